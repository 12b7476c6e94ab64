"""Load on the real server from a second process: ``python -m bench load``.

A mix of what shoppers and programs ask for, by some clients at the same time, each of which asks
again as soon as it is answered. Beside it a plain Flask page on the same server and workers, in the
same run: what is told of speed is a ratio to that.
"""

import argparse
import http.client
import io
import itertools
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Literal

import numpy as np
from PIL import Image, ImageDraw

from bench.measuring import busy, cores
from bench.serving import Answer, Server, ask, ask_on
from bench.tables import printed, put

WOMAN: Mapping[str, object] = {
    "body": "female",
    "measurements": {"stature": 168, "bust_girth": 92, "waist_girth": 74, "hip_girth": 100},
}

MIX = ("page", "avatar", "page", "GLB", "avatar", "page", "picture", "avatar", "GLB", "comparison")
"""Requests in turn: of ten, three each for a page and a body's numbers, two for its file, one each
for a picture and a comparison."""

CLIENTS = (1, 8, 32)
"""How many ask at the same time."""

Served = Literal["site", "plain"]

Drive = Callable[[Served, int, int], "Load"]
"""Drives one of both by a number of clients, with a number of requests."""

DRAWING = 2
"""Clients that want pictures all the while: one is always being drawn."""

BESIDE: Mapping[str, tuple[str, str, Mapping[str, object] | None]] = {
    "health check": ("GET", "/healthz", None),
    "page": ("GET", "/numbers", None),
    "avatar": ("POST", "/api/v1/avatars", WOMAN),
}
"""What is asked for meanwhile: nothing, a page, and a body's numbers."""


@dataclass(frozen=True, slots=True)
class Load:
    """What a number of clients met.

    clients : how many asked at the same time
    seconds : on the clock, all together
    latencies : by kind of request, those that were answered 2xx, seconds
    answers : how many by status; 0 where none came
    """

    clients: int
    seconds: float
    latencies: Mapping[str, Sequence[float]]
    answers: Mapping[int, int]

    @property
    def rate(self) -> float:
        """Requests answered 2xx a second."""
        return sum(map(len, self.latencies.values())) / self.seconds

    def quantile(self, share: float) -> float:
        """Of the latencies, seconds."""
        every = [one for some in self.latencies.values() for one in some]
        return float(np.quantile(every, share)) if every else float("nan")


def outline(port: int) -> bytes:
    """A body's own outline, as the server draws it; a plain figure where it draws none."""
    drawn = ask(port, "POST", "/api/v1/avatars/front.png", {**WOMAN, "silhouette": True})
    if drawn.status == 200:
        return drawn.body
    picture = Image.new("L", (300, 600))
    ImageDraw.Draw(picture).rectangle((100, 30, 200, 570), fill=255)
    stream = io.BytesIO()
    picture.save(stream, "PNG")
    return stream.getvalue()


def comparison(png: bytes) -> bytes:
    """The parts of a comparison's request, between lines of ``--part``."""
    document = b'{"body": "female", "measurements": {"stature": 168}}'
    return (
        b"--part\r\nContent-Disposition: form-data; name=avatar\r\n\r\n" + document + b"\r\n"
        b'--part\r\nContent-Disposition: form-data; name=front; filename="front.png"\r\n'
        b"Content-Type: image/png\r\n\r\n" + png + b"\r\n--part--\r\n"
    )


def send(connection: http.client.HTTPConnection, kind: str, parts: bytes) -> Answer:
    """One request of a kind."""
    if kind == "plain":
        return ask_on(connection, "GET", "/")
    if kind == "page":
        return ask_on(connection, "GET", "/numbers")
    if kind == "comparison":
        multipart = {"Content-Type": "multipart/form-data; boundary=part"}
        return ask_on(connection, "POST", "/api/v1/comparisons", parts, multipart)
    path = {"avatar": "", "GLB": ".glb", "picture": "/front.png"}[kind]
    return ask_on(connection, "POST", "/api/v1/avatars" + path, WOMAN)


def drive(port: int, clients: int, requests: int, mix: Sequence[str], parts: bytes) -> Load:
    """Sends so many requests by so many clients."""
    turns = itertools.count()
    latencies: dict[str, list[float]] = {kind: [] for kind in mix}
    answers: Counter[int] = Counter()
    lock = threading.Lock()

    def client() -> None:
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=120)
        while (turn := next(turns)) < requests:
            kind = mix[turn % len(mix)]
            start = time.perf_counter()
            try:
                status = send(connection, kind, parts).status
            except (OSError, http.client.HTTPException):
                connection.close()
                status = 0
            took = time.perf_counter() - start
            with lock:
                answers[status] += 1
                if status == 200:
                    latencies[kind].append(took)
        connection.close()

    threads = [threading.Thread(target=client) for _ in range(clients)]
    start = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return Load(clients, time.perf_counter() - start, latencies, answers)


def main(arguments: Sequence[str]) -> None:
    """Drives and prints."""
    parser = argparse.ArgumentParser(prog="python -m bench load", description=__doc__)
    parser.add_argument("--requests", type=int, default=500, help="by each number of clients")
    parser.add_argument("--clients", type=int, nargs="+", default=CLIENTS)
    parser.add_argument(
        "--pictures", type=int, default=200, help="drawn while others ask the same worker"
    )
    parser.add_argument(
        "--memory", type=int, default=5000, help="requests over which it is watched"
    )
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="the tables into docs/hosting.md")
    options = parser.parse_args(arguments)
    tables = []
    with ProcessPoolExecutor(1, get_context("spawn")) as second:
        with _driven(second, options.workers) as (driven, server):
            tables.append(printed(_compare(driven, options.clients, options.requests)))
            print()
            _print_kinds(driven("site", 1, options.requests))
            if options.memory:
                _watch(server, lambda count: driven("site", 8, count), options.memory)
        if options.pictures:
            print(
                f"\nOne worker, asked for other things one by one; {DRAWING} clients want "
                f"{options.pictures} pictures of it:\n"
            )
            tables.append(printed(_beside_pictures(second, options.pictures)))
    if options.write:
        for table in tables:
            put(table)


