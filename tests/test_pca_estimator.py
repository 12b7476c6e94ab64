"""The paper's model by principal components, beside its linear one."""

import numpy as np
import pytest
from sklearn.linear_model import LinearRegression
from sklearn.utils.estimator_checks import parametrize_with_checks

from model.estimators import LinearBodyEstimator, PCABodyEstimator


@parametrize_with_checks(
    [PCABodyEstimator(), PCABodyEstimator(fit_intercept=False), PCABodyEstimator(0.9)]
)
def test_it_keeps_scikit_learns_contract(estimator, check) -> None:
    check(estimator)


@pytest.fixture
def people() -> tuple[np.ndarray, np.ndarray]:
    """Measurements and coordinates with a linear law between them and much noise."""
    random = np.random.default_rng(0)
    measurements = random.normal(size=(200, 5)) * [0.1, 10, 0.2, 0.05, 1] + [1.7, 70, 1, 0.4, 3]
    law = random.normal(size=(7, 5))
    return measurements, measurements @ law.T + random.normal(size=(200, 7)) + 3


def planted(random, *, centred):
    """200 bodies of 9 coordinates with 3 components whose weights follow from measurements."""
    measurements = random.normal(size=(200, 4))
    if centred:
        measurements -= measurements.mean(axis=0)
    measurements += 0.0 if centred else 5.0
    scores = measurements @ random.normal(size=(4, 3)) * [9, 3, 1]
    directions = np.linalg.qr(random.normal(size=(9, 3)))[0].T
    mean = random.normal(size=9)
    return measurements, mean + scores @ directions, directions


def test_it_finds_planted_components_and_their_law() -> None:
    measurements, bodies, directions = planted(np.random.default_rng(1), centred=False)
    estimator = PCABodyEstimator().fit(measurements, bodies)
    assert estimator.components_.shape == (3, 9)
    # The same space: each planted direction lies in the span of the components.
    inside = directions @ estimator.components_.T @ estimator.components_
    assert inside == pytest.approx(directions, abs=1e-9)
    assert estimator.predict(measurements) == pytest.approx(bodies, abs=1e-8)
    assert estimator.score(measurements, bodies) == pytest.approx(1)


def test_equations_1_to_5_to_the_letter() -> None:
    """Without a constant, every step as the paper writes it, on matrices of one body a column."""
    random = np.random.default_rng(2)
    P = random.normal(size=(4, 50)) + 2
    S = random.normal(size=(9, 4)) @ P + random.normal(size=(9, 50))
    mean = S.mean(axis=1, keepdims=True)
    D = S - mean
    eigenvalues, U = np.linalg.eigh(D @ D.T / 49)
    W = (U.T @ D) / eigenvalues[:, None]
    to_weights = W @ np.linalg.pinv(D)
    B = W @ np.linalg.pinv(P)
    new = random.normal(size=(4, 3)) + 2
    expected = np.linalg.inv(to_weights) @ B @ new + mean

    estimator = PCABodyEstimator(fit_intercept=False).fit(P.T, S.T)
    assert estimator.eigenvalues_ == pytest.approx(eigenvalues[::-1])
    assert np.abs(estimator.weights(new.T)) == pytest.approx(np.abs((B @ new).T[:, ::-1]))
    assert estimator.predict(new.T) == pytest.approx(expected.T)


@pytest.mark.parametrize("missing", [[], [1], [0, 3], [0, 1, 2, 3, 4]])
def test_with_all_components_and_a_constant_it_is_the_linear_law(people, missing) -> None:
    measurements, bodies = people
    new = measurements[:20].copy()
    new[:, missing] = np.nan
    ours = PCABodyEstimator().fit(measurements, bodies).predict(new)
    theirs = LinearBodyEstimator().fit(measurements, bodies).predict(new)
    assert ours == pytest.approx(theirs, abs=1e-8)


def test_without_a_constant_the_two_differ_by_what_the_algebra_says(people) -> None:
    """S x⁺ = (D + S̄ 1ᵀ) x⁺, so the linear law adds S̄ (1ᵀ x⁺ p) where the other adds S̄."""
    measurements, bodies = people
    ours = PCABodyEstimator(fit_intercept=False).fit(measurements, bodies).predict(measurements)
    theirs = LinearBodyEstimator(fit_intercept=False).fit(measurements, bodies)
    constant = np.ones(200) @ np.linalg.pinv(measurements.T) @ measurements.T
    apart = (1 - constant)[:, None] * bodies.mean(axis=0)
    assert ours - theirs.predict(measurements) == pytest.approx(apart, abs=1e-6)
    assert np.abs(apart).max() > 0.1


def test_without_a_constant_the_two_agree_on_centred_bodies() -> None:
    measurements, bodies, _ = planted(np.random.default_rng(3), centred=True)
    bodies -= bodies.mean(axis=0)
    ours = PCABodyEstimator(fit_intercept=False).fit(measurements, bodies)
    theirs = LinearBodyEstimator(fit_intercept=False).fit(measurements, bodies)
    assert ours.predict(measurements) == pytest.approx(theirs.predict(measurements), abs=1e-9)


def test_the_division_by_eigenvalues_is_undone(people) -> None:
    measurements, bodies = people
    estimator = PCABodyEstimator(n_components=3).fit(measurements, bodies)
    scores = (bodies - bodies.mean(axis=0)) @ estimator.components_.T
    assert scores.var(axis=0, ddof=1) == pytest.approx(estimator.eigenvalues_)
    undivided = LinearRegression().fit(measurements, scores).predict(measurements)
    assert estimator.weights(measurements) == pytest.approx(undivided / estimator.eigenvalues_)
    expected = bodies.mean(axis=0) + undivided @ estimator.components_
    assert estimator.predict(measurements) == pytest.approx(expected, abs=1e-8)


def test_fewer_components_keep_the_greatest_variance(people) -> None:
    measurements, bodies = people
    everything = PCABodyEstimator().fit(measurements, bodies)
    assert (np.diff(everything.eigenvalues_) < 0).all()
    first = PCABodyEstimator(n_components=2).fit(measurements, bodies)
    assert first.eigenvalues_ == pytest.approx(everything.eigenvalues_[:2])
    held = np.cumsum(everything.eigenvalues_) / everything.eigenvalues_.sum()
    share = PCABodyEstimator(n_components=0.9).fit(measurements, bodies)
    assert len(share.eigenvalues_) == np.searchsorted(held, 0.9) + 1


def test_a_single_body_is_refused() -> None:
    with pytest.raises(ValueError, match="minimum of 2 is required"):
        PCABodyEstimator().fit([[1.0]], [[2.0]])
