from itertools import product

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from model import geometry


def tube(sides: int = 64, radius: float = 0.3, height: float = 2.0) -> trimesh.Trimesh:
    """An open tube about the vertical, its corners on the circle."""
    turns = np.arange(sides) * 2 * np.pi / sides
    ring = np.stack([radius * np.cos(turns), np.zeros(sides), radius * np.sin(turns)], axis=1)
    vertices = np.concatenate([ring, ring + np.array([0, height, 0])])
    here, there = np.arange(sides), (np.arange(sides) + 1) % sides
    faces = np.concatenate(
        [
            np.stack([here, here + sides, there], axis=1),
            np.stack([there, here + sides, there + sides], axis=1),
        ]
    )
    return trimesh.Trimesh(vertices, faces, process=False)


def hulls_of(mesh: trimesh.Trimesh, origin, normal) -> geometry.Hulls:
    return cut(mesh.vertices.view(np.ndarray), geometry.edges_of(mesh.faces), origin, normal)


def cut(vertices, edges, origin, normal) -> geometry.Hulls:
    normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
    stations = ((vertices - origin) @ normal)[None]
    families = np.zeros(len(vertices), dtype=int)
    points = geometry.sections(vertices[None], edges.T, stations, families, np.ones(1, dtype=int))
    return geometry.hulls(points, normal[None])


def test_a_tubes_girth_is_its_polygons() -> None:
    hulls = hulls_of(tube(), (0, 0.7, 0), (0, 1, 0))
    assert hulls.perimeters[0] == pytest.approx(2 * 64 * 0.3 * np.sin(np.pi / 64), abs=1e-12)


def test_a_slanted_cut_of_a_tube_is_an_ellipse() -> None:
    hulls = hulls_of(tube(sides=2000), (0, 1, 0), (0, 1, 1))
    a, b = 0.3 * np.sqrt(2), 0.3
    theta = np.linspace(0, 2 * np.pi, 200_001)
    ellipse = np.trapezoid(np.hypot(a * np.sin(theta), b * np.cos(theta)), theta)
    assert hulls.perimeters[0] == pytest.approx(ellipse, rel=1e-5)


def test_a_spheres_girth_shrinks_with_height() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=5, radius=1.0)
    for height in (0.0, 0.3, 0.8):
        girth = hulls_of(sphere, (0, height, 0), (0, 1, 0)).perimeters[0]
        assert girth == pytest.approx(2 * np.pi * np.sqrt(1 - height**2), rel=2e-3)


def test_a_plane_through_vertices_counts_them_once() -> None:
    box = trimesh.creation.box(extents=(2, 2, 2)).subdivide()
    assert hulls_of(box, (0, 0, 0), (0, 1, 0)).perimeters[0] == pytest.approx(8, abs=1e-12)


def test_a_plane_that_misses_has_no_girth() -> None:
    hulls = hulls_of(tube(), (0, 5, 0), (0, 1, 0))
    assert hulls.perimeters[0] == 0
    assert len(hulls.loop(0)) == 0


def test_hollows_are_bridged() -> None:
    """Two separate tubes: the tape goes round both."""
    left, right = tube(), tube()
    left.apply_translation([-1, 0, 0])
    right.apply_translation([1, 0, 0])
    both = trimesh.util.concatenate([left, right])
    one = hulls_of(left, (0, 1, 0), (0, 1, 0)).perimeters[0]
    assert hulls_of(both, (0, 1, 0), (0, 1, 0)).perimeters[0] == pytest.approx(one + 4, abs=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 2, np.pi])
def test_points_in_one_direction_from_the_mean_come_in_any_order(angle) -> None:
    """As in the middle of a symmetric body: which of them comes first is a matter of rounding."""
    around = 2 * np.pi * np.arange(12) / 12 + angle
    ring = np.stack([np.cos(around), np.zeros(12), np.sin(around)], axis=1)
    inner = np.array([0.5, 0.6, 0.75])[:, None] * ring[0]
    aside = np.array([-np.sin(angle), 0.0, np.cos(angle)])
    for signs in product((-1e-17, 0.0, 1e-17), repeat=4):
        points = np.concatenate([ring, inner, -inner]) + 0.0
        points[[0, 12, 13, 14]] += np.array(signs)[:, None] * aside
        cut = geometry.Sections(
            points=points,
            rows=np.zeros(len(points), dtype=np.int64),
            edges=np.arange(len(points)),
            fractions=np.zeros(len(points)),
        )
        tied = geometry.hulls(cut, np.array([[0.0, 1.0, 0.0]]))
        assert tied.perimeters[0] == pytest.approx(24 * np.sin(np.pi / 12), abs=1e-12), signs


