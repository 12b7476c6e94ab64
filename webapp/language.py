"""Languages: English, which the texts are written in, and Portuguese.

Pages follow the person's choice, then what their browser prefers. The interface for programs speaks
English. Texts are found by ``make words``, which also compiles the translations.
"""

from collections.abc import Callable, Mapping
from typing import Any
from urllib.parse import urlsplit

from babel.numbers import get_decimal_symbol
from flask import Blueprint, Flask, Response, redirect, request, session
from flask_babel import Babel, get_locale
from werkzeug.wrappers import Response as AnyResponse

from webapp import units

LANGUAGES: Mapping[str, str] = {"en": "English", "pt": "Português"}
"""Each language's own name for itself."""

TAGS: Mapping[str, str] = {"en": "en-GB", "pt": "pt-PT"}
"""What a page says of its language."""

bp = Blueprint("language", __name__)


@bp.post("/language")
def speak() -> AnyResponse:
    """Another language, for a page without a form of its own."""
    speaks()
    # Browsers read a backslash there as a slash.
    parts = urlsplit(request.form.get("page", "").replace("\\", "/"))
    ours = not parts.netloc and parts.path.startswith("/") and not parts.path.startswith("//")
    return redirect(parts.path if ours else "/", 303)


def speaks() -> bool:
    """Whether the posted form asks for another language, which is kept."""
    chosen = request.form.get("language")
    if chosen in LANGUAGES:
        session["language"] = chosen
        return True
    return False


def choose() -> str:
    """The language of the answer to this request."""
    if request.path.startswith("/api/"):
        return "en"
    chosen = session.get("language")
    if chosen in LANGUAGES:
        return str(chosen)
    return request.accept_languages.best_match(list(LANGUAGES)) or "en"


def usual_units() -> units.Units:
    """Inches and pounds for a browser of the United States, centimetres everywhere else."""
    return "imperial" if (request.accept_languages.best or "").upper().endswith("-US") else "metric"


def language() -> str:
    """The language of this page."""
    return str(get_locale() or "en")


def decimal_sign() -> str:
    """What stands before the decimals in the page's language."""
    return get_decimal_symbol(get_locale() or "en")


def decimal(text: str) -> str:
    """A number, written with a point, as the page's language writes it."""
    return text.replace(".", decimal_sign())


def set_up(app: Flask) -> None:
    """Texts in the language of each request."""
    Babel(app, default_translation_directories="translations", locale_selector=choose)
    app.jinja_env.globals |= {
        "languages": LANGUAGES,
        "language": language,
        "language_tag": lambda: TAGS[language()],
        "decimal_sign": decimal_sign,
    }
    app.add_template_filter(decimal)
    for written in (units.show, units.show_signed):
        app.add_template_filter(_localised(written), written.__name__)
    app.after_request(_told)


def _localised(written: Callable[..., str]) -> Callable[..., str]:
    """The same writer of numbers, in the page's language."""

    def write(*values: Any, **choices: Any) -> str:
        return decimal(written(*values, **choices))

    return write


def _told(response: Response) -> Response:
    """Pages say which language they are in, and what that depends on."""
    if response.mimetype == "text/html":
        response.headers["Content-Language"] = TAGS[language()]
        response.vary.update(["Accept-Language", "Cookie"])
    return response
