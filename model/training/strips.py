"""Finds the strips of skin that geodesic lengths run over, on a sample of bodies.

Exact geodesics come from pygeodesic (the windows of Mitchell, Mount and Papadimitriou 1987,
*The discrete geodesic problem*, SIAM J. Comput. 16). The strips that they cross on different
bodies differ; a few of them serve a whole population.
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
import pygeodesic.geodesic
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from model.geodesics import Bundle, Strip, Strips
from model.geometry import Floats, Integers, edges_of
from model.template_mesh import Landmark, TemplateMesh

TOLERANCE = 5e-4
"""How much longer than the best strip found a chosen one may be on the sample, in metres."""

NEARBY = 0.08
"""How far from the template's shortest way along edges a geodesic may lie, in metres."""

MOST = 6
"""How many strips a way gets at most."""

AT_CORNER = 1 - 1e-9
"""A barycentric coordinate from which on a point is the triangle's corner."""


def find_strips(template: TemplateMesh, bodies: Floats, ways: Iterable[tuple[str, str]]) -> Strips:
    """A few strips for each way between two landmarks.

    Parameters
    ----------
    bodies : ndarray of shape (B, V, 3), the sample, metres.
    ways : names of two landmarks each.

    Raises
    ------
    ValueError
        For a way between landmarks on one triangle.
    """
    neighbours = _Neighbours(template.faces.astype(np.int64))
    ends = {way: [template.landmarks[name] for name in way] for way in ways}
    for way, (start, stop) in ends.items():
        if start.face == stop.face:
            raise ValueError(f"{way[0]} and {way[1]} lie on one triangle")
    bands = {way: neighbours.band(template.vertices, *both) for way, both in ends.items()}
    found: dict[tuple[str, str], list[Strip]] = {way: [] for way in ends}
    for number, body in enumerate(bodies, 1):
        print(f"\rstrips on {number} of {len(bodies)} bodies", end="", flush=True)
        for way, (start, stop) in ends.items():
            path = neighbours.geodesic(body, bands[way], start, stop)
            length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
            known = Bundle([found[way]]).lengths(body[None]).min() if found[way] else np.inf
            if known > length + TOLERANCE / 2:
                found[way].append(neighbours.strip(body, path, start, stop))
    print()
    return {way: choose(strips, bodies) for way, strips in found.items()}


def choose(strips: Sequence[Strip], bodies: Floats) -> tuple[Strip, ...]:
    """The fewest strips, taken greedily, that keep the way short on every body.

    Parameters
    ----------
    strips : of one way, one at least.
    bodies : as in `find_strips`.
    """
    lengths = Bundle([[strip] for strip in strips]).lengths(bodies)
    least = lengths.min(axis=1)
    chosen: list[int] = []
    so_far = np.full(len(bodies), np.inf)
    while len(chosen) < MOST and (so_far - least).max() > TOLERANCE:
        excess = np.minimum(lengths, so_far[:, None]) - least[:, None]
        chosen.append(int(np.lexsort((excess.sum(axis=0), excess.max(axis=0)))[0]))
        so_far = np.minimum(so_far, lengths[:, chosen[-1]])
    return tuple(strips[index] for index in chosen)


