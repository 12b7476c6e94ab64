"""The skeleton in bodies, and the skin that follows it; the file's, read by its definition."""

import io

import numpy as np
import pytest
import trimesh
from glb_reader import read, values
from scipy.spatial.transform import Rotation
from test_gltf import validated

from model.appearance import dress
from model.estimators import load_estimators
from model.gltf import mirrored_order, to_glb
from model.measurements import BODY_KINDS, MeasurementSet
from model.morph_targets import morph_targets
from model.rig import load_rig, rig_of, strongest, turned
from model.template_mesh import TemplateMesh, load_template_mesh

VRM = {
    "hips": "",
    "spine": "hips",
    "chest": "spine",
    "upperChest": "chest",
    "neck": "upperChest",
    "head": "neck",
}
for side in ("left", "right"):
    VRM |= {
        f"{side}Shoulder": "upperChest",
        f"{side}UpperArm": f"{side}Shoulder",
        f"{side}LowerArm": f"{side}UpperArm",
        f"{side}Hand": f"{side}LowerArm",
        f"{side}UpperLeg": "hips",
        f"{side}LowerLeg": f"{side}UpperLeg",
        f"{side}Foot": f"{side}LowerLeg",
        f"{side}Toes": f"{side}Foot",
    }
"""VRM's humanoid bones that the rig has, and what each hangs on."""

PEOPLE = [
    ("female", {"stature": 1.55, "weight": 45.0}),
    ("male", {"stature": 1.9, "weight": 80.0}),
    ("neutral", {"stature": 1.7, "weight": 130.0}),
]


@pytest.fixture(scope="module")
def rig():
    return load_rig()


@pytest.fixture(scope="module", params=PEOPLE, ids=lambda person: person[0])
def body(request):
    kind, asked = request.param
    return load_estimators()[kind].estimate(MeasurementSet(asked))


def winding(body, point):
    """How often the skin goes around a point: 1 inside, 0 outside (van Oosterom, Strackee 1983)."""
    a, b, c = (body.vertices[body.template.faces] - point).transpose(1, 0, 2)
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    solid = np.einsum("fx,fx->f", a, np.cross(b, c))
    dots = [np.einsum("fx,fx->f", one, other) for one, other in ((a, b), (b, c), (c, a))]
    around = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    return np.arctan2(solid, around).sum() / (2 * np.pi)


def of_bones(rig, vertices_weighing, *names):
    return vertices_weighing[:, [rig.names.index(name) for name in names]].sum(axis=1)


def test_the_bones_are_vrms(rig):
    parents = [rig.names[parent] if parent >= 0 else "" for parent in rig.parents]
    assert dict(zip(rig.names, parents, strict=True)) == VRM
    assert (rig.parents < np.arange(len(rig.names))).all()


def test_weights_are_whole_and_alike_on_both_sides(rig):
    assert (rig.weights.sum(axis=1, dtype=int) == 255).all()
    np.testing.assert_allclose(rig.regressors.sum(axis=1), 1, atol=1e-5)
    mirror = load_template_mesh().mirror
    swap = [
        rig.names.index(
            name.replace("left", "right") if "left" in name else name.replace("right", "left")
        )
        for name in rig.names
    ]
    off = np.abs(rig.dense_weights[mirror][:, swap] - rig.dense_weights).max(axis=1)
    # On the middle, a fifth bone that is left out may be one side's.
    assert (off > 2.5 / 255).mean() < 0.003
    assert off.max() < 0.07


def test_joints_lie_in_the_body_where_they_belong(rig, body):
    places = dict(zip(rig.names, rig.places(body.vertices), strict=True))
    for bone in VRM:
        left = places[bone]
        assert winding(body, left) == pytest.approx(1, abs=1e-6), bone
        if bone.startswith("left"):
            right = places[bone.replace("left", "right")]
            np.testing.assert_allclose(right, left * [-1, 1, 1], atol=1e-6)
        elif not bone.startswith("right"):
            assert left[0] == pytest.approx(0, abs=1e-6)

    def landmark(*names):
        return body.template.landmark_points(body.vertices, *names)

    for joint, marks in (
        ("leftLowerArm", ("radiale_left", "medial_epicondyle_left")),
        ("leftHand", ("stylion_left", "ulnar_styloid_left")),
        ("leftLowerLeg", ("lateral_knee_left", "medial_knee_left")),
        ("leftFoot", ("lateral_malleolus_left", "medial_malleolus_left")),
    ):
        assert np.linalg.norm(places[joint] - landmark(*marks)) < 0.045, joint


