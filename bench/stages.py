"""Where the time of a request goes: ``python -m bench stages``.

The site in this process, asked for each kind of request that `load` sends, under Python's
profiler: what each call from the site into the model takes of the processor, with all that it
calls and on all threads, and what the page's template, packing and all the rest take. The profiler
itself takes time for each call, so that shares count, not milliseconds.
"""

import argparse
import cProfile
import pstats
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from flask.testing import FlaskClient
from werkzeug.test import TestResponse

from bench.load import WOMAN, comparison
from webapp import create_app

ROOT = Path(__file__).resolve().parent.parent

Place = tuple[str, int, str]
"""A function as the profiler names it: its file, its line and its name."""

OTHERS: Mapping[tuple[str, str], str] = {
    ("templating.py", "render_template"): "the page's template",
    ("flask_compress.py", "after_request"): "packing",
    ("provider.py", "dumps"): "JSON",
}
"""By the end of a file's name and the function: what else is told apart."""


def send(client: FlaskClient, kind: str, parts: bytes) -> TestResponse:
    """One request of a kind, from somebody who takes packed answers."""
    packed = {"Accept-Encoding": "zstd"}
    if kind == "page":
        return client.get("/numbers", headers=packed)
    if kind == "comparison":
        parted = "multipart/form-data; boundary=part"
        return client.post("/api/v1/comparisons", data=parts, content_type=parted, headers=packed)
    path = {"avatar": "", "GLB": ".glb", "picture": "/front.png"}[kind]
    return client.post("/api/v1/avatars" + path, json=WOMAN, headers=packed)


def stages(profile: cProfile.Profile) -> tuple[float, Counter[str]]:
    """The seconds of all calls, and of those from the site into the model and into `OTHERS`."""
    took: Counter[str] = Counter()
    stats: dict[Place, Any] = vars(pstats.Stats(profile))["stats"]
    for place, (*_, callers) in stats.items():
        name, ours = _told(place), _room(place) == "model"
        for caller, (*_, seconds) in callers.items():
            if name and (_room(caller) == "webapp" or not ours):
                took[name] += seconds
    return float(vars(pstats.Stats(profile))["total_tt"]), took


def _told(place: Place) -> str:
    """What a function is called in the table; "" if it is none of its rows."""
    file, _, function = place
    if _room(place) == "model":
        return f"{Path(file).stem}.{function}"
    return next(
        (words for (end, name), words in OTHERS.items() if file.endswith(end) and function == name),
        "",
    )


def _room(place: Place) -> str:
    """The package of ours that a function is in."""
    path = Path(place[0])
    return path.relative_to(ROOT).parts[0] if path.is_relative_to(ROOT) else ""


def table(kind: str, rounds: int, total: float, took: Counter[str]) -> Iterator[str]:
    """A kind of request in rows: what takes a hundredth of it or more."""
    yield f"| {kind} | {total / rounds * 1e3:.1f} ms | |"
    for name, seconds in took.most_common():
        if seconds >= 0.01 * total:
            yield f"| | {name} | {seconds / total:.0%} |"
    yield f"| | the rest | {1 - took.total() / total:.0%} |"


def main(arguments: Sequence[str]) -> None:
    """Asks and prints."""
    parser = argparse.ArgumentParser(prog="python -m bench stages", description=__doc__)
    parser.add_argument("--rounds", type=int, default=20, help="requests of each kind")
    options = parser.parse_args(arguments)
    settings = {
        "SECRET_KEY": "of the bench",
        "FITTING_ROOM_LOCAL": True,
        "RATELIMIT_ENABLED": False,
    }
    client = create_app(settings).test_client()
    drawn = client.post("/api/v1/avatars/front.png", json={**WOMAN, "silhouette": True})
    if drawn.status_code != 200:
        raise SystemExit("Pictures cannot be drawn here: scripts/require.sh osmesa")
    parts = comparison(drawn.data)
    print("| request | where the time goes | share |\n|---|---|---:|")
    for kind in ("page", "avatar", "GLB", "picture", "comparison"):
        send(client, kind, parts)
        profile = cProfile.Profile(time.process_time)
        profile.enable()
        for _ in range(options.rounds):
            if send(client, kind, parts).status_code != 200:
                raise RuntimeError(f"no answer to a request for a {kind}")
        profile.disable()
        print(*table(kind, options.rounds, *stages(profile)), sep="\n", flush=True)
