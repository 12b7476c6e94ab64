"""Several readings of one measurement: when a third is wanted, which value counts, how sure it is.

Two good readings lie no further apart than the survey allowed its measurers, which is twice the
deviation of one careful reading (`model.law.TAPE_NOISE`, where the sources stand).
"""

import math
import statistics
from collections.abc import Mapping, Sequence

from model.law import TAPE_NOISE

MOST = 3
"""Readings that are kept of one measurement."""

REPEATABILITY: Mapping[str, float] = {name: 2 * noise for name, noise in TAPE_NOISE.items()} | {
    "weight": 0.5
}
"""How far two good readings of a measurement may lie apart, SI. Of weight: as bathroom scales
repeat."""

PRIOR_READINGS = 4
"""How many readings the trained measurers' deviation counts for, beside a person's own."""


def middle(values: Sequence[float]) -> float:
    """What several readings come to: their median."""
    return statistics.median(values)


def differ(name: str, values: Sequence[float]) -> bool:
    """Whether two readings lie so far apart that a third is wanted."""
    return len(values) == 2 and abs(values[0] - values[1]) > REPEATABILITY[name] + 1e-9


def own_factor(readings: Mapping[str, Sequence[float]]) -> float:
    """How a person's readings repeat beside a trained measurer's: 1 is the same, 2 twice as far.

    The deviations of all measurements that were read twice, each as a share of the expected one,
    are put together, and with them `PRIOR_READINGS` readings as trained measurers take them.
    """
    squares, freedom = float(PRIOR_READINGS), PRIOR_READINGS
    for name, values in readings.items():
        if len(values) > 1:
            squares += (len(values) - 1) * statistics.variance(values) / _deviation(name) ** 2
            freedom += len(values) - 1
    return math.sqrt(squares / freedom)


def noise(readings: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """The deviation of each value, SI: of all, once anything was read twice; else of none.

    References
    ----------
    A mean of n independent readings deviates by 1/√n of one reading's deviation; a median of three
    by a little more (1.16 times), which is left out.
    """
    if all(len(values) < 2 for values in readings.values()):
        return {}
    factor = own_factor(readings)
    return {
        name: factor * _deviation(name) / math.sqrt(len(values))
        for name, values in readings.items()
    }


def _deviation(name: str) -> float:
    return REPEATABILITY[name] / 2
