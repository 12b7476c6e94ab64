from dataclasses import replace

import numpy as np
import pytest
import trimesh

from model.girths import Extent, Girth
from model.tapes import Height, Span
from model.template_mesh import Landmark, TemplateMesh


def marked(mesh: trimesh.Trimesh, **marks) -> TemplateMesh:
    """A mesh as a template, with landmarks at the vertices nearest to some points."""
    vertices = mesh.vertices.view(np.ndarray)
    landmarks = {}
    for name, point in marks.items():
        vertex = np.linalg.norm(vertices - point, axis=1).argmin()
        face = np.flatnonzero((mesh.faces == vertex).any(axis=1))[0]
        weights = tuple((mesh.faces[face] == vertex).astype(float).tolist())
        landmarks[name] = Landmark(face=int(face), weights=weights)
    return TemplateMesh(
        vertices=vertices,
        faces=mesh.faces.view(np.ndarray).astype(np.int32),
        face_parts=np.zeros(len(mesh.faces), dtype=np.uint8),
        part_names=("whole",),
        mirror=np.arange(len(vertices), dtype=np.int32),
        landmarks=landmarks,
    )


def turned(profile: list[tuple[float, float]], sections: int = 64) -> trimesh.Trimesh:
    """The solid of revolution of a profile of radii and heights, about the vertical."""
    mesh = trimesh.creation.revolve(np.array(profile), sections=sections)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
    return mesh


def ring(radius: float, sections: int = 64) -> float:
    return 2 * sections * radius * np.sin(np.pi / sections)


@pytest.fixture(scope="module")
def tube() -> TemplateMesh:
    """A closed tube of radius 0.2 and height 2 about an axis that leans by 30 degrees."""
    mesh = trimesh.creation.cylinder(radius=0.2, height=2.0, sections=64)
    ends = np.array([[0, 0, -1.0], [0, 0, 1.0]])
    lean = trimesh.transformations.rotation_matrix(np.radians(-60), [1, 0, 0])
    mesh.apply_transform(lean)
    foot, head = trimesh.transform_points(ends, lean)
    return marked(mesh, foot=foot, head=head)


def test_a_girth_across_its_axis_reads_the_tube(tube: TemplateMesh) -> None:
    girth = Girth(("whole",), ("foot",), ("head",), (0.3, 0.7), "widest", cut="across")
    assert girth.read(tube, tube.vertices[None])[0] == pytest.approx(ring(0.2), abs=1e-9)


def test_a_level_girth_reads_the_slanted_cut(tube: TemplateMesh) -> None:
    across = Girth(("whole",), ("foot",), ("head",), (0.5, 0.5), "widest", cut="across", planes=1)
    level = replace(across, cut="level")
    straight, slanted = (g.read(tube, tube.vertices[None])[0] for g in (across, level))
    axis = tube.landmark_points(tube.vertices, "head") - tube.landmark_points(tube.vertices, "foot")
    stretch = np.linalg.norm(axis) / abs(axis[1])
    theta = np.linspace(0, 2 * np.pi, 100_001)
    ellipse = np.trapezoid(np.hypot(stretch * np.sin(theta), np.cos(theta)), theta) * 0.2
    assert straight < slanted
    assert slanted == pytest.approx(ellipse, rel=2e-3)


def test_spans_and_heights_are_distances_of_landmarks(tube: TemplateMesh) -> None:
    vertices = tube.vertices[None]
    assert Span("foot", "head").read(tube, vertices)[0] == pytest.approx(2.0)
    rise = abs(np.diff([tube.landmark_points(tube.vertices, n)[1] for n in ("foot", "head")])[0])
    assert abs(Height(("head",), ("foot",)).read(tube, vertices)[0]) == pytest.approx(rise)


