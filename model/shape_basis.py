"""The small space that all bodies live in: a mean and directions on half of the template.

Bodies of the population are symmetric, so that the left half says it all. A body is the
mean plus its coefficients times the directions; coefficients have unit deviation over the
population.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from model.geometry import Floats, Integers
from model.template_mesh import DATA, Gradient, reading


@dataclass(frozen=True, eq=False)
class ShapeBasis:
    """A linear space of symmetric bodies.

    Attributes
    ----------
    mean : ndarray of shape (H, 3), metres: the kept half of the mean body.
    directions : ndarray of shape (K, H·3), float32, metres per unit of coefficient; laid
        out so that what all directions do to one coordinate stands together.
    half : ndarray of shape (H,), the kept vertices.
    mirror : ndarray of shape (V,), the vertex on the other side of the body.
    fingerprint : tells this basis from any other; estimators belong to one basis.
    """

    mean: Floats
    directions: NDArray[np.float32]
    half: NDArray[np.int32]
    mirror: NDArray[np.int32]
    fingerprint: str

    def vertices(self, coefficients: Floats) -> Floats:
        """Bodies from coefficients.

        Parameters
        ----------
        coefficients : ndarray of shape (B, K).

        Returns
        -------
        ndarray of shape (B, V, 3), metres; soles at Y = 0, centred at X = 0.
        """
        bodies = self._whole(self.mean + self._half_moves(coefficients))
        bodies[..., 1] -= bodies[..., 1].min(axis=1, keepdims=True)
        return bodies

    def moves(self, changes: Floats) -> Floats:
        """How vertices move where coefficients change, not yet put on the floor again.

        Parameters
        ----------
        changes : ndarray of shape (n, K).

        Returns
        -------
        ndarray of shape (n, V, 3), metres.
        """
        return self._whole(self._half_moves(changes))

    def _half_moves(self, changes: Floats) -> NDArray[np.float32]:
        moved: NDArray[np.float32] = changes.astype(np.float32) @ self.directions
        return moved.reshape(len(moved), -1, 3)

    def _whole(self, half: NDArray[np.floating[Any]]) -> Floats:
        """Both sides from the kept one: (n, H, 3) to (n, V, 3)."""
        places, signs = self._folded
        whole = half.astype(np.float64).take(places, axis=1)
        whole[..., 0] *= signs
        return whole

    def by_coefficients(self, gradients: Sequence[Gradient]) -> Floats:
        """Derivatives by vertices chained to derivatives by coefficients.

        What the right side does is folded onto the left. The soles' own motion is left out,
        as no tape knows where a body stands.

        Parameters
        ----------
        gradients : n derivatives by the vertices of one body.

        Returns
        -------
        ndarray of shape (n, K).
        """
        places, signs = self._folded
        size = self.directions.shape[1]
        by_coefficients = np.empty((len(gradients), len(self.directions)))
        few, columns, slopes = [], [], []
        for row, (indices, by_vertex) in enumerate(gradients):
            by_place = by_vertex.astype(np.float32)
            by_place[:, 0] *= signs[indices]
            column = (3 * places[indices][:, None] + np.arange(3)).ravel()
            if len(column) > size:
                folded = np.bincount(column, by_place.ravel(), size).astype(np.float32)
                by_coefficients[row] = self.directions @ folded
            else:
                few.append(row)
                columns.append(column)
                slopes.append(by_place.ravel())
        if few:
            ends = np.cumsum([0, *map(len, columns)])
            sparse = (np.concatenate(slopes), np.concatenate(columns), ends)
            by_coefficients[few] = csr_array(sparse, shape=(len(few), size)) @ self.directions.T
        return by_coefficients

    @cached_property
    def _folded(self) -> tuple[Integers, NDArray[np.float32]]:
        """Each vertex's place in the kept half, and -1 where left and right change: (V,) each."""
        places = np.empty(len(self.mirror), dtype=np.int64)
        signs = np.full(len(self.mirror), -1, dtype=np.float32)
        places[self.mirror[self.half]] = np.arange(len(self.half))
        places[self.half] = np.arange(len(self.half))
        signs[self.half] = 1
        return places, signs


@lru_cache(maxsize=4)
def load_shape_basis(folder: Path = DATA) -> ShapeBasis:
    """The shipped basis, mapped from its file and made into floats once per process.

    Raises
    ------
    FileNotFoundError, DamagedFileError
        Where a file is missing or damaged; the message names it.
    """
    with reading(folder / "shape_directions.npy") as path:
        stored = np.load(path, mmap_mode="r", allow_pickle=False)
    path = folder / "shape_basis.npz"
    with reading(path), path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
        return ShapeBasis(
            mean=arrays["mean"].astype(np.float64),
            directions=np.multiply(stored.T, arrays["scales"].astype(np.float32), order="C").T,
            half=arrays["half"].astype(np.int32),
            mirror=arrays["mirror"].astype(np.int32),
            fingerprint=str(arrays["fingerprint"]),
        )
