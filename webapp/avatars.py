"""The avatar: its page, its file and its pictures, from the measurements in the session."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from flask import (
    Blueprint,
    Response,
    abort,
    current_app,
    flash,
    redirect,
    render_template,
    request,
    session,
    url_for,
)
from flask_babel import lazy_gettext as _l
from werkzeug.wrappers import Response as AnyResponse

from model import studio
from model.anthropometry import ImpossibleBodyError, Measured, measure
from model.cameras import Side
from model.estimators import Estimator
from model.gltf import to_glb
from model.law import TAPE_NOISE
from model.measurements import MEASUREMENTS, BodyKind, MeasurementSet
from model.morph_targets import morph_targets
from model.rendering import render_png, render_webp
from model.rig import rig_of
from model.studio import RenderingUnavailable
from model.tape_fit import fit_to_tape
from model.template_mesh import Body
from webapp import metrics, refined, table_words, units
from webapp.answers import LEG, Typed
from webapp.forms import AvatarRequest, Limits, Refusal, Refused
from webapp.language import decimal

ESTIMATED: tuple[tuple[Any, tuple[str, ...]], ...] = (
    (_l("Around the body"), ("girth",)),
    (_l("Over the skin"), ("length",)),
    (_l("Heights and weight"), ("height", "mass")),
)
"""The parts of the page's table, and the kinds of measurements in each."""

MET: Mapping[str, float] = {"m": 0.001, "kg": 0.1}
"""An entered value this near to the body's is met, by unit: no tape or scale reads finer."""

BEGIN_HERE = _l("To show your body we need your height first. It takes a minute.")
LOOK_AGAIN = _l("Some of your answers need another look.")
CONTRADICTORY = _l(
    "These measurements contradict each other: no body has all of them. "
    "Please check each number and its unit."
)

NAMED = 3
"""Of the entered values that a body has not, the page's first sentence names so many."""

STEPS: Mapping[units.Quantity, Mapping[units.Units, str]] = {
    "m": {"metric": "0.5", "imperial": "0.25"},
    "kg": {"metric": "0.5", "imperial": "1"},
}
"""What the buttons for more and less change a value by, in the page's unit."""

bp = Blueprint("avatars", __name__)


@dataclass(frozen=True, slots=True)
class Avatar:
    """A body, what was asked of it and what it measures."""

    wanted: AvatarRequest
    estimator: Estimator
    body: Body
    measured: Measured
    ranges: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, slots=True)
class Row:
    """One measurement of an avatar, SI; `asked` is None where it was not entered."""

    name: str
    asked: float | None
    taken: float
    low: float
    high: float

    @property
    def unmet(self) -> bool:
        """Whether this was entered and the body does not have it."""
        return self.asked is not None and not _is_met(self.name, self.asked, self.taken)


@dataclass(frozen=True, slots=True)
class Field:
    """A number to change on the page, as it is written there; its limits and its step, for scripts.

    feet : whether it is in feet and inches, its limits and its step in inches
    """

    name: str
    unit: str
    value: str
    number: str
    low: str
    high: str
    size: str
    feet: bool


def estimators() -> Mapping[BodyKind, Estimator]:
    """The estimators that this process loaded at its start."""
    loaded: Mapping[BodyKind, Estimator] = current_app.extensions["estimators"]
    return loaded


def make_avatar(wanted: AvatarRequest) -> Avatar:
    """Estimate the body that was asked for, fit it to the tape unless told not to, measure it.

    Raises
    ------
    Refused
        Where each value is plausible, but no body can have them all.
    """
    estimator = estimators()[wanted.body]
    try:
        taken_along = refined.unpacked(estimator, wanted.asked, wanted.refined)
        if taken_along is not None:
            body = taken_along
        elif wanted.fit == "tape":
            body = fit_to_tape(estimator, wanted.asked).body
        else:
            body = estimator.estimate(wanted.asked)
        avatar = avatar_of(wanted, estimator, body)
    except ImpossibleBodyError:
        raise Refused([Refusal("measurements", "contradictory", str(CONTRADICTORY))]) from None
    if wanted.fit == "tape":
        metrics.fitted(
            wanted.body,
            (
                abs(value - avatar.measured.values[name])
                for name, value in wanted.asked.items()
                if MEASUREMENTS[name].unit == "m"
            ),
        )
    return avatar


def avatar_of(wanted: AvatarRequest, estimator: Estimator, body: Body) -> Avatar:
    """A body with what it measures.

    Raises
    ------
    ImpossibleBodyError
        For what is no body.
    """
    measured = measure(body)
    noise = {**TAPE_NOISE, **wanted.noise} if wanted.noise else None
    ranges = estimator.ranges(wanted.asked, measured.values, noise=noise)
    return Avatar(wanted, estimator, body, measured, ranges)


def rows(avatar: Avatar) -> list[Row]:
    """What was asked and what the body measures, in the table's order."""
    table = []
    for name, taken in avatar.measured.values.items():
        asked = avatar.wanted.asked.get(name)
        if asked is None:
            low, high = avatar.ranges[name]
        elif _is_met(name, asked, taken):
            low = high = taken
        else:
            low, high = sorted((asked, taken))
        table.append(Row(name, asked, taken, low, high))
    return table


def estimated_groups(every: Sequence[Row]) -> dict[str, list[Row]]:
    """The rows of what was not entered, under the titles of the page's table."""
    return {
        str(title): [
            row for row in every if row.asked is None and MEASUREMENTS[row.name].kind in kinds
        ]
        for title, kinds in ESTIMATED
    }


