"""From a picture's file to the outline of one standing person in it, or a refusal by name.

A mask is light where the person is and dark elsewhere, or says so with an alpha channel. What a
file claims to be is believed of its first bytes alone, and its size is known before anything of
it is decoded. Knows pictures, not bodies.
"""

import io
import struct
import zlib
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFile, ImageOps, JpegImagePlugin, PngImagePlugin
from scipy import ndimage

from model.geometry import Booleans, Integers

Reason = Literal[
    "no_person",
    "cut_off",
    "several_people",
    "too_small",
    "wrong_type",
    "animated",
    "unreadable",
    "too_large",
]

MOST_BYTES = 4 * 2**20
"""Of a file. A mask of a photo of twelve million pixels takes a tenth of that."""

MOST_PIXELS = 13_000_000
MOST_ACROSS = 8192
"""Of a picture, in all and along its longer side: what telephones take."""

FINEST = 1600
"""A person is kept this many pixels high at most: one millimetre of a body is enough."""

LEAST_HEIGHT = 256
"""Pixels of a person's height, in a picture of at most `FINEST`: one is some 7 mm of the body."""

LIGHT = 0.5
"""What is lighter is person: 0 to 1."""

_GREY = (0.2, 0.8)
_MOST_GREY = 0.12
"""Masks have few pixels of these greys, at edges; photos have many."""

_LEAST_SHARE = 0.003
_MOST_SHARE = 0.85
"""Of the picture, that a person may fill."""

_ANOTHER = 0.2
"""A region of this share of the largest one is no speck: there is somebody, or something, else."""

_SLIMMEST, _BROADEST = 0.1, 1.05
"""Breadth beside height, of a person from the side and of one with the arms stretched out."""

_TOP = 0.12
_HEAD_BREADTH = 0.06
"""Two heads are two runs of pixels, each this broad beside the height, in the top of a figure."""

_CROWN = 0.7
"""A crown's first rows are narrower than this share of the head a little below it; a straight
cut through a head or a neck is not."""

_PINHOLE = 0.0004
"""Holes smaller than this share of the person are the segmenter's, not the outside seen through."""

_BROKEN = (
    OSError,
    ValueError,
    SyntaxError,
    TypeError,
    IndexError,
    KeyError,
    EOFError,
    OverflowError,
    MemoryError,
    struct.error,
    zlib.error,
)
"""What Pillow raises, by its many ways to fail, for files that are broken."""


class PictureRefusedError(ValueError):
    """A file that is no mask of one standing person; `reason` says why, in one word."""

    def __init__(self, reason: Reason, words: str) -> None:
        super().__init__(f"{reason}: {words}")
        self.reason = reason


_SCAN = b"\xff\xda"
_MOST_SCANS = 64
"""A JPEG's picture may come in scans, each of which costs the time of a whole picture, however
short it is. Cameras and programs make ten or so."""


@dataclass(frozen=True, eq=False)
class Mask:
    """One standing person, cut out so that the outline touches all four edges.

    Attributes
    ----------
    cover : ndarray of shape (h, w), float32: how much of each pixel is person, 0 to 1.
    left, top : where the cut-out's corner lay in the picture as it came, in its pixels.
    scale : pixels of the picture as it came to one of `cover`.
    """

    cover: NDArray[np.float32]
    left: float
    top: float
    scale: float


def read_mask(content: bytes) -> Mask:
    """The person in a file.

    Raises
    ------
    PictureRefusedError
        For a file that is no PNG or JPEG, is too large, is broken, or shows no standing
        person, more than one, or not all of one.
    """
    if len(content) > MOST_BYTES:
        raise PictureRefusedError("too_large", f"{len(content)} bytes are over {MOST_BYTES}")
    picture = _open(content)
    if picture.width * picture.height > MOST_PIXELS or max(picture.size) > MOST_ACROSS:
        raise PictureRefusedError(
            "too_large",
            f"{picture.width} × {picture.height} pixels are over {MOST_PIXELS} in all "
            f"or {MOST_ACROSS} along one side",
        )
    if getattr(picture, "is_animated", False):
        raise PictureRefusedError("animated", "a picture that moves")
    try:
        cover, scale = _cover(picture)
    except _BROKEN as error:
        raise PictureRefusedError("unreadable", str(error)) from error
    return person(cover, scale)


