"""The Fitting Room's site: reads requests, calls the model, writes responses."""

import contextlib
import io
import os
import secrets
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from flask import Flask, jsonify, render_template, request
from flask.json.provider import DefaultJSONProvider
from flask_limiter import Limiter, RateLimitExceeded
from flask_limiter.util import get_remote_address
from flask_wtf import CSRFProtect
from werkzeug.exceptions import BadRequest, HTTPException, ServiceUnavailable
from werkzeug.middleware.proxy_fix import ProxyFix
from werkzeug.wrappers import Response

from model.estimators import load_estimators
from model.rendering import RenderingUnavailable
from model.template_mesh import DATA
from webapp import api, avatars, comparisons, delivery, language, units, wizard
from webapp.forms import Refused

if TYPE_CHECKING:
    from _typeshed.wsgi import StartResponse, WSGIApplication, WSGIEnvironment

ROOT = Path(__file__).parent.parent

CONTENT_SECURITY_POLICY = {
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
SECURITY_HEADERS = {
    "Content-Security-Policy": "; ".join(
        f"{what} {whence}" for what, whence in CONTENT_SECURITY_POLICY.items()
    ),
    "X-Content-Type-Options": "nosniff",
    # Forms over https are checked against the referrer, so our own pages must send one.
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=(), payment=(), usb=()",
}

PHOTO_HEADERS = {
    # What finds people in photos is WebAssembly, and it asks for the camera: where it runs alone.
    "Content-Security-Policy": SECURITY_HEADERS["Content-Security-Policy"].replace(
        "script-src 'self'", "script-src 'self' 'wasm-unsafe-eval'"
    ),
    "Permissions-Policy": SECURITY_HEADERS["Permissions-Policy"].replace(
        "camera=()", "camera=(self)"
    ),
}
PHOTO_PAGE = "comparisons.page"
PHOTO_WORKER = "build/photos/worker.js"

HEARD_OUT = 64 * 2**20
PIECE = 2**16
"""Bytes that are read, and let go, of a request that is refused for its size or its type."""


class CarefulInput(io.RawIOBase):
    """A request's body, of which a part that cannot be read is the sender's fault.

    Servers tell broken chunks and lost connections by exceptions of their own.
    """

    def __init__(self, given: IO[bytes]) -> None:
        super().__init__()
        self.given = given

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: bytearray) -> int:  # type: ignore[override]
        try:
            content = self.given.read(len(buffer))
        except Exception as error:
            raise BadRequest("The request's body is broken.") from error
        buffer[: len(content)] = content
        return len(content)


class InTheirOrder(DefaultJSONProvider):
    """JSON whose members stay in the order in which they are made."""

    sort_keys = False


def create_app(settings: Mapping[str, Any] | None = None) -> Flask:
    """The site, ready to serve.

    Parameters
    ----------
    settings : mapping, optional
        Flask's settings, which go before those of the environment.

    Raises
    ------
    RuntimeError
        If there is no secret key and the site is not said to be local.
    """
    app = Flask(__name__, template_folder=ROOT / "templates", static_folder=ROOT / "static")
    app.config.update(environment(os.environ))
    app.config.update(settings or {})
    if not app.config["SECRET_KEY"]:
        raise RuntimeError("SECRET_KEY must be set: it signs what shoppers' browsers keep")
    app.jinja_options = {"trim_blocks": True, "lstrip_blocks": True}
    if app.config["TRUSTED_PROXIES"]:
        hops = app.config["TRUSTED_PROXIES"]
        app.wsgi_app = ProxyFix(  # type: ignore[method-assign]
            app.wsgi_app, x_for=hops, x_proto=hops, x_host=hops
        )

    app.wsgi_app = careful_reading(app.wsgi_app)  # type: ignore[method-assign, assignment]
    app.json = InTheirOrder(app)
    language.set_up(app)

    app.extensions["estimators"] = load_estimators(Path(app.config["FITTING_ROOM_DATA"]))
    app.request_class = comparisons.InMemory
    app.before_request(comparisons.make_room)  # Before the token of a form is looked for.
    csrf = CSRFProtect(app)
    csrf.exempt(api.bp)
    limiter = Limiter(get_remote_address, app=app)
    for blueprint in (wizard.bp, avatars.bp, comparisons.bp, api.bp):
        app.register_blueprint(blueprint)
    app.add_url_rule("/healthz", view_func=limiter.exempt(health))

    app.add_template_filter(units.show)
    app.add_template_filter(units.show_signed)
    delivery.deliver(app)
    app.register_error_handler(HTTPException, failed)
    app.register_error_handler(RateLimitExceeded, too_many)
    app.register_error_handler(Refused, api.refused)
    app.register_error_handler(RenderingUnavailable, no_picture)
    app.after_request(add_headers)
    app.after_request(hear_out)
    return app


