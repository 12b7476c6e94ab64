"""A photo's outline beside a body's: laid over one another, and compared.

Both lie on one sheet: the upright plane through the body's axis, seen from the photo's camera,
in pixels of equal size. The photo is scaled by the stature, between crown and soles, put on the
ground, and moved sideways until both have most in common. Arms rarely hang as the avatar's do, so
they are left out of what is judged: of the avatar by its body parts, of the photo where they
stand off the trunk. Where they touch it, nothing beside the trunk is judged.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

from model.anthropometry import TAPES
from model.cameras import USUAL_CAMERA, Camera, Facing, Side, seen
from model.geometry import Booleans, Floats, Integers
from model.girths import Girth, tie
from model.masks import LIGHT, Mask, PictureRefusedError, runs
from model.silhouette import LEG, ROWS, UPRIGHT, contour, fill
from model.template_mesh import Body

MARGIN = 24
"""Pixels of the sheet around what lies on it."""

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
        overlaps = [_Sheet(mask, body, side, camera, way, _COARSE).overlap for way in ways]
        facing = ways[int(np.argmax(overlaps))]
    best = _Sheet(mask, body, side, camera, facing or "right")
    if best.overlap < LEAST_OVERLAP:
        raise PictureRefusedError(
            "no_person", f"{best.overlap:.2f} of the outline is a person's, under {LEAST_OVERLAP}"
        )
    return best.compared()


@dataclass(frozen=True, eq=False)
class Edges:
    """What a photo's outline says of a body, row by row; metres on the sheet.

    Attributes
    ----------
    side, camera, facing : how it is seen.
    heights, ends, positions : ndarrays of shape (n,): where above the floor, whether at the left
        (0) or the right (1), and how far to the right of the body's axis the figure ends.
    leg_heights, leg_breadths : ndarrays of shape (m,): how broad a leg is from the front.
    """

    side: Side
    camera: Camera
    facing: Facing
    heights: Floats
    ends: Integers
    positions: Floats
    leg_heights: Floats
    leg_breadths: Floats


def photo_edges(mask: Mask, body: Body, side: Side, camera: Camera, facing: Facing) -> Edges:
    """The edges of a photo's trunk and legs, laid over a body that is near to it.

    Head, hair, neck and feet are left out, and so is what an arm hides.
    """
    return _Sheet(mask, body, side, camera, facing).edges()


class _Sheet:
    """A photo and a body laid over one another."""

    def __init__(
        self,
        mask: Mask,
        body: Body,
        side: Side,
        camera: Camera,
        facing: Facing,
        rows: int = ROWS,
    ) -> None:
        self.body, self.side, self.camera, self.facing = body, side, camera, facing
        template = body.template
        self.flat = seen(body.vertices, side, camera, facing)
        low, high = self.flat[:, 1].min(), self.flat[:, 1].max()
        self.step = float((high - low) / rows)
        reach = float(np.abs(self.flat[:, 0]).max()) / self.step
        ratio = len(mask.cover) / rows
        half = int(max(reach, 0.8 * mask.cover.shape[1] / ratio)) + MARGIN
        self.size = (2 * half, rows + 2 * MARGIN)
        self.origin = (float(half), MARGIN + high / self.step)
        self.points = self.origin + self.flat / self.step * [1, -1]
        upright = template.faces_of(*UPRIGHT)
        self.upright = fill(self.points, template.faces[upright], self.size)
        self.whole = self.upright | fill(self.points, template.faces[~upright], self.size)
        left = half - mask.cover.shape[1] / ratio / 2
        left += self._shift(_laid(mask, left, ratio, self.size) >= LIGHT)
        self.cover = _laid(mask, left, ratio, self.size)
        self.photo: Booleans = self.cover >= LIGHT
        scale = ratio * mask.scale
        self.place = (mask.left - scale * left, mask.top - scale * MARGIN, scale)
        common, either = self.photo & self.whole, self.photo | self.whole
        self.overlap = float(common.sum() / either.sum())

    def _shift(self, photo: Booleans) -> float:
        """How far to the right the photo goes, in pixels, to have most in common."""
        width = self.size[0]
        # Every third row tells enough.
        spectra = [np.fft.rfft(mask[::3], 2 * width, axis=1) for mask in (self.upright, photo)]
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
            near = range(int(height) - _SMOOTH, int(height) + _SMOOTH + 1)
            parts = LEG if leg else UPRIGHT
            avatar = contour(template, self.flat, parts, self._heights(near)).positions.mean(axis=0)
            photo = None
            if leg or not hidden[:, int(height)].any():
                photo = self._breadth(near, arms, avatar, legs=leg)
            if photo is None:
                unseen.append(name)
                continue
            levels.append(
                Level(
                    measurement=name,
                    photo=photo,
                    avatar=float(np.ptp(avatar)),
                    height=float((self.origin[1] - height) * self.step),
                )
            )
        return sorted(levels, key=lambda level: -level.height), unseen

    def _heights(self, rows: Iterable[int]) -> Floats:
        """How far above the floor the middles of rows lie, in metres."""
        return (self.origin[1] - (np.array(rows) + 0.5)) * self.step

    def _breadth(self, near: range, arms: Booleans, avatar: Floats, *, legs: bool) -> float | None:
        """The photo's mean breadth in rows, in metres; None where legs do not stand apart."""
        found = []
        for row in near:
            spans = self._spans(row, arms)
            if legs and len(spans) == 2:
                found.append(float(np.mean([end - start for start, end in spans])))
            elif not legs and (ends := _over(spans, avatar)):
                found.append(ends[1] - ends[0])
        return float(np.mean(found)) if len(found) > _SMOOTH else None

    def _spans(self, row: int, arms: Booleans) -> list[tuple[float, float]]:
        """From where to where the photo has a person in a row, arms aside, in metres."""
        columns = _spans(np.where(arms[row], 0, self.cover[row]))
        left = self.origin[0]
        return [((start - left) * self.step, (end - left) * self.step) for start, end in columns]

    def edges(self) -> Edges:
        """The photo's edges, see `photo_edges`."""
        arms, hidden = self._arms()
        crotch = self._landmark_row("crotch")
        if self.side == "front":
            trunk = range(self._landmark_row("axilla_left"), crotch, _SPACING)
            legs = range(crotch + _SPACING, self._row(_LEGS_END), _SPACING)
        else:
            trunk = range(self._landmark_row("suprasternale"), self._row(_LEGS_END), _SPACING)
            legs = range(0)
        upright, whole = (_edges_of(figure) for figure in (self.upright, self.whole))
        found: list[tuple[int, int, float]] = []
        for row in trunk:
            avatar = [(ends[row] - self.origin[0]) * self.step for ends in upright]
            for end in (0, 1):
                near = slice(row - _SMOOTH, row + _SMOOTH + 1)
                # From the side an arm hides what is behind it.
                sleeve = self.side == "profile" and (upright[end] != whole[end])[near].any()
                if hidden[end, near].any() or sleeve:
                    continue
                ways = [
                    ends[end]
                    for place in range(near.start, near.stop)
                    if (ends := _over(self._spans(place, arms), np.array(avatar)))
                ]
                if len(ways) > _SMOOTH:
                    found.append((row, end, float(np.mean(ways))))
        pairs = []
        for row in legs:
            near_rows = range(row - _SMOOTH, row + _SMOOTH + 1)
            breadth = self._breadth(near_rows, arms, np.zeros(2), legs=True)
            if breadth is not None:
                pairs.append((row, breadth))
        return Edges(
            side=self.side,
            camera=self.camera,
            facing=self.facing,
            heights=self._heights([row for row, _, _ in found]),
            ends=np.array([end for _, end, _ in found], dtype=np.int64),
            positions=np.array([position for _, _, position in found]),
            leg_heights=self._heights([row for row, _ in pairs]),
            leg_breadths=np.array([breadth for _, breadth in pairs]),
        )


def _over(spans: list[tuple[float, float]], avatar: Floats) -> tuple[float, float] | None:
    """From the first to the last of the spans that have something of the avatar's in them."""
    met = [span for span in spans if span[0] < avatar[1] and span[1] > avatar[0]]
    return (met[0][0], met[-1][1]) if met else None


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
