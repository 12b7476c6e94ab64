"""What a person typed, kept exactly so, and what it comes to.

One measurement may have up to three readings, and the inside leg a place that it was measured to.
What is kept fits the signed session cookie.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Self, cast, get_args

from flask_babel import gettext as _

from model.measurements import BODY_KINDS, MEASUREMENTS, BodyKind, Measurement, MeasurementSet
from model.plausibility import TROUSERS_SHORT_OF_FLOOR
from webapp import readings, units
from webapp.forms import AvatarRequest, Limits, Refusal, Refused, beyond
from webapp.language import decimal
from webapp.units import UNITS, Units

LEG = "inseam_height"

LegEnd = Literal["floor", "ankle", "trousers"]
LEG_ENDS: tuple[LegEnd, ...] = get_args(LegEnd)
"""Where people measure an inside leg to."""

ANKLE_SHARE: Mapping[str, float] = {"female": 0.0391, "male": 0.0413, "neutral": 0.0402}
"""The ankle's height as a share of stature, in the survey (ANSUR II, lateral malleolus): the people
of one sex deviate from it by 4 to 5 mm."""

TYPICAL_STATURE: Mapping[str, float] = {"female": 1.63, "male": 1.756, "neutral": 1.69}
"""Metres: the survey's mean, for those who did not say theirs."""

HEM_NOISE = 0.02
"""Metres: trousers are cut longer and shorter than `TROUSERS_SHORT_OF_FLOOR` says."""

TYPED_LENGTH = 20
"""Characters kept of an answer: room for ``5 feet 6 1/2 inches``, and the cookie stays small."""

_LABEL = re.compile(r"\s*(?:w\s*)?\d{2}\s*(?:[/x×,-]|\s)?\s*l?\s*(\d{2}(?:[.,]5)?)\s*", re.I)
"""The length in what stands on trousers: ``32/34``, ``W32 L34``."""


