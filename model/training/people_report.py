"""The part of docs/validation.md about fitted bodies, ranges and doubts, on people and bodies."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from model.anthropometry import TAKEN
from model.estimators import Estimator, PCABodyEstimator, load_estimators
from model.geometry import Floats
from model.measurements import BodyKind
from model.shape_basis import load_shape_basis
from model.training.fit_report import (
    EIGHT,
    ENTERED_HEAD,
    NOT_ENTERED_HEAD,
    SEVEN,
    Fits,
    band_heads,
    band_rows,
    coverage_rows,
    entered_row,
    fit_all,
    not_entered_rows,
    regression,
)
from model.training.law_fit import survey_people
from model.training.law_report import (
    TURNS,
    coverage_of,
    coverage_table,
    false_alarms,
    procedure_rows,
    recognised,
)
from model.training.population import Population
from model.training.population_report import table
from model.training.survey import FROM_SURVEY, INDEX_BANDS, SEXES, STATURE_BANDS, Sex
from model.training.validation import (
    everyone,
    held_out_values,
    most_telling_of,
    people_like_the_survey,
)

DRAWN = 200
"""People drawn of each sex where the survey's rows are not at hand."""

PCA_SHARE = 0.95
"""Of the variance of bodies, what the components keep in the paper's model by PCA."""

Values = Mapping[str, Floats]
"""By measurement, what people or bodies measure: ndarrays of shape (n,), SI."""


def people_sections(population: Population, measured: Floats, rows: Path | None) -> str:
    """All of it, with the headline table first.

    Parameters
    ----------
    measured : ndarray of shape (n, M), what each body of the population measures, SI, as `TAKEN`.
    rows : the folder of the survey's rows; None where they are not at hand.
    """
    estimators = load_estimators()
    people: dict[str, Values]
    if rows is None:
        people = {sex: people_like_the_survey(sex, DRAWN, population.seed) for sex in SEXES}
        seen = {sex: people_like_the_survey(sex, 2000, population.seed + 1) for sex in SEXES}
        who = (
            f"{2 * DRAWN} people **drawn from the survey's statistics**, its rows not being at "
            'hand (`make report ARGS="--survey-rows FOLDER"` takes real people).'
        )
    else:
        people = {sex: everyone(rows, sex) for sex in SEXES}
        seen = {
            sex: dict(zip(FROM_SURVEY, survey_people(rows, sex, test=False).T, strict=True))
            for sex in SEXES
        }
        count = sum(len(values["stature"]) for values in people.values())
        who = (
            f"All {count} **real people** of ANSUR II's rows at hand that are kept for tests: "
            "nothing was trained or calibrated on them. Soldiers, 17 to 58 years, few of them "
            "very heavy. They have no waist at its narrowest and no mid thigh."
        )
    both = {n: np.concatenate([people[sex][n] for sex in SEXES]) for n in FROM_SURVEY}
    fits: dict[str, Fits] = {sex: fit_all(estimators[sex], people[sex], SEVEN) for sex in SEXES}
    alike = {
        sex: fit_all(
            estimators[sex], {n: v[::3] for n, v in people[sex].items()}, tuple(FROM_SURVEY)
        )
        for sex in SEXES
    }
    regressed: dict[str, Values] = {sex: regression(seen[sex], fits[sex]) for sex in SEXES}
    bodies = _fitted_bodies(population, estimators, dict.fromkeys(SEXES, EIGHT))
    whole = _fitted_bodies(population, estimators, dict.fromkeys(SEXES, TAKEN), every=5)
    telling = _fitted_bodies(
        population,
        estimators,
        {sex: most_telling_of(population, measured, sex, len(EIGHT)) for sex in SEXES},
    )
    everybody: dict[str, tuple[Estimator, Values]] = {
        **{sex: (estimators[sex], people[sex]) for sex in SEXES},
        "neutral": (estimators["neutral"], both),
    }
    return "\n\n".join(
        [
            "## In short",
            who,
            _headline(fits, regressed, bodies, telling, _pca_distances(population, measured)),
            "The eight are those of a shopper and the thigh. The eight that tell most of the "
            "surface were chosen on bodies that are not held out, one after another, then "
            "exchanged for as long as that told more: "
            + "; ".join(
                f"{sex}: " + ", ".join(f"`{name}`" for name in telling[sex].entered)
                for sex in SEXES
            )
            + ".",
            "## What was entered, linear and fitted",
            "Sums are the paper's total distance error (TDE). Linear in centimetres, fitted in "
            "millimetres. First the seven that a shopper enters; then all that the survey has, of "
            "every third person; then all 41 of every fifth held-out body of the population.",
            table(
                ENTERED_HEAD,
                [entered_row(sex, of[sex]) for of in (fits, alike, whole) for sex in SEXES],
            ),
            "## What was not entered",
            "Mean absolute errors in mm, read off the mesh, from stature, weight, bust, abdomen, "
            "hips, neck and inseam; beside a plain regression fitted to the survey itself.",
            table(
                NOT_ENTERED_HEAD,
                [row for s in SEXES for row in not_entered_rows(s, fits[s], regressed[s])],
            ),
            "## Across the range",
            "By band of body-mass index (kg/m²) and of stature (cm), in mm, with how many there "
            f"are. People, from the seven; and {_count(bodies)} held-out bodies of the population, "
            "from eight (the seven and the thigh), with the mean distance of vertices.",
            table(["", "error", *band_heads(INDEX_BANDS)], _bands(fits, bodies, "index")),
            table(["", "error", *band_heads(STATURE_BANDS, 100)], _bands(fits, bodies, "stature")),
            "## Ranges",
            "How often the printed 80 % range holds the truth, from the seven, and by band of "
            "body-mass index. A share of 0.80 found on 100 people is uncertain by 0.08, on 400 by "
            "0.04 (nineteen of twenty times).",
            table(
                ["", "measurement", "all", *band_heads(INDEX_BANDS)],
                [row for sex in SEXES for row in coverage_rows(sex, fits[sex])],
            ),
            *_procedure(rows),
            *_coverage(everybody, population),
            "## Doubts",
            *_doubts(everybody),
        ]
    )


