from pathlib import Path

import numpy as np
import pytest

from model.anthropometry import read_tapes
from model.template_mesh import load_template_mesh
from model.training.survey import (
    BODY_MASS_INDEX,
    SEXES,
    SURVEY_TAPES,
    draw_people,
    is_test_person,
    load_statistics,
    read_people,
)

ROWS = Path(__file__).parents[2] / "shared" / "data" / "ansur2"


@pytest.mark.parametrize("sex", SEXES)
def test_the_statistics_are_those_of_the_tapes(sex) -> None:
    statistics = load_statistics(sex)
    assert statistics.columns == tuple(SURVEY_TAPES)
    assert np.diag(statistics.correlations) == pytest.approx(1)
    assert statistics.correlations == pytest.approx(statistics.correlations.T)
    assert np.linalg.eigvalsh(statistics.covariance()).min() > 0
    assert 1.5 < np.exp(statistics.means[0]) < 1.9


@pytest.mark.parametrize("sex", SEXES)
def test_a_draw_weighted_back_is_the_survey(sex) -> None:
    statistics = load_statistics(sex)
    people = draw_people(statistics, 40_000, np.random.default_rng(0))
    logs, weights = np.log(people.values), np.exp(people.log_odds)
    weights /= weights.sum()
    mean = weights @ logs
    assert mean == pytest.approx(statistics.means, abs=0.01)
    deviation = np.sqrt(weights @ (logs - mean) ** 2)
    assert deviation == pytest.approx(statistics.deviations, rel=0.06)
    covariance = (logs - mean).T @ ((logs - mean) * weights[:, None])
    correlations = covariance / np.outer(deviation, deviation)
    assert np.abs(correlations - statistics.correlations).max() < 0.07


@pytest.mark.parametrize("sex", SEXES)
def test_a_draw_reaches_from_thin_to_heavy(sex) -> None:
    people = draw_people(load_statistics(sex), 5000, np.random.default_rng(0))
    index = people.values[:, 1] / people.values[:, 0] ** 2
    assert index.min() >= BODY_MASS_INDEX[0] - 1e-9
    assert index.max() <= BODY_MASS_INDEX[1] + 1e-9
    assert (index < 18.5).mean() > 0.05
    assert (index > 40).mean() > 0.08


def test_the_same_seed_draws_the_same_people() -> None:
    draws = [draw_people(load_statistics("male"), 10, np.random.default_rng(3)) for _ in range(2)]
    assert (draws[0].values == draws[1].values).all()


def test_the_templates_landmarks_have_the_surveys_proportions() -> None:
    """Heights over stature, of the mean body of both sexes, within a fiftieth of stature."""
    template = load_template_mesh()
    heights = [name for name in SURVEY_TAPES if name.endswith("height")]
    taken = read_tapes(template, template.vertices[None], [SURVEY_TAPES[n] for n in heights])[0]
    stature = np.ptp(template.vertices[:, 1])
    for name, value in zip(heights, taken, strict=True):
        place = list(SURVEY_TAPES).index(name)
        surveyed = [load_statistics(sex).means[[place, 0]] for sex in SEXES]
        ratio = np.mean([np.exp(height - stature_) for height, stature_ in surveyed])
        assert value / stature == pytest.approx(ratio, abs=0.02), name


def test_one_person_in_five_is_kept_for_tests() -> None:
    kept = sum(is_test_person(str(number)) for number in range(10_000, 20_000))
    assert 0.18 < kept / 10_000 < 0.22


@pytest.mark.skipif(not ROWS.exists(), reason=f"the survey's rows are not here ({ROWS})")
@pytest.mark.parametrize("sex", SEXES)
def test_the_statistics_are_the_rows_own_without_the_test_people(sex) -> None:
    subjects, values = read_people(ROWS / f"{sex}_half_a.csv")
    seen = [not is_test_person(subject) for subject in subjects]
    logs = np.log(values[seen])
    statistics = load_statistics(sex)
    assert statistics.people == len(logs)
    assert statistics.means == pytest.approx(logs.mean(axis=0), abs=1e-6)
    assert statistics.deviations == pytest.approx(logs.std(axis=0, ddof=1), abs=1e-6)
    assert statistics.correlations == pytest.approx(np.corrcoef(logs.T), abs=1e-4)
