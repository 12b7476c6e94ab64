"""Writes ``docs/population.md``: the population beside the survey, its misses, its looks."""

import io
import json
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from model.cameras import SIDES
from model.geometry import Floats
from model.rendering import render_png
from model.shape_basis import load_shape_basis
from model.template_mesh import DATA, Body, load_template_mesh
from model.training.person_fit import RELAXED, TOLERANCES, USUAL_TOLERANCE, targets
from model.training.population import Population
from model.training.population_files import FORM_COLUMNS
from model.training.stance import FEET
from model.training.survey import (
    BODY_MASS_INDEX,
    INDEX_BANDS,
    SEXES,
    SURVEY_TAPES,
    Sex,
    load_statistics,
)

CORRELATED = ("stature", "weightkg", *FORM_COLUMNS[1:])
AIM = 0.005
"""The mean miss that the fit aims at, in metres."""

SHEET_BODIES = 14
"""Of each sex."""

SHEET_SIZE = (170, 340)
"""Of one picture, in pixels."""

SHEET_COLOUR = (243, 241, 237)
TALLEST = 2.0
"""Stature in metres of a body that fills its picture's height."""


WHY_MISSED = {
    "bicepscircumferenceflexed": "flexed in the survey, hanging on our bodies: a wide tolerance",
    "forearmcircumferenceflexed": "flexed in the survey, hanging on our bodies: a wide tolerance",
    "buttockheight": "our landmark is fixed to the skin, the survey's is the most backward point",
    "chestheight": "follows the breast's form, which is drawn and held",
    "axillaheight": "our arms stand out: the fold under the arm lies elsewhere",
    "acromialheight": "our arms stand out, and lift the tip of the shoulder with them",
    "biacromialbreadth": "our arms stand out, and move the tips of the shoulders",
    "chestdepth": "the caliper presses, and its level differs; a wide tolerance",
    "waistbreadth": "a wide tolerance, so that the girth of the abdomen is met instead",
    "waistdepth": "a wide tolerance, so that the girth of the abdomen is met instead",
    "hipbreadth": "our legs stand apart, the survey's together",
    "buttockdepth": "our legs stand apart; a wide tolerance",
}


def write_population_report(population: Population, docs: Path) -> None:
    """Writes the document and its sheet of bodies into the folder of documents."""
    sheet = docs / "images" / "population.jpg"
    sheet.parent.mkdir(parents=True, exist_ok=True)
    chosen = sheet_rows(population)
    draw_sheet(population, chosen).save(sheet, quality=82, optimize=True)
    text = "\n\n".join(
        [
            "# The open population",
            "Written by `make report`; do not edit. "
            f"Population of {population.date}, seed {population.seed}.",
            _how_many(population),
            "## One stance",
            "How somebody stands is no shape, and tapes do not tell it. So all bodies are put into "
            "one stance by the skeleton that the avatar's file carries "
            "(`model/training/stance.py`): each ankle's joint "
            f"{FEET * 100:.1f} % of stature from the middle and below the hip, the lines from hips "
            "to neck and from neck to head as upright, arms as far out. Then they are fitted once "
            "more, by what that moved. Curved backs, bowed legs and round shoulders stay each "
            "body's own.",
            "## How it looks",
            "From thin to heavy, in front view and profile: women, then men; of each build a "
            "shorter and a taller person. Under each body: stature in cm and body-mass index.",
            "![Bodies of the population](images/population.jpg)",
            "## Beside the survey",
            _beside_survey_words(),
            *[_beside_survey(population, sex) for sex in SEXES],
            "## Correlations",
            "Between logarithms; the survey's, then the population's weighted back to the "
            "survey's statures and weights.",
            *[_correlations(population, sex) for sex in SEXES],
            "## What the fit missed",
            f"Mean and largest miss of the kept bodies, in mm (weight in kg). The aim is a mean "
            f"of {AIM * 1e3:.0f} mm; what misses it is marked, with the reason below.",
            _misses(population),
            _why(population),
        ]
    )
    (docs / "population.md").write_text(text + "\n", encoding="utf-8")
    print(f"wrote {docs / 'population.md'}")


def table(head: list[str], rows: list[list[str]], *, numbers: bool = True) -> str:
    """A Markdown table; right of the first column stand numbers, or words."""
    rule = ["---"] + ["--:" if numbers else "---"] * (len(head) - 1)
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, rule, *rows])


