"""How many requests one address may send: counted, and forgotten when the limit's time is over."""

import contextlib
import hmac
import ipaddress
import time

from flask import Flask, current_app
from flask_limiter import Limiter
from flask_limiter.util import get_remote_address
from limits.storage import MemoryStorage

from webapp import health

JUMP = 5.0
"""Seconds by which a clock moves that is set: one that is only kept right moves by less."""


def set_up(app: Flask) -> None:
    """Count all requests but those for the site's health."""
    ahead = _ahead()

    @app.before_request
    def begin_anew_after_a_jump() -> None:
        """Else a clock that is set back by an hour turns away for an hour who reached the limit."""
        nonlocal ahead
        now = _ahead()
        if abs(now - ahead) > JUMP:
            ahead = now
            if limiter.enabled and isinstance(limiter.storage, MemoryStorage):
                limiter.storage.reset()

    limiter = Limiter(sender, app=app)
    limiter.exempt(health.bp)


def _ahead() -> float:
    """By how much the clock that people set is ahead of the one that nobody sets."""
    return time.time() - time.monotonic()


def sender() -> str:
    """Whom a request is counted for: a network address that cannot be read from what is kept.

    Of IPv6, which gives everyone a network of their own, the network.
    """
    address = get_remote_address()
    with contextlib.suppress(ValueError):
        if ipaddress.ip_address(address).version == 6:
            address = str(ipaddress.ip_network(f"{address}/64", strict=False))
    key = current_app.config["SECRET_KEY"].encode()
    return hmac.digest(key, address.encode(), "sha256").hex()[:16]
