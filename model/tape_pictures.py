"""Where each tape runs, drawn on a body: for the documents and for the guide of the form.

A girth or a length is a band on the skin, solid where the camera sees it and faint where the body
hides it; a height is a dimension line beside the body, with a tick at each end. Bands are told
from hidden ones by the depths of the picture.
"""

import io
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageChops, ImageDraw

from model.anthropometry import TAPES
from model.appearance import dress
from model.cameras import Camera, Projection
from model.geometry import Booleans, Floats
from model.measurements import MEASUREMENTS, BodyKind
from model.plausibility import TROUSERS_SHORT_OF_FLOOR
from model.rendering import FINENESS, Photograph, in_underwear, photograph
from model.tapes import Height
from model.template_mesh import Body

ACCENT = (176, 58, 38)
"""The one colour of all tapes: it stands out from skin and garment alike."""

EDGE = (255, 253, 250)
LINE = (92, 98, 102)
"""The floor, and what leads from the body to a dimension line."""

PANEL = (400, 500)
"""Width and height of one view, in pixels."""

BAND = 0.011
BAND_PIXELS = (5.0, 10.0)
"""A tape's width, in metres, and the fewest and most pixels that it is drawn with."""

DISTANCE = 5.0
"""Of the camera, in metres: so far away that near and far look almost alike."""

ROOM = 0.22
"""Free room around what is shown, as a share of it."""

EMPTY_ROOM = 0.07
"""The most free room below the soles and above the crown, as a share of the view's height."""

LEAST_WINDOW = 0.52
"""The least height of what a view shows, in metres: enough of the body to know the place."""

STEP = 0.003
"""Between points of a path that are tested for being seen, in metres."""

HIDDEN_BEHIND = 0.004
"""How much nearer to the camera than the tape something must be to hide it, in metres."""

SHORTEST_RUN = 0.012
"""A stretch of tape shorter than this, in metres, is not shown as hidden between seen ones, or the
other way round."""

FINE = 4
"""Points of the overlay per pixel's side."""

ON_FLOOR = 0.005
"""A height that ends as near to the floor as this is from the floor, in metres."""

GAP = 8
"""Between two views, in pixels."""


@dataclass(frozen=True)
class View:
    """Where the camera stands.

    azimuth : degrees from straight in front of the person towards their left
    words : as in "seen from ..."
    lift : how far above a band's middle the camera stands, in metres: loops are seen as loops
    """

    azimuth: float
    words: str
    lift: float = 0.55

    @property
    def right(self) -> Floats:
        """The picture's right, in the body's coordinates: of shape (3,)."""
        turn = np.radians(self.azimuth)
        return np.array([np.cos(turn), 0.0, -np.sin(turn)])

    @property
    def towards(self) -> Floats:
        """The way from the body to the camera, level: of shape (3,)."""
        turn = np.radians(self.azimuth)
        return np.array([np.sin(turn), 0.0, np.cos(turn)])


FRONT = View(0, "the front")
BACK = View(180, "the back")
LEFT = View(90, "their left")
FRONT_LEFT = View(40, "their front left")
BACK_LEFT = View(140, "their back left")
FRONT_ABOVE = View(0, "the front, a little from above", lift=1.5)

VIEWS: Mapping[str, tuple[View, ...]] = {
    "head_girth": (FRONT, LEFT),
    "neck_girth": (FRONT, LEFT),
    "armscye_girth": (FRONT_LEFT, BACK_LEFT),
    "shoulder_length": (FRONT_ABOVE,),
    "rise_length": (FRONT, BACK),
    "glute_length": (BACK,),
    "neck_to_waist_length": (BACK,),
    "collarbone_to_waist_length": (FRONT, FRONT_LEFT),
    "upper_arm_length": (BACK_LEFT,),
    "lower_arm_length": (BACK_LEFT,),
    "arm_length": (BACK_LEFT,),
    "breast_length": (FRONT, FRONT_LEFT),
    "collarbone_to_underbust_length": (FRONT, FRONT_LEFT),
    "armpit_to_waist_length": (FRONT_LEFT,),
    "torso_height": (BACK,),
    "hip_to_ankle_height": (LEFT,),
}
"""From where a tape is seen, where that is not as usual for its kind."""


