"""What a person's other values say about one: whether it seems unusual, and what may be meant.

A value is doubted where it lies far from what the others lead to expect by the joint law of
people's measurements, all body-mass indices held equally possible: nobody is doubted for being
slight or heavy. Of a doubted value it is asked whether another reading is far likelier: another
unit, or a neighbouring measurement that is easily taken in its place.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Literal

import numpy as np
from scipy.special import ndtri

from model.anthropometry import TAKEN
from model.estimators import RANGE_SHARE, Estimator
from model.geometry import Floats, Integers
from model.law import TAPE_NOISE, Given
from model.measurements import MEASUREMENTS, MeasurementSet

Code = Literal["unusual", "unit_mix_up", "neighbouring_definition", "contradicts"]
Area = Literal["whole", "top", "bottom"]

UNUSUAL = 2.8
"""Standard deviations from the expected value beyond which a value seems unusual: of normal
ones, one in two hundred."""

ELSEWHERE = 2.4
"""The same, where a neighbouring measurement would be expected just there."""

NEAR = 3.0
"""So near to what is expected, in standard deviations, another reading must lie to be what was
probably meant."""

FAR_LIKELIER = float(np.log(20))
"""By so much, in logarithms, another reading must be likelier than the value as it stands."""

_LENGTH_FACTORS = (2.54, 1 / 2.54, 10.0, 0.1, 100.0, 0.01, 30.48, 1 / 30.48, 12.0, 1 / 12)
_MASS_FACTORS = (0.45359237, 1 / 0.45359237, 6.35029318, 1 / 6.35029318, 14.0, 1 / 14)
UNIT_FACTORS: Mapping[str, tuple[float, ...]] = {"m": _LENGTH_FACTORS, "kg": _MASS_FACTORS}
"""By unit: what a value has to be multiplied with if it was told in another unit than was asked
for. Inches, millimetres, metres and feet for centimetres or inches; pounds and stones for
kilograms or pounds; and the other way round."""

NEIGHBOURS: Mapping[str, tuple[str, ...]] = {
    "waist_girth": ("abdomen_girth", "hip_girth"),
    "abdomen_girth": ("waist_girth", "hip_girth"),
    "hip_girth": ("abdomen_girth",),
    "bust_girth": ("underbust_girth",),
    "underbust_girth": ("bust_girth",),
    "thigh_girth": ("mid_thigh_girth",),
    "mid_thigh_girth": ("thigh_girth",),
}
"""Which measurement may have been taken in another's place."""

TROUSERS_SHORT_OF_FLOOR = 0.025
"""Metres that the hem of trousers stays above the floor, by whose inseam shoppers know theirs."""

AREAS: Mapping[Area, tuple[str, ...]] = {
    "whole": tuple(name for name in TAKEN if name not in ("head_girth", "weight")),
    "top": (
        "bust_girth",
        "underbust_girth",
        "waist_girth",
        "neck_girth",
        "upper_arm_girth",
        "lower_arm_girth",
        "wrist_girth",
        "armscye_girth",
        "shoulder_length",
        "neck_to_waist_length",
        "collarbone_to_waist_length",
        "arm_length",
    ),
    "bottom": (
        "waist_girth",
        "abdomen_girth",
        "hip_girth",
        "thigh_girth",
        "mid_thigh_girth",
        "knee_girth",
        "calf_girth",
        "ankle_girth",
        "rise_length",
        "waist_height",
        "inseam_height",
        "foot_height",
    ),
}
"""By garment area: the measurements that a garment there has to fit."""


@dataclass(frozen=True, slots=True)
class Expected:
    """Where four of five people's values lie, SI, and the middle of them."""

    low: float
    middle: float
    high: float


@dataclass(frozen=True, slots=True)
class Doubt:
    """A value that may want another look.

    Attributes
    ----------
    measurement : whose value it is.
    code : ``unusual``, ``contradicts`` (it and others cannot well be one person's),
        ``unit_mix_up`` or ``neighbouring_definition``.
    expected : where four of five people's values lie who share the other values, SI.
    suggestion : the value that was probably meant, SI; None where there is no guess.
    meant : the measurement that was probably taken in its place: its name, or
        ``inside_leg_height`` (to the floor) or ``trousers_inseam``; None otherwise.
    conflicts : the asked measurements that speak against it, the strongest first.
    """

    measurement: str
    code: Code
    expected: tuple[float, float]
    suggestion: float | None = None
    meant: str | None = None
    conflicts: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Gain:
    """How much one more measurement would narrow what is not known of a garment area.

    Attributes
    ----------
    measurement : that would be taken.
    before, after : half of the 80 % range of the area's measurements, the root of the mean
        square over them, metres.
    share : by which the range narrows, 0 to 1.
    """

    measurement: str
    before: float
    after: float
    share: float


