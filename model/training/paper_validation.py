"""The paper's validation and evaluation (5.1 and 5.4) on bodies that were not learned from.

Reference: *Estimating Body Shapes From Body Measurements*, section 5: bodies estimated from
subsets of measurements, their vertices' distances, their measurements, and the total distance
error (TDE), which is the sum of a person's absolute misses.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model.anthropometry import TAKEN, measure_batch
from model.geometry import Floats
from model.measurements import MEASUREMENTS
from model.training.feature_selection import PAPER_DROPPED, TABLE_4, Selection
from model.training.paper_models import Model, PaperSpace, given
from model.training.population import Population
from model.training.survey import Sex

PAPER_TDE = (0.36, 0.66, 0.61, 0.84, 0.51, 0.27)
"""Of the paper's six people P1 to P6, in metres (5.4)."""

TOPS = (2, 4, 6, 8, 10)
"""So many of the measurements that vary most are given, in its first five subsets (5.1.1)."""

ENDS = (3, 97)
"""The small and the large body: the held-out ones nearest to these percentiles of weight."""

ALLOWED: Mapping[str, float] = {
    "bust_girth": 0.015,
    "hip_girth": 0.012,
    "waist_girth": 0.012,
    "abdomen_girth": 0.012,
    "neck_girth": 0.011,
    "stature": 0.010,
    "inseam_height": 0.010,
    "hip_to_ankle_height": 0.010,
    "waist_height": 0.010,
    "thigh_girth": 0.012,
    "mid_thigh_girth": 0.012,
    "rise_length": 0.012,
    "underbust_to_belly_button_length": 0.012,
}
"""What two readings of an expert may differ by, in metres: ANSUR II's practice for chest, hip,
waist, neck, stature and crotch height (Gordon et al. 2014, NATICK/TR-15/007). The other
heights as the crotch's, other girths and lengths as the hip's."""

SELF_MEASURED = 4.0
"""How many times an expert's that of people who measure themselves is: their waists were out by
± 48 mm in a study of 622 adults, beside the expert's 12."""


@dataclass(frozen=True, eq=False)
class ShapeErrors:
    """Distances between the vertices of estimated bodies and of the true ones.

    Attributes
    ----------
    squared : ndarray of shape (n,), mean squared error of the coordinates, m².
    mean, largest : ndarrays of shape (n,), of the vertices' distances, metres.
    shifted : ndarray of shape (n,), as `mean`, where the estimate is first moved as a whole
        to where it comes nearest: what is wrong with the shape rather than its place.
    """

    squared: Floats
    mean: Floats
    largest: Floats
    shifted: Floats


def subsets(selections: Mapping[Sex, Selection], sex: Sex) -> dict[str, tuple[str, ...]]:
    """The paper's seven subsets as our population chooses them, then the paper's own seven."""
    selection = selections[sex]
    shared = set.intersection(*(set(chosen.selected) for chosen in selections.values()))
    in_both = tuple(name for name in selection.selected if name in shared)
    return {
        **{f"top {count}": selection.top[:count] for count in TOPS},
        f"selected {len(in_both)}": in_both,
        f"selected {len(selection.selected)}": selection.selected,
        "Table 4": tuple(name for name in TABLE_4[sex] if name in selection.names),
    }


def small_and_large(population: Population, values: Floats, sex: Sex) -> NDArray[np.int64]:
    """Two held-out bodies of a sex, by weight: their rows, (2,).

    Parameters
    ----------
    values : ndarray of shape (n, m), what every body of the population measures, SI, as `TAKEN`.
    """
    rows = held_out(population, sex)
    weights = values[rows, TAKEN.index("weight")]
    ends = np.percentile(weights, ENDS)
    return rows[np.abs(weights - ends[:, None]).argmin(axis=1)]


