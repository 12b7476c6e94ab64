"""What is where on a set's mean shape: body parts and landmarks, from our registered template.

Landmarks are kept in a file that a person may correct: a point that is moved there by hand is put
on the nearest skin, and counts from then on.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.sparse import csgraph, csr_array
from threadpoolctl import threadpool_limits

from model.appearance import vertex_normals
from model.estimators import Estimator
from model.geometry import Floats, Integers
from model.template_mesh import DATA, Landmark, TemplateMesh
from model.training.scans_files import ScanError
from model.training.scans_placing import guess
from model.training.scans_registration import Skin, register

LANDMARKS_FILE = "landmarks.json"

MOVED = 5e-5
"""A point further than this from where its triangle has it was moved by hand, in metres."""

REACH = 0.05
"""A point that was moved by hand lies no further from the skin, in metres."""

INSIDE = 0.01
"""A landmark is a corner of its triangle, or at least this share inside it: from one that lies on
an edge, triangles without area would lead on."""

LOOSE = 0.02
"""Where our template lies further from the scans' mean shape, on average, it was not laid on it."""


def find_anatomy(
    estimator: Estimator, vertices: Floats, faces: NDArray[np.int32]
) -> tuple[TemplateMesh, float]:
    """Parts and landmarks of a mean shape, by laying our template on it.

    Parameters
    ----------
    estimator : of our own bodies, of either sex.
    vertices : ndarray of shape (V, 3), metres, +Y up, facing +Z.
    faces : one closed 2-manifold, wound outwards.

    Returns
    -------
    template : without strips; each vertex is its own mirror image.
    distance : how far our template lies from the shape on average, in metres.

    Raises
    ------
    ScanError
        Where our template does not come to lie on it.
    """
    ours, target = estimator.template, Skin(vertices, faces)
    # The matrices are small: threads would wait for one another longer than they work.
    with threadpool_limits(limits=1):
        laid, distance = register(ours, estimator.basis, target, guess(estimator, vertices, faces))
    if distance > LOOSE:
        raise ScanError(
            f"our template lies {distance * 1e3:.0f} mm from the scans' mean shape on average, at "
            f"most {LOOSE * 1e3:.0f} are good: in which pose do the people stand?"
        )
    skin = Skin(laid, ours.faces)
    nearest, _, _ = skin.nearest(vertices[faces].mean(axis=1), target.face_normals)
    names = list(ours.landmarks)
    normals = vertex_normals(laid, ours.faces)
    places = [ours.landmark_weights(name) for name in names]
    points = np.array([weights @ laid[indices] for indices, weights in places])
    facing = np.array([weights @ normals[indices] for indices, weights in places])
    template = TemplateMesh(
        vertices=vertices,
        faces=faces,
        face_parts=whole_parts(faces, ours.face_parts[nearest]),
        part_names=ours.part_names,
        mirror=np.arange(len(vertices), dtype=np.int32),
        landmarks=dict(zip(names, on_skin(target, points, facing), strict=True)),
    )
    return template, distance


def on_skin(skin: Skin, points: Floats, normals: Floats) -> list[Landmark]:
    """Landmarks on the skin nearest to points, (n, 3), that faces as the normals, (n, 3), do."""
    faces, closest, _ = skin.nearest(points, normals)
    weights = trimesh.triangles.points_to_barycentric(skin.triangles[faces], closest)
    corner = weights.max(axis=1, keepdims=True) > 1 - 2 * INSIDE
    weights = np.where(corner, np.round(weights), np.clip(weights, INSIDE, 1))
    weights /= weights.sum(axis=1, keepdims=True)
    rows = zip(faces.tolist(), weights.tolist(), strict=True)
    return [Landmark(face, (a, b, c)) for face, (a, b, c) in rows]


