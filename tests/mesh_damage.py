"""Damage to good meshes, made to be mended: each maker returns the mesh and the truth of it."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import scipy.sparse
import trimesh

from model.template_mesh import load_template_mesh

RUBBISH = -1


@dataclass(frozen=True)
class Damaged:
    """A mesh, and what is true of it.

    truth (F, 3): of each corner, the vertex of the good mesh, or RUBBISH.
    mix (V, V of the good mesh): how each vertex comes from good ones.
    """

    good_points: np.ndarray
    good_faces: np.ndarray
    faces: np.ndarray
    truth: np.ndarray
    mix: scipy.sparse.csr_array

    @property
    def points(self):
        return self.mix @ self.good_points


def intact(mesh) -> Damaged:
    faces = np.asarray(mesh.faces, dtype=np.int64)
    identity = scipy.sparse.eye_array(len(mesh.vertices), format="csr")
    return Damaged(np.asarray(mesh.vertices), faces, faces, faces, identity)


def body() -> Damaged:
    return intact(load_template_mesh())


def ball() -> Damaged:
    """A ball with rings, its poles at the top and the bottom."""
    return intact(trimesh.creation.uv_sphere(radius=0.3, count=[9, 12]))


def block() -> Damaged:
    return intact(trimesh.creation.box().subdivide().subdivide())


# ---------------------------------------------------------------- damage


def with_faces(mesh: Damaged, faces, truth=None) -> Damaged:
    faces = np.reshape(faces, (-1, 3))
    truth = np.full_like(faces, RUBBISH) if truth is None else truth
    return replace(mesh, faces=np.vstack([mesh.faces, faces]), truth=np.vstack([mesh.truth, truth]))


def with_point(mesh: Damaged, *parents: int, scale: float = 1.0) -> tuple[Damaged, int]:
    """A vertex more, in the middle of others (or `scale` times as far from the origin)."""
    row = mesh.mix[list(parents)].sum(axis=0)[None] * (scale / len(parents))
    mix = scipy.sparse.vstack([mesh.mix, scipy.sparse.csr_array(row)], format="csr")
    return replace(mesh, mix=mix), mix.shape[0] - 1


def duplicated(mesh: Damaged, rng, count=3) -> Damaged:
    chosen = rng.choice(len(mesh.good_faces), count, replace=False)
    turn = [[1, 2, 0]]
    return with_faces(
        mesh,
        np.take_along_axis(mesh.faces[chosen], np.repeat(turn, count, 0), 1),
        np.take_along_axis(mesh.truth[chosen], np.repeat(turn, count, 0), 1),
    )


def backed(mesh: Damaged, rng, count=3) -> Damaged:
    """Faces that a coincident one of the opposite winding lies on."""
    chosen = rng.choice(len(mesh.good_faces), count, replace=False)
    return with_faces(mesh, mesh.faces[chosen][:, ::-1], mesh.truth[chosen][:, ::-1])


def repeating(mesh: Damaged, rng) -> Damaged:
    """Faces with a vertex twice, or three times."""
    a, b, _ = mesh.faces[rng.integers(len(mesh.good_faces))]
    return with_faces(mesh, [(a, b, a), (b, b, b)])


def flapped(mesh: Damaged, rng) -> Damaged:
    """A face without area along an edge."""
    a, b, _ = mesh.faces[rng.integers(len(mesh.good_faces))]
    mesh, middle = with_point(mesh, a, b)
    return with_faces(mesh, (b, a, middle))


def finned(mesh: Damaged, rng) -> Damaged:
    """A face that stands off the skin, two faces thick, and one that hangs inside it."""
    a, b, c = mesh.faces[rng.integers(len(mesh.good_faces))]
    mesh, outer = with_point(mesh, a, b, scale=1.01)
    mesh, inner = with_point(mesh, b, c, scale=0.99)
    return with_faces(mesh, [(a, b, outer), (b, a, outer), (b, c, inner)])


def ring_of(mesh: Damaged):
    """A closed ring of edges: above the left foot, or a parallel of the ball."""
    if len(mesh.good_points) > 1000:
        part = load_template_mesh().faces_of("foot_left")
    else:
        part = mesh.good_points[mesh.good_faces][:, :, 2].mean(axis=1) > 0.12
    directed = mesh.good_faces[part][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges, count = np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)
    now = np.empty(len(mesh.good_points), dtype=np.int64)
    now[mesh.truth[mesh.truth >= 0]] = mesh.faces[mesh.truth >= 0]
    return now[edges[count == 1]]


def walled(mesh: Damaged, rng, copies=1) -> Damaged:
    """A wall across the inside, from edge to edge of a ring."""
    ring = ring_of(mesh)
    mesh, middle = with_point(mesh, *np.unique(ring))
    wall = [(a, b, middle)[:: rng.choice([1, -1])] for a, b in ring]
    return with_faces(mesh, wall * copies)


def welded(mesh: Damaged, kept, lost) -> Damaged:
    """Vertices `lost` (n,) become vertices `kept` (n,), half-way between."""
    kept, lost = np.asarray(kept), np.asarray(lost)
    mix = mesh.mix.tolil()
    mix[kept] = mix[lost] = (mesh.mix[kept] + mesh.mix[lost]) / 2
    renamed = np.arange(mesh.mix.shape[0])
    renamed[lost] = kept
    return replace(mesh, faces=renamed[mesh.faces], mix=mix.tocsr())


def vertices_welded(mesh: Damaged, rng) -> Damaged:
    """Two fans meet in a vertex: the skin touches itself in a point."""
    touching = scipy.sparse.coo_array(
        (np.ones(mesh.faces.size), (mesh.faces.ravel(), np.repeat(np.arange(len(mesh.faces)), 3))),
        shape=(mesh.mix.shape[0], len(mesh.faces)),
    ).tocsr()
    for _ in range(100):
        kept, lost = rng.choice(len(mesh.good_points), 2, replace=False)
        near = touching @ touching[[kept]].T.toarray()
        near = touching @ (touching.T @ near)
        if not near[lost, 0] and touching[[kept]].sum() and touching[[lost]].sum():
            return welded(mesh, [kept], [lost])
    raise AssertionError("no two vertices of the skin are far apart")


@cache
def foot_contacts():
    """Pairs of facing triangles (3,), (3,) between the toes of the left foot."""
    template = load_template_mesh()
    good = trimesh.Trimesh(template.vertices, template.faces, process=False)
    foot = np.flatnonzero(template.faces_of("foot_left"))
    centres, normals = good.triangles_center[foot], good.face_normals[foot]
    towards = centres[None] - centres[:, None]
    gap = np.linalg.norm(towards, axis=2)
    facing = (normals @ normals.T < -0.7) & (np.einsum("fgi,fi->fg", towards, normals) > 0)
    facing &= np.arange(len(foot))[:, None] < np.arange(len(foot))
    contacts = []
    for pair in np.argsort(np.where(facing, gap, np.inf), axis=None)[:40:8]:
        one, other = template.faces[foot[list(np.unravel_index(pair, gap.shape))]].astype(np.int64)
        around = good.faces[np.isin(good.faces, one).any(axis=1)]
        if np.isin(good.faces[np.isin(good.faces, other).any(axis=1)], around).any():
            continue
        orders = [other[[0, 2, 1]], other[[2, 1, 0]], other[[1, 0, 2]]]
        apart = [np.linalg.norm(good.vertices[one] - good.vertices[o]) for o in orders]
        contacts.append((one, orders[int(np.argmin(apart))]))
    return contacts


def toes_touching(mesh: Damaged, rng) -> Damaged:
    """SPRING's damage: at the left foot, two faces of two toes have become coincident."""
    contacts = foot_contacts()
    return welded(mesh, *contacts[rng.integers(len(contacts))])


