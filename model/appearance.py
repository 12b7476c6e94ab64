"""How a body looks: its normals, its plain underwear, and the colours of both.

Shared by the file (`gltf`) and the pictures (`rendering`), so that they show the same person.
Colours are sRGB, as a designer writes them; `linear` gives what light is reckoned in.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from model.geometry import Booleans, Floats, Integers, edges_of
from model.measurements import BodyKind
from model.template_mesh import Body, TemplateMesh

# A shop's mannequin: warm and light, of nobody's skin, and a garment that is clearly one.
SKIN_COLOUR = (0.84, 0.765, 0.70)
GARMENT_COLOUR = (0.36, 0.42, 0.47)

# Behind a body in pictures, of 255: as on the page (static/css/site.css, --backdrop).
BACKDROP = (244, 242, 239)

# An edge is cut no nearer to its end than this share of its length: no needle-thin triangles.
SHORTEST_CUT = 0.04

# Cloth lies smoothly over the body: under it the light follows normals averaged this many times
# with their neighbours', fully so from this many metres inside the edge. The points stay.
CLOTH_ROUNDS = 20
CLOTH_HEM = 0.02


@dataclass(frozen=True, eq=False)
class DressedBody:
    """A body's surface, ready to be drawn: one set of points, two sets of faces.

    The points are the body's own vertices followed by those along the garment's edge.

    positions : ndarray of shape (N, 3), metres
    normals : ndarray of shape (N, 3), of length 1
    skin, garment : ndarrays of shape (n, 3), faces that index the points
    """

    positions: Floats
    normals: Floats
    skin: NDArray[np.int32]
    garment: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class GarmentCut:
    """Where the garment's edge crosses the template's edges: the same for all bodies of a kind.

    ends : ndarray of shape (E, 2), the vertices at the ends of each edge that is cut
    along : ndarray of shape (E,), where it is cut: 0 at the first end, 1 at the second
    skin, garment : ndarrays of shape (n, 3), faces; vertex V + e is the cut of edge e
    """

    ends: NDArray[np.int32]
    along: Floats
    skin: NDArray[np.int32]
    garment: NDArray[np.int32]

    def extend(self, values: Floats) -> Floats:
        """Values at the vertices, (V, ...), followed by those at the cuts: (V + E, ...)."""
        first, second = values[self.ends[:, 0]], values[self.ends[:, 1]]
        along = self.along.reshape(-1, *[1] * (values.ndim - 1))
        return np.concatenate([values, first + along * (second - first)])


def dress(body: Body) -> DressedBody:
    """The surface of a body in its plain underwear."""
    template = body.template
    cut = garment_cut(template, body.kind)
    normals = vertex_normals(body.vertices, template.faces)
    covered, under = _under_cloth(template, body.kind)
    normals[covered] += under * (_unit(_smoothed(body, normals)) - normals[covered])
    return DressedBody(
        positions=cut.extend(body.vertices),
        normals=_unit(cut.extend(normals)),
        skin=cut.skin,
        garment=cut.garment,
    )


def dressed_moves(body: Body, moves: Floats) -> tuple[Floats, Floats]:
    """How the surface of a dressed body changes as its vertices begin to move.

    The derivatives of `dress`, but that each face's weight at a vertex stays: on smooth skin,
    where neighbouring faces all but share a plane, it changes no normal.

    Parameters
    ----------
    body : Body
    moves : ndarray of shape (n, V, 3)
        Ways to move its vertices, metres for each unit.

    Returns
    -------
    positions, normals : ndarrays of shape (n, N, 3), for each unit.
    """
    cut = garment_cut(body.template, body.kind)
    # Of all moves at once: ndarrays of shape (V, n, 3).
    columns = moves.transpose(1, 0, 2)
    totals, changes = _normal_moves(body, moves)
    normals, changes = _unit(totals), _unit_moves(totals, changes)
    covered, under = _under_cloth(body.template, body.kind)
    smooth = _smoothed(body, normals)
    smooth_changes = _unit_moves(smooth, _smoothed(body, changes))
    normals[covered] += under * (_unit(smooth) - normals[covered])
    changes[covered] += under[:, None] * (smooth_changes - changes[covered])
    changes = _unit_moves(cut.extend(normals), cut.extend(changes))
    return cut.extend(columns).transpose(1, 0, 2), changes.transpose(1, 0, 2)


@lru_cache(maxsize=8)
def garment_field(template: TemplateMesh, kind: BodyKind) -> Floats:
    """How far each vertex of the mean body lies inside the underwear: (V,), metres.

    Negative outside. Briefs for everybody; a band over the chest too, except for the male body.
    The edges are curves at heights between landmarks, so that they go over the same places of
    every body.
    """
    x, y, z = template.vertices.T

    def height(*names: str) -> float:
        return float(template.landmark_points(template.vertices, *names)[1])

    crotch, navel = height("crotch"), height("omphalion")
    # A leg opening rises from below the crotch to the outside of the hip; the waistband is lower
    # in front.
    beside = np.abs(x) - 0.06
    opening = crotch - 0.035 + 0.28 * (beside + np.hypot(beside, 0.03))
    waistband = crotch + 0.6 * (navel - crotch) - 0.1 * z
    field = np.minimum(y - opening, waistband - y)
    field[~_covers(template, "torso", "upper_leg")] = -1.0
    if kind != "male":
        armpit = height("axilla_left", "axilla_right")
        breast, underbust = height("thelion_left", "thelion_right"), height("underbust")
        side = np.abs(template.landmark_points(template.vertices, "axilla_left")[0])
        top = armpit - 0.02 + 0.035 * (1 - np.minimum((x / side) ** 2, 1))
        band = np.minimum(y - underbust + 0.3 * (breast - underbust), top - y)
        band[~_covers(template, "torso")] = -1.0
        field = np.maximum(field, band)
    return field


@lru_cache(maxsize=8)
def garment_cut(template: TemplateMesh, kind: BodyKind) -> GarmentCut:
    """Where the underwear's edge runs over the faces."""
    return cut_faces(template.faces, garment_field(template, kind))


