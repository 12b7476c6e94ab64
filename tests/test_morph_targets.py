"""The live preview's targets against the estimator that they stand for, and against the tape."""

from dataclasses import replace

import numpy as np
import pytest
from glb_reader import read, values

from model.anthropometry import TAKEN, measure
from model.appearance import dress, dressed_moves
from model.estimators import load_estimators
from model.gltf import mirrored_order, to_glb
from model.measurements import BODY_KINDS, MEASUREMENTS, MeasurementSet
from model.morph_targets import morph_targets

HALF_MILLIMETRE = 0.5e-3


@pytest.fixture(scope="module", params=BODY_KINDS)
def estimator(request):
    return load_estimators()[request.param]


def people(estimator, names):
    """Values of the middle of the population, and others up to two deviations away."""
    moments = estimator.linear.moments_
    spread = np.sqrt(np.diag(moments)[1:] - moments[0, 1:] ** 2)
    middle = {
        name: (moments[0, 1 + i], spread[i])
        for i, name in enumerate(estimator.names)
        if name in names
    }
    sides = np.random.default_rng(7).uniform(-1, 1, len(middle))
    before = MeasurementSet({name: mean for name, (mean, _) in middle.items()})
    # Of someone heavier or taller, everything is larger: all go one way, none quite alike.
    after = {
        name: mean + (1 + side) * deviation
        for (name, (mean, deviation)), side in zip(middle.items(), sides, strict=True)
    }
    return before, MeasurementSet(after)


def preview(vertices, moves, soles, weights):
    """What a page does with the targets."""
    shown = vertices + np.tensordot(weights, moves, axes=1)
    shown[:, 1] -= shown[soles, 1].min()
    return shown


WIZARD = [name for name, row in MEASUREMENTS.items() if row.in_wizard]


@pytest.mark.parametrize("names", [["stature"], ["stature", "weight", "bust_girth"], WIZARD])
def test_the_targets_are_the_linear_law(estimator, names):
    before, after = people(estimator, names)
    body = estimator.estimate(before)
    morphs = morph_targets(estimator, body, before)
    assert morphs.names == tuple(before)
    weights = (np.array(list(after.values())) - morphs.values) / morphs.steps
    shown = preview(body.vertices, morphs.moves, morphs.soles, weights)
    np.testing.assert_allclose(shown, estimator.estimate(after).vertices, atol=1e-6)


def test_the_slopes_are_those_of_the_tapes(estimator):
    before, _ = people(estimator, WIZARD)
    body = estimator.estimate(before)
    morphs = morph_targets(estimator, body, before)
    taken = measure(body).values
    for i, name in enumerate(morphs.names):
        step = 0.001 * morphs.values[i]
        sides = [
            measure(estimator.estimate(MeasurementSet(dict(before) | {name: before[name] + way})))
            for way in (-step, step)
        ]
        low, high = ([side.values[other] for other in TAKEN] for side in sides)
        slopes = (np.array(high) - low) / (2 * step)
        # A girth may change its plane on the way, which bends its slope.
        off = np.abs(morphs.slopes[:, i] - slopes)
        assert np.median(off) < 1e-3
        assert (off * step < 2e-4 * np.array([taken[other] for other in TAKEN])).all(), name


def test_nothing_asked_is_refused(estimator):
    body = estimator.estimate(MeasurementSet({"stature": 1.7}))
    with pytest.raises(ValueError, match="morph targets"):
        morph_targets(estimator, body, MeasurementSet({}))


def test_normals_turn_with_a_body_that_turns(estimator):
    body = estimator.estimate(MeasurementSet({"stature": 1.7}))
    axis = np.array([0.2, 0.3, -0.4])
    positions, normals = dressed_moves(body, np.cross(axis, body.vertices)[None])
    here = dress(body)
    np.testing.assert_allclose(positions[0], np.cross(axis, here.positions), atol=1e-9)
    np.testing.assert_allclose(normals[0], np.cross(axis, here.normals), atol=1e-9)


def test_normals_follow_the_shape(estimator):
    before, _ = people(estimator, ["stature", "weight"])
    body = estimator.estimate(before)
    move = morph_targets(estimator, body, before).moves[1]
    normals = dressed_moves(body, move[None])[1][0]
    there = dress(replace(body, vertices=body.vertices + 0.01 * move)).normals
    changes = (there - dress(body).normals) / 0.01
    assert np.linalg.norm(normals - changes) < 0.3 * np.linalg.norm(changes)


# ---------------------------------------------------------------- the file

WOMAN = {
    "body": "female",
    "measurements": {"stature": 168, "weight": 68, "bust_girth": 92, "waist_girth": 76},
}


