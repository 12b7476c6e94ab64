"""Writes ``docs/paper.md``: the paper's choice, validation and evaluation, on our population."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from model.anthropometry import TAKEN
from model.geometry import Floats
from model.shape_basis import load_shape_basis
from model.template_mesh import load_template_mesh
from model.training.feature_selection import SELECTED, TABLE_4
from model.training.measurement_report import (
    EXACT,
    SELF,
    Evaluation,
    evaluate,
    evaluation_chapter,
    measurement_chapter,
)
from model.training.paper_models import (
    LINEAR,
    LINEAR_LETTER,
    PCA,
    PCA_DIVIDED,
    PCA_LETTER,
    PaperSpace,
)
from model.training.paper_validation import PAPER_TDE
from model.training.population import Population
from model.training.population_report import table
from model.training.selection_report import Choice, choose, selection_chapter
from model.training.shape_report import (
    MAPPED_SUBSETS,
    NOTHING,
    Trial,
    shape_chapter,
    try_models,
)
from model.training.survey import SEXES, Sex


def write_paper_report(
    population: Population, values: Floats, docs: Path, survey_rows: Path | None
) -> None:
    """Writes the document and its figures into the folder of documents.

    Parameters
    ----------
    values : ndarray of shape (n, m), what every body measures, SI, as `TAKEN`.
    survey_rows : folder of the survey's rows, for real people's errors, or None.
    """
    images = docs / "images"
    images.mkdir(parents=True, exist_ok=True)
    written = f"`make report`; population of {population.date}, seed {population.seed}."
    space = PaperSpace.of(load_shape_basis(), load_template_mesh())
    choices = choose(population, values)
    selections = {sex: choice.selection for sex, choice in choices.items()}
    trials = {sex: try_models(space, population, values, selections, sex) for sex in SEXES}
    evaluation = evaluate(space, trials, population.seed, survey_rows)
    text = "\n\n".join(
        [
            "# The paper, reproduced",
            "*Estimating Body Shapes From Body Measurements*, its sections 4.1 and 5, on the "
            "open population instead of SPRING. Written by `make report`; do not edit. "
            f"Population of {population.date}, seed {population.seed}; "
            f"{int((~population.held_out).sum())} bodies learned from, "
            f"{int(population.held_out.sum())} held out.",
            "## What the paper found, and what we find",
            findings(space, choices, trials, evaluation),
            selection_chapter(choices, images, written, survey_rows),
            shape_chapter(space, trials, population, values, images, written),
            measurement_chapter(space, trials),
            evaluation_chapter(evaluation),
        ]
    )
    (docs / "paper.md").write_text(text + "\n", encoding="utf-8")
    print(f"wrote {docs / 'paper.md'}")


def findings(
    space: PaperSpace,
    choices: Mapping[Sex, Choice],
    trials: Mapping[Sex, Trial],
    evaluation: Evaluation,
) -> str:
    """The paper's statements beside our numbers, as a Markdown table."""
    same = [
        f"{sex} {len(set(choices[sex].selection.selected) & set(TABLE_4[sex]))} of {SELECTED}"
        for sex in SEXES
    ]
    alike = set.intersection(*(set(choices[sex].selection.selected) for sex in SEXES))
    rows = [
        [
            "Seven measurements are chosen for each sex, six of them alike (Table 4).",
            f"Of its seven we choose: {', '.join(same)}; {len(alike)} of ours are alike. The "
            "criterion is weak; see below.",
        ],
        [
            "More measurements often give better bodies (5.1.1).",
            "Yes. Top 2 to top 10, mean vertex distance: "
            + _each(
                trials,
                lambda trial: (
                    " to ".join(
                        f"{_mean(trial, LINEAR_LETTER, name):.0f}" for name in ("top 2", "top 10")
                    )
                    + " mm"
                ),
            )
            + ".",
        ],
        [
            "Without height among what is given, the whole body is scaled ((1b), (1c)).",
            "Yes, and the missing constant term is why. From the top 4 the lightest and the "
            "heaviest tenth of the bodies become, on average, taller than they are by "
            + _each(trials, lambda trial: _taller(space, trial, LINEAR_LETTER))
            + "; with a constant by "
            + _each(trials, lambda trial: _taller(space, trial, LINEAR))
            + ".",
        ],
        [
            "The eighth to tenth measurement change almost nothing: the mean squared errors of "
            "(1d) and (1e) differ by 0.0002 (no unit; if m², 2 cm²).",
            "Top 8 and top 10 differ on our four bodies by at most "
            + _each(trials, lambda trial: f"{_squared_step(trial):.1f} cm²")
            + ".",
        ],
        [
            "The selected six and seven do worse than the top 8 on a large man's belly.",
            "The best of the seven subsets for our large bodies: "
            + _each(trials, lambda trial: f"{_best(trial)}")
            + ".",
        ],
        [
            "The PCA model cannot estimate realistic bodies (5.2).",
            "To the letter it cannot: from Table 4 its bodies are "
            + _each(
                trials,
                lambda trial: (
                    f"{_mean(trial, PCA_LETTER, 'Table 4'):.0f} mm off, the mean body "
                    f"{_mean(trial, LINEAR, NOTHING):.0f} and the linear model "
                    f"{_mean(trial, LINEAR_LETTER, 'Table 4'):.0f}"
                ),
            )
            + ". Its weights have mean zero, its measurements have not, and equation 4 has no "
            "constant to bridge that. With one, both models agree: "
            + _each(
                trials,
                lambda trial: (
                    f"{_mean(trial, PCA, 'Table 4'):.1f} and "
                    f"{_mean(trial, LINEAR, 'Table 4'):.1f} mm"
                ),
            )
            + ". If the weights also stay divided by their eigenvalues: "
            + _each(trials, lambda trial: f"{_mean(trial, PCA_DIVIDED, 'Table 4'):.0f} mm")
            + ".",
        ],
        [
            f"The sum of a person's errors is {min(PAPER_TDE) * 100:.0f} to "
            f"{max(PAPER_TDE) * 100:.0f} cm (5.4).",
            f"{_total(evaluation, EXACT)} if people measure what their bodies do; "
            f"{_total(evaluation, SELF)} if they err as people do who measure themselves "
            "(medians, and 95 %; linear model with a constant). An erring tape explains a part "
            "of the paper's sums.",
        ],
    ]
    return table(["the paper", "here"], rows, numbers=False)


