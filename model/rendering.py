"""A body as pictures, front and profile: the only file that imports pyrender.

The camera stands at `distance` from the body's vertical axis and looks level from `height`, as a
person with a telephone does who does not tilt it. The picture's frame is shifted, not the camera,
so that soles and crown are in it. Pixels are counted from the picture's upper left corner; a
pixel's middle lies at a half.
"""

from __future__ import annotations

import io
import os
import threading
import zlib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageChops

from model.appearance import GARMENT_COLOUR, SKIN_COLOUR, DressedBody, dress, linear
from model.template_mesh import Body

if TYPE_CHECKING:
    from collections.abc import Callable

Side = Literal["front", "profile"]
Facing = Literal["right", "left"]
Result = TypeVar("Result")

# Metres. Nearer, the lens would touch a large body's belly; farther, perspective no longer matters.
DISTANCES = (1.0, 10.0)
HEIGHTS = (0.0, 3.0)

# The picture's edge stays free by this share of its width and height on every side.
MARGIN = 0.04

# Points of a finer grid per pixel's side, averaged: a smooth outline.
FINENESS = 2

# As the viewer's on the page (static/css/site.css, --backdrop).
BACKDROP = (244, 242, 239)

# The darkest of a foot's shadow on the floor, as a share of the light.
_SHADE = 0.32

# Nothing drawn is darker than this in red, so that what is darker is no body: 0 to 1.
_DARKEST = 0.02
_COVERED = [0] + [255] * 255


class RenderingUnavailable(RuntimeError):
    """Pictures cannot be drawn on this machine: OSMesa or what leads to it is missing."""


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


