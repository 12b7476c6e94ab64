"""Learns the joint law of measurements: from real people where the survey has them, else bodies.

What the survey measured is taken from its people, without those kept for tests, as numbers that
the project keeps (`write_survey_laws`). How the other measurements follow from those is taken
from the bodies of the population.
"""

import csv
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import norm

from model.anthropometry import TAKEN
from model.estimators import RANGE_SHARE
from model.geometry import Floats
from model.law import LEAST_NOISE, Law
from model.measurements import BODY_KINDS, BodyKind
from model.template_mesh import DATA
from model.training.survey import (
    FROM_SURVEY,
    SEXES,
    SURVEY_TAPES,
    Sex,
    is_test_person,
    read_people,
)

CALIBRATED_ON: Sequence[Sequence[str]] = (
    ("stature", "weight"),
    ("stature", "weight", "bust_girth", "hip_girth"),
    ("stature", "weight", "waist_girth"),
    ("stature", "weight", "bust_girth", "abdomen_girth", "hip_girth"),
    (
        "stature",
        "weight",
        "bust_girth",
        "abdomen_girth",
        "hip_girth",
        "inseam_height",
        "foot_height",
        "neck_girth",
    ),
    ("stature", "bust_girth", "waist_girth", "hip_girth"),
    ("stature", "bust_girth", "abdomen_girth", "hip_girth", "thigh_girth", "inseam_height"),
)
"""What people may know of themselves: ranges given each are calibrated together."""

FOLDS = 5
"""Into so many parts people are taken for calibration."""

REACH_SHARE = 0.02
"""The share of people at either end beyond whose index nothing bends further."""


def law_of(names: Sequence[str], values: Floats, weights: Floats | None = None) -> Law:
    """The law of people or bodies.

    Parameters
    ----------
    names : of the columns; the first two are stature and weight.
    values : ndarray of shape (n, m), SI.
    weights : ndarray of shape (n,), equal by default.
    """
    shares = np.ones(len(values)) if weights is None else weights
    shares = shares / shares.sum()
    logs = np.log(values)
    means = shares @ logs
    core = logs[:, :2] - means[:2]
    difference = core[:, 1] - 2 * core[:, 0]
    order = np.argsort(difference)
    ends = np.interp(
        [REACH_SHARE, 1 - REACH_SHARE], np.cumsum(shares[order]), difference[order]
    ).tolist()
    within = np.clip(difference, *ends)
    design = np.column_stack([np.ones(len(logs)), core, within**2])
    root = np.sqrt(shares)[:, None]
    found = np.linalg.lstsq(root * design, root * logs, rcond=None)[0]
    found[:, :2] = 0
    found[0, :2] = means[:2]
    found[[1, 2], [0, 1]] = 1
    left = logs - design @ found
    widenings = _widenings(left, within, shares)
    left /= np.exp(widenings * within[:, None])
    left[:, :2] = core
    covariance = (left * shares[:, None]).T @ left
    covariance[:2, 2:] = covariance[2:, :2] = 0
    return Law(
        names=tuple(names),
        means=found[0],
        slopes=found[1:3].T,
        bends=found[3],
        widenings=widenings,
        covariance=covariance,
        reach=(ends[0], ends[1]),
        factors=np.ones(len(names)),
        factor_slopes=np.zeros(len(names)),
    )


def _widenings(left: Floats, within: Floats, shares: Floats) -> Floats:
    """How deviations grow with the index; what chance makes of the slopes is taken back."""
    slopes, chance = _slopes(left, within, shares)
    common = slopes[2:].mean()
    real = max(float(slopes[2:].var() - chance[2:].mean()), 0)
    slopes = common + real / (real + chance) * (slopes - common)
    slopes[:2] = 0
    return slopes


def _slopes(left: Floats, within: Floats, shares: Floats) -> tuple[Floats, Floats]:
    """How the logarithms of the sizes of (n, m) go with (n,), and the variances of that by chance.

    `shares`, the weights, add up to 1.
    """
    sizes = np.log(np.abs(left) + 1e-4)
    centred = within - shares @ within
    slopes = (shares * centred) @ sizes / (shares @ centred**2)
    rest = sizes - shares @ sizes - np.outer(centred, slopes)
    effective = 1 / (shares**2).sum()
    return slopes, (shares @ rest**2) / (effective * (shares @ centred**2))


