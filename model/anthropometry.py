"""Measuring bodies: each measurement is one row of `TAPES`, and the rows drive the loop.

Definitions are those of ``model/data/measurements.csv``; where the table leaves room, what
is taken is said here. Of limbs the left one is measured. Tapes of one kind are read together,
which is several times faster than one by one.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from model.geodesics import length_gradient
from model.geometry import Floats
from model.girths import Girth, tie
from model.measurements import MEASUREMENTS, MeasurementSet
from model.tapes import Geodesic, Height, Legs, Loop, Mass, Tape, bundle, legs_of
from model.template_mesh import Body, Gradient, Landmarks, TemplateMesh

WAIST: Landmarks = ("waist_front", "waist_back")
HIP: Landmarks = ("lateral_thigh_left", "medial_thigh_left")
KNEE: Landmarks = ("lateral_knee_left", "medial_knee_left")
ANKLE: Landmarks = ("lateral_malleolus_left", "medial_malleolus_left")
SHOULDER: Landmarks = ("acromion_left", "axilla_left")
ELBOW: Landmarks = ("radiale_left", "medial_epicondyle_left")
WRIST: Landmarks = ("stylion_left", "ulnar_styloid_left")
THELIA: Landmarks = ("thelion_left", "thelion_right")
BUTTOCKS: Landmarks = ("buttock_point_left", "buttock_point_right")
# Over a round belly the middle is not the shortest way, but the one a tape takes.
WAIST_TO_CROTCH: Landmarks = ("waist_front", "omphalion", "abdomen_bottom", "crotch")

TRUNK = ("torso",)
HIPS = ("torso", "upper_leg")
THIGH = ("upper_leg_left",)
LEG = ("upper_leg_left", "lower_leg_left")
CALF = ("lower_leg_left", "foot_left")
ARM = ("upper_arm_left", "lower_arm_left")
HAND = ("lower_arm_left", "hand_left")


def _limb(
    parts: tuple[str, ...],
    start: Landmarks,
    stop: Landmarks,
    span: tuple[float, float],
    pick: Literal["widest", "narrowest"],
    planes: int,
) -> Girth:
    """A tape across a limb."""
    return Girth(parts, start, stop, span, pick, cut="across", planes=planes, reach=0.06)


TAPES: Mapping[str, Tape] = {
    "stature": Height(),
    "weight": Mass(),
    # Between the lowest ribs and the top of the hip bones; both move with the trunk.
    "waist_girth": Girth(TRUNK, ("omphalion",), ("underbust",), (0.15, 0.6), "narrowest", planes=9),
    # Above the brows and the ears, whose tips would make it jump.
    "head_girth": Girth(
        ("head_neck",), ("glabella",), ("vertex",), (0.06, 0.42), "widest", planes=7, reach=0.025
    ),
    "bust_girth": Girth(TRUNK, THELIA, ("underbust",), (0.0, 0.5), "widest", planes=5),
    # From the fullest part of the buttocks upwards: below it, legs that stand apart widen it.
    "hip_girth": Girth(HIPS, BUTTOCKS, ("omphalion",), (0.0, 0.5), "widest", planes=9),
    "knee_girth": _limb(LEG, HIP, KNEE, (0.96, 1.02), "widest", planes=3),
    "ankle_girth": _limb(CALF, KNEE, ANKLE, (0.75, 0.97), "narrowest", planes=9),
    # To under the jaw, but not the chin: on heavy people lower planes graze the shoulders, where a
    # girth changes by much with little.
    "neck_girth": Girth(
        ("head_neck", "torso"),
        ("cervicale", "neck_front"),
        ("nape", "throat"),
        (0.7, 1.9),
        "narrowest",
        cut="slanted",
        planes=7,
        reach=0.08,
        past=(("menton", 0.04), ("clavicle_left", 0.055), ("clavicle_right", 0.055)),
    ),
    "lower_arm_girth": _limb(ARM, ELBOW, WRIST, (0.12, 0.45), "widest", planes=9),
    "upper_arm_girth": _limb(ARM, SHOULDER, ELBOW, (0.35, 0.8), "narrowest", planes=9),
    "wrist_girth": _limb(HAND, ELBOW, WRIST, (0.85, 1.0), "narrowest", planes=5),
    # Below the border of the trunk, which runs from face to face.
    "thigh_girth": _limb(THIGH, HIP, KNEE, (0.03, 0.11), "widest", planes=5),
    "calf_girth": _limb(CALF, KNEE, ANKLE, (0.15, 0.5), "widest", planes=9),
    "armscye_girth": Loop(
        ("acromion_left", "armpit_front_left", "axilla_left", "armpit_back_left")
    ),
    "elbow_girth": _limb(ARM, ELBOW, WRIST, (-0.04, 0.04), "widest", planes=3),
    # About the navel, where the belly is fullest; further down it would read the hips.
    "abdomen_girth": Girth(HIPS, ("omphalion",), ("underbust",), (-0.05, 0.2), "widest", planes=6),
    # Breasts may hang below the fold, where the tape passes behind them. On the template a nipple
    # is 5.4 cm from the fold, and on the heaviest bodies skin hangs that there lies 1.6 cm lower.
    "underbust_girth": Girth(
        TRUNK,
        ("underbust",),
        ("omphalion",),
        (0.0, 0.2),
        "narrowest",
        planes=4,
        past=tuple((nipple, 0.07) for nipple in THELIA),
    ),
    "mid_thigh_girth": _limb(THIGH, HIP, KNEE, (0.35, 0.6), "narrowest", planes=7),
    "shoulder_length": Geodesic(("acromion_left", "suprasternale", "acromion_right")),
    "rise_length": Geodesic((*WAIST_TO_CROTCH, "abdomen_back", "waist_back")),
    "glute_length": Geodesic(("abdomen_back", "buttock_point_left", "gluteal_fold_left")),
    "neck_to_waist_length": Geodesic(("cervicale", "waist_back")),
    "collarbone_to_waist_length": Geodesic(("clavicle_left", "thelion_left", "waist_left")),
    "upper_arm_length": Geodesic(("acromion_left", "radiale_left")),
    "lower_arm_length": Geodesic(("radiale_left", "stylion_left")),
    "breast_length": Geodesic(("chest_top_left", "thelion_left", "underbust_left")),
    "front_lower_trunk_length": Geodesic(WAIST_TO_CROTCH),
    "armpit_to_waist_length": Geodesic(("axilla_left", "waist_side_left")),
    "collarbone_to_underbust_length": Geodesic(("clavicle_left", "thelion_left", "underbust_left")),
    "underbust_to_belly_button_length": Geodesic(("underbust", "omphalion")),
    "arm_length": Geodesic(("acromion_left", "radiale_left", "stylion_left")),
    "groin_length": Geodesic(("abdomen_bottom", "crotch")),
    "belly_length": Geodesic(("underbust", "omphalion", "abdomen_bottom")),
    "waist_to_knee_height": Height(WAIST, ("midpatella_left",)),
    "waist_height": Height(WAIST),
    "inseam_height": Height(("crotch",), ("lateral_malleolus_left",)),
    "foot_height": Height(("lateral_malleolus_left",)),
    "torso_height": Height(("cervicale",), ("crotch",)),
    "neck_height": Height(("menton",), ("suprasternale",)),
    "hip_to_ankle_height": Height(("buttock_point_left",), ("lateral_malleolus_left",)),
}
"""How each measurement is taken. A row of the table is all that a new one needs."""

TAKEN: tuple[str, ...] = tuple(name for name in MEASUREMENTS if name in TAPES)
"""The measurements that are taken, in the table's order."""


