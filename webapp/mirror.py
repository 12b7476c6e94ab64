"""What the avatar's page asks for while it is open: the numbers of its body, and other values.

Both speak of the measurements in the session, so that none stands in an address. The answers are
those of the interface for programs, in the page's language.
"""

import json
from dataclasses import replace
from typing import Any

from flask import Blueprint, Response, abort, jsonify, request, session
from flask_babel import gettext as _

from model.measurements import MEASUREMENTS
from webapp import checks, refined, table_words
from webapp.answers import LEG, Typed
from webapp.api import document
from webapp.avatars import Avatar, limits, make_avatar, rows, shown
from webapp.forms import Refusal, Refused
from webapp.kept import remember

bp = Blueprint("mirror", __name__)


@bp.get("/avatar.json")
def numbers() -> Response:
    """The body's measurements, as the API answers them, with the path of each tape."""
    return jsonify(_told(shown(), _typed()))


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
    answer = jsonify(_told(make_avatar(typed.read(limits())), typed))
    refined.leave()
    remember(typed)
    return answer


def _told(avatar: Avatar, typed: Typed) -> dict[str, Any]:
    """An avatar as the API answers it, for its page: its words are those of the page."""
    answer = document(avatar)
    for row in answer["measurements"]:
        row["label"] = table_words.body_label(row["name"])
    return answer | {"warnings": _warnings(avatar, typed)}


def _warnings(avatar: Avatar, typed: Typed) -> list[dict[str, str]]:
    """What a shopper may want to look at again: what the body has not, and what seems unusual."""
    chosen = avatar.wanted.units
    if LEG in avatar.wanted.asked:  # as the page has it, wherever it was measured to
        ours = checks.number(avatar.wanted.asked[LEG], LEG, chosen, 2)
        typed = replace(typed.with_texts(LEG, [ours]), leg_to="ankle", kept=typed.kept)
    words = {
        name: question.message
        for name, question in checks.questions(typed, avatar.estimator).items()
    }
    doubted = bool(words)
    for row in rows(avatar):
        if row.unmet and row.name not in words:
            value = checks.with_unit(row.taken, row.name, chosen)
            # Where one number is doubted, the others may well be right.
            words[row.name] = (
                _("On the body: %(value)s.", value=value)
                if doubted
                else _(
                    "This does not seem to go together with your other numbers: on the body it is "
                    "%(value)s.",
                    value=value,
                )
            )
    return [{"measurement": name, "message": message} for name, message in words.items()]


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
