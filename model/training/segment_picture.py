"""The template's named parts as a picture: front and back, each part labelled between them."""

import io
from collections.abc import Mapping

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from model.appearance import BACKDROP, vertex_normals
from model.cameras import Camera, Projection
from model.geometry import Floats
from model.rendering import Painted, photograph
from model.tape_pictures import BACK, FRONT, View
from model.template_mesh import Body, TemplateMesh

SEGMENTS: Mapping[str, tuple[str, tuple[float, float, float]]] = {
    "head_neck": ("head and neck", (0.87, 0.66, 0.38)),
    "torso": ("torso", (0.42, 0.53, 0.65)),
    "upper_arm": ("upper arms", (0.74, 0.44, 0.39)),
    "lower_arm": ("lower arms", (0.60, 0.72, 0.58)),
    "hand": ("hands", (0.55, 0.41, 0.55)),
    "upper_leg": ("upper legs", (0.86, 0.78, 0.55)),
    "lower_leg": ("lower legs", (0.35, 0.57, 0.58)),
    "foot": ("feet", (0.80, 0.55, 0.38)),
}
"""The segments, each one part of the template or the same part of both sides: name, sRGB."""

PANEL = (430, 760)
"""Of one figure, in pixels."""

MIDDLE = 190
"""Width of the column of names between the two figures, in pixels."""

INK = (62, 68, 72)
TEXT = 17
LINE_PITCH = 46


def segment_picture(body: Body) -> bytes:
    """The segments of a body in their colours, as the bytes of a WebP file.

    Raises
    ------
    RenderingUnavailable
        If this machine lacks OSMesa; the message says what is missing.
    """
    size = (2 * PANEL[0] + MIDDLE, PANEL[1])
    sheet = Image.new("RGB", size, BACKDROP)
    painted = in_segments(body.template, body.vertices)
    pens = ImageDraw.Draw(sheet)
    places: dict[str, list[tuple[float, float]]] = {name: [] for name in SEGMENTS}
    for view, left in ((FRONT, 0), (BACK, PANEL[0] + MIDDLE)):
        projection = _projection(body, view)
        sheet.paste(photograph(painted, projection, PANEL).picture, (left, 0))
        for name in SEGMENTS:
            column, row = projection.pixels(_middle(body, name)[None])[0]
            places[name].append((left + float(column), float(row)))
    font = ImageFont.load_default(TEXT)
    for row, name in zip(_rows(places), sorted(places, key=lambda n: places[n][0][1]), strict=True):
        words, _ = SEGMENTS[name]
        centre = size[0] / 2
        half = pens.textlength(words, font=font) / 2 + 8
        for (x, y), start in zip(places[name], (centre - half, centre + half), strict=True):
            pens.line([(start, row), (x, y)], fill=INK, width=1)
            pens.ellipse([x - 3, y - 3, x + 3, y + 3], fill=INK)
        pens.text((centre, row), words, font=font, fill=INK, anchor="mm")
    stream = io.BytesIO()
    sheet.save(stream, "WEBP", quality=80, method=6)
    return stream.getvalue()


def segment_words() -> str:
    """What the picture shows, for those who do not see it."""
    names = [words for words, _ in SEGMENTS.values()]
    return (
        "A body from the front and from the back, its segments in different colours: "
        f"{', '.join(names[:-1])} and {names[-1]}."
    )


def in_segments(template: TemplateMesh, vertices: Floats) -> Painted:
    """A body's vertices, (V, 3) in metres, with each segment in its colour."""
    coats = [
        (template.faces[template.faces_of(name)], colour) for name, (_, colour) in SEGMENTS.items()
    ]
    return Painted(vertices, vertex_normals(vertices, template.faces), coats)


def push_apart(rows: list[float], pitch: float) -> None:
    """Moves rows that are in order, in place, from neighbours nearer than a pitch: one pass."""
    for i in range(len(rows) - 1):
        short = pitch - (rows[i + 1] - rows[i])
        if short > 0:
            rows[i], rows[i + 1] = rows[i] - short / 2, rows[i + 1] + short / 2


def _projection(body: Body, view: View) -> Projection:
    tall = float(body.vertices[:, 1].max()) * 1.08
    camera = Camera(distance=6.0, height=tall / 2 - 0.03 * tall)
    focal = PANEL[1] / tall * camera.distance
    return Projection(camera, view.right, view.towards, focal, PANEL[0] / 2, PANEL[1] / 2)


def _middle(body: Body, name: str) -> Floats:
    """The middle of a part, of two that of the left one: ndarray of shape (3,)."""
    template = body.template
    left = f"{name}_left"
    part = left if left in template.part_names else name
    middle: Floats = body.vertices[np.unique(template.faces[template.faces_of(part)])].mean(axis=0)
    return middle


def _rows(places: Mapping[str, list[tuple[float, float]]]) -> list[float]:
    """The rows of the names, near the rows of their parts and apart from one another."""
    rows = sorted(ends[0][1] for ends in places.values())
    for _ in range(200):
        push_apart(rows, LINE_PITCH)
    return rows
