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

    Corners of all rows follow one another, each row's in order around its hull.

    Attributes
    ----------
    points : ndarray of shape (N, 3), the corners.
    edges : ndarray of shape (N,), the mesh edge on which each corner lies.
    fractions : ndarray of shape (N,), how far along that edge, from its first vertex.
    starts : ndarray of shape (R + 1,), where each row begins.
    perimeters : ndarray of shape (R,); 0 where the plane misses the mesh.
    """

    points: Floats
    edges: Integers
    fractions: Floats
    starts: Integers
    perimeters: Floats

    def corners(self, row: int) -> slice:
        """The places of one row's corners."""
        return slice(int(self.starts[row]), int(self.starts[row + 1]))

    def loop(self, row: int) -> Floats:
        """The corners of one hull: ndarray of shape (n, 3), a closed loop, first not repeated."""
        return self.points[self.corners(row)]


def section_hulls(vertices: Floats, edges: Integers, origins: Floats, normals: Floats) -> Hulls:
    """Convex hulls of the sections of meshes by planes: what a taut tape goes round.

    The hull is found for all rows at once: the points of a section are sorted by their
    angle about their mean, which lies within the hull, and corners that turn inwards are
    dropped until none does. A corner dropped lies in the triangle of the mean and its two
    neighbours, so that no corner of the hull is ever lost.

    Parameters
    ----------
    vertices : ndarray of shape (B, V, 3).
    edges : ndarray of shape (E, 2), the edges to be cut.
    origins : ndarray of shape (B, P, 3), a point of each plane.
    normals : ndarray of shape (B, P, 3), the unit normal of each plane.

    Returns
    -------
    Hulls of B·P rows: the planes of the first mesh, of the second, and so on.
    """
    planes = origins.shape[1]
    row_count = len(vertices) * planes
    heights = normals @ vertices.transpose(0, 2, 1)
    heights -= np.einsum("bpi,bpi->bp", origins, normals)[..., None]
    heights = heights.reshape(row_count, -1)
    above = heights > 0
    rows, cut = np.nonzero(above[:, edges[:, 0]] != above[:, edges[:, 1]])
    low, high = edges[cut].T
    fractions = heights[rows, low] / (heights[rows, low] - heights[rows, high])
    starts = vertices[rows // planes, low]
    points = starts + fractions[:, None] * (vertices[rows // planes, high] - starts)

    counts = np.bincount(rows, minlength=row_count)
    centres = (
        np.stack(
            [np.bincount(rows, weights=points[:, axis], minlength=row_count) for axis in range(3)],
            axis=1,
        )
        / np.maximum(counts, 1)[:, None]
    )
    offsets = points - centres[rows]
    right, up = _plane_axes(normals.reshape(-1, 3))
    flat = np.stack(
        [
            np.einsum("ni,ni->n", offsets, right[rows]),
            np.einsum("ni,ni->n", offsets, up[rows]),
        ],
        axis=1,
    )
    order = np.lexsort((np.arctan2(flat[:, 1], flat[:, 0]), rows))
    flat, rows = flat[order], rows[order]
    distinct = np.ones(len(rows), dtype=bool)
    distinct[1:] = (rows[1:] != rows[:-1]) | (np.abs(np.diff(flat, axis=0)).max(1) > COINCIDENT)
    flat, rows, order = flat[distinct], rows[distinct], order[distinct]
    while True:
        after = _next_in_row(rows, row_count)
        steps = flat[after] - flat
        turns = np.empty(len(rows))
        turns[after] = steps[:, 0] * steps[after, 1] - steps[:, 1] * steps[after, 0]
        outward = turns > 0
        if outward.all():
            break
        flat, rows, order = flat[outward], rows[outward], order[outward]
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    return Hulls(
        points=points[order],
        edges=cut[order],
        fractions=fractions[order],
        starts=np.searchsorted(rows, np.arange(row_count + 1)),
        perimeters=np.bincount(rows, lengths, row_count).astype(np.float64),
    )


def _plane_axes(normals: Floats) -> tuple[Floats, Floats]:
    """Two unit axes of each plane, (R, 3) each; right-handed with the normal."""
    least = np.argmin(np.abs(normals), axis=1)
    right = np.cross(np.eye(3)[least], normals)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    return right, np.cross(normals, right)


def _next_in_row(rows: Integers, row_count: int) -> Integers:
    """For sorted rows, the place of the next member of each one's row, around to its first."""
    starts = np.searchsorted(rows, np.arange(row_count + 1))
    after = np.arange(1, len(rows) + 1)
    filled = starts[1:] > starts[:-1]
    after[starts[1:][filled] - 1] = starts[:-1][filled]
    return after


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
    corners = hulls.corners(row)
    loop, fractions = hulls.points[corners], hulls.fractions[corners, None]
    cut = edges[hulls.edges[corners]]
    towards_next = np.roll(loop, -1, axis=0) - loop
    towards_next /= np.linalg.norm(towards_next, axis=1, keepdims=True)
    by_point = np.roll(towards_next, 1, axis=0) - towards_next
    along = vertices[cut[:, 1]] - vertices[cut[:, 0]]
    slide = np.einsum("ni,ni->n", along, by_point) / (along @ normal)
    by_vertex = by_point - slide[:, None] * normal
    gradient = np.concatenate([(1 - fractions) * by_vertex, fractions * by_vertex])
    return cut.T.ravel(), gradient, slide.sum() * normal
