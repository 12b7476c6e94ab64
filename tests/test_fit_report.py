import numpy as np
import pytest

from model.anthropometry import TAKEN
from model.estimators import load_estimators
from model.training.fit_report import (
    EIGHT,
    SEVEN,
    Fits,
    band_rows,
    coverage_rows,
    entered_row,
    fit_all,
    not_entered_rows,
    regression,
)
from model.training.law_report import (
    MIX_UPS,
    coverage_of,
    false_alarms,
    procedure_rows,
    recognised,
)
from model.training.survey import FROM_SURVEY, SEXES
from model.training.validation import most_telling, people_like_the_survey


@pytest.fixture(scope="module")
def planted() -> Fits:
    """Four people, whose bodies are off as planted; calf and thigh were not entered."""
    random = np.random.default_rng(0)
    true = random.uniform(0.5, 1.0, size=(4, len(TAKEN)))
    true[:, 0], true[:, 1] = [1.6, 1.7, 1.8, 1.9], [50, 65, 85, 120]
    values = {name: true[:, TAKEN.index(name)] for name in FROM_SURVEY}
    off = np.zeros_like(true)
    off[:, TAKEN.index("bust_girth")] = [0.0002, 0, 0, -0.002]
    off[:, TAKEN.index("calf_girth")] = [0.01, -0.01, 0.02, -0.02]
    low, high = true + off - 0.015, true + off + 0.015
    none = np.empty(0)
    return Fits(SEVEN, values, true + 0.05, true + off, low, high, none, none, np.full(4, 0.03))


def test_planted_errors_are_told(planted) -> None:
    row = entered_row("female", planted)
    assert row[3:] == ["30.00", "5.00", "0.55", "1.73", "2.00", "75.0 %", "30"]
    regressed = {"calf_girth": np.full(4, 0.03), "thigh_girth": np.full(4, 0.001)}
    calf, thigh = not_entered_rows("female", planted, regressed)
    assert calf == ["female", "`calf_girth`", "30.0", "50.0", "15.0", "0.50"]
    assert thigh[4:] == ["0.0", "0.00"]


def test_coverage_is_counted_by_band(planted) -> None:
    rows = {row[1]: row[2:] for row in coverage_rows("female", planted)}
    assert rows["`calf_girth`"][0] == "0.500"
    assert rows["`thigh_girth`"][0] == "1.000"
    assert not set(SEVEN) & {name.strip("`") for name in rows}
    # Indices 19.5, 22.5, 26.2 and 33.2.
    assert rows["`calf_girth`"][1:] == [
        "none", "1.00 (2)", "0.00 (1)", "0.00 (1)", "none", "none"
    ]  # fmt: skip
    entered, others = band_rows("female", planted, "stature")
    assert entered[2:] == ["none", "0.20 (1)", "0.00 (1)", "0.00 (1)", "2.00 (1)"]
    assert len(others) == len(entered)


def test_a_regression_finds_a_planted_law(planted) -> None:
    seen = people_like_the_survey("male", 50, 3)
    twice = {name: seen[name] for name in SEVEN}
    twice |= {n: 2 * seen["bust_girth"] - 0.1 for n in FROM_SURVEY if n not in SEVEN}
    for name, misses in regression(twice, planted).items():
        expected = 2 * planted.values["bust_girth"] - 0.1 - planted.values[name]
        assert misses == pytest.approx(expected, abs=1e-6)


def test_drawn_people_are_as_the_law_says() -> None:
    """Those of the survey's statistics, with the law that was learned from its people."""
    for sex in SEXES:
        estimator, people = load_estimators()[sex], people_like_the_survey(sex, 4000, 0)
        for share in coverage_of(estimator.law, people, ("stature", "weight")).values():
            assert share.mean() == pytest.approx(0.8, abs=0.045)


def test_people_who_take_turns_are_held_against_laws_that_did_not_see_them() -> None:
    people = np.stack(list(people_like_the_survey("female", 1000, 1).values()), axis=1)
    rows = procedure_rows(people, SEVEN)
    assert [row[0] for row in rows[:-1]] == [f"`{n}`" for n in FROM_SURVEY if n not in SEVEN]
    shares = [float(row[1]) for row in rows]
    assert shares == pytest.approx([0.8] * len(rows), abs=0.05)
    assert shares[-1] == pytest.approx(np.mean(shares[:-1]), abs=0.001)


def test_fits_and_doubts_of_a_few_people() -> None:
    estimator = load_estimators()["female"]
    people = {name: v[:3] for name, v in people_like_the_survey("female", 3, 1).items()}
    fits = fit_all(estimator, people, SEVEN)
    assert fits.met().all()
    assert (fits.low <= fits.taken).all()
    assert (fits.taken <= fits.high).all()
    assert fits.sums().max() < 0.005 < fits.sums(linear=True).max()
    assert set(false_alarms(estimator, people, EIGHT)) == set(EIGHT)
    shares = recognised(estimator, people)
    assert set(shares) == set(MIX_UPS)
    assert shares["pounds read as kilograms"] == (1, 1)


def test_the_most_telling_measurements_are_found() -> None:
    random = np.random.default_rng(5)
    names = ["waist_girth", "stature", "hip_girth", "arm_length", "weight"]
    values = random.normal(size=(300, 5))
    # The hips are the waist again; the arms tell most, then the waist.
    values[:, 2] = values[:, 0]
    surface = values @ np.array([[2.0, 0, 0], [0.5, 0.5, 0], [0, 0, 0], [0, 0, 5], [0, 0.1, 0]])
    found = most_telling(values, surface, names, 4)
    assert found[:2] == ["stature", "arm_length"]
    assert found[2] in {"waist_girth", "hip_girth"}
    assert found[3] == "weight"
