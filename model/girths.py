"""Girths: taut tapes around body parts, many of them tied together.

A girth is the perimeter of the convex hull of the plane section of that body part. Where a
definition says widest or narrowest, planes are tried at fixed steps of a stated span between
landmarks: the largest or smallest of values that each move smoothly with the body moves
continuously too, even where two places compete.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from model import geometry
from model.geometry import Floats, Integers
from model.template_mesh import UP, Gradient, Landmarks, TemplateMesh


@dataclass(frozen=True)
class Girth:
    """A taut tape around a body part.

    Attributes
    ----------
    parts : the parts that are cut; of others the tape knows nothing.
    start, stop : the mean points of these landmarks span the axis along which planes lie.
    span : from where to where planes are tried, as fractions of the way from start to stop.
    pick : which of the planes counts.
    cut : how planes lie: level; across, perpendicular to the axis; or slanted, along the line
        from the first landmarks of start and stop (at the back) to the last (in front).
    planes : how many are tried.
    reach : how far beyond the span edges may be met, in metres on the template. The skin of a
        part lies at other heights, between the same landmarks, on other bodies.
    past : landmarks that the tape passes by, and how far around each, in metres on the
        template, no skin is met. A plane that just touches what hangs or sticks out there
        would make the girth jump.
    """

    parts: tuple[str, ...]
    start: Landmarks
    stop: Landmarks
    span: tuple[float, float] = (0.0, 0.0)
    pick: Literal["widest", "narrowest"] = "widest"
    cut: Literal["level", "across", "slanted"] = "level"
    planes: int = 1
    reach: float = 0.15
    past: tuple[tuple[str, float], ...] = ()

    @property
    def step(self) -> float:
        """From plane to plane, as a share of the way from start to stop; of one plane, 1."""
        return (self.span[1] - self.span[0]) / (self.planes - 1) if self.planes > 1 else 1.0

    def ends(self) -> tuple[Landmarks, Landmarks, Landmarks, Landmarks]:
        """Start and stop, and the two ends of the line that tilts the planes."""
        if self.cut == "slanted":
            return (
                self.start,
                self.stop,
                (self.start[0], self.stop[0]),
                (self.start[-1], self.stop[-1]),
            )
        return self.start, self.stop, self.start, self.stop

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        """The girths of a batch: (B,), metres."""
        tied, rows = tie(template, vertices, [self])
        return tied.perimeters[rows[:, 0]]

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The girth, metres, and its closed loop, (P, 3), whose first point is not repeated."""
        tied, rows = tie(template, vertices[None], [self])
        return float(tied.perimeters[rows[0, 0]]), tied.loop(int(rows[0, 0]))

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        """The girth and its derivative, a `Gradient`, on the plane that counts just now."""
        tied, rows = tie(template, vertices[None], [self])
        row = int(rows[0, 0])
        return float(tied.perimeters[row]), gradients(template, vertices, [self], tied, [(0, row)])[
            0
        ]

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
    rig = _rig(template, tuple(girths))
    starts, stops, tails, heads = np.moveaxis(rig.points(vertices), 2, 0)
    normals = np.einsum("gij,bgj->bgi", rig.turns, heads - tails) + rig.uprights
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    rises = np.einsum("bgi,bgi->bg", stops - starts, normals)
    firsts = np.einsum("bgi,bgi->bg", starts, normals) + rig.firsts * rises
    steps = rig.steps * rises
    part = np.take(vertices, rig.indices, axis=1)
    stations = np.empty(part.shape[:2])
    for place, own in enumerate(rig.spans):
        along = part[:, own] @ (normals[:, place] / steps[:, place, None])[..., None]
        np.subtract(along[..., 0], (firsts / steps)[:, place, None], out=stations[:, own])
    cut = geometry.sections(part, rig.edges, stations, rig.families, rig.planes)
    tied = geometry.hulls(cut, np.repeat(normals, rig.planes, axis=1).reshape(-1, 3))
    perimeters = tied.perimeters.reshape(len(vertices), -1)
    ends = np.cumsum(rig.planes)
    rows = np.empty((len(vertices), len(girths)), dtype=np.int64)
    for column, girth in enumerate(girths):
        first, end = ends[column] - girth.planes, ends[column]
        rows[:, column] = first + girth.chosen(perimeters[:, first:end])
    return tied, rows + np.arange(len(vertices))[:, None] * perimeters.shape[1]


