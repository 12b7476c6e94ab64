"""The paper's validation of measurements and its evaluation (5.1.2, 5.4): part of docs/paper.md."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from model.anthropometry import TAKEN
from model.geometry import Floats
from model.measurements import MEASUREMENTS
from model.training.paper_models import LINEAR, LINEAR_LETTER, PCA_LETTER, PaperSpace
from model.training.paper_validation import (
    PAPER_TDE,
    SELF_MEASURED,
    PeopleErrors,
    evaluated,
    misses,
    people_errors,
)
from model.training.population_report import table
from model.training.shape_report import MAPPED_SUBSETS, Trial
from model.training.survey import FROM_SURVEY, SEXES, Sex
from model.training.validation import real_people

WOMEN, MEN = 5, 1
"""The paper's six people (5.2)."""

MEASURED = 40
"""So many held-out bodies of each sex are estimated from every subset and measured."""

EVALUATED = 100
"""So many of each sex are the people of the evaluation."""

REAL = "real people's values"
EXACT, SELF = "as the body measures", "as people read themselves"
READINGS: Mapping[str, float] = {EXACT: 0.0, "as an expert reads": 1.0, SELF: SELF_MEASURED}
"""What is entered: deviations as multiples of an expert's allowed difference."""

PAPER_LARGEST = {"abdomen_girth": 0.31, "inseam_height": 0.12, "bust_girth": 0.05}
"""The largest errors that the paper names (5.4), metres."""

EVALUATED_MODELS = (LINEAR_LETTER, PCA_LETTER, LINEAR)

Evaluation = Mapping[tuple[str, str], Mapping[Sex, PeopleErrors]]
"""By model and what was entered, then by sex."""


def measurement_chapter(space: PaperSpace, trials: Mapping[Sex, Trial]) -> str:
    """The validation of measurements (5.1.2) as Markdown."""
    names = list(next(iter(trials.values())).subsets)[: MAPPED_SUBSETS + 2]
    summary, pieces = [], []
    for sex, trial in trials.items():
        by_name = {}
        for model in EVALUATED_MODELS:
            cells = []
            for name in names:
                missed = _missed(space, trial, model, name)
                cells.append(_given_and_others(missed, trial, name))
                if model == LINEAR:
                    by_name[name] = missed.mean(axis=0)
            summary.append([sex, model, *cells])
        pieces.append(_every_measurement(sex, trial, by_name))
    return "\n\n".join(
        [
            "## Validation: body measurements",
            f"{MEASURED} held-out bodies of each sex, estimated and measured again. In mm the "
            "mean error of the lengths and girths that were given, in cm the largest one, in mm "
            "the mean error of those that were not given.",
            table(["", "mean · largest · others", *names], summary),
            "Mean absolute errors by measurement; bold where it was given.",
            *pieces,
        ]
    )


def _missed(space: PaperSpace, trial: Trial, model: str, subset: str) -> Floats:
    """Absolute misses of some of the held-out bodies: (n, m), SI, as `TAKEN`."""
    rows = np.unique(np.linspace(0, len(trial.values) - 1, MEASURED).astype(np.int64))
    return np.abs(misses(space, trial.estimate(model, subset, rows), trial.values[rows]))


def _given_and_others(missed: Floats, trial: Trial, subset: str) -> str:
    lengths = [i for i, name in enumerate(TAKEN) if MEASUREMENTS[name].kind != "mass"]
    inside = [i for i in lengths if TAKEN[i] in trial.subsets[subset]]
    others = missed[:, [i for i in lengths if i not in inside]]
    return (
        f"{missed[:, inside].mean() * 1e3:.1f} · {missed[:, inside].max() * 100:.1f} · "
        f"{others.mean() * 1e3:.1f}"
    )


def _every_measurement(sex: Sex, trial: Trial, by_name: Mapping[str, Floats]) -> str:
    rows = []
    for i, name in enumerate(TAKEN):
        scale = 1.0 if MEASUREMENTS[name].kind == "mass" else 1e3
        cells = []
        for subset, errors in by_name.items():
            words = f"{errors[i] * scale:.1f}"
            cells.append(f"**{words}**" if name in trial.subsets[subset] else words)
        rows.append([f"`{name}`", *cells])
    summary = f"{sex.capitalize()}, linear with a constant: every measurement"
    head = ["mm (weight in kg)", *by_name]
    return f"<details><summary>{summary}</summary>\n\n{table(head, rows)}\n\n</details>"


