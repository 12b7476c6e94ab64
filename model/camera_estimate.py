"""Where a photo was taken from, as its outline tells it.

What an outline tells is how steeply the camera looks at the feet: its height beside its distance.
From the side the nearer foot stands lower in the picture than the other, and more so the higher
the camera is; from the front, whose feet turn as they like, toes tell a little. How far away the
camera is it hardly tells. So both are weighed with what people are asked for: three metres, at the
height of the hips.
"""

from collections.abc import Mapping

import numpy as np

from model.cameras import HEIGHTS, USUAL_CAMERA, Camera, Facing, Side
from model.geometry import Floats
from model.masks import Mask
from model.sheet import Sheet
from model.template_mesh import Body

ROWS = 225
"""Of the sheets on which cameras are tried."""

LEGS = 0.30
"""Of the stature: lower down there are legs and feet, and no hands."""

OFF: Mapping[Side, float] = {"front": 0.008, "profile": 0.002}
"""Metres of a row that may differ, on average over the legs, as an exponential law's scale. Found
on known bodies beside their avatars (`python -m bench silhouettes`)."""

DISTANCE_SPREAD, HEIGHT_SPREAD = 0.5, 0.25
"""Metres by which people's cameras deviate from the usual one."""

_STEEPNESSES = np.linspace(0.06, 0.70, 9)
_NEARER = np.array([-0.05, -0.025, 0.025, 0.05])
"""Heights beside distances that are tried, from a camera in the usual distance; and about the
best of them."""

_DISTANCES, _HEIGHTS = np.linspace(1.2, 6.0, 97), np.linspace(0.1, 2.2, 85)


def estimate_camera(
    masks: Mapping[Side, Mask],
    body: Body,
    *,
    distance: float | None = None,
    height: float | None = None,
) -> Camera:
    """The likeliest camera for outlines of somebody like a body.

    Parameters
    ----------
    masks : one or both views, taken from one place.
    distance, height : metres, where one of them is known.
    """
    facings = {side: _facing(mask, body, side) for side, mask in masks.items()}

    def doubts(steepnesses: Floats) -> Floats:
        return sum(
            (_misfits(mask, body, side, facings[side], steepnesses) / OFF[side])
            for side, mask in masks.items()
        ) + np.zeros(len(steepnesses))

    first = doubts(_STEEPNESSES)
    best = _STEEPNESSES[int(first.argmin())]
    steep = np.concatenate([_STEEPNESSES, best + _NEARER])
    order = steep.argsort()
    steep, off = steep[order], np.concatenate([first, doubts(best + _NEARER)])[order]
    distances = _DISTANCES if distance is None else np.array([distance])
    heights = _HEIGHTS if height is None else np.array([height])
    ratios = heights / distances[:, None]
    doubt = np.interp(ratios, steep, off)
    # What lies outside of what was tried, is as unlikely as it is far.
    doubt += np.abs(ratios - ratios.clip(steep[0], steep[-1])) / 0.01
    doubt += ((distances[:, None] - USUAL_CAMERA.distance) / DISTANCE_SPREAD) ** 2 / 2
    doubt += ((heights - USUAL_CAMERA.height) / HEIGHT_SPREAD) ** 2 / 2
    far, high = np.unravel_index(int(doubt.argmin()), doubt.shape)
    return Camera(float(distances[far]), float(heights[high]))


def _misfits(mask: Mask, body: Body, side: Side, facing: Facing, steepnesses: Floats) -> Floats:
    """By how much of a row legs differ on average, in metres, for every steepness: (n,)."""
    found = []
    for steepness in steepnesses:
        height = float(np.clip(steepness * USUAL_CAMERA.distance, *HEIGHTS))
        sheet = Sheet(mask, body, side, Camera(USUAL_CAMERA.distance, height), facing, ROWS)
        low = sheet.row(LEGS)
        apart = np.abs(sheet.cover[low:] - sheet.upright_cover[low:])
        found.append(float(apart.sum(axis=1).mean()) * sheet.step)
    return np.array(found)


def _facing(mask: Mask, body: Body, side: Side) -> Facing:
    """The picture's side that a person in profile looks to."""
    ways: tuple[Facing, ...] = ("right", "left")
    if side == "front":
        return ways[0]
    overlaps = [Sheet(mask, body, side, USUAL_CAMERA, way, ROWS).overlap for way in ways]
    return ways[int(np.argmax(overlaps))]
