"""The small space that all bodies live in: a mean and directions on half of the template.

Bodies of the population are symmetric, so that the left half says it all. A body is the
mean plus its coefficients times the directions; coefficients have unit deviation over the
population.
"""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from model.geometry import Floats
from model.template_mesh import DATA


@dataclass(frozen=True, eq=False)
class ShapeBasis:
    """A linear space of symmetric bodies.

    Attributes
    ----------
    mean : ndarray of shape (H, 3), metres: the kept half of the mean body.
    directions : ndarray of shape (K, H·3), float32, metres per unit of coefficient.
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
        moved = coefficients.astype(np.float32) @ self.directions
        half = self.mean + moved.reshape(len(moved), -1, 3)
        bodies = np.empty((len(half), len(self.mirror), 3))
        bodies[:, self.mirror[self.half]] = half * [-1, 1, 1]
        bodies[:, self.half] = half
        bodies[..., 1] -= bodies[..., 1].min(axis=1, keepdims=True)
        return bodies


@lru_cache(maxsize=4)
def load_shape_basis(folder: Path = DATA) -> ShapeBasis:
    """The shipped basis, mapped from its file and made into floats once per process.

    Raises
    ------
    FileNotFoundError
        Where a file is missing; the message names it.
    """
    stored = np.load(folder / "shape_directions.npy", mmap_mode="r", allow_pickle=False)
    with np.load(folder / "shape_basis.npz", allow_pickle=False) as arrays:
        return ShapeBasis(
            mean=arrays["mean"].astype(np.float64),
            directions=stored.astype(np.float32) * arrays["scales"].astype(np.float32)[:, None],
            half=arrays["half"].astype(np.int32),
            mirror=arrays["mirror"].astype(np.int32),
            fingerprint=str(arrays["fingerprint"]),
        )
