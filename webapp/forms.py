"""Requests as values that the model understands, or as messages that a person can act on.

Two doors, one result: the JSON of the API (`read_document`) and what a person typed
(`webapp.answers.Typed`). Both refuse with every fault at once, each at its field.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, cast, get_args

from flask_babel import gettext as _
from flask_babel import lazy_gettext as _l

from model.cameras import DISTANCES, HEIGHTS, Camera
from model.measurements import BODY_KINDS, MEASUREMENTS, BodyKind, Measurement, MeasurementSet
from model.refinement import WORN, Worn
from webapp import units
from webapp.language import decimal
from webapp.units import UNITS, Units

Limits = Mapping[str, tuple[float, float]]
"""What an adult can plausibly measure: name to lowest and highest value, SI."""

BODY_MEMBERS = ("body", "units", "measurements", "fit")
FILE_MEMBERS = (*BODY_MEMBERS, "morph_targets")
PICTURE_MEMBERS = (*BODY_MEMBERS, "silhouette", "camera", "facing")
COMPARISON_MEMBERS = (*PICTURE_MEMBERS, "refine", "worn")

Fit = Literal["tape", "linear"]
FITS: tuple[Fit, Fit] = get_args(Fit)
"""Bent until it measures what was asked, or the linear estimate as it is; the first by default."""

CAMERA_LIMITS = {"distance": DISTANCES, "height": HEIGHTS}
"""Where a camera may stand, in metres."""

ROUNDING = 1e-9
"""Metres or kilograms by which a limit may seem to be passed: 82 cm is 0.8200000000000001 m."""

_UNIT_WORDS = {
    "m": _l("metres"),
    "cm": _l("centimetres"),
    "mm": _l("millimetres"),
    "in": _l("inches"),
    "ft": _l("feet"),
    "kg": _l("kilograms"),
    "lb": _l("pounds"),
    "st": _l("stones"),
}

_LOOKS_LIKE = {
    "cm": ("m", "in", "mm", "ft"),
    "in": ("cm", "ft", "m", "mm"),
    "kg": ("lb", "st"),
    "lb": ("kg", "st"),
}
"""For a value beyond the limits: the other units it may be in, the most likely first."""


@dataclass(frozen=True, slots=True)
class AvatarRequest:
    """A body to make, and how to draw it.

    noise : the deviation of what was read more than once, SI, by name
    camera, told : where the camera stood, and which of its members were told; the others are usual
    worn : what the person of the photos wears; None where not told
    refined : what an outline made of the body, see `webapp.refined`; "" where none had a say
    """

    body: BodyKind
    units: Units
    asked: MeasurementSet
    fit: Fit = "tape"
    morph_targets: bool = False
    noise: Mapping[str, float] = field(default_factory=dict)
    refine: bool = False
    worn: Worn | None = None
    silhouette: bool = False
    camera: Camera = field(default_factory=Camera)
    told: frozenset[str] = frozenset()
    facing: Literal["right", "left"] = "right"
    refined: str = ""


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
    refine = _flag(document, "refine", faults)
    worn = _choice(document, "worn", WORN, None, faults) if "worn" in document else None
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
        refine=refine,
        worn=cast(Worn | None, worn),
        silhouette=silhouette,
        camera=camera,
        told=frozenset(document.get("camera", {})),
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
                faults += beyond(measurement, asked[name], chosen, allowed[name], field)
    return asked


def beyond(
    measurement: Measurement, value: float, chosen: Units, limits: tuple[float, float], field: str
) -> list[Refusal]:
    """A refusal if the value is beyond the limits: as another unit's if it fits that one."""
    low, high = limits
    if low - ROUNDING <= value <= high + ROUNDING:
        return []
    symbol = units.SYMBOLS[measurement.unit][chosen]
    if (unit := other_unit(measurement, value, chosen, limits)) is not None:
        words, meant = unit
        message = _(
            "That looks like %(unit)s. Did you mean %(value)s %(symbol)s?",
            unit=words,
            value=decimal(units.write(units.from_si(meant, measurement.unit, chosen), 1)),
            symbol=symbol,
        )
        return [Refusal(field, "out_of_range", message)]
    least, most = units.range_in(low, high, measurement.unit, chosen)
    message = _(
        "We can work with %(least)s to %(most)s %(symbol)s here. "
        "Please check the number and its unit.",
        least=decimal(units.write(least, 1)),
        most=decimal(units.write(most, 1)),
        symbol=symbol,
    )
    return [Refusal(field, "out_of_range", message)]


def other_unit(
    measurement: Measurement, value: float, chosen: Units, limits: tuple[float, float]
) -> tuple[str, float] | None:
    """The unit in which a number beyond the limits is within them, in words, and that value, SI."""
    number = units.from_si(value, measurement.unit, chosen)
    for other in _LOOKS_LIKE[units.SYMBOLS[measurement.unit][chosen]]:
        meant = number * units.SI_PER[measurement.unit][other]
        if limits[0] <= meant <= limits[1]:
            return str(_UNIT_WORDS[other]), meant
    return None


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
