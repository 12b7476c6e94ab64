"""A body as pictures, front and profile.

Where the camera stands and what it makes of points is told in `cameras`; `studio` draws them.
"""

from __future__ import annotations

import io
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageChops

from model.appearance import BACKDROP, GARMENT_COLOUR, SKIN_COLOUR, DressedBody, dress, linear
from model.cameras import USUAL_CAMERA, Camera, Facing, Projection, Side, project
from model.geometry import Floats
from model.studio import Coat, Drawn, draw
from model.template_mesh import Body

if TYPE_CHECKING:
    from collections.abc import Sequence

# Points of a finer grid per pixel's side, averaged: a smooth outline.
FINENESS = 2

# Of a hundred. Beside the PNG file no difference is seen.
WEBP_QUALITY = 90

# The darkest of a foot's shadow on the floor, as a share of the light.
_SHADE = 0.32

_COVERED = [0] + [255] * 255


@dataclass(frozen=True, eq=False)
class Painted:
    """A surface in its colours, before any light falls on it.

    positions : ndarray of shape (N, 3), metres
    normals : ndarray of shape (N, 3), of length 1
    coats : faces (n, 3) that index the points, and their colour, sRGB from 0 to 1: one for all,
        (3,), or one for each point, (N, 3)
    """

    positions: Floats
    normals: Floats
    coats: Sequence[tuple[NDArray[np.int32], ArrayLike]]


@dataclass(frozen=True, eq=False)
class Photograph:
    """A picture, and how far away what it shows is.

    picture : RGB
    depths : ndarray of shape (FINENESS · height, FINENESS · width), metres along the way that the
        camera looks; infinite where there is nothing
    """

    picture: Image.Image
    depths: NDArray[np.float32]


def photograph(painted: Painted, projection: Projection, size: tuple[int, int]) -> Photograph:
    """A lit surface before the plain backdrop; size is width and height in pixels.

    Raises
    ------
    RenderingUnavailable
        If this machine lacks OSMesa; the message says what is missing.
    """
    drawn = draw(painted.positions, _lit(painted, projection), projection, size, FINENESS, True)
    picture = _before(Image.new("RGB", size, BACKDROP), drawn)
    depths = np.full((FINENESS * size[1], FINENESS * size[0]), np.inf, dtype=np.float32)
    left, top = (FINENESS * low for low in drawn.corner)
    high, wide = drawn.depths.shape
    depths[top : top + high, left : left + wide] = np.where(drawn.depths > 0, drawn.depths, np.inf)
    return Photograph(picture, depths)


def in_underwear(dressed: DressedBody) -> Painted:
    """A dressed body in the colours of its skin and garment."""
    coats = [(dressed.skin, SKIN_COLOUR), (dressed.garment, GARMENT_COLOUR)]
    return Painted(dressed.positions, dressed.normals, coats)


def render_png(
    body: Body,
    side: Side,
    *,
    size: tuple[int, int] = (600, 1200),
    silhouette: bool = False,
    camera: Camera = USUAL_CAMERA,
    facing: Facing = "right",
    projection: Projection | None = None,
) -> bytes:
    """A picture of the body in its plain underwear, as the bytes of a PNG file.

    `render_webp` gives the same without the silhouette, as a file of a tenth of its size.

    Parameters
    ----------
    body : Body
    side : "front" or "profile"
    size : width and height in pixels
    silhouette : the body's outline instead, filled: white on black, and nothing between
    camera : Camera
    facing : the picture's side that a person in profile looks to
    projection : where points fall, in place of camera and facing

    Raises
    ------
    RenderingUnavailable
        If this machine lacks OSMesa; the message says what is missing.
    """
    dressed = dress(body)
    if projection is None:
        projection = project(dressed.positions, side, size=size, camera=camera, facing=facing)
    if silhouette:
        return _png(_silhouette(dressed, projection, size))
    return _png(_picture(dressed, projection, size))


def render_webp(body: Body, side: Side, *, size: tuple[int, int] = (600, 1200)) -> bytes:
    """The picture of `render_png` for a page: the bytes of a WebP file.

    Raises
    ------
    RenderingUnavailable
        As `render_png`.
    """
    dressed = dress(body)
    stream = io.BytesIO()
    picture = _picture(dressed, project(dressed.positions, side, size=size), size)
    picture.save(stream, "WEBP", quality=WEBP_QUALITY, method=2)
    return stream.getvalue()


# ---- what the pictures show -------------------------------------------------------------------


def _silhouette(dressed: DressedBody, projection: Projection, size: tuple[int, int]) -> Image.Image:
    picture = Image.new("L", size)
    white = np.ones_like(dressed.positions)
    coats = [(dressed.skin, white), (dressed.garment, white)]
    drawn = draw(dressed.positions, coats, projection, size)
    picture.paste(Image.fromarray(drawn.colours[:, :, 0]), drawn.corner)
    return picture