@dataclass(frozen=True, slots=True)
class Typed:
    """A person's answers exactly as they left them, sensible or not.

    body : a kind of body, or "" where none was chosen
    answers : the first reading of each measurement
    again : further readings
    leg_to : where the inside leg was measured to; "" where that was not said
    kept : measurements whose value a person looked at again and kept
    """

    body: str = ""
    units: Units = "metric"
    answers: Mapping[str, str] = field(default_factory=dict)
    again: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    leg_to: str = ""
    kept: frozenset[str] = frozenset()

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> Self:
        """From a posted form, or from what `fields` gave the session earlier."""
        answers, again = {}, {}
        for name in MEASUREMENTS:
            places = [name, *(f"{name}:{number}" for number in range(2, readings.MOST + 1))]
            texts = [_printable(str(fields.get(place) or "")) for place in places]
            typed = [text for text in texts if text]
            if typed:
                answers[name] = typed[0]
                if typed[1:]:
                    again[name] = tuple(typed[1:])
        body, chosen, leg_to = (fields.get(key) for key in ("body", "units", f"{LEG}:to"))
        kept = str(fields.get("kept") or "").split()
        return cls(
            body=body if body in BODY_KINDS else "",
            units=chosen if chosen in UNITS else "metric",
            answers=answers,
            again=again,
            leg_to=leg_to if leg_to in LEG_ENDS else "",
            kept=frozenset(name for name in kept if name in answers),
        )

    def fields(self) -> dict[str, str]:
        """What the session keeps."""
        fields = {"body": self.body, "units": self.units, **self.answers}
        for name, texts in self.again.items():
            fields |= {f"{name}:{number}": text for number, text in enumerate(texts, 2)}
        if self.leg_to:
            fields[f"{LEG}:to"] = self.leg_to
        if self.kept:
            fields["kept"] = " ".join(sorted(self.kept))
        return fields

    def texts(self, name: str) -> tuple[str, ...]:
        """All readings of a measurement as they were typed; none where there is none."""
        if name not in self.answers:
            return ()
        return (self.answers[name], *self.again.get(name, ()))

    def with_texts(self, name: str, texts: Sequence[str]) -> Self:
        """The same with other readings of one measurement; what changes is no longer kept."""
        typed = [text for text in map(_printable, texts) if text][: readings.MOST]
        if tuple(typed) == self.texts(name):
            return self
        answers = {other: text for other, text in self.answers.items() if other != name}
        again = {other: rest for other, rest in self.again.items() if other != name}
        if typed:
            answers[name] = typed[0]
            if typed[1:]:
                again[name] = tuple(typed[1:])
        return replace(self, answers=answers, again=again, kept=self.kept - {name})

    def with_body(self, body: str) -> Self:
        """The same for another kind of body; "" changes nothing."""
        return replace(self, body=body) if body else self

    def written_in(self, chosen: Units, leg_to: str) -> Self:
        """The same, to take answers typed in these units; and where an inside leg ends, if said."""
        converted = self if chosen == self.units else self.in_units(chosen)
        return replace(converted, leg_to=leg_to) if leg_to else converted

    def keeping(self, name: str) -> Self:
        """The same, with one value looked at again and kept."""
        return replace(self, kept=self.kept | {name})

    def in_units(self, new: Units) -> Self:
        """The same answers written in other units."""

        def written(name: str, text: str) -> str:
            if name == LEG and self.leg_to == "trousers":
                return text
            quantity = MEASUREMENTS[name].unit
            converted = units.convert(text, quantity, self.units, new, feet=name == "stature")
            return text if converted == text else decimal(converted)

        return replace(
            self,
            units=new,
            answers={name: written(name, text) for name, text in self.answers.items()},
            again={
                name: tuple(written(name, text) for text in texts)
                for name, texts in self.again.items()
            },
        )

    def shortest(self) -> Self:
        """The same with every answer as short as it can be written, and without unreadable ones."""

        def short(name: str, text: str) -> str:
            try:
                value = self.value(name, text)
            except ValueError:
                return ""
            quantity = MEASUREMENTS[name].unit
            chosen: Units = "imperial" if self._printed(name) else self.units
            return units.write(units.from_si(value, quantity, chosen), 2)

        shortened = self
        for name in self.answers:
            shortened = shortened.with_texts(name, [short(name, text) for text in self.texts(name)])
        return shortened

    def once(self) -> Self:
        """The same with the first reading of each measurement alone."""
        return replace(self, again={})

    @property
    def kind(self) -> BodyKind:
        """The kind of body, for what is known of all kinds before one was chosen."""
        return cast(BodyKind, self.body or "neutral")

    def value(self, name: str, text: str) -> float:
        """A reading in metres or kilograms, as it was taken.

        Raises
        ------
        ValueError
            If the text is no number.
        """
        if not self._printed(name):
            return units.parse(text, MEASUREMENTS[name].unit, self.units)
        if label := _LABEL.fullmatch(text):
            text = label[1]
        text = re.sub(r"^\s*l\s*", "", text, flags=re.I)
        value = units.parse(text, "m", "imperial")
        # Where trousers are sold by the centimetre, their number is beyond any in inches.
        return value if value < 1.27 else units.parse(text, "m", "metric")

    def values(self, name: str) -> list[float]:
        """All readings of a measurement that can be read, as they were taken, SI."""
        found = []
        for text in self.texts(name):
            try:
                found.append(self.value(name, text))
            except ValueError:
                continue
        return found

    def leg_offset(self) -> float:
        """What an inside leg as it was taken is longer than our inseam, in metres."""
        if self.leg_to in ("", "ankle"):
            return 0.0
        ankle = self.values("foot_height")
        if ankle:
            height = readings.middle(ankle)
        else:
            stature = self.values("stature")
            tall = readings.middle(stature) if stature else TYPICAL_STATURE[self.kind]
            height = ANKLE_SHARE[self.kind] * tall
        return height - (TROUSERS_SHORT_OF_FLOOR if self.leg_to == "trousers" else 0.0)

    def offset(self, name: str) -> float:
        """What a measurement as it was taken is longer than ours of that name, in metres."""
        return self.leg_offset() if name == LEG else 0.0

    def faults(self, name: str, allowed: tuple[float, float]) -> list[Refusal]:
        """What cannot be used of one measurement's readings; `allowed` are its limits, SI."""
        measurement = MEASUREMENTS[name]
        offset = self.offset(name)
        ends = (allowed[0] + offset, allowed[1] + offset)
        shown: Units = "imperial" if self._printed(name) else self.units
        found = []
        for number, text in enumerate(self.texts(name), 1):
            place = name if number == 1 else f"{name}:{number}"
            try:
                value = self.value(name, text)
            except ValueError:
                message = _unreadable(measurement, shown)
                found.append(Refusal(place, "not_a_number", message))
            else:
                found += beyond(measurement, value, shown, ends, place)
        if name == LEG and self.texts(name) and not self.leg_to:
            message = _("Say where your number ends, so that we read it rightly.")
            found.append(Refusal(f"{LEG}:to", "required", message))
        return found

    def read(self, limits: Mapping[BodyKind, Limits]) -> AvatarRequest:
        """The request that the answers make.

        Raises
        ------
        Refused
            With a message for every answer that cannot be used.
        """
        faults = []
        if not self.body:
            faults.append(Refusal("body", "required", _("Choose one of the three.")))
        allowed = limits[self.kind]
        for name in self.answers:
            faults += self.faults(name, allowed[name])
        if "stature" not in self.answers:
            message = _("Enter your height: it is the one measurement we cannot do without.")
            faults.append(Refusal("stature", "required", message))
        if faults:
            raise Refused(faults)
        asked, noise = self.known()
        return AvatarRequest(self.kind, self.units, asked, noise=noise)

    def known(self) -> tuple[MeasurementSet, dict[str, float]]:
        """What is readable, as our measurements, and how sure what was read twice is; SI."""
        taken = {name: values for name in self.answers if (values := self.values(name))}
        asked = {
            name: readings.middle(values) - self.offset(name) for name, values in taken.items()
        }
        noise = readings.noise(taken)
        if LEG in asked and self.leg_to == "trousers":
            noise[LEG] = HEM_NOISE
        return MeasurementSet({name: value for name, value in asked.items() if value > 0}), noise

    def _printed(self, name: str) -> bool:
        """Whether this is the number that is printed on trousers."""
        return name == LEG and self.leg_to == "trousers"


def _printable(text: str) -> str:
    """What was typed, without signs that no page can show, and not too long for the cookie."""
    shown = "".join(sign if sign.isprintable() else " " for sign in text)
    return shown.strip()[:TYPED_LENGTH].strip()


def _unreadable(measurement: Measurement, chosen: Units) -> str:
    """Words for what is no number, with ways to write one: no one's number in particular."""
    if chosen == "metric":
        ways = _("57.5 or 57,5")
    elif measurement.name == "stature":
        ways = _("5 ft 6, 5'6\" or 66")
    elif measurement.unit == "kg":
        ways = _("140 or 140.5")
    else:
        ways = _("22.5 or 22 1/2")
    return _("We could not read this as a number. Write it like %(ways)s.", ways=ways)
