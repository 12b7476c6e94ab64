"""ANSUR II: its statistics, people drawn from them, and how its columns are measured on a body.

The 2012 Anthropometric Survey of U.S. Army Personnel, public domain (Gordon et al. 2014,
NATICK/TR-15/007; definitions: Hotzman et al. 2011, NATICK/TR-11/017). The project keeps
means, deviations and correlations of the logarithms, never rows.
"""

import csv
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from model.anthropometry import (
    ARM,
    BUTTOCKS,
    ELBOW,
    HIP,
    HIPS,
    KNEE,
    LEG,
    SHOULDER,
    TAPES,
    THELIA,
    TRUNK,
)
from model.geometry import Floats
from model.girths import Extent, Girth
from model.tapes import Height, Span, Tape
from model.template_mesh import DATA

Sex = Literal["female", "male"]
SEXES: tuple[Sex, Sex] = ("female", "male")


def _level(*landmarks: str) -> Girth:
    """The trunk at the level of landmarks."""
    return Girth(HIPS, landmarks, ("suprasternale",))


_CHEST = Girth(TRUNK, THELIA, ("suprasternale",))
_NAVEL = _level("omphalion")
_BUTTOCK = _level(*BUTTOCKS)

SURVEY_TAPES: Mapping[str, Tape] = {
    "stature": TAPES["stature"],
    "weightkg": TAPES["weight"],
    "chestcircumference": TAPES["bust_girth"],
    "waistcircumference": TAPES["abdomen_girth"],
    "buttockcircumference": TAPES["hip_girth"],
    "thighcircumference": TAPES["thigh_girth"],
    "lowerthighcircumference": Girth(LEG, HIP, KNEE, (0.86, 0.86), cut="across", reach=0.08),
    "calfcircumference": TAPES["calf_girth"],
    "anklecircumference": TAPES["ankle_girth"],
    "neckcircumference": TAPES["neck_girth"],
    "bicepscircumferenceflexed": Girth(
        ARM, SHOULDER, ELBOW, (0.35, 0.75), "widest", cut="across", planes=9, reach=0.06
    ),
    "forearmcircumferenceflexed": TAPES["lower_arm_girth"],
    "wristcircumference": TAPES["wrist_girth"],
    "headcircumference": TAPES["head_girth"],
    "crotchheight": Height(("crotch",)),
    "lateralmalleolusheight": TAPES["foot_height"],
    "kneeheightmidpatella": Height(("midpatella_left",)),
    "buttockheight": Height(("buttock_point_left",)),
    "waistheightomphalion": Height(("omphalion",)),
    "chestheight": Height(("thelion_left",)),
    "axillaheight": Height(("axilla_left",)),
    "acromialheight": Height(("acromion_left",)),
    "suprasternaleheight": Height(("suprasternale",)),
    "cervicaleheight": Height(("cervicale",)),
    "biacromialbreadth": Span("acromion_left", "acromion_right"),
    "acromionradialelength": Span("acromion_left", "radiale_left"),
    "radialestylionlength": Span("radiale_left", "stylion_left"),
    "footlength": Span("heel_left", "toe_tip_left"),
    "handlength": Span("stylion_left", "dactylion_left"),
    "chestdepth": Extent(_CHEST, "depth"),
    "waistbreadth": Extent(_NAVEL, "breadth"),
    "waistdepth": Extent(_NAVEL, "depth"),
    "hipbreadth": Extent(_BUTTOCK, "breadth"),
    "buttockdepth": Extent(_BUTTOCK, "depth"),
}
"""The survey's columns that bodies are fitted to, and the tape of each."""

FROM_SURVEY: Mapping[str, tuple[str, ...]] = {
    "stature": ("stature",),
    "weight": ("weightkg",),
    "head_girth": ("headcircumference",),
    "bust_girth": ("chestcircumference",),
    "hip_girth": ("buttockcircumference",),
    "ankle_girth": ("anklecircumference",),
    "neck_girth": ("neckcircumference",),
    "wrist_girth": ("wristcircumference",),
    "thigh_girth": ("thighcircumference",),
    "calf_girth": ("calfcircumference",),
    "abdomen_girth": ("waistcircumference",),
    "inseam_height": ("crotchheight", "lateralmalleolusheight"),
    "foot_height": ("lateralmalleolusheight",),
}
"""Measurements that a real person of the survey has: a column, or one less another."""

TEST_SHARE = 5
"""One real person in so many is kept for tests: nothing that trains or calibrates sees them."""


@dataclass(frozen=True)
class SurveyStatistics:
    """The survey of one sex; all of logarithms of SI values.

    Attributes
    ----------
    people : how many were measured.
    columns : the survey's names.
    means, deviations : ndarrays of shape (C,).
    correlations : ndarray of shape (C, C).
    """

    people: int
    columns: tuple[str, ...]
    means: Floats
    deviations: Floats
    correlations: Floats

    def covariance(self) -> Floats:
        """Of the logarithms: (C, C)."""
        return self.correlations * np.outer(self.deviations, self.deviations)


def statistics_path(sex: Sex) -> Path:
    """Where the project keeps the statistics of one sex."""
    return DATA / "survey" / f"ansur2_{sex}.csv"


def load_statistics(sex: Sex) -> SurveyStatistics:
    """The statistics of one sex, from the project's table."""
    with statistics_path(sex).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    columns = tuple(row["column"] for row in rows)
    return SurveyStatistics(
        people=int(rows[0]["people"]),
        columns=columns,
        means=np.array([float(row["log_mean"]) for row in rows]),
        deviations=np.array([float(row["log_deviation"]) for row in rows]),
        correlations=np.array([[float(row[name]) for name in columns] for row in rows]),
    )


