import numpy as np
import pytest
import trimesh

from model.template_mesh import TemplateMesh, load_template_mesh


@pytest.fixture(scope="module")
def template() -> TemplateMesh:
    return load_template_mesh()


def test_it_is_one_closed_body_wound_outwards(template: TemplateMesh) -> None:
    mesh = trimesh.Trimesh(template.vertices, template.faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.euler_number == 2
    assert mesh.volume > 0.04


def test_it_is_its_own_mirror_image(template: TemplateMesh) -> None:
    mirrored = template.vertices[template.mirror] * [-1, 1, 1]
    assert np.abs(mirrored - template.vertices).max() < 1e-6
    faces = {tuple(sorted(face)) for face in template.faces.tolist()}
    assert {tuple(sorted(face)) for face in template.mirror[template.faces].tolist()} == faces


def test_the_person_faces_forwards_with_their_left_at_plus_x(template: TemplateMesh) -> None:
    def at(name: str):
        return template.landmark_points(template.vertices, name)

    assert at("toe_tip_left")[2] > at("heel_left")[2]
    assert at("acromion_left")[0] > 0 > at("acromion_right")[0]
    assert at("vertex")[1] > at("cervicale")[1] > at("omphalion")[1] > at("crotch")[1]
    assert at("omphalion")[2] > at("buttock_point_left")[2]


def test_every_landmark_is_a_point_of_its_triangle(template: TemplateMesh) -> None:
    for name, landmark in template.landmarks.items():
        assert 0 <= landmark.face < len(template.faces), name
        assert sum(landmark.weights) == pytest.approx(1), name
        assert min(landmark.weights) >= 0, name


def test_left_and_right_landmarks_mirror_each_other(template: TemplateMesh) -> None:
    lefts = [name for name in template.landmarks if name.endswith("_left")]
    assert lefts
    for left in lefts:
        right = left.removesuffix("_left") + "_right"
        mirrored = template.landmark_points(template.vertices, right) * [-1, 1, 1]
        assert template.landmark_points(template.vertices, left) == pytest.approx(mirrored)


def test_middle_landmarks_lie_in_the_middle(template: TemplateMesh) -> None:
    for name in template.landmarks:
        if not name.endswith(("_left", "_right")):
            assert abs(template.landmark_points(template.vertices, name)[0]) < 1e-6, name


def test_the_mean_point_of_landmarks_is_their_mean(template: TemplateMesh) -> None:
    names = ("acromion_left", "axilla_left")
    each = [template.landmark_points(template.vertices, name) for name in names]
    mean = template.landmark_points(template.vertices, *names)
    assert mean == pytest.approx(np.mean(each, axis=0))


def test_parts_of_both_sides_can_be_named_together(template: TemplateMesh) -> None:
    both = template.faces_of("upper_leg")
    sides = template.faces_of("upper_leg_left") | template.faces_of("upper_leg_right")
    assert (both == sides).all()
    assert template.faces_of(*template.part_names).all()


def test_an_unknown_part_is_refused(template: TemplateMesh) -> None:
    with pytest.raises(ValueError, match="no part 'tail'"):
        template.faces_of("tail")
