from dataclasses import replace
from pathlib import Path

import numpy as np
import pygeodesic.geodesic
import pytest
from scipy.spatial import cKDTree

from model import template_mesh
from model.anthropometry import TAPES
from model.geodesics import Bundle, Strip, length_gradient, load_strips, save_strips
from model.geometry import Floats
from model.shape_basis import load_shape_basis
from model.tapes import Geodesic, bundle, legs_of
from model.template_mesh import load_template_mesh
from model.training.population import load_population


def fan(*gates: tuple[int, int], start: int, stop: int) -> Strip:
    """A strip between two vertices, by the left and right ends of its gates."""
    return Strip(
        left=np.array([left for left, _ in gates]),
        right=np.array([right for _, right in gates]),
        ends=np.array([[start] * 3, [stop] * 3]),
        weights=np.array([[1.0, 0.0, 0.0]] * 2),
    )


def ladder(path: Floats, width: float = 1.0) -> tuple[Floats, Strip]:
    """A ribbon of triangles about a polyline in space, its rungs along x; and its strip.

    The way runs from the middle of the ribbon's first rung, which is no gate, to the last.
    """
    left, right = (path + np.array([side * width / 2, 0, 0]) for side in (-1, 1))
    vertices = np.stack([left, right], axis=1).reshape(-1, 3)
    vertices = np.concatenate([vertices, path[[0, -1]]])
    gates = []
    for rung in range(len(path) - 1):
        # From the rung's left end over to the next rung, then that rung itself.
        gates += [(2 * rung, 2 * rung + 3), (2 * rung + 2, 2 * rung + 3)]
    count = 2 * len(path)
    return vertices, fan(*gates[:-1], start=count, stop=count + 1)


def test_over_a_folded_ribbon_the_way_is_as_straight_as_unfolded() -> None:
    path = np.array([[0, 0, 0], [0, 1, 0.5], [0, 1.4, 1.9], [0, 3, 2], [0, 3, 4]], dtype=float)
    path[:, 0] += 0.1 * np.arange(5)
    vertices, strip = ladder(path)
    unfolded = np.linalg.norm(np.diff(path[:, 1:], axis=0), axis=1).sum()
    ((_, way),) = Bundle([[strip]]).ways(vertices)
    assert way.length == pytest.approx(np.hypot(unfolded, 0.4), abs=1e-12)
    assert np.linalg.norm(np.diff(way.points, axis=0), axis=1).sum() == pytest.approx(way.length)


def test_around_a_tube_the_way_is_a_helix() -> None:
    """On a prism of 48 sides a way over 20 of them is the hypotenuse of the unrolled sides."""
    turns = np.arange(21) * 2 * np.pi / 48
    path = np.stack([np.linspace(0, 0.5, 21), np.cos(turns), np.sin(turns)], axis=1)
    vertices, strip = ladder(path, width=3.0)
    around = 20 * 2 * np.sin(np.pi / 48)
    assert Bundle([[strip]]).lengths(vertices[None])[0, 0] == pytest.approx(
        np.hypot(around, 0.5), abs=1e-12
    )


@pytest.mark.parametrize("mirror", [1, -1])
def test_a_way_bends_at_the_corner_of_its_strip(mirror: int) -> None:
    """From (0, 0) to (3, 1.5) around the corner at (1, 1), both ways about."""
    corner, outer = [[1.0, 1.0]], [[-1, 0], [-1, 2], [0, 4], [2, 4]]
    flat = np.array([*corner, *outer, [0, 0], [3.0, 1.5]]) * [mirror, 1]
    vertices = np.column_stack([flat, np.zeros(len(flat))])
    gates = [(outer_vertex, 0)[::mirror] for outer_vertex in (1, 2, 3, 4)]
    ((_, way),) = Bundle([[fan(*gates, start=5, stop=6)]]).ways(vertices)
    assert way.length == pytest.approx(np.sqrt(2) + np.hypot(2, 0.5))
    assert way.fractions == pytest.approx(np.full(4, (1 + mirror) / 2))
    assert way.points[1:-1] == pytest.approx(np.tile(vertices[0], (4, 1)))


def way_from_bend_to_bend(left: Floats, right: Floats) -> float:
    """The shortest way upwards through level gates, by trying all places where it may bend.

    left, right : ndarrays of shape (n, 2), the ends of the gates; the first and the last are
        points. A way runs straight between two ends that see each other through the gates between.
    """
    shortest = {(0, 0): 0.0}
    for gate in range(1, len(left)):
        for at, end in enumerate((left[gate], right[gate])):
            ways = [np.inf]
            for before in range(gate):
                for other, start in enumerate((left[before], right[before])):
                    shares = (left[before + 1 : gate, 1] - start[1]) / (end[1] - start[1])
                    across = start[0] + shares * (end[0] - start[0])
                    seen = (across >= left[before + 1 : gate, 0] - 1e-12) & (
                        across <= right[before + 1 : gate, 0] + 1e-12
                    )
                    if seen.all():
                        so_far = shortest.get((before, other), np.inf)
                        ways.append(so_far + float(np.linalg.norm(end - start)))
            shortest[gate, at] = min(ways)
    return shortest[len(left) - 1, 0]