def _each(trials: Mapping[Sex, Trial], words: Callable[[Trial], str]) -> str:
    return "; ".join(f"{sex} {words(trial)}" for sex, trial in trials.items())


def _mean(trial: Trial, model: str, subset: str) -> float:
    """The mean vertex distance in mm."""
    return float(trial.errors[model, subset].mean.mean() * 1e3)


def _taller(space: PaperSpace, trial: Trial, model: str) -> str:
    """How much taller the lightest and the heaviest tenth become from the top 4."""
    by_weight = np.argsort(trial.values[:, TAKEN.index("weight")])
    tenth = max(len(by_weight) // 10, 1)
    light, heavy = (
        np.ptp(space.vertices(trial.estimate(model, "top 4", rows))[:, :, 1], axis=1).mean()
        - trial.values[rows, TAKEN.index("stature")].mean()
        for rows in (by_weight[:tenth], by_weight[-tenth:])
    )
    return f"{light * 100:+.0f} and {heavy * 100:+.0f} cm"


def _squared_step(trial: Trial) -> float:
    """The most that top 8 and top 10 differ by in mean squared error, cm²."""
    eight, ten = (trial.errors[LINEAR_LETTER, name].squared for name in ("top 8", "top 10"))
    return float(np.abs(eight - ten)[trial.ends].max()) * 1e4


def _best(trial: Trial) -> str:
    """The subset that comes nearest to the large body, to the letter."""
    names = list(trial.subsets)[:MAPPED_SUBSETS]
    errors = [trial.errors[LINEAR_LETTER, name].squared[trial.ends[1]] for name in names]
    return names[int(np.argmin(errors))]


def _total(evaluation: Evaluation, words: str) -> str:
    totals = np.concatenate([found.total for found in evaluation[LINEAR, words].values()]) * 100
    return f"{np.median(totals):.0f} cm ({np.quantile(totals, 0.95):.0f})"
