import csv

import numpy as np
import pytest

from model.anthropometry import TAKEN
from model.measurements import MEASUREMENTS
from model.training.population import load_population
from model.training.spreads import (
    Spread,
    load_spreads,
    load_survey_measurements,
    write_spreads,
    write_survey_measurements,
)
from model.training.survey import SEXES, is_test_person, load_statistics


def test_a_spread_without_weights():
    assert Spread.of(np.array([1.0, 3.0])) == Spread(2, 2.0, 1.0, 1.0, 3.0)


def test_weights_count_for_the_mean_and_the_deviation_but_not_for_the_range():
    assert Spread.of(np.array([1.0, 3.0, 9.0]), np.array([5.0, 5.0, 0.0])) == Spread(
        3, 2.0, 1.0, 1.0, 9.0
    )


def test_the_survey_is_read_from_its_rows_without_the_people_kept_for_tests(tmp_path):
    columns = {column for row in MEASUREMENTS.values() for column in row.survey_columns}
    seen = [str(n) for n in range(1000, 1100) if not is_test_person(str(n))][:2]
    kept = next(str(n) for n in range(1000, 1100) if is_test_person(str(n)))
    for sex in SEXES:
        with (tmp_path / f"{sex}_half_a.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, ["subjectid", *sorted(columns)])
            writer.writeheader()
            for subject, value in ((seen[0], 800), (seen[1], 900), (kept, 5000)):
                people = dict.fromkeys(columns, value) | {"lateralmalleolusheight": 60}
                writer.writerow(people | {"subjectid": subject})
    target = tmp_path / "written.csv"
    assert write_survey_measurements(tmp_path, target) == 2 * 27
    table = load_survey_measurements(target)
    assert table["female", "weight"].mean == pytest.approx(85.0)
    inseam = table["male", "inseam_height"]
    assert (inseam.count, inseam.low, inseam.high) == (2, 0.74, 0.84)
    assert inseam.mean == pytest.approx(0.79)


def test_the_shipped_table_agrees_with_the_shipped_statistics():
    """Two ways to one number: columns of the survey stand in both."""
    table = load_survey_measurements()
    for sex in SEXES:
        statistics = load_statistics(sex)
        for name, row in MEASUREMENTS.items():
            if row.ansur2 in statistics.columns:
                place = statistics.columns.index(row.ansur2)
                theirs = np.exp(statistics.means[place] + statistics.deviations[place] ** 2 / 2)
                assert table[sex, name].mean == pytest.approx(theirs, rel=2e-3)
                assert table[sex, name].count == statistics.people


def test_spreads_of_the_population_come_back_as_written(tmp_path):
    population = load_population()
    values = np.random.default_rng(7).uniform(1, 2, (len(population.sexes), len(TAKEN)))
    write_spreads(population, values, tmp_path / "spreads.csv")
    spreads = load_spreads(tmp_path / "spreads.csv")
    assert set(spreads) == {(sex, name) for sex in SEXES for name in TAKEN}
    women = population.of("female")
    last = spreads["female", TAKEN[-1]]
    assert last.count == women.sum()
    assert last.high == pytest.approx(values[women, -1].max(), abs=1e-5)
    weights = np.exp(population.log_odds[women])
    assert last.mean == pytest.approx(np.average(values[women, -1], weights=weights), abs=1e-5)
