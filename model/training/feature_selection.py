"""Which measurements to ask for: the paper's choice of seven (section 4.1.1), step by step.

Reference: *Estimating Body Shapes From Body Measurements*, 4.1.1 and Table 4. Outliers beyond
mean ± 3 standard deviations become missing; measurements with many are left out; values are
scaled to 0..1 and sorted by variance; of the ten that vary most, those are dropped that
others tell. The paper states no thresholds: `ERROR_PRONE` and `TOLD` are ours.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from model.estimators import LinearBodyEstimator
from model.geometry import Booleans, Floats, Integers
from model.measurements import MEASUREMENTS
from model.training.survey import Sex

DEVIATIONS = 3.0
"""A value further than this many standard deviations from the mean is an outlier (4.1.1)."""

ERROR_PRONE = 0.01
"""A measurement with a larger share of outliers is left out. The paper leaves four girths out
and states no share; a normal law has 0.0027."""

TOP = 10
"""How many of the most varying measurements are looked at more closely (4.1.1)."""

SELECTED = 7
"""How many are chosen in the end (4.1.1)."""

DRAWS = 200
"""How often people are drawn anew to see how firm a choice is."""

TOLD = 0.5
"""The share of a measurement's variance that another must tell for it to be dropped: a
correlation of 0.71. The paper calls such pairs highly correlated and states no number."""

TABLE_4: Mapping[Sex, tuple[str, ...]] = MappingProxyType(
    {
        "female": (
            "bust_girth",
            "hip_girth",
            "abdomen_girth",
            "thigh_girth",
            "stature",
            "waist_girth",
            "mid_thigh_girth",
        ),
        "male": (
            "bust_girth",
            "hip_girth",
            "thigh_girth",
            "waist_girth",
            "abdomen_girth",
            "stature",
            "neck_girth",
        ),
    }
)
"""The paper's subsets of seven, by falling variance."""

PAPER_LEFT_OUT = ("underbust_girth", "upper_arm_girth", "armscye_girth", "knee_girth")
"""The four girths that the paper leaves out for their outliers (4.1.1; "bicep girth" there)."""

PAPER_DROPPED: Mapping[Sex, tuple[str, ...]] = MappingProxyType(
    {
        "female": ("waist_height", "inseam_height", "hip_to_ankle_height"),
        "male": ("waist_height", "rise_length", "underbust_to_belly_button_length"),
    }
)
"""What the paper drops of each top ten. It names the two lengths (4.1.1) and how many heights;
which heights follows from those that its evaluation reports (5.4)."""


@dataclass(frozen=True, eq=False)
class Selection:
    """The steps of the choice, and the choice.

    Attributes
    ----------
    names : the m measurements chosen from.
    outliers : ndarray of shape (m,), how many values became missing.
    error_prone : those left out for their outliers.
    low, high : ndarrays of shape (m,), the ends that were scaled to 0 and 1, SI units.
    scaled : ndarray of shape (n, m), the values from 0 to 1, NaN for outliers.
    variances : ndarray of shape (m,), of the scaled values.
    top : the ten that vary most, by falling variance.
    judged : `top`, and stature where it is not among them.
    correlations : ndarray of shape (j, j), of `judged`.
    told : of those dropped, by which other measurement they are told.
    selected : the seven.
    """

    names: tuple[str, ...]
    outliers: Integers
    error_prone: tuple[str, ...]
    low: Floats
    high: Floats
    scaled: Floats
    variances: Floats
    top: tuple[str, ...]
    judged: tuple[str, ...]
    correlations: Floats
    told: Mapping[str, str]
    selected: tuple[str, ...]

    def correlation(self, one: str, other: str) -> float:
        """Between two of `judged`."""
        return float(self.correlations[self.judged.index(one), self.judged.index(other)])


def candidates(names: Sequence[str]) -> tuple[str, ...]:
    """Those to choose from: all that are measured with a tape. The paper has no weight."""
    return tuple(name for name in names if MEASUREMENTS[name].kind != "mass")


def select(names: Sequence[str], values: Floats) -> Selection:
    """Chooses seven measurements.

    Parameters
    ----------
    names : the m measurements, stature among them.
    values : ndarray of shape (n, m), SI units.

    Raises
    ------
    ValueError
        Where stature is not among the names, or values are of another width.
    """
    names = tuple(names)
    if "stature" not in names:
        raise ValueError(f"heights are told by stature, which is not among {names}")
    if values.shape[1:] != (len(names),):
        raise ValueError(f"values of shape {values.shape} are not of {len(names)} measurements")
    outlying = find_outliers(values)
    kept = np.where(outlying, np.nan, values)
    low, high = np.nanmin(kept, axis=0), np.nanmax(kept, axis=0)
    scaled = (kept - low) / (high - low)
    variances = np.nanvar(scaled, axis=0, ddof=1)
    error_prone = outlying.mean(axis=0) > ERROR_PRONE
    ranked = [names[i] for i in np.argsort(-variances, kind="stable") if not error_prone[i]]
    top = tuple(ranked[:TOP])
    judged = top if "stature" in top else (*top, "stature")
    correlations = correlate(kept[:, [names.index(name) for name in judged]])
    told, selected = _prune(top, judged, correlations)
    if len(selected) < SELECTED:
        selected += [name for name in ranked[TOP:] if name not in selected]
    return Selection(
        names=names,
        outliers=outlying.sum(axis=0),
        error_prone=tuple(np.array(names)[error_prone].tolist()),
        low=low,
        high=high,
        scaled=scaled,
        variances=variances,
        top=top,
        judged=judged,
        correlations=correlations,
        told=told,
        selected=tuple(selected[:SELECTED]),
    )


