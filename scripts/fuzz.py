"""Throws generated requests at the whole site, and stops at the first that it does not answer well.

Nothing may be answered 5xx, and no exception may leave the site. What is sent: `fuzz_ways`. It goes
in portions, each with a seed of its own, so that a run tells how far it is, and what was answered
until then where it is stopped.

    python scripts/fuzz.py [--inputs 50000] [--processes 2] [--seed 1]
"""

import argparse
import signal
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from datetime import UTC, datetime
from functools import cache
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path

from flask import Flask

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from fuzz_ways import WAYS, Tally
from webapp import create_app

SETTINGS = {
    "TESTING": True,
    "SECRET_KEY": "of the fuzzing, and no secret",
    "SESSION_COOKIE_SECURE": False,
    "RATELIMIT_ENABLED": False,
    "WTF_CSRF_ENABLED": False,
    "FITTING_ROOM_LOCAL": True,
}

SHARES = {"forms": 0.42, "pictures": 0.3, "bytes": 0.2, "api": 0.075, "bodies": 0.005}
"""Of all inputs, in each way of making them. The dear ones are the fewest."""

PORTION = 1000
"""Inputs that a process sends before it tells of them."""


@cache
def site() -> Flask:
    """The site of this process."""
    return create_app(SETTINGS)


def fuzz(inputs: int, seed: int) -> Tally:
    """Sends so many requests, in all ways."""
    tally = Tally()
    shares = dict(SHARES)
    if find_spec("schemathesis") is None:
        shares["bytes"] += shares.pop("api")
    for way, share in shares.items():
        wanted = max(round(inputs * share), len(SHARES))  # some, however few are wanted of all
        WAYS[way](site(), tally, wanted, seed)
    return tally


def lines(tally: Tally) -> Iterator[str]:
    """The answers as a table."""
    yield "| way | inputs | answers |"
    yield "|---|---:|---|"
    for way in WAYS:
        statuses = sorted((status, n) for (one, status), n in tally.answers.items() if one == way)
        yield f"| {way} | {tally.total(way)} | {', '.join(f'{s}: {n}' for s, n in statuses)} |"


def main() -> None:
    """Sends, and prints what was answered."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--inputs", type=int, default=50_000)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    start = time.monotonic()
    portions = [min(PORTION, options.inputs - begun) for begun in range(0, options.inputs, PORTION)]
    tally = Tally()
    with ProcessPoolExecutor(options.processes, get_context("spawn"), _leave_keys) as pool:
        running = [
            pool.submit(fuzz, portion, options.seed + number)
            for number, portion in enumerate(portions)
        ]
        try:
            for done in as_completed(running):
                tally.answers += done.result().answers
                seconds = time.monotonic() - start
                print(f"{tally.total():>7} inputs, {seconds:.0f} s", file=sys.stderr, flush=True)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            print("Stopped. What was answered until then:\n", *lines(tally), sep="\n")
            raise
    seeds = f"{options.seed} to {options.seed + len(portions) - 1}"
    print(*lines(tally), sep="\n")
    print(
        f"\n{tally.total()} inputs, seeds {seeds}, {datetime.now(UTC):%Y-%m-%d}, "
        f"{time.monotonic() - start:.0f} s: none was answered 5xx."
    )


def _leave_keys() -> None:
    """Ctrl-C is the first process's to hear."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    main()
