"""The pictures of the wizard's guide: every measurement on bodies of each kind and build.

Small WebP files in ``static/guide/``, named ``<measurement>_<kind>_<build>.webp``, and the inside
leg down to each place that people measure it to. A person is shown the build that comes nearest to
their own once their height and weight are known (`webapp.guide`).
"""

import io
from collections.abc import Mapping
from pathlib import Path

from PIL import Image, ImageDraw

from model.anthropometry import TAKEN, measure
from model.estimators import Estimator, load_estimators
from model.measurements import MEASUREMENTS, BodyKind, MeasurementSet
from model.tape_pictures import LEG_ENDS, leg_picture, tape_picture
from model.template_mesh import DATA

GUIDE = Path("static", "guide")

SHEET = Path("docs", "images", "guide.webp")
"""All measurements on one sheet, to look at."""

PANEL = (320, 400)
"""Of one view, in pixels: sharp at half a telephone's width, and small."""

BUILDS: Mapping[str, float] = {"slim": 20.5, "medium": 25.5, "broad": 33.0}
"""The body-mass index of each build that is drawn, in kg/m²."""

STATURES: Mapping[BodyKind, float] = {"female": 1.63, "male": 1.756, "neutral": 1.69}
"""Metres: the survey's mean woman and man (ANSUR II), and their mean."""

LARGEST_PICTURE = 30_000
"""Bytes."""


def builds_of(kind: BodyKind) -> tuple[str, ...]:
    """The builds that are drawn of a kind of body; neutral ones are drawn once."""
    return ("medium",) if kind == "neutral" else tuple(BUILDS)


def picture_names() -> list[str]:
    """The names of all files, without their ending."""
    subjects = [*TAKEN, *(f"inside_leg_{end}" for end in LEG_ENDS)]
    return [
        f"{subject}_{kind}_{build}"
        for kind in STATURES
        for build in builds_of(kind)
        for subject in subjects
    ]


def draw_guide(folder: Path = GUIDE) -> None:
    """Draws all pictures, in place of those that are there.

    Raises
    ------
    ValueError
        If a picture is larger than `LARGEST_PICTURE`.
    """
    drawn: dict[str, bytes] = {}
    for kind, estimator in load_estimators(DATA).items():
        for build in builds_of(kind):
            drawn |= _pictures(estimator, build)
    for name, picture in drawn.items():
        if len(picture) > LARGEST_PICTURE:
            raise ValueError(f"{name} has {len(picture)} bytes, more than {LARGEST_PICTURE}")
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.webp"):
        old.unlink()
    for name, picture in drawn.items():
        (folder / f"{name}.webp").write_bytes(picture)
    SHEET.write_bytes(sheet(folder))
    size = sum(map(len, drawn.values()))
    print(f"drew {len(drawn)} pictures into {folder}, {size / 1e3:.0f} kB")


def sheet(folder: Path = GUIDE, columns: int = 7) -> bytes:
    """All measurements of one body on one sheet, in the table's order: the bytes of a WebP file."""
    wide, tall = PANEL[0] // 2 * 2 + 6, PANEL[1] // 2 + 20
    rows = -(-len(TAKEN) // columns)
    paper = Image.new("RGB", (columns * wide, rows * tall), "white")
    pen = ImageDraw.Draw(paper)
    for place, name in enumerate(TAKEN):
        left, top = place % columns * wide, place // columns * tall
        with Image.open(folder / f"{name}_female_medium.webp") as picture:
            paper.paste(picture.reduce(2), (left, top + 14))
        pen.text((left, top), MEASUREMENTS[name].label, fill="black")
    stream = io.BytesIO()
    paper.save(stream, "WEBP", quality=70, method=6)
    return stream.getvalue()


def _pictures(estimator: Estimator, build: str) -> dict[str, bytes]:
    """All pictures of one kind and build, by name."""
    stature = STATURES[estimator.kind]
    asked = MeasurementSet({"stature": stature, "weight": BUILDS[build] * stature**2})
    body = estimator.estimate(asked)
    paths = measure(body).paths
    drawn = {name: tape_picture(body, name, paths[name], panel=PANEL) for name in TAKEN}
    for end in LEG_ENDS:
        drawn[f"inside_leg_{end}"] = leg_picture(body, paths["inseam_height"], end, panel=PANEL)
    return {f"{name}_{estimator.kind}_{build}": picture for name, picture in drawn.items()}
