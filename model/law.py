"""How people's measurements go together: one joint law, from which follows that of any subset.

The law is of natural logarithms: what is alike among slight and heavy people are ratios.
Stature and weight are normal. The others follow them: a mean that is linear in both and bends
with the body-mass index, and about it normal deviations, whose size changes with the index.

Of what is known, the index is estimated first; at that index all is normal, and what is not
known follows in closed form (Anderson 2003, *An Introduction to Multivariate Statistical
Analysis*, theorem 2.5.1).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri

from model.geometry import Floats
from model.measurements import MEASUREMENTS, MeasurementSet

LEAST_NOISE = 1e-3
"""No value is told more exactly than this share of itself: a millimetre of a metre. Values that
follow from one another can then stand together."""

TAPE_NOISE: Mapping[str, float] = {
    name: {"mass": 0.1, "height": 0.005, "length": 0.005, "girth": 0.006}[row.kind]
    for name, row in MEASUREMENTS.items()
} | {
    "stature": 0.005,
    "bust_girth": 0.0075,
    "underbust_girth": 0.0075,
    "waist_girth": 0.006,
    "abdomen_girth": 0.006,
    "hip_girth": 0.006,
    "neck_girth": 0.0055,
    "head_girth": 0.0025,
    "ankle_girth": 0.002,
    "wrist_girth": 0.002,
    "foot_height": 0.002,
    "inseam_height": 0.005,
}
"""Standard deviation of one careful reading, SI: half of the error that the survey allowed its
measurers (ANSUR: chest 15, hips and waist 12, neck 11, stature and crotch height 10, head 5,
ankle 4 mm), which nineteen of twenty repeated readings keep. Where it names none, that of the
nearest kind."""

WIDE_INDEX = (16.0, 50.0)
"""The body-mass indices, kg/m², that a wide law holds equally possible, in their logarithm."""

INDEX_ROUNDS = 3
"""How often the index is estimated anew; it is exact at once where stature and weight are known."""


@dataclass(frozen=True, eq=False)
class Given:
    """What the law says of everything, some values being known; of natural logarithms.

    Attributes
    ----------
    names : of the measurements.
    means : ndarray of shape (m,).
    covariance : ndarray of shape (m, m), of what stays unknown, calibrated.
    """

    names: tuple[str, ...]
    means: Floats
    covariance: Floats

    def deviation(self, name: str) -> float:
        """The standard deviation of a measurement's logarithm."""
        place = self.names.index(name)
        return float(np.sqrt(max(self.covariance[place, place], 0)))

    def range(self, name: str, share: float) -> tuple[float, float, float]:
        """The low end, the middle and the high end between which a share of people lie, SI."""
        middle = self.means[self.names.index(name)]
        reach = ndtri((1 + share) / 2) * self.deviation(name)
        low, centre, high = np.exp([middle - reach, middle, middle + reach]).tolist()
        return low, centre, high

    def score(self, name: str, value: float) -> float:
        """How many standard deviations an SI value lies above the expected one."""
        above = np.log(value) - self.means[self.names.index(name)]
        return float(above / max(self.deviation(name), LEAST_NOISE))


