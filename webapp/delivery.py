"""How answers travel: compressed, and kept by browsers where nothing of a shopper is in them."""

import functools
import gzip
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import brotli
from flask import Flask, current_app, request, url_for
from flask_compress import Compress
from werkzeug.security import safe_join
from werkzeug.wrappers import Response

ROOT = Path(__file__).parent.parent

YEAR = 365 * 24 * 60 * 60
"""Seconds."""

ANSWERS = (
    "application/json",
    "application/problem+json",
    "model/gltf-binary",
    "text/csv",
    "text/html",
)
FILES = (
    "application/javascript",
    "application/json",
    "application/wasm",
    "image/svg+xml",
    "text/css",
    "text/javascript",
)
"""What becomes smaller by compression: of the site's answers, and of its static files."""

PIECE = re.compile(r"/build/[\w-]+-[0-9A-Z]{8}\.js$")
"""A piece of a page's script, named after its content by the build."""

LEAST = 500
"""Bytes: compressed, less than these is hardly smaller."""

LARGE = 2 * 2**20
"""Bytes of a static file on which the best compression would take seconds."""


def deliver(app: Flask) -> None:
    """Compress what the site answers, and fingerprint its static files."""
    app.config.from_mapping(
        COMPRESS_ALGORITHM=["zstd", "br", "gzip"],
        COMPRESS_MIMETYPES=ANSWERS,
        COMPRESS_STREAMS=False,
        COMPRESS_LEVEL=4,
        COMPRESS_ZSTD_LEVEL=6,
        COMPRESS_MIN_SIZE=LEAST,
    )
    Compress(app)
    app.after_request(compress_file)
    app.add_template_global(static_url)
    app.add_template_global(pieces)


def static_url(filename: str) -> str:
    """The address of a static file, with its fingerprint: it may be kept for a year."""
    file = ROOT / "static" / filename
    if not file.is_file():
        return url_for("static", filename=filename)
    return url_for("static", filename=filename, v=fingerprint(file, file.stat().st_mtime_ns))


def pieces(script: str) -> list[str]:
    """The addresses of what a built script imports at once, to be asked for beside it.

    A browser that learns of them from the script itself asks a round trip later.
    """
    listed = ROOT / "static" / "build" / "pieces.json"
    if not listed.is_file():  # without the front end there is no script either
        return []
    return [
        url_for("static", filename=piece)
        for piece in imports(listed, listed.stat().st_mtime_ns).get(script, ())
    ]


@functools.lru_cache(maxsize=1)
def imports(listed: Path, changed: int) -> Mapping[str, Sequence[str]]:  # noqa: ARG001 - as below
    """What the build says that each of its scripts imports."""
    found: Mapping[str, Sequence[str]] = json.loads(listed.read_text("utf-8"))
    return found


@functools.lru_cache
def fingerprint(file: Path, changed: int) -> str:  # noqa: ARG001 - what is kept is kept for it
    """A few letters that are others as soon as the file's content is; `changed` is its time."""
    return hashlib.sha256(file.read_bytes()).hexdigest()[:12]


def keep(response: Response) -> None:
    """Let browsers keep a static file for as long as its address says what is in it.

    While a new version is brought out, a page of it may ask a server of the old one: what that
    one lacks, or has otherwise, must not be kept under the new name.
    """
    filename = (request.view_args or {}).get("filename", "")
    given = request.args.get("v")
    if PIECE.search(request.path) or (given and static_url(filename).endswith(f"v={given}")):
        response.cache_control.max_age = YEAR
        response.cache_control.public = True
        response.cache_control.immutable = True
        response.cache_control.no_cache = None


def compress_file(response: Response) -> Response:
    """A static file, as small as it gets: each is compressed once by a process."""
    if request.endpoint != "static" or response.mimetype not in FILES:
        return response
    response.vary.add("Accept-Encoding")
    encoding = request.accept_encodings.best_match(("br", "gzip"))
    found = safe_join(str(current_app.static_folder), (request.view_args or {})["filename"])
    if response.status_code != 200 or encoding is None or found is None:
        return response
    file = Path(found)
    if file.stat().st_size < LEAST:
        return response
    response.close()
    response.direct_passthrough = False
    response.set_data(squeezed(file, file.stat().st_mtime_ns, encoding))
    response.content_encoding = encoding
    # The same file in another coat: to browsers that ask whether theirs is still good, it is.
    etag, _ = response.get_etag()
    if etag is not None:
        response.set_etag(etag, weak=True)
    return response


@functools.lru_cache
def squeezed(file: Path, changed: int, encoding: str) -> bytes:  # noqa: ARG001 - as above
    """A file's content, compressed."""
    content = file.read_bytes()
    large = len(content) > LARGE
    if encoding == "br":
        squeezed: bytes = brotli.compress(content, quality=5 if large else 10)
        return squeezed
    return gzip.compress(content, 6 if large else 9, mtime=0)
