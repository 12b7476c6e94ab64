"""A set of scans made from bodies that are known: SPRING's format, and another mesh than ours.

Long edges of the template are split, and edges collapsed until there are as many vertices as SPRING
has; vertices and faces are shuffled. Each vertex is a fixed mix of the template's, so that the
meshes of a set correspond and their measurements are known. At the left foot two triangles of two
toes have become coincident; z is up, people look to -y, and the groin is at 0.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse

from model.template_mesh import load_template_mesh

VERTICES = 12_500
LONG = 0.022
"""Edges of the template longer than this, in metres, are split."""


@dataclass(frozen=True)
class OtherMesh:
    """Another mesh over the same skin.

    faces : (F, 3).
    mix : (V, V of the template), how each vertex comes from the template's.
    """

    faces: np.ndarray
    mix: scipy.sparse.csr_array

    def of(self, bodies):
        """Bodies (n, V of the template, 3) on this mesh: (n, V, 3)."""
        return np.stack([self.mix @ body for body in bodies])


def split_long_edges(faces, points, mix):
    """Every edge longer than LONG is split, and its faces are cut accordingly."""
    pairs = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, which = np.unique(pairs, axis=0, return_inverse=True)
    long = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1) > LONG
    middle = np.where(long, len(points) + np.cumsum(long) - 1, -1)[which].reshape(-1, 3)
    new = (mix[edges[long, 0]] + mix[edges[long, 1]]) / 2
    cut = []
    for face, (ab, bc, ca) in zip(faces.tolist(), middle.tolist(), strict=True):
        ring = [v for v in (face[0], ab, face[1], bc, face[2], ca) if v >= 0]
        if len(ring) == 6:
            cut += [(ab, bc, ca), (ca, face[0], ab), (ab, face[1], bc), (bc, face[2], ca)]
        else:
            # A fan from a new vertex, or the face itself.
            apex = next((i for i, v in enumerate(ring) if v >= len(points)), 0)
            ring = ring[apex:] + ring[:apex]
            cut += [(ring[0], ring[i], ring[i + 1]) for i in range(1, len(ring) - 1)]
    return np.array(cut), scipy.sparse.vstack([mix, new]).tocsr()


def collapse(faces, bodies, kept):
    """Half-edge collapses until so many vertices are left; a manifold stays one.

    Those first that change the skin of these bodies, (n, V, 3), least: by how far the vertex that
    stays lies from the planes of the faces around the one that goes (Garland and Heckbert 1997).
    """
    points = bodies.mean(axis=0).tolist()
    around = [set() for _ in points]
    triangles = dict(enumerate(faces.tolist()))
    for number, face in triangles.items():
        for vertex in face:
            around[vertex].add(number)

    def neighbours(vertex):
        return {v for number in around[vertex] for v in triangles[number]} - {vertex}

    def normal(a, b, c):
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = points[a], points[b], points[c]
        ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx

    def dot(u, v):
        return sum(x * y for x, y in zip(u, v, strict=True))

    def may_go(lost, stays):
        if len(neighbours(lost) & neighbours(stays)) != 2:
            return False
        for number in around[lost] - around[stays]:
            face = triangles[number]
            before, after = normal(*face), normal(*(stays if v == lost else v for v in face))
            turned = dot(before, after) <= 0.7 * (dot(before, before) * dot(after, after)) ** 0.5
            if turned or dot(after, after) < 1e-3 * dot(before, before):
                return False
        return True

    left = len(points)
    while left > kept:
        now = np.array(list(triangles.values()))
        # Both ways along each edge, as the triangles on both sides have it.
        edges = now[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        cost = sum(skin_change(now, body, edges) for body in bodies)
        touched = set()
        for lost, stays in edges[np.argsort(cost)[: len(edges) // 4]].tolist():
            near = neighbours(lost)
            if left == kept:
                break
            if touched & near or not may_go(lost, stays):
                continue
            for number in around[lost] & around[stays]:
                for vertex in triangles.pop(number):
                    around[vertex].discard(number)
            for number in around[lost]:
                triangles[number] = [stays if v == lost else v for v in triangles[number]]
                around[stays].add(number)
            touched |= near
            left -= 1
    return np.array(list(triangles.values()))


def skin_change(faces, points, edges):
    """What each collapse, from the first vertex of an edge to its second, costs: (E,)."""
    a, b, c = points[faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    outer = (normals[:, :, None] * normals[:, None, :]).reshape(-1, 9)
    corners = (np.ones(faces.size), (faces.ravel(), np.repeat(np.arange(len(faces)), 3)))
    around = scipy.sparse.csr_array(corners, shape=(len(points), len(faces)))
    planes = (around @ outer).reshape(-1, 3, 3)
    step = points[edges[:, 1]] - points[edges[:, 0]]
    # The second term keeps triangles from becoming needles where the skin is flat.
    return np.einsum("ei,eij,ej->e", step, planes[edges[:, 0]], step) + 1e-3 * (step**2).sum(axis=1)


def other_mesh(bodies, vertices=VERTICES + 3):
    """The template's skin on another mesh, faithful to these bodies."""
    template = load_template_mesh()
    mix = scipy.sparse.eye_array(len(template.vertices), format="csr")
    faces, mix = split_long_edges(template.faces, template.vertices, mix)
    faces = collapse(faces, np.stack([mix @ body for body in bodies]), vertices)
    random = np.random.default_rng(0)
    used = random.permutation(np.unique(faces))
    place = np.empty(mix.shape[0], dtype=np.int64)
    place[used] = np.arange(len(used))
    return OtherMesh(faces=place[random.permutation(faces)], mix=mix[used])