def gradients(
    template: TemplateMesh,
    vertices: Floats,
    girths: Sequence[Girth],
    tied: geometry.Hulls,
    chosen: Sequence[tuple[int, int]],
) -> list[Gradient]:
    """Derivatives of girths at some of the planes that were tried on one body.

    Parameters
    ----------
    vertices : ndarray of shape (V, 3), metres.
    tied : what :func:`tie` made of these girths and that body alone.
    chosen : for each derivative the place of its girth, and which of its planes.
    """
    rig = _rig(template, tuple(girths))
    part = vertices[rig.indices]
    ends = rig.points(vertices[None])[0]
    firsts = np.cumsum(rig.planes) - rig.planes
    slopes_of = []
    for place, plane in chosen:
        fraction = girths[place].span[0] + girths[place].step * plane
        start, stop, tail, head = ends[place]
        direction = rig.turns[place] @ (head - tail) + rig.uprights[place]
        size = np.linalg.norm(direction)
        normal = direction / size
        origin = start + fraction * (stop - start)
        row = int(firsts[place]) + plane
        slopes = geometry.perimeter_gradient(tied, row, part, rig.edges, origin, normal)
        by_direction = (slopes.by_normal - normal * (normal @ slopes.by_normal)) / size
        by_line = by_direction @ rig.turns[place]
        by_ends = ((1 - fraction) * slopes.by_origin, fraction * slopes.by_origin)
        pieces = [(rig.indices[slopes.indices], slopes.by_vertex)]
        for names, by_mean in zip(girths[place].ends(), (*by_ends, -by_line, by_line), strict=True):
            indices, weights = template.landmark_weights(*names)
            pieces.append((indices, weights[:, None] * by_mean))
        indices, gradient = (np.concatenate(piece) for piece in zip(*pieces, strict=True))
        slopes_of.append((indices, gradient))
    return slopes_of


@dataclass(frozen=True)
class Extent:
    """How broad (left to right) or deep (front to back) the section of a girth is.

    Attributes
    ----------
    girth : which section.
    direction : what is measured of it.
    """

    girth: Girth
    direction: Literal["breadth", "depth"]

    @property
    def axis(self) -> int:
        """The axis that is measured along: 0 is left to right, 2 back to front."""
        return 0 if self.direction == "breadth" else 2

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        """The extents of a batch: (B,), metres."""
        tied, rows = tie(template, vertices, [self.girth])
        return np.array([np.ptp(tied.loop(row)[:, self.axis]) for row in rows[:, 0].tolist()])

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The extent, metres, and the two points that lie furthest apart, (2, 3)."""
        _, loop = self.girth.take(template, vertices)
        along = loop[:, self.axis]
        return float(np.ptp(along)), loop[[along.argmin(), along.argmax()]]

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        """The extent and its derivative, its two ends held where they lie on their edges."""
        tied, rows = tie(template, vertices[None], [self.girth])
        row = int(rows[0, 0])
        rig = _rig(template, (self.girth,))
        along = tied.loop(row)[:, self.axis]
        ends = [int(along.argmin()), int(along.argmax())]
        cut = rig.indices[rig.edges[:, tied.edges[tied.corners(row)][ends]]]
        fractions = tied.fractions[tied.corners(row)][ends]
        direction = np.eye(3)[self.axis]
        signs = np.array([-1.0, 1.0])
        slopes = np.concatenate([signs * (1 - fractions), signs * fractions])[:, None] * direction
        return float(along[ends[1]] - along[ends[0]]), (cut.ravel(), slopes)


@dataclass(frozen=True)
class _Rig:
    """What several girths meet on a template, side by side.

    Attributes
    ----------
    indices : ndarray of shape (n,), vertices; those of one girth after those of another.
    edges : ndarray of shape (2, E), places in `indices`.
    families : ndarray of shape (n,), the girth that each vertex is there for.
    spans : where each girth's vertices are in `indices`.
    planes : ndarray of shape (G,), how many planes each girth tries.
    firsts, steps : ndarrays of shape (G,), the first plane and the step to the next, as shares
        of the way from start to stop.
    turns : ndarray of shape (G, 3, 3), from the line that tilts a plane to its direction.
    uprights : ndarray of shape (G, 3), added to that.
    landmarks : ndarray of shape (L,), vertices.
    weights : ndarray of shape (G, 4, L), each girth's ends as sums of those.
    """

    indices: Integers
    edges: Integers
    families: Integers
    spans: tuple[slice, ...]
    planes: Integers
    firsts: Floats
    steps: Floats
    turns: Floats
    uprights: Floats
    landmarks: Integers
    weights: Floats

    def points(self, vertices: Floats) -> Floats:
        """Each girth's ends (see :meth:`Girth.ends`): vertices (B, V, 3) to (B, G, 4, 3)."""
        return np.einsum("gel,bli->bgei", self.weights, vertices[:, self.landmarks])


