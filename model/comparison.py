"""A photo's outline beside a body's: laid over one another, and compared.

Both lie on one sheet: the upright plane through the body's axis, seen from the photo's camera,
in pixels of equal size. The photo is scaled by the stature, between crown and soles, put on the
ground, and moved sideways until both have most in common. Arms rarely hang as the avatar's do, so
they are left out of what is judged: of the avatar by its body parts, of the photo where they
stand off the trunk. Where they touch it, nothing beside the trunk is judged.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from model.anthropometry import TAPES
from model.cameras import USUAL_CAMERA, Camera, Facing, Side, seen
from model.geometry import Booleans, Floats, Integers
from model.girths import Girth, tie
from model.masks import Mask, PictureRefusedError
from model.sheet import SMOOTH, Sheet, edges_of_figure, over
from model.silhouette import LEG, ROWS, UPRIGHT, contour
from model.template_mesh import Body

TRUNK_LEVELS = (
    "neck_girth",
    "bust_girth",
    "underbust_girth",
    "waist_girth",
    "abdomen_girth",
    "hip_girth",
)
LEVELS: Mapping[Side, tuple[str, ...]] = {
    "front": (*TRUNK_LEVELS, "mid_thigh_girth", "knee_girth", "calf_girth", "ankle_girth"),
    "profile": (*TRUNK_LEVELS, "thigh_girth", "mid_thigh_girth", "knee_girth", "calf_girth"),
}
"""The girths at whose height breadths (front) and depths (profile) are told. From the front a
leg's is the mean of both, where they stand apart; the thigh's tape runs where they touch. From
the side both legs are one; the farther foot stands behind the ankle."""

EDGE_LEVELS = tuple(name for name in LEVELS["profile"] if name != "neck_girth")
"""The girths at whose height `photo_edges` has edges: they begin below the neck and end above the
ankles."""

_SPACING = 8
"""Rows between the edges that a photo is asked for: some 15 mm."""

_LEGS_END = 0.14
"""Of the stature: lower down are ankles and feet, which stand as they like."""

_COARSE = ROWS // 4
"""Rows enough to tell where a person in profile looks."""

LEAST_OVERLAP = 0.4
"""Outlines of which less than this share is common, are not of one person standing upright."""


@dataclass(frozen=True, eq=False)
class Level:
    """How broad or deep a figure is at the height of a girth, in metres on the sheet."""

    measurement: str
    photo: float
    avatar: float
    height: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """A photo's outline and an avatar's, on one sheet.

    Attributes
    ----------
    side, camera, facing : how both are seen.
    step : metres to a pixel of the sheet.
    photo, avatar : ndarrays of bool, shape (h, w): with arms, soles on the same row.
    arms : ndarray of bool, shape (h, w): what is not judged.
    iou : how much of the two judged figures together is common to both.
    distance : mean distance of the judged outlines from one another, in metres.
    levels : from the top down.
    unseen : girths whose level an arm hides.
    origin : (2,) column and row on the sheet of the body's axis on the floor.
    place : left, top and scale: a pixel (x, y) of the sheet lies at left + scale · x,
        top + scale · y of the picture as it came.
    """

    side: Side
    camera: Camera
    facing: Facing
    step: float
    photo: Booleans
    avatar: Booleans
    arms: Booleans
    iou: float
    distance: float
    levels: tuple[Level, ...]
    unseen: tuple[str, ...]
    origin: tuple[float, float]
    place: tuple[float, float, float]


def compare(
    mask: Mask,
    body: Body,
    side: Side,
    *,
    camera: Camera = USUAL_CAMERA,
    facing: Facing | None = None,
) -> Comparison:
    """A photo's outline beside a body's.

    Parameters
    ----------
    mask : of a person who stands upright.
    facing : the picture's side that the person looks to in profile; found where not told.

    Raises
    ------
    PictureRefusedError
        Where the two have so little in common that the photo shows no standing person.
    """
    if side == "profile" and facing is None:
        ways: tuple[Facing, ...] = ("right", "left")
        overlaps = [Sheet(mask, body, side, camera, way, _COARSE).overlap for way in ways]
        facing = ways[int(np.argmax(overlaps))]
    best = Sheet(mask, body, side, camera, facing or "right")
    if best.overlap < LEAST_OVERLAP:
        raise PictureRefusedError(
            "no_person", f"{best.overlap:.2f} of the outline is a person's, under {LEAST_OVERLAP}"
        )
    return _compared(best)


@dataclass(frozen=True, eq=False)
class Edges:
    """What a photo's outline says of a body, row by row; metres on the sheet.

    Attributes
    ----------
    side, camera, facing : how it is seen.
    heights, ends, positions : ndarrays of shape (n,): where above the floor, whether at the left
        (0) or the right (1), and how far to the right of the body's axis the figure ends.
    leg_heights, leg_breadths : ndarrays of shape (m,): how broad a leg is from the front.
    hands : see `Sheet.hands`; none in profile.
    """

    side: Side
    camera: Camera
    facing: Facing
    heights: Floats
    ends: Integers
    positions: Floats
    leg_heights: Floats
    leg_breadths: Floats
    hands: Mapping[str, Floats]


def photo_edges(mask: Mask, body: Body, side: Side, camera: Camera, facing: Facing) -> Edges:
    """The edges of a photo's trunk and legs, laid over a body that is near to it.

    Head, hair, neck and feet are left out, and so is what an arm hides.
    """
    return _edges(Sheet(mask, body, side, camera, facing))


def _compared(sheet: Sheet) -> Comparison:
    arms, hidden = sheet.arms()
    photo, avatar = sheet.photo & ~arms, sheet.upright & ~arms
    # Pixels at an edge count by their parts; those at a seam, of which arms have a part, do not.
    judged = ~ndimage.binary_dilation(arms, np.ones((3, 3), dtype=bool))
    covers = sheet.cover[judged], sheet.upright_cover[judged]
    levels, unseen = _levels(sheet, arms, hidden)
    return Comparison(
        side=sheet.side,
        camera=sheet.camera,
        facing=sheet.facing,
        step=sheet.step,
        photo=sheet.photo,
        avatar=sheet.whole,
        arms=arms,
        iou=float(np.minimum(*covers).sum() / np.maximum(*covers).sum()),
        distance=_apart(photo, avatar, arms) * sheet.step,
        levels=tuple(levels),
        unseen=tuple(unseen),
        origin=sheet.origin,
        place=sheet.place,
    )


def _levels(sheet: Sheet, arms: Booleans, hidden: Booleans) -> tuple[list[Level], list[str]]:
    """Breadths or depths from the top down, and the levels that cannot be told."""
    names = LEVELS[sheet.side]
    template = sheet.body.template
    girths = [girth for name in names if isinstance(girth := TAPES[name], Girth)]
    tied, rows = tie(template, sheet.body.vertices[None], girths)
    levels, unseen = [], []
    for name, row in zip(names, rows[0].tolist(), strict=True):
        leg = sheet.side == "front" and name not in TRUNK_LEVELS
        loop = seen(tied.loop(row), sheet.side, sheet.camera, sheet.facing)
        ends = loop[[loop[:, 0].argmin(), loop[:, 0].argmax()]]
        height = float(sheet.origin[1] - ends[:, 1].mean() / sheet.step)
        near = range(int(height) - SMOOTH, int(height) + SMOOTH + 1)
        parts = LEG if leg else UPRIGHT
        avatar = contour(template, sheet.flat, parts, sheet.heights(near)).positions.mean(axis=0)
        photo = None
        behind = sheet.side == "profile" and (arms & sheet.photo)[near.start : near.stop].any()
        if leg or not (behind or hidden[:, int(height)].any()):
            photo = sheet.breadth(near, arms, avatar, legs=leg)
        if photo is None:
            unseen.append(name)
            continue
        levels.append(
            Level(
                measurement=name,
                photo=photo,
                avatar=float(np.ptp(avatar)),
                height=float((sheet.origin[1] - height) * sheet.step),
            )
        )
    return sorted(levels, key=lambda level: -level.height), unseen


def _edges(sheet: Sheet) -> Edges:
    """The photo's edges, see `photo_edges`."""
    arms, hidden = sheet.arms()
    crotch = sheet.landmark_row("crotch")
    if sheet.side == "front":
        trunk = range(sheet.landmark_row("axilla_left"), crotch, _SPACING)
        legs = range(crotch + _SPACING, sheet.row(_LEGS_END), _SPACING)
    else:
        trunk = range(sheet.landmark_row("suprasternale"), sheet.row(_LEGS_END), _SPACING)
        legs = range(0)
    upright, whole = (edges_of_figure(figure) for figure in (sheet.upright, sheet.upright | arms))
    found: list[tuple[int, int, float]] = []
    for row in trunk:
        avatar = [(ends[row] - sheet.origin[0]) * sheet.step for ends in upright]
        for end in (0, 1):
            near = slice(row - SMOOTH, row + SMOOTH + 1)
            # From the side an arm hides what is behind it.
            sleeve = sheet.side == "profile" and (upright[end] != whole[end])[near].any()
            if hidden[end, near].any() or sleeve:
                continue
            ways = [
                ends[end]
                for place in range(near.start, near.stop)
                if (ends := over(sheet.spans(place, arms), np.array(avatar)))
            ]
            if len(ways) > SMOOTH:
                found.append((row, end, float(np.mean(ways))))
    pairs = []
    for row in legs:
        near_rows = range(row - SMOOTH, row + SMOOTH + 1)
        breadth = sheet.breadth(near_rows, arms, np.zeros(2), legs=True)
        if breadth is not None:
            pairs.append((row, breadth))
    return Edges(
        side=sheet.side,
        camera=sheet.camera,
        facing=sheet.facing,
        heights=sheet.heights([row for row, _, _ in found]),
        ends=np.array([end for _, end, _ in found], dtype=np.int64),
        positions=np.array([position for _, _, position in found]),
        leg_heights=sheet.heights([row for row, _ in pairs]),
        leg_breadths=np.array([breadth for _, breadth in pairs]),
        hands=sheet.hands(arms, hidden) if sheet.side == "front" else {},
    )


def _apart(one: Booleans, other: Booleans, blind: Booleans) -> float:
    """How far two outlines are from one another, in pixels: the mean both ways.

    Where they border on what is not judged, they are no outlines.
    """
    seam = ndimage.binary_dilation(blind, iterations=2)
    outlines = [mask & ~ndimage.binary_erosion(mask) for mask in (one, other)]
    points = [np.argwhere(outline) for outline in outlines]
    judged = [np.argwhere(outline & ~seam) for outline in outlines]
    ways = [
        np.atleast_1d(cKDTree(points[1 - way]).query(judged[way])[0])
        for way in (0, 1)
        if len(judged[way])
    ]
    return float(np.mean([way.mean() for way in ways]))
