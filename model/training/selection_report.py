"""The paper's choice of seven measurements in words, tables and charts: part of docs/paper.md."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model.anthropometry import TAKEN
from model.geometry import Floats
from model.training.charts import Bar, bars, boxes, shades
from model.training.feature_selection import (
    DRAWS,
    ERROR_PRONE,
    PAPER_LEFT_OUT,
    SELECTED,
    TABLE_4,
    TOLD,
    TOP,
    Selection,
    Stability,
    candidates,
    scaled_variances,
    select,
    stability,
)
from model.training.paper_validation import learned_from
from model.training.population import Population
from model.training.population_report import table
from model.training.survey import SEXES, SURVEY_TAPES, Sex, is_test_person, read_people

NORMAL, EVEN = 1 / 36, 1 / 12
"""The variance, scaled to 0..1, of a normal law cut off and filled up at three deviations, and
of an even one."""


@dataclass(frozen=True, eq=False)
class Choice:
    """What was chosen for one sex, and how firmly.

    Attributes
    ----------
    selection : by the paper's steps.
    without_four : the seven where the paper's four girths are left out as well.
    drawn_anew : from as many people drawn from the population, with replacement.
    as_surveyed : the same, drawn so that stature and weight are as in the survey.
    """

    selection: Selection
    without_four: tuple[str, ...]
    drawn_anew: Stability
    as_surveyed: Stability


def choose(population: Population, values: Floats) -> dict[Sex, Choice]:
    """The choice for each sex, from bodies that estimators may learn from.

    Parameters
    ----------
    values : ndarray of shape (n, m), SI, as `TAKEN`.
    """
    names = candidates(TAKEN)
    columns = [TAKEN.index(name) for name in names]
    fewer = tuple(name for name in names if name not in PAPER_LEFT_OUT)
    choices: dict[Sex, Choice] = {}
    for sex in SEXES:
        rows = learned_from(population, sex)
        mine = values[rows][:, columns]
        seed = population.seed
        choices[sex] = Choice(
            selection=select(names, mine),
            without_four=select(fewer, mine[:, [names.index(name) for name in fewer]]).selected,
            drawn_anew=stability(names, mine, seed=seed),
            as_surveyed=stability(
                names, mine, seed=seed, weights=np.exp(population.log_odds[rows])
            ),
        )
    return choices


def selection_chapter(
    choices: Mapping[Sex, Choice], images: Path, written: str, survey_rows: Path | None
) -> str:
    """The chapter as Markdown; writes its charts into the folder of images.

    Parameters
    ----------
    written : by what, when and from what, to stand below each chart.
    survey_rows : folder of the survey's rows, to look at its own people too, or None.
    """
    selections = {sex: choice.selection for sex, choice in choices.items()}
    _charts(selections, images)
    count = len(next(iter(selections.values())).names)
    pieces = [
        "## Feature selection",
        f"Of {count} measurements taken with a tape (weight is not in the paper) seven are chosen "
        "for each sex by the steps of 4.1.1, from the bodies that estimators learn from.",
        "### 1. Outliers",
        _outlier_words(selections),
        _picture("outliers", "Outliers of each measurement", written),
        "### 2. Scaling and variance",
        "Each measurement is scaled so that its values, outliers aside, go from 0 to 1, and "
        "the measurements are sorted by variance.",
        _picture("scaled", "The scaled measurements", written),
        _picture("variances", "Variance of the scaled measurements", written),
        f"What this measures is how evenly people fill the range: a normal law reaching to three "
        f"deviations on both sides has a variance of {NORMAL:.3f} whatever its width, an even "
        f"one {EVEN:.3f}. A measurement ranks high by a flat or lopsided law, not by being more "
        "telling.",
        *[_variance_table(sex, selections[sex]) for sex in SEXES],
        "### 3. The ten that vary most, and which tell each other",
        _pruning_words(selections),
        *[_picture(f"correlations_{sex}", f"Correlations, {sex}", written) for sex in SEXES],
        *[_top_table(sex, selections[sex]) for sex in SEXES],
        "### 4. Seven, beside the paper's Table 4",
        *[_seven_table(sex, choices[sex]) for sex in SEXES],
        _why(choices),
    ]
    if survey_rows is not None:
        pieces.append(survey_words(survey_rows))
    return "\n\n".join(pieces)


def _picture(name: str, words: str, written: str) -> str:
    return f"![{words}](images/paper_{name}.svg)\n\n*{words}. {written}*"


def _charts(selections: Mapping[Sex, Selection], images: Path) -> None:
    outliers: dict[str, list[Bar]] = {}
    variances: dict[str, list[Bar]] = {}
    scaled: dict[str, dict[str, Floats]] = {}
    for sex, selection in selections.items():
        by_outliers = np.argsort(-selection.outliers, kind="stable")
        outliers[sex] = [
            Bar(
                selection.names[i],
                float(selection.outliers[i]),
                str(selection.outliers[i]),
                selection.names[i] in selection.error_prone,
            )
            for i in by_outliers
        ]
        by_variance = np.argsort(-selection.variances, kind="stable")
        scaled[sex] = {selection.names[i]: selection.scaled[:, i] for i in by_variance}
        variances[sex] = [
            Bar(
                selection.names[i],
                float(selection.variances[i]),
                f"{selection.variances[i]:.4f}",
                selection.names[i] in selection.top,
            )
            for i in by_variance
        ]
        drawn = shades(selection.judged, selection.correlations, title=f"Correlations, {sex}")
        _write(images / f"paper_correlations_{sex}.svg", drawn)
    note = f"Bodies beyond mean ± 3 deviations. Dark: more than {ERROR_PRONE:.0%}, left out."
    _write(images / "paper_outliers.svg", bars(outliers, note=note))
    note = "Box: the middle half of the bodies, and the median; line: nine tenths of them."
    _write(images / "paper_scaled.svg", boxes(scaled, note=note))
    _write(images / "paper_variances.svg", bars(variances, note=f"Dark: the top {TOP}."))


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _names(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "none"


def _outlier_words(selections: Mapping[Sex, Selection]) -> str:
    pieces = []
    for sex, selection in selections.items():
        worst = [selection.names[i] for i in np.argsort(-selection.outliers, kind="stable")[:4]]
        four = [
            f"`{name}` {selection.outliers[selection.names.index(name)]}"
            for name in PAPER_LEFT_OUT
            if name in selection.names
        ]
        pieces.append(
            f"- {sex}: {selection.outliers.sum()} values in all; most in {_names(worst)}; in "
            f"the four that the paper leaves out: {', '.join(four)}. Left out here: "
            f"{_names(selection.error_prone)}."
        )
    return (
        "Values beyond mean ± 3 standard deviations become missing. The paper finds most in "
        "girths and leaves out four of them as prone to error, without a rule; ours is more than "
        f"{ERROR_PRONE:.0%} of the bodies (a normal law has 0.27 %).\n\n" + "\n".join(pieces)
    )


def _variance_table(sex: Sex, selection: Selection) -> str:
    rows = []
    for rank, i in enumerate(np.argsort(-selection.variances, kind="stable"), 1):
        rows.append(
            [
                str(rank),
                f"`{selection.names[i]}`",
                f"{selection.outliers[i]}",
                f"{selection.low[i] * 100:.1f}",
                f"{selection.high[i] * 100:.1f}",
                f"{selection.variances[i]:.4f}",
            ]
        )
    head = ["", "measurement", "outliers", "0 is (cm)", "1 is (cm)", "variance"]
    return (
        f"<details><summary>{sex.capitalize()}: all measurements by variance</summary>\n\n"
        + table(head, rows)
        + "\n\n</details>"
    )


def _pruning_words(selections: Mapping[Sex, Selection]) -> str:
    pieces = []
    for sex, selection in selections.items():
        told = [
            f"`{name}` by `{teller}` ({selection.correlation(name, teller):.2f})"
            for name, teller in selection.told.items()
        ]
        pieces.append(f"- {sex}: {'; '.join(told) or 'none'}. {_uniform(selection)}")
    return (
        "The paper drops every height but stature as told by it, and two lengths as told by "
        "the neck's girth; it keeps six girths, however alike. So do we: heights give way to "
        f"stature, lengths to a girth, where it tells at least {TOLD:.0%} of their variance (a "
        f"correlation of {np.sqrt(TOLD):.2f}); girths never give way. Dropped:\n\n"
        + "\n".join(pieces)
    )


def _uniform(selection: Selection) -> str:
    """What the same threshold would leave if it held for girths too."""
    kept: list[str] = []
    for name in selection.top:
        if all(selection.correlation(name, other) ** 2 < TOLD for other in kept):
            kept.append(name)
    return f"If the same held for girths too, only {_names(kept)} would be left."


def _top_table(sex: Sex, selection: Selection) -> str:
    rows = []
    for rank, name in enumerate(selection.top, 1):
        others = [other for other in selection.top if other != name]
        nearest = max(others, key=lambda other: abs(selection.correlation(name, other)))
        fate = "kept" if name in selection.selected else "beyond the seven"
        if name in selection.told:
            fate = f"told by `{selection.told[name]}`"
        variance = selection.variances[selection.names.index(name)]
        words = f"`{nearest}` {selection.correlation(name, nearest):.2f}"
        rows.append([str(rank), f"`{name}`", f"{variance:.4f}", words, fate])
    head = [sex, "measurement", "variance", "most like", ""]
    return table(head, rows)


def _seven_table(sex: Sex, choice: Choice) -> str:
    def share(shares: Mapping[str, float], name: str) -> str:
        return f"{shares[name]:.0%}" if name in shares else "not taken"

    theirs, ours = TABLE_4[sex], choice.selection.selected
    surveyed = choice.as_surveyed.selected
    usual = sorted(surveyed, key=lambda name: -surveyed[name])[:SELECTED]
    rows = [
        [
            str(rank + 1),
            f"`{theirs[rank]}`" + (" ✓" if theirs[rank] in ours else ""),
            f"`{ours[rank]}`" + (" ✓" if ours[rank] in theirs else ""),
            share(choice.drawn_anew.selected, ours[rank]),
            f"`{choice.without_four[rank]}`",
            f"`{usual[rank]}`",
            share(surveyed, usual[rank]),
        ]
        for rank in range(SELECTED)
    ]
    head = [sex, "paper", "ours", "drawn anew", "paper's four left out", "as surveyed", "of draws"]
    return table(head, rows)


def _why(choices: Mapping[Sex, Choice]) -> str:
    pieces = []
    for sex, choice in choices.items():
        ours, theirs = choice.selection.selected, TABLE_4[sex]
        ranks = [
            choice.selection.names[i]
            for i in np.argsort(-choice.selection.variances, kind="stable")
        ]
        missing = [
            f"`{name}` (rank {ranks.index(name) + 1})"
            for name in theirs
            if name not in ours and name in ranks
        ]
        pieces.append(
            f"- {sex}: {len(set(ours) & set(theirs))} of the paper's seven. Not chosen here: "
            f"{', '.join(missing) or 'none'}. Chosen here only: "
            f"{_names(name for name in ours if name not in theirs)}."
        )
    often = [
        share
        for choice in choices.values()
        for share in sorted(choice.as_surveyed.selected.values())[-SELECTED:]
    ]
    return "\n\n".join(
        [
            f"*Drawn anew*: the share of {DRAWS} draws of as many people from the population, with "
            "replacement, in which the measurement is among the seven. *As surveyed*: the seven "
            "chosen most often when people are drawn so that stature and weight are as in "
            "ANSUR II, and how often.",
            "\n".join(pieces),
            "Why ours differ. Six in ten of our people are drawn evenly over body-mass index, "
            "SPRING's are as they came. Whatever follows weight closely then fills its range "
            "evenly and rises; statures come from a normal law and stay near its "
            f"{NORMAL:.3f}, so that height falls behind. Which girths lead is partly chance: "
            f"{_firm(choices)}. Drawn as the survey has it, little is settled: "
            f"the seven most frequent are chosen in {min(often):.0%} to {max(often):.0%} of the "
            "draws, for all measurements then have nearly normal laws, which this variance "
            "hardly tells apart. The method says little about which measurements a body needs; "
            "the errors of the subsets, below, do.",
        ]
    )


def _firm(choices: Mapping[Sex, Choice]) -> str:
    """How many of the seven are chosen almost always, and how near the top ten are."""
    pieces = []
    for sex, choice in choices.items():
        shares = [choice.drawn_anew.selected[name] for name in choice.selection.selected]
        variances = [
            choice.selection.variances[choice.selection.names.index(name)]
            for name in choice.selection.top
        ]
        pieces.append(
            f"{sex} {sum(share >= 0.9 for share in shares)} of {len(shares)} are chosen in nine "
            f"draws of ten, and the first's variance is {variances[0] / variances[-1] - 1:.0%} "
            "above the tenth's"
        )
    return "; ".join(pieces)


def survey_words(folder: Path) -> str:
    """The same steps on the survey's real people, but those kept for tests, and its columns."""
    pieces = []
    for sex in SEXES:
        subjects, people = read_people(folder / f"{sex}_half_a.csv")
        seen = np.array([not is_test_person(subject) for subject in subjects])
        variances = scaled_variances(people[seen])
        columns = list(SURVEY_TAPES)
        ranked = np.argsort(-variances, kind="stable")
        top = ", ".join(f"`{columns[i]}`" for i in ranked[:TOP])
        rank = ranked.tolist().index(columns.index("stature")) + 1
        pieces.append(
            f"- {sex} ({int(seen.sum())}): {top}: from {variances[ranked[0]]:.4f} to "
            f"{variances[ranked[TOP - 1]]:.4f}; stature is rank {rank} of {len(columns)} with "
            f"{variances[columns.index('stature')]:.4f}."
        )
    return (
        "The survey's own people bear that out. Of the columns that our bodies are fitted to, "
        "those vary most by the same steps:\n\n" + "\n".join(pieces)
    )