@dataclass(frozen=True)
class Measured:
    """What a body measures.

    Attributes
    ----------
    values : every measurement that is taken.
    paths : where each tape ran, ndarray of shape (n, 3) in metres: a girth is a closed
        loop whose first point is not repeated, a length an open polyline, a height two
        points; weight has none.
    """

    values: MeasurementSet
    paths: Mapping[str, Floats]


class ImpossibleBodyError(ValueError):
    """A surface that no person has: turned inside out, or cut by no tape."""


def measure(body: Body) -> Measured:
    """Takes every measurement of one body, with the path of each tape.

    Raises
    ------
    ImpossibleBodyError
        For a body with a measurement that is not positive. Values that contradict each
        other strongly can make the linear estimate such a body.
    """
    taken = take_tapes(body.template, body.vertices, [TAPES[name] for name in TAKEN])
    readings = dict(zip(TAKEN, taken, strict=True))
    for name, (value, _) in readings.items():
        if not value > 0:
            raise ImpossibleBodyError(f"the body has no {name}")
    return Measured(
        values=MeasurementSet({name: value for name, (value, _) in readings.items()}),
        paths={name: path for name, (_, path) in readings.items()},
    )


def measure_batch(template: TemplateMesh, vertices: Floats, names: Iterable[str] = TAKEN) -> Floats:
    """Takes measurements of many bodies.

    Parameters
    ----------
    vertices : ndarray of shape (B, V, 3), metres.
    names : which measurements; all that are taken by default.

    Returns
    -------
    ndarray of shape (B, number of names), SI units.
    """
    return read_tapes(template, vertices, [TAPES[name] for name in names])


