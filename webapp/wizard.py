"""The wizard: one measurement a page, a review, and one form for those who know their numbers.

Nothing that was typed is lost by an error, by going back or by changing units or language: see
`webapp.kept`.
"""

from collections.abc import Sequence
from typing import Any, Literal

from flask import (
    Blueprint,
    Response,
    abort,
    flash,
    jsonify,
    redirect,
    render_template,
    request,
    session,
    url_for,
)
from flask_babel import gettext as _
from flask_wtf.csrf import CSRFError
from werkzeug.wrappers import Response as AnyResponse

from model.measurements import MEASUREMENTS
from model.tape_pictures import views_of
from webapp import checks, guide, readings, table_words
from webapp.answers import LEG, LEG_ENDS, Typed
from webapp.avatars import estimators, limits
from webapp.forms import Refusal, Refused
from webapp.kept import given, remember, remembered
from webapp.language import speaks
from webapp.units import UNITS, symbols

bp = Blueprint("wizard", __name__)

Page = str | AnyResponse | tuple[str, int]

THEN = ("review", "more")
"""Where a step that was not come to in turn leads back to."""


@bp.get("/")
def start() -> str:
    """Who it is for, and in which units."""
    return _start(remembered())


@bp.post("/")
def begin() -> Page:
    """Keep who it is for; then the first measurement."""
    typed = remembered()
    given = Typed.of(request.form)
    typed = typed.in_units(given.units).with_body(given.body)
    remember(typed)
    if speaks():
        return redirect(url_for("wizard.start"), 303)
    if not typed.body:
        return _start(typed, [Refusal("body", "required", _("Choose one of the three."))]), 422
    return redirect(url_for("wizard.step", name=guide.steps(typed.body)[0]), 303)


@bp.get("/measure/<name>")
def step(name: str) -> Page:
    """One measurement: its words, its picture, its number."""
    if name not in MEASUREMENTS:
        abort(404)
    typed = remembered()
    if not typed.body:
        flash(_("Before you measure: who is it for?"))
        return redirect(url_for("wizard.start"), 303)
    return _step(name, typed)


@bp.post("/measure/<name>")
def measured(name: str) -> Page:
    """Keep one measurement's readings; then what the pressed button says."""
    if name not in MEASUREMENTS:
        abort(404)
    typed = given(name)
    here = url_for("wizard.step", name=name, then=_then() or None)
    if (chosen := request.form.get("switch_to")) in UNITS:
        remember(typed.in_units(chosen))
        return redirect(here, 303)
    if speaks():
        remember(typed)
        return redirect(here, 303)
    if "skip" in request.form:
        remember(typed.with_texts(name, ()))
        return redirect(_beside(name, typed, 1), 303)
    remember(typed)
    if not typed.body:
        return redirect(url_for("wizard.start"), 303)
    if changed := _accepted(name, typed):
        typed, name_now = changed
        remember(typed)
        return redirect(_beside(name, typed, 1) if name_now == name else here, 303)
    faults = _faults(name, typed)
    if faults:
        return _step(name, typed, faults), 422
    values = typed.values(name)
    if readings.differ(name, values) and "enough" not in request.form:
        return redirect(here + "#third", 303)
    elsewhere = request.form.get("place", name)
    if elsewhere != name and elsewhere in dict(guide.PLACES.get(name, ())) and typed.texts(name):
        typed, fault = _moved(name, elsewhere, typed)
        if fault:
            return _step(name, typed, [fault]), 422
        remember(typed)
        return redirect(_beside(name, typed, 1), 303)
    if name in _questions(typed):
        if request.form.get("seen", "") != " ".join(typed.texts(name)):
            return redirect(here + "#check", 303)
        remember(typed.keeping(name))
    return redirect(_beside(name, typed, 1), 303)


@bp.post("/check/<name>")
def check(name: str) -> AnyResponse:
    """What is said about a number while it is typed: nothing of it is kept."""
    if name not in MEASUREMENTS:
        abort(404)
    typed = given(name)
    faults = _faults(name, typed) if typed.texts(name) else []
    said = render_template("wizard/_check.html", **_checked(name, typed, faults))
    return jsonify(faults=[fault.message for fault in faults], said=said)


@bp.get("/measure")
def more() -> Page:
    """All measurements, to choose from."""
    typed = remembered()
    if not typed.body:
        return redirect(url_for("wizard.start"), 303)
    return render_template(
        "wizard/more.html",
        typed=typed,
        groups=guide.GROUPS,
        labels=table_words.labels(),
        words=guide.WORDS,
    )


