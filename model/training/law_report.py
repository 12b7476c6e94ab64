"""How well the law of people holds: coverage and doubts, for tables of docs/validation.md."""

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from scipy.stats import norm

from model.anthropometry import TAKEN
from model.estimators import RANGE_SHARE, Estimator
from model.geometry import Floats
from model.law import Law
from model.measurements import MeasurementSet
from model.plausibility import TROUSERS_SHORT_OF_FLOOR, Doubt, doubts
from model.training.fit_report import EIGHT, SEVEN
from model.training.law_fit import calibrated, law_of
from model.training.survey import FROM_SURVEY, INDEX_BANDS

SUBSETS: Mapping[str, Sequence[str]] = {
    "stature and weight": ("stature", "weight"),
    "stature, weight, bust, hips": ("stature", "weight", "bust_girth", "hip_girth"),
    "seven": SEVEN,
    "bust, abdomen, hips and stature": ("stature", "bust_girth", "abdomen_girth", "hip_girth"),
}
"""What is entered, for the tables of coverage."""

TURNS = 10
"""Into so many parts all people are taken, to be held out one after another."""

MIXED_UP = 40
"""Of so many people of each kind values are mixed up on purpose."""


def coverage_of(
    law: Law, values: Mapping[str, Floats], entered: Sequence[str]
) -> dict[str, Floats]:
    """Whether a law's ranges hold the truth: by measurement not entered, (n,) of 0 and 1.

    Parameters
    ----------
    values : by measurement, what is true of n people: ndarrays of shape (n,), SI.
    """
    logs = np.full((len(values["stature"]), len(law.names)), np.nan)
    for name in entered:
        logs[:, law.names.index(name)] = np.log(values[name])
    means, covariances = law.given_rows(logs)
    deviations = np.sqrt(np.maximum(np.einsum("nii->ni", covariances), 0)) * law.calibration(means)
    reach = norm.ppf((1 + RANGE_SHARE) / 2)
    inside = {}
    for name, own in values.items():
        if name not in entered:
            i = law.names.index(name)
            off = np.abs(np.log(own) - means[:, i])
            inside[name] = (off <= reach * deviations[:, i]).astype(float)
    return inside


def coverage_table(
    kind: str, estimator: Estimator, values: Mapping[str, Floats]
) -> tuple[list[list[str]], list[list[str]]]:
    """Rows of coverage by subset: over measurements, and over bands of body-mass index.

    Values are as in `coverage_of`, here and below.
    """
    by_name, by_band = [], []
    index = values["weight"] / values["stature"] ** 2
    for words, entered in SUBSETS.items():
        inside = coverage_of(estimator.law, values, entered)
        together = np.array(list(inside.values())).mean(axis=0)
        shares = [f"{inside[n].mean():.2f}" if n in inside else "" for n in values]
        by_name.append([kind, words, f"{together.mean():.3f}", *shares])
        by_band.append([kind, words, *_by_band(together, index)])
    return by_name, by_band


def _by_band(shares: Floats, index: Floats) -> list[str]:
    """Means by band of body-mass index, with how many people there are."""
    cells = []
    for low, high in pairwise(INDEX_BANDS):
        mine = (index >= low) & (index < high)
        cells.append(f"{shares[mine].mean():.3f} ({mine.sum()})" if mine.any() else "none")
    return cells


def procedure_rows(people: Floats, entered: Sequence[str]) -> list[list[str]]:
    """How often ranges hold the truth of people whom their law did not see, all taking turns.

    Laws are learned and calibrated as the shipped one is, each on nine tenths of the people, and
    held against the other tenth: with each person held out once, chance counts for less than on
    those alone who are kept for tests.

    Parameters
    ----------
    people : ndarray of shape (n, len(FROM_SURVEY)), SI.

    Returns
    -------
    Rows of a table: each measurement that is not entered, then all, over everybody and by band.
    """
    turn = np.arange(len(people)) % TURNS
    columns = dict(zip(FROM_SURVEY, people.T, strict=True))
    inside = {name: np.empty(len(people)) for name in FROM_SURVEY if name not in entered}
    for one in range(TURNS):
        seen, mine = people[turn != one], turn == one
        law = calibrated(law_of(tuple(FROM_SURVEY), seen), seen)
        held_out = {name: column[mine] for name, column in columns.items()}
        for name, own in coverage_of(law, held_out, entered).items():
            inside[name][mine] = own
    index = columns["weight"] / columns["stature"] ** 2
    everything = {f"`{name}`": own for name, own in inside.items()}
    everything["all of these"] = np.array(list(inside.values())).mean(axis=0)
    return [
        [words, f"{own.mean():.3f}", *_by_band(own, index)] for words, own in everything.items()
    ]