@dataclass(frozen=True, slots=True)
class Projection:
    """What a camera makes of points: `pixels(points)`.

    right, towards : ndarrays of shape (3,), the picture's right and the way to the camera
    focal : pixels for a slope of one
    column, row : the pixel that the camera looks at, level
    """

    camera: Camera
    right: NDArray[np.float64]
    towards: NDArray[np.float64]
    focal: float
    column: float
    row: float

    def pixels(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where points, (n, 3) in metres, fall in the picture: (n, 2), column and row."""
        across, up = _slopes(points, self.camera, self.right, self.towards)
        return np.column_stack([self.column + self.focal * across, self.row - self.focal * up])


def project(
    vertices: NDArray[np.float64],
    side: Side,
    *,
    size: tuple[int, int] = (600, 1200),
    camera: Camera = Camera(),
    facing: Facing = "right",
) -> Projection:
    """The projection that `render_png` uses for these vertices, (V, 3) in metres.

    Front and profile have one scale, the larger that both fit into the frame with.
    """
    axes = {name: _axes(name, facing) for name in ("front", "profile")}
    spans = {}
    for name, (right, towards) in axes.items():
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
        *axes[side],
        focal=float(focal),
        column=float(width / 2 - focal * (least + most) / 2),
        row=float(height / 2 + focal * (bottom + top) / 2),
    )


def render_png(
    body: Body,
    side: Side,
    *,
    size: tuple[int, int] = (600, 1200),
    silhouette: bool = False,
    camera: Camera = Camera(),
    facing: Facing = "right",
) -> bytes:
    """A picture of the body in its plain underwear, as the bytes of a PNG file.

    Parameters
    ----------
    body : Body
    side : "front" or "profile"
    size : width and height in pixels
    silhouette : the body's outline instead, filled: white on black, and nothing between
    camera : Camera
    facing : the picture's side that a person in profile looks to

    Raises
    ------
    RenderingUnavailable
        If this machine lacks OSMesa; the message says what is missing.
    """
    dressed = dress(body)
    projection = project(dressed.positions, side, size=size, camera=camera, facing=facing)
    if silhouette:
        return _png(_silhouette(dressed, projection, size))
    return _png(_picture(dressed, projection, size))


def _axes(side: str, facing: Facing) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The picture's right and the way towards the camera, in the body's axes."""
    if side == "front":
        return np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    if facing == "right":  # the camera is at the person's right hand, at -X
        return np.array([0, 0, 1.0]), np.array([-1.0, 0, 0])
    return np.array([0, 0, -1.0]), np.array([1.0, 0, 0])


def _slopes(
    points: NDArray[np.float64],
    camera: Camera,
    right: NDArray[np.float64],
    towards: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sideways and upwards per metre of depth, as the camera sees points."""
    depth = camera.distance - points @ towards
    return points @ right / depth, (points[:, 1] - camera.height) / depth


# ---- what the pictures show -------------------------------------------------------------------


def _silhouette(dressed: DressedBody, projection: Projection, size: tuple[int, int]) -> Image.Image:
    picture = Image.new("L", size)
    white = np.ones_like(dressed.positions)
    drawn, corner = _draw(dressed, white, white, projection, size)
    picture.paste(Image.fromarray(drawn[:, :, 0]), corner)
    return picture


def _picture(dressed: DressedBody, projection: Projection, size: tuple[int, int]) -> Image.Image:
    light = _light(dressed, projection)
    skin, garment = (_srgb(linear(colour) * light) for colour in (SKIN_COLOUR, GARMENT_COLOUR))
    drawn, corner = _draw(dressed, skin, garment, projection, size, FINENESS)
    # The body was drawn on black, so that its edge pixels hold no more than their share of it.
    fine = Image.fromarray(drawn)
    person = fine.reduce(FINENESS)
    cover = fine.getchannel("R").point(_COVERED).reduce(FINENESS)
    picture = _backdrop(dressed, projection, size)
    box = (*corner, corner[0] + person.width, corner[1] + person.height)
    black = Image.new("RGB", person.size)
    around = Image.composite(black, picture.crop(box), cover)
    picture.paste(ImageChops.add(person, around), corner)
    return picture


def _light(dressed: DressedBody, projection: Projection) -> NDArray[np.float64]:
    """How much light leaves each point towards the camera, per colour: ndarray (N, 3).

    Reckoned at the points, some 15 mm apart, instead of at every pixel: the same to the eye for
    light as soft as this, and a third of the time under a software renderer. A broad warm lamp
    above the camera's left shoulder, a weak cool one from the right, light from the ceiling and
    back from the floor, and a little at the edges, which sets the body off from the backdrop.
    """
    normals, right, towards = dressed.normals, projection.right, projection.towards
    across, up, front = normals @ right, normals[:, 1], normals @ towards

    def lamp(direction: tuple[float, float, float], wrap: float) -> NDArray[np.float64]:
        x, y, z = np.array(direction) / np.linalg.norm(direction)
        return np.maximum(0, (across * x + up * y + front * z + wrap) / (1 + wrap))

    def tint(amount: NDArray[np.float64], colour: tuple[float, float, float]) -> Any:
        return amount[:, None] * np.array(colour)

    edge = (1 - np.clip(front, 0, 1)) ** 3
    return (
        tint(lamp((-0.6, 0.55, 0.75), 0.15) ** 1.2, (1.0, 0.975, 0.93))
        + tint(lamp((0.9, 0.1, 0.35), 0.2) ** 1.5, (0.15, 0.17, 0.20))
        + tint(0.5 + 0.5 * up, (0.19, 0.20, 0.22))
        + tint(0.5 - 0.5 * up, (0.10, 0.09, 0.08))
        + tint(edge, (0.10, 0.10, 0.10))
    )


def _srgb(light: NDArray[np.float64]) -> NDArray[np.float64]:
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


def _footprints(dressed: DressedBody) -> list[NDArray[np.float64]]:
    low = dressed.positions[dressed.positions[:, 1] < 0.04]
    feet = (low[low[:, 0] >= 0], low[low[:, 0] < 0])
    return [foot for foot in feet if len(foot)]


def _png(picture: Image.Image) -> bytes:
    # Runs only: on smooth shading both faster and a sixth smaller than the fastest full search.
    stream = io.BytesIO()
    picture.save(stream, "PNG", compress_level=1, compress_type=zlib.Z_RLE)
    return stream.getvalue()


# ---- the one thread that draws ----------------------------------------------------------------


class _Studio:
    """pyrender on one GL context. Made and used in one thread only.

    pyrender's own OffscreenRenderer makes a context anew for every picture size, and always reads
    the depths back, which takes longer than to draw them. So its parts are used here.
    """

    def __init__(self) -> None:
        os.environ["PYOPENGL_PLATFORM"] = "osmesa"
        # Mesa's own threads would be missing after a fork, and the first picture wait for them
        # for ever. Without them it is no slower: reading the pixels back takes the time.
        os.environ["LP_NUM_THREADS"] = "0"
        try:
            import pyrender
            from pyrender.platforms.osmesa import OSMesaPlatform

            self._pyrender = pyrender
            self._platform_class = OSMesaPlatform
            self._open((1200, 2400))
        except Exception as error:  # every layer below fails in its own way
            raise RenderingUnavailable(
                f"pictures need OSMesa (Debian: libosmesa6) and pyrender: {error!r}"
            ) from error

    def _open(self, size: tuple[int, int]) -> None:
        self._size = size
        self._platform = self._platform_class(*size)
        self._platform.init_context()
        self._platform.make_current()
        self._renderer = self._pyrender.Renderer(*size)

    def draw(
        self,
        parts: list[dict[str, Any]],
        projection: Projection,
        corner: tuple[int, int],
        size: tuple[int, int],
        fineness: int,
    ) -> NDArray[np.uint8]:
        """The part of a picture from a corner on, `fineness` times as fine: (height, width, 3)."""
        width, height = fineness * size[0], fineness * size[1]
        if width > self._size[0] or height > self._size[1]:
            self._renderer.delete()
            self._platform.delete_context()
            self._open((max(width, self._size[0]), max(height, self._size[1])))
        pyrender, camera = self._pyrender, projection.camera
        scene = pyrender.Scene(bg_color=(0.0, 0.0, 0.0, 0.0))
        scene.add(pyrender.Mesh([pyrender.Primitive(mode=4, **part) for part in parts]))
        pose = np.eye(4)
        pose[:3, 0], pose[:3, 2] = projection.right, projection.towards
        pose[:3, 3] = camera.distance * projection.towards + (0, camera.height, 0)
        lens = pyrender.IntrinsicsCamera(
            fx=fineness * projection.focal,
            fy=fineness * projection.focal,
            cx=fineness * (projection.column - corner[0]),
            cy=fineness * (projection.row - corner[1]),
            znear=0.05,
            zfar=camera.distance + 5,
        )
        scene.add(lens, pose=pose)
        self._renderer.viewport_width, self._renderer.viewport_height = width, height
        # Flat: the colours are the points' own, already lit.
        self._renderer.render(scene, pyrender.RenderFlags.FLAT)
        drawn: NDArray[np.uint8] = self._renderer.read_color_buf()
        return drawn


_lock = threading.Lock()
_worker: ThreadPoolExecutor | None = None
_studio: _Studio | None = None


def _forget_worker() -> None:
    """A forked process has the parent's variables but not its thread: begin anew there."""
    global _lock, _worker, _studio
    _lock, _worker, _studio = threading.Lock(), None, None


os.register_at_fork(after_in_child=_forget_worker)


def _in_studio(task: Callable[[_Studio], Result]) -> Result:
    """Run a task in the thread that owns the GL contexts; the first one opens the studio."""
    global _worker

    def run() -> Result:
        global _studio
        if _studio is None:
            _studio = _Studio()
        return task(_studio)

    with _lock:
        if _worker is None:
            _worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="rendering")
        worker = _worker
    return worker.submit(run).result()


def _draw(
    dressed: DressedBody,
    skin: NDArray[np.float64],
    garment: NDArray[np.float64],
    projection: Projection,
    size: tuple[int, int],
    fineness: int = 1,
) -> tuple[NDArray[np.uint8], tuple[int, int]]:
    """The body in the given colours of its points, (N, 3), on black.

    Returns the smallest part of the picture that holds the body, and its upper left corner: the
    rest need not be drawn.
    """
    positions = dressed.positions.astype(np.float32)
    parts = [
        {
            "positions": positions,
            "indices": faces.astype(np.uint32),
            "color_0": np.insert(np.maximum(colours, _DARKEST), 3, 1, axis=1).astype(np.float32),
        }
        for faces, colours in ((dressed.skin, skin), (dressed.garment, garment))
        if len(faces)
    ]
    pixels = projection.pixels(dressed.positions)
    left, top = (int(low) for low in np.maximum(np.floor(pixels.min(axis=0)) - 1, 0))
    right, bottom = (int(high) for high in np.minimum(np.ceil(pixels.max(axis=0)) + 1, size))
    part = right - left, bottom - top
    drawn = _in_studio(lambda s: s.draw(parts, projection, (left, top), part, fineness))
    return drawn, (left, top)