def evaluate(
    space: PaperSpace, trials: Mapping[Sex, Trial], seed: int, survey_rows: Path | None
) -> Evaluation:
    """Estimates the evaluation's people with each model, from each way of reading a tape.

    Parameters
    ----------
    survey_rows : folder of the survey's rows, for real people too, or None.
    """
    random = np.random.default_rng(seed)
    people = {
        sex: trials[sex].values[np.sort(random.permutation(len(trials[sex].values))[:EVALUATED])]
        for sex in SEXES
    }
    groups = [(words, people, tape) for words, tape in READINGS.items()]
    if survey_rows is not None:
        real = {sex: real_values(survey_rows, sex, seed) for sex in SEXES}
        groups.append((REAL, real, 0.0))
    return {
        (model, words): {
            sex: people_errors(
                space, trials[sex].models[model], group[sex], sex, tape=tape, seed=seed
            )
            for sex in SEXES
        }
        for model in EVALUATED_MODELS
        for words, group, tape in groups
    }


def real_values(folder: Path, sex: Sex, seed: int) -> Floats:
    """What real people kept for tests measure: (n, m), SI, as `TAKEN`; NaN not known."""
    known = real_people(folder, sex, seed)
    values = np.full((len(known["stature"]), len(TAKEN)), np.nan)
    for name in FROM_SURVEY:
        values[:, TAKEN.index(name)] = known[name]
    return values


def evaluation_chapter(evaluation: Evaluation) -> str:
    """The evaluation (5.4) as Markdown."""
    rows = [["paper, linear", "six people's own", *_cells(np.array(PAPER_TDE)), "", "", ""]]
    rows += [[*key, *_total_cells(errors)] for key, errors in evaluation.items()]
    six = [f"P{i + 1}" for i in range(len(PAPER_TDE))]
    largest = [
        [f"`{name}`", f"{paper * 100:.0f}"]
        + [
            f"{_largest(evaluation[model, words], name) * 100:.1f}"
            for model in (LINEAR_LETTER, LINEAR)
            for words in (EXACT, SELF)
        ]
        for name, paper in PAPER_LARGEST.items()
    ]
    ways = [f"{model}, {words}" for model in (LINEAR_LETTER, LINEAR) for words in (EXACT, SELF)]
    has_real = any(words == REAL for _, words in evaluation)
    return "\n\n".join(
        [
            "## Evaluation: the sum of errors per person",
            "Total distance error (TDE): the absolute differences between what a person "
            "entered and what the estimated body measures, added up, in cm. As in the paper, "
            f"eight values are given and ten summed. {_asked()} P1 to P6 are five women and a "
            f"man, taken at random; the last columns are of {EVALUATED} women and {EVALUATED} "
            "men.",
            table(["model", "entered", *six, "median", "95 %", "largest"], rows),
            _reading_words(real=has_real),
            "The largest errors that the paper names, in cm, and ours over the same people:",
            table(["", "paper", *ways], largest),
        ]
    )


def _asked() -> str:
    pieces = []
    for sex in SEXES:
        entered, summed = evaluated(sex)
        asked = ", ".join(f"`{name}`" for name in entered)
        more = ", ".join(f"`{name}`" for name in summed if name not in entered)
        pieces.append(f"{sex.capitalize()}: {asked}; summed too: {more}.")
    return " ".join(pieces)


def _total_cells(errors: Mapping[Sex, PeopleErrors]) -> list[str]:
    six = np.concatenate([errors["female"].total[:WOMEN], errors["male"].total[:MEN]])
    everyone = np.concatenate([errors[sex].total for sex in SEXES])
    ends = [np.median(everyone), np.quantile(everyone, 0.95), everyone.max()]
    return _cells(np.concatenate([six, ends]))


def _cells(errors: Floats) -> list[str]:
    return [f"{error * 100:.1f}" for error in errors]


def _largest(errors: Mapping[Sex, PeopleErrors], name: str) -> float:
    return max(float(np.abs(found.missed[:, TAKEN.index(name)]).max()) for found in errors.values())


def _reading_words(*, real: bool) -> str:
    words = (
        "The paper's people measured themselves, and none of their values need agree with one "
        "another; ours are what a body does measure, in the other rows with an error of the "
        "tape added: normal, its deviation the difference that ANSUR II allows between two "
        "readings of an expert (waist and hips 12 mm, bust 15, stature 10), and four times "
        "that for people who measure themselves (± 48 mm at the waist in a study of 622 "
        "adults). "
    )
    if real:
        return words + (
            "*Real people* are of ANSUR II, nobody whom the population's statistics have "
            "seen. They have no narrowest waist, mid thigh, waist height or lengths over the "
            "skin, which are neither given nor summed for them."
        )
    return words + (
        "Real people: not computed, the survey's rows were not given. These people are drawn "
        "from its statistics, and their bodies are known."
    )
