"""The paper's models on the shipped shape basis."""

import numpy as np
import pytest

from model.estimators import LinearBodyEstimator
from model.shape_basis import load_shape_basis
from model.template_mesh import load_template_mesh
from model.training import paper_models
from model.training.paper_models import (
    LINEAR,
    LINEAR_LETTER,
    PCA,
    PCA_DIVIDED,
    PCA_LETTER,
    PaperSpace,
    from_groin,
    given,
    learn,
)


@pytest.fixture(scope="module")
def space():
    return PaperSpace.of(load_shape_basis(), load_template_mesh())


@pytest.fixture(scope="module")
def coefficients(space):
    return np.random.default_rng(0).normal(size=(6, len(space.root)))


def test_the_groin_is_at_zero_and_nothing_moves_forwards(space, coefficients) -> None:
    vertices = space.vertices(space.coordinates(coefficients))
    assert np.abs(space.template.landmark_points(vertices, "crotch")[:, 1]).max() < 1e-5
    standing = load_shape_basis().vertices(coefficients)
    moved = standing - from_groin(space.template, standing)
    assert np.abs(moved[..., [0, 2]]).max() == 0
    assert np.ptp(moved[..., 1], axis=1).max() < 1e-12


def test_bodies_are_those_of_the_shape_basis(space, coefficients) -> None:
    ours = space.vertices(space.coordinates(coefficients))
    theirs = from_groin(space.template, load_shape_basis().vertices(coefficients))
    assert np.abs(ours - theirs).max() < 2e-5


def test_distances_are_those_of_the_vertices(space, coefficients) -> None:
    coordinates = space.coordinates(coefficients)
    vertices = space.vertices(coordinates)
    ours = ((coordinates[:3] - coordinates[3:]) ** 2).sum(axis=1)
    theirs = ((vertices[:3] - vertices[3:]) ** 2).sum(axis=(1, 2))
    assert ours == pytest.approx(theirs, rel=1e-4)


@pytest.fixture(scope="module")
def people(space):
    """Bodies that follow four measurements, and more than those."""
    random = np.random.default_rng(1)
    values = random.normal(size=(150, 4)) * [0.07, 0.1, 0.1, 12] + [1.7, 0.9, 1.0, 70]
    law = random.normal(size=(4, len(space.root)))
    coefficients = (values - values.mean(axis=0)) / values.std(axis=0) @ law
    coefficients += random.normal(size=coefficients.shape)
    return values, space.coordinates(coefficients)


def test_the_letters_linear_law_is_that_of_the_vertices(space, people) -> None:
    """A = y x⁺ on some vertices themselves is what it is in the space."""
    values, coordinates = people
    some = slice(0, 60)
    y = space.vertices(coordinates)[:, some].reshape(len(values), -1)
    law = y.T @ np.linalg.pinv(values.T)
    estimated = space.vertices(learn(values, coordinates)[LINEAR_LETTER](values[:5]))
    assert np.abs(estimated[:, some].reshape(5, -1) - values[:5] @ law.T).max() < 1e-4


def test_only_a_constant_brings_the_mean_body_for_mean_measurements(people) -> None:
    values, coordinates = people
    models = learn(values, coordinates)
    mean = values.mean(axis=0, keepdims=True)
    rows = np.concatenate([mean, given("abcd", mean, "ab"), given("abcd", mean, "d")])
    for name in (LINEAR, PCA, PCA_DIVIDED):
        apart = models[name](rows) - coordinates.mean(axis=0)
        assert np.abs(apart).max() < 1e-6, name
    for name in (LINEAR_LETTER, PCA_LETTER):
        assert np.abs(models[name](rows) - coordinates.mean(axis=0)).max() > 1e-3, name


def test_the_letters_laws_scale_the_body_with_what_is_given(people) -> None:
    """Without a constant a twentieth more of all that is given is a twentieth more body."""
    values, coordinates = people
    linear = learn(values, coordinates)[LINEAR_LETTER]
    rows = given("abcd", values[:5], "bc")
    assert linear(1.05 * rows) == pytest.approx(1.05 * linear(rows))


def test_with_a_constant_and_all_components_the_two_are_one(people, monkeypatch) -> None:
    values, coordinates = people
    monkeypatch.setattr(paper_models, "COMPONENT_SHARE", None)
    models = learn(values, coordinates)
    rows = given("abcd", values[:5], "acd")
    assert models[PCA](rows) == pytest.approx(models[LINEAR](rows), abs=1e-6)
    assert np.abs(models[PCA_DIVIDED](rows) - models[LINEAR](rows)).max() > 0.1


def test_the_linear_model_is_the_estimators(people) -> None:
    values, coordinates = people
    ours = learn(values, coordinates)[LINEAR](values)
    theirs = LinearBodyEstimator().fit(values, coordinates).predict(values)
    assert (ours == theirs).all()


def test_what_is_not_given_is_unknown() -> None:
    rows = given(("a", "b", "c"), np.ones((2, 3)), ("c", "a"))
    assert np.isnan(rows).tolist() == [[False, True, False]] * 2
