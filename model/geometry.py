"""Mathematics on batches of triangle meshes: plane sections, hulls, volume. Knows no bodies.

Arrays lead with the batch: vertices are of shape (B, V, 3). Lengths are in the vertices'
own unit.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]

COINCIDENT = 1e-10
"""Points of a section nearer than this, in the vertices' unit, are one point."""


def edges_of(faces: NDArray[Any]) -> Integers:
    """The edges of triangles, each once.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), vertex indices.

    Returns
    -------
    ndarray of shape (E, 2), smaller vertex index first, in lexical order.
    """
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    return np.unique(np.sort(pairs, axis=1), axis=0)


def volume(vertices: Floats, faces: NDArray[Any]) -> Floats:
    """Volume of closed meshes, by the divergence theorem.

    Parameters
    ----------
    vertices : ndarray of shape (..., V, 3).
    faces : ndarray of shape (F, 3), wound outwards.

    Returns
    -------
    ndarray of shape (...).
    """
    a, b, c = (vertices[..., faces[:, corner], :] for corner in range(3))
    return np.einsum("...fi,...fi->...", a, np.cross(b, c)) / 6


def volume_gradient(vertices: Floats, faces: NDArray[Any]) -> Floats:
    """The derivative of :func:`volume` by each vertex, of one mesh.

    Parameters
    ----------
    vertices : ndarray of shape (V, 3).
    faces : ndarray of shape (F, 3), wound outwards.

    Returns
    -------
    ndarray of shape (V, 3).
    """
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    gradient = np.zeros_like(vertices)
    for corner, (p, q) in enumerate([(b, c), (c, a), (a, b)]):
        share = np.cross(p, q) / 6
        for axis in range(3):
            gradient[:, axis] += np.bincount(
                faces[:, corner], weights=share[:, axis], minlength=len(vertices)
            )
    return gradient


@dataclass(frozen=True)
class Hulls:
    """The convex hulls of plane sections; row r is one plane through one mesh.

    Attributes
    ----------
    points : ndarray of shape (R, P, 3), the hull's corners in order; rows are padded.
    valid : ndarray of shape (R, P), False where a row is padding.
    edges : ndarray of shape (R, P), the mesh edge on which each corner lies.
    fractions : ndarray of shape (R, P), how far along that edge, from its first vertex.
    perimeters : ndarray of shape (R,); 0 where the plane misses the mesh.
    """

    points: Floats
    valid: Booleans
    edges: Integers
    fractions: Floats
    perimeters: Floats

    def loop(self, row: int) -> Floats:
        """The corners of one hull: ndarray of shape (n, 3), a closed loop, first not repeated."""
        return self.points[row, self.valid[row]]


def section_hulls(vertices: Floats, edges: Integers, origins: Floats, normals: Floats) -> Hulls:
    """Convex hulls of the sections of meshes by planes: what a taut tape goes round.

    The hull is found for all rows at once: the points of a section are sorted by their
    angle about their mean, which lies within the hull, and corners that turn inwards are
    dropped until none does. A corner dropped lies in the triangle of the mean and its two
    neighbours, so that no corner of the hull is ever lost.

    Parameters
    ----------
    vertices : ndarray of shape (R, V, 3).
    edges : ndarray of shape (E, 2), the edges to be cut.
    origins : ndarray of shape (R, 3), a point of each plane.
    normals : ndarray of shape (R, 3), unit normals.
    """
    heights = np.einsum("rvi,ri->rv", vertices, normals)
    heights -= np.einsum("ri,ri->r", origins, normals)[:, None]
    first, second = heights[:, edges[:, 0]], heights[:, edges[:, 1]]
    rows, cut = np.nonzero((first > 0) != (second > 0))
    counts = np.bincount(rows, minlength=len(vertices))
    width = max(int(counts.max(initial=0)), 1)
    places = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)

    shape = (len(vertices), width)
    edge_ids = np.zeros(shape, dtype=np.int64)
    edge_ids[rows, places] = cut
    fractions = np.zeros(shape)
    fractions[rows, places] = first[rows, cut] / (first[rows, cut] - second[rows, cut])
    valid = np.arange(width) < counts[:, None]
    row_ids = np.arange(len(vertices))[:, None]
    starts = vertices[row_ids, edges[edge_ids, 0]]
    points = starts + fractions[..., None] * (vertices[row_ids, edges[edge_ids, 1]] - starts)

    right, up = _plane_axes(normals)
    centres = (points * valid[..., None]).sum(axis=1) / np.maximum(counts, 1)[:, None]
    offsets = points - centres[:, None]
    flat = np.stack(
        [np.einsum("rpi,ri->rp", offsets, right), np.einsum("rpi,ri->rp", offsets, up)], axis=-1
    )
    angles = np.where(valid, np.arctan2(flat[..., 1], flat[..., 0]), np.inf)
    order = np.argsort(angles, axis=1, kind="stable")
    flat, valid = np.take_along_axis(flat, order[..., None], axis=1), valid[row_ids, order]
    valid &= ~_repeats(flat, valid)
    flat, order, valid = _drop_inward_corners(flat, order, valid)

    steps = np.where(valid[..., None], _neighbour(flat, valid, +1) - flat, 0)
    return Hulls(
        points=points[row_ids, order],
        valid=valid,
        edges=edge_ids[row_ids, order],
        fractions=fractions[row_ids, order],
        perimeters=np.linalg.norm(steps, axis=-1).sum(axis=1),
    )


