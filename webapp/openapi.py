"""The API's description in OpenAPI 3.1, made of the same tables that requests are checked with."""

from typing import Any

from model.comparison import LEVELS
from model.masks import LEAST_HEIGHT, MOST_ACROSS, MOST_BYTES, MOST_PIXELS
from model.measurements import BODY_KINDS, MEASUREMENTS
from webapp.comparisons import SIDES
from webapp.forms import CAMERA_LIMITS, FITS
from webapp.units import SYMBOLS, UNITS

Schema = dict[str, Any]

VERSION = "1.0.0"

WARNINGS = {
    "not_met": "the body has another value, see `fit`.",
    "unusual": "far from what the other values lead to expect.",
    "contradicts": "it and those in `conflicts` are seldom one person's.",
    "unit_mix_up": "far likelier in another unit, see `suggestion`.",
    "neighbouring_definition": "far likelier as another measurement, such as an inseam to the "
    "floor; `suggestion` is what was asked for.",
}
"""The codes of warnings, and what they say of an entered value."""


def document() -> Schema:
    """The whole description."""
    health = _object({"status": {"const": "ok"}})
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "The Fitting Room",
            "version": VERSION,
            "description": "A body from tape measurements: what it measures, as a glTF file and "
            "as pictures. Nothing that is sent is kept.",
            "license": {"name": "Apache-2.0", "identifier": "Apache-2.0"},
        },
        "paths": {
            "/healthz": {
                "get": {
                    "operationId": "health",
                    "summary": "Answers once the estimators are loaded.",
                    "responses": {"200": _answer("It serves.", "application/json", health)},
                }
            },
            "/api/v1/measurements": {"get": _measurements()},
            "/api/v1/avatars": {
                "post": _avatar_operation(
                    "makeAvatar",
                    "A body's measurements, each as asked and as taken.",
                    "AvatarRequest",
                    _answer("The measurements.", "application/json", _ref("Avatar")),
                )
            },
            "/api/v1/avatars.glb": {
                "post": _avatar_operation(
                    "makeAvatarFile",
                    "A body as a glTF 2.0 file: metres, +Y up, facing +Z, soles at Y = 0.",
                    "AvatarFileRequest",
                    _answer("The file.", "model/gltf-binary", {}),
                )
            },
            **{
                f"/api/v1/avatars/{side}.png": {
                    "post": _avatar_operation(
                        f"draw{side.title()}",
                        f"A body as a picture, {words}.",
                        "PictureRequest",
                        _answer("The picture.", "image/png", {}),
                        {"503": _problem("This server cannot draw pictures.")},
                    )
                }
                for side, words in (("front", "seen from the front"), ("profile", "from the side"))
            },
            "/api/v1/comparisons": {"post": _comparison_operation()},
            "/api/v1/openapi.json": {
                "get": _operation(
                    "describe",
                    "This description.",
                    _answer("OpenAPI 3.1.", "application/json", {"type": "object"}),
                )
            },
        },
        "components": {"schemas": _schemas()},
    }


