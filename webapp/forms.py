"""Requests as values that the model understands, or as messages that a person can act on.

Two doors, one result: the JSON of the API (`read_document`) and what a person typed into the form
(`Typed.read`). Both refuse with every fault at once, each at its field.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Self, cast, get_args

from model.cameras import DISTANCES, HEIGHTS, Camera
from model.measurements import BODY_KINDS, MEASUREMENTS, BodyKind, Measurement, MeasurementSet
from webapp import units
from webapp.units import UNITS, Units

Limits = Mapping[str, tuple[float, float]]
"""What an adult can plausibly measure: name to lowest and highest value, SI."""

FORM = tuple(name for name, row in MEASUREMENTS.items() if row.in_wizard)
"""The measurements that a person can type, in the table's order."""

BODY_MEMBERS = ("body", "units", "measurements", "fit")
FILE_MEMBERS = (*BODY_MEMBERS, "morph_targets")
PICTURE_MEMBERS = (*BODY_MEMBERS, "silhouette", "camera", "facing")
COMPARISON_MEMBERS = PICTURE_MEMBERS

Fit = Literal["tape", "linear"]
FITS: tuple[Fit, Fit] = get_args(Fit)
"""Bent until it measures what was asked, or the linear estimate as it is; the first by default."""

CAMERA_LIMITS = {"distance": DISTANCES, "height": HEIGHTS}
"""Where a camera may stand, in metres."""

ROUNDING = 1e-9
"""Metres or kilograms by which a limit may seem to be passed: 82 cm is 0.8200000000000001 m."""

TYPED_LENGTH = 20
"""Characters kept of an answer: room for ``5 feet 6 1/2 inches``, and the cookie stays small."""

_LOOKS_LIKE = {
    "cm": {"m": "metres", "in": "inches", "mm": "millimetres", "ft": "feet"},
    "in": {"cm": "centimetres", "ft": "feet", "m": "metres", "mm": "millimetres"},
    "kg": {"lb": "pounds", "st": "stones"},
    "lb": {"kg": "kilograms", "st": "stones"},
}
"""For a value beyond the limits: the other units it may be in, the most likely first."""


@dataclass(frozen=True, slots=True)
class AvatarRequest:
    """A body to make, and how to draw it."""

    body: BodyKind
    units: Units
    asked: MeasurementSet
    fit: Fit = "tape"
    morph_targets: bool = False
    silhouette: bool = False
    camera: Camera = field(default_factory=Camera)
    facing: Literal["right", "left"] = "right"


@dataclass(frozen=True, slots=True)
class Refusal:
    """One fault: where it is (as ``measurements.bust_girth``), a code, and words for people."""

    field: str
    code: str
    message: str


class Refused(ValueError):
    """A request that cannot be met, with all its faults."""

    def __init__(self, faults: Sequence[Refusal]) -> None:
        super().__init__("; ".join(f"{fault.field}: {fault.message}" for fault in faults))
        self.faults = tuple(faults)


@dataclass(frozen=True, slots=True)
class Typed:
    """The form exactly as a person left it, sensible or not."""

    body: str = ""
    units: Units = "metric"
    answers: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> Self:
        """From the posted form, or from what `fields` gave the session earlier."""
        answers = {name: _printable(str(fields.get(name) or "")) for name in FORM}
        body, chosen = fields.get("body"), fields.get("units")
        return cls(
            body=body if body in BODY_KINDS else "",
            units=chosen if chosen in UNITS else "metric",
            answers={name: answer for name, answer in answers.items() if answer},
        )

    def fields(self) -> dict[str, str]:
        """What the session keeps."""
        return {"body": self.body, "units": self.units, **self.answers}

    def in_units(self, new: Units) -> Self:
        """The same answers written in other units."""
        answers = {
            name: units.convert(
                answer, MEASUREMENTS[name].unit, self.units, new, feet=name == "stature"
            )
            for name, answer in self.answers.items()
        }
        return replace(self, units=new, answers=answers)

    def read(self, limits: Mapping[BodyKind, Limits]) -> AvatarRequest:
        """The request that the answers make.

        Raises
        ------
        Refused
            With a message for every answer that cannot be used.
        """
        faults = []
        if not self.body:
            faults.append(Refusal("body", "required", "Choose one of the three."))
        allowed = limits[cast(BodyKind, self.body or "neutral")]
        values = {}
        for name, answer in self.answers.items():
            measurement = MEASUREMENTS[name]
            try:
                value = units.parse(answer, measurement.unit, self.units)
            except ValueError:
                message = _unreadable(measurement, self.units)
                faults.append(Refusal(name, "not_a_number", message))
                continue
            values[name] = value
            faults += _beyond(measurement, value, self.units, allowed[name], name)
        if "stature" not in self.answers:
            message = "Enter your height: it is the one measurement we cannot do without."
            faults.append(Refusal("stature", "required", message))
        if faults:
            raise Refused(faults)
        return AvatarRequest(cast(BodyKind, self.body), self.units, MeasurementSet(values))


