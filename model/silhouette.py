"""Outlines of bodies beside outlines in pictures: drawn, laid over one another, compared.

Both lie on one sheet: the upright plane through the body's axis, seen from the photo's camera,
in pixels of equal size. The photo is scaled by the stature, between crown and soles, put on the
ground, and moved sideways until trunk and legs lie over one another best. Arms rarely hang as
the avatar's do, so they are left out of what is judged: of the avatar by its body parts, of the
photo where they stand off the trunk. Where they touch it, nothing beside the trunk is judged.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

from model.anthropometry import TAPES
from model.cameras import USUAL_CAMERA, Camera, Facing, Side, seen
from model.geometry import Booleans, Floats, Integers, edges_of
from model.girths import Girth, tie
from model.masks import LIGHT, Mask, PictureRefusedError, runs
from model.template_mesh import Body, TemplateMesh

ROWS = 900
"""Pixels of the sheet from crown to soles: under 2 mm each."""

MARGIN = 24
"""Pixels of the sheet around what lies on it."""

ARMS = ("upper_arm", "lower_arm", "hand")
UPRIGHT = ("head_neck", "torso", "upper_leg", "lower_leg", "foot")
"""What is judged."""

LEG = ("upper_leg_left", "lower_leg_left")

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

FREE = 0.3
"""A run of the photo's pixels that overlaps the avatar by less than this share is an arm."""

ARMS_END = 0.30
"""Of the stature: lower down there are no hands, of whoever stands upright."""

HANDS_END = 0.36
"""Of the stature: down to here a hand may lie on a thigh, unseen."""

_SMOOTH = 2
"""A breadth is the mean over this many rows above and below, too."""

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


def silhouette(
    body: Body, side: Side, *, camera: Camera = USUAL_CAMERA, facing: Facing = "right"
) -> Mask:
    """A body's outline as a camera sees it, arms included, `ROWS` high."""
    flat = seen(body.vertices, side, camera, facing)
    low, high = flat.min(axis=0), flat.max(axis=0)
    step = (high[1] - low[1]) / ROWS
    points = np.column_stack([flat[:, 0] - low[0], high[1] - flat[:, 1]]) / step
    size = (int(np.ceil(points[:, 0].max())), ROWS)
    cover = fill(points, body.template.faces, size).astype(np.float32)
    return Mask(cover, 0.0, 0.0, 1.0)


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
    ways: tuple[Facing, ...]
    ways = ("right",) if side == "front" else ("right", "left") if facing is None else (facing,)
    sheets = [_Sheet(mask, body, side, camera, way) for way in ways]
    best = max(sheets, key=lambda sheet: sheet.overlap)
    if best.overlap < LEAST_OVERLAP:
        raise PictureRefusedError(
            "no_person", f"{best.overlap:.2f} of the outline is a person's, under {LEAST_OVERLAP}"
        )
    return best.compared()


