"""The headers that every answer carries: what browsers may do with it, and who may frame it."""

from collections.abc import Mapping, Sequence

from flask import current_app, request
from werkzeug.wrappers import Response

CONTENT_SECURITY_POLICY: Mapping[str, str] = {
    "default-src": "'self'",
    "script-src": "'self'",
    "style-src": "'self'",
    "img-src": "'self' blob: data:",
    # The promise that nothing of a shopper goes elsewhere, kept by the browser.
    "connect-src": "'self'",
    "worker-src": "'self'",
    "form-action": "'self'",
    "object-src": "'none'",
    "base-uri": "'none'",
    "frame-ancestors": "'none'",
}

SECURITY_HEADERS: Mapping[str, str] = {
    "X-Content-Type-Options": "nosniff",
    # Forms over https are checked against the referrer, so our own pages must send one.
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=(), payment=(), usb=()",
}

HSTS = "max-age=31536000"

FILE_NAMES: Mapping[str, str] = {
    "application/json": "api.json",
    "application/problem+json": "api.json",
    "image/png": "api.png",
}
"""What the API's answers are called where a browser is led to one: it saves it, and opens nothing
that somebody else made up. A body has a name of its own."""

PHOTO_PAGE = "comparisons.page"
PHOTO_WORKER = "build/photos/worker.js"

EMBED_SCRIPT = "embed.js"
"""The one file that pages of other origins may load."""


def content_security_policy(*, photos: bool = False, ancestors: Sequence[str] = ()) -> str:
    """The policy of an answer.

    Parameters
    ----------
    photos : whether it looks at photos: what finds people in them is WebAssembly.
    ancestors : origins that may show it in a frame.
    """
    policy = dict(CONTENT_SECURITY_POLICY)
    if photos:
        policy["script-src"] += " 'wasm-unsafe-eval'"
    if ancestors:
        policy["frame-ancestors"] = " ".join(("'self'", *ancestors))
    return "; ".join(f"{what} {whence}" for what, whence in policy.items())


def secure(response: Response) -> Response:
    """Give an answer its security headers."""
    photos = _sees_photos()
    origins = current_app.config["EMBED_ORIGINS"]
    headers = response.headers
    policy = content_security_policy(photos=photos, ancestors=origins)
    headers.setdefault("Content-Security-Policy", policy)
    for name, value in SECURITY_HEADERS.items():
        headers.setdefault(name, value)
    saved_as = FILE_NAMES.get(response.mimetype or "")
    if saved_as and request.path.startswith("/api/"):
        headers.setdefault("Content-Disposition", f'attachment; filename="{saved_as}"')
    if photos:
        # The camera is asked for on this page alone, and used by nobody but us.
        everywhere = SECURITY_HEADERS["Permissions-Policy"]
        headers["Permissions-Policy"] = everywhere.replace("camera=()", "camera=(self)")
    if origins and (request.view_args or {}).get("filename") == EMBED_SCRIPT:
        headers["Cross-Origin-Resource-Policy"] = "cross-origin"
    if not current_app.config["FITTING_ROOM_LOCAL"]:
        headers.setdefault("Strict-Transport-Security", HSTS)
    return response


def _sees_photos() -> bool:
    """Whether the answer is the page that takes photos, or the worker that looks at them."""
    arguments = request.view_args or {}
    return request.endpoint == PHOTO_PAGE or arguments.get("filename") == PHOTO_WORKER
