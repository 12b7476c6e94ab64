"""Tapes: the ways to take a measurement on a body.

A girth is what a taut tape reads (:mod:`model.girths`). A length is a geodesic over the
skin, within a few strips that serve a whole population. Heights are vertical distances.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Protocol

import numpy as np

from model import geometry
from model.geodesics import Bundle, Way, length_gradient
from model.geometry import Floats
from model.template_mesh import UP, Gradient, Landmarks, TemplateMesh

BODY_DENSITY = 1000.0
"""Mass over volume of the closed body, lungs included, in kg/m³.

Siri (1961, *Body composition from fluid spaces and density*): fat 900 and lean 1,100 kg/m³,
so 1,042 at a quarter of fat. Some 3.3 litres of air in the chest (thoracic gas volume, about
that of McCrory et al. 1998, *J. Appl. Physiol.* 84) make that 996 in a body of 75 kg. By the
same reckoning it is 1,024 for 70 kg with a tenth of fat, and 973 for 120 kg with 45 %.
"""

Legs = tuple[tuple[str, str], ...]
"""Ways from one landmark to another."""


class Tape(Protocol):
    """How one measurement is taken."""

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        """Values of a batch: vertices of shape (B, V, 3) in metres; returns (B,), SI."""
        ...

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The value of one body, vertices of shape (V, 3), and where the tape runs: (n, 3)."""
        ...

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        """The value of one body, vertices of shape (V, 3), and its derivative by them."""
        ...


@dataclass(frozen=True)
class Geodesic:
    """The shortest way over the skin through landmarks, in the template's strips.

    Attributes
    ----------
    through : the landmarks, in order.
    """

    through: Landmarks

    def legs(self) -> Legs:
        """The ways from each landmark to the next."""
        return tuple(pairwise(self.through))

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        """The lengths of a batch's ways: (B,), metres."""
        return bundle(template, self.legs()).lengths(vertices).sum(axis=1)

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The length, metres, and its path over the skin, an open polyline: (n, 3)."""
        ways = [way for _, way in bundle(template, self.legs()).ways(vertices)]
        return sum(way.length for way in ways), self.path(ways)

    def path(self, ways: Sequence[Way]) -> Floats:
        """The ways of all legs as one: (n, 3)."""
        return np.concatenate([way.points for way in ways])

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        """The length and its derivative, a `Gradient`, along the way as it runs just now."""
        ways = bundle(template, self.legs()).ways(vertices)
        slopes = [length_gradient(strip, way) for strip, way in ways]
        indices, gradient = (np.concatenate(piece) for piece in zip(*slopes, strict=True))
        return sum(way.length for _, way in ways), (indices, gradient)


@dataclass(frozen=True)
class Loop(Geodesic):
    """A way over the skin through landmarks and back to the first of them.

    A tape that lies in a hollow, as in the armpit, is no hull of a plane section: which skin
    such a section ends with would change from one moment to the next.
    """

    def legs(self) -> Legs:
        """The ways from each landmark to the next, and from the last to the first."""
        return tuple(pairwise((*self.through, self.through[0])))

    def path(self, ways: Sequence[Way]) -> Floats:
        """The ways of all legs as one closed loop, whose first point is not repeated: (n, 3)."""
        return super().path(ways)[:-1]


@dataclass(frozen=True)
class Height:
    """A vertical distance between the mean points of landmarks, or from the soles.

    Attributes
    ----------
    top : landmarks; empty means the highest point of the body.
    bottom : landmarks; empty means the soles.
    """

    top: Landmarks = ()
    bottom: Landmarks = ()

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        """The heights of a batch: (B,), metres."""
        return self._ends(template, vertices, 0)[:, 1] - self._ends(template, vertices, 1)[:, 1]

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The height, metres, and a vertical line through its upper end: (2, 3)."""
        top, bottom = (self._ends(template, vertices[None], end)[0] for end in (0, 1))
        return float(top[1] - bottom[1]), np.array([top, [top[0], bottom[1], top[2]]])

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        """The height and its derivative, a `Gradient`, which only the two ends have."""
        pieces = []
        for end, sign in ((0, 1.0), (1, -1.0)):
            names = (self.top, self.bottom)[end]
            if names:
                indices, weights = template.landmark_weights(*names)
            else:
                extreme = vertices[:, 1].argmin() if end else vertices[:, 1].argmax()
                indices, weights = np.array([extreme]), np.ones(1)
            pieces.append((indices, sign * weights[:, None] * UP))
        indices, slopes = (np.concatenate(piece) for piece in zip(*pieces, strict=True))
        return float(self.read(template, vertices[None])[0]), (indices, slopes)

    def _ends(self, template: TemplateMesh, vertices: Floats, end: int) -> Floats:
        names = (self.top, self.bottom)[end]
        if names:
            return template.landmark_points(vertices, *names)
        heights = vertices[..., 1]
        extreme = heights.argmin(axis=1) if end else heights.argmax(axis=1)
        return vertices[np.arange(len(vertices)), extreme]


@dataclass(frozen=True)
class Span:
    """The straight distance between two landmarks."""

    start: str
    stop: str

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        """The distances of a batch: (B,), metres."""
        return np.linalg.norm(self._between(template, vertices), axis=-1)

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The distance, metres, and its two ends: (2, 3)."""
        ends = np.array(
            [template.landmark_points(vertices, end) for end in (self.start, self.stop)]
        )
        return float(np.linalg.norm(ends[1] - ends[0])), ends

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        """The distance and its derivative, a `Gradient`, along the line between the ends."""
        between = self._between(template, vertices)
        length = float(np.linalg.norm(between))
        start, start_weights = template.landmark_weights(self.start)
        stop, stop_weights = template.landmark_weights(self.stop)
        weights = np.concatenate([-start_weights, stop_weights])
        return length, (np.concatenate([start, stop]), weights[:, None] * between / length)

    def _between(self, template: TemplateMesh, vertices: Floats) -> Floats:
        start = template.landmark_points(vertices, self.start)
        return template.landmark_points(vertices, self.stop) - start


@dataclass(frozen=True)
class Mass:
    """Volume of the closed body times `BODY_DENSITY`."""

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        """The masses of a batch: (B,), kilograms."""
        return BODY_DENSITY * geometry.volume(vertices, template.faces)

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The mass; a scale has no tape, so the path is empty, of shape (0, 3)."""
        return float(self.read(template, vertices[None])[0]), np.zeros((0, 3))

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        """The mass and its derivative, a `Gradient`: the density times that of the volume."""
        slopes = BODY_DENSITY * geometry.volume_gradient(vertices, template.faces)
        # Volume grows with the third power of size: its slope along the body is three times it.
        mass = float(np.vdot(slopes, vertices)) / 3
        return mass, (np.arange(len(vertices)), slopes)


def legs_of(tapes: Iterable[Tape]) -> Legs:
    """The legs of all geodesics among some tapes, each once."""
    geodesics = [tape for tape in tapes if isinstance(tape, Geodesic)]
    return tuple(dict.fromkeys(leg for tape in geodesics for leg in tape.legs()))


@lru_cache(maxsize=64)
def bundle(template: TemplateMesh, legs: Legs) -> Bundle:
    """The strips of several legs, unfolded together.

    Raises
    ------
    ValueError
        For a leg that the template has no strip for.
    """
    missing = [leg for leg in legs if leg not in template.strips]
    if missing:
        raise ValueError(f"the template has no strip from {missing[0][0]} to {missing[0][1]}")
    return Bundle([template.strips[leg] for leg in legs])
