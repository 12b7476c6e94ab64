"""Outlines as photos would give them, of bodies that are known: cameras, noise."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from model.masks import Mask, runs

STEP = 0.002

WAVES = 0.03
"""Metres: how far along an outline its errors are alike."""


def roughened(
    mask: Mask, share: float, height: float, random: np.random.Generator
) -> NDArray[np.float32]:
    """A mask whose outline is moved at every point by a share of the breadth there.

    Parameters
    ----------
    share : of the row's run of pixels that ends there, as a standard deviation.
    height : of the person, in metres.

    Returns
    -------
    ndarray of shape (h, w), with space around the person.
    """
    inside = np.pad(mask.cover, 30) >= 0.5
    rows, starts, ends = runs(inside)
    breadths = np.zeros(inside.shape)
    for row, start, end in zip(rows, starts, ends, strict=True):
        breadths[row, start:end] = end - start
    outwards, nearest = ndimage.distance_transform_edt(~inside, return_indices=True)
    breadths = breadths[tuple(nearest)]
    depths = ndimage.distance_transform_edt(inside) - outwards
    waves = ndimage.gaussian_filter(
        random.normal(size=inside.shape), WAVES / height * len(mask.cover)
    )
    depths += share * breadths * waves / waves.std()
    return np.clip(depths + 0.5, 0, 1).astype(np.float32)
