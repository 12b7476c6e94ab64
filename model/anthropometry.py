"""Measuring bodies: each measurement is one row of `TAPES`, and the rows drive the loop.

A girth is what a taut tape reads: the perimeter of the convex hull of the plane section of
that body part. Where a definition says widest or narrowest, planes are tried at fixed
steps of a stated span between landmarks: the largest or smallest of values that each move
smoothly with the body moves continuously too, even where two places compete. Heights are
vertical distances. Definitions are those of ``model/data/measurements.csv``.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, Protocol

import numpy as np

from model import geometry
from model.geometry import Floats, Integers
from model.measurements import MEASUREMENTS, MeasurementSet
from model.template_mesh import Body, TemplateMesh

BODY_DENSITY = 1000.0
"""Mass over volume of the closed body, lungs included, in kg/m³.

Siri (1961, *Body composition from fluid spaces and density*): fat 900 and lean 1,100 kg/m³,
so 1,042 at a quarter of fat. Some 3.3 litres of air in the chest (thoracic gas volume, about
that of McCrory et al. 1998, *J. Appl. Physiol.* 84) make that 996 in a body of 75 kg. By the
same reckoning it is 1,024 for 70 kg with a tenth of fat, and 973 for 120 kg with 45 %.
"""

UP = np.array([0.0, 1.0, 0.0])
LEFT = np.array([1.0, 0.0, 0.0])

REACH = 0.75
"""How far beyond its span a tape's edges are kept, as a share of its axis. A part's skin lies
at other heights, between the same landmarks, on other bodies; never by so much."""

Landmarks = tuple[str, ...]
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
    cut : how planes lie: level; across, perpendicular to the axis; or slanted, along the
        line from the first landmark of start and stop (at the back) to the last (in front).
    planes : how many are tried.
    """

    parts: tuple[str, ...]
    start: Landmarks
    stop: Landmarks
    span: tuple[float, float]
    pick: Literal["widest", "narrowest"]
    cut: Literal["level", "across", "slanted"] = "level"
    planes: int = 17

    def hulls(
        self, template: TemplateMesh, vertices: Floats
    ) -> tuple[geometry.Hulls, Integers, Floats]:
        """The hulls at every plane, the chosen row of each body, and its plane's normal.

        Parameters
        ----------
        vertices : ndarray of shape (B, V, 3), metres.

        Returns
        -------
        hulls : rows run over bodies, then planes.
        chosen : ndarray of shape (B,), the row that counts.
        normals : ndarray of shape (B, 3), the normal of the chosen plane.
        """
        indices, edges = _cut_edges(template, self)
        start = template.landmark_points(vertices, *self.start)
        axis = template.landmark_points(vertices, *self.stop) - start
        origins = start[:, None] + self.fractions()[:, None] * axis[:, None]
        normals = self._normals(template, vertices, axis)
        hulls = geometry.section_hulls(vertices[:, indices], edges, origins, normals)
        girths = hulls.perimeters.reshape(len(vertices), -1)
        best = girths.argmax(axis=1) if self.pick == "widest" else girths.argmin(axis=1)
        bodies = np.arange(len(vertices))
        return hulls, bodies * self.planes + best, normals[bodies, best]

    def fractions(self) -> Floats:
        """Where planes are tried, as shares of the way from start to stop: (planes,)."""
        return np.linspace(*self.span, self.planes)

    def _normals(self, template: TemplateMesh, vertices: Floats, axis: Floats) -> Floats:
        """The unit normals of all planes: (B, planes, 3)."""
        if self.cut == "level":
            return np.broadcast_to(UP, (len(vertices), self.planes, 3))
        if self.cut == "across":
            normals = np.repeat(axis[:, None], self.planes, axis=1)
        else:
            low, high = (
                template.landmark_points(vertices, ends[-1])
                - template.landmark_points(vertices, ends[0])
                for ends in (self.start, self.stop)
            )
            forward = low[:, None] + self.fractions()[:, None] * (high - low)[:, None]
            normals = np.cross(forward, LEFT)
        return normals / np.linalg.norm(normals, axis=2, keepdims=True)

    def read(self, template: TemplateMesh, vertices: Floats) -> Floats:
        hulls, chosen, _ = self.hulls(template, vertices)
        return hulls.perimeters[chosen]

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The girth and its closed loop, whose first point is not repeated."""
        hulls, chosen, _ = self.hulls(template, vertices[None])
        row = int(chosen[0])
        return float(hulls.perimeters[row]), hulls.loop(row)

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        """As in `Tape`; the plane moves with its landmarks, its normal is held."""
        hulls, chosen, normals = self.hulls(template, vertices[None])
        part, edges = _cut_edges(template, self)
        indices, slopes, by_origin = geometry.perimeter_gradient(
            hulls, int(chosen[0]), vertices[part], edges, normals[0]
        )
        fraction = self.fractions()[chosen[0] % self.planes]
        start, start_weights = template.landmark_weights(*self.start)
        stop, stop_weights = template.landmark_weights(*self.stop)
        gradient = np.concatenate(
            [
                slopes,
                (1 - fraction) * start_weights[:, None] * by_origin,
                fraction * stop_weights[:, None] * by_origin,
            ]
        )
        value = float(hulls.perimeters[chosen[0]])
        return value, (np.concatenate([part[indices], start, stop]), gradient)


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
        hulls, chosen, _ = self.girth.hulls(template, vertices)
        return np.array([np.ptp(hulls.loop(row)[:, self.axis]) for row in chosen.tolist()])

    def take(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Floats]:
        """The extent and the two points that lie furthest apart."""
        _, loop = self.girth.take(template, vertices)
        along = loop[:, self.axis]
        return float(np.ptp(along)), loop[[along.argmin(), along.argmax()]]

    def gradient(self, template: TemplateMesh, vertices: Floats) -> tuple[float, Gradient]:
        """As in `Tape`; the two ends slide with the plane no more than their edges do."""
        hulls, chosen, _ = self.girth.hulls(template, vertices[None])
        row = int(chosen[0])
        part, edges = _cut_edges(template, self.girth)
        along = hulls.loop(row)[:, self.axis]
        ends = [int(along.argmin()), int(along.argmax())]
        cut = part[edges[hulls.edges[hulls.corners(row)][ends]]]
        fractions = hulls.fractions[hulls.corners(row)][ends]
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


LEFT_HIP: Landmarks = ("lateral_thigh_left", "medial_thigh_left")
LEFT_KNEE: Landmarks = ("lateral_knee_left", "medial_knee_left")
THIGH = ("upper_leg_left",)

TAPES: Mapping[str, Tape] = {
    "stature": Height(),
    "weight": Mass(),
    # Between the lowest ribs and the top of the hip bones; both move with the trunk.
    "waist_girth": Girth(
        ("torso",), ("omphalion",), ("underbust",), (0.0, 0.6), "narrowest", planes=21
    ),
    "bust_girth": Girth(
        ("torso",), ("thelion_left", "thelion_right"), ("underbust",), (0.0, 0.5), "widest"
    ),
    "hip_girth": Girth(
        ("torso", "upper_leg"), ("crotch",), ("omphalion",), (0.18, 0.6), "widest", planes=21
    ),
    "neck_girth": Girth(
        ("head_neck", "torso"),
        ("cervicale", "neck_front"),
        ("nape", "throat"),
        (0.0, 0.9),
        "narrowest",
        cut="slanted",
    ),
    "thigh_girth": Girth(THIGH, LEFT_HIP, LEFT_KNEE, (0.0, 0.1), "widest", cut="across"),
    # About the navel, where the belly is fullest; further down it would read the hips.
    "abdomen_girth": Girth(
        ("torso", "upper_leg"), ("omphalion",), ("underbust",), (-0.1, 0.2), "widest"
    ),
    "mid_thigh_girth": Girth(THIGH, LEFT_HIP, LEFT_KNEE, (0.35, 0.6), "narrowest", cut="across"),
    "inseam_height": Height(("crotch",), ("lateral_malleolus_left",)),
    "foot_height": Height(("lateral_malleolus_left",)),
}
"""How each measurement is taken. A row of the table is all that a new one needs."""

TAKEN: tuple[str, ...] = tuple(name for name in MEASUREMENTS if name in TAPES)
"""The measurements that are taken, in the table's order."""


