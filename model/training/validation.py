"""How far the estimates are off, on bodies and people that the estimators did not see."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model.anthropometry import TAKEN, measure_batch
from model.estimators import Estimator
from model.geometry import Floats
from model.measurements import MEASUREMENTS, BodyKind
from model.template_mesh import load_template_mesh
from model.training.law_fit import survey_people
from model.training.population import Population, bodies_of
from model.training.survey import FROM_SURVEY, SEXES, Sex, load_statistics

ENTERED: Mapping[str, Sequence[str]] = {
    "all that are taken": TAKEN,
    "the eight that the paper evaluates": (
        "stature",
        "bust_girth",
        "waist_girth",
        "abdomen_girth",
        "hip_girth",
        "thigh_girth",
        "mid_thigh_girth",
        "inseam_height",
    ),
    "stature, weight, bust, hips": ("stature", "weight", "bust_girth", "hip_girth"),
    "stature and weight": ("stature", "weight"),
    "stature": ("stature",),
}
"""What is entered, for the tables."""

REAL_PER_SEX = 100
"""So many real people of each sex try the linear estimate and the paper's models."""


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of one estimator with one set of entered values.

    Attributes
    ----------
    misses : by measurement, ndarray of shape (n,): taken less true, SI units; NaN unknown.
    vertices : ndarray of shape (n,), mean vertex distance in metres; empty if unknown.
    """

    misses: Mapping[str, Floats]
    vertices: Floats

    def lengths(self, names: Sequence[str]) -> Floats:
        """Absolute misses of lengths alone (no weight): ndarray of shape (n, lengths)."""
        return np.abs(
            np.stack([self.misses[n] for n in names if MEASUREMENTS[n].kind != "mass"], axis=1)
        )


def estimate(
    estimator: Estimator, values: Mapping[str, Floats], entered: Sequence[str]
) -> tuple[Floats, Floats]:
    """Bodies from entered values: vertices (n, V, 3), metres, and what they measure (n, M), SI.

    Parameters
    ----------
    values : by measurement, ndarrays of shape (n,), SI.
    entered : those of the values that are known.
    """
    count = len(next(iter(values.values())))
    rows = np.full((count, len(estimator.names)), np.nan)
    for name in entered:
        rows[:, estimator.names.index(name)] = values[name]
    vertices = estimator.basis.vertices(estimator.linear.predict(rows))
    return vertices, measure_batch(estimator.template, vertices)


def held_out_values(population: Population, kind: BodyKind) -> tuple[Floats, dict[str, Floats]]:
    """The held-out bodies of a kind: vertices (n, V, 3), metres, and by name what they measure.

    Those of the neutral kind are every second one of both sexes.
    """
    rows = np.flatnonzero(population.held_out)
    rows = rows[::2] if kind == "neutral" else rows[population.of(kind)[rows]]
    vertices = np.concatenate([part for _, part in bodies_of(population, rows)])
    taken = measure_batch(load_template_mesh(), vertices)
    return vertices, dict(zip(TAKEN, taken.T, strict=True))


def errors_on_bodies(
    estimator: Estimator, vertices: Floats, values: Mapping[str, Floats], entered: Sequence[str]
) -> Errors:
    """Errors on bodies whose shape is known: vertices of shape (n, V, 3), metres.

    Values and what is entered are as in `estimate`.
    """
    estimated, taken = estimate(estimator, values, entered)
    misses = {name: taken[:, i] - values[name] for i, name in enumerate(TAKEN)}
    distances = np.linalg.norm(estimated - vertices, axis=2).mean(axis=1)
    return Errors(misses=misses, vertices=distances)


def everyone(folder: Path, sex: Sex) -> dict[str, Floats]:
    """What all real people measure whom nothing was trained or calibrated on: by name, (n,), SI."""
    return dict(zip(FROM_SURVEY, survey_people(folder, sex, test=True).T, strict=True))


def real_people(folder: Path, sex: Sex, seed: int) -> dict[str, Floats]:
    """The measurements of some of `everyone`, drawn by chance: by name, (n,) each, SI."""
    values = everyone(folder, sex)
    order = np.random.default_rng(seed).permutation(len(values["stature"]))
    chosen = np.sort(order[:REAL_PER_SEX])
    return {name: column[chosen] for name, column in values.items()}


def people_like_the_survey(sex: Sex, count: int, seed: int) -> dict[str, Floats]:
    """What people drawn from the survey's statistics measure, where its rows are not at hand.

    As `everyone`: by name, ndarrays of shape (count,), SI.
    """
    statistics = load_statistics(sex)
    random = np.random.default_rng([seed, SEXES.index(sex)])
    logs = random.multivariate_normal(
        statistics.means, statistics.covariance(), size=count, method="eigh"
    )
    columns = dict(zip(statistics.columns, np.exp(logs).T, strict=True))
    return {
        name: columns[first] - sum(columns[other] for other in less)
        for name, (first, *less) in FROM_SURVEY.items()
    }


def errors_on_people(
    estimator: Estimator, values: Mapping[str, Floats], entered: Sequence[str]
) -> Errors:
    """Errors on real people, of whom only some measurements are known: as in `estimate`."""
    known = [name for name in entered if name in values]
    _, taken = estimate(estimator, values, known)
    misses = {name: taken[:, TAKEN.index(name)] - values[name] for name in values}
    return Errors(misses=misses, vertices=np.empty(0))


def most_telling_of(population: Population, measured: Floats, sex: Sex, count: int) -> list[str]:
    """The measurements that tell most of the surface of a sex's bodies that are not held out.

    Parameters
    ----------
    measured : ndarray of shape (n, M), what every body of the population measures, SI, as `TAKEN`.
    count : how many are wanted.
    """
    seen = np.flatnonzero(population.of(sex) & ~population.held_out)
    some = [part[:, ::20] for _, part in bodies_of(population, seen)]
    surface = np.concatenate(some).reshape(len(seen), -1)
    return most_telling(measured[seen], surface, TAKEN, count)


def most_telling(values: Floats, surface: Floats, names: Sequence[str], count: int) -> list[str]:
    """The measurements that tell most of where the surface lies, stature among them.

    One after another, always the one with which a linear law leaves the least squared distance;
    then each but stature is exchanged for another for as long as that leaves less.

    Parameters
    ----------
    values : ndarray of shape (n, M), what bodies measure.
    surface : ndarray of shape (n, P), coordinates of their points.
    names : of the M measurements.
    count : how many are wanted.
    """
    scaled = (values - values.mean(axis=0)) / values.std(axis=0)
    products = scaled.T @ scaled
    with_surface = scaled.T @ (surface - surface.mean(axis=0))

    def told(chosen: Sequence[int]) -> float:
        by = with_surface[chosen]
        # Some heights are sums of others: what follows from those already chosen tells nothing.
        inverse = np.linalg.pinv(products[np.ix_(chosen, chosen)], rcond=1e-9, hermitian=True)
        return float(np.sum(by * (inverse @ by)))

    def best(kept: list[int]) -> list[int]:
        rest = [place for place in range(len(names)) if place not in kept]
        return [*kept, max(rest, key=lambda place: told([*kept, place]))]

    chosen = [list(names).index("stature")]
    while len(chosen) < count:
        chosen = best(chosen)
    tried = 0
    while tried < count - 1:
        # The second in turn leaves, and whichever tells most comes in at the end.
        exchanged = best([chosen[0], *chosen[2:]])
        gains = told(exchanged) > told(chosen) * (1 + 1e-9)
        tried = 0 if gains else tried + 1
        chosen = exchanged if gains else [chosen[0], *chosen[2:], chosen[1]]
    return [names[place] for place in chosen]