def read_people(path: Path) -> tuple[list[str], Floats]:
    """Real people's rows of a survey file.

    Returns
    -------
    ids : subject numbers.
    values : ndarray of shape (n, C), SI units, in the order of `SURVEY_TAPES`.
    """
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    scale = {"weightkg": 0.1}
    values = [[float(row[name]) * scale.get(name, 1e-3) for name in SURVEY_TAPES] for row in rows]
    return [row["subjectid"] for row in rows], np.array(values)


def is_test_person(subject: str) -> bool:
    """Whether a real person is kept for tests; settled by their number alone."""
    return zlib.crc32(subject.encode()) % TEST_SHARE == 0


def write_statistics(sex: Sex, rows: Path) -> SurveyStatistics:
    """Computes the table of one sex from the survey's rows, without the test people."""
    subjects, values = read_people(rows)
    seen = np.array([not is_test_person(subject) for subject in subjects])
    logs = np.log(values[seen])
    correlations = np.corrcoef(logs.T)
    columns = tuple(SURVEY_TAPES)
    path = statistics_path(sex)
    path.parent.mkdir(exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            ["column", "people", "mean", "deviation", "log_mean", "log_deviation", *columns]
        )
        for i, name in enumerate(columns):
            column = values[seen, i]
            numbers = [column.mean(), column.std(ddof=1), logs[:, i].mean(), logs[:, i].std(ddof=1)]
            writer.writerow(
                [name, int(seen.sum())]
                + [f"{number:.6f}" for number in numbers]
                + [f"{number:.4f}" for number in correlations[i]]
            )
    return load_statistics(sex)


@dataclass(frozen=True)
class People:
    """People drawn from the survey's statistics.

    Attributes
    ----------
    values : ndarray of shape (n, C), SI units, in the order of `SURVEY_TAPES`.
    log_odds : ndarray of shape (n,), the logarithm of how much likelier each person's
        stature and weight are in the survey than in the draw: weights that turn the wide
        draw back into the survey.
    """

    values: Floats
    log_odds: Floats


BODY_MASS_INDEX = (16.0, 50.0)
"""The range that the population covers, in kg/m²."""

INDEX_BANDS = (16.0, 18.5, 25.0, 30.0, 35.0, 40.0, 51.0)
"""Edges of the bands in which errors are shown, in kg/m²: those of the World Health
Organization's classes, with room for misses of the weight at the upper end."""

STATURE_BANDS = (1.35, 1.55, 1.65, 1.75, 1.85, 2.15)
"""Edges of the bands of stature in which errors are shown, in metres."""

WIDE_SHARE = 0.6
"""The share of people whose index is drawn evenly (in its logarithm) over the whole range;
the others' follows the survey."""

STATURE_WIDENING = 1.15
"""How much wider than the survey's the draw of statures is."""


def draw_people(statistics: SurveyStatistics, count: int, random: np.random.Generator) -> People:
    """Draws people: stature and index widely, the rest as the survey says given those.

    The other measurements follow the log-linear regression on stature and weight that the
    survey's covariance implies, with its residual covariance.
    """
    columns = list(statistics.columns)
    known = [columns.index("stature"), columns.index("weightkg")]
    rest = [i for i in range(len(columns)) if i not in known]
    covariance = statistics.covariance()
    stature_mean, stature_deviation = statistics.means[known[0]], statistics.deviations[known[0]]
    # The index given stature, in logarithms: weight less twice stature.
    slope = covariance[known[1], known[0]] / covariance[known[0], known[0]] - 2
    spread = np.sqrt(
        covariance[known[1], known[1]] - covariance[known[0], known[1]] ** 2 / stature_deviation**2
    )
    low, high = np.log(BODY_MASS_INDEX)

    standard = np.clip(random.normal(size=count), -2.8, 2.8)
    stature = stature_mean + STATURE_WIDENING * stature_deviation * standard
    centre = statistics.means[known[1]] - 2 * stature_mean + slope * (stature - stature_mean)
    surveyed = centre + spread * random.normal(size=count)
    wide = random.uniform(low, high, size=count)
    index = np.where(
        (random.uniform(size=count) < WIDE_SHARE) | (surveyed < low) | (surveyed > high),
        wide,
        surveyed,
    )
    logs = np.empty((count, len(columns)))
    logs[:, known] = np.stack([stature, index + 2 * stature], axis=1)
    regression = np.linalg.solve(covariance[np.ix_(known, known)], covariance[np.ix_(known, rest)])
    residual = covariance[np.ix_(rest, rest)] - covariance[np.ix_(rest, known)] @ regression
    noise = random.multivariate_normal(np.zeros(len(rest)), residual, size=count, method="eigh")
    # No one is drawn with a value beyond three residual deviations.
    limit = 3 * np.sqrt(np.diag(residual))
    logs[:, rest] = (
        statistics.means[rest]
        + (logs[:, known] - statistics.means[known]) @ regression
        + np.clip(noise, -limit, limit)
    )

    def log_normal(x: Floats, mean: Floats | float, deviation: float) -> Floats:
        return -0.5 * ((x - mean) / deviation) ** 2 - np.log(deviation)

    in_survey = log_normal(index, centre, float(spread))
    even = np.log(np.sqrt(2 * np.pi) / (high - low))
    drawn = np.logaddexp(np.log(WIDE_SHARE) + even, np.log(1 - WIDE_SHARE) + in_survey)
    taller = log_normal(stature, stature_mean, stature_deviation)
    taller -= log_normal(stature, stature_mean, STATURE_WIDENING * stature_deviation)
    return People(values=np.exp(logs), log_odds=in_survey - drawn + taller)
