"""Outlines help the body: what photos say is weighed with what bodies look like.

Edges of the outlines, row by row, are observations of the body. Given those, with their noise,
the likely bodies are again a normal law, of another mean and a smaller spread (Bayes' rule for
linear observations; Gauss-Newton, as an outline bends when the body does); among them the tape
fit finds the one that measures what was asked. Entered values hold as before, and outlines have a
say in what those leave open.

Clothes and stance are no body. How far close cloth stands off is left open, level by level:
it only ever adds to an outline, and by the same in every photo, so that most of what the entered
values and what bodies look like do not explain is taken for it. Where cloth hangs loose, as the
person says or as so much of it is found, an outline only says where the body ends at most. Where
the person stands, leans and sways is left open too, and so is how arms are turned: of them it
counts how far they reach, which bent elbows and fingers only ever shorten. What an arm may hide is
left out, and an edge that is far from where any likely body has it counts for little.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from scipy.linalg import block_diag, qr, solve_triangular
from scipy.optimize import nnls

from model.anthropometry import TAPES
from model.cameras import Camera, Facing, Side, seen, seen_slopes
from model.comparison import Edges, photo_edges
from model.estimators import Estimator
from model.geometry import Booleans, Floats
from model.masks import Mask
from model.measurements import MEASUREMENTS, MeasurementSet
from model.silhouette import ARMS, LEG, UPRIGHT, contour, contour_gradients
from model.tape_fit import TOLERANCES, Likely, TapeFit, fit_to_tape, furthest
from model.tape_pieces import TapePieces

NOISE = 0.006
"""Metres: how far an outline's edge may be off, in rows 15 mm apart. Two passes of the segmenter
over one photo differ by 4 mm in the breadth of a trunk."""

CLOTH = 0.006
"""Metres: how far cloth stands off the body at a level, on average. Most wear next to nothing, as
photos are asked for in tight clothes, and some wear much: an exponential law."""

CLOTH_LEVELS = np.linspace(0.14, 0.86, 13)
"""Shares of the stature, from above the ankles to the neck: between two of them cloth changes
evenly."""

Worn = Literal["tight", "loose_top", "loose_legs", "loose"]
WORN: tuple[Worn, ...] = get_args(Worn)
LOOSE: Mapping[Worn, tuple[float, float]] = {
    "tight": (0, 0),
    "loose_top": (0.41, 1),
    "loose_legs": (0, 0.65),
    "loose": (0, 1),
}
"""From where to where clothes hang loose, as shares of the stature. A top hangs over the hips, and
trousers and skirts begin at the waist; edges within a level of there are taken as loose too."""

HANGING = 0.005
"""Metres: where nobody said what is worn, cloth that is found to stand off by more hangs loose."""

TAPED = 0.05
"""Where cloth is told from body, entered values are known to this share of how bodies differ."""

PLACE, LEAN, SWAY = 0.05, 0.03, 0.01
"""Metres: how far the figure may be off to one side as a whole, at head and feet by leaning and
at its middle by swaying, as deviations, for each photo anew."""

BENT, FORWARDS = 0.04, 0.01
"""Metres: by how much arms reach less far than they might, on average, as elbows and fingers are
bent, an exponential law; and how far either way that is off, as a deviation, as arms are held
forwards or backwards. Of 0.02 and 0.04 the latter brought 24 held-out bodies nearer that
docs/comparison.md does not have."""

OUTLIER = 3.0
"""An edge that is off by this many times the noise counts half (Cauchy's weights)."""

ROUNDS = 2
"""Each lays the photos over the newest body. A third would move it by half a millimetre on average,
and by two in trousers that stand off by three centimetres."""

REWEIGHTINGS = 4

MILDER = 4
"""Where the pull asks for a body that nobody has, or entered values are lost, the noise is taken
to be twice as large, and twice again: so often at most before outlines are given up."""


@dataclass(frozen=True, eq=False)
class Photo:
    """An outline, and how it was seen."""

    mask: Mask
    side: Side
    camera: Camera
    facing: Facing


@dataclass(frozen=True, eq=False)
class Refined:
    """A body that outlines had a say in.

    Attributes
    ----------
    fit : as the tape fit gives it; its distance and limit are the population's.
    cloth : ndarray, metres that were taken for cloth at each of `CLOTH_LEVELS`.
    loose : ndarray of bool, at which of those cloth hangs loose.
    unexplained : the share of edges that count less than half.
    pull : 1 for the whole, a half where the noise had to be taken twice as large, and so on; 0
        where outlines were given up.
    """

    fit: TapeFit
    cloth: Floats
    loose: Booleans
    unexplained: float
    pull: float

    def cloth_at(self, share: float) -> float:
        """Metres that were taken for cloth at a height, told as a share of the stature."""
        return float(np.interp(share, CLOTH_LEVELS, self.cloth))

    def loose_at(self, share: float) -> bool:
        """Whether outlines only said where the body ends at most, at such a height."""
        return bool(_near(self.loose, np.array([share]))[0])


@dataclass(frozen=True, eq=False)
class _Observed:
    """Edges beside a body's: n of them.

    Attributes
    ----------
    rest : ndarray of shape (n,), metres: how far the photo's are outside or to the right.
    shares : ndarray of shape (n,), how high they are, of the stature.
    outwards : ndarray of shape (n,), by cloth that stands off by a metre: of a breadth 2, of the
        figure's right end 1, of its left end -1, of a hand's reach 0.
    slopes : ndarray of shape (n, K), by the body's coefficients.
    bent : ndarray of shape (n, B), by what only ever shortens, of exponential laws of mean 1.
    free : ndarray of shape (n, F), by what is none of these, each of unit deviation.
    """

    rest: Floats
    shares: Floats
    outwards: Floats
    slopes: Floats
    bent: Floats
    free: Floats


def refine(
    estimator: Estimator,
    asked: MeasurementSet,
    photos: Sequence[Photo],
    worn: Worn | None = None,
) -> Refined:
    """The likeliest body that measures what was asked, given outlines of the person.

    Parameters
    ----------
    worn : what the person wears; where it hangs loose is looked for if nobody told.

    Raises
    ------
    ValueError
        Where nothing is asked.
    PictureRefusedError
        For an outline of something else.
    """
    first = fit_to_tape(estimator, asked)
    for times in range(MILDER):
        found = _pulled(estimator, asked, photos, first, NOISE * 2**times, worn)
        if _holds(first, found.fit):
            return replace(found, pull=0.5**times)
    nowhere = np.zeros(len(CLOTH_LEVELS))
    return Refined(first, nowhere, nowhere > 0, 1.0, 0.0)


def _pulled(
    estimator: Estimator,
    asked: MeasurementSet,
    photos: Sequence[Photo],
    first: TapeFit,
    noise: float,
    worn: Worn | None,
) -> Refined:
    """What outlines make of a body, whether or not it looks like a person."""
    fit, centre = first, estimator.likeliest(asked)
    low, high = LOOSE[worn or "tight"]
    loose = (low < CLOTH_LEVELS) & (high > CLOTH_LEVELS)
    for _ in range(ROUNDS):
        seen_now = [_observe(estimator, fit, photo) for photo in photos]
        tapes = _tape_slopes(estimator, asked, fit)
        at = fit.coefficients
        likely, cloth, weights = _given(estimator, centre, at, tapes, seen_now, noise, loose)
        hanging = (cloth > HANGING) & ~loose
        if worn is None and hanging.any():
            loose = loose | hanging
            likely, cloth, weights = _given(estimator, centre, at, tapes, seen_now, noise, loose)
        fit = fit_to_tape(estimator, asked, likely)
    w = np.linalg.solve(estimator.spread, fit.coefficients - estimator.mean)
    fit = replace(fit, distance=float(w @ w), furthest=furthest(estimator, len(MEASUREMENTS)))
    return Refined(fit, cloth, loose, float((weights < 0.5).mean()), 1.0)


def _holds(first: TapeFit, fit: TapeFit) -> bool:
    """Whether a fit looks like a person, and misses nothing that the first one met."""
    kept = all(
        abs(miss) <= max(TOLERANCES[MEASUREMENTS[name].unit], abs(first.misses[name]))
        for name, miss in fit.misses.items()
    )
    return kept and fit.distance <= fit.furthest


def _tape_slopes(estimator: Estimator, asked: MeasurementSet, fit: TapeFit) -> Floats:
    """Derivatives of what was asked by a body's coefficients: ndarray of shape (m, K)."""
    pieces = TapePieces(estimator.template, [TAPES[name] for name in asked])
    reading = pieces.read(fit.body.vertices, with_slopes=True)
    gradients = pieces.gradients(fit.body.vertices, reading, reading.chosen)
    return estimator.basis.by_coefficients(gradients)


def _observe(estimator: Estimator, fit: TapeFit, photo: Photo) -> _Observed:
    """A photo's edges beside those of a body."""
    body, basis = fit.body, estimator.basis
    edges = photo_edges(photo.mask, body, photo.side, photo.camera, photo.facing)
    flat = seen(body.vertices, edges.side, edges.camera, edges.facing)
    heights, places = np.unique(edges.heights, return_inverse=True)
    trunk = contour(body.template, flat, UPRIGHT, heights)
    by_vertex = contour_gradients(trunk, body.vertices, edges.side, edges.camera, edges.facing)
    slopes = basis.by_coefficients(by_vertex)[places + edges.ends * len(heights)]
    shares = edges.heights / flat[:, 1].max()
    along = 2 * shares - 1
    observed = _Observed(
        rest=edges.positions - trunk.positions[places, edges.ends],
        shares=shares,
        outwards=np.where(edges.ends == 1, 1.0, -1.0),
        slopes=slopes,
        bent=np.zeros((len(along), 0)),
        free=np.column_stack(
            [np.full(len(along), PLACE), LEAN * along, SWAY * (1 - along**2)],
        ),
    )
    if edges.side == "front":
        observed = _with_legs(estimator, fit, edges, flat, observed)
    return _with_hands(estimator, fit, edges, flat, observed) if edges.hands else observed


def _with_legs(
    estimator: Estimator, fit: TapeFit, edges: Edges, flat: Floats, observed: _Observed
) -> _Observed:
    """Breadths of legs too: where each leg stands, is left open."""
    body, count = fit.body, len(edges.leg_heights)
    legs = contour(body.template, flat, LEG, edges.leg_heights)
    by_vertex = contour_gradients(legs, body.vertices, edges.side, edges.camera, edges.facing)
    slopes = estimator.basis.by_coefficients(by_vertex)
    free = np.zeros((count, observed.free.shape[1]))
    return _Observed(
        np.concatenate([observed.rest, edges.leg_breadths - np.ptp(legs.positions, axis=1)]),
        np.concatenate([observed.shares, edges.leg_heights / flat[:, 1].max()]),
        np.concatenate([observed.outwards, np.full(count, 2.0)]),
        np.concatenate([observed.slopes, slopes[count:] - slopes[:count]]),
        np.concatenate([observed.bent, np.zeros((count, observed.bent.shape[1]))]),
        np.concatenate([observed.free, free]),
    )


def _with_hands(
    estimator: Estimator, fit: TapeFit, edges: Edges, flat: Floats, observed: _Observed
) -> _Observed:
    """How far arms reach from the shoulder too: how they are turned there, is left open."""
    template, vertices = fit.body.template, fit.body.vertices
    rest, gradients = [], []
    for side, end in edges.hands.items():
        own = np.unique(template.faces[template.faces_of(*(f"{arm}_{side}" for arm in ARMS))])
        near, weights = template.landmark_weights(f"acromion_{side}")
        shoulder = weights @ flat[near]
        tip = own[np.linalg.norm(flat[own] - shoulder, axis=1).argmax()]
        reaches = np.stack([flat[tip], end]) - shoulder
        lengths = np.linalg.norm(reaches, axis=1)
        along, photos = reaches / lengths[:, None]
        rest.append(lengths[1] - lengths[0])
        across, up = seen_slopes(vertices[[tip, *near]], edges.side, edges.camera, edges.facing)
        ways = np.stack([along, *[photos - along] * len(near)])
        by_vertex = ways[:, :1] * across + ways[:, 1:] * up
        gradients.append((np.array([tip, *near]), np.array([1, *weights])[:, None] * by_vertex))
    count = len(rest)
    heights = [end[1] / flat[:, 1].max() for end in edges.hands.values()]
    return _Observed(
        np.concatenate([observed.rest, rest]),
        np.concatenate([observed.shares, heights]),
        np.concatenate([observed.outwards, np.zeros(count)]),
        np.concatenate([observed.slopes, estimator.basis.by_coefficients(gradients)]),
        block_diag(observed.bent, -BENT * np.eye(count)),
        block_diag(observed.free, FORWARDS * np.eye(count)),
    )


def _by_levels(shares: Floats) -> Floats:
    """How much each of `CLOTH_LEVELS` counts at some heights: (n, L)."""
    every = np.eye(len(CLOTH_LEVELS))
    return np.column_stack([np.interp(shares, CLOTH_LEVELS, one) for one in every])


def _near(loose: Booleans, shares: Floats) -> Booleans:
    """Which heights lie less than a level away from where cloth hangs loose."""
    near: Booleans = np.interp(shares, CLOTH_LEVELS, loose) > 0
    return near


def _given(
    estimator: Estimator,
    centre: Floats,
    at: Floats,
    tapes: Floats,
    photos: Sequence[_Observed],
    noise: float,
    loose: Booleans,
) -> tuple[Likely, Floats, Floats]:
    """Which bodies are likely given the edges; what was taken for cloth; each edge's weight.

    Parameters
    ----------
    centre : ndarray of shape (K,), coefficients of what is likeliest without them.
    at : ndarray of shape (K,), coefficients of the body that the edges were taken beside, which
        measures what was asked.
    tapes : ndarray of shape (m, K), what was asked by coefficients.
    loose : ndarray of bool, shape (L,): where edges only say where the body ends at most.
    """
    rest, shares, outwards, slopes = (
        np.concatenate([getattr(photo, name) for photo in photos])
        for name in ("rest", "shares", "outwards", "slopes")
    )
    bounds, by_levels = _near(loose, shares), _by_levels(shares)
    # One cloth for all photos, but where it hangs loose; each its own place, lean and sway.
    parts = [
        slopes @ estimator.spread,
        CLOTH * np.where(bounds, 0, outwards)[:, None] * by_levels,
        bent := block_diag(*(photo.bent for photo in photos)),
        block_diag(*(photo.free for photo in photos)),
    ]
    every = np.concatenate(parts, axis=1) / noise
    size = len(at)
    cloth = slice(size, size + len(CLOTH_LEVELS) + bent.shape[1])
    w = np.linalg.solve(estimator.spread, at - centre)
    goal = rest / noise + every[:, :size] @ w
    known = tapes @ estimator.spread
    known /= TAPED * np.linalg.norm(known, axis=1)[:, None]
    # Cloth has its law's linear term; the little more is for levels that no photo shows.
    own = np.ones(every.shape[1])
    own[cloth] = 1e-3
    weights = np.where(bounds, 0.0, 1.0)
    for _ in range(REWEIGHTINGS):
        weighted = every * weights[:, None]
        precision = np.diag(own) + weighted.T @ every
        pull = weighted.T @ goal
        pull[cloth] -= 1
        taped, taped_pull = precision.copy(), pull.copy()
        taped[:size, :size] += known.T @ known
        taped_pull[:size] += known.T @ (known @ w)
        found, kept = _without_less_than_nothing(taped, taped_pull, cloth)
        off = goal - every @ found
        # A loose sleeve may hide a hand: there it has no say at all.
        outside = bounds & (off * outwards >= 0)
        weights = np.where(outside, 0, 1 / (1 + (off / OUTLIER) ** 2))
    # The tape fit sees to what was asked: of that, this spread knows nothing.
    half = np.linalg.cholesky(np.linalg.inv(precision[np.ix_(kept, kept)])[:size, :size])
    # A triangular root of spread · covariance · spreadᵀ, without squaring either.
    root = np.asarray(qr((estimator.spread @ half).T, mode="r")[0][:size].T, dtype=np.float64)
    triangle = root * np.where(np.diag(root) < 0, -1.0, 1.0)
    mean = centre + estimator.spread @ found[:size]
    cloths = found[size : size + len(CLOTH_LEVELS)] * CLOTH
    if loose.any():
        bounds &= outwards != 0
        hangs = noise * np.where(outside[bounds], off[bounds] / outwards[bounds], 0)
        share_of = by_levels[np.ix_(bounds, loose)]
        cloths[loose] = hangs @ share_of / np.maximum(share_of.sum(axis=0), 1e-9)
    return Likely(mean, triangle), cloths, weights


def _without_less_than_nothing(
    precision: Floats, pull: Floats, cloth: slice
) -> tuple[Floats, Booleans]:
    """The solution in which no cloth is below zero, and which unknowns are not held there."""
    others = np.ones(len(pull), dtype=bool)
    others[cloth] = False
    # With the others at their best for any cloth, what is left is a small problem of cloth alone.
    across = precision[others, cloth]
    best = np.linalg.solve(
        precision[np.ix_(others, others)], np.column_stack([across, pull[others]])
    )
    root = np.linalg.cholesky(precision[cloth, cloth] - across.T @ best[:, :-1]).T
    goal = solve_triangular(root, pull[cloth] - across.T @ best[:, -1], trans=1)
    found = np.empty(len(pull))
    found[cloth], _ = nnls(root, goal)
    found[others] = best[:, -1] - best[:, :-1] @ found[cloth]
    return found, others | (found > 0)