def sheet_rows(population: Population) -> list[list[int]]:
    """For each sex the rows of the bodies to draw, by body-mass index; of neighbours a short one,
    then a tall one.
    """
    stature, weight = population.taken[:, 0], population.taken[:, 1]
    index = weight / stature**2
    chosen = []
    for sex in SEXES:
        people = np.flatnonzero(population.of(sex))
        people = people[np.argsort(index[people])]
        bands = np.array_split(people, SHEET_BODIES // 2)
        picks = []
        for band in bands:
            middle = band[max(len(band) // 2 - 12, 0) : len(band) // 2 + 12]
            by_stature = middle[np.argsort(stature[middle])]
            picks += [int(by_stature[0]), int(by_stature[-1])]
        picks[0], picks[-1] = int(people[2]), int(people[-3])
        chosen.append(picks)
    return chosen


def draw_sheet(population: Population, chosen: list[list[int]]) -> Image.Image:
    """Front and profile of the chosen bodies, a pair of rows for each sex."""
    template, basis = load_template_mesh(), load_shape_basis()
    width, height = SHEET_SIZE
    size = (width * SHEET_BODIES, (height + 18) * 2 * len(SEXES))
    sheet = Image.new("RGB", size, SHEET_COLOUR)
    pen = ImageDraw.Draw(sheet)
    for sex_row, (sex, picks) in enumerate(zip(SEXES, chosen, strict=True)):
        bodies = basis.vertices(population.coefficients[picks])
        for column, (pick, vertices) in enumerate(zip(picks, bodies, strict=True)):
            body = Body(template=template, vertices=vertices, kind=sex)
            stature, weight = population.taken[pick, :2]
            for side_row, side in enumerate(SIDES):
                top = (2 * sex_row + side_row) * (height + 18)
                picture = Image.open(io.BytesIO(render_png(body, side, size=SHEET_SIZE)))
                # One scale for all: a picture fits its body, so shorter people's shrink.
                share = stature / TALLEST
                small = picture.resize((round(width * share), round(height * share)))
                corner = (column * width + (width - small.width) // 2, top + height - small.height)
                sheet.paste(small, corner)
                pen.text(
                    (column * width + 50, top + height + 3),
                    f"{stature * 100:.0f} cm, {weight / stature**2:.0f}",
                    fill="black",
                )
    return sheet


def _how_many(population: Population) -> str:
    tally = json.loads((DATA / "population.json").read_text(encoding="utf-8"))
    index = population.taken[:, 1] / population.taken[:, 0] ** 2
    rows = []
    for sex in SEXES:
        mine = index[population.of(sex)]
        counts, _ = np.histogram(mine, INDEX_BANDS)
        rows.append([sex, str(len(mine)), *map(str, counts)])
    held = int(population.held_out.sum())
    basis = load_shape_basis()
    return "\n\n".join(
        [
            f"Of {tally['drawn']} people drawn (body-mass index {BODY_MASS_INDEX[0]:.0f} to "
            f"{BODY_MASS_INDEX[1]:.0f}), {tally['kept']} bodies are kept; {held} of those are "
            f"held out from every shipped estimator. {len(basis.directions)} shape components "
            "place every vertex of every body to within "
            f"{tally['largest_vertex_error_mm']:.2f} mm, as shipped. Rejected, a body at times for "
            "two reasons:",
            "\n".join(f"- {reason}: {count}" for reason, count in tally["rejected"].items()),
            table(
                ["", "kept"]
                + [f"index {low:g} to {high:g}" for low, high in pairwise(INDEX_BANDS)],
                rows,
            ),
        ]
    )


def _beside_survey_words() -> str:
    return (
        "Means ± deviations, in mm (weight in kg). The population is wide by design, so that "
        "thin and heavy people are served as well as the crowd; *weighted* gives each body the "
        "weight that its stature and weight have in the survey, and is what compares. The "
        "survey: ANSUR II, soldiers of 17 to 58 years, without the people kept for tests."
    )


def _beside_survey(population: Population, sex: Sex) -> str:
    mine = population.of(sex)
    taken, weights = population.taken[mine], np.exp(population.log_odds[mine])
    weights = weights / weights.sum()
    statistics = load_statistics(sex)
    survey_mean, survey_deviation = _plain_moments(statistics.means, statistics.deviations)
    relaxed = np.array([RELAXED.get(name, 1.0) for name in SURVEY_TAPES])
    mean = weights @ taken
    deviation = np.sqrt(weights @ (taken - mean) ** 2)
    rows = []
    for i, name in enumerate(SURVEY_TAPES):
        scale = 1.0 if name == "weightkg" else 1e3
        digits = 1 if name == "weightkg" else 0
        pairs = [
            (survey_mean[i] * relaxed[i], survey_deviation[i] * relaxed[i]),
            (mean[i], deviation[i]),
            (taken[:, i].mean(), taken[:, i].std()),
        ]
        rows.append(
            [f"`{name}`" + (" (relaxed)" if name in RELAXED else "")]
            + [f"{m * scale:.{digits}f} ± {d * scale:.{digits}f}" for m, d in pairs]
        )
    effective = 1 / (weights**2).sum()
    return (
        f"### {sex.capitalize()}\n\n"
        + table(["column", f"survey ({statistics.people})", "weighted", "as drawn"], rows)
        + f"\n\nThe weights are worth {effective:.0f} people."
    )


def _plain_moments(log_mean: Floats, log_deviation: Floats) -> tuple[Floats, Floats]:
    """Mean and deviation of values whose logarithms are normal."""
    mean = np.exp(log_mean + log_deviation**2 / 2)
    return mean, mean * np.sqrt(np.expm1(log_deviation**2))


def _correlations(population: Population, sex: Sex) -> str:
    mine = population.of(sex)
    logs = np.log(population.taken[mine])
    covariance = np.cov(logs.T, aweights=np.exp(population.log_odds[mine]))
    spread = np.sqrt(np.diag(covariance))
    ours = covariance / np.outer(spread, spread)
    theirs = load_statistics(sex).correlations
    names = list(SURVEY_TAPES)
    places = [names.index(name) for name in CORRELATED]
    rows = []
    for row, i in enumerate(places):
        cells = [
            f"{theirs[i, j]:.2f} · {ours[i, j]:.2f}" if column < row else ""
            for column, j in enumerate(places[:-1])
        ]
        if row:
            rows.append([f"`{names[i]}`", *cells])
    off = np.abs(ours - theirs)[np.triu_indices(len(names), 1)]
    return (
        f"### {sex.capitalize()}\n\n"
        + table([""] + [f"`{name}`" for name in CORRELATED[:-1]], rows)
        + f"\n\nOver all pairs of the {len(names)} columns the two differ by {off.mean():.2f} "
        f"on average, by {np.quantile(off, 0.95):.2f} in one pair of twenty."
    )


def _missed(population: Population) -> Floats:
    """How far each kept body is from what it was fitted to: (n, C), SI units."""
    goals = np.array([targets(row) for row in population.drawn])
    missed: Floats = np.abs(population.taken - goals)
    return missed


def _over(population: Population, column: int) -> bool:
    """Whether a length's mean miss is beyond the aim, for women or men."""
    if list(SURVEY_TAPES)[column] == "weightkg":
        return False
    missed = _missed(population)[:, column]
    return any(float(missed[population.of(sex)].mean()) > AIM for sex in SEXES)


def _why(population: Population) -> str:
    reasons = [
        f"- `{name}`: {WHY_MISSED[name]}."
        for i, name in enumerate(SURVEY_TAPES)
        if _over(population, i)
    ]
    return "\n".join(reasons)


def _misses(population: Population) -> str:
    missed = _missed(population)
    rows = []
    for i, name in enumerate(SURVEY_TAPES):
        scale = 1.0 if name == "weightkg" else 1e3
        cells = []
        for sex in SEXES:
            mine = missed[population.of(sex), i]
            cells += [f"{mine.mean() * scale:.1f}", f"{mine.max() * scale:.1f}"]
        tolerance = TOLERANCES.get(name, USUAL_TOLERANCE) * scale
        rows.append(
            [f"`{name}`" + (" *" if _over(population, i) else ""), f"{tolerance:g}", *cells]
        )
    head = ["column", "tolerance", "women, mean", "largest", "men, mean", "largest"]
    return table(head, rows)
