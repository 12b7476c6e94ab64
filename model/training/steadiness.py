"""How steady measurements are: what a tiny movement of the skin, or a step between bodies, does."""

import numpy as np
from numpy.typing import NDArray

from model.anthropometry import TAKEN, TAPES, read_tapes
from model.appearance import vertex_normals
from model.geometry import Floats
from model.measurements import MEASUREMENTS
from model.shape_basis import load_shape_basis
from model.tapes import Tape
from model.template_mesh import load_template_mesh
from model.training.population import Population
from model.training.population_report import table

TINY = 1e-5
"""A hundredth of a millimetre, in metres."""

STEPS = 100
"""From one body to another."""

LINES = 20
"""So many lines between any bodies, and as many between heavy ones, are walked for the report."""

HEAVY = 60
"""So many of the heaviest bodies for their height count as heavy there."""


def changes_by_tiny(coefficients: Floats, seed: int) -> Floats:
    """How much measurements change where the skin moves by a hundredth of a millimetre.

    Each body is moved twice: every vertex by chance, as far as that along each axis; and all of
    them outwards.

    Parameters
    ----------
    coefficients : ndarray of shape (n, K), the bodies on the shape basis.

    Returns
    -------
    ndarray of shape (n, 2, M), the changes of each of `TAKEN` by chance and outwards, SI.
    """
    template, basis = load_template_mesh(), load_shape_basis()
    random = np.random.default_rng(seed)
    tapes = [TAPES[name] for name in TAKEN]
    changes = np.empty((len(coefficients), 2, len(TAKEN)))
    for row, one in enumerate(coefficients):
        body = basis.vertices(one[None])[0]
        moved = np.stack([body, body, body])
        moved[1] += random.uniform(-TINY, TINY, body.shape)
        moved[2] += TINY * vertex_normals(body, template.faces)
        values = read_tapes(template, moved, tapes)
        changes[row] = np.abs(values[1:] - values[0])
    return changes


def jumps(ones: Floats, others: Floats, tapes: list[Tape]) -> Floats:
    """By how much a step along lines between bodies differs from the step before and the next.

    A place of the skin that is lost or won at once makes one step differ from both. Where one
    place takes over from another steps change too, but stay changed.

    Parameters
    ----------
    ones, others : ndarrays of shape (n, K), the ends of the lines on the shape basis.

    Returns
    -------
    ndarray of shape (n, tapes), the largest of each line, SI.
    """
    shares = np.linspace(0, 1, STEPS + 1)[:, None]
    largest = []
    for one, other in zip(ones, others, strict=True):
        bodies = load_shape_basis().vertices((1 - shares) * one + shares * other)
        changes = np.abs(np.diff(read_tapes(load_template_mesh(), bodies, tapes), 2, axis=0))
        largest.append(np.minimum(changes[:-1], changes[1:]).max(axis=0))
    return np.array(largest)


def heaviest(population: Population, count: int, below: float = 60.0) -> NDArray[np.int64]:
    """The rows of the bodies with the largest body-mass index below one, in kg/m²: (count,)."""
    index = body_mass_index(population)
    order = np.argsort(index)
    return order[index[order] < below][-count:]


def body_mass_index(population: Population) -> Floats:
    """In kg/m²: ndarray of shape (n,)."""
    indices: Floats = population.taken[:, 1] / population.taken[:, 0] ** 2
    return indices


def steadiness_section(population: Population) -> str:
    """The part of docs/validation.md about this, as Markdown."""
    seed = population.seed
    changes = changes_by_tiny(population.coefficients, seed)
    random = np.random.default_rng(seed)
    heavy = heaviest(population, HEAVY)
    pairs = [random.choice(len(population.sexes), 2, replace=False) for _ in range(LINES)]
    pairs += [random.choice(heavy, 2, replace=False) for _ in range(LINES)]
    ones, others = population.coefficients[np.array(pairs).T]
    walked = jumps(ones, others, [TAPES[name] for name in TAKEN])
    rows = []
    for place, name in enumerate(TAKEN):
        if MEASUREMENTS[name].kind == "mass":
            continue
        by_chance, outwards = changes[:, :, place].T
        numbers = [by_chance.max(), np.median(outwards), np.quantile(outwards, 0.99)]
        numbers.append(outwards.max())
        jumped = [walked[part, place].max() for part in (slice(LINES), slice(LINES, None))]
        rows.append(
            [f"`{name}`", *(f"{n * 1e3:.3f}" for n in numbers), *(f"{j * 1e3:.2f}" for j in jumped)]
        )
    return "\n\n".join(
        [
            f"By how many mm each measurement changes where the skin of all {len(changes)} bodies "
            "of the population moves by 0.01 mm: every point by chance along each axis, or all "
            "outwards. A hoop whose points all move outwards by that much grows by 0.063, as 2 π "
            "is; one that lies where a body widens steeply, as between a short neck and the "
            f"shoulders, by more. Then how much one step of a hundred along {LINES} lines between "
            f"any two bodies, and {LINES} between two of the {HEAVY} heaviest for their height, "
            "differs from the steps before and after it. Tapes that jumped to another place once "
            f"made steps of 2 mm and more. Seed {seed}.",
            table(
                [
                    "",
                    "by chance, largest",
                    "outwards, median",
                    "outwards, 99 %",
                    "outwards, largest",
                    "step, any two",
                    "step, heavy",
                ],
                rows,
            ),
        ]
    )