def glb(avatar: Avatar) -> Response:
    """The avatar as a file to keep; it says which estimator made it, and of what."""
    extras = {
        "body": avatar.wanted.body,
        "estimator": {
            "version": avatar.estimator.version,
            "trained_on": avatar.estimator.trained_on,
        },
        "units": "metres and kilograms",
        "measurements": {
            row.name: {"asked": row.asked, "taken": round(row.taken, 5)} for row in rows(avatar)
        },
    }
    if avatar.wanted.refined:
        extras["refined"] = "by the outline of a photo"
    if avatar.wanted.morph_targets:
        morphs = morph_targets(avatar.estimator, avatar.body, avatar.wanted.asked)
        content = to_glb(avatar.body, extras, measured=avatar.measured.values, morphs=morphs)
    else:
        content = to_glb(avatar.body, extras, rig=rig_of(avatar.body.template))
    response = Response(content, mimetype="model/gltf-binary")
    response.headers.set("Content-Disposition", "attachment", filename="avatar.glb")
    return response


def picture(avatar: Avatar, side: Side) -> Response:
    """The avatar from one side."""
    png = render_png(
        avatar.body,
        side,
        silhouette=avatar.wanted.silhouette,
        camera=avatar.wanted.camera,
        facing=avatar.wanted.facing,
    )
    return Response(png, mimetype="image/png")


def why_no_pictures() -> str:
    """Why this machine cannot draw pictures; "" if the last one that was asked for was drawn.

    Before the first one, and after one that failed, a small one is tried; this warms up too.
    """
    if studio.failure() == "":
        return ""
    neutral = estimators()["neutral"]
    low, high = neutral.limits["stature"]
    body = neutral.estimate(MeasurementSet({"stature": (low + high) / 2}))
    try:
        render_png(body, "front", size=(60, 120))
    except RenderingUnavailable as problem:
        current_app.logger.warning("no pictures: %s", problem)
        return str(problem)
    return ""


@bp.get("/avatar")
def page() -> str | AnyResponse:
    """The body of the measurements in the session."""
    wanted = shown_request()
    if wanted is None:
        begun = bool(session.get("typed"))
        flash(str(LOOK_AGAIN if begun else BEGIN_HERE))
        return redirect(url_for("wizard.review" if begun else "wizard.start"), 303)
    try:
        avatar = make_avatar(wanted)
    except Refused:
        flash(str(CONTRADICTORY))
        return redirect(url_for("wizard.review"), 303)
    every = rows(avatar)
    entered = [row for row in every if row.asked is not None]
    return render_template(
        "avatars/avatar.html",
        units=wanted.units,
        entered=entered,
        unmet=[table_words.body_label(row.name) for row in _farthest(entered)],
        labels=table_words.body_labels(),
        estimated=estimated_groups(every),
        measurements=MEASUREMENTS,
        fields=[_field(row, wanted) for row in entered],
        pictures=not why_no_pictures(),
        refined=bool(wanted.refined),
    )


def _farthest(entered: Sequence[Row]) -> list[Row]:
    """Of the entered values that the body has not, those that are furthest from it."""
    unmet = [row for row in entered if row.unmet]
    return sorted(unmet, key=lambda row: -abs((row.asked or 0) / row.taken - 1))[:NAMED]


def _field(row: Row, wanted: AvatarRequest) -> Field:
    """The field that changes an entered value beside the body."""
    quantity, chosen = MEASUREMENTS[row.name].unit, wanted.units
    low, high = limits()[wanted.body][row.name]
    least, most = units.range_in(low, high, quantity, chosen)
    value = units.from_si(row.asked or row.taken, quantity, chosen)
    feet = row.name == "stature" and chosen == "imperial"
    # An inside leg to the ankle is mostly reckoned, not typed: it is told as the table tells it.
    places = 1 if row.name == LEG else 2
    return Field(
        name=row.name,
        unit="ft, in" if feet else units.SYMBOLS[quantity][chosen],
        value=decimal(units.write(value, places, feet=feet)),
        number=units.write(value, places),
        low=units.write(least, 1),
        high=units.write(most, 1),
        size=STEPS[quantity][chosen],
        feet=feet,
    )


@bp.get("/avatar.glb")
def file() -> Response:
    """The body as a file; with `?live=1`, the one that the page's preview bends."""
    return glb(shown(morph_targets=request.args.get("live") == "1"))


@bp.get("/avatar/<any(front, profile):side>.png")
def side(side: Side) -> Response:
    """The body from one side."""
    return picture(shown(), side)


@bp.get("/avatar/<any(front, profile):side>.webp")
def light_side(side: Side) -> Response:
    """The body from one side, as the page shows it: a tenth of the other's weight."""
    return Response(render_webp(shown().body, side), mimetype="image/webp")


def shown_request() -> AvatarRequest | None:
    """What the session's answers ask for; None where they make no request."""
    try:
        wanted = Typed.of(session.get("typed", {})).read(limits())
    except Refused:
        return None
    return replace(wanted, refined=_taken_along(wanted))


def _taken_along(wanted: AvatarRequest) -> str:
    """What an outline made of this very body, where the shopper took it along."""
    text = refined.kept()
    if text and refined.unpacked(estimators()[wanted.body], wanted.asked, text) is None:
        return ""
    return text


def shown(*, morph_targets: bool = False) -> Avatar:
    """The avatar of the session; without one, there is nothing here."""
    wanted = shown_request() or abort(404)
    try:
        return make_avatar(replace(wanted, morph_targets=morph_targets))
    except Refused:
        abort(404)


def _is_met(name: str, asked: float, taken: float) -> bool:
    """Whether a body has an entered value."""
    return abs(asked - taken) <= MET[MEASUREMENTS[name].unit]


def limits() -> dict[BodyKind, Limits]:
    """What an adult can plausibly measure, for each kind of body."""
    return {kind: estimator.limits for kind, estimator in estimators().items()}