def read_document(
    document: object, members: Sequence[str], limits: Mapping[BodyKind, Limits]
) -> AvatarRequest:
    """The request that a JSON document makes; `members` are the names it may hold.

    Raises
    ------
    Refused
        With every fault of the document.
    """
    if not isinstance(document, dict):
        raise Refused([Refusal("", "not_an_object", "The request must be a JSON object.")])
    faults = [
        Refusal(str(name), "unknown_member", f"Not known here. Allowed: {', '.join(members)}.")
        for name in document
        if name not in members
    ]
    body = _choice(document, "body", BODY_KINDS, None, faults)
    chosen = cast(Units, _choice(document, "units", UNITS, "metric", faults))
    fit = cast(Fit, _choice(document, "fit", FITS, FITS[0], faults))
    facing = _choice(document, "facing", ("right", "left"), "right", faults)
    silhouette = _flag(document, "silhouette", faults)
    morph_targets = _flag(document, "morph_targets", faults)
    camera = _camera(document.get("camera", {}), faults)
    asked = _asked(document, chosen, limits.get(cast(BodyKind, body)), faults)
    if faults:
        raise Refused(faults)
    return AvatarRequest(
        body=cast(BodyKind, body),
        units=chosen,
        asked=MeasurementSet(asked),
        fit=fit,
        morph_targets=morph_targets,
        silhouette=silhouette,
        camera=camera,
        facing=cast(Literal["right", "left"], facing),
    )


def _asked(
    document: Mapping[str, object], chosen: Units, allowed: Limits | None, faults: list[Refusal]
) -> dict[str, float]:
    """The document's measurements in SI; faults are added to `faults`."""
    given = document.get("measurements")
    if not isinstance(given, dict):
        message = "An object of measurements is needed, with at least stature."
        code = "required" if given is None else "not_an_object"
        faults.append(Refusal("measurements", code, message))
        return {}
    if "stature" not in given:
        message = "Stature is needed: it is the one measurement that cannot be left out."
        faults.append(Refusal("measurements.stature", "required", message))
    asked = {}
    for name, number in given.items():
        field = f"measurements.{name}"
        if name not in MEASUREMENTS:
            message = "No measurement has this name. GET /api/v1/measurements lists them."
            faults.append(Refusal(field, "unknown_measurement", message))
        elif (value := _number(number)) is None:
            faults.append(Refusal(field, "not_a_number", "A finite number is needed."))
        else:
            measurement = MEASUREMENTS[name]
            asked[name] = units.to_si(value, measurement.unit, chosen)
            if allowed is not None:
                faults += _beyond(measurement, asked[name], chosen, allowed[name], field)
    return asked


def _beyond(
    measurement: Measurement, value: float, chosen: Units, limits: tuple[float, float], field: str
) -> list[Refusal]:
    """A refusal if the value is beyond the limits: as another unit's if it fits that one."""
    low, high = limits
    if low - ROUNDING <= value <= high + ROUNDING:
        return []
    symbol = units.SYMBOLS[measurement.unit][chosen]
    number = units.from_si(value, measurement.unit, chosen)
    for other, words in _LOOKS_LIKE[symbol].items():
        meant = number * units.SI_PER[measurement.unit][other]
        if low <= meant <= high:
            shown = units.write(units.from_si(meant, measurement.unit, chosen), 1)
            message = f"That looks like {words}. Did you mean {shown} {symbol}?"
            return [Refusal(field, "out_of_range", message)]
    least, most = units.range_in(low, high, measurement.unit, chosen)
    message = (
        f"We can work with {units.write(least, 1)} to {units.write(most, 1)} {symbol} here. "
        "Please check the number and its unit."
    )
    return [Refusal(field, "out_of_range", message)]


def _printable(text: str) -> str:
    """What was typed, without signs that no page can show, and not too long for the cookie."""
    shown = "".join(sign if sign.isprintable() else " " for sign in text)
    return shown.strip()[:TYPED_LENGTH].strip()


def _unreadable(measurement: Measurement, chosen: Units) -> str:
    """Words for what is no number, with ways to write one: no one's number in particular."""
    if chosen == "metric":
        ways = "57.5 or 57,5"
    elif measurement.name == "stature":
        ways = "5 ft 6, 5'6\" or 66"
    elif measurement.unit == "kg":
        ways = "140 or 140.5"
    else:
        ways = "22.5 or 22 1/2"
    return f"We could not read this as a number. Write it like {ways}."


def _camera(given: object, faults: list[Refusal]) -> Camera:
    """The document's camera; faults are added to `faults`."""
    if not isinstance(given, dict):
        message = 'A camera is an object, such as {"distance": 3.0, "height": 0.9}.'
        faults.append(Refusal("camera", "not_an_object", message))
        return Camera()
    placed = {}
    for name, number in given.items():
        field = f"camera.{name}"
        if name not in CAMERA_LIMITS:
            message = "Not known here. Allowed: distance, height."
            faults.append(Refusal(field, "unknown_member", message))
            continue
        low, high = CAMERA_LIMITS[name]
        value = _number(number)
        if value is None:
            faults.append(Refusal(field, "not_a_number", "A finite number is needed."))
        elif not low <= value <= high:
            message = f"Between {low:g} and {high:g} metres, please."
            faults.append(Refusal(field, "out_of_range", message))
        else:
            placed[name] = value
    return Camera(**placed)


def _choice(
    document: Mapping[str, object],
    name: str,
    choices: Sequence[str],
    default: str | None,
    faults: list[Refusal],
) -> str:
    """One of some words; a fault is added to `faults`."""
    value = document.get(name, default)
    if isinstance(value, str) and value in choices:
        return value
    code = "required" if name not in document else "invalid_choice"
    faults.append(Refusal(name, code, f"One of {', '.join(choices)} is needed."))
    return default or ""


def _flag(document: Mapping[str, object], name: str, faults: list[Refusal]) -> bool:
    """True or false; a fault is added to `faults`."""
    value = document.get(name, False)
    if isinstance(value, bool):
        return value
    faults.append(Refusal(name, "invalid_choice", "Either true or false is needed."))
    return False


def _number(given: object) -> float | None:
    """A finite number, or None; true and false are no numbers."""
    if isinstance(given, bool) or not isinstance(given, int | float):
        return None
    try:
        number = float(given)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None
