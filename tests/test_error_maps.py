"""The error maps against the distances that they show."""

import numpy as np
import pytest

from model.appearance import BACKDROP
from model.template_mesh import load_template_mesh
from model.training.error_maps import (
    CELL,
    FOOT,
    HEAD,
    MARGIN,
    SHOWN,
    VIRIDIS,
    MapRow,
    colours,
    draw_map,
)


def test_colours_run_from_dark_blue_to_yellow() -> None:
    shown = colours(np.array([0.0, 0.05, 0.1, 9.0]), 0.1)
    assert shown == pytest.approx(np.array([VIRIDIS[0], VIRIDIS[5], VIRIDIS[-1], VIRIDIS[-1]]))
    brightness = colours(np.linspace(0, 1, 50), 1) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(brightness) > 0).all()


@pytest.fixture(scope="module")
def figure():
    """Columns: no error; all 10 cm off; the upper half 5 cm off."""
    template = load_template_mesh()
    true = template.vertices - [0, 0.8, 0]
    forwards = np.array([0, 0, 0.1])
    upper = 0.5 * (true[:, 1] > 0)[:, None] * forwards
    estimated = {"none": true, "all": true + forwards, "upper": true + upper}
    return draw_map(template, [MapRow(["female", "small"], true, estimated)], 0.1)


def cell(figure, column):
    """The front picture of a column: (height, width, 3), and which pixels are of the body."""
    left = MARGIN + column * sum(SHOWN.values())
    pixels = np.asarray(figure.crop((left, HEAD, left + SHOWN["front"], HEAD + CELL[1])))
    return pixels, np.abs(pixels - np.array(BACKDROP)).max(axis=2) > 60


def test_the_figure_holds_every_column_and_a_scale(figure) -> None:
    assert figure.size == (MARGIN + 4 * sum(SHOWN.values()), HEAD + CELL[1] + FOOT)
    scale = np.asarray(figure)[figure.height - FOOT + 16, MARGIN : figure.width - 2 * MARGIN]
    assert scale[0] == pytest.approx(255 * np.array(VIRIDIS[0]), abs=2)
    assert scale[-1] == pytest.approx(255 * np.array(VIRIDIS[-1]), abs=2)


def test_a_body_takes_the_colour_of_its_error(figure) -> None:
    shades = [pixels[body].mean(axis=0) for pixels, body in (cell(figure, i) for i in range(4))]
    none, everywhere, upper, original = shades
    assert none[2] > none[1]
    assert everywhere[1] > 2 * everywhere[2]
    assert none.sum() < upper.sum() < everywhere.sum()
    assert np.ptp(original) < 40


def test_colours_are_where_the_error_is(figure) -> None:
    pixels, body = cell(figure, 2)
    rows = np.flatnonzero(body.any(axis=1))
    head = pixels[rows[:20]][body[rows[:20]]].mean(axis=0)
    feet = pixels[rows[-20:]][body[rows[-20:]]].mean(axis=0)
    assert head[1] > head[0]
    assert feet[1] < head[1] / 2


def test_bodies_have_one_scale() -> None:
    template = load_template_mesh()
    true = template.vertices - [0, template.vertices[:, 1].min(), 0]
    picture = draw_map(template, [MapRow([], true, {"smaller": 0.8 * true})], 0.1)
    tall, short = (np.flatnonzero(cell(picture, i)[1].any(axis=1)) for i in (1, 0))
    assert np.ptp(short) == pytest.approx(0.8 * np.ptp(tall), abs=4)
    assert short[-1] == pytest.approx(tall[-1], abs=3)
