"""Counts and times for Prometheus: of all shoppers together, and of none of them anything.

They are answered on an address of their own (METRICS_BIND), never on the public one. Processes
share their numbers through PROMETHEUS_MULTIPROC_DIR, which `server` sets.
"""

import os
import time
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from flask import Flask, g, request
from prometheus_client import (
    REGISTRY,
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    make_wsgi_app,
    multiprocess,
)
from werkzeug.wrappers import Response

if TYPE_CHECKING:
    from _typeshed.wsgi import StartResponse, WSGIApplication, WSGIEnvironment

REQUESTS = Counter("fitting_room_requests", "Requests answered.", ["endpoint", "method", "status"])
SECONDS = Histogram(
    "fitting_room_request_seconds",
    "Seconds from a request's arrival in the site to its answer.",
    ["endpoint"],
    buckets=(0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10),
)
WAITED = Histogram(
    "fitting_room_waited_seconds",
    "Seconds that requests for a body waited for their turn.",
    buckets=(0.001, 0.01, 0.05, 0.1, 0.5, 1, 2.5, 5, 10),
)
TURNED_AWAY = Counter(
    "fitting_room_turned_away", "Requests answered 503 because too many waited already."
)
RESIDUAL = Histogram(
    "fitting_room_fit_residual_metres",
    "The largest length by which a fitted body misses what was entered.",
    ["body"],
    buckets=(0.0001, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1),
)
RESIDENT = Gauge(
    "fitting_room_worker_resident_bytes",
    "Memory that a process holds.",
    multiprocess_mode="liveall",
)

METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "DELETE", "PATCH", "OPTIONS"})
_MEMORY = Path("/proc/self/statm")
_PAGE = os.sysconf("SC_PAGE_SIZE")


def set_up(app: Flask) -> None:
    """Count and time every request."""

    @app.before_request
    def begin() -> None:
        g.began = time.perf_counter()

    @app.after_request
    def count(response: Response) -> Response:
        endpoint = request.endpoint or "none"
        method = request.method if request.method in METHODS else "other"
        REQUESTS.labels(endpoint, method, response.status_code).inc()
        SECONDS.labels(endpoint).observe(seconds())
        if _MEMORY.exists():
            RESIDENT.set(int(_MEMORY.read_text().split()[1]) * _PAGE)
        return response


def seconds() -> float:
    """Since the request arrived; 0 where it never came as far as to begin."""
    now = time.perf_counter()
    return now - g.get("began", now)


def fitted(body: str, misses: Iterable[float]) -> None:
    """Count by how much a fitted body misses what was entered, in metres: the largest of all."""
    RESIDUAL.labels(body).observe(max(misses, default=0.0))


def beside(wsgi_app: "WSGIApplication", bind: str) -> "WSGIApplication":
    """The site, and on the port of `bind` the metrics in its place.

    Raises
    ------
    ValueError
        Where `bind` is no address with a port.
    """
    port = bind.rpartition(":")[2]
    if not bind.rpartition(":")[0] or not port.isdecimal():
        raise ValueError(f"METRICS_BIND is {bind!r}: address:port is needed")
    registry = REGISTRY
    if "PROMETHEUS_MULTIPROC_DIR" in os.environ:
        registry = CollectorRegistry()
        multiprocess.MultiProcessCollector(registry)  # type: ignore[no-untyped-call]
    answer = make_wsgi_app(registry)

    def routed(environ: "WSGIEnvironment", start_response: "StartResponse") -> Iterable[bytes]:
        # The port is that of the socket, which no header changes.
        if environ["SERVER_PORT"] != port:
            return wsgi_app(environ, start_response)
        if environ["PATH_INFO"] != "/metrics":
            start_response("404 Not Found", [("Content-Type", "text/plain")])
            return [b"Metrics are at /metrics.\n"]
        return answer(environ, start_response)

    return routed
