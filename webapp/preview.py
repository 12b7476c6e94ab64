"""The wizard's view in 3D: a person's own estimated body and one tape on it, while they type.

Sent with what stands in the form just then; nothing of it is kept, and none stands in an address.
"""

from flask import Blueprint, Response, abort, jsonify

from model.measurements import MEASUREMENTS
from webapp import table_words
from webapp.api import document
from webapp.avatars import Avatar, glb, limits, make_avatar
from webapp.forms import Refused
from webapp.kept import given

bp = Blueprint("preview", __name__)


@bp.post("/preview/<name>.glb")
def body(name: str) -> Response:
    """The body, as a file."""
    return glb(_avatar(name))


@bp.post("/preview/<name>.json")
def tape(name: str) -> Response:
    """The row of one measurement, as the API has it: with the path of its tape on that body."""
    avatar = _avatar(name)
    (row,) = [row for row in document(avatar)["measurements"] if row["name"] == name]
    return jsonify(row | {"label": table_words.body_label(name)})


def _avatar(name: str) -> Avatar:
    """The avatar of the answers; those that cannot be are left aside. None without a height."""
    if name not in MEASUREMENTS:
        abort(404)
    typed = given(name)
    allowed = limits()[typed.kind]
    for other in list(typed.answers):
        if typed.faults(other, allowed[other]):
            typed = typed.with_texts(other, ())
    try:
        return make_avatar(typed.read(limits()))
    except Refused:
        abort(404)
