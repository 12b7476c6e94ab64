"""Files of scans: triangle meshes as OBJ or PLY, read strictly; errors name file and line.

References: Wavefront, *Object Files (.obj)*, of which ``v`` and ``f`` lines count; Turk 1994,
*The PLY Polygon File Format*, in text and binary.
"""

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from model.geometry import Floats

Number = TypeVar("Number", np.float64, np.int32)

SUFFIXES = (".obj", ".ply")


class ScanError(ValueError):
    """Something is wrong with a scan or a set of them; the message names the file."""


@dataclass(frozen=True, eq=False)
class ScanMesh:
    """What a file holds.

    Attributes
    ----------
    vertices : ndarray of shape (V, 3), in the file's unit and axes.
    faces : ndarray of shape (F, 3), int32.
    """

    vertices: Floats
    faces: NDArray[np.int32]


def read_scan(name: str, content: bytes) -> ScanMesh:
    """Reads one mesh.

    Parameters
    ----------
    name : the file's, for messages; its suffix says the format.
    content : what is in it.

    Raises
    ------
    ScanError
        For anything but a mesh of triangles with finite coordinates.
    """
    mesh = _read_ply(name, content) if name.lower().endswith(".ply") else _read_obj(name, content)
    if not len(mesh.vertices) or not len(mesh.faces):
        raise ScanError(
            f"{name}: no mesh, {len(mesh.vertices)} vertices and {len(mesh.faces)} faces"
        )
    outside = (mesh.faces < 0) | (mesh.faces >= len(mesh.vertices))
    if outside.any():
        face, corner = np.argwhere(outside)[0].tolist()
        raise ScanError(
            f"{name}: face {face + 1} has the vertex {mesh.faces[face, corner]}, counted from 0, "
            f"and there are {len(mesh.vertices)}"
        )
    return mesh


# ---------------------------------------------------------------- OBJ


_POINT = re.compile(rb"^v[ \t]+(\S+[ \t]+\S+[ \t]+\S+)[ \t\r]*$", re.M)
_FACE = re.compile(rb"^f[ \t]+(\d+[ \t]+\d+[ \t]+\d+)[ \t\r]*$", re.M)
_EITHER = re.compile(rb"^[vf][ \t]", re.M)


def _read_obj(name: str, content: bytes) -> ScanMesh:
    """As quickly as most files allow; what is written otherwise, or wrong, line by line."""
    points, faces = _POINT.findall(content), _FACE.findall(content)
    plain = len(points) + len(faces) == len(_EITHER.findall(content))
    vertices = _numbers(b" ".join(points), np.float64)
    corners = _corners(b" ".join(faces))
    if not plain or vertices.size != 3 * len(points) or not np.isfinite(vertices).all():
        return _read_obj_lines(name, content)
    if not corners.size or corners.min() < 1 or corners.max() > len(points):
        return _read_obj_lines(name, content)
    return ScanMesh(vertices.reshape(-1, 3), corners.reshape(-1, 3) - 1)


@lru_cache(maxsize=1)
def _corners(text: bytes) -> NDArray[np.int32]:
    """The corners of all faces, in one row, counted from 1: the same in each file of a set."""
    return _numbers(text, np.int32)


