"""The paper's validation of body shape (5.1.1): part of docs/paper.md."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from model.anthropometry import TAKEN
from model.estimators import LinearBodyEstimator, PCABodyEstimator
from model.geometry import Floats
from model.training.charts import lines
from model.training.error_maps import MapRow, draw_map
from model.training.feature_selection import TABLE_4, Selection, best_for_shape, candidates
from model.training.paper_models import (
    COMPONENT_SHARE,
    LINEAR,
    LINEAR_LETTER,
    PCA,
    PCA_DIVIDED,
    PCA_LETTER,
    Model,
    PaperSpace,
    given,
    learn,
)
from model.training.paper_validation import (
    TOPS,
    ShapeErrors,
    held_out,
    learned_from,
    shape_errors,
    small_and_large,
    subsets,
)
from model.training.population import Population
from model.training.population_report import table
from model.training.survey import SEXES, Sex

MODELS = (LINEAR_LETTER, PCA_LETTER, LINEAR, PCA, PCA_DIVIDED)

PAPER_SCALE = 0.15
"""Where the scale of the error maps ends, in metres: at the largest error of the paper's."""

MAPPED = {1: PCA_LETTER, 2: LINEAR_LETTER, 3: LINEAR}
"""The figures and their models; the first two are the paper's."""

MAPPED_SUBSETS = 7
"""How many of the subsets are columns of the figures, (a) to (g)."""

ENDS = ("small", "large")
"""What the two bodies at either end are called."""

BEST = "seven best for shape"
NOTHING = "nothing: the mean body"

COMPONENTS = (1, 2, 3, 5, 10, 20, 50, 100)
"""So many are kept, for the chart of errors."""


@dataclass(frozen=True, eq=False)
class Trial:
    """One sex: what was learned, what it is tried on, and how far off it is.

    Attributes
    ----------
    models : by name.
    subsets : by name, the measurements given.
    coordinates : ndarray of shape (n, 1 + K), of the held-out bodies.
    values : ndarray of shape (n, m), their measurements, SI, as `TAKEN`.
    ends : ndarray of shape (2,), the rows of a small and a large one.
    errors : by model and subset, of every held-out body.
    """

    models: Mapping[str, Model]
    subsets: Mapping[str, Sequence[str]]
    coordinates: Floats
    values: Floats
    ends: NDArray[np.int64]
    errors: Mapping[tuple[str, str], ShapeErrors]

    def estimate(self, model: str, subset: str, rows: NDArray[np.int64]) -> Floats:
        """Coordinates of held-out bodies estimated from a subset: (rows, 1 + K)."""
        return self.models[model](given(TAKEN, self.values[rows], self.subsets[subset]))


def try_models(
    space: PaperSpace,
    population: Population,
    values: Floats,
    selections: Mapping[Sex, Selection],
    sex: Sex,
) -> Trial:
    """Learns from one sex and estimates its held-out bodies from every subset.

    Parameters
    ----------
    values : ndarray of shape (n, m), what every body measures, SI, as `TAKEN`.
    """
    seen, unseen = learned_from(population, sex), held_out(population, sex)
    learned = space.coordinates(population.coefficients[seen])
    true = space.coordinates(population.coefficients[unseen])
    allowed = candidates(TAKEN)
    chosen: dict[str, Sequence[str]] = dict(subsets(selections, sex))
    linear = LinearBodyEstimator().fit(values[seen], learned)
    chosen[BEST] = best_for_shape(linear, TAKEN, allowed)
    chosen[f"all {len(allowed)}"] = allowed
    chosen[f"all {len(allowed)} and weight"] = TAKEN
    chosen[NOTHING] = ()
    models = learn(values[seen], learned)
    errors = {
        (model, name): shape_errors(
            space, models[model](given(TAKEN, values[unseen], subset)), true
        )
        for model in MODELS
        for name, subset in chosen.items()
    }
    return Trial(
        models=models,
        subsets=chosen,
        coordinates=true,
        values=values[unseen],
        ends=np.searchsorted(unseen, small_and_large(population, values, sex)),
        errors=errors,
    )


def shape_chapter(
    space: PaperSpace,
    trials: Mapping[Sex, Trial],
    population: Population,
    values: Floats,
    images: Path,
    written: str,
) -> str:
    """The chapter as Markdown; writes its figures into the folder of images.

    Parameters
    ----------
    values : as in `try_models`.
    written : by what, when and from what, to stand below each figure.
    """
    return "\n\n".join(
        [
            "## Validation: body shape",
            _subset_words(trials),
            _figures(space, trials, images, written),
            "### The four bodies in numbers",
            "Mean and largest distance of the vertices in cm, and the mean squared error of the "
            "coordinates in cm². Bodies are compared as in the paper, with the groin at one "
            "height.",
            *[_four_bodies(trials, model) for model in MAPPED.values()],
            "### All held-out bodies",
            "Mean distance of the vertices in mm, and in brackets the mean over bodies of the "
            "largest distance in cm. The paper's equations have no constant term: all of the "
            "body must follow in proportion from what is given. *Left divided*: the paper "
            "divides the weights by their eigenvalues and does not say that they are "
            "multiplied again; if they are, the division changes nothing, and if not, what comes "
            "out depends on the unit (here the metre). *In place*: the "
            "linear model with a constant, each estimate first moved as a whole to where it "
            "fits best.",
            *[_all_bodies(trials[sex], sex) for sex in SEXES],
            _components(space, population, values, images, written),
        ]
    )