def expected(
    estimator: Estimator,
    asked: MeasurementSet,
    name: str,
    *,
    noise: Mapping[str, float] | None = None,
) -> Expected:
    """What the asked values, without its own, say of a measurement.

    Parameters
    ----------
    name : of the measurement, asked or not.
    noise : see `Estimator.ranges`.
    """
    given = estimator.law.given(_without(asked, name), noise)
    return Expected(*given.range(name, RANGE_SHARE))


def doubts(
    estimator: Estimator,
    asked: MeasurementSet,
    *,
    noise: Mapping[str, float] | None = None,
) -> list[Doubt]:
    """The asked values that may want another look, in the table's order.

    Where taking one value away leaves nothing to doubt among the others, that one alone is
    doubted; where several would do, each is, and each names those that speak against it.

    Parameters
    ----------
    noise : by measurement, the standard deviation of an asked value about the true one, SI;
        `model.law.TAPE_NOISE` by default.
    """
    noise = TAPE_NOISE if noise is None else noise
    found = {name: _Doubted.of(estimator, asked, name, noise) for name in asked}
    doubted = [name for name, one in found.items() if one.unusual or one.meant]
    culprits = [name for name in doubted if _explains(estimator, asked, name, noise)]
    if len(doubted) > 1 and culprits:
        # Of those that would each explain all, the ones that fit no better another way.
        named = [name for name in culprits if found[name].meant]
        doubted = named or culprits
    return [found[name].doubt(estimator, len(doubted) > 1) for name in doubted]


def conflicts(
    estimator: Estimator,
    asked: MeasurementSet,
    name: str,
    *,
    noise: Mapping[str, float] | None = None,
) -> tuple[str, ...]:
    """The fewest asked values that already speak against one as all others do, strongest first.

    They are found one by one: beside those before it, each makes the value the least likely.

    Parameters
    ----------
    name : of the asked value that is doubted.
    noise : as in `doubts`.
    """
    noise = TAPE_NOISE if noise is None else noise

    def score(others: Sequence[str]) -> float:
        some = MeasurementSet({other: asked[other] for other in others})
        given = estimator.law.given(some, noise, wide=True)
        return abs(_score(given, name, asked[name], noise))

    rest = [other for other in asked if other != name]
    limit = min(ELSEWHERE, score(rest))
    against: list[str] = []
    while rest:
        scores = {other: score([*against, other]) for other in rest}
        strongest = max(rest, key=lambda other: scores[other])
        against.append(strongest)
        rest.remove(strongest)
        if scores[strongest] >= limit:
            break
    return tuple(against)


def next_measurements(
    estimator: Estimator, asked: MeasurementSet, area: Area = "whole"
) -> list[Gain]:
    """What to measure next, the measurement that narrows the area most first.

    One that is asked already is not named; `TAPE_NOISE` is taken for granted.
    """
    law = estimator.law
    given = law.given(asked, TAPE_NOISE)
    wanted = np.array([law.names.index(name) for name in AREAS[area]])
    middles = np.exp(given.means)
    before = _half_range(given.covariance, middles, wanted)
    gains = []
    for place, name in enumerate(law.names):
        if name in asked:
            continue
        across = given.covariance[:, place]
        noisy = across[place] + (TAPE_NOISE[name] / middles[place]) ** 2
        after = _half_range(given.covariance - np.outer(across, across) / noisy, middles, wanted)
        gains.append(Gain(name, before, after, 1 - after / before if before > 0 else 0.0))
    return sorted(gains, key=lambda gain: gain.after)


def _half_range(covariance: Floats, middles: Floats, wanted: Integers) -> float:
    """Half of the 80 % ranges of wanted measurements, in the root of the mean square."""
    variances = np.maximum(np.diag(covariance), 0) * middles**2
    return float(ndtri((1 + RANGE_SHARE) / 2) * np.sqrt(variances[wanted].mean()))


def _without(asked: MeasurementSet, *names: str) -> MeasurementSet:
    return MeasurementSet({name: value for name, value in asked.items() if name not in names})


