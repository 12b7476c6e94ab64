"""Centimetres, inches, feet and inches, kilograms, pounds and stones, to and from SI.

A quantity is told by its SI unit, as in the table of measurements: ``"m"`` or ``"kg"``.
Factors are exact by definition: the international yard and pound agreement of 1959
(1 in = 0.0254 m, 1 lb = 0.45359237 kg).
"""

import math
import re
import unicodedata
from decimal import ROUND_HALF_UP, Decimal
from typing import Literal, get_args

Units = Literal["metric", "imperial"]
Quantity = Literal["m", "kg"]
UNITS: tuple[Units, ...] = get_args(Units)

SYMBOLS: dict[Quantity, dict[Units, str]] = {
    "m": {"metric": "cm", "imperial": "in"},
    "kg": {"metric": "kg", "imperial": "lb"},
}
"""The unit of each quantity on a page and in the API."""

SI_PER: dict[Quantity, dict[str, float]] = {
    "m": {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254, "ft": 0.3048},
    "kg": {"kg": 1.0, "lb": 0.45359237, "st": 6.35029318},
}

DECIMALS = {"cm": 1, "in": 2, "kg": 1, "lb": 1}
"""Of a number that comes from other units: as fine as a tape or a scale, at least."""

_SPELLINGS = {
    "millimetre": "mm", "millimeter": "mm", "centimetre": "cm", "centimeter": "cm",
    "metre": "m", "meter": "m", '"': "in", "inch": "in", "inche": "in", "'": "ft", "foot": "ft",
    "feet": "ft", "kilo": "kg", "kilogram": "kg", "pound": "lb", "stone": "st",
}  # fmt: skip
_SECOND_PART = {"ft": "in", "m": "cm", "st": "lb"}
"""The unit of the second number in ``5 ft 6``, ``1 m 68`` and ``11 st 4``."""

_AMOUNT = r"(?:(\d+(?:[.,]\d*)?|[.,]\d+)(?![\d/]))?(?:\s*[- ]?\s*(\d+)\s*/\s*(\d+))?"
_UNIT = r"""\s*([a-z]+|["'])?\.?\s*"""
_TYPED = re.compile(rf"\s*{_AMOUNT}{_UNIT}(?:(?:,|and)?\s*{_AMOUNT}{_UNIT})?")


def symbols(units: Units) -> dict[Quantity, str]:
    """The unit of each quantity on a page."""
    return {quantity: choices[units] for quantity, choices in SYMBOLS.items()}


def to_si(value: float, quantity: Quantity, units: Units) -> float:
    """A value in the page's unit, in metres or kilograms."""
    return value * SI_PER[quantity][SYMBOLS[quantity][units]]


def from_si(value: float, quantity: Quantity, units: Units) -> float:
    """A value in metres or kilograms, in the page's unit."""
    return value / SI_PER[quantity][SYMBOLS[quantity][units]]


def parse(text: str, quantity: Quantity, units: Units) -> float:
    """What a person typed, in metres or kilograms.

    A number without a unit is in the page's unit. Decimal point or comma, fractions, units written
    out and two-part values are understood: ``92,5``, ``36 1/4``, ``5'6"``, ``5 ft 6``, ``1.68 m``,
    ``11 st 4``.

    Raises
    ------
    ValueError
        If the text is no number, or names a unit of another quantity.
    """
    match = _TYPED.fullmatch(_plain(text))
    if match is None:
        raise ValueError(f"{text!r} is not a number")
    first, unit, second, second_unit = (
        _amount(*match.group(1, 2, 3)),
        _symbol(match[4]),
        _amount(*match.group(5, 6, 7)),
        _symbol(match[8]),
    )
    factors = SI_PER[quantity]
    if first is None or (second is None and second_unit):
        raise ValueError(f"{text!r} is not a number")
    if second is None:
        unit = unit or SYMBOLS[quantity][units]
        if unit not in factors:
            raise ValueError(f"{unit!r} is not a unit of {quantity}")
        return first * factors[unit]
    smaller = _SECOND_PART.get(unit, "")
    if unit not in factors or smaller not in factors or second_unit not in ("", smaller):
        raise ValueError(f"{text!r} is not a number")
    return first * factors[unit] + second * factors[smaller]