@bp.get("/review")
def review() -> Page:
    """What was entered, and what would help most."""
    typed = remembered()
    if not typed.body:
        return redirect(url_for("wizard.start"), 303)
    order = guide.steps(typed.body)
    names = [name for name in (*order, *MEASUREMENTS) if name in typed.answers]
    names = list(dict.fromkeys(names))
    estimator = estimators()[typed.kind]
    best = checks.best_next(typed, estimator) if "stature" in typed.answers else []
    return render_template(
        "wizard/review.html",
        typed=typed,
        names=names,
        skipped={
            name: checks.estimate(name, typed, estimator)
            for name in order
            if name not in typed.answers
        },
        questions=_questions(typed),
        best=best,
        pictures={one.name: guide.picture(one.name, typed) for one in best},
        repeats=checks.repeats(typed),
        faults={name: found for name in names if (found := _faults(name, typed))},
        bodies=guide.BODY_WORDS,
        labels=table_words.labels(),
        leg_words=guide.LEG_WORDS,
    )


@bp.get("/numbers")
def form() -> str:
    """One form of what most people know, with what was typed earlier."""
    return _form(remembered())


@bp.post("/numbers")
def answer() -> Page:
    """Keep what was typed; then other units, messages, or the body."""
    given = Typed.of(request.form)
    typed = remembered().with_body(given.body).written_in(given.units, given.leg_to)
    for name in guide.QUICK:
        rest = typed.texts(name)[1:] if typed.texts(name)[:1] == given.texts(name)[:1] else ()
        typed = typed.with_texts(name, (*given.texts(name)[:1], *rest))
    if (chosen := request.form.get("switch_to")) in UNITS:
        remember(typed.in_units(chosen))
        return redirect(url_for("wizard.form", _anchor="units"), 303)
    remember(typed)
    if speaks():
        return redirect(url_for("wizard.form"), 303)
    try:
        typed.read(limits())
    except Refused as refused:
        return _form(typed, refused.faults), 422
    return redirect(url_for("avatars.page"), 303)


@bp.post("/forget")
def forget() -> AnyResponse:
    """Forget everything that was typed: the next person at this screen sees nothing of it."""
    language = session.get("language")
    session.clear()
    if language:
        session["language"] = language
    flash(_("Your measurements are forgotten."))
    return redirect(url_for("wizard.start"), 303)


@bp.app_errorhandler(CSRFError)
def stale(error: CSRFError) -> tuple[str, int] | Response:
    """A form whose session has ended is shown again, with what was typed into it."""
    code = error.code or 400
    notice = _("This page had been open for long, so we ask you to press the button once more.")
    if request.endpoint == "wizard.begin":
        return _start(Typed.of(request.form), notice=notice), code
    if request.endpoint == "wizard.measured":
        name = (request.view_args or {}).get("name", "")
        given = Typed.of(request.form)
        if name in MEASUREMENTS and given.body:
            return _step(name, given, notice=notice), code
        return _start(given, notice=notice), code
    return _form(Typed.of(request.form), notice=notice), code


# ---- what a person typed ------------------------------------------------------------------------


def _faults(name: str, typed: Typed) -> list[Refusal]:
    """What cannot be used of one measurement."""
    faults = typed.faults(name, limits()[typed.kind][name])
    if name == "stature" and not typed.texts(name):
        message = _("Enter your height: it is the one measurement we cannot do without.")
        faults.append(Refusal(name, "required", message))
    return faults


def _accepted(name: str, typed: Typed) -> tuple[Typed, str] | None:
    """The answers after a proposal was accepted, and the measurement that it was accepted for."""
    if "keep" in request.form and typed.texts(name):
        return (typed.keeping(name), name) if not _faults(name, typed) else None
    if use := request.form.get("use"):
        changed = typed.with_texts(name, [use])
        return (changed, name) if not _faults(name, changed) else None
    if (end := request.form.get("leg")) in LEG_ENDS and name == LEG:
        return typed.written_in(typed.units, str(end)), name
    if (there := request.form.get("move", "")) in MEASUREMENTS and there != name:
        changed, fault = _moved(name, there, typed)
        return (changed, there) if fault is None else None
    return None


def _questions(typed: Typed) -> dict[str, checks.Question]:
    """The values that may want another look."""
    return checks.questions(typed, estimators()[typed.kind])


