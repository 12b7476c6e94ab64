"""Unit and axes of a set of scans: recognised, said, and turned into ours.

Ours are metres, +Y up, facing +Z, soles at Y = 0. The way is one for the whole set; then each scan
is turned about the vertical and moved over the ground until it lies best on the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from model import geometry
from model.appearance import vertex_normals
from model.estimators import Estimator
from model.geometry import Floats
from model.tapes import BODY_DENSITY
from model.training.scans_files import ScanError
from model.training.scans_registration import ARMS, Mannequin, Skin

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""Metres of each."""

STATURES = (1.2, 2.3)
"""Of adults, in metres: wider than any survey's, and narrow enough to tell the units apart."""

AXES = ("+x", "-x", "+y", "-y", "+z", "-z")

UPRIGHT = 0.9
"""The second longest side of a set's bounding boxes is below this share of the longest."""

CLEAR = 0.85
"""The best of the ways to face is nearer to our body than this share of the second best."""

CAPPED = 0.1
"""No point of our body counts as further from the scans' skin than this, in metres."""

FAR_TURNED = 45.0
"""Degrees about the vertical by which no scan may lie off the others."""

FAR_OFF = 0.15
"""Metres from the mean shape, on average over a scan's vertices: they are other places."""


@dataclass(frozen=True, eq=False)
class Frame:
    """How the scans' coordinates become ours.

    Attributes
    ----------
    unit : m, cm or mm.
    up, front : the axes of the scans along which a person stands and looks, such as +z.
    """

    unit: str
    up: str
    front: str

    @property
    def matrix(self) -> Floats:
        """Takes points of the scans to ours, but for the place: ndarray of shape (3, 3)."""
        up, front = direction(self.up), direction(self.front)
        return np.array([np.cross(up, front), up, front]) * UNITS[self.unit]


def direction(axis: str) -> Floats:
    """The unit vector of an axis such as -y: (3,)."""
    return np.eye(3)["xyz".index(axis[1])] * (-1.0 if axis[0] == "-" else 1.0)


def recognise_unit(
    names: Sequence[str], vertices: NDArray[np.float32], unit: str | None, up: str | None
) -> tuple[str, int]:
    """The unit, and along which of the three axes people stand.

    Parameters
    ----------
    names : of the n scans, for messages.
    vertices : ndarray of shape (n, V, 3), in the scans' unit and axes.
    unit, up : where they are known.

    Raises
    ------
    ScanError
        Where statures are those of no adult in any unit, or of one file in another, or where no
        axis is clearly the longest.
    """
    low, high = STATURES
    sides = np.ptp(vertices, axis=1).astype(np.float64)
    usual = np.median(sides, axis=0)
    axis = "xyz".index(up[1]) if up else int(usual.argmax())
    if not up and np.sort(usual)[1] > UPRIGHT * usual.max():
        raise ScanError(
            f"which way is up? The scans measure {_listed(usual)} along x, y and z: give --up"
        )
    fitting = [u for u, size in UNITS.items() if _is_adult(usual[axis] * size)]
    if unit is None and not fitting:
        raise ScanError(
            f"{names[0]}: {sides[0, axis]:.4g} high; in metres, centimetres or millimetres an "
            f"adult stands {low} to {high} m: give the scans in one of these"
        )
    unit = unit or fitting[0]
    for name, height in zip(names, sides[:, axis] * UNITS[unit], strict=True):
        if not _is_adult(height):
            others = [u for u, size in UNITS.items() if _is_adult(height / UNITS[unit] * size)]
            why = f"is it in {others[0]}?" if others else f"adults stand {low} to {high} m"
            raise ScanError(f"{name}: {height:.4g} m high, if in {unit} as the set is: {why}")
    return unit, axis


def _is_adult(stature: float) -> bool:
    return STATURES[0] <= stature <= STATURES[1]


def _listed(values: Floats) -> str:
    return ", ".join(f"{value:.4g}" for value in values)


def guess(estimator: Estimator, vertices: Floats, faces: NDArray[np.int32]) -> Floats:
    """The shape of somebody with the stature and volume of a mesh in metres, +Y up: (K,)."""
    known = {
        "stature": float(np.ptp(vertices[:, 1])),
        "weight": BODY_DENSITY * float(geometry.volume(vertices, faces)),
    }
    row = np.array([[known.get(name, np.nan) for name in estimator.names]])
    return estimator.linear.predict(row)[0]


