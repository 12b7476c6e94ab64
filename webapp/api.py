"""The HTTP API, version 1: JSON in, JSON, files and pictures out. It sets no cookie."""

import json
from collections.abc import Sequence
from typing import Any

from flask import Blueprint, Response, abort, jsonify, request
from werkzeug.exceptions import HTTPException, UnprocessableEntity, default_exceptions

from model.cameras import SIDES, Side
from model.measurements import BODY_KINDS, MEASUREMENTS
from model.plausibility import Doubt, conflicts, doubts, expected
from webapp import comparisons, openapi, units, uploads
from webapp.avatars import Avatar, glb, limits, make_avatar, picture, rows
from webapp.forms import (
    BODY_MEMBERS,
    COMPARISON_MEMBERS,
    FILE_MEMBERS,
    PICTURE_MEMBERS,
    AvatarRequest,
    Refusal,
    Refused,
    read_document,
)
from webapp.units import UNITS, Units

DECIMALS = 3
"""Of centimetres, inches, kilograms and pounds in answers: finer than any tape."""

bp = Blueprint("api", __name__, url_prefix="/api/v1")


@bp.get("/measurements")
def measurements() -> Response:
    """The table of measurements, with what each kind of body can plausibly measure."""
    chosen = request.args.get("units", "metric")
    if chosen not in UNITS:
        raise Refused([Refusal("units", "invalid_choice", f"One of {', '.join(UNITS)} is needed.")])
    return jsonify(
        [
            {
                "name": name,
                "label": row.label,
                "kind": row.kind,
                "unit": units.SYMBOLS[row.unit][chosen],
                "definition": row.definition,
                "how_to": row.how_to,
                "helper_needed": row.helper_needed,
                "range": {
                    kind: units.range_in(*limits()[kind][name], row.unit, chosen, DECIMALS)
                    for kind in BODY_KINDS
                },
                "in_wizard": {kind: kind in row.in_wizard for kind in BODY_KINDS},
            }
            for name, row in MEASUREMENTS.items()
        ]
    )


@bp.post("/avatars")
def avatar() -> Response:
    """A body's measurements, each as asked and as taken."""
    return jsonify(document(make_avatar(_wanted(BODY_MEMBERS))))


@bp.post("/avatars.glb")
def avatar_file() -> Response:
    """A body as a glTF file."""
    return glb(make_avatar(_wanted(FILE_MEMBERS)))


@bp.post("/avatars/<any(front, profile):side>.png")
def avatar_picture(side: Side) -> Response:
    """A body as a picture."""
    return picture(make_avatar(_wanted(PICTURE_MEMBERS)), side)


@bp.post("/comparisons")
def comparison() -> Response:
    """Outlines of a person beside a body, view by view."""
    if request.mimetype != "multipart/form-data":
        abort(415, "The request's content type must be multipart/form-data.")
    unknown = {*request.form, *request.files} - {"avatar", *SIDES}
    if unknown:
        message = "Not known here. Allowed: avatar, front, profile."
        raise Refused([Refusal(str(name), "unknown_member", message) for name in sorted(unknown)])
    if "avatar" in request.files:
        asked = request.files["avatar"].read()
    elif "avatar" in request.form:
        asked = request.form["avatar"].encode()
    else:
        message = "The part avatar, a JSON object, is needed."
        raise Refused([Refusal("avatar", "required", message)])
    if len(asked) > uploads.MOST_DOCUMENT:
        abort(413)
    wanted = _read(asked, COMPARISON_MEMBERS)
    masks = uploads.masks_sent()
    avatar = make_avatar(wanted)
    views = comparisons.compare_all(avatar, masks, comparisons.camera_of(avatar, masks))
    content: dict[str, Any] = {
        side: comparisons.document(view, wanted) for side, view in views.items()
    }
    if wanted.refine:
        improved = comparisons.improve(avatar, masks, views)
        content["refinement"] = comparisons.refinement(avatar, improved)
    return jsonify(content)


@bp.get("/openapi.json")
def description() -> Response:
    """The API in OpenAPI's words."""
    return jsonify(openapi.document())


def problem(error: HTTPException, faults: Sequence[Refusal] = ()) -> Response:
    """An error as RFC 9457 has it, with the headers that belong to its status."""
    response = error.get_response()
    content = {
        "type": "about:blank",
        "title": error.name,
        "status": error.code,
        "detail": error.description,
        "errors": [
            {"field": fault.field, "code": fault.code, "message": fault.message} for fault in faults
        ],
    }
    return Response(
        json.dumps(content),
        status=error.code,
        headers=[header for header in response.headers if header[0] != "Content-Length"],
        content_type="application/problem+json",
    )


def refused(error: Refused) -> Response:
    """A request that cannot be met, fault by fault."""
    if isinstance(error, uploads.PicturesRefused):
        kind = default_exceptions[error.status]
        return problem(kind("Some pictures cannot be used."), error.faults)
    return problem(UnprocessableEntity("Some values cannot be used."), error.faults)


