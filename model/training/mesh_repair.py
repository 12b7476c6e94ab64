"""Mends a set of corresponded meshes: decided once on their topology, applied to all.

Faces between air and solid (:mod:`model.training.mesh_cells`) are the skin, wound outwards
whatever their winding was; faces with air or solid on both sides are dropped. Where more than
two faces of the skin share an edge it is cut and stitched again in pairs, and a vertex becomes
one for each fan (Guéziec et al. 2001, *Cutting and stitching: converting sets of polygons to
manifold surfaces*).

Coincident faces are either one face twice, or two skins that touch, as at SPRING's left foot.
Where the cells leave it open, the reading with the fewest pieces and handles is taken. Loose
pieces are dropped if they lie inside the body (eyes, teeth) or have no volume to speak of.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.cluster.hierarchy import DisjointSet

from model.geometry import Booleans, Floats, Integers
from model.training.mesh_cells import DEBRIS, SMALL, Cells, HalfEdges, all_inside, linked, volumes

FLAT = 1e-8
"""A face lower than this share of the mesh's diagonal has no area: some 20 nm on a body."""

ALL = -1
"""In the choice of a joint: all of them."""

Element = Literal["vertex", "edge", "face"]


@dataclass(frozen=True)
class Finding:
    """Something found in a mesh, and where.

    Attributes
    ----------
    what : what it is, and what was done with it.
    element : what the indices count.
    indices : the vertices or faces as they were given, or edges as pairs of vertices.
    point : where the first of them is on the reference shape, in its unit.
    """

    what: str
    element: Element
    indices: tuple[int, ...] | tuple[tuple[int, int], ...]
    point: tuple[float, float, float]

    def __str__(self) -> str:
        x, y, z = self.point
        listed = ", ".join(str(index) for index in self.indices[:8])
        more = f" and {len(self.indices) - 8} more" if len(self.indices) > 8 else ""
        place = f"{self.element} {listed}{more}; near {x:.4f}, {y:.4f}, {z:.4f}"
        return f"{self.what}: {len(self.indices)} ({place})"


class UnrepairableMeshError(ValueError):
    """A mesh that cannot be mended: `finding` and the message say what is wrong, and where."""

    def __init__(self, finding: Finding) -> None:
        super().__init__(f"the mesh cannot be mended: {finding}")
        self.finding = finding


@dataclass(frozen=True, eq=False)
class RepairedMesh:
    """A closed 2-manifold wound outwards, and how the meshes of a set become it.

    Attributes
    ----------
    faces : ndarray of shape (F', 3), indices of the new vertices.
    vertex_sources : ndarray of shape (V',), the old vertex of each new one. Old vertices keep
        their order, without those that no face needs; split ones are added at the end.
    face_sources : ndarray of shape (F',), the old face of each new one, ascending.
    vertex_count : V, how many vertices each mesh of the set has.
    findings : what was done, and where; empty for a sound mesh.
    """

    faces: Integers
    vertex_sources: Integers
    face_sources: Integers
    vertex_count: int
    findings: tuple[Finding, ...]

    @property
    def report(self) -> tuple[str, ...]:
        """What was done, a line each."""
        return tuple(str(finding) for finding in self.findings)

    def apply(self, vertices: ArrayLike) -> NDArray[Any]:
        """The vertices of meshes of the set, as the repaired faces count them.

        Parameters
        ----------
        vertices : array of shape (..., V, 3), in any unit.

        Returns
        -------
        ndarray of shape (..., V', 3).

        Raises
        ------
        ValueError
            If there are not V vertices of three coordinates.
        """
        given = np.asarray(vertices)
        if given.ndim < 2 or given.shape[-2:] != (self.vertex_count, 3):
            raise ValueError(f"expected shape (..., {self.vertex_count}, 3), got {given.shape}")
        return given[..., self.vertex_sources, :]


