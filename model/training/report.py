"""Writes the population's, the paper's and the validation's page of docs/, with fixed seeds."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from model.anthropometry import TAKEN
from model.estimators import load_estimators
from model.geometry import Floats
from model.measurements import MEASUREMENTS
from model.training.fit_report import band_heads
from model.training.paper_report import write_paper_report
from model.training.people_report import people_sections
from model.training.population import Population, load_population
from model.training.population_report import table, write_population_report
from model.training.smoothness import smoothness_section
from model.training.steadiness import steadiness_section
from model.training.survey import FROM_SURVEY, INDEX_BANDS, SEXES
from model.training.train import measure_population
from model.training.validation import (
    ENTERED,
    Errors,
    errors_on_bodies,
    errors_on_people,
    held_out_values,
    real_people,
)

DOCS = Path("docs")


def write_report(survey_rows: Path | None) -> None:
    """Writes all three documents; the errors on real people need the survey's rows."""
    population = load_population()
    write_population_report(population, DOCS)
    measured = measure_population(population)
    write_paper_report(population, measured, DOCS, survey_rows)
    text = _validation(population, measured, survey_rows)
    (DOCS / "validation.md").write_text(text + "\n", encoding="utf-8")
    print(text)
    print(f"wrote {DOCS / 'validation.md'}")


def _validation(population: Population, measured: Floats, survey_rows: Path | None) -> str:
    pieces = [
        "# Validation",
        f"Written by `make report`; do not edit. Population of {population.date}, seed "
        f"{population.seed}. The estimators are the shipped ones, which saw none of these "
        "bodies and people.",
        "The linear estimate (the paper's section 4.5) bends no body to the tape: what it "
        "misses of the entered values is what the tape fit closes (`model/tape_fit.py`).",
        people_sections(population, measured, survey_rows),
        "## The linear estimate on held-out bodies of the population",
        _held_out(population),
    ]
    if survey_rows is None:
        pieces.append(
            "Errors on real people: not computed, the survey's rows were not given "
            '(`make report ARGS="--survey-rows FOLDER"`).'
        )
    else:
        pieces += ["## The linear estimate on real people", _real(survey_rows, population.seed)]
    pieces += ["## Smoothness", smoothness_section(population, DOCS)]
    pieces += ["## Steadiness", steadiness_section(population)]
    return "\n\n".join(pieces)


def _held_out(population: Population) -> str:
    pieces, by_name, by_band = [], [], []
    for kind, estimator in load_estimators().items():
        vertices, values = held_out_values(population, kind)
        index = values["weight"] / values["stature"] ** 2
        for words, entered in ENTERED.items():
            errors = errors_on_bodies(estimator, vertices, values, entered)
            pieces.append(_summary_row(kind, words, entered, errors))
            if entered is TAKEN:
                by_name += [_name_row(kind, name, errors.misses[name]) for name in TAKEN]
                by_band.append([kind, *_bands(errors, index)])
    count = int(population.held_out.sum())
    return "\n\n".join(
        [
            f"{count} bodies; of the neutral kind every second one of both sexes. *Sum* is the "
            "paper's total distance error (TDE): absolute misses of the entered lengths and "
            "girths added up, per body. Centimetres; mean vertex distance in millimetres.",
            table(_SUMMARY_HEAD, pieces),
            "With everything entered, by measurement, in mm (weight in kg):",
            table(["", "measurement", "bias", "mean error", "95 %", "largest"], by_name),
            "With everything entered, mean vertex distance (mm) by band of body-mass index:",
            table(["", *band_heads(INDEX_BANDS)], by_band),
        ]
    )


def _real(folder: Path, seed: int) -> str:
    pieces, by_name = [], []
    people = 0
    estimators = load_estimators()
    for sex in SEXES:
        estimator = estimators[sex]
        values = real_people(folder, sex, seed)
        people += len(values["stature"])
        for words, entered in ENTERED.items():
            known = [name for name in entered if name in FROM_SURVEY]
            errors = errors_on_people(estimator, values, entered)
            pieces.append(_summary_row(sex, words, known, errors))
            if entered is TAKEN:
                by_name += [_name_row(sex, name, errors.misses[name]) for name in FROM_SURVEY]
    return "\n\n".join(
        [
            f"{people} people of ANSUR II (soldiers, 17 to 58 years, few very heavy), none of "
            "whom is in the statistics that the population was drawn from. They have no waist "
            "at its narrowest and no mid thigh, so these are left out where the set names them.",
            table(_SUMMARY_HEAD, pieces),
            "With everything that they have entered, in mm (weight in kg):",
            table(["", "measurement", "bias", "mean error", "95 %", "largest"], by_name),
        ]
    )


_SUMMARY_HEAD = [
    "",
    "entered",
    "sum, mean",
    "sum, 95 %",
    "entered, largest miss",
    "not entered, mean error",
    "vertices, mean (mm)",
]


def _summary_row(kind: str, words: str, entered: Sequence[str], errors: Errors) -> list[str]:
    names = list(errors.misses)
    inside = [name for name in names if name in entered]
    outside = [n for n in names if n not in inside and MEASUREMENTS[n].kind != "mass"]
    sums = errors.lengths(inside).sum(axis=1) * 100
    largest = errors.lengths(inside).max() * 100
    others = f"{errors.lengths(outside).mean() * 100:.2f}" if outside else ""
    mesh = f"{errors.vertices.mean() * 1e3:.1f}" if errors.vertices.size else ""
    return [
        kind,
        words,
        f"{sums.mean():.2f}",
        f"{np.quantile(sums, 0.95):.2f}",
        f"{largest:.2f}",
        others,
        mesh,
    ]


def _name_row(kind: str, name: str, misses: Floats) -> list[str]:
    scaled = misses * (1.0 if name == "weight" else 1e3)
    size = np.abs(scaled)
    numbers = [scaled.mean(), size.mean(), np.quantile(size, 0.95), size.max()]
    return [kind, f"`{name}`", *[f"{number:.1f}" for number in numbers]]


def _bands(errors: Errors, index: Floats) -> list[str]:
    cells = []
    for low, high in pairwise(INDEX_BANDS):
        mine = errors.vertices[(index >= low) & (index < high)]
        cells.append(f"{mine.mean() * 1e3:.1f} ({len(mine)})" if len(mine) else "none")
    return cells