def toes_touching(mesh):
    """SPRING's damage: a triangle of a toe of the left foot and one of the next are coincident."""
    template = load_template_mesh()
    points = mesh.mix @ template.vertices
    centres = points[mesh.faces].mean(axis=1)
    sides = np.diff(points[mesh.faces], axis=1)
    normals = np.cross(sides[:, 0], sides[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    toes = template.landmark_points(template.vertices, "toe_tip_left") - [0, 0, 0.04]
    near = np.flatnonzero(np.linalg.norm(centres - toes, axis=1) < 0.05)
    towards = centres[near][None] - centres[near][:, None]
    gap = np.linalg.norm(towards, axis=2)
    facing = normals[near] @ normals[near].T < -0.7
    facing &= np.einsum("fgi,fi->fg", towards, normals[near]) > 0
    for pair in np.argsort(np.where(facing, gap, np.inf), axis=None):
        one, other = mesh.faces[near[list(np.unravel_index(pair, gap.shape))]]
        around, beyond = (
            np.unique(mesh.faces[np.isin(mesh.faces, corners).any(axis=1)])
            for corners in (one, other)
        )
        if not np.isin(around, beyond).any():
            break
    orders = [other[[0, 2, 1]], other[[2, 1, 0]], other[[1, 0, 2]]]
    other = min(orders, key=lambda order: np.linalg.norm(points[one] - points[order]))
    mix = mesh.mix.tolil()
    mix[one] = (mesh.mix[one] + mesh.mix[other]) / 2
    kept = np.setdiff1d(np.arange(len(points)), other)
    place = np.empty(len(points), dtype=np.int64)
    place[kept], place[other] = np.arange(len(kept)), np.searchsorted(kept, one)
    return OtherMesh(faces=place[mesh.faces], mix=mix.tocsr()[kept])


def in_spring_axes(body, scan):
    """A scan, (V, 3) in our axes, as SPRING has it: z up, with the body's groin at 0."""
    crotch = load_template_mesh().landmark_points(body, "crotch")
    return (scan - crotch) @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])


def write_obj(path, points, faces):
    """A file of `v` and `f` lines, and nothing else."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")


def write_set(folder, bodies, sexes):
    """Bodies (n, V of the template, 3) as scans, named as SPRING's are; returns their mesh."""
    mesh = toes_touching(other_mesh(bodies))
    for number, (body, sex) in enumerate(zip(bodies, sexes, strict=True)):
        own = folder / f"SPRING_{sex.upper()}"
        own.mkdir(parents=True, exist_ok=True)
        scan = in_spring_axes(body, mesh.mix @ body)
        write_obj(own / f"SPRING{number:04d}.obj", scan, mesh.faces)
    return mesh
