"""Timings of several ways in turn: warmed up, repeated, as medians with their quartiles."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from model.geometry import Floats


@dataclass(frozen=True)
class Timings:
    """Seconds of several ways to do a thing.

    seconds : on the clock, by name, ndarray of shape (rounds,)
    reckoned : of those the seconds that the processor gave to this process, likewise: what is
        left of them on a machine that has nothing else to do
    """

    seconds: Mapping[str, Floats]
    reckoned: Mapping[str, Floats]

    def median(self, name: str) -> float:
        """Seconds on the clock."""
        return float(np.median(self.seconds[name]))

    def median_reckoned(self, name: str) -> float:
        """Seconds of the processor."""
        return float(np.median(self.reckoned[name]))

    def spread(self, name: str) -> tuple[float, float]:
        """The quartiles, in seconds on the clock."""
        low, high = np.quantile(self.seconds[name], [0.25, 0.75])
        return float(low), float(high)

    def ratio(self, name: str, beside: str) -> float:
        """How many times as long as another reckons: the median over rounds, which did both."""
        return float(np.median(self.reckoned[name] / self.reckoned[beside]))


def take_turns(ways: Mapping[str, Callable[[], object]], rounds: int, warm_up: int) -> Timings:
    """Times every way once in each round, so that all meet the same weather; each on one thread.

    Each way is gone once more right before it is timed: the caches then hold its own data, as on a
    server that does nothing else, and not those of the way before it.

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
    reckoned = {name: np.empty(rounds) for name in ways}
    with threadpool_limits(1):
        for turn in range(rounds):
            for name, way in ways.items():
                way()
                start, start_reckoned = time.perf_counter(), time.process_time()
                way()
                seconds[name][turn] = time.perf_counter() - start
                reckoned[name][turn] = time.process_time() - start_reckoned
    return Timings(seconds, reckoned)
