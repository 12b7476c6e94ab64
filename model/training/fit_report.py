"""How well fitted bodies measure what was asked and what was not: tables of docs/validation.md."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from model.anthropometry import TAKEN, measure
from model.estimators import Estimator
from model.geometry import Booleans, Floats
from model.measurements import MEASUREMENTS, MeasurementSet
from model.tape_fit import fit_to_tape
from model.training.survey import FROM_SURVEY, INDEX_BANDS, STATURE_BANDS

SEVEN = (
    "stature",
    "weight",
    "bust_girth",
    "hip_girth",
    "neck_girth",
    "abdomen_girth",
    "inseam_height",
)
"""What a shopper who has a tape at hand enters; a plain regression is compared on these."""

EIGHT = (*SEVEN, "thigh_girth")
"""The same, and one the more: as many as the paper evaluates."""

MET: Mapping[str, float] = {"m": 0.001, "kg": 0.1}
"""By unit, what a value may be missed by and is still met."""


@dataclass(frozen=True, eq=False)
class Fits:
    """Fitted bodies of some people or bodies, and what is true of them.

    Attributes
    ----------
    entered : what was asked.
    values : by measurement, what is true: ndarray of shape (n,), SI.
    linear, taken : ndarrays of shape (n, M), what the linear estimate and the fitted body measure.
    low, high : ndarrays of shape (n, M), the printed ranges.
    vertices, linear_vertices : ndarrays of shape (n,), mean distance of the fitted body's and
        the linear estimate's vertices from the true ones, metres; empty if not known.
    seconds : ndarray of shape (n,), of one processor for the fit.
    """

    entered: Sequence[str]
    values: Mapping[str, Floats]
    linear: Floats
    taken: Floats
    low: Floats
    high: Floats
    vertices: Floats
    linear_vertices: Floats
    seconds: Floats

    def misses(self, name: str, *, linear: bool = False) -> Floats:
        """What bodies measure less what is true: ndarray of shape (n,), SI."""
        of = self.linear if linear else self.taken
        return of[:, TAKEN.index(name)] - self.values[name]

    def sums(self, *, linear: bool = False) -> Floats:
        """The paper's total distance error over entered lengths, by person: (n,), metres."""
        lengths = [name for name in self.entered if MEASUREMENTS[name].kind != "mass"]
        misses: Floats = np.abs([self.misses(name, linear=linear) for name in lengths]).sum(axis=0)
        return misses

    def met(self) -> Booleans:
        """Whether everything that was entered is met: ndarray of shape (n,)."""
        kept = [np.abs(self.misses(n)) <= MET[MEASUREMENTS[n].unit] for n in self.entered]
        return np.all(kept, axis=0)


def fit_all(
    estimator: Estimator,
    values: Mapping[str, Floats],
    entered: Sequence[str],
    vertices: Floats | None = None,
) -> Fits:
    """Fits a body to each person's entered values, showing progress.

    Parameters
    ----------
    values : by measurement, what is true of n people: ndarrays of shape (n,), SI.
    vertices : ndarray of shape (n, V, 3), metres: the true bodies, where they are known.
    """
    count = len(values["stature"])
    linear, taken, low, high = (np.empty((count, len(TAKEN))) for _ in range(4))
    apart: list[tuple[float, float]] = []
    seconds = np.empty(count)
    for row in range(count):
        asked = MeasurementSet({name: float(values[name][row]) for name in entered})
        estimate = estimator.estimate(asked)
        linear[row] = list(measure(estimate).values.values())
        begun = time.thread_time()
        body = fit_to_tape(estimator, asked).body
        seconds[row] = time.thread_time() - begun
        measured = measure(body).values
        taken[row] = list(measured.values())
        ranges = estimator.ranges(asked, measured)
        low[row], high[row] = np.array([ranges[name] for name in TAKEN]).T
        if vertices is not None:
            off = [np.linalg.norm(b.vertices - vertices[row], axis=1) for b in (body, estimate)]
            apart.append((float(off[0].mean()), float(off[1].mean())))
        if row % 20 == 19 or row == count - 1:
            print(f"\r{estimator.kind}: fitted {row + 1} of {count}", end="", flush=True)
    print()
    fitted, estimated = np.array(apart).reshape(-1, 2).T
    return Fits(entered, values, linear, taken, low, high, fitted, estimated, seconds)


def regression(seen: Mapping[str, Floats], fits: Fits) -> dict[str, Floats]:
    """A plain regression's misses of what was not entered, learned from the survey's people.

    Parameters
    ----------
    seen : by measurement, of the people that are not kept for tests: ndarray of shape (n,), SI.
    fits : of other people, whose misses are wanted.

    Returns
    -------
    By measurement, what it estimates less what is true: ndarray of shape (n,), SI.
    """

    def design(values: Mapping[str, Floats]) -> Floats:
        columns = [values[name] for name in fits.entered]
        return np.column_stack([np.ones(len(columns[0])), *columns])

    laws = {
        name: np.linalg.lstsq(design(seen), seen[name], rcond=None)[0]
        for name in FROM_SURVEY
        if name not in fits.entered
    }
    return {name: design(fits.values) @ law - fits.values[name] for name, law in laws.items()}