def decoded(glb):
    """The document, its positions, and the targets' positions and normals."""
    document, binary = read(glb)
    skin = document["meshes"][0]["primitives"][0]
    points = values(document, binary, skin["attributes"]["POSITION"]).astype(float)
    targets, normals = (
        np.array([values(document, binary, target[kind]) for target in skin["targets"]])
        for kind in ("POSITION", "NORMAL")
    )
    return document, points, targets, normals


@pytest.fixture(scope="module")
def ask(site):
    def ask(**changes):
        wanted = WOMAN["measurements"] | changes.pop("measurements", {})
        document = WOMAN | {"morph_targets": True} | changes | {"measurements": wanted}
        response = site.test_client().post("/api/v1/avatars.glb", json=document)
        assert response.status_code == 200, response.text
        return decoded(response.data)

    return ask


def test_the_files_preview_is_the_served_linear_body(ask):
    document, points, targets, normals = ask(fit="linear")
    extras = document["meshes"][0]["extras"]
    changed = {"stature": 175, "weight": 79, "bust_girth": 101, "waist_girth": 74}
    served = ask(fit="linear", measurements=changed)[1]
    weights = []
    for name, target in zip(extras["targetNames"], extras["targets"], strict=True):
        assert name == target["name"]
        assert target["unit"] == MEASUREMENTS[name].unit
        si = changed[name] if target["unit"] == "kg" else changed[name] / 100
        weights.append((si - target["value"]) / target["step"])
    shown = preview(points, targets, extras["soles"], weights)
    assert np.linalg.norm(shown - served, axis=1).max() < HALF_MILLIMETRE
    assert np.linalg.norm(points - served, axis=1).max() > 0.05
    assert normals.any(axis=(1, 2)).all()
    for primitive in document["meshes"][0]["primitives"]:
        assert len(primitive["targets"]) == len(document["meshes"][0]["weights"]) == 4


def test_of_all_values_at_once_the_files_preview_is_near_too(estimator):
    """The rounding of 41 targets adds up: all values change, each by up to a twenty-fifth."""
    before, _ = people(estimator, list(MEASUREMENTS))
    assert len(before) == 41
    body = estimator.estimate(before)
    morphs = morph_targets(estimator, body, before)
    document, points, targets, _ = decoded(to_glb(body, morphs=morphs))
    soles = document["meshes"][0]["extras"]["soles"]
    random = np.random.default_rng(3)
    for shares in (*random.uniform(-0.04, 0.04, (5, 41)), *0.1 * np.eye(41)[:5]):
        after = {
            name: value * (1 + share)
            for (name, value), share in zip(before.items(), shares, strict=True)
        }
        weights = (np.array(list(after.values())) - morphs.values) / morphs.steps
        shown = preview(points, targets, soles, weights)
        exact = dress(estimator.estimate(MeasurementSet(after))).positions
        exact = exact[mirrored_order(body.template, body.kind)]
        assert np.linalg.norm(shown - exact, axis=1).max() < HALF_MILLIMETRE


def test_the_file_tells_how_every_measurement_changes(ask, site):
    extras = ask(fit="linear")[0]["meshes"][0]["extras"]
    changed = WOMAN | {"fit": "linear", "measurements": WOMAN["measurements"] | {"bust_girth": 94}}
    rows = site.test_client().post("/api/v1/avatars", json=changed).json["measurements"]
    place = extras["targetNames"].index("bust_girth")
    assert [row["name"] for row in extras["measurements"]] == list(MEASUREMENTS)
    for told, row in zip(extras["measurements"], rows, strict=True):
        value = told["value"] + 0.02 * told["slopes"][place]
        scale = 1 if told["unit"] == "kg" else 100
        assert scale * value == pytest.approx(row["taken"], abs=0.15), row["name"]


def test_the_page_gets_targets_about_the_body_that_it_shows(client):
    client.send(body="male", stature="180", weight="82")
    plain = client.get("/avatar.glb").data
    document, points, targets, _ = decoded(client.get("/avatar.glb?live=1").data)
    assert b"targets" not in plain
    assert document["meshes"][0]["extras"]["targetNames"] == ["stature", "weight"]
    assert points[:, 1].max() == pytest.approx(1.80, abs=0.001)
    top = points[:, 1].argmax()
    step = document["meshes"][0]["extras"]["targets"][0]["step"]
    assert step == 0.18
    assert targets[0][top, 1] == pytest.approx(step, abs=0.01)


def test_a_file_without_targets_names_none():
    body = load_estimators()["neutral"].estimate(MeasurementSet({"stature": 1.7}))
    assert b"targetNames" not in to_glb(body)
