"""What cannot be mended is refused, with the place."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from mesh_damage import (
    ball,
    body,
    crumpled,
    joined,
    shuffled,
    vertices_welded,
    walled,
)

from model.training.mesh_repair import UnrepairableMeshError, repair


@pytest.fixture
def rng():
    return np.random.default_rng(20)


# ---------------------------------------------------------------- refusals


def refusal(faces, points) -> UnrepairableMeshError:
    with pytest.raises(UnrepairableMeshError) as refused:
        repair(faces, points)
    x, y, z = refused.value.finding.point
    assert f"near {x:.4f}, {y:.4f}, {z:.4f}" in str(refused.value)
    return refused.value


@pytest.mark.parametrize("make", [body, ball])
@pytest.mark.parametrize("damage", [shuffled, walled, vertices_welded])
def test_a_hole_is_refused_with_its_rim(make, damage, rng):
    mesh = make()
    mesh = damage(mesh, rng)
    (lost,) = np.flatnonzero((np.sort(mesh.truth, 1) == np.sort(mesh.good_faces[40])).all(axis=1))
    a, b, c = sorted(mesh.faces[lost].tolist())
    mesh = replace(mesh, faces=np.delete(mesh.faces, lost, axis=0))
    finding = refusal(mesh.faces, mesh.points).finding
    assert finding.what == "holes, their open edges"
    assert finding.element == "edge"
    assert set(finding.indices) == {(a, b), (a, c), (b, c)}
    assert finding.point == pytest.approx(mesh.points[list(finding.indices[0])].mean(axis=0))


def test_a_hole_is_refused_though_something_closed_lies_inside():
    ball = trimesh.creation.icosphere(3, 1.0)
    eye = trimesh.creation.icosphere(1, 0.2)
    faces, points = joined(ball, eye)
    assert refusal(faces[1:], points).finding.what == "holes, their open edges"


def test_a_limb_cut_off_by_a_wall_that_has_a_hole_is_refused(rng):
    mesh = walled(body(), rng)
    sole = mesh.points[mesh.faces][:, :, 1].mean(axis=1).argmin()
    finding = refusal(np.delete(mesh.faces, sole, axis=0), mesh.points).finding
    edges = {tuple(np.sort(mesh.faces[sole][[i, i - 1]]).tolist()) for i in range(3)}
    assert set(finding.indices) == edges


def test_a_second_body_is_refused():
    ball = trimesh.creation.icosphere(2, 1.0)
    other = trimesh.creation.icosphere(2, 0.3)
    other.apply_translation([2, 0, 0])
    finding = refusal(*joined(ball, other)).finding
    assert finding.what == "faces of a second piece"
    assert finding.indices == tuple(range(len(ball.faces), len(ball.faces) + len(other.faces)))


def test_two_bodies_that_share_an_edge_are_refused():
    one, other = trimesh.creation.box(), trimesh.creation.box()
    other.apply_translation([1, 1, 0])
    whole = trimesh.util.concatenate([one, other])
    whole.merge_vertices()
    assert len(whole.vertices) == 14
    assert refusal(whole.faces, whole.vertices).finding.what == "faces of a second piece"


def klein_bottle(n=8):
    """A grid that is glued to itself the wrong way round; where it lies does not matter."""
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")

    def at(i, j):
        return np.where(i == n, 0, i) * n + np.where(i == n, -j, j) % n

    a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
    faces = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    return faces, np.random.default_rng(0).random((n * n, 3))


def test_a_surface_of_one_side_is_refused():
    faces, points = klein_bottle()
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    finding = refusal(faces, points).finding
    assert finding.what == "faces of one side only"
    assert finding.element == "face"


@pytest.mark.parametrize(
    ("seed", "said"), [(6, "faces around nothing"), (574, "faces without a partner, at edges")]
)
def test_what_has_no_inside_that_could_be_told_is_refused(seed, said):
    assert refusal(*crumpled(seed)).finding.what == said


def test_a_surface_around_nothing_is_refused():
    flat = trimesh.creation.icosphere(0)
    finding = refusal(flat.faces, flat.vertices @ np.diag([1, 1, 0])).finding
    assert finding.what == "faces without volume"


@pytest.mark.parametrize(
    ("faces", "points", "said"),
    [
        ([[0, 1, 2]], np.zeros((3, 2)), r"finite and \(V, 3\)"),
        ([[0, 1, 2]], np.full((3, 3), np.nan), "finite"),
        ([[0, 1, 2, 3]], np.zeros((4, 3)), r"\(F, 3\), they are \(1, 4\)"),
        (np.zeros((0, 3), dtype=int), np.zeros((4, 3)), r"\(F, 3\), they are \(0, 3\)"),
        ([[0, 1, 3]], np.zeros((3, 3)), "from 0 to 2"),
        ([[0, 1, -1]], np.zeros((3, 3)), "from 0 to 2"),
        ([[0.0, 1.0, 2.0]], np.zeros((3, 3)), "from 0 to 2"),
    ],
)
def test_what_is_no_mesh_is_refused(faces, points, said):
    with pytest.raises(ValueError, match=said):
        repair(faces, points)


@pytest.mark.parametrize("shape", [(7, 3), (8, 2), (8,), (2, 9, 3)])
def test_vertices_of_another_mesh_are_refused(shape):
    box = trimesh.creation.box()
    with pytest.raises(ValueError, match=r"expected shape \(\.\.\., 8, 3\)"):
        repair(box.faces, box.vertices).apply(np.zeros(shape))