def cut_faces(faces: NDArray[np.int32], field: Floats) -> GarmentCut:
    """Cut faces along the line where a field over the vertices is zero.

    Parameters
    ----------
    faces : ndarray of shape (F, 3)
    field : ndarray of shape (V,)
        At least zero on the garment's side. Linear within a face, so that the line runs
        straight through it and meets its neighbour's at their common edge.
    """
    inside = field >= 0
    count = inside[faces].sum(axis=1)
    # Of a face that is cut, one corner lies alone on its side: turn the face to begin with it.
    mixed = faces[(count == 1) | (count == 2)]
    alone = np.argmax(inside[mixed] == (inside[mixed].sum(axis=1) == 1)[:, None], axis=1)
    tip, left, right = np.take_along_axis(mixed, (alone[:, None] + np.arange(3)) % 3, axis=1).T
    pairs = np.sort(np.concatenate([np.c_[tip, left], np.c_[tip, right]]), axis=1)
    ends, index = np.unique(pairs, axis=0, return_inverse=True)
    ends = ends.reshape(-1, 2).astype(np.int32)
    start, stop = field[ends[:, 0]], field[ends[:, 1]]
    along = np.clip(start / (start - stop), SHORTEST_CUT, 1 - SHORTEST_CUT)

    on_left, on_right = len(field) + index.reshape(2, -1)
    tips = np.c_[tip, on_left, on_right]
    rests = np.r_[np.c_[on_left, left, right], np.c_[on_left, right, on_right]]
    tip_inside = inside[tip]
    rest_inside = ~np.tile(tip_inside, 2)
    garment = [faces[count == 3], tips[tip_inside], rests[rest_inside]]
    skin = [faces[count == 0], tips[~tip_inside], rests[~rest_inside]]
    return GarmentCut(
        ends=ends,
        along=along,
        skin=np.concatenate(skin).astype(np.int32),
        garment=np.concatenate(garment).astype(np.int32),
    )


def vertex_normals(vertices: Floats, faces: NDArray[np.int32]) -> Floats:
    """Smooth normals, of length 1: ndarray of shape (V, 3).

    Each face weighs by the sine of its angle at the vertex over the lengths of the two sides
    there, which is exact for every mesh whose vertices lie on a sphere. A vertex without a face
    gets +Y.

    References
    ----------
    N. Max, "Weights for Computing Vertex Normals from Facet Normals", Journal of Graphics
    Tools 4(2), 1999.
    """
    sides = vertices[faces[:, 1:]] - vertices[faces[:, :1]]
    return _unit(_gathering(vertices, faces) @ np.cross(sides[:, 0], sides[:, 1]))


