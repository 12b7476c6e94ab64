"""Tapes: the ways to take a measurement on a body.

A girth is what a taut tape reads: the perimeter of the convex hull of the plane section of
that body part. Where a definition says widest or narrowest, planes are tried at fixed
steps of a stated span between landmarks: the largest or smallest of values that each move
smoothly with the body moves continuously too, even where two places compete. A length is a
geodesic over the skin, within a few strips that serve a whole population. Heights are
vertical distances.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, Protocol

import numpy as np

from model import geometry
from model.geodesics import Bundle, length_gradient
from model.geometry import Floats, Integers
from model.template_mesh import TemplateMesh

BODY_DENSITY = 1000.0
"""Mass over volume of the closed body, lungs included, in kg/m³.

Siri (1961, *Body composition from fluid spaces and density*): fat 900 and lean 1,100 kg/m³,
so 1,042 at a quarter of fat. Some 3.3 litres of air in the chest (thoracic gas volume, about
that of McCrory et al. 1998, *J. Appl. Physiol.* 84) make that 996 in a body of 75 kg. By the
same reckoning it is 1,024 for 70 kg with a tenth of fat, and 973 for 120 kg with 45 %.
"""

UP = np.array([0.0, 1.0, 0.0])
LEFT = np.array([1.0, 0.0, 0.0])
FORWARD = np.array([0.0, 0.0, 1.0])

ON_PLANE = 1e-9
"""A vertex nearer to a plane than this lies on it, in metres."""

Landmarks = tuple[str, ...]
Legs = tuple[tuple[str, str], ...]
"""Ways from one landmark to another."""

Gradient = tuple[Integers, Floats]
"""Vertex indices (n,) and the derivative by each (n, 3); repeated indices add up."""


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
class Girth:
    """A taut tape around a body part.

    Attributes
    ----------
    parts : the parts that are cut; of others the tape knows nothing.
    start, stop : the mean points of these landmarks span the axis along which planes lie.
    span : from where to where planes are tried, as fractions of the way from start to stop.
    pick : which of the planes counts.
    cut : how planes lie: level; across, perpendicular to the axis; slanted, along the line
        from the first landmarks of start and stop (at the back) to the last (in front); or
        along, one plane through start and stop, from front to back, of which the tape goes
        around what lies beyond the start.
    planes : how many are tried.
    reach : how far beyond the span edges may be met, in metres on the template. The skin of a
        part lies at other heights, between the same landmarks, on other bodies.
    """

    parts: tuple[str, ...]
    start: Landmarks
    stop: Landmarks
    span: tuple[float, float] = (0.0, 0.0)
    pick: Literal["widest", "narrowest"] = "widest"
    cut: Literal["level", "across", "slanted", "along"] = "level"
    planes: int = 1
    reach: float = 0.15

    def fractions(self) -> Floats:
        """Where planes are tried, as shares of the way from start to stop: (planes,)."""
        return np.linspace(*self.span, self.planes)

    def sections(
        self, template: TemplateMesh, vertices: Floats
    ) -> tuple[geometry.Sections, Floats]:
        """The section by every plane, and each body's normal.

        Parameters
        ----------
        vertices : ndarray of shape (B, V, 3), metres.

        Returns
        -------
        sections : rows run over bodies, then planes; edges are those of :meth:`edges`.
        normals : ndarray of shape (B, 3).
        """
        indices, edges = self.edges(template)
        start = template.landmark_points(vertices, *self.start)
        axis = template.landmark_points(vertices, *self.stop) - start
        normals = self._normals(template, vertices)
        part = vertices[:, indices]
        stations = np.einsum("bni,bi->bn", part - start[:, None], normals)
        if self.cut != "along":
            stations /= np.einsum("bi,bi->b", axis, normals)[:, None]
        return geometry.sections(part, edges, stations, self.fractions()), normals

    def edges(self, template: TemplateMesh) -> tuple[Integers, Integers]:
        """The edges that the tape may meet, and their vertices.

        Returns
        -------
        indices : ndarray of shape (n,), the vertices.
        edges : ndarray of shape (E, 2), places in `indices`.
        """
        return _edges(template, self)

    def _normals(self, template: TemplateMesh, vertices: Floats) -> Floats:
        """The unit normal of each body's planes: (B, 3)."""
        if self.cut == "level":
            return np.broadcast_to(UP, (len(vertices), 3))
        tail, head = (template.landmark_points(vertices, *ends) for ends in self._tilting())
        directions = self._across(head - tail)
        return directions / np.linalg.norm(directions, axis=1, keepdims=True)

    def _tilting(self) -> tuple[Landmarks, Landmarks]:
        """The landmarks between which the line runs that tilts the planes."""
        if self.cut == "slanted":
            return (self.start[0], self.stop[0]), (self.start[-1], self.stop[-1])
        return self.start, self.stop

    def _across(self, line: Floats) -> Floats:
        """The planes' direction from that line, not of unit length: (..., 3)."""
        if self.cut == "along":
            return np.cross(line, FORWARD)
        return np.cross(line, LEFT) if self.cut == "slanted" else line

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        tied, rows = tie(template, vertices, [self])
        return tied.perimeters[rows[:, 0]]

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The girth and its closed loop, whose first point is not repeated."""
        tied, rows = tie(template, vertices[None], [self])
        return float(tied.perimeters[rows[0, 0]]), tied.loop(int(rows[0, 0]))

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        cut, normals = self.sections(template, vertices[None])
        tied = geometry.hulls(cut, np.repeat(normals, self.planes, axis=0))
        row = int(self.chosen(tied.perimeters[None])[0])
        part, edges = self.edges(template)
        fraction, normal = self.fractions()[row], normals[0]
        start, stop = (
            template.landmark_points(vertices, *ends) for ends in (self.start, self.stop)
        )
        origin = start + fraction * (stop - start)
        slopes = geometry.perimeter_gradient(tied, row, vertices[part], edges, origin, normal)
        pieces = [(part[slopes.indices], slopes.by_vertex)]
        for names, by_mean in (
            (self.start, (1 - fraction) * slopes.by_origin),
            (self.stop, fraction * slopes.by_origin),
            *self._tilt(template, vertices, normal, slopes.by_normal),
        ):
            indices, weights = template.landmark_weights(*names)
            pieces.append((indices, weights[:, None] * by_mean))
        indices, gradient = (np.concatenate(piece) for piece in zip(*pieces, strict=True))
        return float(tied.perimeters[row]), (indices, gradient)

    def _tilt(
        self, template: TemplateMesh, vertices: Floats, normal: Floats, by_normal: Floats
    ) -> list[tuple[Landmarks, Floats]]:
        """The derivative by the landmarks that tilt the plane."""
        if self.cut == "level":
            return []
        tail, head = self._tilting()
        start, stop = (template.landmark_points(vertices, *ends) for ends in (tail, head))
        direction = self._across(stop - start)
        by_direction = (by_normal - normal * (normal @ by_normal)) / np.linalg.norm(direction)
        if self.cut == "along":
            by_direction = np.cross(FORWARD, by_direction)
        elif self.cut == "slanted":
            by_direction = np.cross(LEFT, by_direction)
        return [(tail, -by_direction), (head, by_direction)]

    def chosen(self, girths: Floats) -> Integers:
        """Which plane counts, given the girth at each: (..., planes) to (...)."""
        return girths.argmax(axis=-1) if self.pick == "widest" else girths.argmin(axis=-1)


def tie(
    template: TemplateMesh, vertices: Floats, girths: Sequence[Girth]
) -> tuple[geometry.Hulls, Integers]:
    """Ties several tapes around many bodies at once.

    Parameters
    ----------
    vertices : ndarray of shape (B, V, 3), metres.

    Returns
    -------
    hulls : of every plane of every tape.
    rows : ndarray of shape (B, number of girths), the hull that counts.
    """
    cuts, normals = zip(*(girth.sections(template, vertices) for girth in girths), strict=True)
    counts = [len(vertices) * girth.planes for girth in girths]
    firsts = np.cumsum([0, *counts])
    tied = geometry.hulls(
        geometry.Sections(
            points=np.concatenate([cut.points for cut in cuts]),
            rows=np.concatenate(
                [cut.rows + first for cut, first in zip(cuts, firsts, strict=False)]
            ),
            edges=np.concatenate([cut.edges for cut in cuts]),
            fractions=np.concatenate([cut.fractions for cut in cuts]),
        ),
        np.concatenate(
            [np.repeat(n, girth.planes, axis=0) for n, girth in zip(normals, girths, strict=True)]
        ),
    )
    rows = np.empty((len(vertices), len(girths)), dtype=np.int64)
    bodies = np.arange(len(vertices))
    for column, girth in enumerate(girths):
        own = tied.perimeters[firsts[column] : firsts[column + 1]].reshape(len(vertices), -1)
        rows[:, column] = firsts[column] + bodies * girth.planes + girth.chosen(own)
    return tied, rows


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
        return tuple(zip(self.through, self.through[1:], strict=False))

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        return bundle(template, self.legs()).lengths(vertices).sum(axis=1)

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The length and its path over the skin, an open polyline."""
        ways = [way for _, way in bundle(template, self.legs()).ways(vertices)]
        return sum(way.length for way in ways), np.concatenate([way.points for way in ways])

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        ways = bundle(template, self.legs()).ways(vertices)
        slopes = [length_gradient(strip, way) for strip, way in ways]
        indices, gradient = (np.concatenate(piece) for piece in zip(*slopes, strict=True))
        return sum(way.length for _, way in ways), (indices, gradient)


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
        return self._ends(template, vertices, 0)[:, 1] - self._ends(template, vertices, 1)[:, 1]

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The height and a vertical line through its upper end."""
        top, bottom = (self._ends(template, vertices[None], end)[0] for end in (0, 1))
        return float(top[1] - bottom[1]), np.array([top, [top[0], bottom[1], top[2]]])

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
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
        return np.linalg.norm(self._between(template, vertices), axis=-1)

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The distance and its two ends."""
        ends = np.array(
            [template.landmark_points(vertices, end) for end in (self.start, self.stop)]
        )
        return float(np.linalg.norm(ends[1] - ends[0])), ends

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
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
class Extent:
    """How broad (left to right) or deep (front to back) the section of a girth is."""

    girth: Girth
    direction: Literal["breadth", "depth"]

    @property
    def axis(self) -> int:
        return 0 if self.direction == "breadth" else 2

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        tied, rows = tie(template, vertices, [self.girth])
        return np.array([np.ptp(tied.loop(row)[:, self.axis]) for row in rows[:, 0].tolist()])

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The extent and the two points that lie furthest apart."""
        _, loop = self.girth.take(template, vertices)
        along = loop[:, self.axis]
        return float(np.ptp(along)), loop[[along.argmin(), along.argmax()]]

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        """As in `Tape`; the two ends slide with the plane no more than their edges do."""
        tied, rows = tie(template, vertices[None], [self.girth])
        row = int(rows[0, 0])
        part, edges = self.girth.edges(template)
        along = tied.loop(row)[:, self.axis]
        ends = [int(along.argmin()), int(along.argmax())]
        cut = part[edges[tied.edges[tied.corners(row)][ends]]]
        fractions = tied.fractions[tied.corners(row)][ends]
        direction = np.eye(3)[self.axis]
        signs = np.array([-1.0, 1.0])
        slopes = np.concatenate([signs * (1 - fractions), signs * fractions])[:, None] * direction
        return float(along[ends[1]] - along[ends[0]]), (cut.T.ravel(), slopes)


@dataclass(frozen=True)
class Mass:
    """Volume of the closed body times `BODY_DENSITY`."""

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        return BODY_DENSITY * geometry.volume(vertices, template.faces)

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The mass; a scale has no tape, so the path is empty, of shape (0, 3)."""
        return float(self.read(template, vertices[None])[0]), np.zeros((0, 3))

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        slopes = BODY_DENSITY * geometry.volume_gradient(vertices, template.faces)
        return float(self.read(template, vertices[None])[0]), (np.arange(len(vertices)), slopes)


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


@lru_cache(maxsize=256)
def _edges(template: TemplateMesh, tape: Girth) -> tuple[Integers, Integers]:
    """As :meth:`Girth.edges`: those of the parts that on the template lie within reach."""
    faces = template.faces[template.faces_of(*tape.parts)]
    start = template.landmark_points(template.vertices, *tape.start)
    axis = template.landmark_points(template.vertices, *tape.stop) - start
    normal = UP * np.sign(axis[1]) if tape.cut == "level" else axis / np.linalg.norm(axis)
    stations = (template.vertices - start) @ normal
    if tape.cut == "along":
        edges = geometry.edges_of(faces[(stations[faces] > -ON_PLANE).all(axis=1)])
    else:
        edges = geometry.edges_of(faces)
        low, high = stations[edges].min(axis=1), stations[edges].max(axis=1)
        first, last = np.array(tape.span) * (axis @ normal)
        edges = edges[(high > first - tape.reach) & (low < last + tape.reach)]
    indices, places = np.unique(edges, return_inverse=True)
    return indices, places.reshape(edges.shape)
