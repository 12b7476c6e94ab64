"""From measurements to a body by principal components, as the paper's section 4.3 has it.

Reference: *Estimating Body Shapes From Body Measurements*, section 4.3, equations 1 to 5. No site
estimates with it: `model.estimators` is compared with it.
"""

from typing import Any

from sklearn.decomposition import PCA

from model.estimators import BodyEstimator, LinearBodyEstimator
from model.geometry import Floats


class PCABodyEstimator(BodyEstimator):
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
