"""How each measurement is spread: means, deviations and ranges, of the survey and the population.

The survey's where ANSUR II has a measurement as a column, or as the difference of two (see
`Measurement.survey_columns`); of its people without those kept for tests.
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model.anthropometry import TAKEN
from model.geometry import Floats
from model.measurements import MEASUREMENTS
from model.template_mesh import DATA
from model.training.population import Population
from model.training.survey import SEXES, Sex, is_test_person

SURVEY_MEASUREMENTS_FILE = DATA / "survey" / "ansur2_measurements.csv"


@dataclass(frozen=True)
class Spread:
    """How a measurement is spread over people or bodies; SI units.

    count : of people or bodies
    mean, deviation : of their values
    low, high : the smallest and the largest
    """

    count: int
    mean: float
    deviation: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Floats, weights: Floats | None = None) -> "Spread":
        """Of values (n,), where given with weights (n,) for the mean and the deviation."""
        shares = np.full(len(values), 1 / len(values)) if weights is None else weights
        shares = shares / shares.sum()
        mean = float(shares @ values)
        deviation = float(np.sqrt(shares @ (values - mean) ** 2))
        return cls(len(values), mean, deviation, float(values.min()), float(values.max()))


def write_survey_measurements(folder: Path, target: Path = SURVEY_MEASUREMENTS_FILE) -> int:
    """Computes the table from the survey's rows; returns how many lines it has."""
    lines = []
    for sex in SEXES:
        with (folder / f"{sex}_half_a.csv").open(encoding="utf-8", newline="") as file:
            people = [row for row in csv.DictReader(file) if not is_test_person(row["subjectid"])]
        for name, row in MEASUREMENTS.items():
            if not row.survey_columns:
                continue
            scale = 0.1 if row.kind == "mass" else 1e-3
            first, *less = (
                np.array([float(person[column]) for person in people]) * scale
                for column in row.survey_columns
            )
            spread = Spread.of(first - sum(less))
            numbers = (spread.mean, spread.deviation, spread.low, spread.high)
            lines.append([sex, name, spread.count, *(f"{number:.6f}" for number in numbers)])
    with target.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["sex", "measurement", "people", "mean", "deviation", "low", "high"])
        writer.writerows(lines)
    return len(lines)


def load_survey_measurements(
    path: Path = SURVEY_MEASUREMENTS_FILE,
) -> Mapping[tuple[Sex, str], Spread]:
    """The shipped table, by sex and measurement."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {
        (sex, row["measurement"]): Spread(
            int(row["people"]), *(float(row[key]) for key in ("mean", "deviation", "low", "high"))
        )
        for row in rows
        for sex in SEXES
        if sex == row["sex"]
    }


def write_spreads(population: Population, values: Floats, path: Path) -> None:
    """Writes how the bodies of the population are spread.

    Parameters
    ----------
    values : ndarray of shape (n, M), what each body measures, SI, in the order of `TAKEN`.
    """
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        head = ["sex", "measurement", "bodies", "mean", "deviation", "low", "high"]
        writer.writerow([*head, "weighted_mean", "weighted_deviation"])
        for sex in SEXES:
            mine = population.of(sex)
            weights = np.exp(population.log_odds[mine])
            for column, name in enumerate(TAKEN):
                plain = Spread.of(values[mine, column])
                weighted = Spread.of(values[mine, column], weights)
                numbers = [plain.mean, plain.deviation, plain.low, plain.high]
                numbers += [weighted.mean, weighted.deviation]
                writer.writerow([sex, name, plain.count, *(f"{n:.5f}" for n in numbers)])


def load_spreads(path: Path) -> Mapping[tuple[Sex, str], Spread]:
    """The written table, by sex and measurement: weighted back to the survey.

    Counts and ranges are of the bodies as they are.
    """
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    keys = ("weighted_mean", "weighted_deviation", "low", "high")
    return {
        (sex, row["measurement"]): Spread(int(row["bodies"]), *(float(row[key]) for key in keys))
        for row in rows
        for sex in SEXES
        if sex == row["sex"]
    }
