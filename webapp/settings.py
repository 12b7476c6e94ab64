"""What the environment may say: every variable once, and the settings that come of them.

The table of docs/hosting.md is this one; a test holds them together.
"""

import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from model.template_mesh import DATA


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of the environment: its name, its default and what it means."""

    name: str
    default: str
    meaning: str


VARIABLES = (
    Variable(
        "SECRET_KEY",
        "",
        "signs what shoppers' browsers keep, and is the same for all servers behind one balancer. "
        "A deployed site refuses to start without one, with one that everybody knows, or with "
        "fewer than 16 letters. Make one with `openssl rand -hex 32`; `make run` keeps its own in "
        "`instance/`",
    ),
    Variable(
        "SECRET_KEY_FALLBACKS",
        "",
        "former keys, separated by spaces: what they signed is still read, so that a key can be "
        "changed without losing what a shopper is typing",
    ),
    Variable("HOST", "0.0.0.0", "where to listen; `make run`: 127.0.0.1"),  # noqa: S104
    Variable("PORT", "8000", "where to listen"),
    Variable("WEB_CONCURRENCY", "2", "processes: one for each core is a good beginning"),
    Variable("WEB_THREADS", "16", "requests that a process listens to at the same time"),
    Variable(
        "WORK_AT_ONCE", "4", "bodies that a process reckons or draws at the same time, of those"
    ),
    Variable(
        "WORK_WAITING",
        "8",
        "requests for a body that wait for their turn in a process. One more is answered 503 with "
        "`Retry-After` at once",
    ),
    Variable(
        "OPENBLAS_NUM_THREADS",
        "1",
        "threads with which a request reckons: with one, requests do not take the cores from one "
        "another",
    ),
    Variable(
        "TRUSTED_PROXIES",
        "0",
        "proxies in front, whose `X-Forwarded-*` headers are believed: too many, and a shopper "
        "may say to be anyone; too few, and all shoppers share one limit",
    ),
    Variable("RATELIMIT_ENABLED", "1", "0: no limit on requests"),
    Variable("RATELIMIT_DEFAULT", "600 per minute", "requests of one address, page and pictures"),
    Variable(
        "RATELIMIT_STORAGE_URI",
        "memory://",
        "where requests are counted: each process's own memory, or `redis://host:6379/0` for all "
        "together. Where Redis fails, each process counts for itself until it is back",
    ),
    Variable(
        "EMBED_ORIGINS",
        "",
        "origins of the shops that may show the fitting room on their pages, separated by spaces; "
        "see [embedding](embedding.md)",
    ),
    Variable(
        "METRICS_BIND",
        "",
        "address and port of the Prometheus metrics, such as `127.0.0.1:9100`; without it there "
        "are none. Never the public address",
    ),
    Variable("LOG_LEVEL", "info", "debug, info, warning or error"),
    Variable(
        "FITTING_ROOM_DATA",
        "",
        "a folder of estimators learned from [scans](scans.md), in place of the shipped ones",
    ),
    Variable(
        "FITTING_ROOM_LOCAL",
        "0",
        "1: a server on one's own machine, without https; `make run` sets it",
    ),
)
"""All that the site and its server read from the environment."""

DEFAULTS: Mapping[str, str] = {variable.name: variable.default for variable in VARIABLES}

KNOWN_KEYS = frozenset(
    {"change me", "changeme", "default", "dev", "key", "password", "secret", "secret key", "test"}
)
"""Keys that everybody knows, whatever is put between their words or after them."""

LEAST_KEY = 16
"""Letters of a secret key."""

PATIENT: Mapping[str, float] = {"socket_connect_timeout": 0.5, "socket_timeout": 0.5}
"""Seconds that a request waits for Redis at most: without them, as long as one that hangs."""

_ORIGIN = re.compile(r"https?://[a-z0-9.-]+(:\d{1,5})?", re.IGNORECASE)


def environment(variables: Mapping[str, str]) -> dict[str, Any]:
    """Flask's settings from the environment's variables.

    Raises
    ------
    ValueError
        Where a number is none, or an origin is more or less than one.
    """

    def said(name: str) -> str:
        return variables.get(name) or DEFAULTS[name]

    def number(name: str) -> int:
        value = said(name)
        if not value.isdecimal():
            raise ValueError(f"{name} is {value!r}: a whole number from 0 up is needed")
        return int(value)

    local = said("FITTING_ROOM_LOCAL") == "1"
    storage = said("RATELIMIT_STORAGE_URI")
    origins = tuple(said("EMBED_ORIGINS").split())
    for origin in origins:
        if not _ORIGIN.fullmatch(origin):
            raise ValueError(
                f"EMBED_ORIGINS has {origin!r}: an origin such as https://shop.example is needed, "
                "without a path"
            )
    return {
        "FITTING_ROOM_LOCAL": local,
        "SECRET_KEY": said("SECRET_KEY") or (secrets.token_hex(32) if local else ""),
        "SECRET_KEY_FALLBACKS": said("SECRET_KEY_FALLBACKS").split(),
        # Of a name with this prefix browsers take a cookie by https alone, from this very host and
        # for all of it: no neighbour under the same domain can set or read it.
        "SESSION_COOKIE_NAME": "fitting_room" if local else "__Host-fitting_room",
        "SESSION_COOKIE_HTTPONLY": True,
        # On a shop's page the cookie is a third party's: it travels there, and only there, in a
        # jar of that shop's own.
        "SESSION_COOKIE_SAMESITE": "None" if origins else "Lax",
        "SESSION_COOKIE_PARTITIONED": bool(origins),
        "SESSION_COOKIE_SECURE": bool(origins) or not local,
        # The token lives as long as the session: a form may stay open while one looks for a tape.
        "WTF_CSRF_TIME_LIMIT": None,
        "FITTING_ROOM_DATA": said("FITTING_ROOM_DATA") or DATA,
        "MAX_CONTENT_LENGTH": 64 * 1024,
        "TRUSTED_PROXIES": number("TRUSTED_PROXIES"),
        "RATELIMIT_ENABLED": variables.get("RATELIMIT_ENABLED", "1") not in ("0", "false", ""),
        "RATELIMIT_STORAGE_URI": storage,
        "RATELIMIT_DEFAULT": said("RATELIMIT_DEFAULT"),
        "RATELIMIT_STORAGE_OPTIONS": PATIENT if storage.startswith("redis") else {},
        # Where that store fails each process counts for itself; a request that fails with it while
        # another one finds that out goes through uncounted. Nobody is turned away for that.
        "RATELIMIT_IN_MEMORY_FALLBACK_ENABLED": True,
        "RATELIMIT_SWALLOW_ERRORS": True,
        "EMBED_ORIGINS": origins,
        "METRICS_BIND": said("METRICS_BIND"),
        "WORK_AT_ONCE": number("WORK_AT_ONCE"),
        "WORK_WAITING": number("WORK_WAITING"),
    }


def check_key(key: str, *, local: bool) -> None:
    """Refuse to sign with a key that others know or can guess.

    Raises
    ------
    RuntimeError
        Without a key; on a deployed site also with one that everybody knows, or a short one.
    """
    if not key:
        raise RuntimeError("SECRET_KEY must be set: it signs what shoppers' browsers keep")
    if local:
        return
    words = re.sub(r"[\W\d_]+", " ", key.lower()).strip()
    if words in KNOWN_KEYS or len(key) < LEAST_KEY:
        raise RuntimeError(
            f"SECRET_KEY has {len(key)} letters, and may be known to others: at least {LEAST_KEY} "
            "that nobody can guess are needed. Make one with: openssl rand -hex 32"
        )
