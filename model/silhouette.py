"""A body's silhouette: drawn as pixels, and its edges row by row with their derivatives.

All on the upright plane through the body's axis as a camera sees it (`cameras.seen`): metres to
the picture's right of the axis, and above the floor.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from model.cameras import USUAL_CAMERA, Camera, Facing, Side, seen, seen_slopes
from model.geometry import Booleans, Floats, Integers, edges_of
from model.masks import Mask
from model.template_mesh import Body, Gradient, TemplateMesh

ROWS = 900
"""Pixels from crown to soles: under 2 mm each."""

ARMS = ("upper_arm", "lower_arm", "hand")
UPRIGHT = ("head_neck", "torso", "upper_leg", "lower_leg", "foot")
"""All but the arms."""

LEG = ("upper_leg_left", "lower_leg_left")

_PARTS = 4
"""Parts of a pixel's breadth that are told apart where it is said how much of it is covered."""

_STEEPEST = 2.0
"""An outline that runs more level than this, metres sideways for one upwards, has no edge that a
row tells: its slope is held here."""

_NEAR = 0.004
"""Metres up and down over which an outline's slope is taken."""


def fill(points: Floats, faces: NDArray[np.int32], size: tuple[int, int]) -> Booleans:
    """The pixels whose middle lies in a triangle.

    Parameters
    ----------
    points : ndarray of shape (V, 2), columns and rows; a pixel's middle lies at a half.
    faces : ndarray of shape (F, 3).
    size : width and height in pixels.

    Returns
    -------
    ndarray of bool, shape (height, width).
    """
    width, height = size
    order = np.argsort(points[:, 1][faces], axis=1, kind="stable")
    top, middle, low = points[np.take_along_axis(faces, order, axis=1)].transpose(1, 0, 2)
    first = np.clip(np.ceil(top[:, 1] - 0.5), 0, height).astype(np.int64)
    last = np.clip(np.ceil(low[:, 1] - 0.5), 0, height).astype(np.int64)
    count = last - first
    owner = np.repeat(np.arange(len(faces)), count)
    rows = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count) + first[owner]
    a, b, c = top[owner], middle[owner], low[owner]
    y = rows + 0.5
    upper = y < b[:, 1]
    start, stop = np.where(upper[:, None], a, b), np.where(upper[:, None], b, c)
    long = a[:, 0] + (c[:, 0] - a[:, 0]) * (y - a[:, 1]) / (c[:, 1] - a[:, 1])
    rise = stop[:, 1] - start[:, 1]
    share = np.divide(y - start[:, 1], rise, out=np.zeros_like(y), where=rise > 0)
    short = start[:, 0] + (stop[:, 0] - start[:, 0]) * share
    ends = np.clip(np.ceil(np.sort([long, short], axis=0) - 0.5), 0, width).astype(np.int64)
    cells = rows * (width + 1) + ends
    counts = [np.bincount(cell, minlength=height * (width + 1)) for cell in cells]
    inside: Booleans = np.cumsum((counts[0] - counts[1]).reshape(height, -1), axis=1)[:, :-1] > 0
    return inside


def cover(points: Floats, faces: NDArray[np.int32], size: tuple[int, int]) -> NDArray[np.float32]:
    """How much of each pixel lies in triangles, along the row through its middle.

    Parameters
    ----------
    points, faces, size : see `fill`.

    Returns
    -------
    ndarray of float32, shape (height, width), from 0 to 1.
    """
    width, height = size
    fine = fill(points * [_PARTS, 1], faces, (_PARTS * width, height))
    parts = fine.reshape(height, width, _PARTS)
    return np.asarray(parts.mean(axis=2, dtype=np.float32))


def towards_camera(points: Floats, faces: NDArray[np.int32]) -> NDArray[np.int32]:
    """The triangles that turn their outside to the camera: those of a body cover all of it.

    Parameters
    ----------
    points : ndarray of shape (V, 2), columns and rows, rows downwards.
    """
    a, b, c = points[faces].transpose(1, 2, 0)
    first = (b[0] - a[0]) * (c[1] - a[1])
    facing: NDArray[np.int32] = faces[first < (c[0] - a[0]) * (b[1] - a[1])]
    return facing