def repair(faces: ArrayLike, reference: ArrayLike) -> RepairedMesh:
    """Decide how a set of corresponded meshes is mended.

    Parameters
    ----------
    faces : array of shape (F, 3), vertex indices.
    reference : array of shape (V, 3), one shape of the set, such as its mean: what needs
        geometry is decided on it. In any unit.

    Raises
    ------
    UnrepairableMeshError
        For holes, surfaces with one side only, a second piece that is not inside the first, and
        faces that cannot be joined in pairs; it states the place.
    ValueError
        For arrays that are no mesh.
    """
    mesh = _Mesh(np.asarray(faces), np.asarray(reference, dtype=np.float64))
    mesh.mend_flat_faces()
    cells = Cells(mesh.faces, mesh.points)
    if cells.one_sided.any():
        one_sided = mesh.sources[cells.first[cells.one_sided]]
        raise UnrepairableMeshError(mesh.finding("faces of one side only", "face", one_sided))
    best = _Reading(mesh, cells, frozenset())
    # It may be simpler with all joints of skins the other way, with a gap, or with one joint so.
    choices = [("joint", ALL)] * (best.joints > 0) + [("gap", int(cell)) for cell in cells.small]
    while choices and not (best.is_simple and choices[0] != ("joint", ALL)):
        kind, number = choices.pop(0)
        trial = _Reading(mesh, cells, best.choices ^ {(kind, number)})
        # What a gap cuts off must not be what makes it simpler: handles must be fewer.
        terms = 3 if kind == "gap" else 4
        if trial.score[:terms] > best.score[:terms]:
            best = trial
        following = number + 1 if kind == "joint" else 0
        if not choices and following < best.joints:
            choices = [("joint", following)]
    if best.fault:
        raise UnrepairableMeshError(best.fault)
    return _finish(best)


class _Mesh:
    """The mesh that is worked on: faces are dropped and mended, and what was done is noted."""

    def __init__(self, faces: NDArray[Any], points: Floats) -> None:
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise ValueError(f"the reference must be finite and (V, 3), it is {points.shape}")
        if faces.ndim != 2 or faces.shape[1] != 3 or len(faces) == 0:
            raise ValueError(f"faces must be (F, 3), they are {faces.shape}")
        if faces.dtype.kind not in "iu" or faces.min() < 0 or faces.max() >= len(points):
            raise ValueError(f"faces must be vertex indices from 0 to {len(points) - 1}")
        self.given, self.points = faces.astype(np.int64), points
        self.faces, self.sources = self.given.copy(), np.arange(len(faces))
        self.findings: list[Finding] = []

    def finding(self, what: str, element: Element, indices: ArrayLike) -> Finding:
        """A finding at vertices (n,), edges (n, 2) or faces (n,) as they were given."""
        places = np.asarray(indices)
        corners = self.given[places[0]] if element == "face" else np.atleast_1d(places[0])
        x, y, z = self.points[corners].mean(axis=0).tolist()
        listed = tuple(tuple(i) if isinstance(i, list) else i for i in places.tolist())
        return Finding(what, element, listed, (x, y, z))

    def note(self, what: str, element: Element, indices: ArrayLike) -> None:
        """Keep a finding, if there is anything to find."""
        if np.size(indices):
            self.findings.append(self.finding(what, element, indices))

    def keep(self, kept: Booleans) -> list[int]:
        """Drop the other faces and return which they were."""
        dropped: list[int] = self.sources[~kept].tolist()
        self.faces, self.sources = self.faces[kept], self.sources[kept]
        return dropped

    def mend_flat_faces(self) -> None:
        """Drop faces without area; where the skin needs one, join or swap an edge of it."""
        low = FLAT * float(np.linalg.norm(np.ptp(self.points, axis=0)))
        repeating, flat, mended = list[int](), list[int](), list[int]()
        for _ in range(10 * len(self.faces)):
            a, b, c = self.faces.T
            repeating += self.keep((a != b) & (b != c) & (c != a))
            corners = self.points[self.faces]
            sides = np.roll(corners, -1, axis=1) - corners
            lengths = np.linalg.norm(sides, axis=2)
            doubled = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
            found = np.flatnonzero(doubled <= low * lengths.max(axis=1))
            if not len(found):
                break
            face = int(found[0])
            triples = np.sort(self.faces, axis=1)
            alike = (triples == triples[face]).all(axis=1)
            distinct = np.flatnonzero(~alike | (np.arange(len(alike)) == face))
            _, first = np.unique(triples[distinct], axis=0, return_index=True)
            shared = HalfEdges(self.faces[distinct[first]]).shared.reshape(-1, 3)
            if alike.sum() > 1 or (shared[distinct[first] == face] % 2).any():
                flat += self.keep(np.arange(len(alike)) != face)
                continue
            mended.append(int(self.sources[face]))
            if lengths[face].min() <= low:
                start, end, _ = np.roll(self.faces[face], -lengths[face].argmin())
                self.faces[self.faces == end] = start
                continue
            # One corner lies on the edge between the others: give that edge up for another.
            start, end, between = np.roll(self.faces[face], -lengths[face].argmax())
            beside = (np.isin(self.faces, (start, end)).sum(axis=1) == 2) & ~alike
            other = self.faces[beside.argmax()]
            apex = other[~np.isin(other, (start, end))][0]
            self.faces[face, self.faces[face] == end] = apex
            self.faces[beside.argmax(), other == start] = between
        else:
            raise UnrepairableMeshError(self.finding("faces without area", "face", mended[-1:]))
        self.note("faces with a repeated vertex, dropped", "face", repeating)
        self.note("faces without area, dropped", "face", flat)
        self.note("faces without area, an edge joined or swapped", "face", mended)