def _wanted(members: Sequence[str]) -> AvatarRequest:
    """What the request's body asks for."""
    if not request.is_json:
        abort(415, "The request's content type must be application/json.")
    content = request.get_data()
    if request.content_length is None and len(content) == request.max_content_length:
        abort(413)  # A body that comes in chunks is cut at the limit without a word.
    return _read(content, members)


def _read(content: bytes, members: Sequence[str]) -> AvatarRequest:
    """What a JSON document asks for."""
    try:
        # Integers are read as floats too: Python refuses to read very long ones.
        document = json.loads(content, parse_int=float)
    except (ValueError, RecursionError):
        abort(400, "What should be JSON is not.")
    return read_document(document, members, limits())


def document(avatar: Avatar) -> dict[str, Any]:
    """An avatar as the API's answer."""
    chosen = avatar.wanted.units
    return {
        "body": avatar.wanted.body,
        "units": chosen,
        "measurements": [
            {
                "name": row.name,
                "label": MEASUREMENTS[row.name].label,
                "kind": MEASUREMENTS[row.name].kind,
                "unit": units.SYMBOLS[MEASUREMENTS[row.name].unit][chosen],
                "asked": None if row.asked is None else _number(row.name, row.asked, chosen),
                "taken": _number(row.name, row.taken, chosen),
                "low": _number(row.name, row.low, chosen),
                "high": _number(row.name, row.high, chosen),
                "path": avatar.measured.paths[row.name].round(5).tolist(),
            }
            for row in rows(avatar)
        ],
        "warnings": _warnings(avatar),
        "estimator": {
            "version": avatar.estimator.version,
            "trained_on": avatar.estimator.trained_on,
        },
    }


def _warnings(avatar: Avatar) -> list[dict[str, Any]]:
    """What a client may want to look at again.

    Entered values that the fitted body has not, and those that the others speak against.
    """
    chosen = avatar.wanted.units
    estimator, asked = avatar.estimator, avatar.wanted.asked
    warnings = []
    if avatar.wanted.fit == "tape":
        for row in rows(avatar):
            if row.unmet:
                seen = expected(estimator, asked, row.name)
                words = (
                    f"{MEASUREMENTS[row.name].label} does not seem to go with the other values: "
                    f"on the body it is {_shown(row.name, row.taken, chosen)}."
                )
                warning = _warning(row.name, "not_met", words, (seen.low, seen.high), chosen)
                against = conflicts(estimator, asked, row.name)
                warnings.append(warning | ({"conflicts": list(against)} if against else {}))
    for doubt in doubts(estimator, asked):
        name, words = doubt.measurement, _words(doubt, chosen)
        warning = _warning(name, doubt.code, words, doubt.expected, chosen)
        if doubt.suggestion is not None:
            warning["suggestion"] = _number(name, doubt.suggestion, chosen)
        if doubt.conflicts:
            warning["conflicts"] = list(doubt.conflicts)
        warnings.append(warning)
    return warnings


def _warning(
    name: str, code: str, words: str, ends: tuple[float, float], chosen: Units
) -> dict[str, Any]:
    return {
        "measurement": name,
        "code": code,
        "message": words,
        "expected": [_number(name, end, chosen) for end in ends],
    }


MEANT = {
    "inside_leg_height": "it may have been taken to the floor. To the ankle it is then about",
    "trousers_inseam": "it may be the number of trousers. To the ankle it is then about",
}
"""What an entered inseam probably is, in words."""


def _words(doubt: Doubt, chosen: Units) -> str:
    """A doubt for people to read."""
    label = MEASUREMENTS[doubt.measurement].label
    low, high = (_shown(doubt.measurement, end, chosen) for end in doubt.expected)
    usual = f"{low} to {high} would be usual"
    if doubt.suggestion is not None:
        probably = _shown(doubt.measurement, doubt.suggestion, chosen)
        if doubt.meant is None:
            return f"{label} seems to be in another unit: {probably} would go with the others."
        if doubt.meant in MEANT:
            return f"{label} seems unusual: {MEANT[doubt.meant]} {probably}."
        return (
            f"{label} seems unusual: it may be that of {MEASUREMENTS[doubt.meant].label}. "
            f"{label} is then about {probably}."
        )
    if doubt.code == "contradicts" and doubt.conflicts:
        others = " and ".join(MEASUREMENTS[name].label for name in doubt.conflicts)
        return f"{label} does not seem to go with {others}: with the others, {usual}."
    return f"{label} seems unusual beside the other values: {usual}."


def _shown(name: str, value: float, chosen: Units) -> str:
    """A value as people read it."""
    unit = MEASUREMENTS[name].unit
    return f"{units.from_si(value, unit, chosen):.1f} {units.SYMBOLS[unit][chosen]}"


def _number(name: str, value: float, chosen: Units) -> float:
    """A value in the API's unit, to `DECIMALS`."""
    return round(units.from_si(value, MEASUREMENTS[name].unit, chosen), DECIMALS)
