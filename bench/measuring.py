"""How long it takes to measure one body, and a population, beside a peer's way."""

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from bench.peer import PeerGirth
from bench.timing import Timings, take_turns
from model.anthropometry import TAKEN, TAPES, measure, measure_batch
from model.geometry import Floats
from model.girths import Girth
from model.template_mesh import Body, load_template_mesh
from model.training.population import bodies_of, load_population
from model.training.survey import SEXES

GIRTHS: tuple[str, ...] = tuple(name for name in TAKEN if isinstance(TAPES[name], Girth))

ALL = "everything, with paths"
VALUES = "everything, values alone"
OUR_GIRTHS = "the girths alone, ours"
PEER_SEARCHING = "the girths, trimesh at all the same planes"
PEER_TOLD = "the girths, trimesh told the planes that count"


@dataclass(frozen=True)
class OneBody:
    """What the timings of one body say.

    timings : by the names above
    apart : how far our girths and the peer's differ, in metres, by name
    """

    timings: Timings
    apart: Mapping[str, float]


def time_one_body(rounds: int, warm_up: int) -> OneBody:
    """Times the template's mean body."""
    template = load_template_mesh()
    body = Body(template, template.vertices, "neutral")
    alone = body.vertices[None]
    peers = [PeerGirth.of(name, TAPES[name], template) for name in GIRTHS]  # type: ignore[arg-type]
    planes = [peer.planes(template, body.vertices) for peer in peers]
    found = [peer.take(body.vertices, plane) for peer, plane in zip(peers, planes, strict=True)]
    ours = measure_batch(template, alone, GIRTHS)[0]
    apart = np.abs(ours - [girth for girth, _ in found]).tolist()

    def search() -> None:
        for peer, plane in zip(peers, planes, strict=True):
            peer.take(body.vertices, plane)

    def told() -> None:
        for peer, plane, (_, number) in zip(peers, planes, found, strict=True):
            peer.take(body.vertices, plane, only=number)

    ways = {
        ALL: lambda: measure(body),
        VALUES: lambda: measure_batch(template, alone),
        OUR_GIRTHS: lambda: measure_batch(template, alone, GIRTHS),
        PEER_SEARCHING: search,
        PEER_TOLD: told,
    }
    return OneBody(take_turns(ways, rounds, warm_up), dict(zip(GIRTHS, apart, strict=True)))


def time_bodies(bodies: int) -> NDArray[np.float64]:
    """Times bodies of the shipped population, from its first to its last, each measured alone.

    Returns
    -------
    seconds : ndarray of shape (bodies,)

    Raises
    ------
    ValueError
        For more bodies than there are.
    """
    template, population = load_template_mesh(), load_population()
    there = len(population.sexes)
    if not 1 <= bodies <= there:
        raise ValueError(f"{bodies} bodies are not from 1 to {there}")
    rows = np.linspace(0, there - 1, bodies).astype(np.int64)
    seconds = np.empty(bodies)
    with threadpool_limits(1):
        for part, vertices in bodies_of(population, rows):
            for row, positions in zip(range(bodies)[part], vertices, strict=True):
                body = Body(template, positions, SEXES[population.sexes[rows[row]]])
                start = time.perf_counter()
                measure(body)
                seconds[row] = time.perf_counter() - start
    return seconds


@dataclass(frozen=True)
class Run:
    """A population measured.

    bodies, processes : how many, by how many
    seconds : on the clock
    reckoned : that the processor gave to all processes together
    making : of those, for making the bodies from their coefficients
    """

    bodies: int
    processes: int
    seconds: float
    reckoned: float
    making: float


def time_population(bodies: int, processes: Sequence[int]) -> list[Run]:
    """Times the shipped population's first bodies, from their coefficients on.

    Raises
    ------
    ValueError
        For more bodies than there are.
    """
    there = len(load_population().sexes)
    if not 1 <= bodies <= there:
        raise ValueError(f"{bodies} bodies are not from 1 to {there}")
    runs = []
    for count in processes:
        parts = np.array_split(np.arange(bodies), count)
        with Parallel(n_jobs=count) as workers:
            # Every process reads its files and sees its first body before the clock starts.
            workers(delayed(measure_rows)(part[:1]) for part in parts)
            start = time.perf_counter()
            spent = workers(delayed(measure_rows)(part) for part in parts)
            seconds = time.perf_counter() - start
            reckoned, making = (float(sum(each)) for each in zip(*spent, strict=True))
            runs.append(Run(bodies, count, seconds, reckoned, making))
    return runs


def measure_rows(rows: NDArray[np.int64]) -> tuple[float, float]:
    """Measures some bodies of the population, by their rows: ndarray of shape (n,).

    Returns
    -------
    reckoned, making : seconds, as in `Run`.

    Raises
    ------
    ValueError
        Where a measurement is not finite.
    """
    begin = time.process_time()
    template, population = load_template_mesh(), load_population()
    making = 0.0
    values: list[Floats] = []
    with threadpool_limits(1):
        chunks = bodies_of(population, rows)
        for _ in range(len(rows)):
            start = time.process_time()
            chunk = next(chunks, None)
            making += time.process_time() - start
            if chunk is None:
                break
            values.append(measure_batch(template, chunk[1]))
    if not np.isfinite(np.concatenate(values)).all():
        raise ValueError("a body has a measurement that is not finite")
    return time.process_time() - begin, making


def cores() -> int:
    """How many cores this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on this system
        return os.cpu_count() or 1


def busy() -> float:
    """How many processes wanted to run in the last minute; not a number where nobody counts."""
    try:
        return os.getloadavg()[0]
    except (AttributeError, OSError):
        return float("nan")