class _Reading:
    """One way to read a mesh: which faces are skin, and how they are joined in pairs."""

    def __init__(self, mesh: _Mesh, cells: Cells, choices: frozenset[tuple[str, int]]) -> None:
        self.mesh, self.cells, self.choices, self.joints = mesh, cells, choices, 0
        solid = cells.solid.copy()
        solid[[cell for kind, cell in choices if kind == "gap"]] = False
        front, behind = solid[cells.sides].T
        skin = front != behind
        touching = (front == behind) & (cells.copies > 1) & cells.enclosing
        self.inner, self.stray = front & behind & ~touching, ~front & ~behind & ~touching
        # Touching skins are two coincident faces, wound against each other; others are one.
        twin = cells.second[touching]
        source = np.concatenate([cells.first[skin], cells.first[touching], twin])
        turned = np.concatenate([front[skin], np.zeros(len(twin), bool), cells.alike[twin]])
        # Of two at the same angle, what bounds the solid that the angle comes from is first.
        contact = np.where(front, 1, -1)[touching]
        ties = np.concatenate([np.zeros(skin.sum(), int), contact, contact])
        order = np.argsort(source)
        self.source, self.turned = source[order], turned[order]
        faces = mesh.faces[self.source]
        self.faces: Integers = np.where(self.turned[:, None], faces[:, [0, 2, 1]], faces)
        self.halves = HalfEdges(self.faces)
        self.fault = self._fault()
        self.score, self.is_simple = (False, 0, 0.0, 0), False
        if not self.fault:
            self._join(np.repeat(ties[order], 3))

    def _fault(self) -> Finding | None:
        """What hinders joining the skin in pairs."""
        edges, mesh = self.halves.edges, self.mesh
        unpaired = np.bincount(self.halves.edge, np.where(self.halves.along, 1, -1)) != 0
        if unpaired.any():
            return mesh.finding("faces without a partner, at edges", "edge", edges[unpaired])
        if len(edges):
            return None
        if len(self.cells.open_edges):
            return mesh.finding("holes, their open edges", "edge", self.cells.open_edges)
        return mesh.finding("faces without volume", "face", mesh.sources)

    def _join(self, ties: Integers) -> None:
        """Find the other half of each half-edge: the pieces, and the fan of each corner."""
        along, edge, shared = self.halves.along, self.halves.edge, self.halves.shared
        order = self.halves.around(self.mesh.points, np.where(along, 0, ties))
        half = np.arange(self.faces.size)
        after = half - half % 3 + (half + 1) % 3
        partner = np.empty_like(half)
        pairs = order[shared[order] == 2].reshape(-1, 2)
        partner[pairs] = pairs[:, ::-1]
        fan = linked(len(half), pairs.ravel(), after[pairs[:, ::-1]].ravel())
        fans = DisjointSet(range(int(fan.max()) + 1))

        def pair(one: int, other: int, ring: list[int]) -> None:
            partner[[one, other]] = other, one
            fans.merge(fan[one], fan[after[other]])
            fans.merge(fan[after[one]], fan[other])
            ring.remove(one)
            ring.remove(other)

        crowded = order[shared[order] > 2]
        rings = np.split(crowded, np.flatnonzero(np.diff(edge[crowded])) + 1)
        waiting = [ring.tolist() for ring in rings if len(ring)]
        while waiting:
            before = sum(map(len, waiting))
            for ring in waiting:
                # Halves that are of one fan at an end belong together, the more at both.
                bonds = {
                    (one, other): fans.connected(fan[one], fan[after[other]])
                    + fans.connected(fan[after[one]], fan[other])
                    for one in ring if along[one]
                    for other in ring if not along[other]
                }  # fmt: skip
                for (one, other), bond in bonds.items():
                    rivals = [b for (i, j), b in bonds.items() if (i == one) != (j == other)]
                    if bond > max(rivals, default=-1):
                        pair(one, other, ring)
            if before == sum(map(len, waiting)):
                for one, other in self._matches(waiting[0]):
                    pair(one, other, waiting[0])
            waiting = [ring for ring in waiting if ring]

        self.corner = linked(len(half), np.r_[half, after], np.r_[after[partner], partner]).reshape(
            -1, 3
        )
        self.piece = linked(len(self.faces), half // 3, partner // 3)
        self.volume: NDArray[Any] = np.bincount(self.piece, volumes(self.mesh.points, self.faces))
        doubled = (HalfEdges(self.corner).shared > 2).reshape(-1, 3).any(axis=1)
        if doubled.any():
            where = self.mesh.sources[self.source[doubled]]
            self.fault = self.mesh.finding("faces that cannot be joined in pairs", "face", where)
            return
        real = np.abs(self.volume) > DEBRIS * self.volume.max()
        euler = len(np.unique(self.corner[self.body])) - self.body.sum() / 2
        self.score = (True, -int(real.sum()), float(euler), -int(self.body.sum()))
        self.is_simple = self.score[:3] == (True, -1, 2.0)

    def _matches(self, ring: list[int]) -> list[tuple[int, int]]:
        """Pairs of the halves around an edge, by angle, where topology does not say.

        Skins touch from outside: across what is solid. The other choice is the next partner.
        """
        left, matches = ring.copy(), dict[int, int]()
        while left:
            for one, other in zip(left, left[1:] + left[:1], strict=True):
                if self.halves.along[other] and not self.halves.along[one]:
                    matches[one] = other
                    left = [half for half in left if half not in (one, other)]
                    break
        ones = sorted(matches, key=ring.index)
        others = [matches[one] for one in ones]
        if len({("joint", ALL), ("joint", self.joints)} & self.choices) == 1:
            others = others[1:] + others[:1]
        self.joints += 1
        return [*zip(ones, others, strict=True)]

    @property
    def body(self) -> Booleans:
        """The faces of the largest piece."""
        return self.piece == self.volume.argmax()


def _finish(reading: _Reading) -> RepairedMesh:
    """The largest piece of a reading as a mesh, if the rest may be left out."""
    mesh, cells, body = reading.mesh, reading.cells, reading.body
    skin = mesh.points[reading.faces[body]]
    for number in np.flatnonzero(reading.volume < reading.volume.max()):
        piece = reading.piece == number
        where = mesh.sources[reading.source[piece]]
        if abs(reading.volume[number]) <= DEBRIS * reading.volume.max():
            mesh.note("faces of a piece without volume, dropped", "face", where)
        elif all_inside(mesh.points[reading.faces[piece]], skin):
            mesh.note("faces of a piece inside, dropped", "face", where)
        else:
            raise UnrepairableMeshError(mesh.finding("faces of a second piece", "face", where))
    stray = np.flatnonzero(reading.stray)
    faces = mesh.faces[cells.first[stray]]
    sheet = linked(len(mesh.points), faces.ravel(), np.roll(faces, 1, axis=1).ravel())[faces[:, 0]]
    for number in np.unique(sheet):
        own = sheet == number
        if cells.share[stray[own]].sum() > SMALL and not all_inside(mesh.points[faces[own]], skin):
            rim = cells.open_edges[np.isin(cells.open_edges, faces[own]).all(axis=1)]
            if len(rim):
                raise UnrepairableMeshError(mesh.finding("holes, their open edges", "edge", rim))
            where = mesh.sources[cells.first[stray[own]]]
            raise UnrepairableMeshError(mesh.finding("faces around nothing", "face", where))

    taken = np.isin(np.arange(len(mesh.faces)), reading.source)
    again = ~taken & (np.bincount(cells.group, taken) > 0)[cells.group]
    turned = mesh.sources[reading.source[body & reading.turned]]
    crowded = np.unique(reading.halves.edge[reading.halves.shared > 2])
    old, corners = reading.faces[body].ravel(), reading.corner[body].ravel()
    _, first, vertex = np.unique(corners, return_index=True, return_inverse=True)
    order = np.lexsort((first, old[first]))
    split = np.diff(old[first][order], prepend=-1) == 0
    order = np.concatenate([order[~split], order[split]])
    sources = old[first][order]
    unused = np.setdiff1d(np.arange(len(mesh.points)), sources)
    mesh.note("coincident faces, dropped", "face", mesh.sources[again])
    mesh.note("faces inside, dropped", "face", mesh.sources[reading.inner[cells.group]])
    mesh.note("stray faces, dropped", "face", mesh.sources[reading.stray[cells.group]])
    mesh.note("faces turned", "face", turned)
    mesh.note("edges of more than two faces, parted", "edge", reading.halves.edges[crowded])
    mesh.note("vertices of more than one fan, split", "vertex", sources[(~split).sum() :])
    mesh.note("vertices without a face, dropped", "vertex", unused)
    return RepairedMesh(
        faces=np.argsort(order)[vertex].reshape(-1, 3),
        vertex_sources=sources,
        face_sources=mesh.sources[reading.source[body]],
        vertex_count=len(mesh.points),
        findings=tuple(mesh.findings),
    )
