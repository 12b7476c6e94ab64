"""The mesh that all bodies share: its triangles, parts and landmarks; and a body on it.

Axes and units as in :mod:`model`: metres, +Y up, facing +Z, the person's left at +X.
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.geodesics import Strips, load_strips
from model.geometry import Booleans, Floats, Integers
from model.measurements import BodyKind

DATA = Path(__file__).parent / "data"

UP = np.array([0.0, 1.0, 0.0])

Landmarks = tuple[str, ...]
"""Names; what is asked of several is asked of their mean point."""

Gradient = tuple[Integers, Floats]
"""Vertex indices (n,) and the derivative by each (n, 3); repeated indices add up."""


@dataclass(frozen=True)
class Landmark:
    """A named point on the skin, the same place on every body.

    Attributes
    ----------
    face : the triangle it lies in.
    weights : barycentric coordinates, by the triangle's corners; they sum to 1.
    """

    face: int
    weights: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class TemplateMesh:
    """The faces and mean shape that all bodies share.

    Attributes
    ----------
    vertices : ndarray of shape (V, 3), metres, the population's mean body.
    faces : ndarray of shape (F, 3), wound outwards; one closed 2-manifold.
    face_parts : ndarray of shape (F,), the body part of each face, by index.
    part_names : the parts, in the order of their index.
    mirror : ndarray of shape (V,), the vertex on the other side of the body.
    landmarks : the points that measurements run through, by name.
    strips : the strips of skin that geodesic lengths run over, by the landmarks at both ends.
    """

    vertices: Floats
    faces: NDArray[np.int32]
    face_parts: NDArray[np.uint8]
    part_names: tuple[str, ...]
    mirror: NDArray[np.int32]
    landmarks: Mapping[str, Landmark]
    strips: Strips = field(default_factory=dict)

    def faces_of(self, *parts: str) -> Booleans:
        """Which faces belong to any of these parts: ndarray of shape (F,).

        A part of both sides may be named without its side: ``upper_leg`` is
        ``upper_leg_left`` and ``upper_leg_right``.

        Raises
        ------
        ValueError
            For a part that the template does not have.
        """
        wanted: list[int] = []
        for part in parts:
            sides = (part, f"{part}_left", f"{part}_right")
            found = [i for i, name in enumerate(self.part_names) if name in sides]
            if not found:
                raise ValueError(f"the template has no part {part!r}, only {self.part_names}")
            wanted += found
        return np.isin(self.face_parts, wanted)

    def landmark_weights(self, *names: str) -> tuple[NDArray[np.int64], Floats]:
        """The mean point of some landmarks as a weighted sum of vertices.

        Returns
        -------
        indices : ndarray of shape (n,), vertex indices.
        weights : ndarray of shape (n,), summing to 1.
        """
        return _landmark_weights(self, names)

    def landmark_points(self, vertices: Floats, *names: str) -> Floats:
        """Where the mean point of some landmarks lies.

        Parameters
        ----------
        vertices : ndarray of shape (..., V, 3).

        Returns
        -------
        ndarray of shape (..., 3).
        """
        indices, weights = self.landmark_weights(*names)
        return np.einsum("...vi,v->...i", vertices[..., indices, :], weights)


@dataclass(frozen=True, eq=False)
class Body:
    """A shaped template.

    Attributes
    ----------
    template : the mesh it shares with all bodies.
    vertices : ndarray of shape (V, 3), metres; soles at Y = 0, centred at X = 0.
    kind : female, male or neutral.
    """

    template: TemplateMesh
    vertices: Floats
    kind: BodyKind


@lru_cache(maxsize=512)
def _landmark_weights(
    template: TemplateMesh, names: tuple[str, ...]
) -> tuple[NDArray[np.int64], Floats]:
    points = [template.landmarks[name] for name in names]
    indices = np.concatenate([template.faces[point.face] for point in points])
    weights = np.concatenate([point.weights for point in points]) / len(points)
    return indices.astype(np.int64), weights


class DamagedFileError(ValueError):
    """A shipped file is there, and is not what it was; the message names it."""


@contextmanager
def reading(file: Path) -> Iterator[Path]:
    """Names a file in whatever goes wrong while it is read.

    Raises
    ------
    FileNotFoundError, DamagedFileError
        The former as it is, the latter for anything else.
    """
    try:
        yield file
    except (FileNotFoundError, DamagedFileError):
        raise
    except Exception as error:
        raise DamagedFileError(f"{file} is damaged: {error}") from error


@lru_cache(maxsize=4)
def load_template_mesh(folder: Path = DATA) -> TemplateMesh:
    """The shipped template, read once per process.

    Raises
    ------
    FileNotFoundError
        Where the shipped data are missing; the message names the file.
    ValueError
        Where a file is damaged, or strips end elsewhere than the landmarks that they are named
        after.
    """
    path = folder / "template_mesh.npz"
    with reading(path), path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
        template = template_mesh_from(arrays, folder)
    with reading(folder / "strips.npz") as path:
        strips = load_strips(path)
    for way, several in strips.items():
        ends = [template.landmarks[name] for name in way]
        for strip in several:
            same = np.array_equal(strip.ends, template.faces[[end.face for end in ends]])
            if not same or not np.allclose(strip.weights, [end.weights for end in ends]):
                raise ValueError(
                    f"strips.npz was made for other landmarks than {' and '.join(way)}: train again"
                )
    return replace(template, strips=strips)


def template_mesh_from(arrays: Mapping[str, NDArray[Any]], folder: Path = DATA) -> TemplateMesh:
    """A template from its saved arrays and the folder's ``landmarks.json``, without strips.

    Parameters
    ----------
    arrays : by attribute of `TemplateMesh`, but for landmarks and strips; shapes as there.

    Raises
    ------
    FileNotFoundError, DamagedFileError
        Where the landmarks' file is missing or damaged; the message names it.
    """
    faces = arrays["faces"].astype(np.int32)
    with reading(folder / "landmarks.json") as file:
        landmarks = {
            name: Landmark(face=row["face"], weights=tuple(row["weights"]))
            for name, row in json.loads(file.read_text(encoding="utf-8"))["landmarks"].items()
        }
    return TemplateMesh(
        vertices=arrays["vertices"].astype(np.float64),
        faces=faces,
        face_parts=arrays["face_parts"].astype(np.uint8),
        part_names=tuple(str(name) for name in arrays["part_names"]),
        mirror=arrays["mirror"].astype(np.int32),
        landmarks=MappingProxyType(landmarks),
    )