def _count(bodies: Mapping[str, Fits]) -> int:
    return sum(len(fits.seconds) for fits in bodies.values())


def _fitted_bodies(
    population: Population,
    estimators: Mapping[BodyKind, Estimator],
    entered: Mapping[Sex, Sequence[str]],
    every: int = 1,
) -> dict[str, Fits]:
    """Every so manieth held-out body, from what is entered for its sex."""
    fits: dict[str, Fits] = {}
    for sex in SEXES:
        vertices, values = held_out_values(population, sex)
        some = {name: of[::every] for name, of in values.items()}
        fits[sex] = fit_all(estimators[sex], some, entered[sex], vertices[::every])
    return fits


def _pca_distances(population: Population, measured: Floats) -> dict[str, float]:
    """The paper's model by PCA from the eight: mean vertex distance on held-out bodies, metres."""
    distances: dict[str, float] = {}
    places = [TAKEN.index(name) for name in EIGHT]
    for sex in SEXES:
        seen = population.of(sex) & ~population.held_out
        model = PCABodyEstimator(PCA_SHARE).fit(
            measured[seen][:, places], population.coefficients[seen]
        )
        vertices, values = held_out_values(population, sex)
        entered = np.stack([values[name] for name in EIGHT], axis=1)
        found = load_shape_basis().vertices(model.predict(entered))
        distances[sex] = float(np.linalg.norm(found - vertices, axis=2).mean())
    return distances