def _plane_axes(normals: Floats) -> tuple[Floats, Floats]:
    """Two unit axes of each plane, (R, 3) each; right-handed with the normal."""
    least = np.argmin(np.abs(normals), axis=1)
    helper = np.eye(3)[least]
    right = np.cross(helper, normals)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    return right, np.cross(normals, right)


def _repeats(flat: Floats, valid: Booleans) -> Booleans:
    """Whether a corner coincides with the one before it: a plane through a mesh vertex."""
    same = np.linalg.norm(flat - np.roll(flat, 1, axis=1), axis=-1) < COINCIDENT
    same[:, 0] = False
    return same & valid & np.roll(valid, 1, axis=1)


def _neighbour(flat: Floats, valid: Booleans, step: int) -> Floats:
    """The next (+1) or previous (-1) corner of rows whose valid corners come first."""
    counts = np.maximum(valid.sum(axis=1), 1)[:, None]
    index = (np.arange(flat.shape[1]) + step) % counts
    return np.take_along_axis(flat, index[..., None], axis=1)


def _drop_inward_corners(
    flat: Floats, order: Integers, valid: Booleans
) -> tuple[Floats, Integers, Booleans]:
    """Drops corners that do not turn left until all do; compacts the rows."""
    while True:
        front = np.argsort(~valid, axis=1, kind="stable")[:, : max(int(valid.sum(1).max()), 1)]
        flat = np.take_along_axis(flat, front[..., None], axis=1)
        order = np.take_along_axis(order, front, axis=1)
        valid = np.take_along_axis(valid, front, axis=1)
        before = flat - _neighbour(flat, valid, -1)
        after = _neighbour(flat, valid, +1) - flat
        turns = before[..., 0] * after[..., 1] - before[..., 1] * after[..., 0]
        inward = valid & (turns <= 0)
        if not inward.any():
            return flat, order, valid
        valid &= ~inward


def perimeter_gradient(
    hulls: Hulls, row: int, vertices: Floats, edges: Integers, normal: Floats
) -> tuple[Integers, Floats, Floats]:
    """The derivative of one hull's perimeter by the mesh and by the plane.

    The normal is held; the hull's corners slide along their edges.

    Parameters
    ----------
    hulls : from :func:`section_hulls`.
    row : which of them.
    vertices : ndarray of shape (V, 3), the mesh of that row.
    edges : ndarray of shape (E, 2), as given to :func:`section_hulls`.
    normal : ndarray of shape (3,), the plane's unit normal.

    Returns
    -------
    indices : ndarray of shape (2n,), vertex indices; an index may come up repeatedly.
    gradient : ndarray of shape (2n, 3), to be added up by vertex.
    by_offset : ndarray of shape (3,), by the plane's origin.
    """
    keep = hulls.valid[row]
    loop, fractions = hulls.points[row, keep], hulls.fractions[row, keep, None]
    cut = edges[hulls.edges[row, keep]]
    towards_next = np.roll(loop, -1, axis=0) - loop
    towards_next /= np.linalg.norm(towards_next, axis=1, keepdims=True)
    by_point = np.roll(towards_next, 1, axis=0) - towards_next
    along = vertices[cut[:, 1]] - vertices[cut[:, 0]]
    slide = np.einsum("ni,ni->n", along, by_point) / (along @ normal)
    by_vertex = by_point - slide[:, None] * normal
    gradient = np.concatenate([(1 - fractions) * by_vertex, fractions * by_vertex])
    return cut.T.ravel(), gradient, slide.sum() * normal
