"""Where estimated bodies are wrong, as colours on them: the paper's figures 1 and 2."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from model.appearance import BACKDROP, vertex_normals
from model.cameras import SIDES, Side, project
from model.geometry import Floats
from model.rendering import Painted, photograph
from model.template_mesh import TemplateMesh

CELL = (170, 260)
"""Width and height of one picture, in pixels."""

SHOWN: Mapping[Side, int] = {"front": 170, "profile": 84}
"""How many pixels of a picture's width are shown, about its middle: a profile is narrow."""

HEAD, FOOT, MARGIN = 30, 62, 90
"""Pixels above, below and to the left of the pictures."""

FONT_SIZE = 16

BARE = (0.80, 0.78, 0.75)
"""The true body's colour, which has no error."""

VIRIDIS = (
    (0.267, 0.005, 0.329),
    (0.283, 0.141, 0.458),
    (0.254, 0.265, 0.530),
    (0.207, 0.372, 0.553),
    (0.164, 0.471, 0.558),
    (0.128, 0.567, 0.551),
    (0.135, 0.659, 0.518),
    (0.267, 0.749, 0.441),
    (0.478, 0.821, 0.318),
    (0.741, 0.873, 0.150),
    (0.993, 0.906, 0.144),
)
"""Eleven even steps of the colour map viridis, dark blue to yellow as in the paper's figures
(S. van der Walt and N. Smith, 2015; CC0)."""


@dataclass(frozen=True, eq=False)
class MapRow:
    """One body of a figure.

    Attributes
    ----------
    words : lines that stand before the row.
    true : ndarray of shape (V, 3), metres.
    estimated : by column, ndarrays of shape (V, 3), in the same place.
    """

    words: Sequence[str]
    true: Floats
    estimated: Mapping[str, Floats]


def colours(distances: Floats, longest: float) -> Floats:
    """The colours of distances, (V,) in metres: (V, 3), sRGB; from `longest` on the last."""
    place = np.clip(distances / longest, 0, 1)
    steps = np.linspace(0, 1, len(VIRIDIS))
    return np.stack([np.interp(place, steps, channel) for channel in np.transpose(VIRIDIS)], axis=1)


def draw_map(template: TemplateMesh, rows: Sequence[MapRow], longest: float) -> Image.Image:
    """The figure: a row each body, a column each estimate, the original last; front, profile.

    Parameters
    ----------
    longest : the distance in metres at which the scale ends.

    Raises
    ------
    RenderingUnavailable
        If this machine cannot draw.
    """
    columns = [*rows[0].estimated, "original"]
    wide, high = sum(SHOWN.values()), CELL[1]
    width = MARGIN + len(columns) * wide
    sheet = Image.new("RGB", (width, HEAD + len(rows) * high + FOOT), BACKDROP)
    pen = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(FONT_SIZE)
    # One frame for all, so that bodies are as large beside each other as they are.
    floors = [row.true[:, 1].min() for row in rows]
    frame = np.concatenate(
        [
            body - [0, floor, 0]
            for row, floor in zip(rows, floors, strict=True)
            for body in (row.true, *row.estimated.values())
        ]
    )
    for place, name in enumerate(columns):
        letter = f"({chr(ord('a') + place)}) {name}"
        middle = MARGIN + (place + 0.5) * wide
        pen.text((middle, 6), letter, fill="black", font=font, anchor="ma")
    for line, (row, floor) in enumerate(zip(rows, floors, strict=True)):
        top = HEAD + line * high
        pen.multiline_text((12, top + 0.3 * high), "\n".join(row.words), fill="black", font=font)
        for place, name in enumerate(columns):
            body = row.estimated.get(name, row.true)
            far = np.linalg.norm(body - row.true, axis=1)
            painted = Painted(
                positions=body - [0, floor, 0],
                normals=vertex_normals(body, template.faces),
                coats=[(template.faces, BARE if name == "original" else colours(far, longest))],
            )
            left = MARGIN + place * wide
            for side in SIDES:
                picture = photograph(painted, project(frame, side, size=CELL), CELL).picture
                edge = (CELL[0] - SHOWN[side]) // 2
                sheet.paste(picture.crop((edge, 0, edge + SHOWN[side], high)), (left, top))
                left += SHOWN[side]
    _draw_scale(pen, sheet.size, longest)
    return sheet


def _draw_scale(pen: ImageDraw.ImageDraw, size: tuple[int, int], longest: float) -> None:
    """The scale in centimetres, below the figure."""
    font = ImageFont.load_default(FONT_SIZE)
    left, right, top = MARGIN, size[0] - 2 * MARGIN, size[1] - FOOT + 12
    edges = np.linspace(left, right, 257)
    shades = np.round(255 * colours(np.linspace(0, longest, 256), longest)).astype(int)
    for (start, stop), shade in zip(pairwise(edges), shades.tolist(), strict=True):
        pen.rectangle((start, top, stop, top + 14), fill=tuple(shade))
    ticks = np.linspace(0, longest, 6)
    for tick in ticks:
        words = f"{tick * 100:g} cm" + (" and more" if tick == longest else "")
        place = left + (right - left) * tick / longest
        pen.text((place, top + 20), words, fill="black", font=font, anchor="ma")