def views_of(name: str) -> tuple[View, ...]:
    """From where a measurement is drawn, in order."""
    return VIEWS.get(name, (FRONT, BACK) if MEASUREMENTS[name].kind == "girth" else (FRONT,))


def tape_picture(body: Body, name: str, path: Floats, *, panel: tuple[int, int] = PANEL) -> bytes:
    """One measurement drawn on a body, its views side by side, as the bytes of a WebP file.

    Parameters
    ----------
    body : Body
    name : of the measurement
    path : ndarray of shape (n, 3), metres, where `anthropometry.measure` ran its tape
    panel : width and height of one view, in pixels

    Raises
    ------
    RenderingUnavailable
        If this machine lacks OSMesa; the message says what is missing.
    """
    views = views_of(name)
    pitch = panel[0] + GAP
    picture = Image.new("RGB", (pitch * len(views) - GAP, panel[1]), "white")
    for column, view in enumerate(views):
        picture.paste(_panel(body, name, path, view, panel), (column * pitch, 0))
    return _webp(picture)


LEG_ENDS: Mapping[str, float | None] = {
    "floor": 0.0,
    "ankle": None,
    "trousers": TROUSERS_SHORT_OF_FLOOR,
}
"""Down to where people measure an inside leg, as a height in metres; None: the ankle's own."""


def leg_picture(body: Body, path: Floats, end: str, *, panel: tuple[int, int] = PANEL) -> bytes:
    """The inside leg down to one of `LEG_ENDS`, drawn on a body, as the bytes of a WebP file.

    Parameters
    ----------
    body, panel : as in `tape_picture`
    path : ndarray of shape (2, 3), metres, of the inseam: from the crotch to the ankle's level
    """
    path = path.copy()
    ends = _ends(body, "inseam_height", path)
    level = LEG_ENDS[end]
    if level is not None:
        path[1, 1] = ends[1, 1] = level
    return _webp(_panel(body, "inseam_height", path, FRONT, panel, ends))


def _webp(picture: Image.Image) -> bytes:
    stream = io.BytesIO()
    picture.save(stream, "WEBP", quality=82, method=6)
    return stream.getvalue()


PERSON: Mapping[BodyKind, str] = {"female": "a woman", "male": "a man", "neutral": "a person"}


def text_alternative(name: str, kind: BodyKind) -> str:
    """What the picture of a measurement shows, for those who do not see it."""
    row = MEASUREMENTS[name]
    if row.kind == "mass":
        return f"{row.label}: {PERSON[kind]} standing on a scale."
    drawn = "a line beside" if row.kind == "height" else "a tape on the body of"
    seen = " and from ".join(view.words for view in views_of(name))
    which = " (the narrowest part of the torso)" if "waist" in row.definition else ""
    definition = row.definition.replace("waist", f"waist{which}", 1)
    return f"{row.label}: {definition}; {drawn} {PERSON[kind]}, seen from {seen}."


def seen(path: Floats, projection: Projection, depths: NDArray[np.float32]) -> Booleans:
    """Which points of a path, (n, 3) in metres, the camera sees: ndarray of shape (n,).

    Parameters
    ----------
    depths : as `rendering.Photograph` has them
    """
    away = projection.camera.distance - path @ projection.towards
    columns, rows = np.floor(projection.pixels(path) * FINENESS).astype(int).T
    inside = (rows >= 0) & (rows < depths.shape[0]) & (columns >= 0) & (columns < depths.shape[1])
    nearest = np.full(len(path), np.inf)
    nearest[inside] = depths[rows[inside], columns[inside]]
    return away <= nearest + HIDDEN_BEHIND


# ---- one view -----------------------------------------------------------------------------------


def _panel(
    body: Body,
    name: str,
    path: Floats,
    view: View,
    panel: tuple[int, int],
    ends: Floats | None = None,
) -> Image.Image:
    kind = MEASUREMENTS[name].kind
    beside = _beside(body, path, view) if kind == "height" else 0.0
    projection = _frame(body, kind, path, view, beside, panel)
    photo = photograph(in_underwear(dress(body)), projection, panel)
    sheet = _Sheet(projection, panel)
    if kind == "mass":
        sheet.scale(body)
    elif kind == "height":
        sheet.dimension(path, _ends(body, name, path) if ends is None else ends, view, beside)
    else:
        dense = _dense(path, closed=kind == "girth")
        sheet.band(dense, _steady(seen(dense, projection, photo.depths)), ends=kind == "length")
    return sheet.on(photo)