TURNS: Mapping[str, Floats] = {
    "level": np.zeros((3, 3)),
    "across": np.eye(3),
    # The cross product of the line with the direction left.
    "slanted": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}
"""From the line that tilts a plane to the plane's direction, by the kind of cut."""


@lru_cache(maxsize=256)
def _rig(template: TemplateMesh, girths: tuple[Girth, ...]) -> _Rig:
    indices, edges, families, spans = [], [], [], []
    count = 0
    for family, girth in enumerate(girths):
        own, places = np.unique(_edges(template, girth), return_inverse=True)
        indices.append(own)
        edges.append(places.reshape(-1, 2).T + count)
        families.append(np.full(len(own), family))
        spans.append(slice(count, count + len(own)))
        count += len(own)
    ends = [[template.landmark_weights(*names) for names in girth.ends()] for girth in girths]
    landmarks = np.unique(np.concatenate([i for four in ends for i, _ in four]))
    weights = np.zeros((len(girths), 4, len(landmarks)))
    for girth_weights, four in zip(weights, ends, strict=True):
        for row, (vertices, shares) in zip(girth_weights, four, strict=True):
            np.add.at(row, np.searchsorted(landmarks, vertices), shares)
    return _Rig(
        indices=np.concatenate(indices),
        edges=np.ascontiguousarray(np.concatenate(edges, axis=1)),
        families=np.concatenate(families),
        spans=tuple(spans),
        planes=np.array([girth.planes for girth in girths]),
        firsts=np.array([girth.span[0] for girth in girths]),
        steps=np.array([girth.step for girth in girths]),
        turns=np.stack([TURNS[girth.cut] for girth in girths]),
        uprights=np.stack([UP * (girth.cut == "level") for girth in girths]),
        landmarks=landmarks,
        weights=weights,
    )


def _edges(template: TemplateMesh, tape: Girth) -> Integers:
    """The edges of a tape's parts that on the template lie within its reach: (E, 2)."""
    faces = template.faces[template.faces_of(*tape.parts)]
    start = template.landmark_points(template.vertices, *tape.start)
    axis = template.landmark_points(template.vertices, *tape.stop) - start
    met = np.ones(len(template.vertices), dtype=bool)
    for name, radius in tape.past:
        passed = template.landmark_points(template.vertices, name)
        met &= np.linalg.norm(template.vertices - passed, axis=1) > radius
    faces = faces[met[faces].all(axis=1)]
    normal = UP * np.sign(axis[1]) if tape.cut == "level" else axis / np.linalg.norm(axis)
    stations = (template.vertices - start) @ normal
    edges = geometry.edges_of(faces)
    low, high = stations[edges].min(axis=1), stations[edges].max(axis=1)
    first, last = np.array(tape.span) * (axis @ normal)
    return edges[(high > first - tape.reach) & (low < last + tape.reach)]