class _Sheet:
    """A photo and a body laid over one another."""

    def __init__(self, mask: Mask, body: Body, side: Side, camera: Camera, facing: Facing) -> None:
        self.body, self.side, self.camera, self.facing = body, side, camera, facing
        template = body.template
        self.flat = seen(body.vertices, side, camera, facing)
        low, high = self.flat[:, 1].min(), self.flat[:, 1].max()
        self.step = float((high - low) / ROWS)
        reach = float(np.abs(self.flat[:, 0]).max()) / self.step
        ratio = len(mask.cover) / ROWS
        half = int(max(reach, 0.8 * mask.cover.shape[1] / ratio)) + MARGIN
        self.size = (2 * half, ROWS + 2 * MARGIN)
        self.origin = (float(half), MARGIN + high / self.step)
        self.points = self.origin + self.flat / self.step * [1, -1]
        upright = template.faces[template.faces_of(*UPRIGHT)]
        self.upright = fill(self.points, upright, self.size)
        self.whole = fill(self.points, template.faces, self.size)
        left = half - mask.cover.shape[1] / ratio / 2
        left += self._shift(_laid(mask, left, ratio, self.size) >= LIGHT)
        self.cover = _laid(mask, left, ratio, self.size)
        self.photo: Booleans = self.cover >= LIGHT
        scale = ratio * mask.scale
        self.place = (mask.left - scale * left, mask.top - scale * MARGIN, scale)
        common = (self.photo & self.upright).sum()
        self.overlap = float(
            common / ((self.photo & self.whole).sum() + (self.photo ^ self.whole).sum())
        )

    def _shift(self, photo: Booleans) -> float:
        """How far to the right the photo goes, in pixels, to have most in common."""
        width = self.size[0]
        spectra = [np.fft.rfft(mask, 2 * width, axis=1) for mask in (self.upright, photo)]
        common = np.fft.irfft((spectra[0] * spectra[1].conj()).sum(axis=0), 2 * width)
        peak = int(common.argmax())
        before, at, after = common[[peak - 1, peak, (peak + 1) % (2 * width)]]
        bend = before - 2 * at + after
        fine = 0.5 * (before - after) / bend if bend < 0 else 0.0
        return float((peak + fine + width) % (2 * width) - width)

    def compared(self) -> Comparison:
        arms, hidden = self._arms()
        photo, avatar = self.photo & ~arms, self.upright & ~arms
        levels, unseen = self._levels(arms, hidden)
        return Comparison(
            side=self.side,
            camera=self.camera,
            facing=self.facing,
            step=self.step,
            photo=self.photo,
            avatar=self.whole,
            arms=arms,
            iou=float((photo & avatar).sum() / (photo | avatar).sum()),
            distance=_apart(photo, avatar, arms) * self.step,
            levels=tuple(levels),
            unseen=tuple(unseen),
            origin=self.origin,
            place=self.place,
        )

    def _row(self, height: float) -> int:
        """The row at a height on the sheet, as a share of the stature."""
        return int(MARGIN + (1 - height) * ROWS)

    def _arms(self) -> tuple[Booleans, Booleans]:
        """What is not judged: (h, w); and on which side of which row an arm hides it: (2, h)."""
        height, width = self.photo.shape
        arms = np.zeros_like(self.photo)
        hidden = np.zeros((2, height), dtype=bool)
        common = np.zeros((height, width + 1), dtype=np.int64)
        np.cumsum(self.upright, axis=1, out=common[:, 1:])
        rows, starts, ends = runs(self.photo)
        kept = common[rows, ends] - common[rows, starts] >= FREE * (ends - starts)
        kept |= rows >= self._row(ARMS_END)
        first, last = np.full(height, width), np.zeros(height, dtype=np.int64)
        np.minimum.at(first, rows[kept], starts[kept])
        np.maximum.at(last, rows[kept], ends[kept])
        sides = (ends <= first[rows]) & ~kept, (starts >= last[rows]) & ~kept
        for row, start, end in zip(rows[~kept], starts[~kept], ends[~kept], strict=True):
            arms[row, start:end] = True
        shoulder = self._landmark_row("acromion_left")
        if self.side == "profile":
            # An arm that hangs is before the trunk or behind it: what it hides there is not known.
            arms |= self.whole & ~self.upright
            return arms, hidden
        outside = ~self.upright
        columns = np.arange(width)
        for side in (0, 1):
            apart = np.zeros(height, dtype=bool)
            apart[rows[sides[side]]] = True
            apart[:shoulder] = False
            rest = np.zeros(height, dtype=bool)
            rest[shoulder : self._row(HANDS_END)] = True
            if apart.any():
                low = int(np.flatnonzero(apart).max())
                # A hand that ends freely hides nothing below it.
                if self._ends_freely(low, side, first, last):
                    rest[low + 1 :] = False
            hidden[side] = rest & ~apart
            edge = _edges_of(self.upright)[side]
            beyond = columns[None] < edge[:, None] if side == 0 else columns[None] >= edge[:, None]
            arms |= hidden[side][:, None] & beyond & outside
        return arms, hidden

    def _ends_freely(self, row: int, side: int, first: Integers, last: Integers) -> bool:
        """Whether below this row, the last where an arm stands off, the leg grows no broader."""
        near, below = row - 3, row + 6
        ends = first if side == 0 else last
        grown = (ends[near] - ends[below]) * (1 if side == 0 else -1)
        return bool(grown < 0.012 * ROWS)

    def _landmark_row(self, *names: str) -> int:
        point = self.body.template.landmark_points(self.body.vertices, *names)
        flat = seen(point[None], self.side, self.camera, self.facing)[0]
        return int(self.origin[1] - flat[1] / self.step)

    def _levels(self, arms: Booleans, hidden: Booleans) -> tuple[list[Level], list[str]]:
        """Breadths or depths from the top down, and the levels that cannot be told."""
        names = LEVELS[self.side]
        template = self.body.template
        girths = [girth for name in names if isinstance(girth := TAPES[name], Girth)]
        tied, rows = tie(template, self.body.vertices[None], girths)
        levels, unseen = [], []
        for name, row in zip(names, rows[0].tolist(), strict=True):
            leg = self.side == "front" and name not in TRUNK_LEVELS
            loop = seen(tied.loop(row), self.side, self.camera, self.facing)
            ends = loop[[loop[:, 0].argmin(), loop[:, 0].argmax()]]
            height = float(self.origin[1] - ends[:, 1].mean() / self.step)
            edges = _edges(template, LEG if leg else UPRIGHT)
            near = range(int(height) - _SMOOTH, int(height) + _SMOOTH + 1)
            avatar = np.mean([crossing(self.points, edges, row + 0.5) for row in near], axis=0)
            photo = None
            if leg or not hidden[:, int(height)].any():
                photo = self._breadth(near, arms, avatar, legs=leg)
            if photo is None:
                unseen.append(name)
                continue
            levels.append(
                Level(
                    measurement=name,
                    photo=photo * self.step,
                    avatar=float(np.ptp(avatar)) * self.step,
                    height=float((self.origin[1] - height) * self.step),
                )
            )
        return sorted(levels, key=lambda level: -level.height), unseen

    def _breadth(self, near: range, arms: Booleans, avatar: Floats, *, legs: bool) -> float | None:
        """The photo's mean breadth in rows, in pixels; None where legs do not stand apart."""
        found = []
        for row in near:
            cover = np.where(arms[row], 0, self.cover[row])
            spans = _spans(cover)
            if legs and len(spans) == 2:
                found.append(float(np.mean([end - start for start, end in spans])))
            elif not legs:
                met = [end for end in spans if end[0] < avatar[1] and end[1] > avatar[0]]
                if met:
                    found.append(met[-1][1] - met[0][0])
        return float(np.mean(found)) if len(found) > _SMOOTH else None


