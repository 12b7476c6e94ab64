"""The API's description in OpenAPI 3.1, made of the same tables that requests are checked with."""

from model.cameras import SIDES
from model.masks import LEAST_HEIGHT, MOST_ACROSS, MOST_BYTES, MOST_PIXELS
from webapp.openapi_schemas import Schema, object_of, ref, schemas
from webapp.units import UNITS

VERSION = "1.1.0"

BUSY = "As many wait as may; Retry-After says when to come again."


def document() -> Schema:
    """The whole description."""
    health = object_of({"status": {"const": "ok"}})
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
                    _answer("The measurements.", "application/json", ref("Avatar")),
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
                        {"503": _problem(f"{BUSY} Or this server cannot draw pictures.")},
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
        "components": {"schemas": schemas()},
    }


def _measurements() -> Schema:
    operation = _operation(
        "listMeasurements",
        "The table of measurements, with the values that are accepted for each kind of body.",
        _answer(
            "All measurements.",
            "application/json",
            {"type": "array", "items": ref("Measurement")},
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
        "503": _problem(BUSY),
    }
    operation = _operation(name, summary, answer, refusals | (others or {}))
    operation["requestBody"] = {
        "required": True,
        "content": {"application/json": {"schema": ref(request)}},
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
        _answer("Each view that was sent.", "application/json", ref("Comparison")),
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
            "503": _problem(BUSY),
        },
    )
    operation["requestBody"] = {
        "required": True,
        "content": {
            "multipart/form-data": {
                "schema": object_of(
                    {"avatar": ref("ComparisonRequest"), **dict.fromkeys(SIDES, picture)},
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
    return _answer(words, "application/problem+json", ref("Problem"))