def _frame(
    body: Body, kind: str, path: Floats, view: View, beside: float, panel: tuple[int, int]
) -> Projection:
    """The projection that shows a path, its dimension line and enough of the body."""
    across, up = path @ view.right, path[:, 1]
    if kind == "height":
        across = np.append(across, [beside, across.min() - 0.12])
    whole = np.column_stack([body.vertices @ view.right, body.vertices[:, 1]])
    if kind == "mass" or np.ptp(up) > 0.6 * np.ptp(whole[:, 1]):
        across = np.concatenate([across, whole[:, 0]])
        up = np.append(whole[:, 1], -0.06 if kind == "mass" else 0.0)
    room = 1 + (0.1 if np.ptp(up) > 1.2 else 2 * ROOM)
    tall = max(room * np.ptp(up), room * np.ptp(across) * panel[1] / panel[0], LEAST_WINDOW)
    middle, centre = (up.max() + up.min()) / 2, (across.max() + across.min()) / 2
    # No more of the nothing below the soles and above the crown than a margin.
    low, high = (0.5 - EMPTY_ROOM) * tall, whole[:, 1].max() - (0.5 - EMPTY_ROOM) * tall
    middle = (low + high) / 2 if low > high else float(np.clip(middle, low, high))
    height = middle if kind in ("height", "mass") else middle + view.lift
    camera = Camera(DISTANCE, float(np.clip(height, 0, 3)))
    focal = panel[1] / tall * DISTANCE
    return Projection(
        camera,
        view.right,
        view.towards,
        focal=float(focal),
        column=float(panel[0] / 2 - focal * centre / DISTANCE),
        row=float(panel[1] / 2 + focal * (middle - camera.height) / DISTANCE),
    )


def _beside(body: Body, path: Floats, view: View) -> float:
    """How far to the picture's right a dimension line clears the body, in metres."""
    up = body.vertices[:, 1]
    level = (up >= path[:, 1].min() - 0.02) & (up <= path[:, 1].max() + 0.02)
    return float((body.vertices[level] @ view.right).max()) + 0.07


def _ends(body: Body, name: str, path: Floats) -> Floats:
    """Where a height's upper and lower end lie on the body: ndarray of shape (2, 3)."""
    tape = TAPES[name]
    if not isinstance(tape, Height):
        return path
    return np.array(
        [
            body.template.landmark_points(body.vertices, *names) if names else point
            for names, point in zip((tape.top, tape.bottom), path, strict=True)
        ]
    )


def _dense(path: Floats, closed: bool) -> Floats:
    """The path with a point at least every `STEP`."""
    if closed:
        path = np.vstack([path, path[:1]])
    lengths = np.r_[0.0, np.linalg.norm(np.diff(path, axis=0), axis=1).cumsum()]
    stations = np.linspace(0, lengths[-1], max(2, int(np.ceil(lengths[-1] / STEP)) + 1))
    return np.column_stack([np.interp(stations, lengths, path[:, axis]) for axis in range(3)])


def _steady(flags: Booleans) -> Booleans:
    """The same without runs that are shorter than `SHORTEST_RUN`; the ends may be short."""
    flags = flags.copy()
    least = round(SHORTEST_RUN / STEP)
    for value in (False, True):
        edges = np.flatnonzero(np.diff(flags)) + 1
        for start, stop in pairwise(edges.tolist()):
            if stop - start < least and flags[start] == value:
                flags[start:stop] = not value
    return flags


