"""Normals against spheres, the garment's edge against planes and on the template."""

import numpy as np
import pytest
import trimesh

from model.appearance import cut_faces, dress, garment_field, linear, vertex_normals
from model.measurements import BODY_KINDS
from model.template_mesh import Body, load_template_mesh


@pytest.fixture(scope="module")
def template():
    return load_template_mesh()


def test_normals_of_points_on_a_sphere_are_exactly_radial():
    rng = np.random.default_rng(4)
    points = rng.normal(size=(200, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    hull = trimesh.convex.convex_hull(points)
    normals = vertex_normals(hull.vertices * 3 + (1, 2, 3), hull.faces)
    np.testing.assert_allclose(normals, hull.vertices, atol=1e-9)


def test_a_vertex_without_a_face_gets_a_normal_of_length_one():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]])
    normals = vertex_normals(vertices, np.array([[0, 1, 2]], dtype=np.int32))
    np.testing.assert_array_equal(normals[:3], [[0, 0, 1]] * 3)
    np.testing.assert_array_equal(normals[3], [0, 1, 0])


def test_a_cut_follows_a_plane_and_keeps_the_surface():
    ball = trimesh.creation.icosphere(subdivisions=3)
    level = 0.2345
    cut = cut_faces(ball.faces.astype(np.int32), ball.vertices[:, 1] - level)
    points = cut.extend(ball.vertices)
    edge = points[len(ball.vertices) :]
    assert np.abs(edge[:, 1] - level).max() < 0.01
    assert points[cut.garment][:, :, 1].min() > level - 0.01
    assert points[cut.skin][:, :, 1].max() < level + 0.01
    whole = trimesh.Trimesh(points, np.concatenate([cut.skin, cut.garment]), process=False)
    assert whole.is_watertight
    assert whole.is_winding_consistent
    assert whole.volume == pytest.approx(ball.volume, rel=1e-12)
    assert whole.area == pytest.approx(ball.area, rel=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_cut_that_meets_no_face_leaves_all_on_one_side(side):
    ball = trimesh.creation.icosphere(subdivisions=1)
    cut = cut_faces(ball.faces.astype(np.int32), np.full(len(ball.vertices), side))
    assert len(cut.ends) == 0
    assert len(cut.garment) == (len(ball.faces) if side > 0 else 0)
    assert len(cut.skin) + len(cut.garment) == len(ball.faces)


@pytest.mark.parametrize("kind", BODY_KINDS)
def test_the_dressed_body_is_the_body(template, kind):
    body = Body(template, template.vertices * (1.1, 0.95, 1.2), kind)
    dressed = dress(body)
    np.testing.assert_array_equal(dressed.positions[: len(body.vertices)], body.vertices)
    np.testing.assert_allclose(np.linalg.norm(dressed.normals, axis=1), 1, atol=1e-12)
    faces = np.concatenate([dressed.skin, dressed.garment])
    surface = trimesh.Trimesh(dressed.positions, faces, process=False)
    plain = trimesh.Trimesh(body.vertices, template.faces, process=False)
    assert surface.is_watertight
    assert surface.volume == pytest.approx(plain.volume, rel=1e-12)


def test_only_the_light_on_the_cloth_is_smoothed(template):
    dressed = dress(Body(template, template.vertices, "female"))
    bare = vertex_normals(template.vertices, template.faces)
    clothed = garment_field(template, "female") > 0
    normals = dressed.normals[: len(bare)]
    np.testing.assert_allclose(normals[~clothed], bare[~clothed], atol=1e-12)

    def roughness(of):
        """How much the normals of neighbours differ, on average."""
        edges = trimesh.geometry.faces_to_edges(template.faces)
        edges = edges[clothed[edges].all(axis=1)]
        return np.linalg.norm(of[edges[:, 0]] - of[edges[:, 1]], axis=1).mean()

    assert roughness(normals) < 0.7 * roughness(bare)


@pytest.mark.parametrize("kind", BODY_KINDS)
def test_the_underwear_covers_what_it_should_and_no_more(template, kind):
    field = garment_field(template, kind)

    def inside(name):
        indices, weights = template.landmark_weights(name)
        return weights @ field[indices] > 0

    assert inside("crotch")
    assert inside("buttock_point_left")
    assert inside("buttock_point_right")
    assert inside("thelion_left") == inside("thelion_right") == (kind != "male")
    for name in ("omphalion", "suprasternale", "midpatella_left", "stylion_right", "vertex"):
        assert not inside(name)
    limbs = np.unique(template.faces[template.faces_of("upper_arm", "lower_arm", "hand")])
    assert (field[limbs] < 0).all()


@pytest.mark.parametrize("kind", BODY_KINDS)
def test_the_underwear_is_one_closed_edge_to_each_opening(template, kind):
    """Waist and two legs; the band has an upper and a lower edge."""
    dressed = dress(Body(template, template.vertices, kind))
    garment = trimesh.Trimesh(dressed.positions, dressed.garment, process=False)
    edges = np.sort(garment.edges, axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    open_edges = edges[count == 1]
    ends = np.bincount(open_edges.ravel())
    assert set(ends[ends > 0]) == {2}
    loops = trimesh.graph.connected_components(open_edges)
    assert len(loops) == (3 if kind == "male" else 5)


def test_light_of_colours():
    np.testing.assert_allclose(linear([0.0, 1.0]), [0, 1])
    assert linear(0.5) == pytest.approx(0.21404, abs=1e-5)