def calibrated(law: Law, values: Floats, weights: Floats | None = None) -> Law:
    """The law with factors by which four of five values lie within its ranges of 80 %.

    They go with the body-mass index: how deviations widen with it is learned where stature and
    weight are known, and is less so where girths are too.

    Parameters
    ----------
    values : ndarray of shape (n, m), SI, of the people or bodies that the law was learned from,
        in the order of its names. Each fold of them is held against the law of the others.
    weights : as in `law_of`.
    """
    shares = np.ones(len(values)) if weights is None else weights
    fold = np.arange(len(values)) % FOLDS
    parts = [
        _scores(law_of(law.names, values[fold != one], shares[fold != one]), values[fold == one])
        for one in range(FOLDS)
    ]
    order = np.concatenate([np.flatnonzero(fold == one) for one in range(FOLDS)])
    scores = np.concatenate(parts, axis=1)[:, np.argsort(order)]
    factors, factor_slopes = _factors(scores, law.within(np.log(values)), shares)
    return replace(law, factors=factors, factor_slopes=factor_slopes)


def _scores(law: Law, values: Floats) -> Floats:
    """By how many deviations values miss what subsets of the others say: (subsets, n, m).

    NaN where a value is in the subset.
    """
    logs = np.log(values)
    scores = np.full((len(CALIBRATED_ON), *logs.shape), np.nan)
    for mine, subset in zip(scores, CALIBRATED_ON, strict=True):
        known = np.array([name in subset for name in law.names])
        means, covariances = law.given_rows(np.where(known, logs, np.nan))
        deviations = np.sqrt(np.maximum(np.einsum("nii->ni", covariances), LEAST_NOISE**2))
        mine[:, ~known] = (np.abs(logs - means) / deviations)[:, ~known]
    return scores


def _factors(scores: Floats, within: Floats, shares: Floats) -> tuple[Floats, Floats]:
    """By what deviations have to be multiplied for four of five values to lie in their ranges.

    Parameters
    ----------
    scores : ndarray of shape (subsets, n, m), from :func:`_scores`.
    within : ndarray of shape (n,), how the people's indices differ from that of the means.
    shares : ndarray of shape (n,), their weights.

    Returns
    -------
    factors, slopes : ndarrays of shape (m,), as in `Law`.
    """
    factors, slopes = np.ones(scores.shape[2]), np.zeros(scores.shape[2])
    for i, mine in enumerate(scores.transpose(2, 0, 1)):
        told = mine[~np.isnan(mine).any(axis=1)]
        if len(told):
            slopes[i] = _slopes(told.T, within, shares / shares.sum())[0].mean()
            size = (told / np.exp(slopes[i] * within)).ravel()
            weight = np.tile(shares, len(told))
            order = np.argsort(size)
            share = np.cumsum(weight[order]) / weight.sum()
            factors[i] = np.interp(RANGE_SHARE, share, size[order]) / norm.ppf(
                (1 + RANGE_SHARE) / 2
            )
    return factors, slopes


# ---------------------------------------------------------------- real people


def survey_people(folder: Path, sex: Sex, *, test: bool) -> Floats:
    """Real people's values, ndarray of shape (n, len(FROM_SURVEY)), SI: those for tests or not."""
    subjects, columns = read_people(folder / f"{sex}_half_a.csv")
    mine = [is_test_person(subject) == test for subject in subjects]
    place = {name: i for i, name in enumerate(SURVEY_TAPES)}
    return np.stack(
        [
            columns[mine, place[first]] - sum(columns[mine, place[other]] for other in less)
            for first, *less in FROM_SURVEY.values()
        ],
        axis=1,
    )


def survey_law_path(kind: BodyKind) -> Path:
    """Where the project keeps the law of the survey's people of one kind."""
    return DATA / "survey" / f"ansur2_law_{kind}.csv"


