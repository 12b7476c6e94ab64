"""The tape fit: bends an estimate until it measures what was asked.

Of all bodies that measure what was asked it looks for the one nearest, in the population's own
covariance, to the body that people with these values have on average: the linear estimate from
what was asked and, of all other measurements, from what the law of people expects of them. Of
bodies nearest to the population's mean, what was not asked would drift to what is usual in a
population that varies more than people do. It starts there and goes in rounds of Gauss-Newton on
the real measuring code; between two rounds derivatives are mended by what the last step showed
(Broyden 1965, *Mathematics of Computation* 19), which is cheaper than taking them anew. Where no
body that looks like a person measures all that was asked, the fit ends at the edge of what people
look like, with misses as small as they are there, and tells them. Stature gives way last.

Coefficients are written as mean + spread · w: w has unit covariance, and |w| is how far a body
is from the mean one (Mahalanobis).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import chdtri

from model.anthropometry import TAPES
from model.estimators import Estimator
from model.geometry import Booleans, Floats, Integers
from model.measurements import MEASUREMENTS, MeasurementSet
from model.tape_pieces import Reading, TapePieces
from model.template_mesh import Body

TOLERANCES: Mapping[str, float] = {"m": 0.0004, "kg": 0.04}
"""A value this near to the asked one is met, by unit: told in tenths of centimetres or
kilograms, it is the same."""

CLOSENESS = 0.25
"""The fit goes on until every value is met to this share of its tolerance. At the whole tolerance
what is missed would be three times as much for the heaviest as for people in the middle."""

ROUNDS = 12
"""After so many bodies the best is given; four of five fits need three at most."""

SOFTNESS = 1e-7
FIRST_DAMPING = 1e-5
"""What is added to the equations' eigenvalues, which are 1 for a single value: always, so that
values that follow from one another can stand together; and after a step that led nowhere."""

LEAST_GAIN = 0.03
"""At the edge of what people look like, a round that lowers the misses by less is the last; so is
anywhere the second of two in turn: there values contradict each other a little, as those of tapes
do that were read to the half centimetre."""

MOST_FAILURES = 3
"""At that edge, after so many steps in turn that lead nowhere there is nowhere to go."""

HELD = 10.0
"""So many times more than a miss of another value counts one of stature where not all can be met:
it is the value that people know best, and all others are seen beside it."""

USUAL = 0.999
"""The share of people within an estimator's reach."""


@dataclass(frozen=True, eq=False)
class TapeFit:
    """A body fitted to asked values.

    Attributes
    ----------
    body : the fitted body.
    coefficients : of that body, ndarray of shape (K,).
    misses : of every asked value, what the body measures less what was asked; SI units.
    distance : how far the body is from the mean one, squared, in the population's covariance.
    furthest : the largest such distance that still looks like a person, see `furthest`.
    rounds : how many bodies were tried after the linear estimate.
    """

    body: Body
    coefficients: Floats
    misses: Mapping[str, float]
    distance: float
    furthest: float
    rounds: int


def furthest(estimator: Estimator, count: int) -> float:
    """The largest squared distance from the mean body that some values may ask for.

    Were the population normal, the nearest body with n values of a person would lie at a
    squared distance of chi-squared law with n degrees of freedom. Its extremes lie further
    out: how much so was found in training.
    """
    return float(estimator.reach * chdtri(count, 1 - USUAL))


@dataclass(frozen=True, eq=False)
class Likely:
    """Which bodies are likely, where more is known than what kind they are of.

    Attributes
    ----------
    mean : ndarray of shape (K,), coefficients.
    spread : ndarray of shape (K, K), lower triangular, as an estimator's.
    """

    mean: Floats
    spread: Floats


