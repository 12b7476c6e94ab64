"""Writes ``docs/stance.md``: people drawn anew, and what one stance for all takes away.

Bodies of another seed are fitted as the population's are. Nothing was chosen by them, neither the
stance nor the estimators' settings; so what estimates miss of them is what they miss of anybody.
"""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from model.anthropometry import TAKEN, measure_batch
from model.estimators import load_estimators
from model.geometry import Floats
from model.template_mesh import TemplateMesh, load_template_mesh
from model.training.anny_population import BlendShapes, load_blend_shapes
from model.training.fit_report import EIGHT, fit_all
from model.training.person_fit import deformed, placed
from model.training.population import load_population
from model.training.population_build import CHUNK, WORK, draw_of, fit_chunk, recipe
from model.training.population_files import read_fitted
from model.training.population_report import table
from model.training.stance import LINES, in_one_stance, stance_of
from model.training.survey import SEXES, Sex
from model.training.train import measure_population
from model.training.validation import most_telling_of

PER_SEX = 100

AS_HELD = "in the one stance, as the population"
TRUNK_FREE = "trunk and neck as each holds them, arms and legs alike"

MIDDLE = 0.001
"""Vertices of the template that are nearer to its middle, in metres, lie on it."""


def write_stance_report(seed: int, docs: Path = Path("docs")) -> None:
    """Fits people of another seed and writes the document.

    Raises
    ------
    ValueError
        For the population's own seed, whose people are not new.
    """
    population = load_population()
    if seed == population.seed:
        raise ValueError(f"the population itself is of seed {seed}")
    shapes = load_blend_shapes(WORK / "blend_shapes.npz")
    template = load_template_mesh()
    folder = WORK / recipe() / f"seed_{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    chunks = [
        (sex, start, folder / f"{sex}_{start:05d}.npz")
        for sex in SEXES
        for start in range(0, PER_SEX, CHUNK)
    ]
    missing = [chunk for chunk in chunks if not chunk[2].exists()]
    print(f"fitting {CHUNK * len(missing)} people", flush=True)
    Parallel(n_jobs=2)(delayed(fit_chunk)(WORK, seed, *chunk) for chunk in missing)
    measured = measure_population(population)
    estimators = load_estimators()
    stances: list[Floats] = []
    backs: list[Floats] = []
    rows: list[list[str]] = []
    for sex in SEXES:
        paths = [path for one, _, path in chunks if one == sex]
        fitted = read_fitted([(sex, path) for path in paths], template)
        kept = np.flatnonzero(fitted.kept())
        standing = fitted.vertices[kept].astype(np.float64)
        loose = _loose_bodies(shapes, seed, sex, paths, kept)
        stances += [stance_of(body) for body in loose]
        backs += [back_of(template, body) for body in standing]
        leaning = [placed(in_one_stance(template, body, upright=False)) for body in loose]
        telling = most_telling_of(population, measured, sex, len(EIGHT))
        for words, bodies in ((AS_HELD, standing), (TRUNK_FREE, np.array(leaning))):
            values = dict(zip(TAKEN, measure_batch(template, bodies).T, strict=True))
            apart = [
                fit_all(estimators[sex], values, entered, bodies).vertices * 1e3
                for entered in (telling, EIGHT, TAKEN)
            ]
            cells = [f"{one.mean():.1f} ± {one.std() / len(one) ** 0.5:.1f}" for one in apart]
            rows.append([f"{sex}, {words}", f"{len(bodies)}", *cells])
    text = "\n\n".join(
        [
            "# People drawn anew, and the one stance",
            f"Written by `make stance`; do not edit. {datetime.now(UTC):%Y-%m-%d}, "
            f"{PER_SEX} people of each sex of seed {seed}; {len(stances)} bodies are kept by the "
            f"population's rules; estimators of {population.date}, seed {population.seed}. "
            "Nobody chose anything by these people.",
            "## How far estimates are off",
            "Mean distance of vertices in mm, with the standard error of that mean for so many "
            "bodies; nothing is moved to where it fits best. *Telling*: the eight measurements "
            "that tell most of the surface, stature among them. *Shopper's*: the "
            "seven of a form and the thigh. The second rows show what one stance for all takes "
            "away: nothing that is entered tells how somebody leans.",
            table(["", "bodies", "telling", "shopper's", "all 41"], rows),
            "## What is held alike",
            "How the same bodies stand before they are put into the stance (mean ± deviation), and "
            "the stance.",
            table(
                ["", "as they stand", "the stance"],
                [
                    [words, f"{own.mean():.1f} ± {own.std():.1f}", f"{held:g}"]
                    for (words, held), own in zip(LINES.items(), np.transpose(stances), strict=True)
                ],
            ),
            "## What stays each body's own",
            "Roundness: how far the back stands out behind the straight line from the neck's last "
            "vertebra to the waist; hollow: how far the waist at the back lies before the line "
            "from there to the fullest part of the buttocks. In the stance, in mm.",
            table(
                ["", "mean ± deviation", "least", "most"],
                [
                    [
                        words,
                        f"{own.mean():.0f} ± {own.std():.0f}",
                        f"{own.min():.0f}",
                        f"{own.max():.0f}",
                    ]
                    for words, own in zip(
                        ("roundness", "hollow"), 1e3 * np.transpose(backs), strict=True
                    )
                ],
            ),
        ]
    )
    (docs / "stance.md").write_text(text + "\n", encoding="utf-8")
    print(text)


def _loose_bodies(
    shapes: BlendShapes, seed: int, sex: Sex, paths: Sequence[Path], kept: NDArray[np.int64]
) -> Floats:
    """Those of some files' bodies as Anny stands them: (n, V, 3)."""
    files = [np.load(path, allow_pickle=False) for path in paths]
    drawn, parameters = (
        np.concatenate([file[key] for file in files]) for key in ("drawn", "parameters")
    )
    draws = {row: draw_of(shapes, seed, sex, row, drawn[row]) for row in kept.tolist()}
    return np.array(
        [deformed(shapes, draw.fixed, parameters[row])[0] for row, draw in draws.items()]
    )


def back_of(template: TemplateMesh, vertices: Floats) -> Floats:
    """Roundness and hollow of a standing body's back, (V, 3) to (2,), metres."""
    neck, waist = (template.landmark_points(vertices, n) for n in ("cervicale", "waist_back"))
    middle = vertices[np.abs(template.vertices[:, 0]) < MIDDLE]
    back = middle[(middle[:, 1] > waist[1]) & (middle[:, 1] < neck[1])]
    behind = _before(neck, waist, back)
    roundest = back[behind.argmin()]
    buttock = template.landmark_points(vertices, "buttock_point_left")
    return np.array([-behind.min(), _before(roundest, buttock, waist[None])[0]])


def _before(upper: Floats, lower: Floats, points: Floats) -> Floats:
    """How far points lie before the line between two others, seen from the side: (n, 3) to (n,)."""
    along = (lower - upper)[1:] / np.linalg.norm((lower - upper)[1:])
    off = points[:, 1:] - upper[1:]
    return off @ np.array([along[1], -along[0]])
