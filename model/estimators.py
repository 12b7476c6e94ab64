"""From measurements to a body: the paper's two laws, for any subset of measurements.

Reference: *Estimating Body Shapes From Body Measurements*. Linear, section 4.5, equations 6
to 8: a matrix A with T(x) = A x, found as A = y x⁺ from the population's coordinates y and
measurements x. By principal components, section 4.3, equations 1 to 5. Coordinates may be
coefficients on a shape basis: the mean body aside they are linear in the vertices, so that
with a constant term the linear law is the same.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.decomposition import PCA
from sklearn.utils import Tags, assert_all_finite
from sklearn.utils.validation import check_is_fitted, validate_data

from model.anthropometry import TAKEN
from model.checksums import check_sums
from model.geometry import Floats
from model.law import Law
from model.measurements import BODY_KINDS, MEASUREMENTS, BodyKind, MeasurementSet
from model.shape_basis import ShapeBasis, load_shape_basis
from model.template_mesh import DATA, Body, DamagedFileError, TemplateMesh, load_template_mesh

RANGE_SHARE = 0.8
"""How often the truth lies within a printed range."""


class _BodyEstimator(MultiOutputMixin, RegressorMixin, BaseEstimator):
    """What both laws take: measurements, of which some may be missing, and whole coordinates."""

    n_features_in_: int
    single_output_: bool

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        tags.input_tags.allow_nan = True
        tags.target_tags.multi_output = True
        return tags

    def _bodies(self, X: Any, y: Any, least: int) -> tuple[Floats, Floats]:
        """What is learned from, checked: (n, m) and (n, K), of so many bodies at least."""
        X, y = validate_data(
            self,
            X,
            y,
            multi_output=True,
            y_numeric=True,
            dtype=np.float64,
            ensure_all_finite="allow-nan",
            ensure_min_samples=least,
        )
        assert_all_finite(y, input_name="y")
        self.single_output_ = y.ndim == 1
        return X, y.reshape(len(y), -1).astype(np.float64)

    def _measurements(self, X: Any) -> Floats:
        """What is estimated from, checked: (n, m)."""
        check_is_fitted(self)
        checked: Floats = validate_data(
            self, X, reset=False, dtype=np.float64, ensure_all_finite="allow-nan"
        )
        return checked

    def predict(self, X: Any) -> Floats:
        """Estimates coordinates.

        Parameters
        ----------
        X : array-like of shape (n, m); NaN where a measurement is not known.

        Returns
        -------
        ndarray of shape (n, K) or (n,).
        """
        predicted = self._coordinates(self._measurements(X))
        return predicted[:, 0] if self.single_output_ else predicted

    def _coordinates(self, X: Floats) -> Floats:
        """The law itself: (n, m) to (n, K)."""
        raise NotImplementedError


class LinearBodyEstimator(_BodyEstimator):
    """Least squares from measurements to a body, for whichever measurements are known.

    What is learned are sums of products over the population. The law of any subset of
    measurements follows from those in closed form, and is exactly the least-squares law
    that a fit on that subset alone would find.

    Parameters
    ----------
    fit_intercept : bool, default=True
        Whether the law has a constant term. False is equation 8 to the letter.

    Attributes
    ----------
    n_features_in_ : int, the number m of measurements.
    count_ : int, bodies seen.
    moments_ : ndarray of shape (m + 1, m + 1), mean products of a leading 1 and the
        measurements.
    cross_moments_ : ndarray of shape (K, m + 1), mean products with the coordinates.
    single_output_ : bool, whether coordinates were given as one column.

    References
    ----------
    The paper's section 4.5; A = y x⁺ (8), and x⁺ = xᵀ (x xᵀ)⁻¹ for independent rows.
    """

    def __init__(self, *, fit_intercept: bool = True) -> None:
        self.fit_intercept = fit_intercept

    def fit(self, X: Any, y: Any) -> "LinearBodyEstimator":
        """Learns from bodies.

        Parameters
        ----------
        X : array-like of shape (n, m), measurements; NaN is left out of every mean
            product that it would be in.
        y : array-like of shape (n, K) or (n,), coordinates.
        """
        X, y = self._bodies(X, y, least=1)
        values = np.column_stack([np.ones(len(X)), X])
        there = ~np.isnan(values)
        values = np.where(there, values, 0)
        together = np.maximum(there.T.astype(float) @ there, 1)
        self.count_ = len(X)
        self.moments_ = values.T @ values / together
        self.cross_moments_ = y.T @ values / np.maximum(there.sum(axis=0), 1)
        return self

    def _coordinates(self, X: Floats) -> Floats:
        predicted = np.empty((len(X), len(self.cross_moments_)))
        missing = np.isnan(X)
        for pattern in np.unique(missing, axis=0):
            rows = (missing == pattern).all(axis=1)
            known = np.column_stack([np.ones(rows.sum()), X[rows][:, ~pattern]])
            if not self.fit_intercept:
                known = known[:, 1:]
            predicted[rows] = known @ self.law(~pattern).T
        return predicted

    def law(self, known: Any) -> Floats:
        """The matrix A of the known measurements (equation 8).

        Parameters
        ----------
        known : ndarray of bool, shape (m,).

        Returns
        -------
        ndarray of shape (K, number known), led by a constant column with an intercept.
        """
        use = self._columns(known)
        return self._solve(self.cross_moments_[:, use], use)

    def _columns(self, known: Any) -> Any:
        return np.flatnonzero(np.concatenate([[self.fit_intercept], known]))

    def _solve(self, across: Floats, use: Any) -> Floats:
        """Least squares by the normal equations, in columns of like size: (rows, use)."""
        gram = self.moments_[np.ix_(use, use)]
        size = np.sqrt(np.diag(gram))
        size = np.where(size > 0, size, 1.0)
        solution = np.linalg.lstsq(gram / np.outer(size, size), (across / size).T, rcond=1e-13)[0]
        law: Floats = solution.T / size
        return law


class PCABodyEstimator(_BodyEstimator):
    """Least squares from measurements to the weights of a body's principal components.

    The differences of the bodies from their mean, D = Sᵢ - S̄ (1), are turned into weights W
    of D's principal components, each divided by its eigenvalue. What is learned is
    B = W P⁺ (4) for measurements P; a new body is A B P + S̄ (5).

    The paper's A takes weights to coordinates in (2) and coordinates to weights in (3). Here
    it is the former: the components times their eigenvalues, which undoes the division. As
    each weight has a law of its own, the division then changes no body; nor does learning
    weights at all, but for the components that are left out.

    Parameters
    ----------
    n_components : int, float or None, default=None
        How many components: a number, the least that hold a share of the variance, or all.
        As in `sklearn.decomposition.PCA`.
    fit_intercept : bool, default=True
        Whether the laws of the weights have a constant term. False is equation 4 to the
        letter.

    Attributes
    ----------
    n_features_in_ : int, the number m of measurements.
    mean_ : ndarray of shape (K,), the mean body S̄.
    components_ : ndarray of shape (k, K), of length 1, by falling eigenvalue.
    eigenvalues_ : ndarray of shape (k,), the variance along each component.
    weights_law_ : LinearBodyEstimator, from measurements to divided weights.
    single_output_ : bool, whether coordinates were given as one column.

    References
    ----------
    The paper's section 4.3, after S. Wuhrer and C. Shu, *Estimating 3D human shapes from
    measurements*, Machine Vision and Applications 24 (2013).
    """

    def __init__(
        self, n_components: int | float | None = None, *, fit_intercept: bool = True
    ) -> None:
        self.n_components = n_components
        self.fit_intercept = fit_intercept

    def fit(self, X: Any, y: Any) -> "PCABodyEstimator":
        """Learns from bodies.

        Parameters
        ----------
        X : array-like of shape (n, m), measurements; NaN as in `LinearBodyEstimator.fit`.
        y : array-like of shape (n, K) or (n,), coordinates, two bodies at least.
        """
        X, y = self._bodies(X, y, least=2)
        pca = PCA(self.n_components, svd_solver="full").fit(y)
        # As many directions as there are bodies or coordinates come out, some without variance.
        kept = pca.explained_variance_ > 1e-12 * pca.explained_variance_[0]
        self.mean_ = pca.mean_
        self.components_ = pca.components_[kept]
        self.eigenvalues_ = pca.explained_variance_[kept]
        weights = (y - self.mean_) @ self.components_.T / self.eigenvalues_
        self.weights_law_ = LinearBodyEstimator(fit_intercept=self.fit_intercept).fit(X, weights)
        return self

    def weights(self, X: Any) -> Floats:
        """The divided weights, B P: (n, k); X as in `predict`."""
        return self.weights_law_.predict(self._measurements(X))

    def _coordinates(self, X: Floats) -> Floats:
        weights = self.weights_law_.predict(X)
        coordinates: Floats = weights * self.eigenvalues_ @ self.components_ + self.mean_
        return coordinates


@dataclass(frozen=True, eq=False)
class Estimator:
    """A shipped estimator of one kind of body.

    Attributes
    ----------
    kind : the kind of body it estimates.
    names : the measurements that it knows, in the order of the learned columns.
    linear : the learned law.
    law : how people's measurements go together, by which ranges are reckoned.
    spread : ndarray of shape (K, K), lower triangular: times its own transpose it is the
        covariance of the bodies' coefficients.
    reach : how much further than a normal law's the population's bodies lie from their mean,
        in squared distances, see `model.tape_fit`.
    limits : by measurement, the least and the most that an adult may plausibly be, SI.
    population : what bodies the law was learned from, for people to read.
    seed, date : of that population.
    basis, template : the space of bodies and their mesh.
    """

    kind: BodyKind
    names: tuple[str, ...]
    linear: LinearBodyEstimator
    law: Law
    spread: Floats
    reach: float
    limits: Mapping[str, tuple[float, float]]
    population: str
    seed: int
    date: str
    basis: ShapeBasis
    template: TemplateMesh

    @property
    def version(self) -> str:
        """Tells one training from another."""
        return f"{self.date}.{self.seed}"

    @property
    def trained_on(self) -> str:
        """The population, for people to read."""
        return f"{self.population}; {self.linear.count_} bodies; {self.date}, seed {self.seed}"

    @property
    def mean(self) -> Floats:
        """The coefficients of the mean body: ndarray of shape (K,)."""
        mean: Floats = self.linear.cross_moments_[:, 0]
        return mean

    def coefficients(self, asked: MeasurementSet) -> Floats:
        """The linear estimate from any subset of the measurements that it knows: (K,)."""
        known = np.array([name in asked for name in self.names])
        values = [asked[name] for name in self.names if name in asked]
        if self.linear.fit_intercept:
            values.insert(0, 1.0)
        coefficients: Floats = self.linear.law(known) @ np.array(values)
        return coefficients

    def likeliest(self, asked: MeasurementSet, noise: Mapping[str, float] | None = None) -> Floats:
        """The linear estimate from all measurements, those not asked being as expected: (K,).

        What the law of people expects of them holds for people; what bodies of the population
        lead to expect, which `coefficients` follows, for a population that varies more.

        Parameters
        ----------
        noise : see `ranges`.
        """
        values = np.exp(self.law.given(asked, noise).means)
        if not noise:
            values = np.array(
                [asked.get(name, own) for name, own in zip(self.names, values, strict=True)]
            )
        coefficients: Floats = self._whole_law[:, 1:] @ values + self._whole_law[:, 0]
        return coefficients

    @cached_property
    def _whole_law(self) -> Floats:
        """The linear law of all measurements, led by its constant: (K, 1 + m)."""
        law = self.linear.law(np.ones(len(self.names), dtype=bool))
        return law if self.linear.fit_intercept else np.insert(law, 0, 0.0, axis=1)

    def body(self, coefficients: Floats) -> Body:
        """The body of coefficients, ndarray of shape (K,)."""
        vertices = self.basis.vertices(coefficients[None])[0]
        return Body(template=self.template, vertices=vertices, kind=self.kind)

    def estimate(self, asked: MeasurementSet) -> Body:
        """The linear estimate from any subset of the measurements that it knows, as a body."""
        return self.body(self.coefficients(asked))

    def ranges(
        self,
        asked: MeasurementSet,
        taken: MeasurementSet,
        *,
        noise: Mapping[str, float] | None = None,
    ) -> dict[str, tuple[float, float]]:
        """Where four of five people's values lie who share the asked ones: low and high, SI.

        The range of a value that was asked is the taken value itself. Another's follows from
        the law of people, and is widened where needed so that the body's own lies within.

        Parameters
        ----------
        taken : what the body estimated for them measures.
        noise : by measurement, the standard deviation of an asked value about the true one,
            SI: of repeated readings, or `model.law.TAPE_NOISE`. Trained hands' by default.
        """
        given = self.law.given(asked, noise)
        ranges = {}
        for name in self.names:
            low, _, high = given.range(name, RANGE_SHARE)
            own = taken[name]
            ranges[name] = (own, own) if name in asked else (min(low, own), max(high, own))
        return ranges

    def save(self, path: Path) -> None:
        """Writes everything but the shared basis and template; no pickle."""
        part = path.with_name(f"part-{path.name}")
        law: dict[str, Any] = {f"law_{key}": value for key, value in self.law.arrays().items()}
        np.savez(
            part,
            **law,
            kind=self.kind,
            names=np.array(self.names),
            units=np.array([MEASUREMENTS[name].unit for name in self.names]),
            fit_intercept=self.linear.fit_intercept,
            moments=self.linear.moments_,
            cross_moments=self.linear.cross_moments_,
            count=self.linear.count_,
            spread=self.spread.astype(np.float32),
            reach=self.reach,
            limits=np.array([self.limits[name] for name in self.names]),
            population=self.population,
            seed=self.seed,
            date=self.date,
            basis=self.basis.fingerprint,
        )
        part.replace(path)


def load_estimator(path: Path, folder: Path = DATA) -> Estimator:
    """Reads an estimator's file; the shape basis and the template it stands on are in `folder`.

    Raises
    ------
    FileNotFoundError, ValueError
        Where the file is missing, is not one of ours, was trained on another shape basis
        or on other measurements than are taken now; the message names it.
    """
    try:
        # NumPy would leave a file open that turns out to be no archive.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as saved:
            arrays = {key: saved[key] for key in saved.files}
        names = tuple(str(name) for name in arrays["names"])
        linear = LinearBodyEstimator(fit_intercept=bool(arrays["fit_intercept"]))
        linear.n_features_in_ = len(names)
        linear.moments_ = arrays["moments"]
        linear.cross_moments_ = arrays["cross_moments"]
        linear.count_ = int(arrays["count"])
        linear.single_output_ = False
        ends = arrays["limits"].tolist()
        estimator = Estimator(
            kind=BODY_KINDS[BODY_KINDS.index(arrays["kind"].item())],
            names=names,
            linear=linear,
            law=Law.of_arrays(
                names, {key[4:]: value for key, value in arrays.items() if key[:4] == "law_"}
            ),
            spread=arrays["spread"].astype(np.float64),
            reach=float(arrays["reach"]),
            limits={name: (low, high) for name, (low, high) in zip(names, ends, strict=True)},
            population=str(arrays["population"]),
            seed=int(arrays["seed"]),
            date=str(arrays["date"]),
            basis=load_shape_basis(folder),
            template=load_template_mesh(folder),
        )
        trained_on = str(arrays["basis"])
    except (FileNotFoundError, DamagedFileError):
        raise
    except Exception as error:
        raise ValueError(f"{path} is not an estimator's file: {error}") from error
    if trained_on != estimator.basis.fingerprint:
        raise ValueError(f"{path} was trained on another shape basis: run make train")
    if names != TAKEN:
        raise ValueError(f"{path} knows other measurements than are taken: run make train")
    return estimator


def load_estimators(folder: Path = DATA) -> dict[BodyKind, Estimator]:
    """The estimators of a folder, the shipped ones or those of scans: one for each kind of body.

    Raises
    ------
    FileNotFoundError, ValueError
        Where a file of the folder is missing, is not what it was when it was written, or is none
        of ours; the message names it.
    """
    check_sums(folder)
    return {
        kind: load_estimator(folder / "estimators" / f"{kind}.npz", folder) for kind in BODY_KINDS
    }