def test_winding_ribbons_are_passed_from_bend_to_bend() -> None:
    """Ribbons of many lengths that wind to both sides, all pulled taut together."""
    random = np.random.default_rng(8)
    every, strips, expected = [], [], []
    count, bends = 0, 0
    for rungs in (3, 8, 20, 30, 40) * 4:
        path = np.zeros((rungs, 3))
        path[:, 0] = np.cumsum(random.normal(0, 0.7, rungs))
        path[:, 1] = np.cumsum(random.uniform(0.2, 1.0, rungs))
        vertices, strip = ladder(path)
        every.append(vertices)
        strips.append(replace(strip, left=strip.left + count, right=strip.right + count))
        strips[-1] = replace(strips[-1], ends=strip.ends + count)
        count += len(vertices)
        sides = np.array([[-0.5, 0.0], [0.5, 0.0]])
        sides = np.stack([path[:, :2] + side for side in sides])
        sides[:, [0, -1]] = path[[0, -1], :2]
        expected.append(way_from_bend_to_bend(*sides))
    bundled = Bundle([[strip] for strip in strips])
    ways = [way for _, way in bundled.ways(np.concatenate(every))]
    assert [way.length for way in ways] == pytest.approx(expected, abs=1e-9)
    for way in ways:
        bends += int(np.isin(way.fractions, (0, 1)).sum())
        on_skin = np.linalg.norm(np.diff(way.points, axis=0), axis=1).sum()
        assert on_skin == pytest.approx(way.length, abs=1e-9)
    assert bends > 100
    assert bundled.lengths(np.concatenate(every)[None])[0] == pytest.approx(expected, abs=1e-9)


def test_of_several_strips_the_shortest_counts() -> None:
    """Over a tetrahedron's edge between two corners: along one side or the other."""
    vertices = np.array([[0, 0, 1.0], [0, 0, -1.0], [1.0, 0, 0], [-0.5, 1, 0], [-0.5, -3, 0]])
    near, far = (fan((side, 2)[::turn], start=0, stop=1) for side, turn in ((3, 1), (4, -1)))
    lengths = Bundle([[near], [far], [far, near]]).lengths(vertices[None])[0]
    assert lengths[2] == min(lengths[:2])
    assert lengths[0] < lengths[1]


def test_the_gradient_is_the_difference_quotient() -> None:
    random = np.random.default_rng(4)
    template = load_template_mesh()
    vertices = load_shape_basis().vertices(load_population().coefficients[[700]])[0]
    direction = random.normal(size=vertices.shape)
    step = 1e-7
    several = bundle(template, legs_of(TAPES.values()))
    forth, back = several.lengths(
        np.stack([vertices + step * direction, vertices - step * direction])
    )
    for (strip, way), slope in zip(
        several.ways(vertices), (forth - back) / (2 * step), strict=True
    ):
        indices, gradient = length_gradient(strip, way)
        assert np.sum(gradient * direction[indices]) == pytest.approx(slope, abs=1e-5)


def test_ways_agree_with_exact_geodesics_on_fifty_bodies() -> None:
    """A second method: the windows of Mitchell, Mount and Papadimitriou 1987, by pygeodesic."""
    template, population = load_template_mesh(), load_population()
    rows = np.random.default_rng(11).choice(len(population.sexes), 50, replace=False)
    legs = legs_of(TAPES.values())
    several = bundle(template, legs)
    for vertices in load_shape_basis().vertices(population.coefficients[rows]):
        for names, (_, way) in zip(legs, several.ways(vertices), strict=True):
            near = cKDTree(way.points).query(vertices, distance_upper_bound=0.07)[0] < 0.07
            faces = template.faces[near[template.faces].all(axis=1)]
            kept, places = np.unique(faces, return_inverse=True)
            exact = pygeodesic.geodesic.PyGeodesicAlgorithmExact(
                vertices[kept], places.reshape(faces.shape).astype(np.int32)
            )
            ends = [int(np.searchsorted(kept, corner_of(name))) for name in names]
            length, _ = exact.geodesicDistance(*ends)
            assert way.length == pytest.approx(length, abs=1e-3), names


def corner_of(landmark: str) -> int:
    """The vertex that a landmark lies on."""
    template = load_template_mesh()
    indices, weights = template.landmark_weights(landmark)
    assert weights.max() == 1
    return int(indices[weights.argmax()])


def test_strips_are_saved_and_read_back(tmp_path: Path) -> None:
    strips = load_template_mesh().strips
    save_strips(tmp_path / "strips.npz", strips)
    again = load_strips(tmp_path / "strips.npz")
    assert list(again) == list(strips)
    for way, several in strips.items():
        for one, other in zip(several, again[way], strict=True):
            assert (one.left == other.left).all()
            assert (one.right == other.right).all()
            assert (one.ends == other.ends).all()
            assert (one.weights == other.weights).all()


def test_a_way_without_a_strip_is_refused_by_name() -> None:
    bare = replace(load_template_mesh(), strips={})
    with pytest.raises(ValueError, match="no strip from acromion_left to radiale_left"):
        Geodesic(("acromion_left", "radiale_left")).read(bare, bare.vertices[None])


def test_strips_of_other_landmarks_are_refused(tmp_path: Path) -> None:
    """Who corrects a landmark by hand is told that the strips no longer fit it."""
    for name in ("template_mesh.npz", "strips.npz"):
        (tmp_path / name).write_bytes((template_mesh.DATA / name).read_bytes())
    text = (template_mesh.DATA / "landmarks.json").read_text(encoding="utf-8")
    omphalion = load_template_mesh().landmarks["omphalion"]
    moved = text.replace(f'"face": {omphalion.face},', f'"face": {omphalion.face + 1},')
    assert moved != text
    (tmp_path / "landmarks.json").write_text(moved, encoding="utf-8")
    with pytest.raises(ValueError, match="other landmarks than waist_front and omphalion"):
        load_template_mesh.__wrapped__(tmp_path)