def find_outliers(values: Floats) -> Booleans:
    """Which values lie beyond mean ± 3 standard deviations: (n, m), NaN never."""
    centre, spread = np.nanmean(values, axis=0), np.nanstd(values, axis=0, ddof=1)
    return np.abs(values - centre) > DEVIATIONS * spread


def scaled_variances(values: Floats) -> Floats:
    """The variances of columns without outliers, scaled from 0 to 1: (m,) of (n, m)."""
    kept = np.where(find_outliers(values), np.nan, values)
    reach = np.nanmax(kept, axis=0) - np.nanmin(kept, axis=0)
    variances: Floats = np.nanvar(kept, axis=0, ddof=1) / reach**2
    return variances


def correlate(values: Floats) -> Floats:
    """Correlations of columns over the rows where both are known: (m, m) of (n, m)."""
    count = values.shape[1]
    correlations = np.eye(count)
    there = ~np.isnan(values)
    for i in range(count):
        for j in range(i):
            both = there[:, i] & there[:, j]
            pair = np.asarray(np.corrcoef(values[both, i], values[both, j]))
            correlations[i, j] = correlations[j, i] = pair[0, 1]
    return correlations


def _prune(
    top: Sequence[str], judged: Sequence[str], correlations: Floats
) -> tuple[dict[str, str], list[str]]:
    """Drops what others tell: heights that stature tells, lengths that a girth tells.

    Girths never give way, as in the paper, which keeps six of them however alike they are.
    Stature stands in for the first height that it tells, where it is not among the top.
    """
    shares = correlations**2
    place = {name: i for i, name in enumerate(judged)}
    girths = [name for name in top if MEASUREMENTS[name].kind == "girth"]
    told: dict[str, str] = {}
    selected: list[str] = []
    for name in top:
        kind = MEASUREMENTS[name].kind
        tellers = {"height": ["stature"], "length": girths}.get(kind, [])
        tellers = [other for other in tellers if other != name]
        teller = max(tellers, key=lambda t: shares[place[t], place[name]], default=None)
        if teller is None or shares[place[teller], place[name]] < TOLD:
            selected.append(name)
            continue
        told[name] = teller
        if teller not in top and teller not in selected:
            selected.append(teller)
    return told, selected


@dataclass(frozen=True, eq=False)
class Stability:
    """How often measurements are chosen from other people of the same population.

    Attributes
    ----------
    top, selected : by measurement, the share of rounds in which it was among the ten, the
        seven.
    """

    top: Mapping[str, float]
    selected: Mapping[str, float]


def stability(
    names: Sequence[str],
    values: Floats,
    *,
    seed: int,
    weights: Floats | None = None,
    rounds: int = DRAWS,
) -> Stability:
    """Chooses again and again from as many people, drawn from these with replacement.

    Parameters
    ----------
    names, values : as in `select`.
    weights : ndarray of shape (n,), how likely each is drawn; alike by default.
    """
    random = np.random.default_rng(seed)
    share = None if weights is None else weights / weights.sum()
    top, selected = (dict.fromkeys(names, 0) for _ in range(2))
    for _ in range(rounds):
        drawn = random.choice(len(values), size=len(values), p=share)
        choice = select(names, values[drawn])
        for name in choice.top:
            top[name] += 1
        for name in choice.selected:
            selected[name] += 1
    return Stability(
        *({name: hits / rounds for name, hits in counts.items()} for counts in (top, selected))
    )


def best_for_shape(
    linear: LinearBodyEstimator, names: Sequence[str], allowed: Sequence[str], count: int = SELECTED
) -> tuple[str, ...]:
    """The measurements that tell most about the body, each added to those before it.

    Beside the paper's choice, which looks at measurements alone: here the squared error of
    the linear law of the chosen ones is made as small as one addition can.

    Parameters
    ----------
    linear : fitted on coordinates whose squared differences add up to squared distances.
    names : its measurements, in its order.
    allowed : those to choose from.
    """
    moments, across = linear.moments_, linear.cross_moments_
    covariance = moments[1:, 1:] - np.outer(moments[0, 1:], moments[0, 1:])
    with_shape = across[:, 1:] - np.outer(across[:, 0], moments[0, 1:])
    places = {name: names.index(name) for name in allowed}
    chosen: list[str] = []

    def told(subset: list[str]) -> float:
        """The variance of the body that a subset tells."""
        use = [places[name] for name in subset]
        by = with_shape[:, use]
        return float(np.sum(by * np.linalg.solve(covariance[np.ix_(use, use)], by.T).T))

    while len(chosen) < min(count, len(allowed)):
        rest = [name for name in allowed if name not in chosen]
        chosen.append(max(rest, key=lambda name: told([*chosen, name])))
    return tuple(chosen)