# ---------------------------------------------------------------- tables

ENTERED_HEAD = [
    "",
    "people",
    "entered",
    "linear: sum, mean",
    "linear: largest",
    "fitted: sum, mean (mm)",
    "fitted: sum, 95 % (mm)",
    "fitted: largest (mm)",
    "all met",
    "time of a fit on one core, median (ms)",
]


def entered_row(kind: str, fits: Fits) -> list[str]:
    """A row under `ENTERED_HEAD`; the linear estimate's errors are in centimetres."""
    lengths = [name for name in fits.entered if MEASUREMENTS[name].kind != "mass"]
    largest = [
        max(np.abs(fits.misses(name, linear=linear)).max() for name in lengths)
        for linear in (True, False)
    ]
    sums = fits.sums()
    return [
        kind,
        str(len(sums)),
        str(len(fits.entered)),
        f"{fits.sums(linear=True).mean() * 100:.2f}",
        f"{largest[0] * 100:.2f}",
        f"{sums.mean() * 1e3:.2f}",
        f"{np.quantile(sums, 0.95) * 1e3:.2f}",
        f"{largest[1] * 1e3:.2f}",
        f"{100 * fits.met().mean():.1f} %",
        f"{np.median(fits.seconds) * 1e3:.0f}",
    ]


NOT_ENTERED_HEAD = ["", "measurement", "regression", "linear", "fitted", "fitted / regression"]


def not_entered_rows(kind: str, fits: Fits, regressed: Mapping[str, Floats]) -> list[list[str]]:
    """Mean absolute errors of what was not entered, beside the regression's, in mm."""
    rows = []
    for name, theirs in regressed.items():
        sizes = [np.abs(misses).mean() * 1e3 for misses in (
            theirs, fits.misses(name, linear=True), fits.misses(name))]  # fmt: skip
        cells = [f"{size:.1f}" for size in sizes]
        rows.append([kind, f"`{name}`", *cells, f"{sizes[2] / sizes[0]:.2f}"])
    return rows


def band_heads(bands: Sequence[float], scale: float = 1.0) -> list[str]:
    """A column's head for each band between two edges, such as "16 to 18.5"."""
    return [f"{a * scale:g} to {b * scale:g}" for a, b in pairwise(bands)]


def by_band(fits: Fits, of: str, share: Callable[[Booleans], str]) -> list[str]:
    """A cell for each band of body-mass index or stature: `share` of its people, and how many."""
    stature = fits.values["stature"]
    index = fits.values["weight"] / stature**2
    along, bands = (index, INDEX_BANDS) if of == "index" else (stature, STATURE_BANDS)
    cells = []
    for low, high in pairwise(bands):
        mine = (along >= low) & (along < high)
        cells.append(f"{share(mine)} ({mine.sum()})" if mine.any() else "none")
    return cells


def band_rows(kind: str, fits: Fits, of: str) -> list[list[str]]:
    """Errors by band: of what was entered, of what was not, and of the surface."""
    known = [n for n in fits.values if n not in fits.entered and MEASUREMENTS[n].kind != "mass"]
    others = np.abs([fits.misses(name) for name in known]).mean(axis=0)
    sums = fits.sums()
    rows = [
        [kind, "entered, sum", *by_band(fits, of, lambda mine: f"{sums[mine].mean() * 1e3:.2f}")],
        [kind, "not entered", *by_band(fits, of, lambda mine: f"{others[mine].mean() * 1e3:.1f}")],
    ]
    if fits.vertices.size:
        cells = by_band(fits, of, lambda mine: f"{fits.vertices[mine].mean() * 1e3:.1f}")
        rows.append([kind, "vertices", *cells])
    return rows


def coverage_rows(kind: str, fits: Fits) -> list[list[str]]:
    """How often printed ranges hold the truth, by band of body-mass index, and in all."""
    rows, inside = [], []
    for name, values in fits.values.items():
        if name in fits.entered:
            continue
        place = TAKEN.index(name)
        inside.append((values >= fits.low[:, place]) & (values <= fits.high[:, place]))
        rows.append(_coverage_row(kind, f"`{name}`", fits, inside[-1]))
    together = np.array(inside).mean(axis=0)
    return [*rows, _coverage_row(kind, "all of these", fits, together)]


def _coverage_row(kind: str, name: str, fits: Fits, inside: Floats | Booleans) -> list[str]:
    bands = by_band(fits, "index", lambda mine: f"{inside[mine].mean():.2f}")
    return [kind, name, f"{inside.mean():.3f}", *bands]