def _picture(dressed: DressedBody, projection: Projection, size: tuple[int, int]) -> Image.Image:
    coats = _lit(in_underwear(dressed), projection)
    drawn = draw(dressed.positions, coats, projection, size, FINENESS)
    return _before(_backdrop(dressed, projection, size), drawn)


def _before(backdrop: Image.Image, drawn: Drawn) -> Image.Image:
    """What was drawn `FINENESS` times as fine, before a backdrop, which is painted over."""
    # The body was drawn on black, so that its edge pixels hold no more than their share of it.
    fine = Image.fromarray(drawn.colours)
    person = fine.reduce(FINENESS)
    cover = fine.getchannel("R").point(_COVERED).reduce(FINENESS)
    left, top = drawn.corner
    box = (left, top, left + person.width, top + person.height)
    black = Image.new("RGB", person.size)
    around = Image.composite(black, backdrop.crop(box), cover)
    backdrop.paste(ImageChops.add(person, around), drawn.corner)
    return backdrop


def _lit(painted: Painted, projection: Projection) -> list[Coat]:
    light = _light(painted.normals, projection)
    return [(faces, _srgb(linear(colour) * light)) for faces, colour in painted.coats]


def _light(normals: Floats, projection: Projection) -> Floats:
    """How much light leaves each point towards the camera, per colour: ndarray (N, 3).

    Reckoned at the points, some 15 mm apart, instead of at every pixel: the same to the eye for
    light as soft as this, and a third of the time under a software renderer. A broad warm lamp
    above the camera's left shoulder, a weak cool one from the right, light from the ceiling and
    back from the floor, and a little at the edges, which sets the body off from the backdrop.
    """
    right, towards = projection.right, projection.towards
    across, up, front = normals @ right, normals[:, 1], normals @ towards

    def lamp(direction: tuple[float, float, float], wrap: float) -> Floats:
        x, y, z = np.array(direction) / np.linalg.norm(direction)
        return np.maximum(0, (across * x + up * y + front * z + wrap) / (1 + wrap))

    def tint(amount: Floats, colour: tuple[float, float, float]) -> Any:
        return amount[:, None] * np.array(colour)

    edge = (1 - np.clip(front, 0, 1)) ** 3
    return (
        tint(lamp((-0.6, 0.55, 0.75), 0.15) ** 1.2, (1.0, 0.975, 0.93))
        + tint(lamp((0.9, 0.1, 0.35), 0.2) ** 1.5, (0.15, 0.17, 0.20))
        + tint(0.5 + 0.5 * up, (0.19, 0.20, 0.22))
        + tint(0.5 - 0.5 * up, (0.10, 0.09, 0.08))
        + tint(edge, (0.10, 0.10, 0.10))
    )


def _srgb(light: Floats) -> Floats:
    """Linear light as sRGB, each from 0 to 1 (IEC 61966-2-1)."""
    c = np.clip(light, 0, 1)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055)


def _backdrop(dressed: DressedBody, projection: Projection, size: tuple[int, int]) -> Image.Image:
    """A plain light backdrop with a soft shadow around each foot."""
    width, height = size
    picture = Image.new("RGB", size, BACKDROP)
    # Where the line of sight through a pixel below the camera's level meets the floor.
    down = (np.arange(height) + 0.5 - projection.row) / projection.focal
    for foot in _footprints(dressed):
        along = foot @ projection.towards
        middle, reach = (along.max() + along.min()) / 2, np.ptp(along) * 0.7 + 0.03
        seen = np.flatnonzero(down > 0.01)
        depth = projection.camera.height / down[seen]
        behind = (projection.camera.distance - depth - middle) / reach
        seen, depth, behind = (values[np.abs(behind) < 2.5] for values in (seen, depth, behind))
        if not len(seen):
            continue
        across = foot @ projection.right
        middle, reach = (across.max() + across.min()) / 2, np.ptp(across) * 0.7 + 0.03
        slope = (np.arange(width) + 0.5 - projection.column) / projection.focal
        beside = (slope[None, :] * depth[:, None] - middle) / reach
        shade = _SHADE * np.exp(-(beside**2) - behind[:, None] ** 2)
        rows = (0, int(seen[0]), width, int(seen[-1]) + 1)
        floor = np.asarray(picture.crop(rows)) * (1 - shade[:, :, None]) + 0.5
        picture.paste(Image.fromarray(floor.astype(np.uint8)), rows)
    return picture


def _footprints(dressed: DressedBody) -> list[Floats]:
    low = dressed.positions[dressed.positions[:, 1] < 0.04]
    feet = (low[low[:, 0] >= 0], low[low[:, 0] < 0])
    return [foot for foot in feet if len(foot)]


def _png(picture: Image.Image) -> bytes:
    # Runs only: on smooth shading both faster and a sixth smaller than the fastest full search.
    stream = io.BytesIO()
    picture.save(stream, "PNG", compress_level=1, compress_type=zlib.Z_RLE)
    return stream.getvalue()
