"""Silhouettes: drawn as told by closed forms, and their edges' derivatives are true."""

import io

import numpy as np
import pytest
from PIL import Image

from model.cameras import Camera, seen
from model.estimators import load_estimators
from model.rendering import render_png
from model.silhouette import LEG, UPRIGHT, contour, contour_gradients, fill, silhouette
from model.training.population import load_population

CAMERA = Camera(distance=2.2, height=1.3)


@pytest.fixture(scope="module")
def coefficients():
    return load_population().coefficients[7]


@pytest.fixture(scope="module")
def body(coefficients):
    return load_estimators()["neutral"].body(coefficients)


def test_triangles_are_filled_where_a_pixels_middle_lies_in_them():
    points = np.array([[1.0, 1.0], [9.1, 1.0], [1.0, 9.1], [9.1, 9.1]])
    columns, rows = np.meshgrid(np.arange(12) + 0.5, np.arange(10) + 0.5)
    inside = (columns > 1) & (rows > 1) & (columns + rows < 10.1)
    assert np.array_equal(fill(points, np.array([[0, 1, 2]]), (12, 10)), inside)
    square = (columns > 1) & (columns < 9.1) & (rows > 1) & (rows < 9.1)
    assert np.array_equal(fill(points, np.array([[0, 1, 2], [3, 1, 2]]), (12, 10)), square)


def test_triangles_beyond_the_picture_are_cut():
    points = np.array([[-50.0, -50.0], [60.0, -50.0], [5.0, 80.0], [5.0, 5.0]])
    assert fill(points, np.array([[0, 1, 2]]), (10, 10)).all()
    assert not fill(points, np.array([[3, 3, 3]]), (10, 10)).any()


@pytest.mark.parametrize("side", ["front", "profile"])
def test_it_is_the_silhouette_that_the_renderer_draws(body, side):
    """Another way to the same: OpenGL's, to within the pixels of the edge."""
    ours = silhouette(body, side, camera=CAMERA).cover > 0.5
    png = render_png(body, side, size=(1200, 978), silhouette=True, camera=CAMERA)
    picture = Image.open(io.BytesIO(png)).convert("L")
    figure = picture.crop(picture.getbbox())
    theirs = np.asarray(figure.resize(ours.shape[::-1])) > 127
    assert figure.width / figure.height == pytest.approx(ours.shape[1] / ours.shape[0], rel=0.007)
    assert (theirs ^ ours).sum() < 0.02 * ours.sum()


@pytest.mark.parametrize("side", ["front", "profile"])
def test_a_contour_is_where_the_silhouette_ends(body, side):
    flat = seen(body.vertices, side, CAMERA)
    low, high = flat.min(axis=0), flat.max(axis=0)
    step = (high[1] - low[1]) / 900
    drawn = silhouette(body, side, camera=CAMERA).cover >= 0.5
    for row in (150, 300, 420):
        parts = body.template.part_names
        found = contour(body.template, flat, parts, np.array([high[1] - (row + 0.5) * step]))
        columns = (found.positions[0] - low[0]) / step
        ends = np.flatnonzero(drawn[row])[[0, -1]]
        assert columns == pytest.approx(ends + np.array([0, 1]), abs=0.63)


@pytest.mark.parametrize(
    ("side", "parts"), [("front", UPRIGHT), ("front", LEG), ("profile", UPRIGHT)]
)
def test_derivatives_of_contours_are_difference_quotients(coefficients, body, side, parts):
    estimator = load_estimators()["neutral"]
    facing = "left"
    # Of this body, 1.49 m tall: below the hips, and from there to the chest.
    heights = np.linspace(0.3, 0.6, 12) if parts == LEG else np.linspace(0.75, 1.05, 12)

    def at(given):
        flat = seen(estimator.body(given).vertices, side, CAMERA, facing)
        return contour(estimator.template, flat, parts, heights)

    gradients = contour_gradients(at(coefficients), body.vertices, side, CAMERA, facing)
    slopes = estimator.basis.by_coefficients(gradients)
    random = np.random.default_rng(0)
    close = []
    for _ in range(3):
        direction = random.normal(size=len(coefficients))
        step = 0.02
        forth, back = (at(coefficients + sign * step * direction).positions for sign in (1, -1))
        quotients = ((forth - back) / (2 * step)).T.ravel()
        close.append(np.abs(slopes @ direction - quotients) < 0.1 * np.abs(quotients) + 4e-4)
    # An outline that turns within the step is not straight there.
    assert np.mean(close) > 0.85


def test_a_height_that_meets_nothing_is_refused(body):
    with pytest.raises(ValueError, match=r"nothing is met 3\.000 m"):
        contour(body.template, seen(body.vertices, "front", CAMERA), UPRIGHT, np.array([3.0]))