def person(cover: NDArray[np.float32], scale: float = 1.0) -> Mask:
    """The one standing person of a mask, ndarray of shape (h, w) from 0 to 1.

    Parameters
    ----------
    scale : pixels of the picture as it came to one of the mask.

    Raises
    ------
    PictureRefusedError
        As in :func:`read_mask`.
    """
    if ((cover > _GREY[0]) & (cover < _GREY[1])).mean() > _MOST_GREY:
        raise PictureRefusedError("no_person", "a picture in greys is no outline")
    labels, count = ndimage.label(cover >= LIGHT)
    areas = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    if not count or areas.max() < _LEAST_SHARE * cover.size:
        raise PictureRefusedError("no_person", "nothing in the picture is light")
    if areas.max() > _MOST_SHARE * cover.size:
        raise PictureRefusedError("no_person", "nearly all of the picture is light")
    largest = int(areas.argmax()) + 1
    if (areas > _ANOTHER * areas.max()).sum() > 1:
        raise PictureRefusedError("several_people", "there is a second figure")
    rows, columns = ndimage.find_objects(labels)[largest - 1]
    inside = labels[rows, columns] == largest
    height, width = inside.shape
    if not _SLIMMEST < width / height < _BROADEST:
        raise PictureRefusedError(
            "no_person", f"a standing person is not {width / height:.2f} times as broad as high"
        )
    if _heads(inside) > 1:
        raise PictureRefusedError("several_people", "there is a second head")
    if height < LEAST_HEIGHT:
        raise PictureRefusedError("too_small", f"{height} pixels are under {LEAST_HEIGHT}")
    at_edge = (
        rows.start == 0
        or columns.start == 0
        or rows.stop == cover.shape[0]
        or columns.stop == cover.shape[1]
    )
    if at_edge or _is_cut(inside):
        raise PictureRefusedError("cut_off", "the figure ends at an edge, or in a straight line")
    # The edge keeps its greys, which place it within a pixel; all else is black or white.
    near = ndimage.binary_dilation(inside, iterations=2)
    cut = np.where(near, cover[rows, columns], 0).astype(np.float32)
    cut[_pinholes(inside)] = 1
    return Mask(cut, scale * columns.start, scale * rows.start, scale)


def runs(inside: Booleans) -> tuple[Integers, Integers, Integers]:
    """Where rows of a mask are filled without a break.

    Parameters
    ----------
    inside : ndarray of bool, shape (h, w).

    Returns
    -------
    rows, starts, ends : ndarrays of shape (n,), from the top left on; ends are the first
        pixel past each run.
    """
    padded = np.zeros((inside.shape[0], inside.shape[1] + 2), dtype=np.int8)
    padded[:, 1:-1] = inside
    steps = np.diff(padded, axis=1)
    rows, starts = np.nonzero(steps == 1)
    _, ends = np.nonzero(steps == -1)
    return rows, starts, ends


def _open(content: bytes) -> ImageFile.ImageFile:
    """The picture, its size known and nothing of it decoded."""
    stream = io.BytesIO(content)
    try:
        # Not by Image.open, which warns of some sizes and raises at others.
        if content.startswith(b"\x89PNG\r\n\x1a\n"):
            return PngImagePlugin.PngImageFile(stream)
        if content.startswith(b"\xff\xd8\xff"):
            if content.count(_SCAN) > _MOST_SCANS:
                raise PictureRefusedError("unreadable", f"over {_MOST_SCANS} scans in one JPEG")
            return JpegImagePlugin.JpegImageFile(stream)
    except _BROKEN as error:
        raise PictureRefusedError("unreadable", str(error)) from error
    raise PictureRefusedError("wrong_type", "neither PNG nor JPEG")


def _cover(picture: ImageFile.ImageFile) -> tuple[NDArray[np.float32], float]:
    """How much of each pixel is person, and how many pixels of the picture went into one."""
    high = max(picture.size)
    if isinstance(picture, JpegImagePlugin.JpegImageFile):
        picture.draft("L", (FINEST, FINEST))
    upright: Image.Image = ImageOps.exif_transpose(picture)
    if upright.mode.startswith("I"):
        upright = Image.fromarray(np.clip(np.asarray(upright) >> 8, 0, 255).astype(np.uint8))
    grey = upright
    if upright.mode in ("RGBA", "LA", "PA") or "transparency" in upright.info:
        alpha = upright.convert("RGBA").getchannel("A")
        if alpha.getextrema() != (255, 255):
            grey = alpha
    grey = grey.convert("L")
    if (factor := -(-max(grey.size) // FINEST)) > 1:
        grey = grey.reduce(factor)
    cover = np.asarray(grey).astype(np.float32) / np.float32(255)
    return cover, high / max(grey.size)


def _heads(inside: Booleans) -> int:
    """The most runs as broad as a head in any of the top rows."""
    height = len(inside)
    rows, starts, ends = runs(inside[: int(_TOP * height)])
    broad = ends - starts > _HEAD_BREADTH * height
    return int(np.bincount(rows[broad], minlength=1).max())


def _is_cut(inside: Booleans) -> bool:
    """Whether the figure's top is a straight line."""
    height = len(inside)
    breadths = inside[: max(int(0.03 * height), 2)].sum(axis=1)
    return bool(breadths[0] > 0.02 * height and breadths[0] > _CROWN * breadths[-1])


def _pinholes(inside: Booleans) -> Booleans:
    holes, count = ndimage.label(~inside)
    areas = np.bincount(holes.ravel(), minlength=count + 1)
    small = areas < _PINHOLE * inside.sum()
    small[0] = False
    edge = np.unique(np.concatenate([holes[0], holes[-1], holes[:, 0], holes[:, -1]]))
    small[edge] = False
    found: Booleans = small[holes]
    return found
