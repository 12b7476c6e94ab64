"""A photo's outline and a body's on one sheet: how they are laid over one another.

The sheet is the upright plane through the body's axis, seen from the photo's camera, in pixels of
equal size. The photo is scaled by the stature, between crown and soles, put on the ground, and
moved sideways until both have most in common. Arms rarely hang as the avatar's do; where they
hang, or may, is found here.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

from model.cameras import Camera, Facing, Side, seen
from model.geometry import Booleans, Floats, Integers
from model.masks import LIGHT, Mask, runs
from model.silhouette import ARMS, ROWS, UPRIGHT, cover, fill, towards_camera
from model.template_mesh import Body

MARGIN = 24
"""Pixels of the sheet around what lies on it."""

FREE = 0.3
"""A run of the photo's pixels that overlaps the avatar by less than this share is an arm."""

ARMS_END = 0.30
"""Of the stature: lower down there are no hands, of whoever stands upright."""

_SWINGS = np.linspace(-0.25, 0.25, 21)
"""Radians by which arms may be turned about the shoulder from the avatar's, in the picture."""

_LEAST_ARM = 0.055
"""Of an arm, what must stand out from the trunk for it to be told."""

_LEAST_HAND = 0.06
"""Of a hand, likewise: a belly does not reach as low as hands do. Chosen where it
parts four bodies of docs/comparison.md from the others, and tried on 40 held-out bodies beside."""

_STRETCHES = np.linspace(0.85, 1.25, 9)
"""From the side an arm is the longer the less it is lifted sideways: beside the avatar's, which
are lifted by some 35°."""

_COARSE = 4
"""Pixels to one of the picture in which arms are looked for: some 8 mm."""

HANDS_END = 0.36
"""Of the stature: down to here a hand may lie on a thigh, unseen."""

SMOOTH = 2
"""A breadth is the mean over this many rows above and below, too."""