def _subset_words(trials: Mapping[Sex, Trial]) -> str:
    shared = list(next(iter(trials.values())).subsets)[len(TOPS)].removeprefix("selected ")
    pieces = [
        "The paper's subsets as chosen above: of the ten that vary most the first 2 to 10, the "
        f"seven selected, and those of them that both sexes share (six in the paper, {shared} "
        "here); then its own Table 4, and for comparison the seven that tell most about the "
        "shape, each added to those before it where it lowers the squared error of the "
        "vertices most:\n"
    ]
    for sex, trial in trials.items():
        best = ", ".join(f"`{name}`" for name in trial.subsets[BEST])
        pieces.append(f"- {sex}: {best}.")
    return "\n".join(pieces)


def _figures(space: PaperSpace, trials: Mapping[Sex, Trial], images: Path, written: str) -> str:
    pieces = [
        "A small and a large held-out body of each sex, those nearest to the 3rd and 97th "
        "percentile of weight, in front view and profile. Colours are the distances of the "
        "vertices; the scale ends where that of the paper's figures does.",
    ]
    for number, model in MAPPED.items():
        rows = [
            _map_row(space, trial, sex, place, model)
            for sex, trial in trials.items()
            for place in range(len(ENDS))
        ]
        name = f"paper_figure_{number}.jpg"
        draw_map(space.template, rows, PAPER_SCALE).save(images / name, quality=85, optimize=True)
        ours = (
            "; not in the paper, and the law of the shipped estimators" if model == LINEAR else ""
        )
        pieces.append(
            f"![Error map: {model}](images/{name})\n\n*Figure {number}: {model}{ours}. {written}*"
        )
    return "\n\n".join(pieces)


def _map_row(space: PaperSpace, trial: Trial, sex: Sex, place: int, model: str) -> MapRow:
    row = trial.ends[[place]]
    stature, weight = (trial.values[row[0], TAKEN.index(n)] for n in ("stature", "weight"))
    return MapRow(
        words=(sex, ENDS[place], f"{stature * 100:.0f} cm", f"{weight:.0f} kg"),
        true=space.vertices(trial.coordinates[row])[0],
        estimated={
            name: space.vertices(trial.estimate(model, name, row))[0]
            for name in list(trial.subsets)[:MAPPED_SUBSETS]
        },
    )


def _four_bodies(trials: Mapping[Sex, Trial], model: str) -> str:
    names = list(next(iter(trials.values())).subsets)[: MAPPED_SUBSETS + 1]
    rows = []
    for sex, trial in trials.items():
        for words, row in zip(ENDS, trial.ends.tolist(), strict=True):
            cells = []
            for name in names:
                errors = trial.errors[model, name]
                numbers = [errors.mean[row] * 100, errors.largest[row] * 100]
                squared = f"{errors.squared[row] * 1e4:.2f}"
                cells.append(" · ".join([*[f"{number:.1f}" for number in numbers], squared]))
            rows.append([f"{sex}, {words}", *cells])
    return f"{model[:1].upper()}{model[1:]}:\n\n" + table(["mean · largest · MSE", *names], rows)


def _all_bodies(trial: Trial, sex: Sex) -> str:
    rows = []
    for name in trial.subsets:
        cells = []
        for model in MODELS:
            errors = trial.errors[model, name]
            cells.append(f"{errors.mean.mean() * 1e3:.1f} ({errors.largest.mean() * 100:.1f})")
        if name == NOTHING:  # of nothing, without a constant, follows nothing
            cells[MODELS.index(LINEAR_LETTER)] = ""
        in_place = trial.errors[LINEAR, name].shifted.mean()
        rows.append([name, *cells, f"{in_place * 1e3:.1f}"])
    return table([f"{sex}, {len(trial.values)} bodies", *MODELS, "in place"], rows)


def _components(
    space: PaperSpace, population: Population, values: Floats, images: Path, written: str
) -> str:
    series: dict[str, list[float]] = {}
    needed = []
    for sex in SEXES:
        seen, unseen = learned_from(population, sex), held_out(population, sex)
        learned, true = (space.coordinates(population.coefficients[r]) for r in (seen, unseen))
        everything = PCABodyEstimator().fit(values[seen], learned)
        shares = np.cumsum(everything.eigenvalues_) / everything.eigenvalues_.sum()
        needed.append(f"{sex} {int(np.searchsorted(shares, COMPONENT_SHARE)) + 1}")
        for words, subset in (("Table 4", TABLE_4[sex]), ("all", TAKEN)):
            scores = everything.weights(given(TAKEN, values[unseen], subset))
            scores *= everything.eigenvalues_
            series[f"{sex}, {words} given"] = [
                root_mean_square(
                    space,
                    everything.mean_ + scores[:, :count] @ everything.components_[:count] - true,
                )
                for count in COMPONENTS
            ]
    picture = lines(
        COMPONENTS,
        series,
        title="Error of the PCA model by number of components",
        across_label="components",
        up_label="root mean square distance of vertices, mm",
        logarithmic=True,
    )
    (images / "paper_components.svg").write_text(picture, encoding="utf-8")
    return "\n\n".join(
        [
            "### How many components",
            f"The paper does not say how many components it keeps. Ours hold {COMPONENT_SHARE:.0%} "
            f"of the variance ({', '.join(needed)}). With the seven of Table 4 more change "
            "nothing, for these tell nothing of the others.",
            "![Error by number of components](images/paper_components.svg)",
            f"*PCA with a constant. {written}*",
        ]
    )


def root_mean_square(space: PaperSpace, apart: Floats) -> float:
    """Of the vertices' distances, in mm, from differences of coordinates, (n, 1 + K)."""
    squared = (apart[:, 1:] ** 2).sum(axis=1).mean()
    return float(np.sqrt(squared / len(space.template.vertices)) * 1e3)