def fit_to_tape(
    estimator: Estimator, asked: MeasurementSet, likely: Likely | None = None
) -> TapeFit:
    """The likeliest body that measures what was asked.

    Parameters
    ----------
    likely : in place of the estimator's population. Distances are then from its mean, in its
        covariance, and nothing bounds them.

    Raises
    ------
    ValueError
        Where nothing is asked.
    """
    if not asked:
        raise ValueError("a fit needs one measurement at least")
    search = _Search(estimator, asked, likely)
    rounds = 0
    while not search.met and rounds < ROUNDS and search.gains:
        search.go()
        rounds += 1
    misses = dict(zip(asked, search.misses.tolist(), strict=True))
    distance = float(search.w @ search.w)
    coefficients = search.likely.mean + search.likely.spread @ search.w
    return TapeFit(search.body, coefficients, misses, distance, search.furthest, rounds)


class _Search:
    """The state of one fit; values are in units of each measurement's spread in the population.

    Attributes
    ----------
    w, body, reading : the best body so far and what it measures.
    slopes : ndarray of shape (P, K), derivatives of the pieces by w.
    known : ndarray of shape (P,), the pieces whose derivatives were ever needed.
    scales : ndarray of shape (n,), each measurement's spread, SI; of stature less, see `HELD`.
    centre : ndarray of shape (K,), the body that the fit is to stay near.
    aim, slack : ndarrays of shape (P,), what a piece's tape is to measure, and by how much a
        piece that does not count may pass that.
    reach : how long a step may be.
    damping : added to the eigenvalues of the next step's equations.
    failures : how many steps in turn have led nowhere.
    idle : how many steps in turn have led hardly anywhere.
    gains : whether going on is of use.
    """

    def __init__(self, estimator: Estimator, asked: MeasurementSet, likely: Likely | None) -> None:
        self.estimator = estimator
        self.likely = likely or Likely(estimator.mean, estimator.spread)
        self.pieces = TapePieces(estimator.template, [TAPES[name] for name in asked])
        self.furthest = np.inf if likely else furthest(estimator, len(asked))
        start = self.likely.mean if likely else estimator.likeliest(asked)
        self.w = solve_triangular(self.likely.spread, start - self.likely.mean, lower=True)
        # The estimate of contradictory values may be no body at all.
        self.w *= min(1.0, np.sqrt(self.furthest / max(float(self.w @ self.w), 1e-12)))
        self.centre = self.w
        self.body = self._body(self.w)
        self.reading = self.pieces.read(self.body.vertices, with_slopes=True)
        owner = self.pieces.owner
        self.slopes = np.zeros((len(owner), len(self.w)))
        self.known = np.zeros(len(owner), dtype=bool)
        self.scales = np.ones(len(asked))
        self._learn(self.reading.chosen, self.body, self.reading)
        self.scales = np.linalg.norm(self.slopes[self.reading.chosen], axis=1)
        self.scales = np.maximum(self.scales, 1e-6)
        self.scales[[name == "stature" for name in asked]] /= HELD
        self.slopes /= self.scales[owner][:, None]
        self.goal = np.array(list(asked.values()))
        self.aim = (self.goal / self.scales)[owner]
        self.tolerances = np.array(
            [CLOSENESS * TOLERANCES[MEASUREMENTS[name].unit] for name in asked]
        )
        self.slack = (0.5 * self.tolerances / self.scales)[owner]
        self.reach = np.inf
        self.damping = SOFTNESS
        self.failures = 0
        self.idle = 0
        self.gains = True

    @property
    def misses(self) -> Floats:
        """Taken less asked, SI: ndarray of shape (n,)."""
        return self._misses(self.reading)

    @property
    def met(self) -> bool:
        return bool((np.abs(self.misses) <= self.tolerances).all())

    def go(self) -> None:
        """One round: a step, the body there, and what is learned from it."""
        step, at_the_edge = self._step()
        length = float(np.linalg.norm(step))
        if length < 1e-9:
            self.gains = False
            return
        if length > self.reach:
            step *= self.reach / length
            length = self.reach
        body = self._body(self.w + step)
        reading = self.pieces.read(body.vertices)
        change = (reading.values - self.reading.values) / self.scales[self.pieces.owner]
        surprise = (change - self.slopes @ step)[self.known]
        self.slopes[self.known] += np.outer(surprise, step / length**2)
        off = np.abs(self._misses(reading)) > 0.5 * self.tolerances
        self._learn(reading.chosen[off], body, reading)
        before, now = (
            np.linalg.norm(self._misses(r) / self.scales) for r in (self.reading, reading)
        )
        if now < before:
            self.w, self.body, self.reading = self.w + step, body, reading
            self._learn(reading.chosen, body, reading)
            self.reach = 2 * length
            self.damping = max(self.damping / 100, SOFTNESS)
            self.failures = 0
            self.idle = 0 if now < (1 - LEAST_GAIN) * before else self.idle + 1
            self.gains = self.idle < (1 if at_the_edge else 2)
        else:
            self.reach = length / 2
            self.damping = max(10 * self.damping, FIRST_DAMPING)
            self.failures += 1
            self.gains = not (at_the_edge and self.failures == MOST_FAILURES)
            if self.failures == 2:
                self.reading = self.pieces.read(self.body.vertices, with_slopes=True)
                known, self.known = np.flatnonzero(self.known), np.zeros_like(self.known)
                self._learn(known, self.body, self.reading)

    def _step(self) -> tuple[Floats, bool]:
        """Where to go, and whether the edge of what people look like bounds it.

        The chosen piece of each measurement has to reach the asked value, and the others must
        not pass it: those that would are held there too, and the step is found again.
        """
        owner = self.pieces.owner
        rest = self.aim - self.reading.values / self.scales[owner]
        held = np.zeros(len(owner), dtype=bool)
        held[self.reading.chosen] = True
        for _ in range(4):
            step, at_the_edge = self._towards(held, rest)
            passed = (self.slopes @ step - rest) * self.pieces.sense > self.slack
            passed &= self.known & ~held
            if not passed.any():
                break
            held |= passed
        return step, at_the_edge

    def _towards(self, held: Booleans, rest: Floats) -> tuple[Floats, bool]:
        """The step by which some pieces change as they should."""
        slopes, rest = self.slopes[held], rest[held]
        eigenvalues, vectors = np.linalg.eigh(slopes @ slopes.T)
        eigenvalues = np.maximum(eigenvalues, 0)
        apart = self.w - self.centre
        near = self.centre + slopes.T @ (
            vectors @ (vectors.T @ (rest + slopes @ apart) / (eigenvalues + SOFTNESS))
        )
        if at_the_edge := float(near @ near) > self.furthest:
            near = self._at_the_edge(slopes, eigenvalues, vectors, rest)
        if at_the_edge or np.isinf(self.reach):
            return near - self.w, at_the_edge
        # After the first round the nearest body to the present one is near enough the likeliest.
        return slopes.T @ (vectors @ (vectors.T @ rest / (eigenvalues + self.damping))), False

    def _at_the_edge(
        self, slopes: Floats, eigenvalues: Floats, vectors: Floats, rest: Floats
    ) -> Floats:
        """The body at the edge of what people look like that misses what is asked by the least."""
        whole = vectors.T @ (rest + slopes @ self.w)

        def distance(softness: float) -> float:
            return float(np.sum(eigenvalues * (whole / (eigenvalues + softness)) ** 2))

        low, high = np.log(SOFTNESS), np.log(1e6)
        for _ in range(40):
            middle = (low + high) / 2
            beyond = distance(np.exp(middle)) > self.furthest
            low, high = (middle, high) if beyond else (low, middle)
        edge: Floats = slopes.T @ (vectors @ (whole / (eigenvalues + np.exp(high))))
        return edge

    def _learn(self, pieces: Integers, body: Body, reading: Reading) -> None:
        """Takes the derivatives of those pieces that have none yet."""
        new = pieces[~self.known[pieces]]
        if not len(new):
            return
        gradients = self.pieces.gradients(body.vertices, reading, new)
        slopes = self.estimator.basis.by_coefficients(gradients) @ self.likely.spread
        self.slopes[new] = slopes / self.scales[self.pieces.owner[new]][:, None]
        self.known[new] = True

    def _misses(self, reading: Reading) -> Floats:
        misses: Floats = reading.values[reading.chosen] - self.goal
        return misses

    def _body(self, w: Floats) -> Body:
        return self.estimator.body(self.likely.mean + self.likely.spread @ w)