class Sheet:
    """A photo and a body laid over one another.

    Parameters
    ----------
    mask : the photo's outline.
    rows : pixels from the body's crown to its soles.

    Attributes
    ----------
    body, side, camera, facing : what is seen, and how.
    flat : ndarray of shape (V, 2), the body as `cameras.seen` gives it, metres.
    step : metres to a pixel of the sheet.
    size : width and height of the sheet in pixels.
    origin : column and row of the body's axis on the floor.
    points : ndarray of shape (V, 2), the body's vertices: columns and rows.
    upright, whole : ndarrays of bool, (h, w): the body without its arms, and with them.
    upright_cover : ndarray of shape (h, w): how much of a pixel is the body without its arms.
    cover, photo : ndarrays of shape (h, w): how much of a pixel is person, and whether it is.
    place : see `model.comparison.Comparison`.
    overlap : what both have in common, as a share of what either has, arms included.
    """

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
        self.rows = rows
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
        shown = [towards_camera(self.points, template.faces[part]) for part in (upright, ~upright)]
        self.upright_cover = cover(self.points, shown[0], self.size)
        self.upright: Booleans = self.upright_cover >= LIGHT
        self.whole = self.upright | fill(self.points, shown[1], self.size)
        left = half - mask.cover.shape[1] / ratio / 2
        left += self._shift(_laid(mask, left, ratio, self.size))
        self.cover = _laid(mask, left, ratio, self.size)
        self.photo: Booleans = self.cover >= LIGHT
        scale = ratio * mask.scale
        self.place = (mask.left - scale * left, mask.top - scale * MARGIN, scale)
        common, either = self.photo & self.whole, self.photo | self.whole
        self.overlap = float(common.sum() / either.sum())

    def _shift(self, photo: NDArray[np.float32]) -> float:
        """How far to the right the photo goes, in pixels, to have most in common."""
        width = self.size[0]
        # Every third row tells enough.
        spectra = [
            np.fft.rfft(mask[::3], 2 * width, axis=1) for mask in (self.upright_cover, photo)
        ]
        common = np.fft.irfft((spectra[0] * spectra[1].conj()).sum(axis=0), 2 * width)
        peak = int(common.argmax())
        before, at, after = common[[peak - 1, peak, (peak + 1) % (2 * width)]]
        bend = before - 2 * at + after
        fine = 0.5 * (before - after) / bend if bend < 0 else 0.0
        return float((peak + fine + width) % (2 * width) - width)

    def row(self, height: float) -> int:
        """The row at a height on the sheet, as a share of the stature."""
        return int(MARGIN + (1 - height) * self.rows)

    def arms(self) -> tuple[Booleans, Booleans]:
        """What is not judged: (h, w); and on which side of which row an arm hides it: (2, h)."""
        height, width = self.photo.shape
        arms = np.zeros_like(self.photo)
        hidden = np.zeros((2, height), dtype=bool)
        common = np.zeros((height, width + 1), dtype=np.int64)
        np.cumsum(self.upright, axis=1, out=common[:, 1:])
        rows, starts, ends = runs(self.photo)
        kept = common[rows, ends] - common[rows, starts] >= FREE * (ends - starts)
        kept |= rows >= self.row(ARMS_END)
        first, last = np.full(height, width), np.zeros(height, dtype=np.int64)
        np.minimum.at(first, rows[kept], starts[kept])
        np.maximum.at(last, rows[kept], ends[kept])
        sides = (ends <= first[rows]) & ~kept, (starts >= last[rows]) & ~kept
        for row, start, end in zip(rows[~kept], starts[~kept], ends[~kept], strict=True):
            arms[row, start:end] = True
        shoulder = self.landmark_row("acromion_left")
        outside = ~self.upright
        if self.side == "profile":
            # An arm that hangs is before the trunk or behind it: what it hides there is not known.
            arms |= self._unknown(self._hanging() & outside, first, last)
            return arms, hidden
        # A shoulder, where the arm begins, is as high as the arm is lifted.
        low = self.landmark_row("axilla_left")
        arms[:low] |= self._shoulders()[:low] & outside[:low]
        columns = np.arange(width)
        for side in (0, 1):
            apart = np.zeros(height, dtype=bool)
            apart[rows[sides[side]]] = True
            apart[:shoulder] = False
            rest = np.zeros(height, dtype=bool)
            rest[shoulder : self.row(HANDS_END)] = True
            if apart.any():
                low = int(np.flatnonzero(apart).max())
                # A hand that ends freely hides nothing below it.
                if self._ends_freely(low, side, first, last):
                    rest[low + 1 :] = False
            hidden[side] = rest & ~apart
            edge = edges_of_figure(self.upright)[side]
            beyond = columns[None] < edge[:, None] if side == 0 else columns[None] >= edge[:, None]
            arms |= hidden[side][:, None] & beyond & outside
        return arms, hidden

    def _unknown(self, arms: Booleans, first: Integers, last: Integers) -> Booleans:
        """Of where arms may be, that which the photo's figure does not reach beyond.

        Where it does, it is no arm that is seen there, but a belly, or cloth.

        Parameters
        ----------
        arms : ndarray of bool, (h, w), outside the avatar.
        first, last : ndarrays of shape (h,), where the photo's figure begins and ends.
        """
        columns = np.arange(arms.shape[1])
        starts, ends = edges_of_figure(self.upright)
        ahead, behind = arms & (columns < starts[:, None]), arms & (columns >= ends[:, None])
        reaches = (
            first < edges_of_figure(ahead)[0] - SMOOTH,
            last > edges_of_figure(behind)[1] + SMOOTH,
        )
        unknown: Booleans = ahead & ~reaches[0][:, None] | behind & ~reaches[1][:, None]
        return unknown | arms & ~ahead & ~behind

    def _hanging(self) -> Booleans:
        """Where the photo's arms hang, seen from the side, as far as they can be told.

        Of all ways in which an arm may be turned and foreshortened, the one by which it covers
        most of what the photo has outside the avatar, and least of where it has nothing. An arm
        of which hardly anything stands out, and not its hand, hangs before the trunk: what does is
        the trunk's own.
        """
        table = np.where(self.photo, 1, -1)
        table[self.upright] = 0
        found = np.zeros((-(-self.size[1] // _COARSE), -(-self.size[0] // _COARSE)), dtype=bool)
        for side in ("left", "right"):
            ways = self._turned(side, ARMS, _STRETCHES)
            kept = ways.clip(0, np.array(self.size) - 1)
            scores = table[kept[..., 1], kept[..., 0]].sum(axis=1)
            way = int(scores.argmax())
            hand = self._turned(side, ARMS[-1:], _STRETCHES)[way].clip(0, np.array(self.size) - 1)
            of_hand = table[hand[:, 1], hand[:, 0]].mean()
            if scores[way] < _LEAST_ARM * kept.shape[1] and of_hand < _LEAST_HAND:
                continue
            best = kept[way] // _COARSE
            found[best[:, 1], best[:, 0]] = True
        return self._fine(found)

    def _shoulders(self) -> Booleans:
        """Where upper arms may be from the front, turned from where the avatar has them."""
        found = np.zeros((-(-self.size[1] // _COARSE), -(-self.size[0] // _COARSE)), dtype=bool)
        for side in ("left", "right"):
            ways = self._turned(side, ARMS[:1], np.ones(1)).clip(0, np.array(self.size) - 1)
            found[ways[..., 1] // _COARSE, ways[..., 0] // _COARSE] = True
        return self._fine(found)

    def _turned(self, side: str, names: tuple[str, ...], stretches: Floats) -> Integers:
        """Pixels of an arm's parts, turned and stretched: (ways, n, 2), column and row."""
        template = self.body.template
        faces = template.faces[template.faces_of(*(f"{name}_{side}" for name in names))]
        faces = towards_camera(self.points, faces)
        size = (-(-self.size[0] // _COARSE), -(-self.size[1] // _COARSE))
        rows, columns = np.nonzero(fill(self.points / _COARSE, faces, size))
        joint = self.place_of(f"acromion_{side}")
        apart = (np.column_stack([columns, rows]) + 0.5) * _COARSE - joint
        turns = np.array([[[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]] for a in _SWINGS])
        stretched = apart[None] * np.column_stack([np.ones(len(stretches)), stretches])[:, None]
        ways = joint + np.einsum("sni,aij->sanj", stretched, turns).reshape(-1, len(apart), 2)
        return ways.astype(np.int64)

    def _fine(self, coarse: Booleans) -> Booleans:
        """A coarse picture on the sheet, with a little around: hands are not all held alike."""
        wide = ndimage.binary_dilation(coarse, np.ones((3, 3), dtype=bool), iterations=2)
        fine: Booleans = wide.repeat(_COARSE, axis=0).repeat(_COARSE, axis=1)
        return fine[: self.size[1], : self.size[0]]

    def _ends_freely(self, row: int, side: int, first: Integers, last: Integers) -> bool:
        """Whether below this row, the last where an arm stands off, the leg grows no broader."""
        near, below = row - 3, row + 6
        ends = first if side == 0 else last
        grown = (ends[near] - ends[below]) * (1 if side == 0 else -1)
        return bool(grown < 0.012 * self.rows)

    def hands(self, arms: Booleans, hidden: Booleans) -> dict[str, Floats]:
        """How far the photo's arms reach from the front, of those whose hand ends freely.

        Parameters
        ----------
        arms, hidden : as `arms` gives them.

        Returns
        -------
        By left and right, ndarray of shape (2,): the point furthest from the body's shoulder, to
        the picture's right of the axis and above the floor, in metres.
        """
        found = {}
        columns = np.arange(self.size[0]) + 0.5
        for name in ("left", "right"):
            joint = self.place_of(f"acromion_{name}")
            outwards = np.sign(joint[0] - self.origin[0])
            beyond = outwards * (columns - joint[0]) > 0
            points = np.argwhere(arms & self.photo & beyond)[:, ::-1] + 0.5
            if not len(points):
                continue
            end = points[np.linalg.norm(points - joint, axis=1).argmax()]
            if not hidden[int(outwards > 0), int(end[1]) : self.row(HANDS_END)].any():
                found[name] = (end - self.origin) * self.step * [1, -1]
        return found

    def place_of(self, name: str) -> Floats:
        """Where on the sheet a landmark is: column and row, ndarray of shape (2,)."""
        point = self.body.template.landmark_points(self.body.vertices, name)
        flat = seen(point[None], self.side, self.camera, self.facing)[0]
        return self.origin + flat / self.step * [1, -1]

    def landmark_row(self, name: str) -> int:
        """The row of the sheet in which a landmark is."""
        return int(self.place_of(name)[1])

    def heights(self, rows: Iterable[int]) -> Floats:
        """How far above the floor the middles of n rows lie: (n,), metres."""
        return (self.origin[1] - (np.array(rows) + 0.5)) * self.step

    def breadth(self, near: range, arms: Booleans, avatar: Floats, *, legs: bool) -> float | None:
        """The photo's mean breadth in rows, in metres; None where legs do not stand apart.

        Parameters
        ----------
        near : the rows.
        arms : ndarray of bool, the sheet's shape: what is left out.
        avatar : ndarray of shape (2,), from where to where the avatar is, metres.
        legs : whether two spans are looked for, or what lies between the outermost.
        """
        found = []
        for row in near:
            spans = self.spans(row, arms)
            if legs and len(spans) == 2:
                found.append(float(np.mean([end - start for start, end in spans])))
            elif not legs and (ends := over(spans, avatar)):
                found.append(ends[1] - ends[0])
        return float(np.mean(found)) if len(found) > SMOOTH else None

    def spans(self, row: int, arms: Booleans) -> list[tuple[float, float]]:
        """From where to where the photo has a person in a row, in metres.

        Parameters
        ----------
        arms : ndarray of bool, the sheet's shape: what is left out.
        """
        columns = _spans(np.where(arms[row], 0, self.cover[row]))
        left = self.origin[0]
        return [((start - left) * self.step, (end - left) * self.step) for start, end in columns]


def over(spans: list[tuple[float, float]], avatar: Floats) -> tuple[float, float] | None:
    """From the first to the last of the spans that have something of the avatar's span, (2,)."""
    met = [span for span in spans if span[0] < avatar[1] and span[1] > avatar[0]]
    return (met[0][0], met[-1][1]) if met else None


def _spans(cover: NDArray[np.float32]) -> list[tuple[float, float]]:
    """Where a row is person, within a pixel's parts: an edge lies where its cover passes a half."""
    padded = np.zeros(len(cover) + 2, dtype=cover.dtype)
    padded[1:-1] = cover
    ways = np.flatnonzero(np.diff(padded >= LIGHT))
    starts, ends = ways[::2], ways[1::2]
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


def edges_of_figure(inside: Booleans) -> tuple[Integers, Integers]:
    """The first filled column of each row of a picture, (H, W), and the one past the last: (H,).

    Of empty rows they are the picture's right and its left end.
    """
    width = inside.shape[1]
    some = inside.any(axis=1)
    first = np.where(some, inside.argmax(axis=1), width)
    last = np.where(some, width - inside[:, ::-1].argmax(axis=1), 0)
    return first, last
