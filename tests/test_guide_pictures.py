"""The wizard's pictures: one of every measurement on bodies of each kind and build, small."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from model.anthropometry import measure
from model.estimators import load_estimator
from model.measurements import BODY_KINDS, MeasurementSet
from model.tape_pictures import ACCENT, LEG_ENDS, leg_picture, views_of
from model.template_mesh import DATA
from model.training.guide_pictures import (
    BUILDS,
    LARGEST_PICTURE,
    PANEL,
    builds_of,
    picture_names,
)
from webapp import guide

FOLDER = Path(__file__).parents[1] / "static" / "guide"
REMEDY = "run: make guide"


def test_every_measurement_is_drawn_on_every_kind_and_build_and_nothing_else():
    assert {path.stem for path in FOLDER.iterdir()} == set(picture_names()), REMEDY
    assert len(picture_names()) == (41 + len(LEG_ENDS)) * (3 + 3 + 1)


def test_the_pictures_are_small():
    sizes = [path.stat().st_size for path in FOLDER.iterdir()]
    assert min(sizes) > 0
    assert max(sizes) <= LARGEST_PICTURE
    assert sum(sizes) < 2.5e6


@pytest.mark.parametrize("name", ["waist_girth", "stature", "inside_leg_floor"])
def test_pictures_have_the_size_that_the_page_says(name):
    with Image.open(FOLDER / f"{name}_female_medium.webp") as picture:
        views = len(views_of(name)) if not name.startswith("inside_leg") else 1
        assert picture.size == (328 * views - 8, 400)


@pytest.mark.parametrize("kind", BODY_KINDS)
def test_the_site_asks_for_pictures_that_are_drawn(kind):
    drawn = {f"{build}" for build, _ in guide.BUILDS}
    assert drawn == set(BUILDS)
    assert set(builds_of(kind)) <= drawn
    indices = list(BUILDS.values())
    for (_, most), low, high in zip(guide.BUILDS, indices, indices[1:], strict=False):
        assert low < most < high


def test_an_inside_leg_ends_where_its_picture_says():
    body = load_estimator(DATA / "estimators" / "male.npz").estimate(
        MeasurementSet({"stature": 1.8})
    )
    path = measure(body).paths["inseam_height"]

    def lowest(end):
        """The lowest row of the picture that has the tape's colour."""
        picture = Image.open(io.BytesIO(leg_picture(body, path, end, panel=PANEL))).convert("RGB")
        near = np.abs(np.asarray(picture, int) - ACCENT).max(axis=2) < 40
        return np.flatnonzero(near.any(axis=1)).max()

    assert lowest("floor") > lowest("trousers") > lowest("ankle")
