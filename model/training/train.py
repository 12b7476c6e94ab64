"""Trains the shipped estimators from the shipped population; needs no PyTorch."""

from pathlib import Path

import numpy as np
from scipy.stats import chi2

from model.anthropometry import TAKEN, TAPES, measure_batch
from model.checksums import write_sums
from model.estimators import Estimator, LinearBodyEstimator
from model.geodesics import save_strips
from model.geometry import Floats
from model.measurements import BODY_KINDS, BodyKind
from model.shape_basis import load_shape_basis
from model.tape_fit import USUAL
from model.tapes import legs_of
from model.template_mesh import DATA, load_template_mesh, template_mesh_from
from model.training.law_fit import joint_law, load_survey_law
from model.training.population import Population, bodies_of, load_population
from model.training.strips import find_strips

ROOM = 0.15
"""How far beyond the population's extremes a value may lie and still be taken for real."""

LEAST_VARIANCE = 1e-4
"""Of a coefficient, whose variance over the whole population is 1."""

REACH_SUBSETS = 200
"""On how many subsets of measurements it is found how far out the population's bodies lie."""

STRIP_BODIES = 120
"""On how many bodies, evenly through the population, geodesics are looked for; and on those at
both ends of as many components of the shape basis."""


def write_strips(population: Population, path: Path = DATA / "strips.npz") -> None:
    """Finds the strips that geodesic lengths run over, and writes them beside the template."""
    with np.load(DATA / "template_mesh.npz", allow_pickle=False) as arrays:
        template = template_mesh_from(arrays)
    coefficients = population.coefficients
    leading = coefficients[:, :STRIP_BODIES]
    evenly = np.linspace(0, len(coefficients) - 1, STRIP_BODIES).astype(np.int64)
    rows = np.unique(np.concatenate([evenly, leading.argmin(axis=0), leading.argmax(axis=0)]))
    bodies = load_shape_basis().vertices(coefficients[rows])
    save_strips(path, find_strips(template, bodies, legs_of(TAPES.values())))
    load_template_mesh.cache_clear()


def measure_population(population: Population) -> Floats:
    """Takes every measurement of every body: ndarray of shape (n, M), SI; shows progress."""
    template = load_template_mesh()
    values = np.empty((len(population.sexes), len(TAKEN)))
    rows = np.arange(len(values))
    for part, vertices in bodies_of(population, rows):
        values[part] = measure_batch(template, vertices)
        print(f"\rmeasured {part.stop} of {len(values)} bodies", end="", flush=True)
    print()
    return values


def plausible_limits(values: Floats) -> dict[str, tuple[float, float]]:
    """What an adult may measure, given bodies' values, (n, M) with NaN where one is missing."""
    low, high = np.nanmin(values, axis=0) * (1 - ROOM), np.nanmax(values, axis=0) * (1 + ROOM)
    # Whole centimetres and kilograms, outwards: these are shown to people.
    unit = np.array([1.0 if name == "weight" else 0.01 for name in TAKEN])
    limits = np.round(np.stack([np.floor(low / unit), np.ceil(high / unit)], 1) * unit[:, None], 2)
    return dict(zip(TAKEN, map(tuple, limits.tolist()), strict=True))


def train_estimator(
    kind: BodyKind, population: Population, values: Floats, *, fit_intercept: bool = True
) -> Estimator:
    """Fits the linear law of one kind of body to the bodies that are not held out.

    Parameters
    ----------
    values : ndarray of shape (n, M), what every body of the population measures, SI, as `TAKEN`.
    """
    seen = ~population.held_out
    if kind != "neutral":
        seen &= population.of(kind)
    linear = LinearBodyEstimator(fit_intercept=fit_intercept)
    linear.fit(values[seen], population.coefficients[seen])
    return Estimator(
        kind=kind,
        names=TAKEN,
        linear=linear,
        law=joint_law(load_survey_law(kind), values[seen]),
        spread=spread_of(population.coefficients[seen]),
        reach=reach_of(values[seen]),
        limits=plausible_limits(values[seen]),
        population="open population: drawn from ANSUR II's statistics, bodies made with Anny 0.6.2",
        seed=population.seed,
        date=population.date,
        basis=load_shape_basis(),
        template=load_template_mesh(),
    )


def spread_of(coefficients: Floats) -> Floats:
    """The factor of the coefficients' covariance, (K, K), of bodies (n, K): few bodies will do."""
    covariance = np.cov(coefficients.T) + LEAST_VARIANCE * np.eye(coefficients.shape[1])
    return np.linalg.cholesky(covariance).astype(np.float64)


def reach_of(values: Floats, seed: int = 0) -> float:
    """How much further out bodies lie than if their measurements were normal.

    Over random subsets of measurements, of each body the squared distance from the mean in the
    covariance of the subset, as a share of the quantile of chi-squared; of those shares the
    same quantile. About 1 for a normal law, and 1 at least.

    Parameters
    ----------
    values : ndarray of shape (n, M), SI.
    """
    random = np.random.default_rng(seed)
    standard = (values - values.mean(axis=0)) / values.std(axis=0)
    shares = []
    for _ in range(REACH_SUBSETS):
        count = int(random.integers(1, values.shape[1] + 1))
        some = standard[:, random.choice(values.shape[1], count, replace=False)]
        # Some lengths are sums of others.
        inverse = np.linalg.pinv(np.atleast_2d(np.cov(some.T)), rcond=1e-10, hermitian=True)
        distances = np.einsum("ni,ij,nj->n", some, inverse, some, optimize=True)
        shares.append(distances / chi2.ppf(USUAL, count))
    return max(1.0, float(np.quantile(shares, USUAL)))


def train() -> None:
    """Finds the strips of geodesics, measures the population, and writes the estimators; last, the
    checksums of all that a site loads.
    """
    population = load_population()
    write_strips(population)
    values = measure_population(population)
    folder = DATA / "estimators"
    folder.mkdir(exist_ok=True)
    for kind in BODY_KINDS:
        estimator = train_estimator(kind, population, values)
        path = folder / f"{kind}.npz"
        estimator.save(path)
        print(f"{path.name}: {estimator.linear.count_} bodies, {path.stat().st_size} bytes")
    write_sums(DATA)
