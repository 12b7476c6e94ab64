"""The page where measurements are typed.

What was typed is kept, exactly as typed, in the signed session cookie: nothing is lost by an error,
by going back or by changing units, and the server remembers nobody.
"""

from collections.abc import Sequence

from flask import Blueprint, flash, redirect, render_template, request, session, url_for
from flask_wtf.csrf import CSRFError
from werkzeug.wrappers import Response

from model.measurements import MEASUREMENTS
from webapp import guide
from webapp.avatars import limits
from webapp.forms import Refusal, Refused, Typed
from webapp.units import UNITS, symbols

bp = Blueprint("wizard", __name__)


@bp.get("/")
def form() -> str:
    """The form, with what was typed earlier."""
    return _page(Typed.of(session.get("typed", {})))


@bp.post("/")
def answer() -> Response | tuple[str, int]:
    """Keep what was typed; then other units, messages, or the body."""
    typed = Typed.of(request.form)
    if (chosen := request.form.get("switch_to")) in UNITS:
        session["typed"] = typed.in_units(chosen).fields()
        return redirect(url_for("wizard.form", _anchor="units"), 303)
    session["typed"] = typed.fields()
    try:
        typed.read(limits())
    except Refused as refused:
        return _page(typed, refused.faults), 422
    return redirect(url_for("avatars.page"), 303)


@bp.post("/forget")
def forget() -> Response:
    """Forget everything that was typed: the next person at this screen sees nothing of it."""
    session.clear()
    flash("Your measurements are forgotten.")
    return redirect(url_for("wizard.form"), 303)


@bp.app_errorhandler(CSRFError)
def stale(error: CSRFError) -> tuple[str, int]:
    """A form whose session has ended is shown again, with what was typed into it."""
    message = "This page had been open for long, so we ask you to press the button once more."
    return _page(Typed.of(request.form), notice=message), error.code or 400


def _page(typed: Typed, faults: Sequence[Refusal] = (), notice: str = "") -> str:
    """The form with the person's answers and, at their fields, what could not be used."""
    order = ("body", *guide.FIRST, *guide.REST)
    return render_template(
        "wizard/form.html",
        typed=typed,
        bodies=guide.BODY_WORDS,
        first=[MEASUREMENTS[name] for name in guide.FIRST],
        rest=[MEASUREMENTS[name] for name in guide.REST],
        mistakes=guide.USUAL_MISTAKES,
        symbols=symbols(typed.units),
        labels={"body": "Who it is for"} | {name: row.label for name, row in MEASUREMENTS.items()},
        faults=sorted(faults, key=lambda fault: order.index(fault.field)),
        messages={fault.field: fault.message for fault in faults},
        notice=notice,
    )
