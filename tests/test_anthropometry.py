from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from model import girths
from model.anthropometry import (
    TAKEN,
    TAPES,
    ImpossibleBodyError,
    measure,
    measure_batch,
    read_tapes,
)
from model.estimators import load_estimators
from model.girths import Extent, Girth
from model.measurements import BODY_KINDS, MEASUREMENTS, MeasurementSet
from model.shape_basis import load_shape_basis
from model.tapes import BODY_DENSITY, Height, Span, Tape
from model.template_mesh import Body, Landmark, TemplateMesh, load_template_mesh
from model.training.population import load_population
from model.training.survey import SURVEY_TAPES

GIRTHS = [name for name in TAKEN if MEASUREMENTS[name].kind == "girth"]


@pytest.fixture(scope="module")
def bodies() -> list[Body]:
    """Bodies of all kinds, from slight to heavy."""
    estimators = load_estimators()
    return [
        estimators[kind].estimate(MeasurementSet({"stature": 1.7, "weight": weight}))
        for kind in BODY_KINDS
        for weight in (52, 70, 100)
    ]


@pytest.fixture(scope="module")
def tube() -> TemplateMesh:
    """A closed tube of radius 0.2 and height 2 about a slanted axis, with landmarks on it."""
    mesh = trimesh.creation.cylinder(radius=0.2, height=2.0, sections=64)
    landmarks = {}
    for name, end in (("foot", -1), ("head", 1)):
        vertex = np.linalg.norm(mesh.vertices - [0, 0, end], axis=1).argmin()
        face = np.flatnonzero((mesh.faces == vertex).any(axis=1))[0]
        weights = tuple((mesh.faces[face] == vertex).astype(float).tolist())
        landmarks[name] = Landmark(face=int(face), weights=weights)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.radians(-60), [1, 0, 0]))
    return TemplateMesh(
        vertices=mesh.vertices.view(np.ndarray),
        faces=mesh.faces.view(np.ndarray).astype(np.int32),
        face_parts=np.zeros(len(mesh.faces), dtype=np.uint8),
        part_names=("tube",),
        mirror=np.arange(len(mesh.vertices), dtype=np.int32),
        landmarks=landmarks,
    )


def test_a_girth_across_its_axis_reads_the_tube(tube: TemplateMesh) -> None:
    girth = Girth(("tube",), ("foot",), ("head",), (0.3, 0.7), "widest", cut="across")
    expected = 2 * 64 * 0.2 * np.sin(np.pi / 64)
    assert girth.read(tube, tube.vertices[None])[0] == pytest.approx(expected, abs=1e-9)


def test_a_level_girth_reads_the_slanted_cut(tube: TemplateMesh) -> None:
    across = Girth(("tube",), ("foot",), ("head",), (0.5, 0.5), "widest", cut="across", planes=1)
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
    level = Girth(("tube",), ("foot",), ("head",), (0.5, 0.5), "widest", planes=1)
    breadth, depth = (
        Extent(level, d).read(tube, tube.vertices[None])[0] for d in ("breadth", "depth")
    )
    # The axis leans by 30 degrees in the plane of depth and height.
    assert breadth == pytest.approx(0.4, rel=2e-3)
    assert depth == pytest.approx(0.4 / np.cos(np.radians(30)), rel=2e-3)
    value, path = Extent(level, "depth").take(tube, tube.vertices)
    assert value == pytest.approx(depth)
    assert np.ptp(path[:, 2]) == pytest.approx(depth)


def test_all_41_rows_of_the_table_have_a_tape() -> None:
    assert set(TAKEN) == set(TAPES) == set(MEASUREMENTS)
    assert len(TAKEN) == 41


def test_stature_and_weight_are_the_meshes_own(bodies: list[Body]) -> None:
    for body in bodies:
        values = measure(body).values
        mesh = trimesh.Trimesh(body.vertices, body.template.faces, process=False)
        assert values["stature"] == pytest.approx(mesh.extents[1])
        assert values["weight"] == pytest.approx(mesh.volume * BODY_DENSITY)


@pytest.mark.parametrize("name", GIRTHS)
def test_girths_agree_with_trimeshs_sections(bodies: list[Body], name: str) -> None:
    """A second route: trimesh cuts the body part at the reported plane, Qhull ties the tape."""
    tape = TAPES[name]
    assert isinstance(tape, Girth)
    for body in bodies:
        _, path = tape.take(body.template, body.vertices)
        normal = np.linalg.svd(path - path.mean(axis=0))[2][2]
        part = body.template.faces[body.template.faces_of(*tape.parts)]
        if tape.cut == "along":  # of which the tape goes round what lies beyond its start
            edges = girths._edges(body.template, tape)
            known = {tuple(edge) for edge in edges.tolist()}
            sides = np.sort(part[:, [[0, 1], [1, 2], [2, 0]]], axis=2).tolist()
            part = part[[all(tuple(side) in known for side in face) for face in sides]]
        mesh = trimesh.Trimesh(body.vertices, part, process=False)
        section = mesh.section(plane_origin=path[0], plane_normal=normal)
        flat, _ = section.to_2D()
        value = tape.read(body.template, body.vertices[None])[0]
        assert ConvexHull(flat.vertices).area == pytest.approx(value, abs=1e-6)