def read_tapes(template: TemplateMesh, vertices: Floats, tapes: Sequence[Tape]) -> Floats:
    """Reads any tapes on many bodies, in chunks that fit the memory.

    Parameters
    ----------
    vertices : ndarray of shape (B, V, 3), metres.

    Returns
    -------
    ndarray of shape (B, number of tapes), SI units.
    """
    chunk = 16
    values = np.empty((len(vertices), len(tapes)))
    girths, geodesics, others = _sorted(tapes)
    for first in range(0, len(vertices), chunk):
        part = vertices[first : first + chunk]
        rows = values[first : first + chunk]
        if girths:
            tied, chosen = tie(template, part, list(girths.values()))
            rows[:, list(girths)] = tied.perimeters[chosen]
        if geodesics:
            legs = legs_of(geodesics.values())
            shares = _shares(legs, tuple(geodesics.values()))
            rows[:, list(geodesics)] = bundle(template, legs).lengths(part) @ shares
        for column, tape in others.items():
            rows[:, column] = tape.read(template, part)
    return values


def take_tapes(
    template: TemplateMesh, vertices: Floats, tapes: Sequence[Tape]
) -> list[tuple[float, Floats]]:
    """Takes any tapes on one body, vertices of shape (V, 3): values and paths as in `Tape`."""
    girths, geodesics, others = _sorted(tapes)
    taken: dict[int, tuple[float, Floats]] = {}
    if girths:
        tied, rows = tie(template, vertices[None], list(girths.values()))
        for column, row in zip(girths, rows[0].tolist(), strict=True):
            taken[column] = float(tied.perimeters[row]), tied.loop(row)
    if geodesics:
        legs = legs_of(geodesics.values())
        ways = [way for _, way in bundle(template, legs).ways(vertices)]
        by_leg = dict(zip(legs, ways, strict=True))
        for column, geodesic in geodesics.items():
            own = [by_leg[leg] for leg in geodesic.legs()]
            taken[column] = sum(way.length for way in own), geodesic.path(own)
    for column, tape in others.items():
        taken[column] = tape.take(template, vertices)
    return [taken[column] for column in range(len(tapes))]


def tape_gradients(
    template: TemplateMesh, vertices: Floats, tapes: Sequence[Tape]
) -> list[tuple[float, Gradient]]:
    """Values of one body, vertices of shape (V, 3), and their derivatives as in `Tape`.

    The ways of all geodesics are found together.
    """
    girths, geodesics, others = _sorted(tapes)
    readings: dict[int, tuple[float, Gradient]] = {}
    if geodesics:
        legs = legs_of(geodesics.values())
        ways = bundle(template, legs).ways(vertices)
        lengths = {leg: way.length for leg, (_, way) in zip(legs, ways, strict=True)}
        slopes = {leg: length_gradient(*way) for leg, way in zip(legs, ways, strict=True)}
        for column, geodesic in geodesics.items():
            own = geodesic.legs()
            indices, by_vertex = zip(*(slopes[leg] for leg in own), strict=True)
            length = sum(lengths[leg] for leg in own)
            readings[column] = length, (np.concatenate(indices), np.concatenate(by_vertex))
    for column, tape in {**girths, **others}.items():
        readings[column] = tape.gradient(template, vertices)
    return [readings[column] for column in range(len(tapes))]


def _sorted(
    tapes: Sequence[Tape],
) -> tuple[dict[int, Girth], dict[int, Geodesic], dict[int, Tape]]:
    """Tapes that are read together, by their place in the sequence."""
    girths = {i: tape for i, tape in enumerate(tapes) if isinstance(tape, Girth)}
    geodesics = {i: tape for i, tape in enumerate(tapes) if isinstance(tape, Geodesic)}
    others = {i: tape for i, tape in enumerate(tapes) if i not in girths and i not in geodesics}
    return girths, geodesics, others


@lru_cache(maxsize=64)
def _shares(legs: Legs, geodesics: tuple[Geodesic, ...]) -> Floats:
    """Which legs each geodesic is made of: (legs, geodesics) of 0 or 1."""
    return np.array([[float(leg in tape.legs()) for tape in geodesics] for leg in legs])
