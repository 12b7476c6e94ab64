"""The table of the 41 body measurements, and one person's values for them.

SI units: metres and kilograms. Names and definitions follow the paper *Estimating Body
Shapes From Body Measurements* (its tables 1 to 3, section 4.1 and table 4), to which
weight is added: every shopper knows it. The survey column is the one of ANSUR II
(Gordon et al. 2014, NATICK/TR-15/007; definitions: Hotzman et al. 2011, NATICK/TR-11/017)
that comes nearest, with the difference noted; so is the nearest term of ISO 8559-1:2017.
"""

import csv
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Literal, cast, get_args

BodyKind = Literal["female", "male", "neutral"]
BODY_KINDS: tuple[BodyKind, ...] = get_args(BodyKind)

Kind = Literal["height", "girth", "length", "mass"]


@dataclass(frozen=True, slots=True)
class Measurement:
    """One row of the table.

    Attributes
    ----------
    name : the name used in code, files and the API.
    label : what a shopper reads.
    kind : height (vertical), girth (taut tape), length (over the skin) or mass.
    definition : from where to where, for engineers.
    how_to : how a shopper takes it, in one or two sentences.
    helper_needed : whether it takes a second pair of hands.
    in_wizard : the kinds of body whose wizard asks for it.
    source : where the definition comes from.
    ansur2 : the nearest column of the ANSUR II survey, empty where there is none.
    ansur2_note : how that column differs, in a few words; ``a less b`` where the survey has
        the measurement only as the difference of two columns.
    ansur2_definition : what the survey measured, and how ours differs, in sentences.
    iso8559 : the nearest term of ISO 8559-1:2017, with its clause where that is known for
        certain; empty where there is none.
    iso8559_note : how that measurement differs, in sentences.
    """

    name: str
    label: str
    kind: Kind
    definition: str
    how_to: str
    helper_needed: bool
    in_wizard: frozenset[BodyKind]
    source: str
    ansur2: str
    ansur2_note: str
    ansur2_definition: str
    iso8559: str
    iso8559_note: str

    @property
    def unit(self) -> Literal["m", "kg"]:
        """The SI unit: kilograms for a mass, metres for all others."""
        return "kg" if self.kind == "mass" else "m"

    @property
    def survey_columns(self) -> tuple[str, ...]:
        """The column of ANSUR II; or two of them, the second to be taken from the first."""
        if self.ansur2:
            return (self.ansur2,)
        columns = tuple(self.ansur2_note.split(" less "))
        return columns if len(columns) == 2 else ()


def _read_table() -> dict[str, Measurement]:
    path = Path(__file__).parent / "data" / "measurements.csv"
    with path.open(encoding="utf-8", newline="") as file:
        rows = [
            Measurement(
                name=row["name"],
                label=row["label"],
                kind=cast(Kind, row["kind"]),
                definition=row["definition"],
                how_to=row["how_to"],
                helper_needed=row["helper_needed"] == "yes",
                in_wizard=frozenset(cast(list[BodyKind], row["in_wizard"].split())),
                source=row["source"],
                ansur2=row["ansur2"],
                ansur2_note=row["ansur2_note"],
                ansur2_definition=row["ansur2_definition"],
                iso8559=row["iso8559"],
                iso8559_note=row["iso8559_note"],
            )
            for row in csv.DictReader(file)
        ]
    return {row.name: row for row in rows}


MEASUREMENTS: Mapping[str, Measurement] = MappingProxyType(_read_table())
"""All measurements by name, in the table's order."""


class MeasurementSet(Mapping[str, float]):
    """One person's values, name to SI value; frozen, in the table's order.

    Raises
    ------
    ValueError
        For a name that the table does not have, or a value that is not a positive
        finite number.
    """

    __slots__ = ("_values",)

    def __init__(self, values: Mapping[str, float]) -> None:
        unknown = [name for name in values if name not in MEASUREMENTS]
        if unknown:
            raise ValueError(f"no measurement is called {unknown[0]!r}")
        for name, value in values.items():
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"{name} must be positive and finite, not {value!r}")
        self._values = {name: float(values[name]) for name in MEASUREMENTS if name in values}

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __hash__(self) -> int:
        return hash(tuple(self._values.items()))

    def __repr__(self) -> str:
        return f"MeasurementSet({self._values!r})"