def test_at_rest_the_skin_is_the_body(rig, body):
    still = turned(rig, body.vertices, {name: Rotation.identity() for name in rig.names})
    np.testing.assert_allclose(still, body.vertices, atol=1e-12)


def test_turning_the_hips_turns_the_whole_body(rig, body):
    turn = Rotation.from_euler("y", 0.7)
    hips = rig.places(body.vertices)[rig.names.index("hips")]
    found = turned(rig, body.vertices, {"hips": turn})
    np.testing.assert_allclose(found, turn.apply(body.vertices - hips) + hips, atol=1e-12)


def test_a_bent_elbow_moves_the_forearm_alone(rig, body):
    bent = turned(rig, body.vertices, {"leftLowerArm": Rotation.from_euler("x", -1.0)})
    follows = of_bones(rig, rig.dense_weights, "leftLowerArm", "leftHand")
    moved = np.linalg.norm(bent - body.vertices, axis=1)
    assert moved[follows == 0].max() == pytest.approx(0, abs=1e-12)
    hand = np.flatnonzero(rig.dense_weights[:, rig.names.index("leftHand")] == 1)
    assert moved[hand].min() > 0.1
    # What follows one bone alone keeps its shape.
    before, after = (v[hand] - v[hand[0]] for v in (body.vertices, bent))
    np.testing.assert_allclose(
        np.linalg.norm(after, axis=1), np.linalg.norm(before, axis=1), atol=1e-9
    )


@pytest.mark.parametrize(("upper", "lower"), [(-0.4, 0.0), (0.6, 0.3)])
def test_raised_arms_take_their_joints_along_and_are_alike(rig, body, upper, lower):
    pose = {
        side + bone: Rotation.from_rotvec([0.0, 0.0, sign * angle])
        for side, sign in (("left", 1.0), ("right", -1.0))
        for bone, angle in (("UpperArm", upper), ("LowerArm", lower))
    }
    raised = turned(rig, body.vertices, pose)
    arm = [rig.names.index(f"left{bone}") for bone in ("UpperArm", "LowerArm", "Hand")]
    start, elbow, wrist = rig.places(body.vertices)[arm]
    turn = pose["leftUpperArm"]
    elbow_then = start + turn.apply(elbow - start)
    wrist_then = elbow_then + (turn * pose["leftLowerArm"]).apply(wrist - elbow)
    off = np.linalg.norm(rig.places(raised)[arm[1:]] - [elbow_then, wrist_then], axis=1)
    assert off.max() < 0.02
    mirrored = raised[body.template.mirror] * [-1, 1, 1]
    assert np.abs(mirrored - raised).max() < 0.005


def test_a_bone_that_is_none_is_refused(rig, body):
    with pytest.raises(ValueError, match="leftWing"):
        turned(rig, body.vertices, {"leftWing": Rotation.identity()})


def test_only_the_templates_bodies_have_the_rig():
    template = load_template_mesh()
    other = TemplateMesh(
        template.vertices[:3], template.faces[:1], template.face_parts[:1], (), template.mirror, {}
    )
    assert rig_of(template) is load_rig()
    assert rig_of(other) is None


def test_the_four_strongest_bones_are_kept_whole():
    weights = np.array([[0.4, 0.3, 0.15, 0.1, 0.05], [0.0, 0.0, 1.0, 0.0, 0.0]])
    joints, shares = strongest(weights)
    assert joints.tolist() == [[0, 1, 2, 3], [2, 0, 0, 0]]
    assert shares.sum(axis=1).tolist() == [255, 255]
    np.testing.assert_allclose(shares[0] / 255, weights[0, :4] / 0.95, atol=1 / 255)