def test_paths_are_where_the_values_come_from(bodies: list[Body]) -> None:
    for body in bodies:
        measured = measure(body)
        assert set(measured.paths) == set(TAKEN)
        for name, path in measured.paths.items():
            kind = MEASUREMENTS[name].kind
            if kind == "girth":
                length = np.linalg.norm(np.roll(path, -1, axis=0) - path, axis=1).sum()
            elif kind == "length":
                length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
            elif kind == "height":
                assert path.shape == (2, 3)
                assert path[0, [0, 2]] == pytest.approx(path[1, [0, 2]])
                length = path[0, 1] - path[1, 1]
            else:
                assert path.shape == (0, 3)
                continue
            assert length == pytest.approx(measured.values[name], abs=1e-9), name


def test_tapes_lie_where_their_names_say(bodies: list[Body]) -> None:
    for body in bodies:
        paths = measure(body).paths
        height = {name: path[:, 1].mean() for name, path in paths.items() if len(path) > 2}
        # Where a heavy trunk is narrowest at the navel, waist and abdomen may change places.
        for middle in ("waist", "abdomen"):
            order = ("neck", "bust", middle, "hip", "thigh", "mid_thigh")
            heights = [height[f"{part}_girth"] for part in order]
            assert heights == sorted(heights, reverse=True)
        assert np.abs(paths["bust_girth"][:, 0]).max() < 0.35, "the arms have joined the bust"
        assert paths["thigh_girth"][:, 0].min() > -1e-3, "the other leg has joined the thigh"


def test_a_batch_reads_as_one_by_one(bodies: list[Body]) -> None:
    template = bodies[0].template
    batch = measure_batch(template, np.stack([body.vertices for body in bodies]))
    for row, body in zip(batch, bodies, strict=True):
        assert row == pytest.approx([measure(body).values[name] for name in TAKEN], rel=1e-12)


@pytest.mark.parametrize("name", TAKEN)
def test_measurements_do_not_know_where_the_body_stands(bodies: list[Body], name: str) -> None:
    body = bodies[4]
    moved = body.vertices + np.array([0.3, 0.0, -0.2])
    values = TAPES[name].read(body.template, np.stack([body.vertices, moved]))
    assert values[0] == pytest.approx(values[1], abs=1e-9)


@pytest.mark.parametrize("name", TAKEN)
def test_measurements_scale_with_the_body(bodies: list[Body], name: str) -> None:
    body = bodies[4]
    values = TAPES[name].read(body.template, np.stack([body.vertices, 1.1 * body.vertices]))
    power = 3 if name == "weight" else 1
    assert values[1] == pytest.approx(values[0] * 1.1**power, rel=1e-9)


@pytest.mark.parametrize("name", TAKEN)
def test_a_tiny_change_of_the_body_changes_little(bodies: list[Body], name: str) -> None:
    noise = np.random.default_rng(0).normal(scale=1e-5, size=bodies[0].vertices.shape)
    for body in bodies:
        pair = np.stack([body.vertices, body.vertices + noise])
        before, after = TAPES[name].read(body.template, pair)
        assert abs(after - before) < (0.01 if name == "weight" else 5e-5)


@pytest.mark.parametrize("tape", {**TAPES, **SURVEY_TAPES}.values(), ids={**TAPES, **SURVEY_TAPES})
def test_gradients_are_difference_quotients(bodies: list[Body], tape: Tape) -> None:
    body = bodies[4]
    value, (indices, slopes) = tape.gradient(body.template, body.vertices)
    assert value == pytest.approx(tape.read(body.template, body.vertices[None])[0])
    # A smooth bulge that leaves the soles, the crown and the limbs' axes nearly in place.
    x, y, z = body.vertices.T
    direction = np.stack([x, np.zeros_like(y), z], axis=1) * np.sin(3 * y)[:, None] ** 2
    step = 1e-6
    pair = np.stack([body.vertices + step * direction, body.vertices - step * direction])
    forth, back = tape.read(body.template, pair)
    slope = (forth - back) / (2 * step)
    assert np.sum(slopes * direction[indices]) == pytest.approx(slope, rel=1e-4, abs=1e-5)


def test_a_body_inside_out_is_refused(bodies: list[Body]) -> None:
    inside_out = replace(bodies[0], vertices=bodies[0].vertices * [-1, 1, 1])
    with pytest.raises(ImpossibleBodyError, match="has no weight"):
        measure(inside_out)


def test_no_tape_loses_an_edge_that_it_meets(bodies: list[Body]) -> None:
    """Edges far from a tape's span are left out for speed; none of them ever counts."""
    tapes = [tape for tape in {**TAPES, **SURVEY_TAPES}.values() if isinstance(tape, Girth)]
    population = load_population()
    vertices = load_shape_basis().vertices(population.coefficients[::60])
    quick = read_tapes(load_template_mesh(), vertices, tapes)
    whole = [replace(tape, reach=9.0) for tape in tapes]
    assert quick == pytest.approx(read_tapes(load_template_mesh(), vertices, whole), abs=1e-12)