def convert(text: str, quantity: Quantity, old: Units, new: Units, *, feet: bool = False) -> str:
    """What was typed, written in other units; what is no number stays as it is.

    The result is the shortest decimal, not coarser than `DECIMALS`, that is the value typed to the
    digits typed. So tenths and eighths come back as they were: 168 cm is 66.14 in, which is 168 cm.
    With `feet`, feet and inches.
    """
    if old == new:
        return text
    try:
        value = parse(text, quantity, old)
    except ValueError:
        return text
    typed = from_si(value, quantity, old)
    coarsest = DECIMALS[SYMBOLS[quantity][old]]
    digits = max(coarsest, len(write(typed, 3).partition(".")[2]))
    exact = from_si(value, quantity, new)
    for places in range(DECIMALS[SYMBOLS[quantity][new]], 4):
        shortest = round(exact, places)
        back = from_si(to_si(shortest, quantity, new), quantity, old)
        if abs(back - typed) <= 0.5 * 10.0**-digits + 1e-9:
            break
    return write(shortest, 3, feet=feet and new == "imperial" and quantity == "m")


def write(value: float, places: int, *, feet: bool = False) -> str:
    """A number to at most `places` decimals, no idle zeros; `feet`: inches as ``5 ft 6 in``."""
    if feet:
        whole, inches = divmod(round(value, places), 12)
        return f"{whole:.0f} ft {write(inches, places)} in"
    text = f"{value:.{places}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def show(
    value: float,
    quantity: Quantity,
    units: Units,
    *,
    feet: bool = False,
    entered: bool = False,
    places: int = 1,
) -> str:
    """A value in metres or kilograms as it stands in a table.

    feet : inches as ``5′ 6.1″``
    entered : as fine as tapes are read, so that a quarter of an inch stays one: ``15.25``
    """
    if entered and SYMBOLS[quantity][units] == "in":
        places = 2
    # As browsers round what the interface for programs answers: scripts write the same numbers.
    answered = Decimal(round(from_si(value, quantity, units), 3))
    number = answered.quantize(Decimal(1).scaleb(-places), ROUND_HALF_UP)
    if feet and units == "imperial":
        return f"{number // 12}′ {number % 12}″"
    return str(number)


def show_signed(value: float, quantity: Quantity, units: Units, places: int = 1) -> str:
    """A difference with its sign: ``+0.4``, ``−1.2`` (with a true minus), ``0.0``."""
    text = f"{from_si(value, quantity, units):+.{places}f}"
    return text.lstrip("+-") if float(text) == 0 else text.replace("-", "\N{MINUS SIGN}")


def range_in(
    low: float, high: float, quantity: Quantity, units: Units, places: int = 1
) -> tuple[float, float]:
    """Limits in the page's unit, rounded inwards, so that a limit as it is told is allowed."""
    scale = 10**places
    return (
        math.ceil(from_si(low, quantity, units) * scale - 1e-6) / scale,
        math.floor(from_si(high, quantity, units) * scale + 1e-6) / scale,
    )


def _plain(text: str) -> str:
    """Lower case, plain quotes and digits, vulgar fractions written out."""
    spaced = "".join(
        f" {sign}" if unicodedata.decomposition(sign).startswith("<fraction>") else sign
        for sign in text
    )
    plain = unicodedata.normalize("NFKC", spaced).lower().replace("\N{FRACTION SLASH}", "/")
    plain = re.sub("[\u2018\u2019\u2032`\u00b4]", "'", plain)
    plain = re.sub("[\u201c\u201d\u2033]", '"', plain)
    return plain.replace("''", '"')


def _amount(number: str | None, numerator: str | None, denominator: str | None) -> float | None:
    """``36``, ``1``, ``4`` as 36.25; None where nothing was typed."""
    if number is None and numerator is None:
        return None
    fraction = 0.0
    if numerator is not None and denominator is not None:
        if int(denominator) == 0:
            raise ValueError("a fraction of zero parts")
        fraction = int(numerator) / int(denominator)
    return float((number or "0").replace(",", ".")) + fraction


def _symbol(spelling: str | None) -> str:
    """``inches`` as ``in``; what is not known stays as it is, and "" where nothing was typed."""
    if not spelling:
        return ""
    singular = spelling.removesuffix("s")
    return _SPELLINGS.get(singular, singular)
