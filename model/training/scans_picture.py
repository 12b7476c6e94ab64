"""A set's mean shape with its parts and landmarks, to be checked by eye."""

import io

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from model.appearance import BACKDROP
from model.cameras import Camera, Projection
from model.geometry import Floats
from model.rendering import FINENESS, photograph
from model.tape_pictures import View
from model.template_mesh import TemplateMesh
from model.training.segment_picture import INK, in_segments, push_apart

VIEWS = (View(0, "the front"), View(180, "the back"), View(90, "the left"), View(-90, "the right"))

PANEL = (640, 1120)
"""Of one figure, in pixels."""

NAMES = 190
"""Width of the columns of names on both sides of each figure, in pixels."""

PITCH = 17
TEXT = 13
DOT = (178, 24, 43)

HIDDEN_BEHIND = 0.015
"""How much nearer to the camera than a landmark skin must be to hide it, in metres."""


def landmark_picture(template: TemplateMesh) -> bytes:
    """Parts in colours and landmarks by name, from four sides, as the bytes of a PNG file.

    Raises
    ------
    RenderingUnavailable
        If this machine lacks OSMesa; the message says what is missing.
    """
    width = PANEL[0] + 2 * NAMES
    sheet = Image.new("RGB", (width * 2, PANEL[1] * 2), BACKDROP)
    for place, view in enumerate(VIEWS):
        sheet.paste(_panel(template, view), (place % 2 * width, place // 2 * PANEL[1]))
    stream = io.BytesIO()
    sheet.save(stream, "PNG")
    return stream.getvalue()


def _panel(template: TemplateMesh, view: View) -> Image.Image:
    vertices = template.vertices
    tall = float(vertices[:, 1].max())
    camera = Camera(distance=10.0, height=tall / 2)
    span = float(np.ptp(vertices[:, 0]))
    focal = min(PANEL[1] / tall, PANEL[0] / span) / 1.1 * camera.distance
    projection = Projection(camera, view.right, view.towards, focal, PANEL[0] / 2, PANEL[1] / 2)
    photo = photograph(in_segments(template, vertices), projection, PANEL)
    panel = Image.new("RGB", (PANEL[0] + 2 * NAMES, PANEL[1]), BACKDROP)
    panel.paste(photo.picture, (NAMES, 0))
    names = list(template.landmarks)
    points = np.array([template.landmark_points(vertices, name) for name in names])
    pixels = projection.pixels(points)
    away = camera.distance - points @ view.towards
    columns, rows = np.round(pixels.T * FINENESS).astype(int)
    seen = away < photo.depths[rows, columns] + HIDDEN_BEHIND
    pen = ImageDraw.Draw(panel)
    font = ImageFont.load_default(TEXT)
    pen.text((panel.width / 2, 8), f"from {view.words}", font=font, fill=INK, anchor="mt")
    middle = PANEL[0] / 2
    for on_right in (False, True):
        own = np.flatnonzero(seen & ((pixels[:, 0] > middle) == on_right))
        own = own[np.argsort(pixels[own, 1])]
        edge = NAMES + PANEL[0] - 30 if on_right else NAMES + 30
        for i, level in zip(own.tolist(), _spread(pixels[own, 1]), strict=True):
            x, y = NAMES + pixels[i, 0], pixels[i, 1]
            pen.line([(edge, level), (x, y)], fill=INK, width=1)
            pen.ellipse([x - 3, y - 3, x + 3, y + 3], fill=DOT)
            anchor = "lm" if on_right else "rm"
            side = 4 if on_right else -4
            pen.text((edge + side, level), names[i], font=font, fill=INK, anchor=anchor)
    return panel


def _spread(rows: Floats) -> list[float]:
    """Rows in order, (n,), moved apart by `PITCH` at least and kept within the panel."""
    levels = rows.tolist()
    for _ in range(300):
        push_apart(levels, PITCH)
        levels = [min(max(level, 30.0), PANEL[1] - 12.0) for level in levels]
    return levels