def test_extents_of_a_tubes_section(tube: TemplateMesh) -> None:
    level = Girth(("whole",), ("foot",), ("head",), (0.5, 0.5), "widest", planes=1)
    breadth, depth = (
        Extent(level, d).read(tube, tube.vertices[None])[0] for d in ("breadth", "depth")
    )
    # The axis leans by 30 degrees in the plane of depth and height.
    assert breadth == pytest.approx(0.4, rel=2e-3)
    assert depth == pytest.approx(0.4 / np.cos(np.radians(30)), rel=2e-3)
    value, path = Extent(level, "depth").take(tube, tube.vertices)
    assert value == pytest.approx(depth)
    assert np.ptp(path[:, 2]) == pytest.approx(depth)


def test_on_a_cone_the_widest_is_at_one_end_and_the_narrowest_at_the_other() -> None:
    cone = marked(turned([(0, 0), (0.4, 0), (0.1, 1.5), (0, 1.5)]), low=[0, 0, 0], high=[0, 1.5, 0])
    widest = Girth(("whole",), ("low",), ("high",), (0.2, 0.8), "widest", planes=7)
    narrowest = replace(widest, pick="narrowest")
    values = [tape.read(cone, cone.vertices[None])[0] for tape in (widest, narrowest)]
    assert values == pytest.approx([ring(0.34), ring(0.16)], abs=1e-9)
    _, path = narrowest.take(cone, cone.vertices)
    assert path[:, 1] == pytest.approx(1.2)


def test_on_a_sphere_level_girths_are_its_circles() -> None:
    mesh = trimesh.creation.uv_sphere(radius=0.5, count=[128, 128])
    sphere = marked(mesh, low=[0, -0.5, 0], high=[0, 0.5, 0])
    for share in (0.3, 0.5, 0.6):
        tape = Girth(("whole",), ("low",), ("high",), (share, share), reach=9.0)
        radius = np.sqrt(0.25 - (share - 0.5) ** 2)
        assert tape.read(sphere, sphere.vertices[None])[0] == pytest.approx(
            2 * np.pi * radius, rel=2e-3
        )


def test_what_is_passed_by_is_not_met() -> None:
    """A thick tube and a thin one beside it: the tape goes round both, or behind the thin one."""
    thick = turned([(0, 0), (0.1, 0), (0.1, 1), (0, 1)])
    thin = turned([(0, 0), (0.02, 0), (0.02, 1), (0, 1)])
    thin.apply_translation([0.3, 0, 0])
    both = trimesh.util.concatenate([thick, thin])
    template = marked(both, low=[0, 0, 0], high=[0, 1, 0], beside=[0.3, 0, 0])
    around_both = Girth(("whole",), ("low",), ("high",), (0.5, 0.5))
    behind = replace(around_both, past=(("beside", 0.05),))
    assert around_both.read(template, template.vertices[None])[0] > 2 * 0.3 + ring(0.02)
    assert behind.read(template, template.vertices[None])[0] == pytest.approx(ring(0.1), abs=1e-9)


def test_where_two_places_compete_the_value_is_continuous() -> None:
    """Two bulges, one growing as the other shrinks: the widest changes place, not value."""

    def body(share: float) -> TemplateMesh:
        bulges = [(0.3, 0), (0.3, 0.2), (0.4 + share, 0.5), (0.3, 0.8)]
        bulges += [(0.4 - share, 1.1), (0.3, 1.4), (0.3, 1.6)]
        mesh = turned([(0, 0), *bulges, (0, 1.6)])
        return marked(mesh, low=[0, 0, 0], high=[0, 1.6, 0])

    tape = Girth(("whole",), ("low",), ("high",), (0.1, 0.9), planes=41, reach=9.0)
    shares = np.linspace(-0.001, 0.001, 21)
    values, heights = [], []
    for share in shares:
        template = body(share)
        value, path = tape.take(template, template.vertices)
        values.append(value)
        heights.append(path[:, 1].mean())
    assert np.ptp(heights) > 0.5, "the widest place has moved from bulge to bulge"
    assert np.abs(np.diff(values)).max() <= 1.01 * ring(shares[1] - shares[0])
