import numpy as np
import pytest

from model.anthropometry import read_tapes
from model.shape_basis import load_shape_basis
from model.template_mesh import load_template_mesh
from model.training.population import load_population
from model.training.population_build import HELD_OUT_PER_SEX
from model.training.population_files import (
    LARGEST_VERTEX_ERROR,
    overlap,
    principal_components,
)
from model.training.survey import SEXES, SURVEY_TAPES


def test_components_are_as_few_as_the_error_allows() -> None:
    random = np.random.default_rng(0)
    planted = random.normal(size=(40, 3)) * [0.1, 0.05, 0.02] @ random.normal(size=(3, 90))
    centred = planted - planted.mean(axis=0)
    coefficients, directions = principal_components(centred)
    assert len(directions) <= 5
    assert coefficients.shape == (40, len(directions))
    rest = (centred - coefficients @ directions).reshape(40, -1, 3)
    assert np.linalg.norm(rest, axis=2).max() <= LARGEST_VERTEX_ERROR


def test_arms_and_legs_that_enter_are_seen() -> None:
    template = load_template_mesh()
    assert overlap(template, template.vertices) == 0
    arm = np.unique(template.faces[template.faces_of("lower_arm_left", "hand_left")])
    moved = template.vertices.copy()
    moved[arm, 0] -= 0.3
    assert overlap(template, moved) > 0.05
    leg = np.unique(template.faces[template.faces_of("lower_leg_left")])
    moved = template.vertices.copy()
    moved[leg, 0] -= 0.2
    assert overlap(template, moved) == pytest.approx(-moved[leg, 0].min())


def test_the_shipped_population_is_large_wide_and_complete() -> None:
    population = load_population()
    basis = load_shape_basis()
    assert population.coefficients.shape == (len(population.sexes), len(basis.directions))
    assert population.taken.shape == (len(population.sexes), len(SURVEY_TAPES))
    assert np.isfinite(population.coefficients).all()
    for sex in SEXES:
        mine = population.of(sex)
        assert mine.sum() >= 1500
        assert (population.held_out & mine).sum() == HELD_OUT_PER_SEX
        index = population.taken[mine, 1] / population.taken[mine, 0] ** 2
        assert index.min() < 17
        assert index.max() > 48


def test_decoded_bodies_measure_what_was_recorded() -> None:
    """Half a millimetre at any vertex is some 3 mm of a girth at the very worst; and of a neck
    that widens steeply twice as much.
    """
    population, template = load_population(), load_template_mesh()
    rows = np.linspace(0, len(population.sexes) - 1, 24).astype(int)
    bodies = load_shape_basis().vertices(population.coefficients[rows])
    names = list(SURVEY_TAPES)
    taken = read_tapes(template, bodies, list(SURVEY_TAPES.values()))
    off = np.abs(taken - population.taken[rows])
    lengths = np.delete(off, names.index("weightkg"), axis=1)
    assert lengths.max() < 0.006
    assert lengths.mean() < 0.0003
    assert off[:, names.index("weightkg")].max() < 0.1
