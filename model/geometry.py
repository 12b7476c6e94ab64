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
    """Volume of closed meshes: the sum of signed prisms under their triangles.

    Parameters
    ----------
    vertices : ndarray of shape (..., V, 3).
    faces : ndarray of shape (F, 3), wound outwards.

    Returns
    -------
    ndarray of shape (...).
    """
    x, y, z = (np.ascontiguousarray(vertices[..., axis]) for axis in range(3))
    a, b, c = np.ascontiguousarray(faces.T)
    ax, az = x[..., a], z[..., a]
    # Under each triangle a prism down to the ground: twice its ground area times its height.
    ground = (z[..., b] - az) * (x[..., c] - ax) - (x[..., b] - ax) * (z[..., c] - az)
    return np.einsum("...f,...f->...", ground, y[..., a] + y[..., b] + y[..., c]) / 6


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
    # Around a vertex the triangles' areas, as vectors, sum up to that of the ring they end in.
    x, y, z = np.ascontiguousarray(vertices.T)
    corners = a, b, c = np.ascontiguousarray(faces.T)
    ux, uy, uz = (axis[b] - axis[a] for axis in (x, y, z))
    vx, vy, vz = (axis[c] - axis[a] for axis in (x, y, z))
    areas = (uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)
    gradient = np.empty_like(vertices)
    for axis, area in enumerate(areas):
        by_corner = [np.bincount(corner, area, len(vertices)) for corner in corners]
        gradient[:, axis] = sum(by_corner) / 6
    return gradient


@dataclass(frozen=True)
class Sections:
    """Where edges of meshes meet planes; row r is one plane through one mesh.

    Attributes
    ----------
    points : ndarray of shape (N, 3).
    rows : ndarray of shape (N,), the row of each point.
    edges : ndarray of shape (N,), the mesh edge on which each lies.
    fractions : ndarray of shape (N,), how far along that edge, from its first vertex.
    """

    points: Floats
    rows: Integers
    edges: Integers
    fractions: Floats


def sections(
    vertices: Floats, edges: Integers, stations: Floats, families: Integers, planes: Integers
) -> Sections:
    """Cuts meshes by families of parallel planes.

    Parameters
    ----------
    vertices : ndarray of shape (B, V, 3).
    edges : ndarray of shape (2, E), the edges to be cut; both ends are of one family.
    stations : ndarray of shape (B, V), how far each vertex lies along its family's normal, in
        steps from plane to plane: the planes lie at 0, 1, 2... A vertex on a plane counts as
        below it.
    families : ndarray of shape (V,), the family of planes that cuts each vertex's edges.
    planes : ndarray of shape (G,), how many planes each family has.

    Returns
    -------
    Sections whose rows run over meshes, then families, then planes.
    """
    firsts = np.cumsum(planes) - planes
    # How many planes lie below each vertex: an edge meets those between its ends' counts.
    # (fmax leaves out what is not a number, as on a mesh that has collapsed.)
    below = np.fmin(np.fmax(np.ceil(stations), 0), planes[families]).astype(np.int64)
    tail, head = below[:, edges[0]], below[:, edges[1]]
    meshes, cut = np.nonzero(tail != head)
    tail, head = tail[meshes, cut], head[meshes, cut]
    counts = np.abs(head - tail)
    repeated = np.repeat(np.arange(len(cut)), counts)
    step = np.arange(len(repeated)) - np.repeat(np.cumsum(counts) - counts, counts)
    plane = np.minimum(tail, head)[repeated] + step
    meshes, cut = meshes[repeated], cut[repeated]
    tail, head = edges[0][cut], edges[1][cut]
    start = stations[meshes, tail]
    fractions = (plane - start) / (stations[meshes, head] - start)
    points = vertices[meshes, tail]
    points += fractions[:, None] * (vertices[meshes, head] - points)
    rows = meshes * planes.sum() + firsts[families[tail]] + plane
    return Sections(points, rows, cut, fractions)


