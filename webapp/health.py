"""Whether the server lives, and whether it should be sent shoppers."""

import math
import time

from flask import Blueprint, current_app, jsonify
from flask.typing import ResponseReturnValue
from flask_limiter import Limiter

from model import studio
from webapp.avatars import why_no_pictures

TRY_AGAIN = 5.0
"""Seconds after which a picture is tried again: no limit counts requests for health."""

_tried = -math.inf

bp = Blueprint("health", __name__)


@bp.get("/healthz")
def alive() -> ResponseReturnValue:
    """Says that the estimators are loaded: without them the site does not start."""
    return jsonify(status="ok")


@bp.get("/readyz")
def ready() -> ResponseReturnValue:
    """Says what works. 503 while more shoppers wait than should: others may take the next.

    Without pictures, or with limits counted by each process for itself, the site still serves.
    """
    busy = current_app.extensions["gate"].is_full
    checks = {
        "estimators": "ok",
        "pictures": _pictures(),
        "limits": _limits(),
        "queue": "full" if busy else "ok",
    }
    answer = jsonify(status="busy" if busy else "ready", checks=checks)
    return answer, 503 if busy else 200


def _pictures() -> str:
    """Whether the last one was drawn; where it was not, whether a small one is."""
    global _tried
    if studio.failure() == "":
        return "ok"
    now = time.monotonic()
    if studio.failure() is not None and now - _tried < TRY_AGAIN:
        return "missing"
    _tried = now
    return "missing" if why_no_pictures() else "ok"


def _limits() -> str:
    """Whether requests are counted, and whether where they should be."""
    limiters: set[Limiter] = current_app.extensions.get("limiter", set())
    for limiter in limiters:
        if limiter.storage is not None and not limiter.storage.check():
            return "each process counts for itself"
    return "ok" if limiters else "off"
