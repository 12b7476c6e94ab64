"""One stance for every body of the population, by the skeleton that the avatar's file carries.

A tape tells nothing of how somebody stands; what it leaves open there would count as shape and
move head, hands and feet by centimetres. So the lines between joints (`model/rig.py`) are given the
same directions in all bodies: feet apart in proportion to stature and below the hips, trunk and
neck as upright, arms as far out. How the back is curved, legs are bowed and shoulders lie between
those joints stays each body's own.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from model.geometry import Floats
from model.rig import Rig, load_rig, turned
from model.template_mesh import TemplateMesh

FEET = 0.115
"""How far each ankle's joint is from the middle, as a share of stature. This and the angles below
are what Anny's bodies, fitted to 3,328 drawn people each in a stance of its own, had on average
(2026-12-01)."""

TRUNK_FORWARD = -0.3
NECK_FORWARD = 21.3
LEG_FORWARD = 0.0
"""From the vertical, in degrees: the lines from hips to neck, neck to head and hip to ankle."""

UPPER_ARM = (35.9, 1.6)
LOWER_ARM = (23.8, 6.1)
"""From the vertical outwards, and forwards."""

ROUNDS = 3
"""Joints move with the skin that follows them, so that the first turn is not exact."""

SIDES = (("left", 1.0), ("right", -1.0))


def in_one_stance(template: TemplateMesh, vertices: Floats) -> Floats:
    """A body of the shipped rig's topology, turned at its joints: (V, 3) to (V, 3), metres.

    It is not put on the ground again.
    """
    rig = load_rig()
    for _ in range(ROUNDS):
        vertices = turned(rig, vertices, _towards_the_stance(rig, vertices))
    # Weights of the two sides differ by rounding.
    return (vertices + vertices[template.mirror] * [-1, 1, 1]) / 2


def _towards_the_stance(rig: Rig, vertices: Floats) -> dict[str, Rotation]:
    """By how much each bone is off."""
    places = dict(zip(rig.names, rig.places(vertices), strict=True))
    stature = float(np.ptp(vertices[:, 1]))
    trunk = _forward(np.radians(TRUNK_FORWARD) - _leaning(places["hips"], places["neck"]))
    neck = _forward(np.radians(NECK_FORWARD) - _leaning(places["neck"], places["head"]))
    pose = {"spine": trunk, "neck": trunk.inv() * neck, "head": neck.inv()}
    for side, sign in SIDES:
        hip, ankle, shoulder, elbow, wrist = (
            places[side + name] for name in ("UpperLeg", "Foot", "UpperArm", "LowerArm", "Hand")
        )
        outwards = np.arcsin((FEET * stature - sign * hip[0]) / np.linalg.norm(ankle - hip))
        leg = _turn(hip, ankle, sign, (np.degrees(outwards), LEG_FORWARD))
        upper = _turn(shoulder, elbow, sign, UPPER_ARM)
        lower = _turn(elbow, wrist, sign, LOWER_ARM)
        # What hangs on a turned bone keeps its own direction.
        pose |= {
            f"{side}UpperLeg": leg,
            f"{side}Foot": leg.inv(),
            f"{side}UpperArm": trunk.inv() * upper,
            f"{side}LowerArm": upper.inv() * lower,
        }
    return pose


def _leaning(start: Floats, stop: Floats) -> float:
    """How far forwards an upright line leans, radians."""
    return float(np.arctan2(stop[2] - start[2], stop[1] - start[1]))


def _forward(angle: float) -> Rotation:
    """Tips what stands forwards by an angle in radians."""
    return Rotation.from_rotvec([angle, 0.0, 0.0])


def _turn(start: Floats, stop: Floats, sign: float, wanted: tuple[float, float]) -> Rotation:
    """Turns what hangs to the angles outwards and forwards that are wanted, in degrees.

    `sign` is 1 on the left side.
    """
    x, y, z = stop - start
    outwards = np.radians(wanted[0]) - np.arctan2(sign * x, -y)
    forwards = np.radians(wanted[1]) - np.arctan2(z, -y)
    sideways = Rotation.from_rotvec([0.0, 0.0, sign * outwards])
    return sideways * _forward(-forwards)