@dataclass(frozen=True)
class Hulls:
    """The convex hulls of sections.

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


def hulls(cut: Sections, normals: Floats) -> Hulls:
    """Convex hulls of sections: what a taut tape goes round.

    Found for all rows at once: the points of a section are sorted by their direction from
    their mean, which lies within the hull, and corners that turn inwards are dropped until
    none does. A corner dropped lies in the triangle of the mean and its two neighbours, so
    that no corner of the hull is ever lost.

    Parameters
    ----------
    normals : ndarray of shape (R, 3), the unit normal of each row's plane.
    """
    count = len(normals)
    rows = cut.rows
    # Hulls do not change when planes are squeezed: two of the three coordinates will do.
    dropped = np.abs(normals).argmax(axis=1)
    places = 3 * np.arange(len(rows))
    flat = [cut.points.ravel()[places + ((dropped + k) % 3)[rows]] for k in (1, 2)]
    sizes = np.maximum(np.bincount(rows, minlength=count), 1)
    x, y = (axis - (np.bincount(rows, axis, count) / sizes)[rows] for axis in flat)
    order = np.argsort(rows + _turn(x, y))
    x, y, rows = x[order], y[order], rows[order]
    after = _next_in_row(rows, count)
    distinct = (np.abs(x[after] - x) > COINCIDENT) | (np.abs(y[after] - y) > COINCIDENT)
    if not distinct.all():
        x, y, rows, order = x[distinct], y[distinct], rows[distinct], order[distinct]
    # Rows are done when a pass drops none of their corners.
    corners = np.arange(len(rows))
    kept = np.ones(len(rows), dtype=bool)
    while len(corners):
        outward = _turns(x[corners], y[corners], rows[corners], count) > 0
        kept[corners[~outward]] = False
        unfinished = np.zeros(count, dtype=bool)
        unfinished[rows[corners[~outward]]] = True
        corners = corners[outward & unfinished[rows[corners]]]
    rows, order = rows[kept], order[kept]
    points = cut.points[order]
    steps = points[_next_in_row(rows, count)] - points
    lengths = np.sqrt(np.einsum("ni,ni->n", steps, steps))
    return Hulls(
        points=points,
        edges=cut.edges[order],
        fractions=cut.fractions[order],
        starts=np.searchsorted(rows, np.arange(count + 1)),
        perimeters=np.bincount(rows, lengths, count).astype(np.float64),
    )


def _turn(x: Floats, y: Floats) -> Floats:
    """A number from 0 up to below 1 that grows with the angle of a direction."""
    reach = np.abs(x) + np.abs(y)
    cosine = x / np.maximum(reach, 1e-300)
    return np.where(y < 0, 3 + cosine, 1 - cosine) / 4.000001


def _turns(x: Floats, y: Floats, rows: Integers, row_count: int) -> Floats:
    """Twice the signed area of each corner with its neighbours: positive where it is convex."""
    after = _next_in_row(rows, row_count)
    along, across = x[after] - x, y[after] - y
    turns = np.empty(len(rows))
    turns[after] = along * across[after] - across * along[after]
    return turns


def _next_in_row(rows: Integers, row_count: int) -> Integers:
    """For sorted rows, the place of the next member of each one's row, around to its first."""
    starts = np.searchsorted(rows, np.arange(row_count + 1))
    after = np.arange(1, len(rows) + 1)
    filled = starts[1:] > starts[:-1]
    after[starts[1:][filled] - 1] = starts[:-1][filled]
    return after


@dataclass(frozen=True)
class PerimeterGradient:
    """The derivative of one hull's perimeter by the mesh and by the plane.

    Attributes
    ----------
    indices : ndarray of shape (2n,), vertex indices; an index may come up repeatedly.
    by_vertex : ndarray of shape (2n, 3), to be added up by vertex.
    by_origin : ndarray of shape (3,), by a shift of the plane.
    by_normal : ndarray of shape (3,), by a change of the plane's unit normal about the origin.
    """

    indices: Integers
    by_vertex: Floats
    by_origin: Floats
    by_normal: Floats


def perimeter_gradient(
    tied: Hulls, row: int, vertices: Floats, edges: Integers, origin: Floats, normal: Floats
) -> PerimeterGradient:
    """The derivative of one hull's perimeter; the hull's corners slide along their edges.

    Parameters
    ----------
    tied : from :func:`hulls`.
    row : which of them.
    vertices : ndarray of shape (V, 3), the mesh of that row.
    edges : ndarray of shape (2, E), as given to :func:`sections`.
    origin, normal : ndarrays of shape (3,), a point of the plane and its unit normal.
    """
    corners = tied.corners(row)
    loop, fractions = tied.points[corners], tied.fractions[corners, None]
    tail, head = edges[:, tied.edges[corners]]
    towards_next = np.roll(loop, -1, axis=0) - loop
    towards_next /= np.linalg.norm(towards_next, axis=1, keepdims=True)
    by_point = np.roll(towards_next, 1, axis=0) - towards_next
    along = vertices[head] - vertices[tail]
    slide = np.einsum("ni,ni->n", along, by_point) / (along @ normal)
    by_vertex = by_point - slide[:, None] * normal
    return PerimeterGradient(
        indices=np.concatenate([tail, head]),
        by_vertex=np.concatenate([(1 - fractions) * by_vertex, fractions * by_vertex]),
        by_origin=slide.sum() * normal,
        by_normal=-slide @ (loop - origin),
    )