@dataclass(frozen=True, eq=False)
class _Doubted:
    """One asked value held against the others.

    Attributes
    ----------
    given : what the others say, all body-mass indices held possible; `score` is by that.
    meant, suggestion : another reading that is far likelier; ``unit``, or as in `Doubt`.
    """

    name: str
    asked: MeasurementSet
    noise: Mapping[str, float]
    given: Given
    score: float
    meant: str | None = None
    suggestion: float | None = None

    @property
    def unusual(self) -> bool:
        return abs(self.score) > UNUSUAL

    @classmethod
    def of(
        cls,
        estimator: Estimator,
        asked: MeasurementSet,
        name: str,
        noise: Mapping[str, float],
    ) -> "_Doubted":
        others = _without(asked, name)
        given = estimator.law.given(others, noise, wide=True)
        score = _score(given, name, asked[name], noise)
        if abs(score) < ELSEWHERE:
            return cls(name, asked, noise, given, score)
        best: tuple[float, str | None, float | None] = (score**2 / 2 - FAR_LIKELIER, None, None)
        readings = _neighbours(estimator, asked, name, noise)
        if abs(score) > UNUSUAL:
            readings = chain(_other_units(given, name, asked[name], noise), readings)
        for meant, suggestion, other in readings:
            if abs(other) < NEAR and other**2 / 2 < best[0]:
                best = (other**2 / 2, meant, suggestion)
        return cls(name, asked, noise, given, score, best[1], best[2])

    def doubt(self, estimator: Estimator, several: bool) -> Doubt:
        """As it is told."""
        code: Code = "contradicts" if several else "unusual"
        if self.meant:
            code = "unit_mix_up" if self.meant == "unit" else "neighbouring_definition"
        shown = expected(estimator, self.asked, self.name, noise=self.noise)
        return Doubt(
            measurement=self.name,
            code=code,
            expected=(shown.low, shown.high),
            suggestion=self.suggestion,
            meant=self.meant if self.meant != "unit" else None,
            conflicts=conflicts(estimator, self.asked, self.name, noise=self.noise),
        )


def _score(given: Given, name: str, value: float, noise: Mapping[str, float]) -> float:
    """By how many deviations a value lies above the expected one, its own noise in them."""
    middle = given.means[given.names.index(name)]
    deviation = np.hypot(given.deviation(name), noise.get(name, 0.0) / np.exp(middle))
    return float((np.log(value) - middle) / deviation)


def _explains(
    estimator: Estimator, asked: MeasurementSet, name: str, noise: Mapping[str, float]
) -> bool:
    """Whether nothing seems unusual among the others once a value is taken away."""
    rest = _without(asked, name)
    return all(
        abs(
            _score(
                estimator.law.given(_without(rest, other), noise, wide=True),
                other,
                rest[other],
                noise,
            )
        )
        <= UNUSUAL
        for other in rest
    )


def _other_units(
    given: Given, name: str, value: float, noise: Mapping[str, float]
) -> Iterator[tuple[str, float, float]]:
    """A value in other units: what it is called, the value, its score."""
    for factor in UNIT_FACTORS[MEASUREMENTS[name].unit]:
        yield "unit", value * factor, _score(given, name, value * factor, noise)


def _neighbours(
    estimator: Estimator, asked: MeasurementSet, name: str, noise: Mapping[str, float]
) -> Iterator[tuple[str, float, float]]:
    """Neighbours whose value it may be: their names, what ours then is, the neighbour's score."""
    value, law, others = asked[name], estimator.law, _without(asked, name)
    if name == "inseam_height":
        yield from _inside_leg(estimator, asked, noise)
    for neighbour in NEIGHBOURS.get(name, ()):
        # Where the neighbour is asked too, the same was taken twice, or this is not the reason.
        score = _score(law.given(others, noise, wide=True), neighbour, value, noise)
        known = MeasurementSet(dict(others) | {neighbour: value})
        suggestion = law.given(known, noise, wide=True).range(name, RANGE_SHARE)[1]
        yield neighbour, suggestion, score


def _inside_leg(
    estimator: Estimator, asked: MeasurementSet, noise: Mapping[str, float]
) -> Iterator[tuple[str, float, float]]:
    """An inseam that was taken to the floor, or that is a number of trousers."""
    value = asked["inseam_height"]
    given = estimator.law.given(_without(asked, "inseam_height"), noise, wide=True)
    if "foot_height" in asked:
        foot = asked["foot_height"]
    else:
        foot = given.range("foot_height", RANGE_SHARE)[1]
    places: Sequence[tuple[str, float]] = (
        ("inside_leg_height", value - foot),
        ("trousers_inseam", value + TROUSERS_SHORT_OF_FLOOR - foot),
    )
    for meant, inseam in places:
        if inseam > 0:
            yield meant, inseam, _score(given, "inseam_height", inseam, noise)
