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

STRAIGHT = 1e-14
"""Three points of a section that span no larger a parallelogram, in the square of that unit, lie on
a line."""


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
    # As many triangles at a time as leave what they need in the processor's nearest memory.
    some = 4096
    blocks = [
        np.ascontiguousarray(faces[first : first + some].T, dtype=np.intp)
        for first in range(0, len(faces), some)
    ]
    meshes = vertices.reshape(-1, *vertices.shape[-2:])
    columns = (np.ascontiguousarray(mesh.T) for mesh in meshes)
    prisms = [sum(_prisms(three, block) for block in blocks) for three in columns]
    return np.reshape(prisms, vertices.shape[:-2])


def _prisms(coordinates: Floats, corners: NDArray[np.intp]) -> float:
    """The signed prisms between triangles and the ground: (3, V) and (3, F) to their sum."""
    x, y, z = coordinates
    a, b, c = corners
    ax, az = x.take(a), z.take(a)
    # Twice the ground area of each triangle, times its mean height.
    ground = (z.take(b) - az) * (x.take(c) - ax) - (x.take(b) - ax) * (z.take(c) - az)
    return float(ground @ (y.take(a) + y.take(b) + y.take(c))) / 6


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
    below = np.fmin(np.fmax(np.ceil(stations), 0), planes[families]).astype(np.int32)
    tail, head = (below.take(end, axis=1).ravel() for end in edges)
    met = np.flatnonzero(tail != head)
    tail, head = tail[met], head[met]
    counts = np.abs(head - tail)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    plane = np.repeat(np.minimum(tail, head), counts) + step
    meshes, cut = np.divmod(np.repeat(met, counts), edges.shape[1])
    rows = meshes * planes.sum() + firsts[families[edges[0][cut]]] + plane
    tail, head = (end[cut] + meshes * vertices.shape[1] for end in edges)
    every, stations = vertices.reshape(-1, 3), stations.ravel()
    start = stations[tail]
    fractions = (plane - start) / (stations[head] - start)
    points = every.take(tail, axis=0)
    points += fractions[:, None] * (every.take(head, axis=0) - points)
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
    that no corner of the hull is ever lost. Points in one direction from the mean, as in the
    middle of a symmetric body, come in any order: of those only the furthest can be a corner.

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
    ends = _ends(rows)
    distinct = (np.abs(_steps(x, *ends)) > COINCIDENT) | (np.abs(_steps(y, *ends)) > COINCIDENT)
    if not distinct.all():
        x, y, rows, order = x[distinct], y[distinct], rows[distinct], order[distinct]
    # Rows are done when a pass drops none of their corners.
    corners = np.arange(len(rows))
    kept = np.ones(len(rows), dtype=bool)
    while len(corners):
        outward = _outward(x[corners], y[corners], rows[corners])
        inward = corners[~outward]
        kept[inward] = False
        unfinished = np.zeros(count, dtype=bool)
        unfinished[rows[inward]] = True
        corners = corners[outward & unfinished[rows[corners]]]
    rows, order = rows[kept], order[kept]
    loops = cut.points[order]
    steps = _steps(loops, *_ends(rows))
    lengths = np.sqrt(np.einsum("ni,ni->n", steps, steps))
    return Hulls(
        points=loops,
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


def _outward(x: Floats, y: Floats, rows: Integers) -> Booleans:
    """Whether each corner, for sorted rows, is convex, or the tip where a line turns back."""
    first, last = _ends(rows)
    along, across = _steps(x, first, last), _steps(y, first, last)
    turns = np.empty(len(rows))
    turns[1:] = along[:-1] * across[1:] - across[:-1] * along[1:]
    turns[first] = along[last] * across[first] - across[last] * along[first]
    outward: Booleans = turns > STRAIGHT
    if (straight := np.abs(turns) <= STRAIGHT).any():
        further = _steps(x * x + y * y, first, last) > 0
        before = np.empty_like(further)
        before[1:], before[first] = further[:-1], further[last]
        outward |= straight & before & ~further
    return outward


def _steps(points: Floats, first: Integers, last: Integers) -> Floats:
    """From each point to the next of its row, around to the first; see :func:`_ends`."""
    steps = np.empty_like(points)
    np.subtract(points[1:], points[:-1], out=steps[:-1])
    steps[last] = points[first] - points[last]
    return steps


def _ends(rows: Integers) -> tuple[Integers, Integers]:
    """Where each of the sorted rows that are there begins and ends."""
    last = np.flatnonzero(rows[1:] != rows[:-1])
    last = np.append(last, len(rows) - 1) if len(rows) else last
    return np.append(0, last[:-1] + 1) if len(rows) else last, last


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
