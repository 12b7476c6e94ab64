"""Timings of several ways in turn: warmed up, repeated, as medians with their quartiles."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from model.geometry import Floats


@dataclass(frozen=True)
class Timings:
    """Seconds of several ways to do a thing.

    seconds : by name, ndarray of shape (rounds,)
    """

    seconds: Mapping[str, Floats]

    def median(self, name: str) -> float:
        return float(np.median(self.seconds[name]))

    def spread(self, name: str) -> tuple[float, float]:
        """The quartiles."""
        low, high = np.quantile(self.seconds[name], [0.25, 0.75])
        return float(low), float(high)

    def ratio(self, name: str, beside: str) -> float:
        """How many times as long as another: the median over rounds, each of which did both."""
        return float(np.median(self.seconds[name] / self.seconds[beside]))


def take_turns(ways: Mapping[str, Callable[[], object]], rounds: int, warm_up: int) -> Timings:
    """Times every way once in each round, so that all meet the same weather.

    Raises
    ------
    ValueError
        For fewer than one round.
    """
    if rounds < 1:
        raise ValueError(f"{rounds} rounds are not at least 1")
    for _ in range(warm_up):
        for way in ways.values():
            way()
    seconds = {name: np.empty(rounds) for name in ways}
    for turn in range(rounds):
        for name, way in ways.items():
            start = time.perf_counter()
            way()
            seconds[name][turn] = time.perf_counter() - start
    return Timings(seconds)
