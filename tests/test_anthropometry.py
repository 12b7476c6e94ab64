from dataclasses import fields, replace

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from model.anthropometry import (
    TAKEN,
    TAPES,
    ImpossibleBodyError,
    measure,
    measure_batch,
    read_tapes,
)
from model.estimators import load_estimators
from model.geodesics import Bundle, Strip
from model.geometry import Floats
from model.girths import Girth
from model.measurements import BODY_KINDS, MEASUREMENTS, MeasurementSet
from model.shape_basis import load_shape_basis
from model.tapes import BODY_DENSITY, Geodesic, Tape
from model.template_mesh import Body, TemplateMesh, load_template_mesh
from model.training.population import load_population
from model.training.survey import SURVEY_TAPES


def mirrored(tape: Tape) -> Tape:
    """The same tape on the other side of the body."""
    names = {"left": "right", "right": "left"}

    def other(value: object) -> object:
        if isinstance(value, tuple):
            return tuple(other(each) for each in value)
        if isinstance(value, str) and (side := value.rpartition("_")[2]) in names:
            return value.removesuffix(side) + names[side]
        return value

    return replace(tape, **{f.name: other(getattr(tape, f.name)) for f in fields(tape)})


GIRTHS = [name for name in TAKEN if isinstance(TAPES[name], Girth)]


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
def fifty() -> Floats:
    """Fifty bodies of the population, of all builds."""
    coefficients = load_population().coefficients
    rows = np.random.default_rng(7).choice(len(coefficients), 50, replace=False)
    return load_shape_basis().vertices(coefficients[rows])


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
def test_girths_agree_with_trimeshs_sections(fifty: Floats, name: str) -> None:
    """A second route: trimesh cuts the body part at the reported plane, Qhull ties the tape."""
    tape, template = TAPES[name], load_template_mesh()
    assert isinstance(tape, Girth)
    part = template.faces[template.faces_of(*tape.parts)]
    for landmark, radius in tape.past:
        passed = template.landmark_points(template.vertices, landmark)
        far = np.linalg.norm(template.vertices - passed, axis=1) > radius
        part = part[far[part].all(axis=1)]
    for vertices in fifty:
        value, path = tape.take(template, vertices)
        normal = np.linalg.svd(path - path.mean(axis=0))[2][2]
        mesh = trimesh.Trimesh(vertices, part, process=False)
        points = mesh.section(plane_origin=path[0], plane_normal=normal).vertices - path[0]
        across = np.linalg.svd(path - path.mean(axis=0))[2][:2]
        assert ConvexHull(points @ across.T).area == pytest.approx(value, abs=1e-6)


def on_the_right(template: TemplateMesh, strip: Strip) -> Strip:
    """The strip of the other side: seen along the way, left and right change places."""
    return Strip(
        left=template.mirror[strip.right],
        right=template.mirror[strip.left],
        ends=template.mirror[strip.ends],
        weights=strip.weights,
    )


@pytest.mark.parametrize("name", [name for name in TAKEN if mirrored(TAPES[name]) != TAPES[name]])
def test_left_and_right_agree_on_a_symmetric_body(fifty: Floats, name: str) -> None:
    template = load_template_mesh()
    tape = TAPES[name]
    if isinstance(tape, Geodesic):  # strips are kept of the left side alone
        legs = [template.strips[leg] for leg in tape.legs()]
        left, right = (
            Bundle(sides).lengths(fifty).sum(axis=1)
            for sides in (legs, [[on_the_right(template, strip) for strip in leg] for leg in legs])
        )
    else:
        left, right = read_tapes(template, fifty, [tape, mirrored(tape)]).T
    assert left == pytest.approx(right, abs=1e-9)


@pytest.mark.parametrize("name", GIRTHS)
def test_more_girth_asked_is_more_girth_taken(name: str) -> None:
    for estimator in load_estimators().values():
        centre = measure(estimator.estimate(MeasurementSet({"stature": 1.7}))).values[name]
        taken = [
            measure(
                estimator.estimate(MeasurementSet({"stature": 1.7, name: share * centre}))
            ).values[name]
            for share in (0.92, 0.97, 1.0, 1.03, 1.08)
        ]
        assert (np.diff(taken) > 0).all()


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
