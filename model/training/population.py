"""The open population as shipped: its people, and their bodies back from coefficients."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from model.geometry import Booleans, Floats
from model.shape_basis import load_shape_basis
from model.template_mesh import DATA
from model.training.survey import SEXES, Sex

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
        """Which bodies are of one sex: (n,)."""
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
