"""Our template laid on the mean shape of a set of scans, to say what is where on it.

First a body of the shape basis is fitted as a whole, shape and pose together, by Gauss-Newton:
its skin goes to the nearest skin that faces the same way, and the scans' skin to it. Then its
vertices are let go, and what holds them together falls step by step: Amberg et al. 2007, *Optimal
step nonrigid ICP algorithms for surface registration*. (trimesh's own version of that starts from
corresponding landmarks, which is what is looked for here, and takes minutes on our template.)
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.sparse import csgraph, csr_array, diags_array
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from model.appearance import vertex_normals
from model.geometry import Floats, Integers, edges_of
from model.shape_basis import ShapeBasis
from model.template_mesh import TemplateMesh

FACING = 0.5
"""Skin is the nearest only to skin whose normal has at least this much of its direction."""

FINE = 0.05
"""Where skin further away than this is looked at, in metres, its nearest vertex is near enough."""


class Skin:
    """A mesh that is asked which of its points is nearest.

    Attributes
    ----------
    vertices, normals : ndarrays of shape (V, 3), metres and unit normals.
    faces : ndarray of shape (F, 3).
    triangles : ndarray of shape (F, 3, 3), the corners of each face.
    face_normals : ndarray of shape (F, 3), of length 1; 0 of a face without area.
    areas : ndarray of shape (V,), see `vertex_areas`.
    """

    def __init__(self, vertices: Floats, faces: NDArray[np.int32]) -> None:
        self.vertices, self.faces = vertices, faces
        self.normals = vertex_normals(vertices, faces)
        self.triangles = vertices[faces]
        across = np.cross(*np.diff(self.triangles, axis=1).transpose(1, 0, 2))
        length = np.linalg.norm(across, axis=1, keepdims=True)
        self.face_normals: Floats = across / np.where(length > 0, length, 1)
        self.areas = vertex_areas(vertices, faces)
        self._tree = cKDTree(vertices)
        corners = faces.ravel()
        order = np.argsort(corners, kind="stable")
        self._around = order // 3
        self._starts = np.searchsorted(corners[order], np.arange(len(vertices) + 1))

    def nearest(self, points: Floats, normals: Floats) -> tuple[Integers, Floats, Floats]:
        """The nearest point of skin that faces the same way, near the nearest vertices.

        Parameters
        ----------
        points, normals : ndarrays of shape (n, 3).

        Returns
        -------
        faces : ndarray of shape (n,).
        closest : ndarray of shape (n, 3), points of these faces.
        distances : ndarray of shape (n,); infinite where no skin near by faces the same way.
        """
        near = np.asarray(self._tree.query(points, k=3)[1])
        counts = self._starts[near + 1] - self._starts[near]
        which = np.repeat(np.arange(len(points)), counts.sum(axis=1))
        counts = counts.ravel()
        ends = np.cumsum(counts)
        place = np.arange(ends[-1]) + np.repeat(self._starts[near].ravel() - ends + counts, counts)
        face = self._around[place]
        closest = trimesh.triangles.closest_point(self.triangles[face], points[which])
        distances = np.linalg.norm(closest - points[which], axis=1)
        distances[np.einsum("ni,ni->n", self.face_normals[face], normals[which]) < FACING] = np.inf
        starts = np.searchsorted(which, np.arange(len(points)))
        least = np.minimum.reduceat(distances, starts)
        hits = np.flatnonzero(distances == least[which])
        best = hits[np.searchsorted(which[hits], np.arange(len(points)))]
        return face[best], closest[best], distances[best]

    def around(self, point: Floats, count: int = 12) -> Integers:
        """The faces around the vertices nearest to one point: (n,)."""
        near = np.asarray(self._tree.query(point, k=count)[1]).tolist()
        return np.concatenate([self._around[self._starts[v] : self._starts[v + 1]] for v in near])

    def nearest_vertex(self, points: Floats, normals: Floats) -> tuple[Integers, Floats]:
        """The nearest vertex that faces the same way, of the six nearest: (n,), distances (n,)."""
        distances, near = map(np.asarray, self._tree.query(points, k=6))
        distances[np.einsum("nki,ni->nk", self.normals[near], normals) < FACING] = np.inf
        best = distances.argmin(axis=1)[:, None]
        return (
            np.take_along_axis(near, best, axis=1)[:, 0],
            np.take_along_axis(distances, best, axis=1)[:, 0],
        )


@dataclass(frozen=True, eq=False)
class Joint:
    """A place where the body bends.

    Attributes
    ----------
    name : such as ``shoulder_left``.
    ring : ndarray of shape (n,), the vertices between the two parts; it turns about their mean.
    share : ndarray of shape (V,), how far each vertex turns with it: 0 to 1, softly.
    """

    name: str
    ring: Integers
    share: Floats


_ARM = (("wrist", 0.02, ("hand",)), ("elbow", 0.04, ("lower_arm", "hand")))
_LEG = (("ankle", 0.03, ("foot",)), ("knee", 0.06, ("lower_leg", "foot")))
_LIMBS = (
    *_ARM,
    ("shoulder", 0.07, ("upper_arm", "lower_arm", "hand")),
    *_LEG,
    ("hip", 0.08, ("upper_leg", "lower_leg", "foot")),
)
"""Joints from the ends inwards: how far in metres the bend is spread, and what is beyond."""


def joints_of(template: TemplateMesh) -> list[Joint]:
    """The joints of a template, those further out first."""
    edges = edges_of(template.faces)
    count = len(template.vertices)
    lengths = np.linalg.norm(np.diff(template.vertices[edges], axis=1)[:, 0], axis=1)
    graph = csr_array((lengths, (edges[:, 0], edges[:, 1])), shape=(count, count))
    joints = []
    limbs = [
        (f"{name}_{side}", spread, [f"{part}_{side}" for part in beyond])
        for side in ("left", "right")
        for name, spread, beyond in _LIMBS
    ]
    for name, spread, parts in [*limbs, ("neck", 0.05, ["head_neck"])]:
        moving = template.faces_of(*parts)
        beyond, behind = (np.zeros(count, dtype=bool) for _ in range(2))
        beyond[template.faces[moving]] = True
        behind[template.faces[~moving]] = True
        ring = np.flatnonzero(beyond & behind)
        away = csgraph.dijkstra(graph, directed=False, indices=ring, min_only=True)
        share = np.clip(0.5 + np.where(beyond, away, -away) / (2 * spread), 0, 1)
        joints.append(Joint(name, ring, share**2 * (3 - 2 * share)))
    return joints


class Mannequin:
    """A body of the shape basis that can be bent: what is fitted.

    Attributes
    ----------
    coefficients : ndarray of shape (K,), its shape.
    turns : ndarray of shape (J + 1, 3, 3), how each joint is turned, and last the whole body.
    move : ndarray of shape (3,), metres.
    """

    def __init__(self, template: TemplateMesh, basis: ShapeBasis) -> None:
        self.template, self.joints, self._basis = template, joints_of(template), basis
        shape = (len(basis.directions), len(basis.half), 3)
        self._directions = np.empty((len(basis.mirror), len(basis.directions), 3), np.float32)
        half = basis.directions.reshape(shape).transpose(1, 0, 2)
        self._directions[basis.mirror[basis.half]] = half * np.array([-1, 1, 1], np.float32)
        self._directions[basis.half] = half
        self.coefficients = np.zeros(len(basis.directions))
        self.turns = np.tile(np.eye(3), (len(self.joints) + 1, 1, 1))
        self.move = np.zeros(3)

    def copy(self) -> "Mannequin":
        """The same body, to be changed on its own."""
        other = object.__new__(Mannequin)
        other.__dict__.update(self.__dict__)
        other.coefficients, other.turns = self.coefficients.copy(), self.turns.copy()
        return other

    def raise_arms(self, angle: float) -> None:
        """Turn both arms up, from how our template holds them, in radians."""
        for number, joint in enumerate(self.joints):
            if joint.name.startswith("shoulder"):
                outwards = angle if joint.name.endswith("left") else -angle
                self.turns[number] = Rotation.from_rotvec([0, 0, outwards]).as_matrix()

    def _unbent(self) -> Floats:
        moved = self.coefficients.astype(np.float32) @ self._basis.directions
        half = self._basis.mean + moved.reshape(-1, 3)
        points = np.empty((len(self._basis.mirror), 3))
        points[self._basis.mirror[self._basis.half]] = half * [-1, 1, 1]
        points[self._basis.half] = half
        return points

    def vertices(self) -> Floats:
        """Its skin: (V, 3), metres."""
        unbent = self._unbent()
        return self._bend(unbent, unbent, slice(None))[-1] + self.move

    def _bend(self, points: Floats, unbent: Floats, rows: slice | Integers) -> list[Floats]:
        """Points before each turn, those further out first, and after the last: each (n, 3)."""
        stages = [points]
        for joint, turn in zip(self.joints, self.turns, strict=False):
            middle = unbent[joint.ring].mean(axis=0)
            turned = (stages[-1] - middle) @ turn.T + middle
            stages.append(stages[-1] + joint.share[rows, None] * (turned - stages[-1]))
        stages.append(stages[-1] @ self.turns[-1].T)
        return stages

    def rows(self, at: Integers, normals: Floats, count: int) -> tuple[Floats, Floats]:
        """How points of the skin move along given directions as the parameters change.

        Parameters
        ----------
        at : ndarray of shape (n,), vertices.
        normals : ndarray of shape (n, 3).
        count : of coefficients that may change.

        Returns
        -------
        points : ndarray of shape (n, 3).
        rows : ndarray of shape (n, count + 3·(J + 1) + 3), by coefficients, turns and move.
        """
        unbent = self._unbent()
        stages = self._bend(unbent[at], unbent, at)
        # Backwards through the turns: what a small step before each does along the normal.
        slopes, by_shape = normals, np.zeros((len(at), count))
        by_turn = np.empty((len(at), len(self.turns), 3))
        by_turn[:, -1] = np.cross(stages[-1], slopes)
        slopes = slopes @ self.turns[-1]
        for number in reversed(range(len(self.joints))):
            joint, turn = self.joints[number], self.turns[number]
            share = joint.share[at, None]
            arm = (stages[number] - unbent[joint.ring].mean(axis=0)) @ turn.T
            by_turn[:, number] = share * np.cross(arm, slopes)
            turned = share * (slopes @ turn - slopes)
            # The middle that it turns about moves with the shape.
            by_shape -= turned @ self._directions[joint.ring, :count].mean(axis=0).T
            slopes = slopes + turned
        by_shape += np.einsum(
            "nki,ni->nk", self._directions[at, :count], slopes.astype(np.float32), optimize=True
        )
        return stages[-1] + self.move, np.hstack([by_shape, by_turn.reshape(len(at), -1), normals])

    def step(
        self,
        target: Skin,
        samples: tuple[Integers, Integers],
        count: int,
        far: float,
        prior_weight: float,
    ) -> float:
        """One step of Gauss-Newton towards a skin.

        Parameters
        ----------
        samples : vertices of ours and of the target's that are looked at.
        count : of coefficients that may change.
        far : skin further away is not looked at, in metres.
        prior_weight : square metres of mean squared distance that a coefficient of one is worth.

        Returns
        -------
        float, the root mean square of the distances before it, each at most `far`.
        """
        vertices = self.vertices()
        ours = Skin(vertices, self.template.faces)
        at, back = samples
        if far > FINE:
            there, distance = target.nearest_vertex(vertices[at], ours.normals[at])
            goals, normals = target.vertices[there], target.normals[there]
        else:
            face, goals, distance = target.nearest(vertices[at], ours.normals[at])
            normals = target.face_normals[face]
        near = distance < far
        vertex, apart = ours.nearest_vertex(target.vertices[back], target.normals[back])
        close = apart < far
        vertex, back = vertex[close], back[close]
        points, rows = self.rows(
            np.concatenate([at[near], vertex]),
            np.concatenate([normals[near], ours.normals[vertex]]),
            count,
        )
        normals = rows[:, -3:]
        goals = np.concatenate([goals[near], target.vertices[back]])
        misses = np.einsum("ni,ni->n", normals, goals - points)
        # Geman and McClure's weights: what lies far off, as fingers may, hardly counts.
        scale = 4 * np.median(np.abs(misses)) + 1e-4
        weights = (1 + (misses / scale) ** 2) ** -2 / len(misses)
        turning = 3 * len(self.joints)
        prior = np.full(rows.shape[1], prior_weight)
        stiff = np.array([joint.name.startswith(("wrist", "ankle")) for joint in self.joints])
        prior[count : count + turning] *= np.repeat(np.where(stiff, 1e3, 10), 3)
        prior[count + turning :] = 1e-12
        angles = Rotation.from_matrix(self.turns[:-1]).as_rotvec().ravel()
        now = np.concatenate([self.coefficients[:count], angles, np.zeros(6)])
        change = np.linalg.solve(
            rows.T @ (rows * weights[:, None]) + np.diag(prior),
            rows.T @ (weights * misses) - prior * now,
        )
        self.coefficients[:count] += change[:count]
        turns = Rotation.from_rotvec(change[count:-3].reshape(-1, 3)).as_matrix()
        self.turns = turns @ self.turns
        self.move = self.move + change[-3:]
        everything = np.concatenate([distance, apart])
        return float(np.sqrt(np.mean(np.minimum(everything, far) ** 2)))


STAGES = (
    (10, 0.3, 1e-6, 3),
    (30, 0.15, 1e-7, 3),
    (100, 0.08, 1e-8, 3),
    (300, 0.03, 1e-12, 6),
)
"""How the whole body is fitted: coefficients, how far is looked, prior, steps. The last prior is
weak: it would pull landmarks along the skin."""

LOST = 0.08
"""Where the whole body is still further off after the first stage, root mean square, in metres, it
will not come to lie on what is no body in a pose like ours."""

ARMS = (0.0, 0.35, -0.25)
"""How much further from the body the arms are tried, in radians."""

STIFFNESS = (0.15, 0.06, 0.03)
"""Metres over which the vertices that are let go still move together, step by step."""


def register(
    template: TemplateMesh, basis: ShapeBasis, target: Skin, coefficients: Floats
) -> tuple[Floats, float]:
    """Our template on another skin.

    Parameters
    ----------
    target : metres, +Y up, facing +Z, standing about where our template stands.
    coefficients : ndarray of shape (K,), a first guess at the shape.

    Returns
    -------
    vertices : ndarray of shape (V, 3), our template's.
    distance : metres, the mean distance of the target's vertices from them; more than `LOST`
        where they do not come to lie on it.
    """
    start = Mannequin(template, basis)
    start.coefficients[:] = coefficients
    random = np.random.default_rng(0)
    areas = vertex_areas(template.vertices, template.faces), target.areas

    def samples(most: int) -> tuple[Integers, Integers]:
        """By area, as fingers have as many vertices as the trunk."""
        ours, theirs = (
            np.sort(
                random.choice(
                    len(area), min(most, len(area) // 2), replace=False, p=area / area.sum()
                )
            )
            for area in areas
        )
        return ours, theirs

    few = samples(1000)
    tried = []
    for angle in ARMS:
        trial = start.copy()
        trial.raise_arms(angle)
        for _ in range(3):
            left = trial.step(target, few, 10, 0.3, 1e-6)
        tried.append((left, trial))
    best = min(tried, key=lambda pair: pair[0])[1]
    for number, (count, far, weak, steps) in enumerate(STAGES):
        chosen = samples(2500 if number < len(STAGES) - 1 else 6000)
        for _ in range(steps):
            left = best.step(target, chosen, min(count, len(coefficients)), far, weak)
        if left > LOST:
            return best.vertices(), left
    vertices = let_go(best.vertices(), template.faces, target)
    ours = Skin(vertices, template.faces)
    _, _, distances = ours.nearest(target.vertices, target.normals)
    return vertices, float(np.mean(np.minimum(distances, 0.1)))


def let_go(vertices: Floats, faces: NDArray[np.int32], target: Skin) -> Floats:
    """Lets vertices, (V, 3), go to the nearest skin, held together less and less: (V, 3)."""
    start, edges = vertices, edges_of(faces)
    ones = np.ones(len(edges))
    ends = csr_array((ones, (edges[:, 0], edges[:, 1])), shape=(len(vertices),) * 2)
    ends = ends + ends.T
    springs: Any = diags_array(ends.sum(axis=1)) - ends
    area = vertex_areas(vertices, faces)
    for stiffness in STIFFNESS:
        _, goals, distances = target.nearest(vertices, vertex_normals(vertices, faces))
        near = np.isfinite(distances)
        scale = 4 * np.median(distances[near]) + 1e-3
        weights = np.where(near, area * (1 + (np.where(near, distances, 0) / scale) ** 2) ** -2, 0)
        pulled = diags_array(weights + 1e-9) + stiffness**2 * springs
        solve = splu(pulled.tocsc(), permc_spec="MMD_AT_PLUS_A").solve
        vertices = start + solve(weights[:, None] * (goals - start))
    return vertices


def vertex_areas(vertices: Floats, faces: NDArray[np.int32]) -> Floats:
    """A third of the area of the faces around each vertex: (V,), square metres."""
    across = np.cross(*np.diff(vertices[faces], axis=1).transpose(1, 0, 2))
    areas = np.linalg.norm(across, axis=1) / 6
    return np.bincount(faces.ravel(), np.repeat(areas, 3), len(vertices)).astype(np.float64)
