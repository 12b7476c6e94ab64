"""One stance for all: bodies turned at their joints come back, and nothing else of them changes."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from model.anthropometry import measure_batch
from model.rig import load_rig, turned
from model.template_mesh import load_template_mesh
from model.training.stance import (
    FEET,
    LEG_FORWARD,
    LINES,
    LOWER_ARM,
    NECK_FORWARD,
    TRUNK_FORWARD,
    UPPER_ARM,
    in_one_stance,
    stance_of,
)


@pytest.fixture(scope="module")
def template():
    return load_template_mesh()


@pytest.fixture(scope="module")
def standing(template):
    return in_one_stance(template, template.vertices)


def bent(vertices, **degrees):
    """A skin with bones turned by rotation vectors, the right side as the mirror of the left."""
    pose = {}
    for name, (forwards, sideways) in degrees.items():
        if name in load_rig().names:
            pose[name] = Rotation.from_euler("x", forwards, degrees=True)
            continue
        for side, sign in (("left", 1), ("right", -1)):
            turn = Rotation.from_euler("xz", [forwards, sign * sideways], degrees=True)
            pose[side + name] = turn
    return turned(load_rig(), vertices, pose)


STANCES = {
    "feet together": {"UpperLeg": (0, -4), "Foot": (0, 4)},
    "legs behind": {"UpperLeg": (4, 0), "Foot": (-4, 0)},
    "leaning": {"spine": (5, 0), "neck": (-5, 0), "UpperArm": (-5, 0)},
    "head forwards": {"neck": (8, 0), "head": (-8, 0)},
    "arms hanging": {"UpperArm": (3, -6)},
    "elbows bent": {"LowerArm": (-6, 3)},
}


@pytest.mark.parametrize("turns", STANCES.values(), ids=STANCES)
def test_another_stance_comes_back(template, standing, turns) -> None:
    other = bent(standing, **turns)
    assert np.linalg.norm(other - standing, axis=1).max() > 0.01
    back = in_one_stance(template, other)
    apart = back - standing
    apart -= apart.mean(axis=0)
    assert np.linalg.norm(apart, axis=1).mean() < 0.001


def test_the_joints_lie_as_it_says(standing) -> None:
    rig = load_rig()
    places = dict(zip(rig.names, rig.places(standing), strict=True))

    def angles(start, stop):
        x, y, z = places[stop] - places[start]
        return np.degrees(np.arctan2([x, z], abs(y)))

    assert places["leftFoot"][0] == pytest.approx(FEET * np.ptp(standing[:, 1]), abs=0.0005)
    assert angles("hips", "neck")[1] == pytest.approx(TRUNK_FORWARD, abs=0.1)
    assert angles("neck", "head")[1] == pytest.approx(NECK_FORWARD, abs=0.2)
    assert angles("leftUpperLeg", "leftFoot")[1] == pytest.approx(LEG_FORWARD, abs=0.1)
    assert angles("leftUpperArm", "leftLowerArm") == pytest.approx(UPPER_ARM, abs=0.1)
    assert angles("leftLowerArm", "leftHand") == pytest.approx(LOWER_ARM, abs=0.1)


def test_the_stance_is_told_by_its_lines(standing) -> None:
    assert stance_of(standing) == pytest.approx(list(LINES.values()), abs=0.2)


def test_trunk_and_neck_can_be_left_as_they_are(template, standing) -> None:
    other = bent(standing, **STANCES["leaning"])
    other = bent(other, **STANCES["head forwards"])
    before = dict(zip(LINES, stance_of(other), strict=True))
    other = bent(other, **STANCES["arms hanging"])
    held = dict(zip(LINES, stance_of(in_one_stance(template, other, upright=False)), strict=True))
    for line, told in LINES.items():
        own = line in ("hips to neck forwards, °", "neck to head forwards, °")
        assert held[line] == pytest.approx(before[line] if own else told, abs=0.3), line
    assert before["hips to neck forwards, °"] > TRUNK_FORWARD + 4


def test_who_stands_so_is_left_as_they_are(template, standing) -> None:
    again = in_one_stance(template, standing)
    assert np.linalg.norm(again - standing, axis=1).max() < 0.0005


def test_both_sides_stay_alike(template, standing) -> None:
    assert np.array_equal(standing[template.mirror] * [-1, 1, 1], standing)


def test_soles_stay_flat_and_limbs_as_thick(template, standing) -> None:
    other = bent(standing, **STANCES["feet together"])
    back = in_one_stance(template, other)
    sole = standing[:, 1] < standing[:, 1].min() + 0.002
    assert np.ptp(back[sole, 1]) < 0.004
    girths = ("calf_girth", "ankle_girth", "wrist_girth", "lower_arm_girth")
    before, after = measure_batch(template, np.stack([standing, back]), girths)
    assert after == pytest.approx(before, abs=0.0005)
