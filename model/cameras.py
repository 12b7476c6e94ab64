"""Where pictures are taken from, and where points fall in them.

The camera stands at `distance` from the body's vertical axis and looks level from `height`, as a
person with a telephone does who does not tilt it. The picture's frame is shifted, not the camera,
so that soles and crown are in it. Pixels are counted from the picture's upper left corner; a
pixel's middle lies at a half.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from model.geometry import Floats

Side = Literal["front", "profile"]
SIDES: tuple[Side, ...] = get_args(Side)
Facing = Literal["right", "left"]

# Metres. Nearer, the lens would touch a large body's belly; farther, perspective no longer matters.
DISTANCES = (1.0, 10.0)
HEIGHTS = (0.0, 3.0)

# The picture's edge stays free by this share of its width and height on every side.
MARGIN = 0.04


@dataclass(frozen=True, slots=True)
class Camera:
    """Where a picture is taken from, in metres.

    distance : from the body's vertical axis
    height : above the floor

    Raises
    ------
    ValueError
        If either lies outside `DISTANCES` or `HEIGHTS`.
    """

    distance: float = 3.0
    height: float = 0.9

    def __post_init__(self) -> None:
        for name, value, (low, high) in (
            ("distance", self.distance, DISTANCES),
            ("height", self.height, HEIGHTS),
        ):
            if not low <= value <= high:
                raise ValueError(f"camera {name} {value} m is not from {low} to {high} m")


USUAL_CAMERA = Camera()
"""At the hip's height, three metres away: how a person is asked to be photographed."""


@dataclass(frozen=True, slots=True)
class Projection:
    """What a camera makes of points: `pixels(points)`.

    right, towards : ndarrays of shape (3,), the picture's right and the way to the camera
    focal : pixels for a slope of one
    column, row : the pixel that the camera looks at, level
    """

    camera: Camera
    right: Floats
    towards: Floats
    focal: float
    column: float
    row: float

    def pixels(self, points: Floats) -> Floats:
        """Where points, (n, 3) in metres, fall in the picture: (n, 2), column and row."""
        across, up = _slopes(points, self.camera, self.right, self.towards)
        return np.column_stack([self.column + self.focal * across, self.row - self.focal * up])


def seen(points: Floats, side: Side, camera: Camera, facing: Facing = "right") -> Floats:
    """Where points fall on the upright plane through the body's axis, as the camera sees them.

    Parameters
    ----------
    points : ndarray of shape (n, 3), metres.

    Returns
    -------
    ndarray of shape (n, 2), metres: to the picture's right of the axis, and above the floor.
    """
    across, up = _slopes(points, camera, *axes(side, facing))
    return np.column_stack([camera.distance * across, camera.height + camera.distance * up])


def seen_slopes(
    points: Floats, side: Side, camera: Camera, facing: Facing
) -> tuple[Floats, Floats]:
    """Derivatives of what `seen` gives of points by the points themselves, (n, 3) in metres.

    Returns
    -------
    across, up : ndarrays of shape (n, 3).
    """
    right, towards = axes(side, facing)
    depth = (camera.distance - points @ towards)[:, None]
    across = right + (points @ right)[:, None] / depth * towards
    up = [0, 1, 0] + (points[:, 1] - camera.height)[:, None] / depth * towards
    return camera.distance / depth * across, camera.distance / depth * up


def project(
    vertices: Floats,
    side: Side,
    *,
    size: tuple[int, int] = (600, 1200),
    camera: Camera = USUAL_CAMERA,
    facing: Facing = "right",
) -> Projection:
    """The projection that `rendering.render_png` uses for these vertices, (V, 3) in metres.

    Front and profile have one scale, the larger that both fit into the frame with.
    """
    ways = {name: axes(name, facing) for name in SIDES}
    spans = {}
    for name, (right, towards) in ways.items():
        across, up = _slopes(vertices, camera, right, towards)
        spans[name] = across.min(), across.max(), up.min(), up.max()
    width, height = size
    free = 1 - 2 * MARGIN
    focal = min(
        min(free * width / (most - least), free * height / (top - bottom))
        for least, most, bottom, top in spans.values()
    )
    least, most, bottom, top = spans[side]
    return Projection(
        camera,
        *ways[side],
        focal=float(focal),
        column=float(width / 2 - focal * (least + most) / 2),
        row=float(height / 2 + focal * (bottom + top) / 2),
    )


def axes(side: Side, facing: Facing) -> tuple[Floats, Floats]:
    """The picture's right and the way towards the camera: unit vectors in the body's axes, (3,)."""
    if side == "front":
        return np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    if facing == "right":  # the camera is at the person's right hand, at -X
        return np.array([0, 0, 1.0]), np.array([-1.0, 0, 0])
    return np.array([0, 0, -1.0]), np.array([1.0, 0, 0])


def _slopes(
    points: Floats,
    camera: Camera,
    right: Floats,
    towards: Floats,
) -> tuple[Floats, Floats]:
    """Sideways and upwards per metre of depth, as the camera sees points."""
    depth = camera.distance - points @ towards
    return points @ right / depth, (points[:, 1] - camera.height) / depth
