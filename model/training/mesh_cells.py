"""Cells: the parts of space that the faces of a mesh, sound or not, set apart.

Around an edge, each face looks into the wedge between itself and the next one. The sides of
faces that look into one wedge, from edge to edge, look into one cell. The cell around
everything is air, the others are solid; how faces are wound plays no part (Zhou et al. 2016,
*Mesh arrangements for solid geometry*).
"""

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.cluster.hierarchy import DisjointSet
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from model.geometry import Booleans, Floats, Integers

SMALL = 1e-3
"""A sheet of less than this share of the surface may be left out wherever it is."""

GAP = 1e-2
"""What touching skins close in between them is less than this share of the body's volume."""

DEBRIS = 1e-6
"""A piece of less than this share of the body's volume, 0.07 ml of 70 l, is no piece."""


def linked(count: int, first: Integers, second: Integers) -> Integers:
    """Number the components of a graph.

    Parameters
    ----------
    count : how many nodes there are.
    first, second : ndarrays of shape (n,), the two nodes of each link.

    Returns
    -------
    ndarray of shape (count,), the component of each node.
    """
    links = coo_array((np.ones(len(first), dtype=bool), (first, second)), shape=(count, count))
    return connected_components(links, directed=False)[1].astype(np.int64)


class HalfEdges:
    """The half-edges of faces: number 3 · face + corner runs from that corner to the next.

    Attributes
    ----------
    faces : ndarray of shape (F, 3), vertex indices.
    along : ndarray of shape (3F,), whether it runs from the smaller vertex index.
    edges : ndarray of shape (E, 2), vertices of each edge, the smaller first.
    edge : ndarray of shape (3F,), the edge of each half-edge.
    shared : ndarray of shape (3F,), how many faces share that edge.
    """

    def __init__(self, faces: Integers) -> None:
        self.faces = faces
        starts, ends = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
        self.along: Booleans = starts < ends
        base = int(faces.max(initial=0)) + 1
        keys, self.edge, count = np.unique(
            np.minimum(starts, ends) * base + np.maximum(starts, ends),
            return_inverse=True,
            return_counts=True,
        )
        self.edges = np.stack(np.divmod(keys, base), axis=1)
        self.shared = count[self.edge]

    def around(self, points: Floats, ties: Integers) -> Integers:
        """The half-edges edge by edge, and around an edge of three or more by angle.

        Parameters
        ----------
        points : ndarray of shape (V, 3).
        ties : ndarray of shape (3F,), what comes first at the same angle.

        Returns
        -------
        ndarray of shape (3F,), half-edges; the angle grows as a right-handed screw turns that
        runs along the edge.
        """
        angle = np.zeros(len(self.edge))
        crowded = np.flatnonzero(self.shared > 2)
        low, high = points[self.edges[self.edge[crowded]]].transpose(1, 0, 2)
        axis = (high - low) / np.linalg.norm(high - low, axis=1, keepdims=True)
        across = np.cross(axis, np.eye(3)[np.abs(axis).argmin(axis=1)])
        up = np.cross(axis, across)
        towards = points[np.roll(self.faces, -2, axis=1).ravel()[crowded]] - low
        angle[crowded] = np.arctan2((towards * up).sum(axis=1), (towards * across).sum(axis=1))
        return np.lexsort((ties, angle, self.edge))


class Cells:
    """The cells of a mesh, and the distinct faces between them.

    Coincident faces (same vertices, wound either way) count as one distinct face.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), vertex indices; none without area.
    points : ndarray of shape (V, 3).

    Attributes
    ----------
    first, second : ndarrays of shape (G,), the first two faces of each distinct one; F where
        there is no second.
    copies : ndarray of shape (G,), how many there are.
    group : ndarray of shape (F,), the distinct face of each face.
    alike : ndarray of shape (F,), whether it is wound as the first of its group.
    sides : ndarray of shape (G, 2), the cell before (where the normal points) and behind.
    one_sided : ndarray of shape (G,), faces of a surface like Möbius' strip.
    solid : ndarray of shape (C,), which cells are solid.
    small : ndarray of shape (n,), solid cells that could be gaps between touching skins.
    enclosing : ndarray of shape (G,), faces that belong to something with volume.
    open_edges : ndarray of shape (n, 2), vertices of edges with a single face.
    share : ndarray of shape (G,), of the whole surface.
    """

    def __init__(self, faces: Integers, points: Floats) -> None:
        _, self.first, self.group, self.copies = np.unique(
            np.sort(faces, axis=1),
            axis=0,
            return_index=True,
            return_inverse=True,
            return_counts=True,
        )
        rank = np.argsort(faces, axis=1)
        even = (rank[:, 1] - rank[:, 0]) % 3 == 1
        self.alike: Booleans = even == even[self.first][self.group]
        later = np.setdiff1d(np.arange(len(faces)), self.first)
        self.second = np.full(len(self.first), len(faces))
        np.minimum.at(self.second, self.group[later], later)

        distinct = faces[self.first]
        halves = HalfEdges(distinct)
        self.open_edges = halves.edges[halves.edge[halves.shared == 1]]
        self.share = trimesh.triangles.area(points[distinct])
        self.share /= self.share.sum()
        self.sides, self.one_sided = _sides(halves, points, self.share)

        wedges = volumes(points, distinct)
        volume = np.bincount(self.sides.ravel(), np.stack([-wedges, wedges], axis=1).ravel())
        # Of the cells of each connected lot of faces one is outside: as large as all others.
        lot = linked(len(volume), *self.sides.T)
        outside = np.lexsort((volume, lot))[np.flatnonzero(np.diff(np.sort(lot), prepend=-1))]
        largest = max(-volume.min(), DEBRIS * float(np.linalg.norm(np.ptp(points, axis=0))) ** 3)
        filled = (-volume[outside] > DEBRIS * largest)[lot]
        self.solid: Booleans = filled.copy()
        self.solid[outside] = False
        self.enclosing = filled[self.sides[:, 0]]
        same_lot = lot == lot[volume.argmin()]
        self.small = np.flatnonzero(self.solid & same_lot & (volume < GAP * largest))