class _Neighbours:
    """Which triangles border on which, and which lie around a vertex."""

    def __init__(self, faces: Integers) -> None:
        self.faces = faces
        sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        order = np.lexsort((sides[:, 1], sides[:, 0]))
        pairs = order.reshape(-1, 2) // 3
        self.beside: list[list[int]] = [[] for _ in faces]
        for one, other in pairs.tolist():
            self.beside[one].append(other)
            self.beside[other].append(one)
        corners = np.repeat(np.arange(len(faces)), 3)
        self.around = csr_array((np.ones(faces.size, bool), (faces.ravel(), corners)))
        self.edges = edges_of(faces)

    def band(self, vertices: Floats, start: Landmark, stop: Landmark) -> Integers:
        """The triangles within `NEARBY` of the shortest way along edges: (n, 3)."""
        lengths = np.linalg.norm(np.subtract(*vertices[self.edges.T]), axis=1)
        graph = csr_array((lengths, tuple(self.edges.T)), shape=(len(vertices),) * 2)
        first, last = self._corner(start), self._corner(stop)
        _, before = dijkstra(
            graph, directed=False, indices=np.array([first]), return_predecessors=True
        )
        along = [last]
        while along[-1] != first:
            along.append(int(before[0, along[-1]]))
        distances, _ = cKDTree(vertices[along]).query(vertices, distance_upper_bound=NEARBY)
        return self.faces[(np.asarray(distances) <= NEARBY)[self.faces].all(axis=1)]

    def geodesic(self, vertices: Floats, band: Integers, start: Landmark, stop: Landmark) -> Floats:
        """The shortest path within a band between two landmarks: (n, 3)."""
        kept, places = np.unique(band, return_inverse=True)
        points, faces = vertices[kept], places.reshape(-1, 3)
        ends = []
        for landmark in (start, stop):
            corners = np.searchsorted(kept, self.faces[landmark.face])
            if max(landmark.weights) > AT_CORNER:
                ends.append(int(corners[np.argmax(landmark.weights)]))
                continue
            # A corner of its own, in the middle of its triangle.
            ends.append(len(points))
            points = np.vstack([points, landmark.weights @ points[corners]])
            others = faces[(faces != corners).any(axis=1)]
            split = [[a, b, ends[-1]] for a, b in zip(corners, np.roll(corners, -1), strict=True)]
            faces = np.vstack([others, split])
        solver = pygeodesic.geodesic.PyGeodesicAlgorithmExact(points, faces.astype(np.int32))
        _, path = solver.geodesicDistance(*ends)
        away = np.linalg.norm(path[[0, -1]] - points[ends[0]], axis=1)
        return path if away[0] < away[1] else path[::-1]

    def _corner(self, landmark: Landmark) -> int:
        return int(self.faces[landmark.face][np.argmax(landmark.weights)])

    def strip(self, vertices: Floats, path: Floats, start: Landmark, stop: Landmark) -> Strip:
        """The strip of a path, an ndarray of shape (n, 3) with points on edges and vertices."""
        middles = (path[1:] + path[:-1]) / 2
        wanted = [start.face, *(self._face_at(vertices, point) for point in middles), stop.face]
        faces = [wanted[0]]
        for face in wanted[1:]:
            faces += self._between(vertices, faces[-1], face)
        at: dict[int, int] = {}
        simple: list[int] = []
        for face in faces:  # a triangle that comes again closes a loop, which is left out
            if face in at:
                for left_out in simple[at[face] + 1 :]:
                    del at[left_out]
                del simple[at[face] + 1 :]
            else:
                at[face] = len(simple)
                simple.append(face)
        edges = [self._crossed(one, other) for one, other in pairwise(simple)]
        corners = [
            {
                int(c)
                for c, w in zip(self.faces[end.face], end.weights, strict=True)
                if w > AT_CORNER
            }
            for end in (start, stop)
        ]
        while edges and corners[0] & set(edges[0]):
            edges.pop(0)
        while edges and corners[1] & set(edges[-1]):
            edges.pop()
        if not edges:
            raise ValueError(f"two landmarks lie on one triangle, {start.face}")
        crossed = np.array(edges, dtype=np.int64)
        return Strip(
            left=crossed[:, 0],
            right=crossed[:, 1],
            ends=self.faces[[start.face, stop.face]],
            weights=np.array([start.weights, stop.weights]),
        )

    def _face_at(self, vertices: Floats, point: Floats) -> int:
        """The triangle that a point lies in; on an edge, the one further to the left (+X)."""
        near = np.argsort(((vertices - point) ** 2).sum(axis=1))[:8]
        faces = np.unique(self.around[near].indices)
        a, b, c = np.moveaxis(vertices[self.faces[faces]], 1, 0)
        normal = np.cross(b - a, c - a)
        square = np.einsum("fi,fi->f", normal, normal)
        # No point lies in a triangle without area, as some of a scan's may be.
        real = square > 0
        faces, a, b, c = (array[real] for array in (faces, a, b, c))
        normal, square = normal[real], square[real]
        shares = [
            np.einsum("fi,fi->f", normal, np.cross(q - p, point - p)) / square
            for p, q in ((a, b), (b, c), (c, a))
        ]
        away = np.abs(np.einsum("fi,fi->f", normal, point - a)) / np.sqrt(square)
        inside = np.min(shares, axis=0) - away / np.sqrt(np.sqrt(square))
        on_it = np.flatnonzero(inside > inside.max() - 1e-6)
        return int(faces[on_it[np.argmax((a + b + c)[on_it, 0])]])

    def _between(self, vertices: Floats, start: int, stop: int) -> list[int]:
        """The triangles from one to another over shared edges, without the first."""
        came_from = {start: start}
        rim = [start]
        while stop not in came_from:
            grown = []
            for face in rim:
                for other in sorted(
                    self.beside[face], key=lambda f: -float(vertices[self.faces[f], 0].sum())
                ):
                    if other not in came_from:
                        came_from[other] = face
                        grown.append(other)
            rim = grown
        way = [stop]
        while came_from[way[-1]] != way[-1]:
            way.append(came_from[way[-1]])
        return way[-2::-1]

    def _crossed(self, one: int, other: int) -> tuple[int, int]:
        """The edge from one triangle to its neighbour, its left end first, seen from outside."""
        corners = self.faces[one].tolist()
        apex = next(i for i in range(3) if corners[i] not in self.faces[other])
        return corners[(apex + 2) % 3], corners[(apex + 1) % 3]