def whole_parts(faces: NDArray[np.int32], parts: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Parts, (F,), each in one piece: what lies apart from its part goes to what is around it."""
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    order = np.lexsort((sides[:, 1], sides[:, 0])).reshape(-1, 2) // 3
    parts = parts.copy()
    for _ in range(10):
        same = parts[order[:, 0]] == parts[order[:, 1]]
        beside = csr_array(
            (np.ones(same.sum()), (order[same, 0], order[same, 1])), shape=(len(faces),) * 2
        )
        _, piece = csgraph.connected_components(beside, directed=False)
        sizes = np.bincount(piece)
        largest = np.zeros(int(parts.max()) + 1, dtype=np.int64)
        np.maximum.at(largest, parts, sizes[piece])
        astray = sizes[piece] < largest[parts]
        if not astray.any():
            break
        one, other = np.concatenate([order, order[:, ::-1]]).T
        rim = astray[one] & ~astray[other]
        votes: Integers = np.zeros((len(sizes), len(largest)), dtype=np.int64)
        np.add.at(votes, (piece[one[rim]], parts[other[rim]]), 1)
        settled = astray & (votes.max(axis=1) > 0)[piece]
        parts[settled] = votes.argmax(axis=1)[piece[settled]]
    return parts


# ---------------------------------------------------------------- the file


def mesh_name(faces: NDArray[np.int32]) -> str:
    """Tells one mesh from another, by its faces, (F, 3)."""
    return hashlib.sha256(faces.astype(np.int32).tobytes()).hexdigest()[:16]


def write_landmarks(template: TemplateMesh, path: Path) -> None:
    """Writes the landmarks of a set, with the points that a person may move."""
    about = json.loads((DATA / LANDMARKS_FILE).read_text(encoding="utf-8"))["landmarks"]
    rows = []
    for name, mark in template.landmarks.items():
        point = template.landmark_points(template.vertices, name)
        row = {
            "point": point.round(5).tolist(),
            "face": mark.face,
            "weights": list(mark.weights),
            "where": about[name]["where"],
        }
        rows.append(f"    {json.dumps(name)}: {json.dumps(row, ensure_ascii=False)}")
    how = (
        "To correct a landmark, change its point (metres, on mean.ply) and run the command again: "
        "it is put on the nearest skin. Face and weights follow from it."
    )
    head = f'{{\n  "how": {json.dumps(how)},\n  "mesh": "{mesh_name(template.faces)}",\n'
    text = head + '  "landmarks": {\n' + ",\n".join(rows) + "\n  }\n}\n"
    path.write_text(text, encoding="utf-8")


@dataclass(frozen=True)
class Corrections:
    """What a landmarks file has, read against the mean shape.

    Attributes
    ----------
    landmarks : by name, those of the file, with what was moved by hand.
    moved : by name, how far in metres.
    """

    landmarks: Mapping[str, Landmark]
    moved: Mapping[str, float]


def read_landmarks(
    path: Path, vertices: Floats, faces: NDArray[np.int32], names: Iterable[str]
) -> Corrections:
    """Reads landmarks, moved by hand or not; some of the names may be missing.

    Parameters
    ----------
    vertices : ndarray of shape (V, 3), metres: the mean shape that the file was written for.
    faces : ndarray of shape (F, 3).
    names : of the landmarks that there are.

    Raises
    ------
    ScanError
        For a file of another mesh, one that cannot be read, a name that no landmark has, or a
        point that is not near the skin; file and line or name are stated.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        mesh, rows = content["mesh"], content["landmarks"]
        given = {name: _row(row) for name, row in rows.items()}
    except json.JSONDecodeError as error:
        raise ScanError(f"{path}, line {error.lineno}: no JSON: {error.msg}") from None
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ScanError(f"{path}: not as this command writes it: {error}") from None
    if mesh != mesh_name(faces):
        raise ScanError(f"{path} belongs to scans of another mesh: remove it, or give --output")
    unknown = given.keys() - set(names)
    if unknown:
        raise ScanError(f"{path}: no landmark is called {min(unknown)!r}")
    skin = Skin(vertices, faces)
    landmarks, moved = dict[str, Landmark](), dict[str, float]()
    for name, (point, mark) in given.items():
        if not 0 <= mark.face < len(faces):
            raise ScanError(f"{path}: {name} lies on face {mark.face}, there are {len(faces)}")
        before = np.array(mark.weights) @ vertices[faces[mark.face]]
        landmarks[name] = mark
        if np.linalg.norm(point - before) > MOVED:
            moved[name] = float(np.linalg.norm(point - before))
            landmarks[name] = _nearest(path, name, skin, point)
    return Corrections(landmarks, moved)


def _row(row: Mapping[str, Any]) -> tuple[Floats, Landmark]:
    point, weights = (np.array(row[key], dtype=np.float64) for key in ("point", "weights"))
    if point.shape != (3,) or weights.shape != (3,):
        raise ValueError("a point and weights are three numbers each")
    if not (np.isfinite(point).all() and np.isfinite(weights).all()):
        raise ValueError("a point and weights are finite")
    return point, Landmark(int(row["face"]), (weights[0], weights[1], weights[2]))


def _nearest(path: Path, name: str, skin: Skin, point: Floats) -> Landmark:
    """The point of skin nearest to one that was moved by hand, whichever way it faces."""
    near = np.unique(skin.around(point))
    away = trimesh.triangles.closest_point(
        skin.triangles[near], np.repeat(point[None], len(near), axis=0)
    )
    face = near[np.linalg.norm(away - point, axis=1).argmin()]
    mark = on_skin(skin, point[None], skin.face_normals[[face]])[0]
    place = np.array(mark.weights) @ skin.triangles[mark.face]
    distance = float(np.linalg.norm(place - point))
    if not distance <= REACH:
        raise ScanError(
            f"{path}: {name} was moved to {point.tolist()}, {distance * 1e3:.0f} mm from the skin; "
            f"at most {REACH * 1e3:.0f} are taken"
        )
    return mark


def read_template(folder: Path, faces: NDArray[np.int32]) -> TemplateMesh | None:
    """The mean shape and parts of an earlier run on the same mesh, if there is one."""
    try:
        with np.load(folder / "template_mesh.npz", allow_pickle=False) as arrays:
            if mesh_name(arrays["faces"]) != mesh_name(faces):
                return None
            return TemplateMesh(
                vertices=arrays["vertices"].astype(np.float64),
                faces=faces,
                face_parts=arrays["face_parts"],
                part_names=tuple(str(name) for name in arrays["part_names"]),
                mirror=arrays["mirror"],
                landmarks={},
            )
    except (OSError, KeyError, ValueError):
        return None