class _Sheet:
    """A transparent sheet over a picture, drawn on `FINE` times as fine."""

    def __init__(self, projection: Projection, panel: tuple[int, int]) -> None:
        self._projection = projection
        self._panel = panel
        size = (FINE * panel[0], FINE * panel[1])
        self._behind = Image.new("RGBA", size, (*LINE, 0))
        self._faint = Image.new("RGBA", size, (*ACCENT, 0))
        self._clear = Image.new("RGBA", size, (*ACCENT, 0))
        per_metre = projection.focal / projection.camera.distance
        self._width = float(np.clip(BAND * per_metre, *BAND_PIXELS))

    def on(self, photo: Photograph) -> Image.Image:
        """The picture under the sheet; what is behind the body is hidden by it."""
        picture = photo.picture.convert("RGBA")
        free = Image.fromarray(np.isinf(photo.depths).astype(np.uint8) * 255).reduce(FINENESS)
        behind = self._behind.resize(self._panel, Image.Resampling.BOX)
        behind.putalpha(ImageChops.multiply(behind.getchannel("A"), free))
        picture.alpha_composite(behind)
        for layer in (self._faint, self._clear):
            picture.alpha_composite(layer.resize(self._panel, Image.Resampling.BOX))
        return picture.convert("RGB")

    def band(self, dense: Floats, shown: Booleans, ends: bool) -> None:
        """A tape on the skin; the ends of an open one are dots."""
        pixels = self._fine(dense)
        width = self._width
        runs = np.split(np.arange(len(shown)), np.flatnonzero(np.diff(shown)) + 1)
        for value, layer, thick, colour, rounded in (
            (False, self._faint, 0.45 * width, (*ACCENT, 70), False),
            (True, self._clear, width + 2.4, (*EDGE, 255), False),
            (True, self._clear, width, (*ACCENT, 255), True),
        ):
            for run in runs:
                if shown[run[0]] == value:
                    # One point of the next stretch, so that no gap is left between them.
                    self._stroke(layer, pixels[run[0] : run[-1] + 2], thick, colour, rounded)
        if ends:
            for place in (0, -1):
                if shown[place]:
                    self._dot(pixels[place])

    def dimension(self, path: Floats, ends: Floats, view: View, beside: float) -> None:
        """A vertical line beside the body between two levels, with ticks and leaders."""
        shift = (beside - path[0] @ view.right) * view.right
        top, bottom = self._fine(path + shift)
        on_body = self._fine(ends)
        on_floor = path[:, 1].min() < ON_FLOOR
        tick = 1.5 * self._width * FINE
        for point, level in zip(on_body, (top, bottom), strict=True):
            if on_floor and level is bottom:
                floor = np.array([[0, bottom[1]], [FINE * self._panel[0], bottom[1]]])
                self._stroke(self._behind, floor, 1.4, (*LINE, 200))
            else:
                leader = np.array([[point[0], level[1]], [level[0] + tick, level[1]]])
                self._stroke(self._clear, leader, 1.4, (*LINE, 200))
        thick = 0.6 * self._width
        self._stroke(self._clear, np.array([top, bottom]), thick, (*ACCENT, 255))
        for level in (top, bottom):
            across = level + np.array([[-tick, 0], [tick, 0]])
            self._stroke(self._clear, across, thick, (*ACCENT, 255))
        for point, level in zip(on_body, (top, bottom), strict=True):
            if not (on_floor and level is bottom):
                self._dot(np.array([point[0], level[1]]))

    def scale(self, body: Body) -> None:
        """A bathroom scale under the soles."""
        low = body.vertices[body.vertices[:, 1] < 0.05]
        wide = np.abs(low[:, 0]).max() + 0.05
        corners = self._fine(np.array([[-wide, -0.002, 0.0], [wide, -0.042, 0.0]]))
        box = [*corners[0], *corners[1]]
        pen = ImageDraw.Draw(self._clear)
        pen.rounded_rectangle(box, radius=3 * FINE, fill=(*ACCENT, 255))

    def _fine(self, points: Floats) -> Floats:
        pixels: Floats = FINE * self._projection.pixels(points)
        return pixels

    def _stroke(
        self,
        layer: Image.Image,
        points: Floats,
        width: float,
        colour: tuple[int, ...],
        rounded: bool = True,
    ) -> None:
        """A line whose bends, and if `rounded` whose ends, are round; the width in pixels."""
        pen = ImageDraw.Draw(layer)
        flat = [(float(x), float(y)) for x, y in points]
        pen.line(flat, fill=colour, width=max(1, round(width * FINE)))
        radius = width * FINE / 2
        for x, y in flat if rounded else flat[1:-1]:
            pen.ellipse([x - radius, y - radius, x + radius, y + radius], fill=colour)

    def _dot(self, point: Floats) -> None:
        pen = ImageDraw.Draw(self._clear)
        for radius, colour in ((self._width * 0.95, EDGE), (self._width * 0.75, ACCENT)):
            reach = radius * FINE
            box = [*(point - reach), *(point + reach)]
            pen.ellipse([float(edge) for edge in box], fill=(*colour, 255))
