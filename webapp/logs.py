"""Logs as lines of JSON on standard output, with nothing of a shopper in them.

No address of a shopper, no query string, no body, no header; of an error where it happened and of
what kind it was, for its words may hold what somebody entered.
"""

import json
import logging
import re
import secrets
import traceback
from datetime import UTC, datetime
from typing import Any

from flask import Flask, g, has_request_context, request
from werkzeug.wrappers import Response

from webapp import metrics

LOG = logging.getLogger("fitting_room")

_QUERY = re.compile(r"\?\S*")
_ADDRESS = re.compile(r"(?:\d{1,3}\.){3}\d{1,3}|[\da-f]*:[\da-f]*:[\da-f:.]*", re.IGNORECASE)


class JsonLines(logging.Formatter):
    """One JSON object a line: time, level, logger, message, and what was said beside it."""

    def format(self, record: logging.LogRecord) -> str:
        """The line of a record."""
        line: dict[str, Any] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        if record.name.startswith("gunicorn") and record.levelno > logging.INFO:
            # What the server says of a request may hold an address, or what stands behind a
            # question mark; what it says of itself does not.
            line["message"] = _ADDRESS.sub("-", _QUERY.sub("", line["message"]))
        if has_request_context() and "request_id" in g:
            line["request"] = g.request_id
        line |= getattr(record, "fields", {})
        if record.exc_info and record.exc_info[0] is not None:
            line["error"] = told(record.exc_info[1])
        return json.dumps(line, ensure_ascii=False)


def told(error: BaseException | None) -> list[str]:
    """Where an error happened and what kind it was, the innermost last, without its words."""
    lines: list[str] = []
    while error is not None:
        frames = [
            f"{frame.filename}:{frame.lineno} {frame.name}"
            for frame in traceback.extract_tb(error.__traceback__)
        ]
        lines[:0] = [*frames, type(error).__name__]
        error = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    return lines


def set_up(app: Flask) -> None:
    """Log every request when it is answered. Call it before others prepare requests."""

    @app.before_request
    def name() -> None:
        g.request_id = secrets.token_hex(6)

    @app.after_request
    def tell(response: Response) -> Response:
        level = logging.ERROR if response.status_code >= 500 else logging.INFO
        if response.status_code == 503:
            level = logging.WARNING
        LOG.log(
            level,
            "answered",
            extra={
                "fields": {
                    "method": request.method if request.method in metrics.METHODS else "other",
                    # As the site knows it; an unknown address may hold anything.
                    "route": request.url_rule.rule if request.url_rule else None,
                    "status": response.status_code,
                    "ms": round(1000 * metrics.seconds(), 1),
                    "bytes": response.calculate_content_length(),
                }
            },
        )
        return response