def _gathering(vertices: Floats, faces: NDArray[np.int32]) -> csr_array:
    """From faces' cross products to the sums that vertices' normals point along: (V, F)."""
    corners = vertices[faces]
    sides = np.roll(corners, -1, axis=1) - corners
    squares = np.einsum("fcx,fcx->fc", sides, sides)
    # At corner c meet the side that begins there and the side that ends there.
    weights = 1 / np.maximum(squares * np.roll(squares, 1, axis=1), np.finfo(float).tiny)
    rows, columns = faces.ravel(), np.repeat(np.arange(len(faces)), 3)
    return csr_array((weights.ravel(), (rows, columns)), shape=(len(vertices), len(faces)))


def linear(colour: ArrayLike) -> Floats:
    """Linear light from sRGB (IEC 61966-2-1): arrays of one shape, each value from 0 to 1."""
    c = np.asarray(colour, dtype=np.float64)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def _unit(vectors: Floats) -> Floats:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(lengths > 0, vectors / np.where(lengths > 0, lengths, 1), (0.0, 1.0, 0.0))


def _unit_moves(vectors: Floats, changes: Floats) -> Floats:
    """How the directions of vectors change with them: (N, 3) and (N, n, 3) to (N, n, 3)."""
    lengths = np.linalg.norm(vectors, axis=1)
    directions = vectors / np.where(lengths > 0, lengths, 1)[:, None]
    along = np.einsum("vnx,vx->vn", changes, directions)
    across = changes - along[:, :, None] * directions[:, None]
    return across / np.where(lengths > 0, lengths, np.inf)[:, None, None]


def _normal_moves(body: Body, moves: Floats) -> tuple[Floats, Floats]:
    """The sums that vertices' normals point along, (V, 3), and their changes, (V, n, 3).

    A face's cross product p×q + q×r + r×p changes with a corner by the opposite side times that
    corner's move, so that one sparse matrix for each axis of the sides does it for all moves.
    """
    faces = body.template.faces
    corners = body.vertices[faces]
    gather = _gathering(body.vertices, faces)
    totals = gather @ np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    opposite = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    shape = (len(faces), len(body.vertices))
    starts = np.arange(0, faces.size + 1, 3)
    x, y, z = (
        gather @ csr_array((opposite[:, :, axis].ravel(), faces.ravel(), starts), shape=shape)
        for axis in range(3)
    )
    u, v, w = np.ascontiguousarray(moves.transpose(2, 1, 0))
    return totals, np.stack([y @ w - z @ v, z @ u - x @ w, x @ v - y @ u], axis=-1)


def _covers(template: TemplateMesh, *parts: str) -> Booleans:
    """Which vertices have no face outside these parts: (V,)."""
    covers = np.ones(len(template.vertices), dtype=bool)
    covers[template.faces[~template.faces_of(*parts)]] = False
    return covers


def _smoothed(body: Body, values: Floats) -> Floats:
    """Values at the vertices, (V, ...), averaged with their neighbours' under the cloth."""
    covered, average = _cloth(body.template, body.kind)
    smooth = values[covered].reshape(len(covered), math.prod(values.shape[1:]))
    for _ in range(CLOTH_ROUNDS):
        smooth = average @ smooth
    return smooth.reshape(len(covered), *values.shape[1:])


def _under_cloth(template: TemplateMesh, kind: BodyKind) -> tuple[Integers, Floats]:
    """The vertices under the garment, (n,), and how far each follows the cloth: (n, 1), 0 to 1."""
    covered, _ = _cloth(template, kind)
    inside = garment_field(template, kind)[covered]
    return covered, np.clip(inside / CLOTH_HEM, 0, 1)[:, None]


@lru_cache(maxsize=8)
def _cloth(template: TemplateMesh, kind: BodyKind) -> tuple[Integers, csr_array]:
    """The vertices under the garment, (n,), and the mean over each and its neighbours, (n, n)."""
    covered = np.flatnonzero(garment_field(template, kind) > 0)
    place = np.full(len(template.vertices), -1)
    place[covered] = np.arange(len(covered))
    ends = place[edges_of(template.faces)]
    first, second = ends[(ends >= 0).all(axis=1)].T
    itself = np.arange(len(covered))
    rows, columns = np.r_[first, second, itself], np.r_[second, first, itself]
    counts = np.bincount(rows)
    n = len(covered)
    return covered, csr_array((1 / counts[rows], (rows, columns)), shape=(n, n))
