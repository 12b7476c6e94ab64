"""The paper's two models to the letter, and beside them with a constant term.

Reference: *Estimating Body Shapes From Body Measurements*, sections 4.3 and 4.5. As there,
bodies are coordinates from the groin's height, a model is of one sex, and any measurements
may be given. Everything is reckoned in `PaperSpace`, where a body has some hundreds of coordinates
instead of its forty thousand and nothing else is different.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from model.estimators import LinearBodyEstimator, PCABodyEstimator
from model.geometry import Floats
from model.shape_basis import ShapeBasis
from model.template_mesh import TemplateMesh

COMPONENT_SHARE = 0.98
"""The share of the variance that the components hold. The paper says only that they explain
the maximum of it; beyond this share none changes the estimates (see the figure)."""

LINEAR_LETTER = "linear, equations 6 to 8"
PCA_LETTER = "PCA, equations 1 to 5"
LINEAR = "linear, with a constant"
PCA = "PCA, with a constant"
PCA_DIVIDED = "PCA, weights left divided"

Model = Callable[[Floats], Floats]
"""From measurements (n, m), NaN where not given, to coordinates in `PaperSpace` (n, 1 + K)."""


@dataclass(frozen=True, eq=False)
class PaperSpace:
    """Bodies as differences from a mean; distances between them are those of the vertices.

    Coordinates lead with a 1 for the mean, which the linear model without a constant term
    has to learn as it learns the rest. The others are such that their squared differences
    add up to the squared distances of the vertices, so that principal components of the
    coordinates are those of the vertices.

    Attributes
    ----------
    template : the bodies' mesh.
    root : ndarray of shape (K, K), from coefficients on the shape basis to coordinates.
    rows : ndarray of shape (1 + K, V·3), float32, metres: the mean, then the directions.
    """

    template: TemplateMesh
    root: Floats
    rows: NDArray[np.float32]

    @classmethod
    def of(cls, basis: ShapeBasis, template: TemplateMesh) -> "PaperSpace":
        """The space that a shape basis spans."""
        count = len(basis.directions)
        mean = from_groin(template, basis.vertices(np.zeros((1, count))))[0].ravel()
        moved = from_groin(template, basis.vertices(np.eye(count)))
        directions = moved.reshape(count, -1) - mean
        root = np.linalg.cholesky(directions @ directions.T)
        rows = np.vstack([mean, np.linalg.solve(root, directions)])
        return cls(template=template, root=root, rows=rows.astype(np.float32))

    def coordinates(self, coefficients: Floats) -> Floats:
        """From coefficients on the shape basis, (n, K), to coordinates, (n, 1 + K)."""
        return np.column_stack([np.ones(len(coefficients)), coefficients @ self.root])

    def vertices(self, coordinates: Floats) -> Floats:
        """From coordinates, (n, 1 + K), to vertices, (n, V, 3), metres; groin at Y = 0."""
        flat = coordinates.astype(np.float32) @ self.rows
        return flat.reshape(len(flat), -1, 3).astype(np.float64)


def from_groin(template: TemplateMesh, vertices: Floats) -> Floats:
    """Bodies, (n, V, 3), moved up or down so that the groin is at Y = 0.

    The paper's are centred at the groin (5.1.1). Forwards ours stay where they stand: the
    groin's point is further forward the fuller the thighs are, and would take the body along.
    """
    groin = template.landmark_points(vertices, "crotch") * [0, 1, 0]
    return vertices - groin[:, None]


def learn(values: Floats, coordinates: Floats) -> Mapping[str, Model]:
    """Fits every model; of one sex, by the paper.

    Parameters
    ----------
    values : ndarray of shape (n, m), measurements, SI units.
    coordinates : ndarray of shape (n, 1 + K), in `PaperSpace`.
    """
    linear_letter, linear = (
        LinearBodyEstimator(fit_intercept=constant).fit(values, coordinates)
        for constant in (False, True)
    )
    pca_letter, pca = (
        PCABodyEstimator(COMPONENT_SHARE, fit_intercept=constant).fit(values, coordinates)
        for constant in (False, True)
    )
    return {
        LINEAR_LETTER: linear_letter.predict,
        PCA_LETTER: pca_letter.predict,
        LINEAR: linear.predict,
        PCA: pca.predict,
        PCA_DIVIDED: partial(left_divided, pca),
    }


def left_divided(estimator: PCABodyEstimator, rows: Floats) -> Floats:
    """What comes of dividing the weights by their eigenvalues and not multiplying again.

    The paper divides (4.3.1) and does not say that (5) must undo it.
    """
    return estimator.weights(rows) @ estimator.components_ + estimator.mean_


def given(names: Sequence[str], values: Floats, subset: Sequence[str]) -> Floats:
    """Measurements of which only a subset is known: (n, m) with NaN elsewhere."""
    known = [name in subset for name in names]
    return np.where(known, values, np.nan)