def environment(variables: Mapping[str, str]) -> dict[str, Any]:
    """Flask's settings from the environment's variables.

    SECRET_KEY signs the session. FITTING_ROOM_LOCAL=1 is for a server on one's own machine, without
    https: cookies travel without it, and a key is made up where there is none. TRUSTED_PROXIES
    counts the proxies in front. FITTING_ROOM_DATA is a folder of estimators with their template, in
    place of the shipped ones. Variables of Flask-Limiter are named as it names its settings.
    """
    local = variables.get("FITTING_ROOM_LOCAL", "0") == "1"
    return {
        "SECRET_KEY": variables.get("SECRET_KEY") or (secrets.token_hex(32) if local else ""),
        "SESSION_COOKIE_NAME": "fitting_room",
        "SESSION_COOKIE_HTTPONLY": True,
        "SESSION_COOKIE_SAMESITE": "Lax",
        "SESSION_COOKIE_SECURE": not local,
        # The token lives as long as the session: a form may stay open while one looks for a tape.
        "WTF_CSRF_TIME_LIMIT": None,
        "FITTING_ROOM_DATA": variables.get("FITTING_ROOM_DATA") or DATA,
        "MAX_CONTENT_LENGTH": 64 * 1024,
        "TRUSTED_PROXIES": int(variables.get("TRUSTED_PROXIES") or 0),
        "RATELIMIT_ENABLED": variables.get("RATELIMIT_ENABLED", "1") not in ("0", "false", ""),
        "RATELIMIT_STORAGE_URI": variables.get("RATELIMIT_STORAGE_URI") or "memory://",
        "RATELIMIT_DEFAULT": variables.get("RATELIMIT_DEFAULT") or "600 per minute",
    }


def health() -> Response:
    """Says that the estimators are loaded: without them the site does not start."""
    return jsonify(status="ok")


def failed(error: HTTPException) -> Response:
    """An error as a page, or as a problem for callers of the API."""
    if request.path.startswith("/api/"):
        return api.problem(error)
    response = error.get_response()
    response.set_data(render_template("error.html", code=error.code or 500))
    return response


def too_many(error: RateLimitExceeded) -> Response:
    """Too many requests: come again when the limit's time is over."""
    response = failed(error)
    response.headers["Retry-After"] = str(error.limit.limit.get_expiry())
    return response


def no_picture(error: RenderingUnavailable) -> Response:
    """What is asked for needs a picture, and this machine cannot draw."""
    return failed(ServiceUnavailable(f"Pictures cannot be drawn on this server: {error}"))


def careful_reading(wsgi_app: "WSGIApplication") -> "WSGIApplication":
    """The same application, which reads requests' bodies as `CarefulInput`."""

    def careful(environ: "WSGIEnvironment", start_response: "StartResponse") -> Iterable[bytes]:
        environ["wsgi.input"] = CarefulInput(environ["wsgi.input"])
        return wsgi_app(environ, start_response)

    return careful


def hear_out(response: Response) -> Response:
    """Read what a refused request still sends: who is cut off while sending hears no answer."""
    if response.status_code >= 400 and "wsgi.input_terminated" in request.environ:
        left = HEARD_OUT
        with contextlib.suppress(BadRequest):
            while left > 0 and (content := request.environ["wsgi.input"].read(PIECE)):
                left -= len(content)
    return response


def add_headers(response: Response) -> Response:
    """Security for every response; caching for what may be kept and only that."""
    for name, value in (SECURITY_HEADERS | (PHOTO_HEADERS if _sees_photos() else {})).items():
        response.headers.setdefault(name, value)
    if request.endpoint == "static":
        delivery.keep(response)
    elif request.method == "GET" and request.blueprint == "wizard":
        # Kept by the browser alone, so that going back shows what was typed.
        response.cache_control.private = True
        response.cache_control.no_cache = True
    else:
        response.cache_control.no_store = True
    return response


def _sees_photos() -> bool:
    """Whether the answer is the page that takes photos, or the worker that looks at them."""
    arguments = request.view_args or {}
    return request.endpoint == PHOTO_PAGE or arguments.get("filename") == PHOTO_WORKER
