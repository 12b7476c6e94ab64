"""How gunicorn serves the site: ``gunicorn --config webapp/server.py 'webapp:create_app()'``.

It is read before anything of the site is, and told by the environment; see `settings.VARIABLES`.
"""

import contextlib
import ctypes
import os
import shutil
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gunicorn.arbiter import Arbiter
    from gunicorn.workers.base import Worker

ROOT = Path(__file__).resolve().parent.parent
MEMORY = Path("/dev/shm")  # noqa: S108 - a folder of its own is made in it
_M_ARENA_MAX = -8
"""Of mallopt(3)."""

OWNER = "FITTING_ROOM_METRICS_OWNER"
"""The process that made the folder of the metrics."""


def settings(variables: Mapping[str, str]) -> dict[str, Any]:
    """Gunicorn's settings from the environment's variables."""
    metrics = variables.get("METRICS_BIND")
    host, port = variables.get("HOST") or "0.0.0.0", variables.get("PORT") or "8000"  # noqa: S104
    log_level = (variables.get("LOG_LEVEL") or "info").upper()
    return {
        "bind": [f"{host}:{port}", *([metrics] if metrics else [])],
        "workers": int(variables.get("WEB_CONCURRENCY") or 2),
        "worker_class": "gthread",
        # More than work at once: some wait, some read slowly, one answers that all goes well.
        "threads": int(variables.get("WEB_THREADS") or 16),
        # The estimators are loaded once, and shared.
        "preload_app": True,
        "control_socket_disable": True,
        # Where processes show that they live: on a full disk there is no place for it.
        "worker_tmp_dir": str(MEMORY) if MEMORY.is_dir() else None,
        "timeout": 60,
        # Requests that are under way when the server is told to stop or to begin anew.
        "graceful_timeout": 30,
        "keepalive": 15,
        "limit_request_line": 2048,
        "limit_request_fields": 50,
        "limit_request_field_size": 8190,
        "logconfig_dict": {
            "version": 1,
            "disable_existing_loggers": False,
            "formatters": {"lines": {"()": "webapp.logs.JsonLines"}},
            "handlers": {
                "out": {
                    "class": "logging.StreamHandler",
                    "formatter": "lines",
                    "stream": "ext://sys.stdout",
                }
            },
            "root": {"level": "WARNING", "handlers": ["out"]},
            # Gunicorn's own log of requests holds addresses; ours does not.
            "loggers": {
                "fitting_room": {"level": log_level},
                "gunicorn.error": {"level": log_level, "handlers": [], "propagate": True},
                "gunicorn.access": {"level": "CRITICAL", "handlers": [], "propagate": False},
            },
        },
    }


def share_metrics() -> None:
    """Make the folder through which this server's processes share their metrics, once.

    This file is read again when the server begins anew (HUP), and by a new server that takes the
    place of the old one (USR2) and has its environment.
    """
    if os.environ.get(OWNER) != str(os.getpid()):
        # In memory where there is such a folder: a full disk would end the processes.
        os.environ["PROMETHEUS_MULTIPROC_DIR"] = tempfile.mkdtemp(
            prefix="fitting-room-metrics-", dir=MEMORY if MEMORY.is_dir() else None
        )
        os.environ[OWNER] = str(os.getpid())


def when_ready(server: "Arbiter") -> None:
    """The process that loaded the site serves nobody, and tells nothing of itself."""
    _forget_present(server.pid)


def child_exit(server: "Arbiter", worker: "Worker") -> None:  # noqa: ARG001 - gunicorn's
    """Forget what a process that ended says of the present."""
    _forget_present(worker.pid)


def _forget_present(process: int) -> None:
    if "PROMETHEUS_MULTIPROC_DIR" in os.environ:
        from prometheus_client import multiprocess

        multiprocess.mark_process_dead(process)  # type: ignore[no-untyped-call]


def post_request(worker: "Worker", _request: object, _environ: object, _response: object) -> None:
    """Let a process end whose drawing hangs, once it has answered what it can: another one takes
    its place. No thread can be stopped from outside.
    """
    from model import studio

    if studio.hangs() and worker.alive:
        worker.log.error("drawing hangs: this process ends")
        worker.alive = False


def worker_exit(server: "Arbiter", worker: "Worker") -> None:  # noqa: ARG001 - gunicorn's
    """Do not wait for a thread that hangs, as Python would."""
    from model import studio

    if studio.hangs():
        os._exit(1)


def keep_few_heaps() -> None:
    """Tell glibc to serve all threads from two heaps, not from one for each: what pictures need for
    a moment would otherwise stay behind in every one. Elsewhere nothing happens.
    """
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).mallopt(_M_ARENA_MAX, 2)


def on_exit(server: "Arbiter") -> None:  # noqa: ARG001 - gunicorn's
    """Leave nothing behind of what this server made."""
    if os.environ.get(OWNER) == str(os.getpid()):
        shutil.rmtree(os.environ["PROMETHEUS_MULTIPROC_DIR"], ignore_errors=True)


if __name__ == "__config__":
    sys.path.insert(0, str(ROOT))
    # Both are read when NumPy and the metrics are imported.
    os.environ["OPENBLAS_NUM_THREADS"] = os.environ.get("OPENBLAS_NUM_THREADS") or "1"
    if os.environ.get("METRICS_BIND"):
        share_metrics()
    keep_few_heaps()
    globals().update(settings(os.environ))
