"""The command line: ``python -m bench`` prints our timings beside the peer's, and drives the real
server for half a minute.

``python -m bench load`` drives it for a quarter of an hour instead, see `load`.
``python -m bench stages`` tells where the time of a request goes, see `stages`.
``python -m bench silhouettes`` prints how well outlines tell bodies apart, and how they help.
"""

import argparse
import platform
import sys

import numpy as np
import trimesh

from bench import load, silhouettes, stages
from bench.measuring import (
    ALL,
    GIRTHS,
    OUR_GIRTHS,
    PEER_SEARCHING,
    PEER_TOLD,
    VALUES,
    Run,
    busy,
    cores,
    time_bodies,
    time_one_body,
    time_population,
)
from model.anthropometry import TAKEN
from model.geometry import Floats

ALONE = 300
"""Bodies that are measured one after the other."""


def main(arguments: list[str] | None = None) -> None:
    """Times and prints."""
    arguments = sys.argv[1:] if arguments is None else arguments
    others = {"silhouettes": silhouettes.main, "load": load.main, "stages": stages.main}
    if arguments and arguments[0] in others:
        others[arguments[0]](arguments[1:])
        return
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("--rounds", type=int, default=25, help="of the timings of one body")
    parser.add_argument("--warm-up", type=int, default=3, help="rounds before those")
    parser.add_argument("--bodies", type=int, default=3000, help="of the population")
    parser.add_argument(
        "--processes", type=int, nargs="+", default=[1, 2], help="measuring the population"
    )
    parser.add_argument(
        "--requests", type=int, default=40, help="to the real server, by each number of clients"
    )
    options = parser.parse_args(arguments)
    print(
        f"{cores()} cores, {platform.machine()}, Python {platform.python_version()}, "
        f"NumPy {np.__version__}, trimesh {trimesh.__version__}; one thread a process\n"
        f"{busy():.1f} processes wanted to run in the last minute. Reckoned is what the processor "
        "gave to ours;\nratios are of that, and hold on a busy machine too.\n"
    )
    one_body(options.rounds, options.warm_up)
    print()
    one_after_the_other(time_bodies(min(options.bodies, ALONE)))
    print()
    population(time_population(options.bodies, options.processes))
    if options.requests:
        print()
        load.shortly(options.requests)


def one_body(rounds: int, warm_up: int) -> None:
    """Prints what one body takes, ours and the peer's."""
    result = time_one_body(rounds, warm_up)
    timings = result.timings
    print(f"One body: {len(TAKEN)} measurements, {len(GIRTHS)} of them girths; {rounds} rounds")
    print(f"{'':48}{'median':>10}{'quartiles':>20}{'reckoned':>12}{'beside ours':>14}")
    for name, beside in (
        (ALL, ALL),
        (VALUES, ALL),
        (OUR_GIRTHS, OUR_GIRTHS),
        (PEER_SEARCHING, OUR_GIRTHS),
        (PEER_TOLD, OUR_GIRTHS),
    ):
        low, high = (seconds * 1e3 for seconds in timings.spread(name))
        print(
            f"{name:48}{timings.median(name) * 1e3:>7.2f} ms{f'{low:.2f} to {high:.2f}':>20}"
            f"{timings.median_reckoned(name) * 1e3:>9.2f} ms{timings.ratio(name, beside):>13.1f}×"
        )
    worst, second = sorted(result.apart, key=lambda name: -result.apart[name])[:2]
    print(
        f"Ours and the peer's girths differ by {result.apart[worst] * 1e3:.3f} mm ({worst}), "
        f"the others by {result.apart[second] * 1e3:.3f} mm at most."
    )


def one_after_the_other(seconds: Floats) -> None:
    """Prints what bodies of every build take, each measured alone."""
    low, middle, high, most = np.quantile(seconds, [0.25, 0.5, 0.75, 0.95]) * 1e3
    print(
        f"{len(seconds)} bodies of the population, one after the other, with paths: "
        f"median {middle:.2f} ms,\nquartiles {low:.2f} to {high:.2f}, 95 % within {most:.2f}, "
        f"{(seconds < 0.01).mean():.0%} under 10 ms"
    )


def population(runs: list[Run]) -> None:
    """Prints what a population takes."""
    print(f"{runs[0].bodies} bodies of the population: {len(TAKEN)} measurements each")
    print(f"{'':48}{'seconds':>10}{'a body':>20}{'reckoned':>12}{'as fast':>14}")
    for run in runs:
        words = "one process" if run.processes == 1 else f"{run.processes} processes"
        each = f"{run.seconds / run.bodies * 1e3:.2f} ms"
        print(
            f"{words:48}{run.seconds:>10.1f}{each:>20}{run.reckoned:>12.1f}"
            f"{runs[0].seconds / run.seconds:>13.1f}×"
        )
    print(
        f"Of what the first reckoned, {runs[0].making:.1f} seconds went into making the bodies "
        "from their coefficients."
    )


if __name__ == "__main__":
    main(sys.argv[1:])