@dataclass(frozen=True, eq=False)
class Law:
    """The joint law of people's measurements; of natural logarithms of SI values.

    Attributes
    ----------
    names : of the measurements; the first two are stature and weight.
    means : ndarray of shape (m,), at mean stature and weight.
    slopes : ndarray of shape (m, 2), by stature and weight; of those two, 1 by themselves.
    bends : ndarray of shape (m,), by the squared difference of the index from that of the means.
    widenings : ndarray of shape (m,), of the logarithm of a deviation, by that difference.
    covariance : ndarray of shape (m, m): the first two rows and columns are of stature and
        weight, the others of what is left of each measurement given those; at the means' index.
    reach : the least and the most such difference that people were seen with; beyond it, bends
        and widenings stay as they are there.
    factors, factor_slopes : ndarrays of shape (m,), by which deviations are multiplied, and how
        the logarithm of that goes with the difference of the index: calibration.
    """

    names: tuple[str, ...]
    means: Floats
    slopes: Floats
    bends: Floats
    widenings: Floats
    covariance: Floats
    reach: tuple[float, float]
    factors: Floats
    factor_slopes: Floats

    def given(
        self, known: MeasurementSet, noise: Mapping[str, float] | None = None, *, wide: bool = False
    ) -> Given:
        """What follows from known values.

        Parameters
        ----------
        noise : by measurement, the standard deviation of a known value about the true one, SI,
            beyond that of the trained hands that the law was learned from.
        wide : whether all body-mass indices are held equally possible beforehand.
        """
        values = np.full((1, len(self.names)), np.nan)
        for name, value in known.items():
            values[0, self.names.index(name)] = np.log(value)
        variances = np.full(len(self.names), LEAST_NOISE**2)
        for name in known:
            if noise and name in noise:
                variances[self.names.index(name)] += (noise[name] / known[name]) ** 2
        means, covariances = self.given_rows(values, variances, wide=wide)
        factors = self.calibration(means)[0]
        return Given(self.names, means[0], covariances[0] * np.outer(factors, factors))

    def calibration(self, means: Floats) -> Floats:
        """By what the deviations of people with these means, (n, m), are multiplied: (n, m)."""
        return self.factors * np.exp(self.factor_slopes * self.within(means)[:, None])

    def within(self, means: Floats) -> Floats:
        """How far the index that follows from means (n, m) differs, kept within reach: (n,)."""
        apart = means[:, :2] - self.means[:2]
        return np.clip(apart[:, 1] - 2 * apart[:, 0], *self.reach)

    def given_rows(
        self, logs: Floats, variances: Floats | float = LEAST_NOISE**2, *, wide: bool = False
    ) -> tuple[Floats, Floats]:
        """What follows for many people of whom the same is known; not calibrated.

        Parameters
        ----------
        logs : ndarray of shape (n, m), NaN where a value is not known.
        variances : of known values about the true ones: of shape (m,), or one for all.

        Returns
        -------
        means : ndarray of shape (n, m).
        covariances : ndarray of shape (n, m, m).
        """
        law = self.wide() if wide else self
        known = ~np.isnan(logs[0])
        noise = np.diag(np.broadcast_to(variances, len(law.names))[known])
        difference = np.zeros(len(logs))
        for turn in range(INDEX_ROUNDS):
            centres, spread = law.at(difference)
            across = spread[:, :, known]
            inner = across[:, known] + noise
            gain = np.linalg.solve(inner, across.transpose(0, 2, 1)).transpose(0, 2, 1)
            off = logs[:, known] - centres[:, known]
            means = centres + np.einsum("nij,nj->ni", gain, off)
            apart = means[:, :2] - law.means[:2]
            difference = apart[:, 1] - 2 * apart[:, 0]
            if known[:2].all() and turn == 1:
                break  # Stature and weight are known, and so is the index.
        return means, spread - gain @ across.transpose(0, 2, 1)

    def arrays(self) -> dict[str, Floats]:
        """Everything but the names, to be saved."""
        kept = ("means", "slopes", "bends", "widenings", "covariance", "factors", "factor_slopes")
        return {key: getattr(self, key) for key in kept} | {"reach": np.array(self.reach)}

    @classmethod
    def of_arrays(cls, names: tuple[str, ...], arrays: Mapping[str, Floats]) -> "Law":
        """From what `arrays` gave."""
        low, high = arrays["reach"].tolist()
        rest = {key: value for key, value in arrays.items() if key != "reach"}
        return cls(names=names, reach=(low, high), **rest)

    def wide(self) -> "Law":
        """The same law, were all body-mass indices equally common, and statures more varied."""
        low, high = np.log(WIDE_INDEX)
        stature = 1.3 * self.covariance[0, 0]
        slope = self.covariance[0, 1] / self.covariance[0, 0]
        covariance = self.covariance.copy()
        covariance[0, 0] = stature
        covariance[0, 1] = covariance[1, 0] = slope * stature
        covariance[1, 1] = slope**2 * stature + (high - low) ** 2 / 12
        return replace(self, covariance=covariance)

    def at(self, difference: Floats) -> tuple[Floats, Floats]:
        """Means (n, m) and covariances (n, m, m) at indices that differ so from the means'."""
        within = np.clip(difference, *self.reach)[:, None]
        means = self.means + self.bends * within**2
        sizes = np.exp(self.widenings * within)
        sizes[:, :2] = 1
        own = self.covariance * sizes[:, :, None] * sizes[:, None, :]
        own[:, :2, :2] = 0
        spread = self.slopes @ self.covariance[:2, :2] @ self.slopes.T
        return means, own + spread