@dataclass(frozen=True)
class Measured:
    """What a body measures.

    Attributes
    ----------
    values : every measurement that is taken.
    paths : where each tape ran, ndarray of shape (n, 3) in metres: a girth is a closed
        loop whose first point is not repeated, a height two points; weight has none.
    """

    values: MeasurementSet
    paths: Mapping[str, Floats]


class ImpossibleBodyError(ValueError):
    """A surface that no person has: turned inside out, or cut by no tape."""


def measure(body: Body) -> Measured:
    """Takes every measurement of one body, with the path of each tape.

    Raises
    ------
    ImpossibleBodyError
        For a body with a measurement that is not positive. Values that contradict each
        other strongly can make the linear estimate such a body.
    """
    readings = {name: TAPES[name].take(body.template, body.vertices) for name in TAKEN}
    for name, (value, _) in readings.items():
        if not value > 0:
            raise ImpossibleBodyError(f"the body has no {name}")
    return Measured(
        values=MeasurementSet({name: value for name, (value, _) in readings.items()}),
        paths={name: path for name, (_, path) in readings.items()},
    )


def measure_batch(template: TemplateMesh, vertices: Floats, names: Iterable[str] = TAKEN) -> Floats:
    """Takes measurements of many bodies.

    Parameters
    ----------
    vertices : ndarray of shape (B, V, 3), metres.
    names : which measurements; all that are taken by default.

    Returns
    -------
    ndarray of shape (B, number of names), SI units.
    """
    return read_tapes(template, vertices, [TAPES[name] for name in names])


def read_tapes(template: TemplateMesh, vertices: Floats, tapes: Sequence[Tape]) -> Floats:
    """Reads any tapes on many bodies, in chunks that fit the memory: (B, number of tapes)."""
    chunk = 32
    return np.concatenate(
        [
            np.stack([tape.read(template, vertices[i : i + chunk]) for tape in tapes], axis=1)
            for i in range(0, len(vertices), chunk)
        ]
    )


@lru_cache(maxsize=128)
def _cut_edges(template: TemplateMesh, tape: Girth) -> tuple[Integers, Integers]:
    """The edges that a tape may meet, and their vertices.

    Those of the tape's parts that on the template lie within `REACH` of its span.

    Returns
    -------
    indices : ndarray of shape (n,), the vertices.
    edges : ndarray of shape (E, 2), places in `indices`.
    """
    edges = geometry.edges_of(template.faces[template.faces_of(*tape.parts)])
    start = template.landmark_points(template.vertices, *tape.start)
    axis = template.landmark_points(template.vertices, *tape.stop) - start
    normal = UP * np.sign(axis[1]) if tape.cut == "level" else axis / np.linalg.norm(axis)
    stations = (template.vertices - start) @ normal / (axis @ normal)
    low, high = stations[edges].min(axis=1), stations[edges].max(axis=1)
    edges = edges[(high > tape.span[0] - REACH) & (low < tape.span[1] + REACH)]
    indices, places = np.unique(edges, return_inverse=True)
    return indices, places.reshape(edges.shape)