def _schemas() -> dict[str, Schema]:
    positive = {"type": "number", "exclusiveMinimum": 0}
    number: Schema = {"type": "number"}
    text: Schema = {"type": "string"}
    kinds = sorted({row.kind for row in MEASUREMENTS.values()})
    symbols = [symbol for choices in SYMBOLS.values() for symbol in choices.values()]
    row = {
        "name": {"enum": list(MEASUREMENTS)},
        "label": text,
        "kind": {"enum": kinds},
        "unit": {"enum": list(dict.fromkeys(symbols))},
    }
    asked: Schema = {
        "body": {"enum": list(BODY_KINDS), "description": "The population to estimate from."},
        "units": {
            "enum": list(UNITS),
            "default": "metric",
            "description": "Metric: cm and kg. Imperial: in and lb. For the answer too.",
        },
        "measurements": {
            **_object(dict.fromkeys(MEASUREMENTS, positive), required=["stature"]),
            "description": "Any of these, at least stature, within the ranges that "
            "/api/v1/measurements gives for the body; other values are refused with 422.",
        },
        "fit": {
            "enum": list(FITS),
            "default": FITS[0],
            "description": "Tape: the body is bent, within what people look like, until it "
            "measures what was entered to within 1 mm and 0.1 kg. Values that no such body has "
            "together are missed by as little as it can, and each that is missed is warned of as "
            "`not_met`. Linear: the estimate as learned, which need not measure what was entered.",
        },
    }
    camera = {
        name: {"type": "number", "minimum": low, "maximum": high, "description": "Metres."}
        for name, (low, high) in CAMERA_LIMITS.items()
    }
    drawn = {
        "silhouette": {
            "type": "boolean",
            "default": False,
            "description": "The filled outline, white on black.",
        },
        "camera": _object(camera, required=[]),
        "facing": {
            "enum": ["right", "left"],
            "default": "right",
            "description": "In profile: the side of the picture that the person faces.",
        },
    }
    morphs = {
        "morph_targets": {
            "type": "boolean",
            "default": False,
            "description": "Whether the mesh carries a morph target for each entered measurement: "
            "how the linear estimate changes with it. `mesh.extras.targetNames` names them; "
            "`mesh.extras` says what weight shows what value, and what all measurements become.",
        }
    }
    needed = ["body", "measurements"]
    return {
        "AvatarRequest": _object(asked, required=needed),
        "AvatarFileRequest": _object(asked | morphs, required=needed),
        "PictureRequest": _object(asked | drawn, required=needed),
        "ComparisonRequest": _object(
            asked
            | drawn
            | {
                "refine": {
                    "type": "boolean",
                    "default": False,
                    "description": "Whether to answer, beside the comparison, what the body would "
                    "be if the outlines had a say in what the entered values leave open: "
                    "`refinement`. Entered values hold as before.",
                }
            },
            required=needed,
        ),
        "Comparison": {
            **_object(
                {side: _ref("ComparedView") for side in SIDES} | {"refinement": _ref("Refinement")},
                required=[],
            ),
            "minProperties": 1,
        },
        "Refinement": _object(
            {
                "pull": {
                    "type": "number",
                    "minimum": 0,
                    "maximum": 1,
                    "description": "How much the outlines were trusted: 1 as usual; a half, a "
                    "quarter or less where more would have made a body that nobody has, or lost "
                    "an entered value; 0 where they were given up and nothing changed.",
                },
                "moved_cm": _object(
                    {
                        "mean": {"type": "number", "description": "Of all points of the skin."},
                        "most": {"type": "number", "description": "Of any point."},
                    }
                ),
                "cloth_cm": {
                    "type": "number",
                    "description": "How far the outlines lie outside the body all over: what was "
                    "taken for cloth. Below zero where they lie inside.",
                },
                "unexplained": {
                    "type": "number",
                    "minimum": 0,
                    "maximum": 1,
                    "description": "The share of the outlines' edges that no likely body has, and "
                    "that therefore count for little: loose clothes, hands, another stance.",
                },
                "measurements": {
                    "type": "array",
                    "items": _object(
                        {
                            "name": row["name"],
                            "unit": row["unit"],
                            "before": number,
                            "after": number,
                        }
                    ),
                    "minItems": len(MEASUREMENTS),
                    "maxItems": len(MEASUREMENTS),
                },
                **{side: _ref("ComparedView") for side in SIDES},
            },
            required=["pull", "moved_cm", "cloth_cm", "unexplained", "measurements"],
        ),
        "ComparedView": _object(
            {
                "iou": {
                    "type": "number",
                    "minimum": 0,
                    "maximum": 1,
                    "description": "What both outlines have in common, as a share of what either "
                    "has. Arms are left out: the avatar's, the photo's where they stand off the "
                    "trunk, and whatever lies beside the trunk where they do not.",
                },
                "mean_outline_distance_cm": {
                    "type": "number",
                    "minimum": 0,
                    "description": "How far the judged outlines are from one another.",
                },
                "levels": {
                    "type": "array",
                    "items": _ref("Level"),
                    "description": "From the top down. A level that an arm hides, or at which "
                    "legs do not stand apart, is left out.",
                },
                "overlay_png": {
                    "type": "string",
                    "pattern": "^data:image/png;base64,",
                    "description": "The avatar, filled, with the photo's outline over it.",
                },
            }
        ),
        "Level": _object(
            {
                "measurement": {
                    "enum": list(dict.fromkeys(name for side in SIDES for name in LEVELS[side])),
                    "description": "The girth at whose height it is.",
                },
                "photo_cm": {
                    **positive,
                    "description": "Breadth (front) or depth (profile) there, as seen on the "
                    "upright plane through the body's axis; of legs from the front, one's. In "
                    "centimetres, whatever the units.",
                },
                "avatar_cm": positive,
            }
        ),
        "Measurement": _object(
            {
                **row,
                "definition": text,
                "how_to": text,
                "helper_needed": {"type": "boolean"},
                "range": _object({kind: _ref("Range") for kind in BODY_KINDS}),
                "in_wizard": _object({kind: {"type": "boolean"} for kind in BODY_KINDS}),
            }
        ),
        "Range": {
            "description": "Lowest and highest value that is accepted.",
            **_list_of(number, 2),
        },
        "Avatar": _object(
            {
                "body": asked["body"],
                "units": asked["units"],
                "measurements": {
                    "type": "array",
                    "items": _ref("TakenMeasurement"),
                    "minItems": len(MEASUREMENTS),
                    "maxItems": len(MEASUREMENTS),
                },
                "warnings": {"type": "array", "items": _ref("Warning")},
                "estimator": _object({"version": text, "trained_on": text}),
            }
        ),
        "TakenMeasurement": _object(
            {
                **row,
                "asked": {"type": ["number", "null"], "description": "null where not entered."},
                "taken": {**number, "description": "Measured on the returned body."},
                "low": {
                    **number,
                    "description": "With high: 80 % range of the person's value. Of an entered "
                    "value that the body has, both are as taken; of another, they are the two.",
                },
                "high": number,
                "path": {
                    "type": "array",
                    "items": _list_of(number, 3),
                    "description": "Where the tape ran, in the body's coordinates, metres. "
                    "A girth's path is a closed loop.",
                },
            }
        ),
        "Warning": _object(
            {
                "measurement": {"enum": list(MEASUREMENTS)},
                "code": {
                    "enum": list(WARNINGS),
                    "description": " ".join(f"`{code}`: {says}" for code, says in WARNINGS.items()),
                },
                "message": text,
                "expected": {
                    "description": "Where four of five people's values lie who share the other "
                    "entered values.",
                    **_list_of(number, 2),
                },
                "suggestion": {**number, "description": "The value that was probably meant."},
                "conflicts": {
                    "type": "array",
                    "items": {"enum": list(MEASUREMENTS)},
                    "description": "The entered values that speak against this one, the "
                    "strongest first.",
                },
            },
            required=["measurement", "code", "message", "expected"],
        ),
        "Problem": _object(
            {
                "type": text,
                "title": text,
                "status": {"type": "integer"},
                "detail": text,
                "errors": {"type": "array", "items": _ref("Fault")},
            }
        ),
        "Fault": _object({"field": text, "code": text, "message": text}),
    }