def shortly(requests: int) -> None:
    """Drives by few requests and prints: enough for a ratio, not for a tail."""
    print(
        f"The real server, shortly: {requests} requests by each number of clients. For tails and "
        "memory:\npython -m bench load"
    )
    with (
        ProcessPoolExecutor(1, get_context("spawn")) as second,
        _driven(second, workers=2) as (driven, _),
    ):
        printed(_compare(driven, CLIENTS, requests))


@contextmanager
def _driven(second: ProcessPoolExecutor, workers: int) -> Iterator[tuple[Drive, Server]]:
    """The site and the plain page on as many workers, and what drives them from another process."""
    settings = {"WEB_CONCURRENCY": str(workers)}
    print(
        f"{cores()} cores, {workers} workers; {busy():.1f} processes wanted to run in the "
        "last minute. Hold ratios against ratios.\n"
    )
    with Server(settings) as site, Server(settings, "bench.plain:app") as plain:
        ports = {"site": site.port, "plain": plain.port}
        mixes: Mapping[Served, Sequence[str]] = {"site": MIX, "plain": ("plain",)}
        parts = comparison(outline(site.port))

        def driven(served: Served, clients: int, requests: int) -> Load:
            return second.submit(
                drive, ports[served], clients, requests, mixes[served], parts
            ).result()

        driven("site", 2, 4 * len(MIX))  # Warm: the first picture opens the renderer.
        driven("plain", 2, 40)
        yield driven, site


def _compare(driven: Drive, clients: Sequence[int], requests: int) -> Iterator[str]:
    """How the site does beside the plain page, row by row."""
    yield "| clients | answers a second | median | 95 % | beside a plain page | answers |"
    yield "|---:|---:|---:|---:|---:|---|"
    for count in clients:
        base = driven("plain", count, requests)
        load = driven("site", count, requests)
        answers = ", ".join(
            f"{status or 'none'}: {n}" for status, n in sorted(load.answers.items())
        )
        yield (
            f"| {count} | {load.rate:.1f} | {_ms(load.quantile(0.5))} | {_ms(load.quantile(0.95))} "
            f"| {base.rate / load.rate:.0f} × | {answers} |"
        )


def _ms(seconds: float) -> str:
    """Milliseconds, or seconds where there are many."""
    return f"{seconds * 1e3:.0f} ms" if seconds < 0.5 else f"{seconds:.1f} s"


def _beside_pictures(second: ProcessPoolExecutor, pictures: int) -> Iterator[str]:
    """What others wait at a worker while it draws one picture after the other, row by row."""
    with Server({"WEB_CONCURRENCY": "1"}) as site:

        def meanwhile(count: int) -> dict[str, list[float]]:
            drawing = second.submit(drive, site.port, DRAWING, count, ["picture"], b"")
            took: dict[str, list[float]] = {kind: [] for kind in BESIDE}
            while not drawing.done() or len(took["page"]) < 100:
                for kind, times in took.items():
                    start = time.perf_counter()
                    if ask(site.port, *BESIDE[kind]).status != 200:
                        raise RuntimeError(f"no answer to a {kind}")
                    times.append(time.perf_counter() - start)
            drawn = drawing.result().answers.get(200, 0)
            if drawn < count:
                raise RuntimeError(f"{drawn} of {count} pictures were drawn")
            return took

        second.submit(drive, site.port, 1, 3, ["picture"], b"").result()
        alone, beside = meanwhile(0), meanwhile(pictures)
    yield "| | alone, median | 95 % | beside pictures, median | 95 % | all within | median, ratio |"
    yield "|---|---:|---:|---:|---:|---:|---:|"
    for kind in BESIDE:
        quiet, late = alone[kind], beside[kind]
        cells = [_ms(float(np.quantile(t, q))) for t in (quiet, late) for q in (0.5, 0.95)]
        ratio = np.median(late) / np.median(quiet)
        yield f"| {kind} | {' | '.join(cells)} | {_ms(max(late))} | {ratio:.1f} × |"


def _print_kinds(load: Load) -> None:
    print("One client, by kind of request, medians:")
    for kind, times in load.latencies.items():
        if times:
            print(f"{kind:12}{np.median(times) * 1e3:>8.0f} ms")


def _watch(site: Server, run: Callable[[int], Load], requests: int) -> None:
    """Prints the memory of each worker as requests go by, and how much of it they share."""
    print(
        f"\nMemory of each worker, MB, over {requests} requests: resident, of that shared with the "
        "others,\nand as much as falls to it where a shared page counts in equal parts (Pss)"
    )
    steps = 5
    for step in range(steps + 1):
        each = "   ".join(
            f"{one.resident / 1e6:>6.0f}{one.shared / 1e6:>6.0f}{one.proportional / 1e6:>6.0f}"
            for one in site.memory()
        )
        print(f"{requests * step // steps:>8}   {each}", flush=True)
        if step < steps:
            run(requests // steps)