def _numbers(text: bytes, kind: type[Number]) -> NDArray[Number]:
    """All numbers of a text in one row; none where one of them cannot be read."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)
            return np.fromstring(text, dtype=kind, sep=" ")
    except (ValueError, DeprecationWarning):
        return np.empty(0, kind)


def _read_obj_lines(name: str, content: bytes) -> ScanMesh:
    lines = content.splitlines()
    points = [i for i, line in enumerate(lines) if line[:2] in (b"v ", b"v\t")]
    faces = [i for i, line in enumerate(lines) if line[:2] in (b"f ", b"f\t")]
    vertices = _obj_vertices(name, lines, points)
    table = np.array(
        [_obj_face(name, i + 1, lines[i].split()[1:]) for i in faces], dtype=np.int64
    ).reshape(-1, 3)
    # Negative indices count back from the vertices read so far.
    before = np.searchsorted(points, faces)[:, None]
    indices = np.where(table < 0, before + table, table - 1)
    wrong = np.flatnonzero(((indices < 0) | (indices >= len(vertices))).any(axis=1))
    if len(wrong):
        line = faces[wrong[0]]
        raise ScanError(
            f"{name}, line {line + 1}: there are {len(vertices)} vertices, this face has "
            f"{lines[line].decode(errors='replace').strip()!r}"
        )
    return ScanMesh(vertices, indices.astype(np.int32))


def _obj_vertices(name: str, lines: list[bytes], points: list[int]) -> Floats:
    """The coordinates of ``v`` lines, (V, 3); a colour or a weight may follow them."""
    rows = [_finite(f"{name}, line {i + 1}", lines[i].split()[1:4]) for i in points]
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _obj_face(name: str, line: int, corners: list[bytes]) -> list[int]:
    if len(corners) != 3:
        raise ScanError(f"{name}, line {line}: a face of {len(corners)} corners, not a triangle")
    try:
        return [int(corner.split(b"/")[0]) for corner in corners]
    except ValueError:
        said = b" ".join(corners).decode(errors="replace")
        raise ScanError(f"{name}, line {line}: no face: {said!r}") from None


def _finite(place: str, words: list[bytes]) -> list[float]:
    """Three finite numbers, or an error that says where they should be."""
    said = b" ".join(words).decode(errors="replace")
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        raise ScanError(f"{place}: not a number: {said!r}") from None
    if len(numbers) != 3:
        raise ScanError(f"{place}: {len(numbers)} coordinates, not 3: {said!r}")
    if not np.isfinite(numbers).all():
        raise ScanError(f"{place}: not finite: {said!r}")
    return numbers


# ---------------------------------------------------------------- PLY

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip


@dataclass(frozen=True)
class _Element:
    """An element of a PLY file: its name, count and properties (name, count's type, type)."""

    name: str
    count: int
    properties: list[tuple[str, str, str]]

    def dtype(self, order: str) -> np.dtype[np.void]:
        """A row in the file, each list taken for one of three."""
        fields: list[tuple[str, str] | tuple[str, str, int]] = []
        for name, counted, kind in self.properties:
            if counted:
                fields += [(f"{name} count", order + counted), (name, order + kind, 3)]
            else:
                fields.append((name, order + kind))
        return np.dtype(fields)


def _read_ply(name: str, content: bytes) -> ScanMesh:
    form, elements, start, line = _ply_header(name, content)
    named = {element.name: element for element in elements}
    for wanted in ("vertex", "face"):
        if wanted not in named:
            raise ScanError(f"{name}: the header has no element {wanted!r}")
    own = [prop[0] for prop in named["vertex"].properties]
    if not {"x", "y", "z"} <= set(own):
        raise ScanError(f"{name}: vertices have no x, y and z, only {', '.join(own)}")
    corners = next((prop[0] for prop in named["face"].properties if prop[1]), "")
    if not corners:
        raise ScanError(f"{name}: faces have no list of vertices")
    if form == "ascii":
        rows = _ply_text(name, content[start:], elements, line)
    else:
        rows = _ply_binary(name, content[start:], elements, "<" if "little" in form else ">")
    tables = dict(rows)
    vertices = np.stack([tables["vertex"][axis] for axis in "xyz"], axis=1).astype(np.float64)
    wrong = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(wrong):
        raise ScanError(f"{name}: vertex {wrong[0] + 1} is not finite: {vertices[wrong[0]]}")
    return ScanMesh(vertices, tables["face"][corners].astype(np.int32))


def _ply_header(name: str, content: bytes) -> tuple[str, list[_Element], int, int]:
    """The format, the elements, where the data begin, and on which line."""
    end = content.find(b"end_header")
    stop = content.find(b"\n", end) + 1
    if not content.startswith(b"ply") or end < 0 or not stop:
        raise ScanError(f"{name}: not a PLY file, or its header is cut off")
    form, elements = "", list[_Element]()
    header = content[:stop].decode("latin-1").splitlines()
    for number, said in enumerate(header, 1):
        words = said.split()
        try:
            if words[:1] == ["format"]:
                form = words[1]
            elif words[:1] == ["element"]:
                elements.append(_Element(words[1], int(words[2]), []))
            elif words[:2] == ["property", "list"]:
                elements[-1].properties.append((words[4], _TYPES[words[2]], _TYPES[words[3]]))
            elif words[:1] == ["property"]:
                elements[-1].properties.append((words[2], "", _TYPES[words[1]]))
        except (IndexError, KeyError, ValueError):
            raise ScanError(f"{name}, line {number}: cannot be read: {said!r}") from None
    if form not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ScanError(f"{name}: unknown PLY format {form!r}")
    return form, elements, stop, len(header)


def _ply_binary(
    name: str, data: bytes, elements: list[_Element], order: str
) -> Iterator[tuple[str, NDArray[np.void]]]:
    place = 0
    for element in elements:
        kind = element.dtype(order)
        whole = min(element.count, (len(data) - place) // kind.itemsize)
        rows = np.frombuffer(data, kind, whole, place)
        _only_triangles(name, element, rows)
        if whole < element.count:
            raise ScanError(
                f"{name}: cut off after {whole} of {element.count} elements {element.name!r}"
            )
        place += whole * kind.itemsize
        yield element.name, rows


def _only_triangles(name: str, element: _Element, rows: NDArray[np.void]) -> None:
    for listed in (prop[0] for prop in element.properties if prop[1]):
        other = np.flatnonzero(rows[f"{listed} count"] != 3)
        if len(other):
            count = rows[f"{listed} count"][other[0]]
            raise ScanError(
                f"{name}: {element.name} {other[0] + 1} has {count} corners, not a triangle"
            )


def _ply_text(
    name: str, data: bytes, elements: list[_Element], line: int
) -> Iterator[tuple[str, NDArray[np.void]]]:
    lines = data.splitlines()
    for element in elements:
        own = lines[: element.count]
        if len(own) < element.count:
            raise ScanError(
                f"{name}: cut off at line {line + len(own)}, after {len(own)} of "
                f"{element.count} elements {element.name!r}"
            )
        kind = np.dtype([(k[0], k[1].replace("<", "")) if len(k) == 2 else k
                         for k in element.dtype("<").descr])  # fmt: skip
        yield element.name, _text_rows(name, element, own, line, kind)
        lines = lines[element.count :]
        line += element.count


def _text_rows(
    name: str, element: _Element, lines: list[bytes], line: int, kind: np.dtype[np.void]
) -> NDArray[np.void]:
    rows = np.zeros(len(lines), dtype=kind)
    width = sum(3 + 1 if counted else 1 for _, counted, _ in element.properties)
    try:
        table = np.array([said.split() for said in lines], dtype=np.bytes_)
        numbers = table.astype(np.float64).reshape(-1, width)
    except ValueError:
        numbers = np.array(
            [
                _text_row(f"{name}, line {line + i}", element, said)
                for i, said in enumerate(lines, 1)
            ]
        )
    column = 0
    for prop, counted, _ in element.properties:
        if counted:
            rows[f"{prop} count"] = numbers[:, column]
            rows[prop] = numbers[:, column + 1 : column + 4]
            column += 4
        else:
            rows[prop] = numbers[:, column]
            column += 1
    if element.name == "vertex":
        wrong = np.flatnonzero(~np.isfinite(numbers).all(axis=1))
        if len(wrong):
            said = lines[wrong[0]].decode(errors="replace")
            raise ScanError(f"{name}, line {line + wrong[0] + 1}: not finite: {said!r}")
    other = np.flatnonzero(
        np.any([rows[f"{p} count"] != 3 for p, counted, _ in element.properties if counted], axis=0)
    )
    if len(other):
        raise ScanError(f"{name}, line {line + other[0] + 1}: not a triangle")
    return rows


def _text_row(place: str, element: _Element, said: bytes) -> list[float]:
    """The numbers of one line, or an error that says what is wrong with it."""
    words = said.split()
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        raise ScanError(f"{place}: not a number: {said.decode(errors='replace')!r}") from None
    at = 0
    for _, counted, _ in element.properties:
        if counted and at < len(numbers) and numbers[at] != 3:
            raise ScanError(f"{place}: a {element.name} of {numbers[at]:.0f} corners, no triangle")
        at += 4 if counted else 1
    if at != len(numbers):
        raise ScanError(f"{place}: {len(numbers)} numbers, expected {at}")
    return numbers
