"""The live preview: how a body moves, and what it measures, as each entered value changes.

The linear law of the entered measurements, `model.estimators`, taken about a body: a value that
rises by one step, a tenth of itself, adds one target to the vertices. About the linear estimate
this is the law itself, about a body of the tape fit its likeness nearby. The measurements' own
changes are first derivatives, by the chain of tapes, coefficients and law.
"""

from dataclasses import dataclass

import numpy as np

from model.anthropometry import TAKEN, TAPES
from model.estimators import Estimator
from model.geometry import Floats, Integers
from model.measurements import MeasurementSet
from model.tape_pieces import TapePieces
from model.template_mesh import Body

STEP = 0.1
"""What a target stands for: so much more than the value, as a share of it."""

SOLES = 0.01
"""Metres above the floor below which a vertex may come to be the lowest of a changed body."""


@dataclass(frozen=True, eq=False)
class MorphTargets:
    """A body's targets: body(x) = body + Σ (xᵢ - valueᵢ) / stepᵢ · movesᵢ, then put on the floor.

    Attributes
    ----------
    names : the entered measurements, n of them.
    values, steps : ndarrays of shape (n,), SI: where the body stands, and how far a target goes.
    moves : ndarray of shape (n, V, 3), metres; the body's lowest vertex stays on the floor.
    soles : ndarray of shape (s,), the vertices of which another may become the lowest; by how
        much it then passes the floor is to be taken off all heights.
    slopes : ndarray of shape (m, n), of every measurement in `TAKEN`, SI for SI.
    """

    names: tuple[str, ...]
    values: Floats
    steps: Floats
    moves: Floats
    soles: Integers
    slopes: Floats


def morph_targets(estimator: Estimator, body: Body, asked: MeasurementSet) -> MorphTargets:
    """The targets of a body that an estimator made from asked values.

    Raises
    ------
    ValueError
        Where nothing is asked.
    """
    if not asked:
        raise ValueError("a body without entered values has no morph targets")
    known = np.array([name in asked for name in estimator.names])
    law = estimator.linear.law(known)[:, int(estimator.linear.fit_intercept) :]
    steps = np.array([_step(value) for value in asked.values()])
    moves = estimator.basis.moves((law * steps).T)
    heights = body.vertices[:, 1]
    moves[..., 1] -= moves[:, heights.argmin(), 1][:, None]
    return MorphTargets(
        names=tuple(asked),
        values=np.array(list(asked.values())),
        steps=steps,
        moves=moves,
        soles=np.flatnonzero(heights < heights.min() + SOLES),
        slopes=_slopes(estimator, body) @ law,
    )


def _step(value: float) -> float:
    """A tenth of a value, of two digits: alike for all, as the file's numbers have one grain."""
    return float(f"{STEP * value:.2g}")


def _slopes(estimator: Estimator, body: Body) -> Floats:
    """The derivatives of every measurement in `TAKEN` by the coefficients: (m, K)."""
    pieces = TapePieces(estimator.template, [TAPES[name] for name in TAKEN])
    reading = pieces.read(body.vertices, with_slopes=True)
    gradients = pieces.gradients(body.vertices, reading, reading.chosen)
    return estimator.basis.by_coefficients(gradients)