@pytest.mark.parametrize("seed", range(20))
def test_hulls_agree_with_qhull_on_rough_meshes(seed: int) -> None:
    random = np.random.default_rng(seed)
    mesh = trimesh.creation.icosphere(subdivisions=3)
    mesh.vertices *= 1 + 0.5 * random.random((len(mesh.vertices), 1))
    normal = random.normal(size=3)
    normal /= np.linalg.norm(normal)
    section = mesh.section(plane_origin=[0, 0.1, 0], plane_normal=normal)
    flat, _ = section.to_2D()
    expected = ConvexHull(flat.vertices).area
    hulls = hulls_of(mesh, (0, 0.1, 0), normal)
    assert hulls.perimeters[0] == pytest.approx(expected, rel=1e-9)


def test_the_perimeters_gradient_is_its_difference_quotient() -> None:
    random = np.random.default_rng(0)
    mesh = trimesh.creation.icosphere(subdivisions=2)
    vertices = mesh.vertices.view(np.ndarray) * (1 + 0.2 * random.random((len(mesh.vertices), 1)))
    edges, normal = geometry.edges_of(mesh.faces), np.array([0, 1.0, 0])
    origin = np.array([0, 0.123, 0])

    def girth(moved, at, upright):
        return cut(moved, edges, at, upright)

    hulls = girth(vertices, origin, normal)
    slopes = geometry.perimeter_gradient(hulls, 0, vertices, edges.T, origin, normal)
    direction = random.normal(size=vertices.shape)
    step = 1e-7

    def slope(change) -> float:
        forth, back = (girth(*change(sign * step)).perimeters[0] for sign in (1, -1))
        return (forth - back) / (2 * step)

    by_vertex = slope(lambda t: (vertices + t * direction, origin, normal))
    assert np.sum(slopes.by_vertex * direction[slopes.indices]) == pytest.approx(
        by_vertex, abs=1e-6
    )
    by_origin = slope(lambda t: (vertices, origin + t * normal, normal))
    assert slopes.by_origin @ normal == pytest.approx(by_origin, abs=1e-6)
    tilt = np.array([0.6, 0.0, -0.8])
    by_normal = slope(lambda t: (vertices, origin, normal + t * tilt))
    assert slopes.by_normal @ tilt == pytest.approx(by_normal, abs=1e-6)


def test_planes_through_many_meshes_are_rows_in_order() -> None:
    small, large = tube(radius=0.2), tube(radius=0.4)
    vertices = np.stack([small.vertices, large.vertices])
    stations = (vertices[..., 1] + 1.0) / 1.05  # planes at -1, 0.05, 1.1 and 2.15
    families = np.zeros(len(small.vertices), dtype=int)
    edges = geometry.edges_of(small.faces).T
    points = geometry.sections(vertices, edges, stations, families, np.array([4]))
    hulls = geometry.hulls(points, np.tile([0.0, 1.0, 0.0], (8, 1)))
    girth = 2 * 64 * np.sin(np.pi / 64)
    expected = [0, 0.2 * girth, 0.2 * girth, 0, 0, 0.4 * girth, 0.4 * girth, 0]
    assert hulls.perimeters == pytest.approx(expected, abs=1e-12)
    assert hulls.loop(6)[:, 1] == pytest.approx(1.1)


def test_a_collapsed_mesh_has_no_section() -> None:
    mesh = tube()
    stations = np.full((1, len(mesh.vertices)), np.nan)
    families = np.zeros(len(mesh.vertices), dtype=int)
    edges = geometry.edges_of(mesh.faces).T
    points = geometry.sections(mesh.vertices[None], edges, stations, families, np.array([9]))
    assert len(points.points) == 0


def test_volume_of_closed_forms() -> None:
    box = trimesh.creation.box(extents=(2, 3, 4))
    moved = np.stack([box.vertices, box.vertices + 5])
    assert geometry.volume(moved, box.faces) == pytest.approx([24, 24], abs=1e-12)


def test_the_volumes_gradient_is_its_difference_quotient() -> None:
    random = np.random.default_rng(0)
    mesh = trimesh.creation.icosphere(subdivisions=1)
    vertices = mesh.vertices.view(np.ndarray) + 0.05 * random.normal(size=mesh.vertices.shape)
    direction, step = random.normal(size=vertices.shape), 1e-6
    slope = (
        geometry.volume(vertices + step * direction, mesh.faces)
        - geometry.volume(vertices - step * direction, mesh.faces)
    ) / (2 * step)
    gradient = geometry.volume_gradient(vertices, mesh.faces)
    assert np.sum(gradient * direction) == pytest.approx(slope, abs=1e-8)


def test_each_edge_is_listed_once() -> None:
    box = trimesh.creation.box()
    assert len(geometry.edges_of(box.faces)) == len(box.edges_unique)
