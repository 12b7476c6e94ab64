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

LINES = {
    "ankle from the middle, % of stature": 100 * FEET,
    "hips to neck forwards, °": TRUNK_FORWARD,
    "neck to head forwards, °": NECK_FORWARD,
    "hip to ankle forwards, °": LEG_FORWARD,
    "upper arm outwards, °": UPPER_ARM[0],
    "upper arm forwards, °": UPPER_ARM[1],
    "lower arm outwards, °": LOWER_ARM[0],
    "lower arm forwards, °": LOWER_ARM[1],
}
"""The stance by name, for tables."""

ROUNDS = 3
"""Joints move with the skin that follows them, so that the first turn is not exact."""

SIDES = (("left", 1.0), ("right", -1.0))

_CHAIN = ("UpperLeg", "Foot", "UpperArm", "LowerArm", "Hand")
"""The joints of a side that the stance knows: hip, ankle, shoulder, elbow and wrist."""


def in_one_stance(template: TemplateMesh, vertices: Floats, upright: bool = True) -> Floats:
    """A body of the shipped rig's topology, turned at its joints: (V, 3) to (V, 3), metres.

    It is not put on the ground again.

    Parameters
    ----------
    upright : whether trunk and neck too, or arms and legs alone.
    """
    rig = load_rig()
    for _ in range(ROUNDS):
        vertices = turned(rig, vertices, _towards_the_stance(rig, vertices, upright))
    # Weights of the two sides differ by rounding.
    return (vertices + vertices[template.mirror] * [-1, 1, 1]) / 2


def stance_of(vertices: Floats) -> Floats:
    """How a body of the shipped rig's topology, (V, 3), stands: as `LINES`, its left side's."""
    rig = load_rig()
    places = dict(zip(rig.names, rig.places(vertices), strict=True))
    hip, ankle, shoulder, elbow, wrist = (places[f"left{name}"] for name in _CHAIN)
    angles = [
        _leaning(places["hips"], places["neck"]),
        _leaning(places["neck"], places["head"]),
        _hanging(hip, ankle, 1.0)[1],
        *_hanging(shoulder, elbow, 1.0),
        *_hanging(elbow, wrist, 1.0),
    ]
    share = 100 * ankle[0] / np.ptp(vertices[:, 1])
    return np.array([share, *np.degrees(angles)])


def _towards_the_stance(rig: Rig, vertices: Floats, upright: bool) -> dict[str, Rotation]:
    """By how much each bone is off."""
    places = dict(zip(rig.names, rig.places(vertices), strict=True))
    stature = float(np.ptp(vertices[:, 1]))
    trunk = neck = Rotation.identity()
    if upright:
        trunk = _forward(np.radians(TRUNK_FORWARD) - _leaning(places["hips"], places["neck"]))
        neck = _forward(np.radians(NECK_FORWARD) - _leaning(places["neck"], places["head"]))
    pose = {"spine": trunk, "neck": trunk.inv() * neck, "head": neck.inv()}
    for side, sign in SIDES:
        hip, ankle, shoulder, elbow, wrist = (places[side + name] for name in _CHAIN)
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
    outwards, forwards = np.radians(wanted) - _hanging(start, stop, sign)
    sideways = Rotation.from_rotvec([0.0, 0.0, sign * outwards])
    return sideways * _forward(-forwards)


def _hanging(start: Floats, stop: Floats, sign: float) -> Floats:
    """How far what hangs points outwards and forwards, radians: (2,)."""
    x, y, z = stop - start
    return np.array([np.arctan2(sign * x, -y), np.arctan2(z, -y)])