def _checked(name: str, typed: Typed, faults: Sequence[Refusal]) -> dict[str, Any]:
    """What is said about a measurement's number, for its template."""
    if faults:
        question = checks.beyond_limits(name, typed, limits()[typed.kind])
    else:
        question = _questions(typed).get(name)
    return {
        "question": question,
        "fine": "" if faults or question else checks.sits_well(name, typed),
        "texts": typed.texts(name),
        "labels": table_words.labels(),
        "leg_words": guide.LEG_WORDS,
    }


def _moved(name: str, elsewhere: str, typed: Typed) -> tuple[Typed, Refusal | None]:
    """The readings as another measurement's, which they are; unless that has other ones."""
    texts = typed.texts(name)
    there = typed.texts(elsewhere)
    label = table_words.label(elsewhere)
    if there and there != texts:
        message = _(
            "You entered your %(label)s already: %(value)s. Change it there, or leave this empty.",
            label=label,
            value=there[0],
        )
        return typed, Refusal(name, "entered_already", message)
    flash(_("We keep that as: %(label)s.", label=label))
    return typed.with_texts(name, ()).with_texts(elsewhere, texts), None


# ---- where one goes -----------------------------------------------------------------------------


def _then() -> str:
    """Where this step was come to from, if not in turn."""
    then = request.values.get("then", "")
    return then if then in THEN else ""


def _beside(name: str, typed: Typed, step: Literal[1, -1]) -> str:
    """The page after a measurement, or before it."""
    if _then():
        return url_for(f"wizard.{_then()}")
    order = guide.steps(typed.body)
    if name not in order:
        return url_for("wizard.more")
    place = order.index(name) + step
    if place < 0:
        return url_for("wizard.start")
    if place == len(order):
        return url_for("wizard.review")
    return url_for("wizard.step", name=order[place])


# ---- pages --------------------------------------------------------------------------------------


def _start(typed: Typed, faults: Sequence[Refusal] = (), notice: str = "") -> str:
    return render_template(
        "wizard/start.html",
        typed=typed,
        bodies=guide.BODY_WORDS,
        faults=faults,
        messages={fault.field: fault.message for fault in faults},
        labels={"body": _("Who it is for")},
        notice=notice,
    )


def _step(name: str, typed: Typed, faults: Sequence[Refusal] = (), notice: str = "") -> str:
    order = guide.steps(typed.body)
    texts = typed.texts(name)
    values = typed.values(name)
    fields = [name, *(f"{name}:{number}" for number in range(2, readings.MOST + 1))]
    return render_template(
        "wizard/step.html",
        name=name,
        typed=typed,
        texts=[*texts, *[""] * (readings.MOST - len(texts))],
        fields=fields,
        checked=_checked(name, typed, faults),
        price=checks.estimate(name, typed, estimators()[typed.kind]) if name != "stature" else "",
        third=readings.differ(name, values) or len(texts) == readings.MOST,
        differ=readings.differ(name, values),
        row=MEASUREMENTS[name],
        azimuth=views_of(name)[0].azimuth,
        label=table_words.label(name),
        words=guide.WORDS[name],
        how=guide.how(name),
        every_tape=guide.says_tape(name, typed.body),
        wear=guide.wear(name, typed.body),
        tape=guide.tape(name),
        helper=guide.helper(name),
        picture=guide.picture(name, typed),
        leg=LEG_ENDS if name == LEG else (),
        leg_words=guide.LEG_WORDS,
        leg_pictures=guide.leg_pictures(typed) if name == LEG else {},
        places=guide.PLACES.get(name, ()),
        symbols=symbols(typed.units),
        number=order.index(name) + 1 if name in order else 0,
        count=len(order),
        then=_then(),
        back=_beside(name, typed, -1),
        faults=faults,
        messages={fault.field: fault.message for fault in faults},
        labels=table_words.labels(),
        notice=notice,
    )


def _form(typed: Typed, faults: Sequence[Refusal] = (), notice: str = "") -> str:
    order: list[Any] = ["body", *guide.QUICK, *MEASUREMENTS]
    return render_template(
        "wizard/form.html",
        typed=typed,
        bodies=guide.BODY_WORDS,
        names=guide.QUICK,
        others=[table_words.label(name) for name in typed.answers if name not in guide.QUICK],
        rows=MEASUREMENTS,
        words=guide.WORDS,
        leg_words=guide.LEG_WORDS,
        symbols=symbols(typed.units),
        labels={"body": _("Who it is for")} | table_words.labels(),
        faults=sorted(faults, key=lambda fault: order.index(fault.field.partition(":")[0])),
        messages={fault.field: fault.message for fault in faults},
        notice=notice,
    )