def _measurements() -> Schema:
    operation = _operation(
        "listMeasurements",
        "The table of measurements, with the values that are accepted for each kind of body.",
        _answer(
            "All measurements.",
            "application/json",
            {"type": "array", "items": _ref("Measurement")},
        ),
        {"422": _problem("Unknown units.")},
    )
    operation["parameters"] = [
        {
            "name": "units",
            "in": "query",
            "required": False,
            "schema": {"enum": list(UNITS), "default": "metric"},
        }
    ]
    return operation


def _avatar_operation(
    name: str, summary: str, request: str, answer: Schema, others: Schema | None = None
) -> Schema:
    refusals = {
        "400": _problem("The body is not JSON."),
        "413": _problem("The body is too large."),
        "415": _problem("The content type is not application/json."),
        "422": _problem(
            "Values that cannot be; `errors` names each. Values that are each within their "
            "range but that no body has together are `contradictory`, at `measurements`."
        ),
    }
    operation = _operation(name, summary, answer, refusals | (others or {}))
    operation["requestBody"] = {
        "required": True,
        "content": {"application/json": {"schema": _ref(request)}},
    }
    return operation


def _comparison_operation() -> Schema:
    picture = {
        "type": "string",
        "contentMediaType": "image/png",
        "description": "An outline of one person standing upright, whole, light on dark or with "
        f"an alpha channel: PNG or JPEG, up to {MOST_BYTES} bytes, {MOST_PIXELS} pixels and "
        f"{MOST_ACROSS} along a side, the person {LEAST_HEIGHT} pixels high at least.",
    }
    operation = _operation(
        "compare",
        "Outlines of a person, front, profile or both, beside the avatar as the photo's camera "
        "sees it. In profile the person may face either side. No picture is kept.",
        _answer("Each view that was sent.", "application/json", _ref("Comparison")),
        {
            "400": _problem("The part avatar is not JSON, or the body is broken."),
            "413": _problem("A picture (`too_large`) or the whole body is too large."),
            "415": _problem(
                "The content type is not multipart/form-data, or a picture is none of the allowed "
                "kinds: `wrong_type`, `animated`, `unreadable`."
            ),
            "422": _problem(
                "Values that cannot be, as for an avatar; or a picture that is no outline of one "
                "standing person: `no_person`, `cut_off`, `several_people`, `too_small`."
            ),
        },
    )
    operation["requestBody"] = {
        "required": True,
        "content": {
            "multipart/form-data": {
                "schema": _object(
                    {"avatar": _ref("ComparisonRequest"), **dict.fromkeys(SIDES, picture)},
                    required=["avatar"],
                ),
                "encoding": {
                    "avatar": {"contentType": "application/json"},
                    **{side: {"contentType": "image/png, image/jpeg"} for side in SIDES},
                },
            }
        },
    }
    return operation


def _operation(name: str, summary: str, answer: Schema, others: Schema | None = None) -> Schema:
    return {
        "operationId": name,
        "summary": summary,
        "responses": {
            "200": answer,
            **(others or {}),
            "429": _problem("Too many requests; Retry-After says when to come again."),
        },
    }


def _answer(words: str, media_type: str, schema: Schema) -> Schema:
    return {"description": words, "content": {media_type: {"schema": schema}}}


def _problem(words: str) -> Schema:
    return _answer(words, "application/problem+json", _ref("Problem"))


def _ref(name: str) -> Schema:
    return {"$ref": f"#/components/schemas/{name}"}


def _object(properties: dict[str, Any], required: list[str] | None = None) -> Schema:
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties) if required is None else required,
        "additionalProperties": False,
    }


def _list_of(items: Schema, count: int) -> Schema:
    return {"type": "array", "items": items, "minItems": count, "maxItems": count}