# ---------------------------------------------------------------- doubts


def false_alarms(
    estimator: Estimator, values: Mapping[str, Floats], entered: Sequence[str]
) -> dict[str, float]:
    """By entered value, the share of people of whom it is doubted though it is true."""
    people = _people(values, entered)
    counts = dict.fromkeys(entered, 0)
    for number, person in enumerate(people, 1):
        for doubt in doubts(estimator, person):
            counts[doubt.measurement] += 1
        if number % 20 == 0 or number == len(people):
            said = f"\r{estimator.kind}: doubted {number} of {len(people)}"
            print(said, end="", flush=True)
    print()
    return {name: count / len(people) for name, count in counts.items()}


def _people(values: Mapping[str, Floats], entered: Sequence[str]) -> list[MeasurementSet]:
    rows = np.stack([values[name] for name in entered], axis=1).tolist()
    return [MeasurementSet(dict(zip(entered, row, strict=True))) for row in rows]


MixUp = tuple[str, str, Callable[[Mapping[str, float]], float]]

_POUND, _STONE = 0.45359237, 6.35029318

MIX_UPS: Mapping[str, MixUp] = {
    "inches read as centimetres": ("bust_girth", "unit_mix_up", lambda p: p["bust_girth"] / 2.54),
    "centimetres read as inches": ("hip_girth", "unit_mix_up", lambda p: p["hip_girth"] * 2.54),
    "inches read as centimetres, stature": (
        "stature", "unit_mix_up", lambda p: p["stature"] / 2.54),
    "metres read as centimetres": (
        "abdomen_girth", "unit_mix_up", lambda p: p["abdomen_girth"] / 100),
    "millimetres read as centimetres": (
        "neck_girth", "unit_mix_up", lambda p: p["neck_girth"] * 10),
    "pounds read as kilograms": ("weight", "unit_mix_up", lambda p: p["weight"] / _POUND),
    "kilograms read as pounds": ("weight", "unit_mix_up", lambda p: p["weight"] * _POUND),
    "stones read as kilograms": ("weight", "unit_mix_up", lambda p: p["weight"] / _STONE),
    "inseam to the floor": (
        "inseam_height", "neighbouring_definition",
        lambda p: p["inseam_height"] + p["foot_height"]),
    "inseam as trousers have it": (
        "inseam_height", "neighbouring_definition",
        lambda p: p["inseam_height"] + p["foot_height"] - TROUSERS_SHORT_OF_FLOOR),
    "hips for the abdomen": (
        "abdomen_girth", "neighbouring_definition", lambda p: p["hip_girth"]),
    "under bust for the bust": (
        "bust_girth", "neighbouring_definition", lambda p: p["underbust_girth"]),
    "waist for the abdomen": (
        "abdomen_girth", "neighbouring_definition", lambda p: p["waist_girth"]),
    "mid thigh for the thigh": (
        "thigh_girth", "neighbouring_definition", lambda p: p["mid_thigh_girth"]),
}  # fmt: skip
"""Mistakes made on purpose: in which value, what it is to be recognised as, and the value."""


def recognised(
    estimator: Estimator, values: Mapping[str, Floats]
) -> dict[str, tuple[float, float]]:
    """By mistake: the share of people of whom the value is doubted, and recognised as what it is.

    What the survey has not, such as the under bust, is what the law expects of the person.
    """
    law = estimator.law
    count = min(MIXED_UP, len(values["stature"]))
    logs = np.full((count, len(TAKEN)), np.nan)
    for name in FROM_SURVEY:
        logs[:, law.names.index(name)] = np.log(values[name][:count])
    everything = np.exp(np.where(np.isnan(logs), law.given_rows(logs)[0], logs))
    shares = {}
    for words, (name, code, mistaken) in MIX_UPS.items():
        doubted = right = 0
        for row in everything.tolist():
            person = dict(zip(law.names, row, strict=True))
            entered = MeasurementSet({n: person[n] for n in EIGHT} | {name: mistaken(person)})
            found = [one for one in doubts(estimator, entered) if one.measurement == name]
            doubted += bool(found)
            right += any(_is_right(one, code, person[name]) for one in found)
        shares[words] = (doubted / count, right / count)
        print(f"\r{estimator.kind}: mixed up {len(shares)} of {len(MIX_UPS)}", end="", flush=True)
    print()
    return shares


def _is_right(doubt: Doubt, code: str, true: float) -> bool:
    if doubt.code != code or doubt.suggestion is None:
        return False
    return code != "unit_mix_up" or abs(doubt.suggestion / true - 1) < 0.01
