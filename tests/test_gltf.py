"""The file against its standard, read back by another library and by the standard's validator."""

import io
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import trimesh
from glb_reader import read, values

from model.appearance import dress
from model.estimators import load_estimators
from model.gltf import mirrored_order, to_glb
from model.measurements import BODY_KINDS, MeasurementSet
from model.morph_targets import morph_targets
from model.template_mesh import Body, load_template_mesh

ROOT = Path(__file__).parents[1]
EXTRAS = {"estimator": {"version": "1.0"}, "measurements": {"stature": 1.68, "name": "Zoë"}}


@pytest.fixture(scope="module", params=BODY_KINDS)
def body(request):
    template = load_template_mesh()
    return Body(template, template.vertices, request.param)


@pytest.fixture(scope="module")
def glb(body):
    return to_glb(body, EXTRAS)


def test_the_points_are_the_bodys_to_a_hundredth_of_a_millimetre(body, glb):
    document, binary = read(glb)
    skin, _ = document["meshes"][0]["primitives"]
    positions = values(document, binary, skin["attributes"]["POSITION"])
    order = mirrored_order(body.template, body.kind)
    np.testing.assert_array_equal(np.sort(order), np.arange(len(order)))
    np.testing.assert_allclose(positions, dress(body).positions[order], rtol=0, atol=1e-5)


def test_each_point_stands_beside_its_mirror_image(body, glb):
    document, binary = read(glb)
    skin, _ = document["meshes"][0]["primitives"]
    positions = values(document, binary, skin["attributes"]["POSITION"])
    aside = np.flatnonzero(np.abs(positions[:, 0]) > 1e-4)
    assert len(aside) > 13_000
    left, right = positions[aside[::2]], positions[aside[1::2]]
    np.testing.assert_allclose(left, right * [-1, 1, 1], atol=1e-4)


def test_two_materials_share_one_set_of_points(glb):
    document, binary = read(glb)
    assert len(document["meshes"]) == 1
    primitives = document["meshes"][0]["primitives"]
    names = [document["materials"][p["material"]]["name"] for p in primitives]
    assert names == ["Skin", "Garment"]
    assert primitives[0]["attributes"] == primitives[1]["attributes"]
    for material in document["materials"]:
        assert material["pbrMetallicRoughness"]["metallicFactor"] == 0
    faces = np.concatenate([values(document, binary, p["indices"]) for p in primitives])
    count = document["accessors"][primitives[0]["attributes"]["POSITION"]]["count"]
    np.testing.assert_array_equal(np.unique(faces), np.arange(count))


def test_trimesh_reads_the_body(body, glb):
    scene = trimesh.load(io.BytesIO(glb), file_type="glb")
    low, high = scene.bounds
    np.testing.assert_allclose(low, body.vertices.min(axis=0), atol=1e-5)
    np.testing.assert_allclose(high, body.vertices.max(axis=0), atol=1e-5)
    whole = scene.to_geometry()
    whole.merge_vertices(merge_norm=True, merge_tex=True)
    assert whole.is_watertight
    expected = trimesh.Trimesh(body.vertices, body.template.faces, process=False).volume
    assert whole.volume == pytest.approx(expected, rel=1e-5)


def test_the_file_says_what_it_is(glb):
    asset = read(glb)[0]["asset"]
    assert asset["version"] == "2.0"
    assert asset["generator"] == "The Fitting Room"
    assert asset["extras"] == EXTRAS
    assert "extras" not in read(to_glb(one_body()))[0]["asset"]


def test_what_json_has_no_word_for_is_refused():
    with pytest.raises(ValueError, match="JSON"):
        to_glb(one_body(), {"stature": float("nan")})


def test_the_file_is_small(glb):
    assert len(glb) < 600_000


def test_the_validator_finds_nothing(glb):
    code, issues = validated(glb)
    assert issues["numErrors"] == issues["numWarnings"] == code == 0
    assert issues["messages"] == []


def test_the_validator_finds_nothing_with_morph_targets():
    estimator = load_estimators()["neutral"]
    asked = MeasurementSet({"stature": 1.7, "weight": 70.0})
    body = estimator.estimate(asked)
    glb = to_glb(body, morphs=morph_targets(estimator, body, asked))
    document = read(glb)[0]
    assert [len(p["targets"]) for p in document["meshes"][0]["primitives"]] == [2, 2]
    assert document["extensionsRequired"] == ["KHR_mesh_quantization"]
    code, issues = validated(glb)
    assert code == 0
    assert issues["messages"] == []


def test_the_validator_is_heard():
    code, issues = validated(to_glb(one_body()).replace(b'"VEC3"', b'"VEC2"', 1))
    assert code == 1
    assert issues["numErrors"] > 0


def validated(glb):
    """The standard's validator's exit code and findings."""
    node = shutil.which("node")
    if node is None or not (ROOT / "node_modules" / "gltf-validator").is_dir():
        pytest.skip("needs node and the npm packages: make test installs them")
    result = subprocess.run(
        [node, "scripts/validate_glb.mjs"], input=glb, cwd=ROOT, capture_output=True, check=False
    )
    assert result.stdout, result.stderr.decode()
    return result.returncode, json.loads(result.stdout)


def one_body():
    template = load_template_mesh()
    return Body(template, template.vertices, "neutral")
