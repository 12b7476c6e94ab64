"""The one thread of a process that draws: the only file that imports pyrender.

A GL context belongs to one thread. What hangs in it cannot be stopped from within the process: it
is waited for only so long, and then nothing is drawn until it has ended, or its process has.
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from model.cameras import Projection
from model.geometry import Floats

if TYPE_CHECKING:
    from collections.abc import Callable

Result = TypeVar("Result")

Coat = tuple[NDArray[np.int32], Floats]
"""Faces (n, 3), and the colours of all points, (N, 3), sRGB from 0 to 1."""

DARKEST = 0.02
"""Nothing drawn is darker than this in red, so that what is darker is no body: 0 to 1."""

PATIENCE = 20.0
"""Seconds within which a part of a picture must be drawn; it takes some tenths of one."""


class RenderingUnavailable(RuntimeError):
    """Pictures cannot be drawn on this machine: OSMesa or what leads to it is missing."""


class RenderingTimedOut(RenderingUnavailable):
    """A picture was not drawn in time: this may be otherwise in a moment, or in another process."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """A part of a picture, `fineness` times as fine.

    colours : ndarray of shape (h, w, 3), sRGB from 0 to 255
    depths : ndarray of shape (h, w), metres along the way that the camera looks; 0 where nothing is
    corner : column and row of its upper left corner, in the picture's pixels
    """

    colours: NDArray[np.uint8]
    depths: NDArray[np.float32]
    corner: tuple[int, int]


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
        # Nothing is written to disk, and a container without one says nothing of it.
        os.environ["MESA_SHADER_CACHE_DISABLE"] = "true"
        try:
            _without_windows()
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
        _tell_contexts_by_address()
        self._renderer = self._pyrender.Renderer(*size)

    def close(self) -> None:
        """Give back the context, as far as it still lets itself be given back."""
        with contextlib.suppress(Exception):
            self._renderer.delete()
        with contextlib.suppress(Exception):
            self._platform.delete_context()

    def draw(
        self,
        parts: list[dict[str, Any]],
        projection: Projection,
        corner: tuple[int, int],
        size: tuple[int, int],
        fineness: int,
        with_depths: bool,
    ) -> Drawn:
        """The part of a picture from a corner on, `fineness` times as fine."""
        width, height = fineness * size[0], fineness * size[1]
        if width > self._size[0] or height > self._size[1]:
            self.close()
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
        colours = self._renderer.read_color_buf()
        depths = self._renderer.read_depth_buf() if with_depths else np.empty((0, 0), np.float32)
        return Drawn(colours, depths, corner)


def _without_windows() -> None:
    """With pyrender comes a viewer in a window, whose import wants libGL and all of X: servers have
    neither. Nobody looks at it here, and an empty module stands in for it.
    """
    viewer = ModuleType("pyrender.viewer")
    viewer.Viewer = None  # type: ignore[attr-defined]
    sys.modules.setdefault(viewer.__name__, viewer)


def _tell_contexts_by_address() -> None:
    """PyOpenGL asks OSMesa for the current context again and again, and what it is given never
    equals what it was given before. pyrender would then compile its programs anew for every part
    that it draws, and keep them all: a megabyte each.
    """
    from OpenGL.raw.osmesa._types import OSMesaContext

    OSMesaContext.__eq__ = lambda self, other: (
        isinstance(other, type(self)) and self.address == other.address
    )


_lock = threading.Lock()
_worker: ThreadPoolExecutor | None = None
_studio: _Studio | None = None
_due = math.inf
"""When what the thread is at must be done, by the clock that nobody sets; it begins when it begins,
not when it was asked for."""
_failure: str | None = None


def _forget_worker() -> None:
    """A forked process has the parent's variables but not its thread: begin anew there."""
    global _lock, _worker, _studio, _due, _failure
    _lock, _worker, _studio, _due, _failure = threading.Lock(), None, None, math.inf, None


os.register_at_fork(after_in_child=_forget_worker)


def hangs() -> bool:
    """Whether the thread that draws is at something that was due long ago."""
    return time.monotonic() > _due


def failure() -> str | None:
    """Why what was last to be drawn was not; "" if it was, None where there was nothing yet."""
    return _failure


def _in_studio(task: Callable[[_Studio], Result], patience: float = PATIENCE) -> Result:
    """Run a task in the thread that owns the GL contexts; the first one opens the studio.

    A studio in which a task failed is not used again: the task is tried once more in a new one.

    Parameters
    ----------
    patience : seconds that it may take; and that it is waited for, its turn included.

    Raises
    ------
    RenderingUnavailable
        Where it fails.
    RenderingTimedOut
        Where it takes longer; at once, where something before it does so still.
    """
    global _worker, _failure

    def attempt() -> Result:
        global _studio
        if _studio is None:
            _studio = _Studio()
        try:
            return task(_studio)
        except Exception:
            _studio.close()
            _studio = None
            raise

    def attempts() -> Result:
        try:
            return attempt()
        except RenderingUnavailable:
            raise
        except Exception:  # noqa: BLE001 - a driver's failure, of whatever kind
            try:
                return attempt()
            except Exception as error:
                raise RenderingUnavailable(f"drawing failed twice: {error!r}") from error

    def run() -> Result:
        global _due, _failure
        _due = time.monotonic() + patience
        try:
            result = attempts()
            _failure = ""
            return result
        except RenderingUnavailable as error:
            _failure = str(error)
            raise
        finally:
            _due = math.inf

    with _lock:
        if hangs():
            raise RenderingTimedOut("an earlier picture is not finished")
        if _worker is None:
            _worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="rendering")
        drawing = _worker.submit(run)
    try:
        return drawing.result(patience)
    except TimeoutError as error:
        if not drawing.cancel() and drawing.done():
            return drawing.result()
        _failure = f"a picture was not drawn within {patience:g} seconds"
        raise RenderingTimedOut(_failure) from error


def draw(
    positions: Floats,
    coats: list[Coat],
    projection: Projection,
    size: tuple[int, int],
    fineness: int = 1,
    with_depths: bool = False,
) -> Drawn:
    """Faces in the given colours of all points, (N, 3), on black.

    Draws the smallest part of the picture that holds the points: the rest need not be drawn.

    Parameters
    ----------
    positions : ndarray of shape (N, 3), metres.
    size : width and height of the whole picture in pixels.
    fineness : points that are drawn to each pixel's side.
    with_depths : whether `depths` are wanted; without, they are of shape (0, 0).

    Raises
    ------
    RenderingUnavailable, RenderingTimedOut
        If this machine lacks OSMesa, or the picture is not drawn in time.
    """
    parts = [
        {
            "positions": positions.astype(np.float32),
            "indices": faces.astype(np.uint32),
            "color_0": np.insert(np.maximum(colours, DARKEST), 3, 1, axis=1).astype(np.float32),
        }
        for faces, colours in coats
        if len(faces)
    ]
    pixels = projection.pixels(positions)
    left, top = (int(low) for low in np.maximum(np.floor(pixels.min(axis=0)) - 1, 0))
    right, bottom = (int(high) for high in np.minimum(np.ceil(pixels.max(axis=0)) + 1, size))
    corner, part = (left, top), (right - left, bottom - top)
    return _in_studio(lambda s: s.draw(parts, projection, corner, part, fineness, with_depths))
