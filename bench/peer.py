"""The same girths by a library's own means: `trimesh.Trimesh.section` and a convex hull."""

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from model.geometry import Floats
from model.girths import Girth
from model.template_mesh import TemplateMesh


@dataclass(frozen=True)
class Planes:
    """The planes of one girth on one body.

    origins : ndarray of shape (planes, 3), metres
    normal : ndarray of shape (3,), of length 1
    """

    origins: Floats
    normal: Floats


@dataclass(frozen=True, eq=False)
class PeerGirth:
    """A girth as a user of trimesh would take it: cut, flatten, hull, choose.

    name : of the measurement
    tape : our girth, for its definition
    vertices : ndarray of shape (n,), the template's that the part uses
    faces : ndarray of shape (F, 3), places in `vertices`
    """

    name: str
    tape: Girth
    vertices: NDArray[np.int64]
    faces: NDArray[np.int64]

    @classmethod
    def of(cls, name: str, tape: Girth, template: TemplateMesh) -> "PeerGirth":
        """Picks out the body part once, as ours does."""
        faces = template.faces[template.faces_of(*tape.parts)]
        for landmark, radius in tape.past:
            passed = template.landmark_points(template.vertices, landmark)
            far = np.linalg.norm(template.vertices - passed, axis=1) > radius
            faces = faces[far[faces].all(axis=1)]
        vertices, places = np.unique(faces, return_inverse=True)
        return cls(name, tape, vertices.astype(np.int64), places.reshape(faces.shape))

    def planes(self, template: TemplateMesh, vertices: Floats) -> Planes:
        """The planes of the tape's definition on a body, vertices of shape (V, 3)."""
        tape = self.tape
        start = template.landmark_points(vertices, *tape.start)
        axis = template.landmark_points(vertices, *tape.stop) - start
        if tape.cut == "level":
            normal = np.array([0.0, 1.0, 0.0])
        elif tape.cut == "across":
            normal = axis
        else:
            back, front = (
                template.landmark_points(vertices, tape.start[end], tape.stop[end])
                for end in (0, -1)
            )
            normal = np.cross(front - back, [1.0, 0.0, 0.0])
        fractions = np.linspace(*tape.span, tape.planes)
        return Planes(start + fractions[:, None] * axis, normal / np.linalg.norm(normal))

    def take(self, vertices: Floats, planes: Planes, only: int | None = None) -> tuple[float, int]:
        """The girth, in metres, and the number of the plane that counts; of one alone if told.

        vertices : ndarray of shape (V, 3), metres: of a body on the template.

        Raises
        ------
        ValueError
            Where a plane misses the part.
        """
        mesh = trimesh.Trimesh(vertices[self.vertices], self.faces, process=False)
        tried = range(len(planes.origins)) if only is None else [only]
        girths = [self._girth(mesh, planes, planes.origins[number]) for number in tried]
        best = np.argmax(girths) if self.tape.pick == "widest" else np.argmin(girths)
        return girths[best], tried[best]

    def _girth(self, mesh: trimesh.Trimesh, planes: Planes, origin: Floats) -> float:
        section = mesh.section(plane_normal=planes.normal, plane_origin=origin)
        if section is None:
            raise ValueError(f"the plane through {origin} misses the part of {self.name}")
        points = np.asarray(section.vertices)
        right = np.cross(planes.normal, np.eye(3)[np.argmin(np.abs(planes.normal))])
        right /= np.linalg.norm(right)
        flat = np.column_stack([points @ right, points @ np.cross(planes.normal, right)])
        # Of a polygon scipy's "area" is the perimeter.
        return float(ConvexHull(flat).area)