def recognise_axes(
    estimator: Estimator,
    shape: Floats,
    faces: NDArray[np.int32],
    unit: str,
    axis: int,
    given: tuple[str | None, str | None],
) -> Frame:
    """Which way up and front are, by laying our body on the set's mean in each way.

    Parameters
    ----------
    shape : ndarray of shape (V, 3), the mean in the scans' unit and axes.
    faces : wound outwards.
    axis : along which people stand.
    given : up and front, where they are known.

    Raises
    ------
    ScanError
        Where no way is clearly the best.
    """
    up, front = given
    ways = [
        Frame(unit, u, f)
        for u in ([up] if up else [a for a in AXES if a[1] == "xyz"[axis]])
        for f in ([front] if front else [a for a in AXES if a[1] != "xyz"[axis]])
        if f[1] != u[1]
    ]
    if not ways:
        raise ScanError(f"up is {up} and front {front}: they must be two axes")
    mannequin = Mannequin(estimator.template, estimator.basis)
    random = np.random.default_rng(0)
    sample = np.sort(random.permutation(len(estimator.template.vertices))[:1500])
    mannequin.coefficients[:] = guess(estimator, shape @ ways[0].matrix.T, faces)
    bodies = []
    for angle in ARMS:
        mannequin.raise_arms(angle)
        body = on_the_ground(mannequin.vertices())
        bodies.append((body[sample], vertex_normals(body, estimator.template.faces)[sample]))
    distances = []
    for way in ways:
        skin = Skin(on_the_ground(shape @ way.matrix.T), faces)
        apart = (skin.nearest_vertex(*body)[1] for body in bodies)
        distances.append(min(float(np.minimum(far, CAPPED).mean()) for far in apart))
    order = np.argsort(distances)
    if len(ways) > 1 and distances[order[0]] > CLEAR * distances[order[1]]:
        first, second = (ways[i] for i in order[:2])
        raise ScanError(
            f"is up {first.up} and front {first.front}, or up {second.up} and front "
            f"{second.front}? Give --up and --front"
        )
    return ways[order[0]]


def on_the_ground(vertices: Floats) -> Floats:
    """Points, (V, 3), with the lowest at Y = 0 and the middle of their box at X = Z = 0."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    return vertices - [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2]


def place(names: Sequence[str], vertices: NDArray[np.float32], frame: Frame) -> float:
    """Turns all scans into our unit and axes, in place, and lays them on one another.

    Parameters
    ----------
    vertices : ndarray of shape (n, V, 3); holds metres afterwards, soles at Y = 0, the mean
        shape's middle at X = Z = 0.

    Returns
    -------
    float, the largest angle by which a scan was turned about the vertical, in degrees.

    Raises
    ------
    ScanError
        For a scan that faces elsewhere than the others, or does not correspond to them.
    """
    matrix = frame.matrix.T.astype(np.float32)
    for scan in vertices:
        scan[:] = scan @ matrix
        scan -= [scan[:, 0].mean(), scan[:, 1].min(), scan[:, 2].mean()]
    turned = np.zeros(len(vertices))
    for _ in range(2):
        mean = vertices.mean(axis=0, dtype=np.float64)
        for row, scan in enumerate(vertices):
            across = np.sum(mean[:, 0] * scan[:, 2] - mean[:, 2] * scan[:, 0])
            along = np.sum(mean[:, 0] * scan[:, 0] + mean[:, 2] * scan[:, 2])
            angle = np.arctan2(across, along)
            turned[row] += angle
            scan[:] = scan @ Rotation.from_rotvec([0, angle, 0]).as_matrix().T.astype(np.float32)
    degrees = np.degrees(np.abs(turned))
    mean = vertices.mean(axis=0, dtype=np.float64)
    for name, scan, angle in zip(names, vertices, degrees, strict=True):
        if angle > FAR_TURNED:
            raise ScanError(f"{name}: turned by {angle:.0f} degrees against the other scans")
        off = float(np.linalg.norm(scan - mean, axis=1).mean())
        if off > FAR_OFF:
            raise ScanError(
                f"{name}: vertices lie {off:.2f} m from the others' on average: they do not "
                "correspond, or it stands in another way"
            )
    middle = mean - on_the_ground(mean)
    vertices -= (middle * [1, 0, 1]).astype(np.float32)
    return float(degrees.max())