# ---------------------------------------------------------------- the file


@pytest.fixture(scope="module")
def glb(body, rig):
    return to_glb(body, rig=rig)


def test_the_files_skeleton_is_the_bodys_and_holds_it_still(body, rig, glb):
    document, binary = read(glb)
    (skin,) = document["skins"]
    nodes = document["nodes"]
    names = [nodes[joint]["name"] for joint in skin["joints"]]
    assert names == list(rig.names)
    assert document["scenes"][0]["nodes"] == [0, skin["joints"][0]]
    world = {}

    def walk(node, above):
        world[node] = above + nodes[node]["translation"]
        for child in nodes[node].get("children", []):
            walk(child, world[node])

    walk(skin["joints"][0], np.zeros(3))
    places = np.array([world[joint] for joint in skin["joints"]])
    np.testing.assert_allclose(places, rig.places(body.vertices), atol=1e-4)

    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    points = values(document, binary, attributes["POSITION"])
    joints, weights = (
        values(document, binary, attributes["JOINTS_0"]).astype(int),
        values(document, binary, attributes["WEIGHTS_0"]),
    )
    np.testing.assert_allclose(weights.sum(axis=1), 1, atol=1e-6)
    # Column by column: a matrix's last four numbers are its last column.
    binds = values(document, binary, skin["inverseBindMatrices"]).reshape(-1, 4, 4)
    shifts = binds[:, 3, :3] + places
    np.testing.assert_array_equal(binds[:, :3, :3], np.tile(np.eye(3), (len(places), 1, 1)))
    held = points + np.einsum("vk,vkx->vx", weights, shifts[joints])
    np.testing.assert_allclose(held, points, atol=1e-4)
    n = len(body.vertices)
    places = np.argsort(mirrored_order(body.template, body.kind))[:n]
    held, joints, weights = held[places], joints[places], weights[places]
    np.testing.assert_allclose(held, body.vertices, atol=1e-4)
    follows = np.zeros((n, len(names)))
    np.add.at(follows, (np.arange(n)[:, None], joints), weights)
    np.testing.assert_allclose(follows, rig.dense_weights, atol=1e-6)


def test_the_files_normals_in_bytes_are_the_bodys(body, glb):
    document, binary = read(glb)
    assert document["extensionsRequired"] == ["KHR_mesh_quantization"]
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    normals = values(document, binary, attributes["NORMAL"])
    order = mirrored_order(body.template, body.kind)
    np.testing.assert_allclose(normals, dress(body).normals[order], atol=0.6 / 127)


def test_other_readers_are_content_with_the_rig(body, glb):
    code, issues = validated(glb)
    assert code == 0
    assert issues["messages"] == []
    scene = trimesh.load(io.BytesIO(glb), file_type="glb")
    np.testing.assert_allclose(scene.bounds[0], body.vertices.min(axis=0), atol=1e-5)
    np.testing.assert_allclose(scene.bounds[1], body.vertices.max(axis=0), atol=1e-5)
    assert len(glb) < 600_000


@pytest.mark.parametrize("kind", BODY_KINDS)
def test_every_kind_of_body_goes_home_with_its_rig(site, kind):
    wanted = {"body": kind, "measurements": {"stature": 170}}
    client = site.test_client()
    assert b'"leftUpperArm"' in client.post("/api/v1/avatars.glb", json=wanted).data
    live = client.post("/api/v1/avatars.glb", json=wanted | {"morph_targets": True}).data
    assert b'"skins"' not in live


def test_a_rig_and_morph_targets_together_are_refused(rig):
    estimator = load_estimators()["neutral"]
    asked = MeasurementSet({"stature": 1.7})
    body = estimator.estimate(asked)
    with pytest.raises(ValueError, match="not both"):
        to_glb(body, rig=rig, morphs=morph_targets(estimator, body, asked))
