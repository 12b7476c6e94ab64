"""The page of measurements is what the table, the tapes and the population say."""

import re
from pathlib import Path

import numpy as np
import pytest

from model.anthropometry import TAKEN, measure_batch
from model.measurements import MEASUREMENTS
from model.template_mesh import load_template_mesh
from model.training.measurement_guide import (
    BOTH_SEXES,
    LARGEST_PICTURE,
    PAGE,
    SPREADS,
    guide_text,
    mean_body,
    picture_of,
)
from model.training.population import bodies_of, load_population
from model.training.spreads import load_spreads
from model.training.survey import SEXES

DOCS = Path(__file__).parents[1] / "docs"
REMEDY = "run: make guide"


@pytest.fixture(scope="module")
def page():
    return (DOCS / PAGE).read_text(encoding="utf-8")


def test_the_page_is_what_the_code_says(page):
    assert page == guide_text(DOCS), REMEDY


@pytest.mark.parametrize("name", TAKEN)
def test_every_measurement_has_its_entry_and_its_picture(page, name):
    assert f'### <a id="{name}"></a>{MEASUREMENTS[name].label}' in page
    assert f"| name | `{name}` |" in page
    sexes = SEXES if name in BOTH_SEXES else SEXES[:1]
    for sex in sexes:
        picture = DOCS / picture_of(name, sex)
        assert picture.as_posix().removeprefix(f"{DOCS.as_posix()}/") in page
        assert 0 < picture.stat().st_size <= LARGEST_PICTURE, REMEDY


def test_every_picture_has_words(page):
    pictures = re.findall(r"!\[([^\]]*)\]", page)
    assert len(pictures) == len(TAKEN) + len(BOTH_SEXES) + 1
    assert all(len(words) > 20 for words in pictures)


def test_no_picture_is_left_from_before():
    drawn = {picture_of(name) for name in TAKEN}
    drawn |= {picture_of(name, "male") for name in BOTH_SEXES}
    folder = DOCS / "images" / "measurements"
    there = {path.relative_to(DOCS) for path in folder.iterdir()}
    assert there == drawn | {folder.relative_to(DOCS) / "segments.webp"}


def test_the_spreads_are_those_of_the_shipped_population():
    spreads, population = load_spreads(DOCS / SPREADS), load_population()
    assert set(spreads) == {(sex, name) for sex in SEXES for name in TAKEN}
    for sex in SEXES:
        rows = np.flatnonzero(population.of(sex))
        assert spreads[sex, TAKEN[0]].count == len(rows)
        index = population.taken[rows, 1] / population.taken[rows, 0] ** 2
        few = rows[np.argsort(index)[[0, len(rows) // 2, -1]]]
        for _, vertices in bodies_of(population, few):
            for body in measure_batch(load_template_mesh(), vertices):
                for name, value in zip(TAKEN, body, strict=True):
                    spread = spreads[sex, name]
                    assert spread.low - 1e-4 <= value <= spread.high + 1e-4, REMEDY


def test_the_body_that_is_drawn_is_an_ordinary_one():
    """Weighted back to the survey, the mean woman is as tall as the survey's."""
    spreads = load_spreads(DOCS / SPREADS)
    for sex in SEXES:
        body = mean_body(load_population(), sex)
        values = measure_batch(body.template, body.vertices[None], ("stature", "hip_girth"))[0]
        assert values[0] == pytest.approx(spreads[sex, "stature"].mean, abs=0.005)
        assert values[1] == pytest.approx(spreads[sex, "hip_girth"].mean, abs=0.02)
