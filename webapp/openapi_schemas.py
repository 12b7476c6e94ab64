"""What goes in and comes out of the API, as JSON Schema: the parts that its description names."""

from typing import Any

from model.cameras import SIDES
from model.comparison import EDGE_LEVELS, LEVELS
from model.measurements import BODY_KINDS, MEASUREMENTS
from model.refinement import WORN
from webapp.comparison_words import REASONS
from webapp.forms import CAMERA_LIMITS, FITS
from webapp.units import SYMBOLS, UNITS

Schema = dict[str, Any]

WARNINGS = {
    "not_met": "the body has another value, see `fit`.",
    "unusual": "far from what the other values lead to expect.",
    "contradicts": "it and those in `conflicts` are seldom one person's.",
    "unit_mix_up": "far likelier in another unit, see `suggestion`.",
    "neighbouring_definition": "far likelier as another measurement, such as an inseam to the "
    "floor; `suggestion` is what was asked for.",
}
"""The codes of warnings, and what they say of an entered value."""


def schemas() -> dict[str, Schema]:
    """All parts, by name."""
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
            **object_of(dict.fromkeys(MEASUREMENTS, positive), required=["stature"]),
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
        "camera": object_of(camera, required=[]),
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
    level_name = {
        "enum": list(dict.fromkeys(name for side in SIDES for name in LEVELS[side])),
        "description": "The girth at whose height it is.",
    }
    needed = ["body", "measurements"]
    return {
        "AvatarRequest": object_of(asked, required=needed),
        "AvatarFileRequest": object_of(asked | morphs, required=needed),
        "PictureRequest": object_of(asked | drawn, required=needed),
        "ComparisonRequest": object_of(
            asked
            | drawn
            | {
                "refine": {
                    "type": "boolean",
                    "default": False,
                    "description": "Whether to answer, beside the comparison, what the body would "
                    "be if the outlines had a say in what the entered values leave open: "
                    "`refinement`. Entered values hold as before.",
                },
                "worn": {
                    "enum": list(WORN),
                    "description": "What the person of the photos wears, for `refine`: `tight`, "
                    "underwear or what fits close everywhere; `loose_top`, from the shoulders to "
                    "below the hips; `loose_legs`, trousers or a skirt; `loose`, both or a dress. "
                    "Where clothes are loose, outlines only say where the body ends at most. Not "
                    "told, that holds where so much cloth is found that it must hang loose.",
                },
            },
            required=needed,
        ),
        "Comparison": {
            **object_of(
                {side: ref("ComparedView") for side in SIDES} | {"refinement": ref("Refinement")},
                required=[],
            ),
            "minProperties": 1,
        },
        "Refinement": object_of(
            {
                "pull": {
                    "type": "number",
                    "minimum": 0,
                    "maximum": 1,
                    "description": "How much the outlines were trusted: 1 as usual; a half, a "
                    "quarter or less where more would have made a body that nobody has, or lost "
                    "an entered value; 0 where they were given up and nothing changed.",
                },
                "moved_cm": object_of(
                    {
                        "mean": {"type": "number", "description": "Of all points of the skin."},
                        "most": {"type": "number", "description": "Of any point."},
                    }
                ),
                "cloth_cm": {
                    "type": "number",
                    "minimum": 0,
                    "description": "How far off the body the outlines were taken for cloth, on "
                    "average from the ankles to the neck.",
                },
                "clothes": {
                    "type": "array",
                    "items": object_of(
                        {
                            "measurement": level_name | {"enum": list(EDGE_LEVELS)},
                            "cloth_cm": {**positive, "description": "On each side of the body."},
                        }
                    ),
                    "description": "From the top down, the levels at which half a centimetre or "
                    "more was taken for cloth, as neither the entered values nor what bodies "
                    "look like explain it. Every girth of trunk and legs but the ankle's, seen "
                    "in a view or not; between bust and neck there is none, so cloth there "
                    "counts in `cloth_cm` alone.",
                },
                "limited": {
                    "type": "array",
                    "items": level_name | {"enum": list(EDGE_LEVELS)},
                    "description": "Where the outlines' pull was limited, of the same levels: "
                    "there they only said where the body ends at most. "
                    "With `worn` told, where clothes are loose by that; without, near where "
                    "cloth was found. Elsewhere some cloth may count as body all the same.",
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
                    "items": object_of(
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
                **{side: ref("ComparedView") for side in SIDES},
            },
            required=[
                "pull",
                "moved_cm",
                "cloth_cm",
                "clothes",
                "limited",
                "unexplained",
                "measurements",
            ],
        ),
        "ComparedView": object_of(
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
                    "items": ref("Level"),
                    "description": "From the top down. A level that an arm hides, or at which "
                    "legs do not stand apart, is left out.",
                },
                "camera": {
                    **object_of(
                        camera
                        | {"estimated": {"type": "array", "items": {"enum": list(CAMERA_LIMITS)}}}
                    ),
                    "description": "From where the avatar is seen: as the request says, and "
                    "otherwise as estimated from the outlines, beside what is usual.",
                },
                "arms": {
                    "enum": ["left_out"],
                    "description": "Arms are not judged: they rarely hang as the avatar's do.",
                },
                "unseen": {
                    "type": "array",
                    "items": {"enum": list(MEASUREMENTS)},
                    "description": "Levels that are not told, because an arm hides them or legs "
                    "do not stand apart.",
                },
                "overlay_png": {
                    "type": "string",
                    "pattern": "^data:image/png;base64,",
                    "description": "The avatar, filled, with the photo's outline over it.",
                },
            }
        ),
        "Level": object_of(
            {
                "measurement": level_name,
                "photo_cm": {
                    **positive,
                    "description": "Breadth (front) or depth (profile) there, as seen on the "
                    "upright plane through the body's axis; of legs from the front, one's. In "
                    "centimetres, whatever the units.",
                },
                "avatar_cm": positive,
                "reasons": {
                    "type": "array",
                    "items": {"enum": [code for code, _, _ in REASONS]},
                    "description": "What usually makes such a difference at such a level, the "
                    "likeliest first; none where it is under a centimetre. `tape` where the "
                    "level's girth was entered, `estimate` where it was not.",
                },
            }
        ),
        "Measurement": object_of(
            {
                **row,
                "definition": text,
                "how_to": text,
                "helper_needed": {"type": "boolean"},
                "range": object_of({kind: ref("Range") for kind in BODY_KINDS}),
                "in_wizard": object_of({kind: {"type": "boolean"} for kind in BODY_KINDS}),
            }
        ),
        "Range": {
            "description": "Lowest and highest value that is accepted.",
            **list_of(number, 2),
        },
        "Avatar": object_of(
            {
                "body": asked["body"],
                "units": asked["units"],
                "measurements": {
                    "type": "array",
                    "items": ref("TakenMeasurement"),
                    "minItems": len(MEASUREMENTS),
                    "maxItems": len(MEASUREMENTS),
                },
                "warnings": {"type": "array", "items": ref("Warning")},
                "estimator": object_of({"version": text, "trained_on": text}),
            }
        ),
        "TakenMeasurement": object_of(
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
                    "items": list_of(number, 3),
                    "description": "Where the tape ran, in the body's coordinates, metres. "
                    "A girth's path is a closed loop.",
                },
            }
        ),
        "Warning": object_of(
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
                    **list_of(number, 2),
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
        "Problem": object_of(
            {
                "type": text,
                "title": text,
                "status": {"type": "integer"},
                "detail": text,
                "errors": {"type": "array", "items": ref("Fault")},
            }
        ),
        "Fault": object_of({"field": text, "code": text, "message": text}),
    }


def ref(name: str) -> Schema:
    """A part, named."""
    return {"$ref": f"#/components/schemas/{name}"}


def object_of(properties: dict[str, Any], required: list[str] | None = None) -> Schema:
    """An object of these properties and no others; all of them required unless told."""
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties) if required is None else required,
        "additionalProperties": False,
    }


def list_of(items: Schema, count: int) -> Schema:
    """A list of so many."""
    return {"type": "array", "items": items, "minItems": count, "maxItems": count}
