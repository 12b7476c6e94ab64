"""What the avatar's page asks for while it is open: the numbers of its body, and other values.

Both speak of the measurements in the session, so that none stands in an address.
"""

import json
from dataclasses import replace

from flask import Blueprint, Response, abort, jsonify, request, session

from model.measurements import MEASUREMENTS
from webapp.answers import LEG, Typed
from webapp.api import document
from webapp.avatars import limits, make_avatar
from webapp.forms import Refusal, Refused

bp = Blueprint("mirror", __name__)


@bp.get("/avatar.json")
def numbers() -> Response:
    """The body's measurements, as the API answers them, with the path of each tape."""
    try:
        avatar = make_avatar(_typed().read(limits()))
    except Refused:
        abort(404)
    return jsonify(document(avatar))


@bp.post("/avatar.json")
def change() -> Response:
    """Take other values for what was typed, and answer the numbers of that body.

    The request holds what is typed now of some measurements, as ``{"waist_girth": "75,5"}``: one
    reading each, of our measurement, so that an inside leg then ends at the ankle.

    Raises
    ------
    Refused
        With every fault, where the answers make no body; the session stays as it was.
    """
    if not request.is_json:
        abort(415, "The request's content type must be application/json.")
    try:
        given = json.loads(request.get_data())
    except (ValueError, RecursionError):
        abort(400, "The request's body is not JSON.")
    typed = _typed()
    for name, text in _answers(given).items():
        typed = typed.with_texts(name, [text])
        if name == LEG:
            typed = replace(typed, leg_to="ankle")
    answer = jsonify(document(make_avatar(typed.read(limits()))))
    session["typed"] = typed.fields()
    return answer


def _typed() -> Typed:
    """What the session holds; without anything, there is nothing here."""
    return Typed.of(session.get("typed") or abort(404))


def _answers(given: object) -> dict[str, str]:
    """What was typed, by measurement; empty answers too."""
    if not isinstance(given, dict):
        raise Refused([Refusal("", "not_an_object", "The request must be a JSON object.")])
    faults = [
        Refusal(name, "unknown_member", "What was typed of a known measurement is needed.")
        for name, answer in given.items()
        if name not in MEASUREMENTS or not isinstance(answer, str)
    ]
    if faults:
        raise Refused(faults)
    return given