def crossing(points: Floats, edges: Integers, row: float) -> tuple[float, float]:
    """From where to where edges meet a row.

    Parameters
    ----------
    points : ndarray of shape (V, 2), columns and rows.
    edges : ndarray of shape (E, 2).

    Raises
    ------
    ValueError
        Where none does.
    """
    starts, ends = points[edges[:, 0]], points[edges[:, 1]]
    met = (starts[:, 1] - row) * (ends[:, 1] - row) < 0
    if not met.any():
        raise ValueError(f"nothing is met in row {row:.1f}")
    starts, ends = starts[met], ends[met]
    share = (row - starts[:, 1]) / (ends[:, 1] - starts[:, 1])
    columns = starts[:, 0] + share * (ends[:, 0] - starts[:, 0])
    return float(columns.min()), float(columns.max())


def _spans(cover: NDArray[np.float32]) -> list[tuple[float, float]]:
    """Where a row is person, within a pixel's parts: an edge lies where its cover passes a half."""
    _, starts, ends = runs(cover[None] >= LIGHT)
    padded = np.concatenate([[0], cover, [0]])
    spans = []
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        before, at = padded[start], padded[start + 1]
        last, after = padded[end], padded[end + 1]
        spans.append(
            (
                start + 0.5 - (at - LIGHT) / (at - before),
                end - 0.5 + (last - LIGHT) / (last - after),
            )
        )
    return spans


def _laid(mask: Mask, left: float, ratio: float, size: tuple[int, int]) -> NDArray[np.float32]:
    """A mask on the sheet, its left edge in some column and `ratio` of its pixels to one."""
    grey = Image.fromarray((np.pad(mask.cover, 1) * 255).astype(np.uint8))
    placed = (ratio, 0, 1 - ratio * left, 0, ratio, 1 - ratio * MARGIN)
    laid = grey.transform(size, Image.Transform.AFFINE, placed, Image.Resampling.BILINEAR)
    cover: NDArray[np.float32] = np.asarray(laid).astype(np.float32) / np.float32(255)
    return cover


def _apart(one: Booleans, other: Booleans, blind: Booleans) -> float:
    """How far two outlines are from one another, in pixels: the mean both ways.

    Where they border on what is not judged, they are no outlines.
    """
    seam = ndimage.binary_dilation(blind, iterations=2)
    edges = [(mask & ~ndimage.binary_erosion(mask)) for mask in (one, other)]
    ways = []
    for edge, target in (edges, edges[::-1]):
        distances = ndimage.distance_transform_edt(~target)
        ways.append(distances[edge & ~seam])
    return float(np.mean([way.mean() for way in ways if len(way)]))


def _edges_of(inside: Booleans) -> tuple[Integers, Integers]:
    """The first filled column of each row and the one past the last; of empty rows, both ends."""
    width = inside.shape[1]
    some = inside.any(axis=1)
    first = np.where(some, inside.argmax(axis=1), width)
    last = np.where(some, width - inside[:, ::-1].argmax(axis=1), 0)
    return first, last


@lru_cache(maxsize=64)
def _edges(template: TemplateMesh, parts: tuple[str, ...]) -> Integers:
    return edges_of(template.faces[template.faces_of(*parts)])