def some_turned(mesh: Damaged, rng) -> Damaged:
    turned = rng.random(len(mesh.faces)) < 0.1
    return turned_at(mesh, turned)


def patch_turned(mesh: Damaged, rng) -> Damaged:
    centres = mesh.points[mesh.faces].mean(axis=1)
    reach = np.linalg.norm(centres - centres[rng.integers(len(centres))], axis=1)
    return turned_at(mesh, reach < np.quantile(reach, 0.3))


def all_turned(mesh: Damaged, rng) -> Damaged:
    return turned_at(mesh, np.ones(len(mesh.faces), dtype=bool))


def turned_at(mesh: Damaged, turned) -> Damaged:
    faces, truth = mesh.faces.copy(), mesh.truth.copy()
    faces[turned], truth[turned] = faces[turned][:, ::-1], truth[turned][:, ::-1]
    return replace(mesh, faces=faces, truth=truth)


def shuffled(mesh: Damaged, rng) -> Damaged:
    order = rng.permutation(len(mesh.faces))
    return replace(mesh, faces=mesh.faces[order], truth=mesh.truth[order])


# ---------------------------------------------------------------- what a repair must be


def joined(*meshes):
    """Several meshes as one: faces and points."""
    whole = trimesh.util.concatenate(meshes)
    return np.asarray(whole.faces), np.asarray(whole.vertices)


def crumpled(seed) -> tuple[np.ndarray, np.ndarray]:
    """Faces and vertices of a ball with some vertices joined at random, however far apart."""
    rng = np.random.default_rng(seed)
    small = trimesh.creation.icosphere(1)
    faces = small.faces.copy()
    for _ in range(rng.integers(1, 6)):
        lost, kept = rng.choice(len(small.vertices), 2, replace=False)
        faces = np.where(faces == lost, kept, faces)
    return faces, small.vertices