def _headline(
    fits: Mapping[str, Fits],
    regressed: Mapping[str, Values],
    bodies: Mapping[str, Fits],
    telling: Mapping[str, Fits],
    pca: Mapping[str, float],
) -> str:
    numbers = [
        [
            fits[sex].sums(linear=True).mean(),
            fits[sex].sums().mean(),
            max(np.abs(fits[sex].misses(n)).max() for n in SEVEN if n != "weight"),
            np.abs(regressed[sex]["thigh_girth"]).mean(),
            np.abs(fits[sex].misses("thigh_girth")).mean(),
            np.abs(regressed[sex]["calf_girth"]).mean(),
            np.abs(fits[sex].misses("calf_girth")).mean(),
            pca[sex],
            bodies[sex].linear_vertices.mean(),
            bodies[sex].vertices.mean(),
            telling[sex].vertices.mean(),
        ]
        for sex in SEXES
    ]
    words = [
        "seven entered: sum of errors, linear (mm)",
        "seven entered: sum of errors, fitted (mm)",
        "seven entered: largest error, fitted (mm)",
        "thigh, not entered: regression (mm)",
        "thigh, not entered: fitted (mm)",
        "calf, not entered: regression (mm)",
        "calf, not entered: fitted (mm)",
        "held-out bodies, eight entered: mean distance of vertices, by PCA (mm)",
        "the same, linear (mm)",
        "the same, fitted (mm)",
        "the same, from the eight that tell most of the surface, fitted (mm)",
    ]
    rows = [
        [said, *(f"{number * 1e3:.1f}" for number in one)]
        for said, *one in zip(words, *numbers, strict=True)
    ]
    coverage = [coverage_rows(sex, fits[sex])[-1][2] for sex in SEXES]
    rows.append(["printed 80 % ranges that hold the truth", *coverage])
    times = [f"{np.median(fits[sex].seconds) * 1e3:.0f}" for sex in SEXES]
    rows.append(["time of a fit to seven values on one core, median (ms)", *times])
    return table(["", *SEXES], rows)


def _bands(fits: Mapping[str, Fits], bodies: Mapping[str, Fits], of: str) -> list[list[str]]:
    rows = [row for sex in SEXES for row in band_rows(f"{sex}, people", fits[sex], of)]
    return rows + [row for sex in SEXES for row in band_rows(f"{sex}, bodies", bodies[sex], of)]


def _procedure(rows: Path | None) -> list[str]:
    """Ranges by laws learned as the shipped ones are, everybody being held out once."""
    if rows is None:
        return []
    of_all = []
    for sex in SEXES:
        parts = [survey_people(rows, sex, test=test) for test in (False, True)]
        of_all += [[sex, *row] for row in procedure_rows(np.concatenate(parts), SEVEN)]
    return [
        "Chance makes these shares differ by that much from what they would be of many people. So "
        f"that less is left of it, all people take turns: a law is learned and calibrated as the "
        f"shipped one is on nine tenths of them and held against the others, {TURNS} times, until "
        "everybody has been held out once.",
        table(["", "measurement", "all", *band_heads(INDEX_BANDS)], of_all),
    ]


def _coverage(
    everybody: Mapping[str, tuple[Estimator, Values]], population: Population
) -> list[str]:
    by_name, by_band = [], []
    for kind, (estimator, values) in everybody.items():
        names, bands = coverage_table(kind, estimator, values)
        by_name += names
        by_band += bands
    others = [name for name in TAKEN if name not in FROM_SURVEY]
    rows = {name: [f"`{name}`"] for name in others}
    for sex in SEXES:
        _, values = held_out_values(population, sex)
        for entered in (SEVEN, ("stature", "weight")):
            inside = coverage_of(everybody[sex][0].law, values, entered)
            for name in others:
                rows[name].append(f"{inside[name].mean():.2f}")
    return [
        "The law's ranges from other subsets, by measurement and by band of body-mass index; the "
        "neutral body's on women and men together.",
        table(["", "entered", "all", *[f"`{name}`" for name in FROM_SURVEY]], by_name),
        table(["", "entered", *band_heads(INDEX_BANDS)], by_band),
        "Of measurements that the survey has not, on held-out bodies of the population: from the "
        "seven, and from stature and weight.",
        table(
            ["measurement", "female, seven", "female, two", "male, seven", "male, two"],
            list(rows.values()),
        ),
    ]


def _doubts(everybody: Mapping[str, tuple[Estimator, Values]]) -> list[str]:
    alarms, known = [], []
    for kind, (estimator, values) in everybody.items():
        shares = false_alarms(estimator, values, EIGHT)
        mean = float(np.mean(list(shares.values())))
        alarms.append([kind, *(f"{100 * share:.1f}" for share in (*shares.values(), mean))])
        for words, (doubted, right) in recognised(estimator, values).items():
            known.append([kind, words, f"{100 * doubted:.0f}", f"{100 * right:.0f}"])
    return [
        "Of how many in a hundred a true value is doubted, eight being entered.",
        table(["", *[f"`{name}`" for name in EIGHT], "mean"], alarms),
        "Mistakes made on purpose in one of the eight: of how many in a hundred the value is "
        "doubted, and recognised as what it is, with a suggestion (of a unit, the true value).",
        table(["", "mistake", "doubted", "recognised"], known),
    ]