def shape_errors(space: PaperSpace, estimated: Floats, true: Floats) -> ShapeErrors:
    """Errors of estimated coordinates in the space, (n, 1 + K), against the true ones."""
    parts = []
    for start in range(0, len(true), 64):
        part = slice(start, start + 64)
        moved = (estimated[part] - true[part]).astype(np.float32) @ space.rows
        apart = moved.reshape(len(moved), -1, 3)
        squares = np.einsum("nvi,nvi->nv", apart, apart)
        distances = np.sqrt(squares)
        apart -= apart.mean(axis=1, keepdims=True)
        parts.append(
            [
                squares.mean(axis=1, dtype=np.float64) / 3,
                distances.mean(axis=1, dtype=np.float64),
                distances.max(axis=1).astype(np.float64),
                np.sqrt(np.einsum("nvi,nvi->nv", apart, apart)).mean(axis=1, dtype=np.float64),
            ]
        )
    return ShapeErrors(*(np.concatenate(piece) for piece in zip(*parts, strict=True)))


def misses(space: PaperSpace, estimated: Floats, values: Floats) -> Floats:
    """What estimated bodies, (n, 1 + K), measure less the true values: (n, m), SI, as `TAKEN`."""
    parts = [
        measure_batch(space.template, space.vertices(estimated[start : start + 64]))
        for start in range(0, len(estimated), 64)
    ]
    return np.concatenate(parts) - values


def total_distance_error(missed: Floats, names: Sequence[str]) -> Floats:
    """The sum of absolute misses of some lengths and girths: (n,) of (n, m), metres.

    Raises
    ------
    ValueError
        For a name that is no length, or is not taken.
    """
    for name in names:
        if name not in TAKEN or MEASUREMENTS[name].kind == "mass":
            raise ValueError(f"{name} is not a length that is taken")
    sums: Floats = np.abs(missed[:, [TAKEN.index(name) for name in names]]).sum(axis=1)
    return sums


def evaluated(sex: Sex) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What the paper's people were asked for and what their error is the sum of.

    Ten measurements, of which the top eight were given (5.2, 5.3). The paper does not list
    them; Table 4's seven and what it dropped are the ten, and the eighth a height.
    """
    seven, dropped = TABLE_4[sex], PAPER_DROPPED[sex]
    entered = [name for name in (*seven, dropped[0]) if name in TAKEN]
    return tuple(entered), tuple(name for name in (*seven, *dropped) if name in TAKEN)


@dataclass(frozen=True, eq=False)
class PeopleErrors:
    """Errors against what people say they measure.

    Attributes
    ----------
    missed : ndarray of shape (n, m), measured on the estimate less said, SI, as `TAKEN`.
    total : ndarray of shape (n,), each person's total distance error, metres.
    """

    missed: Floats
    total: Floats


def people_errors(
    space: PaperSpace,
    model: Model,
    values: Floats,
    sex: Sex,
    *,
    tape: float = 0.0,
    seed: int = 0,
) -> PeopleErrors:
    """Estimates people from what the paper's people were asked for, and measures them.

    Parameters
    ----------
    values : ndarray of shape (n, m), SI, as `TAKEN`; a column of NaN is not known, and then
        neither entered nor summed.
    tape : deviation of what they say from what they measure, as a multiple of `ALLOWED`.
    """
    entered, summed = evaluated(sex)
    random = np.random.default_rng(seed)
    deviations = np.array([tape * ALLOWED.get(name, 0.0) for name in TAKEN])
    said = values + deviations * random.normal(size=values.shape)
    missed = misses(space, model(given(TAKEN, said, entered)), said)
    known = [name for name in summed if not np.isnan(values[:, TAKEN.index(name)]).any()]
    return PeopleErrors(missed=missed, total=total_distance_error(missed, known))


def learned_from(population: Population, sex: Sex) -> NDArray[np.int64]:
    """The rows of a sex that estimators may see: (n,)."""
    return np.flatnonzero(population.of(sex) & ~population.held_out)


def held_out(population: Population, sex: Sex) -> NDArray[np.int64]:
    """The rows of a sex that they may not: (n,)."""
    return np.flatnonzero(population.of(sex) & population.held_out)
