"""A photo's outline and an avatar's as pictures: over one another, and where they differ.

All have the size of the comparison's sheet, so that they lie on one another.
"""

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

from model.appearance import BACKDROP
from model.cameras import Projection, axes
from model.comparison import Comparison
from model.geometry import Booleans

# PHOTO and AVATAR are as the legend's (static/css/results.css): people who see no difference
# between red and green tell them apart, dark on light and light on dark.
BODY = (206, 198, 188)
UNJUDGED = (228, 223, 217)
PHOTO = (15, 95, 102)
AVATAR = (217, 119, 6)

_LINE = 2
"""Half the breadth of an outline, in pixels."""


def overlay(comparison: Comparison) -> bytes:
    """The avatar, filled, and the photo's outline as a line over it: a PNG file."""
    colours = np.full(comparison.photo.shape, 0, dtype=np.uint8)
    colours[comparison.avatar] = 1
    colours[comparison.avatar & comparison.arms] = 2
    colours[_outline(comparison.photo)] = 3
    return _png(colours, (BACKDROP, BODY, UNJUDGED, PHOTO))


def difference(comparison: Comparison) -> bytes:
    """Where only the photo, and where only the avatar, has something: a PNG file."""
    colours = np.full(comparison.photo.shape, 0, dtype=np.uint8)
    colours[comparison.photo & comparison.avatar] = 1
    colours[comparison.photo & ~comparison.avatar] = 3
    colours[comparison.avatar & ~comparison.photo] = 4
    colours[comparison.arms & (comparison.photo | comparison.avatar)] = 2
    return _png(colours, (BACKDROP, BODY, UNJUDGED, PHOTO, AVATAR))


def filled(figure: Booleans) -> bytes:
    """A figure, ndarray of bool of shape (H, W), in one colour on nothing: a PNG file."""
    return _png(figure.astype(np.uint8), (BACKDROP, PHOTO), clear=True)


def projection(comparison: Comparison) -> Projection:
    """How the sheet sees points, for drawing the avatar on it."""
    camera, step = comparison.camera, comparison.step
    column, row = comparison.origin
    return Projection(
        camera,
        *axes(comparison.side, comparison.facing),
        focal=camera.distance / step,
        column=column,
        row=row - camera.height / step,
    )


def _outline(figure: Booleans) -> Booleans:
    edge: Booleans = ndimage.binary_dilation(figure, iterations=_LINE)
    edge &= ~ndimage.binary_erosion(figure, iterations=_LINE)
    return edge


def _png(
    colours: NDArray[np.uint8], palette: tuple[tuple[int, int, int], ...], *, clear: bool = False
) -> bytes:
    picture = Image.fromarray(colours).convert("P")
    picture.putpalette([part for colour in palette for part in colour])
    stream = io.BytesIO()
    picture.save(stream, "PNG", bits=4, **({"transparency": 0} if clear else {}))
    return stream.getvalue()