def silhouette(
    body: Body,
    side: Side,
    *,
    camera: Camera = USUAL_CAMERA,
    facing: Facing = "right",
    rows: int = ROWS,
) -> Mask:
    """A body's outline as a camera sees it, arms included, so many rows high."""
    flat = seen(body.vertices, side, camera, facing)
    low, high = flat.min(axis=0), flat.max(axis=0)
    step = (high[1] - low[1]) / rows
    points = np.column_stack([flat[:, 0] - low[0], high[1] - flat[:, 1]]) / step
    size = (int(np.ceil(points[:, 0].max())), rows)
    return Mask(cover(points, towards_camera(points, body.template.faces), size), 0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Contour:
    """The outermost points of some parts of a body, row by row.

    Attributes
    ----------
    positions : ndarray of shape (n, 2), metres: the leftmost and the rightmost point of a row.
    edges : ndarray of shape (n, 2, 2), the mesh edge that each lies on, by its vertices.
    shares : ndarray of shape (n, 2), how far along that edge.
    slopes : ndarray of shape (n, 2), how far sideways the outline goes for each metre up.
    """

    positions: Floats
    edges: Integers
    shares: Floats
    slopes: Floats


def contour(
    template: TemplateMesh, flat: Floats, parts: tuple[str, ...], heights: Floats
) -> Contour:
    """The outermost points of some parts at some heights.

    Parameters
    ----------
    flat : ndarray of shape (V, 2), as `cameras.seen` gives it.
    heights : ndarray of shape (n,), metres above the floor on that plane.

    Raises
    ------
    ValueError
        Where nothing is met at a height.
    """
    edges = _edges(template, parts)
    positions, found, shares = _outermost(flat, edges, heights)
    above, below = (_outermost(flat, edges, heights + way)[0] for way in (_NEAR, -_NEAR))
    slopes = np.clip((above - below) / (2 * _NEAR), -_STEEPEST, _STEEPEST)
    return Contour(positions, edges[found], shares, slopes)


def contour_gradients(
    found: Contour, vertices: Floats, side: Side, camera: Camera, facing: Facing
) -> list[Gradient]:
    """Derivatives of a contour's positions by the vertices, (V, 3): of all on the left, then of
    all on the right.

    As the body moves another of its points may come to lie in the row: to first order that is
    the outline's slope times how much higher the point has come.
    """
    gradients = []
    for end in (0, 1):
        for edge, share, slope in zip(
            found.edges[:, end], found.shares[:, end], found.slopes[:, end], strict=True
        ):
            across, up = seen_slopes(vertices[edge], side, camera, facing)
            weights = np.array([1 - share, share])[:, None]
            gradients.append((edge, weights * (across - slope * up)))
    return gradients


def _outermost(flat: Floats, edges: Integers, heights: Floats) -> tuple[Floats, Integers, Floats]:
    """Left and right: positions, places among the edges, and shares along them, (n, 2) each."""
    starts, ends = flat[edges[:, 0]], flat[edges[:, 1]]
    low = np.minimum(starts[:, 1], ends[:, 1])
    high = np.maximum(starts[:, 1], ends[:, 1])
    positions = np.empty((len(heights), 2))
    shares = np.empty((len(heights), 2))
    found = np.empty((len(heights), 2), dtype=np.int64)
    for row, height in enumerate(heights.tolist()):
        met = np.flatnonzero((low < height) & (high >= height))
        if not len(met):
            raise ValueError(f"nothing is met {height:.3f} m above the floor")
        share = (height - starts[met, 1]) / (ends[met, 1] - starts[met, 1])
        across = starts[met, 0] + share * (ends[met, 0] - starts[met, 0])
        outer = [across.argmin(), across.argmax()]
        positions[row], found[row], shares[row] = across[outer], met[outer], share[outer]
    return positions, found, shares


@lru_cache(maxsize=64)
def _edges(template: TemplateMesh, parts: tuple[str, ...]) -> Integers:
    return edges_of(template.faces[template.faces_of(*parts)])