def write_survey_laws(folder: Path) -> int:
    """Computes the laws of the survey's people from its rows; returns how many people they saw."""
    seen = {sex: survey_people(folder, sex, test=False) for sex in SEXES}
    for kind in BODY_KINDS:
        sexes = SEXES if kind == "neutral" else (kind,)
        values = np.concatenate([seen[sex] for sex in sexes])
        # Women and men count alike in the neutral body.
        weights = np.concatenate([np.full(len(seen[sex]), 1 / len(seen[sex])) for sex in sexes])
        law = calibrated(law_of(tuple(FROM_SURVEY), values, weights), values, weights)
        _write_law(law, survey_law_path(kind))
    return sum(len(values) for values in seen.values())


_NUMBERS = (
    *("mean", "by_stature", "by_weight", "bend", "widening", "factor", "factor_slope"),
    *("lowest", "highest"),
)


def _write_law(law: Law, path: Path) -> None:
    ends = np.tile(law.reach, (len(law.names), 1))
    columns = [law.means, *law.slopes.T, law.bends, law.widenings, law.factors]
    columns += [law.factor_slopes, *ends.T]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["measurement", *_NUMBERS, *law.names])
        for i, name in enumerate(law.names):
            numbers = [f"{column[i]:.6f}" for column in columns]
            writer.writerow([name, *numbers, *(f"{v:.9f}" for v in law.covariance[i])])


def load_survey_law(kind: BodyKind) -> Law:
    """The law of the survey's people of one kind, from the project's table."""
    with survey_law_path(kind).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    names = tuple(row["measurement"] for row in rows)
    column = {key: np.array([float(row[key]) for row in rows]) for key in (*_NUMBERS, *names)}
    return Law(
        names=names,
        means=column["mean"],
        slopes=np.stack([column["by_stature"], column["by_weight"]], axis=1),
        bends=column["bend"],
        widenings=column["widening"],
        covariance=np.stack([column[name] for name in names], axis=1),
        reach=(float(column["lowest"][0]), float(column["highest"][0])),
        factors=column["factor"],
        factor_slopes=column["factor_slope"],
    )


# ---------------------------------------------------------------- people and bodies together


def joint_law(surveyed: Law, values: Floats) -> Law:
    """The law of all measurements: the survey's, and what bodies say of the others given those.

    Parameters
    ----------
    surveyed : the law of some measurements.
    values : ndarray of shape (n, M), SI, of bodies, in the order of `TAKEN`.
    """
    logs = np.log(values)
    some = [TAKEN.index(name) for name in surveyed.names]
    others = [i for i in range(len(TAKEN)) if i not in some]
    design = np.column_stack([np.ones(len(logs)), logs[:, some]])
    found = np.linalg.lstsq(design, logs[:, others], rcond=None)[0]
    left = logs[:, others] - design @ found
    onto = np.zeros((len(TAKEN), len(some)))
    onto[some] = np.eye(len(some))
    onto[others] = found[1:].T
    means = onto @ surveyed.means
    means[others] += found[0]
    own = surveyed.covariance.copy()
    own[:2, :2] = 0
    covariance = onto @ own @ onto.T
    covariance[np.ix_(others, others)] += left.T @ left / len(left)
    covariance[:2, :2] = surveyed.covariance[:2, :2]
    bodies = law_of(TAKEN, values)
    widenings = bodies.widenings
    widenings[some] = surveyed.widenings
    factors, slopes = np.ones(len(TAKEN)), np.zeros(len(TAKEN))
    factors[some], slopes[some] = surveyed.factors, surveyed.factor_slopes
    law = Law(
        names=TAKEN,
        means=means,
        slopes=onto @ surveyed.slopes,
        bends=onto @ surveyed.bends,
        widenings=widenings,
        covariance=covariance,
        reach=surveyed.reach,
        factors=factors,
        factor_slopes=slopes,
    )
    of_bodies = _factors(_scores(law, values), law.within(logs), np.ones(len(values)))
    factors[others], slopes[others] = (part[others] for part in of_bodies)
    return law
