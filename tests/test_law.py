from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from model.estimators import load_estimators
from model.law import LEAST_NOISE, TAPE_NOISE, Law
from model.measurements import MEASUREMENTS, MeasurementSet
from model.training.law_fit import _factors, calibrated, law_of

NAMES = ("stature", "weight", "bust_girth", "abdomen_girth", "hip_girth")


@pytest.fixture(scope="module")
def planted() -> tuple[Law, np.ndarray]:
    """A law with bends and widenings, and 20,000 people of it."""
    random = np.random.default_rng(0)
    mixed = random.normal(size=(3, 3)) * 0.02
    covariance = np.zeros((5, 5))
    covariance[:2, :2] = [[0.0016, 0.0030], [0.0030, 0.0260]]
    covariance[2:, 2:] = mixed @ mixed.T + 0.0004 * np.eye(3)
    law = Law(
        names=NAMES,
        means=np.log([1.68, 68, 0.92, 0.88, 1.0]),
        slopes=np.array([[1, 0], [0, 1], [-0.4, 0.4], [-0.6, 0.5], [-0.2, 0.35]]),
        bends=np.array([0, 0, 0.1, -0.2, 0.05]),
        widenings=np.array([0, 0, 0.9, 0.4, -0.3]),
        covariance=covariance,
        reach=(-0.6, 0.6),
        factors=np.ones(5),
        factor_slopes=np.zeros(5),
    )
    core = random.multivariate_normal(np.zeros(2), covariance[:2, :2], 20_000)
    difference = np.clip(core[:, 1] - 2 * core[:, 0], *law.reach)[:, None]
    left = random.multivariate_normal(np.zeros(5), np.diag([0] * 5) + covariance, 20_000)
    left[:, :2] = 0
    logs = law.means + core @ law.slopes.T + law.bends * difference**2
    return law, np.exp(logs + left * np.exp(law.widenings * difference))


def test_without_bends_it_is_the_normal_law(planted) -> None:
    """Conditional mean and covariance, against the ratio of normal densities."""
    law = replace(planted[0], bends=np.zeros(5), widenings=np.zeros(5))
    known = MeasurementSet({"stature": 1.75, "bust_girth": 1.0, "hip_girth": 1.04})
    given = law.given(known)
    spread = law.slopes @ law.covariance[:2, :2] @ law.slopes.T
    spread[2:, 2:] += law.covariance[2:, 2:]
    spread += LEAST_NOISE**2 * np.diag([1, 0, 1, 0, 1])
    joint = multivariate_normal(law.means, spread)
    rest = multivariate_normal(given.means[[1, 3]], given.covariance[np.ix_([1, 3], [1, 3])])
    at = np.log([1.75, 1, 1.0, 1, 1.04])
    ratios = []
    for weight, abdomen in ((60, 0.8), (75, 0.95), (90, 1.0)):
        at[[1, 3]] = np.log([weight, abdomen])
        ratios.append(joint.logpdf(at) - rest.logpdf(at[[1, 3]]))
    assert ratios == pytest.approx([ratios[0]] * 3)


def test_a_planted_law_is_found(planted) -> None:
    law, people = planted
    found = law_of(NAMES, people)
    assert found.slopes == pytest.approx(law.slopes, abs=0.02)
    assert found.bends == pytest.approx(law.bends, abs=0.06)
    assert found.widenings == pytest.approx(law.widenings, abs=0.15)
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx(
        np.sqrt(np.diag(law.covariance)), rel=0.03
    )


@pytest.mark.parametrize("known", [(0, 1), (0, 1, 3), (0, 2, 4)])
def test_ranges_hold_four_of_five_at_every_index(planted, known) -> None:
    law, people = planted
    logs = np.log(people)
    rows = np.full_like(logs, np.nan)
    rows[:, known] = logs[:, known]
    means, covariances = law.given_rows(rows)
    deviations = np.sqrt(np.einsum("nii->ni", covariances))
    unknown = [i for i in range(5) if i not in known]
    inside = (np.abs(logs - means) < 1.2816 * deviations)[:, unknown]
    assert inside.mean(axis=0) == pytest.approx(0.8, abs=0.015)
    if 1 in known:
        index = people[:, 1] / people[:, 0] ** 2
        for part in np.array_split(np.argsort(index), 4):
            assert inside[part].mean(axis=0) == pytest.approx(0.8, abs=0.03)


def test_calibration_mends_tails_that_are_not_normal() -> None:
    random = np.random.default_rng(1)
    core = random.normal(size=(5000, 2)) * [0.04, 0.14] + np.log([1.7, 70])
    heavy = random.standard_t(3, size=(5000, 1)) * 0.02 + 0.4 * core[:, 1:] - 1.8
    people = np.exp(np.hstack([core, heavy]))
    names = NAMES[:3]
    law = calibrated(law_of(names, people), people)
    assert law.factors[2] < 0.9
    low, _, high = law.given(MeasurementSet({"stature": 1.7, "weight": 70})).range(names[2], 0.8)
    exact = np.log(high / low) / 2
    assert exact == pytest.approx(0.02 * 1.638, rel=0.05)  # the quantile of Student's law


def test_calibration_goes_with_the_index() -> None:
    random = np.random.default_rng(2)
    within = random.uniform(-0.5, 0.5, 8000)
    scores = np.abs(random.normal(size=(2, 8000, 2))) * 1.2
    scores[:, :, 1] *= np.exp(0.6 * within)
    scores[1, :, 0] = np.nan  # in the second subset the first measurement is known
    factors, slopes = _factors(scores, within, np.ones(8000))
    assert factors == pytest.approx([1.2, 1.2], rel=0.03)
    assert slopes == pytest.approx([0, 0.6], abs=0.06)
    law = replace(
        load_estimators()["female"].law, factors=np.full(41, 1.2), factor_slopes=np.full(41, 0.6)
    )
    means = np.repeat(law.means[None], 3, axis=0)
    means[:, 1] += [0, 0.1, 9]
    reached = [0, 0.1, law.reach[1]]
    assert law.calibration(means)[:, 5] == pytest.approx(1.2 * np.exp(0.6 * np.array(reached)))


def test_a_noisy_value_says_less() -> None:
    law = load_estimators()["female"].law
    known = MeasurementSet({"stature": 1.68, "waist_girth": 0.74})
    sure, unsure = law.given(known), law.given(known, {"waist_girth": 0.05})
    nothing = law.given(MeasurementSet({"stature": 1.68}))
    for name in ("abdomen_girth", "weight", "bust_girth"):
        assert sure.deviation(name) < unsure.deviation(name) < nothing.deviation(name)
    assert sure.range("waist_girth", 0.8)[1] == pytest.approx(0.74, rel=2e-3)


def test_a_wide_law_holds_heavy_people_possible() -> None:
    law = load_estimators()["male"].law
    known = MeasurementSet({"stature": 1.76})
    usual, wide = law.given(known), law.given(known, wide=True)
    assert abs(usual.score("weight", 150)) > 3.5
    assert abs(wide.score("weight", 150)) < 2.5


def test_every_measurement_has_a_noise() -> None:
    assert set(TAPE_NOISE) == set(MEASUREMENTS)
