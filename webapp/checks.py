"""What the wizard says about a number: questions in kind words, and what leaving it out costs.

Nothing here is a wall: a person may keep any value within the limits.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from flask_babel import gettext as _

from model.estimators import Estimator
from model.law import TAPE_NOISE
from model.measurements import MEASUREMENTS
from model.plausibility import Doubt, doubts, expected, next_measurements
from webapp import readings, table_words, units
from webapp.answers import LEG, Typed
from webapp.forms import Limits, other_unit
from webapp.language import decimal
from webapp.units import Units

LEG_MEANT: Mapping[str, str] = {"inside_leg_height": "floor", "trousers_inseam": "trousers"}
"""What a doubted inseam may have been taken to."""


@dataclass(frozen=True, slots=True)
class Question:
    """Something to look at again.

    message : in words for the person
    use : what to type instead, which was probably meant; "" where there is no guess
    use_words : the same with its unit
    move : the measurement that it probably is instead; "" where there is no guess
    leg_to : where an inside leg was probably measured to; "" where there is no guess
    """

    message: str
    use: str = ""
    use_words: str = ""
    move: str = ""
    leg_to: str = ""


@dataclass(frozen=True, slots=True)
class Best:
    """The measurement that would help most, and how near the others are known before and after.

    before : a number, in the person's units
    after : the same with its unit
    """

    name: str
    before: str
    after: str


def number(value: float, name: str, chosen: Units, places: int = 1) -> str:
    """A value in SI as a person would type it, without its unit."""
    quantity = MEASUREMENTS[name].unit
    feet = name == "stature" and chosen == "imperial"
    return decimal(units.write(units.from_si(value, quantity, chosen), places, feet=feet))


def with_unit(value: float, name: str, chosen: Units, places: int = 1) -> str:
    """A value in SI with its unit."""
    text = number(value, name, chosen, places)
    if name == "stature" and chosen == "imperial":
        return text
    return f"{text} {units.SYMBOLS[MEASUREMENTS[name].unit][chosen]}"


def beyond_limits(name: str, typed: Typed, limits: Limits) -> Question | None:
    """What was probably meant by a first reading that is beyond the limits, if there is a guess."""
    values = typed.values(name)
    if not values or (name == LEG and typed.leg_to == "trousers"):
        return None
    offset = typed.offset(name)
    low, high = (end + offset for end in limits[name])
    if low <= values[0] <= high:
        return None
    meant = other_unit(MEASUREMENTS[name], values[0], typed.units, (low, high))
    if meant is None:
        return None
    return Question(
        "",
        use=number(meant[1], name, typed.units),
        use_words=with_unit(meant[1], name, typed.units),
    )


def questions(typed: Typed, estimator: Estimator) -> dict[str, Question]:
    """The values that may want another look, and that were not looked at again and kept."""
    asked, noise = typed.known()
    found = doubts(estimator, asked, noise={**TAPE_NOISE, **noise})
    return {
        doubt.measurement: _question(doubt, typed)
        for doubt in found
        if doubt.measurement not in typed.kept
    }


def _question(doubt: Doubt, typed: Typed) -> Question:
    name, chosen = doubt.measurement, typed.units
    offset = typed.offset(name)
    low, high = (number(end + offset, name, chosen, 0) for end in doubt.expected)
    usual = _(
        "Beside your other numbers this one seems unusual: %(low)s to %(high)s would be usual.",
        low=low,
        high=high
        if name == "stature" and chosen == "imperial"
        else with_unit(doubt.expected[1] + offset, name, chosen, 0),
    )
    if doubt.code == "unit_mix_up" and doubt.suggestion is not None:
        value = doubt.suggestion + offset
        words = with_unit(value, name, chosen)
        message = _("%(usual)s Did you mean %(value)s?", usual=usual, value=words)
        return Question(message, use=number(value, name, chosen), use_words=words)
    if doubt.meant in MEASUREMENTS:
        message = _(
            "%(usual)s It would go well as: %(label)s.",
            usual=usual,
            label=table_words.label(str(doubt.meant)),
        )
        move = str(doubt.meant) if str(doubt.meant) not in typed.answers else ""
        return Question(message, move=move)
    if doubt.meant in LEG_MEANT:
        leg_to = LEG_MEANT[str(doubt.meant)]
        if leg_to == "floor":
            message = _("This looks like a length down to the floor, not to the ankle bone.")
        else:
            message = _("This looks like the number of trousers, not a length to the ankle bone.")
        return Question(message, leg_to=leg_to)
    against = [table_words.label(other) for other in doubt.conflicts[:2]]
    more = _("It goes least with: %(labels)s.", labels=", ".join(against)) if against else ""
    again = _("Please read the tape once more; if it says the same, keep it.")
    return Question(" ".join(part for part in (usual, more, again) if part))


def sits_well(name: str, typed: Typed) -> str:
    """Words for a number that goes well with the others; "" where there are no others."""
    if not typed.values(name) or not any(other != name for other in typed.answers):
        return ""
    return _("Fits the others.")


def estimate(name: str, typed: Typed, estimator: Estimator) -> str:
    """What we will take a measurement for that is left out, and how near that is."""
    asked, noise = typed.known()
    seen = expected(estimator, asked, name, noise={**TAPE_NOISE, **noise})
    offset = 0.0
    if name == LEG:
        offset = replace(typed, leg_to=typed.leg_to or "floor").leg_offset()
    half = units.from_si((seen.high - seen.low) / 2, MEASUREMENTS[name].unit, typed.units)
    places = 0 if half >= 1.5 else 1
    return _(
        "%(value)s, give or take %(half)s",
        value=with_unit(seen.middle + offset, name, typed.units, places),
        half=decimal(units.write(max(half, 0.1), places)),
    )


def best_next(typed: Typed, estimator: Estimator) -> list[Best]:
    """The measurement that would narrow the body most, and the best that takes no helper, if that
    is another; none where all are entered.
    """
    asked, _noise = typed.known()
    gains = [
        gain
        for gain in next_measurements(estimator, asked)
        if gain.measurement not in typed.answers and gain.measurement != "stature"
    ]
    alone = [gain for gain in gains if not MEASUREMENTS[gain.measurement].helper_needed]
    best = []
    for gain in dict.fromkeys([*gains[:1], *alone[:1]]):
        before = number(gain.before, LEG, typed.units)
        best.append(Best(gain.measurement, before, with_unit(gain.after, LEG, typed.units)))
    return best


def repeats(typed: Typed) -> str:
    """Words on how well a person's readings repeat; "" where nothing was read twice."""
    taken = {name: typed.values(name) for name in typed.answers}
    if all(len(values) < 2 for values in taken.values()):
        return ""
    factor = readings.own_factor(taken)
    if factor < 0.9:
        return _("Your readings repeat very well: the ranges become narrower for it.")
    if factor > 1.3:
        return _("Your readings differ more than usual: the ranges become wider for it.")
    return _("Your readings repeat as well as those of trained hands.")