def _sides(halves: HalfEdges, points: Floats, share: Floats) -> tuple[Integers, Booleans]:
    """The cells before and behind each of G distinct faces (G, 2), and one-sided faces (G,)."""
    count = len(share)
    # Node 2 i is the front of face i, 2 i + 1 its back. Around an edge, a half-edge's face has
    # one side that looks ahead, to the next half-edge's face, which looks back with its other.
    order = halves.around(points, np.zeros(3 * count, dtype=np.int64))
    starts = np.flatnonzero(np.diff(halves.edge[order], prepend=-1))
    place = np.arange(1, 3 * count + 1)
    place[np.append(starts[1:], 3 * count) - 1] = starts
    follower = np.empty_like(order)
    follower[order] = order[place]
    front = 2 * (np.arange(3 * count) // 3)
    ahead, back = front + ~halves.along, (front + halves.along)[follower]
    plain = halves.shared == 2
    side = linked(2 * count, ahead[plain], back[plain]).reshape(count, 2)
    one_sided = side[:, 0] == side[:, 1]

    spaces = DisjointSet(range(int(side.max()) + 1))
    open_sides = side[(halves.shared == 1).reshape(count, 3).any(axis=1)]
    for one, other in np.unique(open_sides, axis=0).tolist():
        spaces.merge(one, other)
    # Where skins run through each other, some wedges would join the inside and the outside of
    # one of them: what most edges say goes first, and contradictions are left out.
    patches = np.unique(np.sort(side, axis=1), axis=0)
    extent = np.bincount(side.ravel(), np.repeat(share, 2))[patches[:, 0]]
    skins = patches[(extent > SMALL) & ~np.isin(patches[:, 0], open_sides)].tolist()
    links = np.stack([side.ravel()[ahead], side.ravel()[back]], axis=1)[halves.shared > 2]
    links, often = np.unique(np.sort(links, axis=1), axis=0, return_counts=True)
    for one, other in links[np.argsort(-often, kind="stable")].tolist():
        ends = {spaces[one], spaces[other]}
        if not any({spaces[before], spaces[behind]} == ends for before, behind in skins):
            spaces.merge(one, other)
    cells = np.array([spaces[space] for space in range(int(side.max()) + 1)])
    return np.unique(cells, return_inverse=True)[1][side], one_sided


def volumes(points: Floats, faces: Integers) -> Floats:
    """The signed volume between the middle of the points and each face.

    Parameters
    ----------
    points : ndarray of shape (V, 3).
    faces : ndarray of shape (F, 3).

    Returns
    -------
    ndarray of shape (F,), cubic units; of a closed mesh they add up to its volume.
    """
    volume: Floats = np.linalg.det(points[faces] - points.mean(axis=0)) / 6
    return volume


def all_inside(triangles: NDArray[np.float64], skin: NDArray[np.float64]) -> bool:
    """Whether the middles of triangles (some 64 of them, if there are more) lie inside a skin.

    By the winding number, a sum of solid angles (Van Oosterom & Strackee 1983, *The solid angle
    of a plane triangle*).

    Parameters
    ----------
    triangles : ndarray of shape (n, 3, 3), corners.
    skin : ndarray of shape (F, 3, 3), corners of a closed mesh wound outwards.
    """
    for point in triangles[:: max(1, len(triangles) // 64)].mean(axis=1):
        a, b, c = (skin - point).transpose(1, 0, 2)
        far_a, far_b, far_c = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
        above = (a * np.cross(b, c)).sum(axis=1)
        below = far_a * far_b * far_c + (a * b).sum(axis=1) * far_c
        below += (b * c).sum(axis=1) * far_a + (c * a).sum(axis=1) * far_b
        # Half of the solid angle each; all of it is 4 π inside, nothing outside.
        if np.arctan2(above, below).sum() < np.pi:
            return False
    return True
