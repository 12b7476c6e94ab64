"""The Fitting Room's site: reads requests, calls the model, writes responses."""

import contextlib
import io
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from flask import Flask, render_template, request
from flask.json.provider import DefaultJSONProvider
from flask_limiter import RateLimitExceeded
from flask_wtf import CSRFProtect
from werkzeug.exceptions import (
    BadHost,
    BadRequest,
    HTTPException,
    SecurityError,
    ServiceUnavailable,
)
from werkzeug.middleware.proxy_fix import ProxyFix
from werkzeug.wrappers import Response

from model.checksums import check_sums
from model.estimators import Estimator, load_estimators
from model.measurements import BodyKind
from model.rig import rig_of
from model.studio import RenderingTimedOut, RenderingUnavailable
from model.template_mesh import DATA
from webapp import (
    api,
    avatars,
    comparisons,
    delivery,
    health,
    language,
    limiting,
    logs,
    metrics,
    mirror,
    overload,
    preview,
    sheet,
    uploads,
    wizard,
)
from webapp.forms import Refused
from webapp.headers import secure
from webapp.sessions import ClockProofSessions
from webapp.settings import check_key, environment

if TYPE_CHECKING:
    from _typeshed.wsgi import StartResponse, WSGIApplication, WSGIEnvironment

ROOT = Path(__file__).parent.parent

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
        """Always: what is read from says where it ends."""
        return True

    def readinto(self, buffer: bytearray) -> int:  # type: ignore[override]
        """Read on, and answer how many bytes; a broken body is a bad request."""
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
        If there is no secret key, or one that is no secret and the site is not said to be local.
    FileNotFoundError, ValueError
        If a file of the estimators is missing or damaged; the message names it.
    """
    app = Flask(__name__, template_folder=ROOT / "templates", static_folder=ROOT / "static")
    app.config.update(environment(os.environ))
    app.config.update(settings or {})
    check_key(app.config["SECRET_KEY"], local=app.config["FITTING_ROOM_LOCAL"])
    app.session_interface = ClockProofSessions()
    app.jinja_options = {"trim_blocks": True, "lstrip_blocks": True}
    if app.config["TRUSTED_PROXIES"]:
        hops = app.config["TRUSTED_PROXIES"]
        app.wsgi_app = ProxyFix(  # type: ignore[method-assign]
            app.wsgi_app, x_for=hops, x_proto=hops, x_host=hops
        )

    app.wsgi_app = careful_reading(app.wsgi_app)  # type: ignore[method-assign, assignment]
    if app.config["METRICS_BIND"]:
        app.wsgi_app = metrics.beside(  # type: ignore[method-assign, assignment]
            app.wsgi_app, app.config["METRICS_BIND"]
        )
    app.json = InTheirOrder(app)
    language.set_up(app)
    logs.set_up(app)
    metrics.set_up(app)

    app.extensions["estimators"] = load(Path(app.config["FITTING_ROOM_DATA"]))
    app.request_class = uploads.InMemory
    app.before_request(uploads.make_room)  # Before the token of a form is looked for.
    csrf = CSRFProtect(app)
    csrf.exempt(api.bp)
    limiting.set_up(app)
    overload.set_up(app)
    for blueprint in (
        health.bp,
        language.bp,
        wizard.bp,
        avatars.bp,
        mirror.bp,
        preview.bp,
        sheet.bp,
        comparisons.bp,
        api.bp,
    ):
        app.register_blueprint(blueprint)

    delivery.deliver(app)
    app.register_error_handler(HTTPException, failed)
    app.register_error_handler(RateLimitExceeded, too_many)
    app.register_error_handler(Refused, api.refused)
    app.register_error_handler(RenderingUnavailable, no_picture)
    app.after_request(add_headers)
    app.after_request(hear_out)
    return app


def load(folder: Path) -> Mapping[BodyKind, Estimator]:
    """All that bodies are made of, whole or not at all: before a server's processes part, so that
    they share it.

    Raises
    ------
    FileNotFoundError, ValueError
        If a file is missing or damaged; the message names it.
    """
    estimators = load_estimators(folder)
    if folder != DATA:
        check_sums(DATA)  # A body on the shipped mesh has the shipped rig.
    rig_of(estimators["neutral"].template)
    return estimators


def failed(error: HTTPException) -> Response:
    """An error as a page, or as a problem for callers of the API."""
    if request.path.startswith("/api/"):
        return api.problem(error)
    if isinstance(error, BadHost | SecurityError):
        # Our pages have addresses in them, which such a host has not.
        return Response("There is no such host.\n", error.code, mimetype="text/plain")
    response = error.get_response()
    busy = isinstance(error, overload.Overloaded)
    response.set_data(render_template("error.html", code="busy" if busy else error.code or 500))
    return response


def too_many(error: RateLimitExceeded) -> Response:
    """Too many requests: come again when the limit's time is over."""
    response = failed(error)
    response.headers["Retry-After"] = str(error.limit.limit.get_expiry())
    return response


def no_picture(error: RenderingUnavailable) -> Response:
    """What is asked for needs a picture, and this machine cannot draw."""
    again = overload.COME_AGAIN if isinstance(error, RenderingTimedOut) else None
    words = f"Pictures cannot be drawn on this server: {error}"
    return failed(ServiceUnavailable(words, retry_after=again))


def careful_reading(wsgi_app: "WSGIApplication") -> "WSGIApplication":
    """The same application, which reads requests' bodies as `CarefulInput`."""

    def careful(environ: "WSGIEnvironment", start_response: "StartResponse") -> Iterable[bytes]:
        environ["wsgi.input"] = CarefulInput(environ["wsgi.input"])
        return wsgi_app(environ, start_response)

    return careful


def hear_out(response: Response) -> Response:
    """Read what a refused request still sends: who is cut off while sending hears no answer."""
    if response.status_code >= 400 and "wsgi.input_terminated" in request.environ:
        overload.leave()  # Who sends slowly keeps nobody waiting.
        left = HEARD_OUT
        with contextlib.suppress(BadRequest):
            while left > 0 and (content := request.environ["wsgi.input"].read(PIECE)):
                left -= len(content)
    return response


def add_headers(response: Response) -> Response:
    """Security for every response; only the site's own files may be kept."""
    secure(response)
    if request.endpoint == "static" and response.status_code < 400:
        delivery.keep(response)
    else:
        response.cache_control.no_store = True
    return response
