"""No more work at once than a process can do: a short queue, and beyond it an honest 503."""

import threading
import time

from flask import Flask, current_app, g, request
from werkzeug.exceptions import ServiceUnavailable

from webapp import metrics

PATIENCE = 10.0
"""Seconds that a request waits for its turn at most: browsers and people wait no longer."""

COME_AGAIN = 2
"""Seconds after which a request that was turned away may come again."""

WORKING = ("avatars", "comparisons", "mirror", "preview", "sheet")
"""Blueprints whose answers need a body; of the API, all that is posted."""


class Overloaded(ServiceUnavailable):
    """There is more to do than can be done."""

    description = "Many people are here at the moment. Please try again in a few seconds."

    def __init__(self) -> None:
        super().__init__(retry_after=COME_AGAIN)


class Gate:
    """Lets a number of threads through at once; some may wait.

    Parameters
    ----------
    at_once : threads that are let through.
    waiting : threads that may wait for them.
    patience : seconds that one waits at most.
    """

    def __init__(self, at_once: int, waiting: int, patience: float = PATIENCE) -> None:
        if at_once < 1:
            raise ValueError(f"{at_once} at once are not at least 1")
        self.most, self.patience = at_once + waiting, patience
        self._slots = threading.Semaphore(at_once)
        self._count = threading.Lock()
        self._inside = 0

    @property
    def is_full(self) -> bool:
        """Whether the next thread would be turned away."""
        return self._inside >= self.most

    def enter(self) -> None:
        """Wait for one's turn.

        Raises
        ------
        Overloaded
            Where too many wait already, or it takes too long.
        """
        with self._count:
            if self.is_full:
                raise Overloaded
            self._inside += 1
        if not self._slots.acquire(timeout=self.patience):
            with self._count:
                self._inside -= 1
            raise Overloaded

    def leave(self) -> None:
        """Make room for the next."""
        self._slots.release()
        with self._count:
            self._inside -= 1


def set_up(app: Flask) -> None:
    """Put a gate before all that reckons or draws a body. Call it after the limits on requests."""
    gate = Gate(app.config["WORK_AT_ONCE"], app.config["WORK_WAITING"])
    app.extensions["gate"] = gate

    @app.before_request
    def enter() -> None:
        if not _is_work():
            return
        # Who sends slowly waits outside: there is no turn before all is read, a form's parts too.
        if request.is_json:
            request.get_data()
        elif request.mimetype == "multipart/form-data":
            request.form  # noqa: B018 - reading it is what counts
        start = time.perf_counter()
        try:
            gate.enter()
        except Overloaded:
            metrics.TURNED_AWAY.inc()
            raise
        g.inside = True
        metrics.WAITED.observe(time.perf_counter() - start)

    app.teardown_request(leave)


def leave(error: BaseException | None = None) -> None:  # noqa: ARG001 - the signature is Flask's
    """Give up this request's turn, if it has one: the next may begin."""
    if g.pop("inside", False):
        current_app.extensions["gate"].leave()


def _is_work() -> bool:
    return request.blueprint in WORKING or (request.blueprint == "api" and request.method == "POST")
