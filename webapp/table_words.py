"""The table's words in the page's language: labels, definitions, how measurements are taken.

They stand in ``model/data/measurements.csv`` in English; the translations know them by that text.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from flask_babel import gettext
from flask_babel import lazy_gettext as _l

from model.measurements import MEASUREMENTS
from model.tape_pictures import (
    BACK,
    BACK_LEFT,
    FRONT,
    FRONT_ABOVE,
    FRONT_LEFT,
    LEFT,
    View,
    views_of,
)

_LABELS: Mapping[str, Any] = {"inseam_height": _l("Inside leg"), "neck_height": _l("Neck height")}
"""What a person knows as something else than the table says: of the inseam they are asked where it
ends, and there are two measurements of the neck."""

_ON_A_BODY: Mapping[str, Any] = {"inseam_height": _l("Inside leg to the ankle")}
"""What a person may have measured otherwise than it is measured on a body."""

_SEEN: Mapping[View, Any] = {
    FRONT: _l("from the front"),
    BACK: _l("from the back"),
    LEFT: _l("from the left"),
    FRONT_LEFT: _l("from the front left"),
    BACK_LEFT: _l("from the back left"),
    FRONT_ABOVE: _l("from the front, a little from above"),
}
_DRAWN: Mapping[str, Any] = {
    "girth": _l("Drawn as a tape on a body, seen %(views)s."),
    "length": _l("Drawn as a tape on a body, seen %(views)s."),
    "height": _l("Drawn as a line beside a body, seen %(views)s."),
    "mass": _l("Drawn as a person on a scale, seen %(views)s."),
}


@dataclass(frozen=True, slots=True)
class Alternative:
    """What a guide's picture shows beside the measurement: from where, and in how many views."""

    name: str

    @property
    def views(self) -> int:
        """How many views the picture has."""
        return len(views_of(self.name))

    @property
    def words(self) -> str:
        """What the picture shows, for those who do not see it, in the page's language."""
        seen = gettext(" and ").join(str(_SEEN[view]) for view in views_of(self.name))
        return str(_DRAWN[MEASUREMENTS[self.name].kind]) % {"views": seen}


ALTERNATIVES: Mapping[str, Alternative] = {name: Alternative(name) for name in MEASUREMENTS}


def labels() -> dict[str, str]:
    """What each measurement is called, in the page's language."""
    return {name: label(name) for name in MEASUREMENTS}


def label(name: str) -> str:
    """What a measurement is called, in the page's language."""
    return str(_LABELS[name]) if name in _LABELS else gettext(MEASUREMENTS[name].label)


def body_labels() -> dict[str, str]:
    """What each measurement of a body is called, in the page's language."""
    return {name: body_label(name) for name in MEASUREMENTS}


def body_label(name: str) -> str:
    """What a measurement of a body is called, in the page's language."""
    return str(_ON_A_BODY[name]) if name in _ON_A_BODY else label(name)


def definition(name: str) -> str:
    """From where to where a measurement goes, in the page's language."""
    return gettext(MEASUREMENTS[name].definition)


def how_to(name: str) -> str:
    """How a measurement is taken, in the page's language."""
    return gettext(MEASUREMENTS[name].how_to)
