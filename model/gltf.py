"""A body as a glTF 2.0 binary: metres, +Y up, facing +Z, two materials on one set of points.

The container is written here, and not by trimesh's exporter, because that makes one mesh of each
material with its own copy of the points, and has no place for the asset's extras.

References
----------
Khronos Group, "glTF 2.0 Specification", sections 3 and 4 (the binary container).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from model.appearance import GARMENT_COLOUR, SKIN_COLOUR, dress, linear
from model.template_mesh import Body

GENERATOR = "The Fitting Room"

_MAGIC, _VERSION = b"glTF", 2
_HEADER = struct.Struct("<4sII")
_CHUNK = struct.Struct("<I4s")

_UNSIGNED_SHORT, _UNSIGNED_INT, _FLOAT = 5123, 5125, 5126
_VERTICES, _INDICES = 34962, 34963
_TRIANGLES = 4

# 65,535 restarts a primitive, so that a point may not have that number.
_MOST_SHORT_POINTS = 65535


def to_glb(body: Body, extras: Mapping[str, object] | None = None) -> bytes:
    """The body in its plain underwear as the bytes of a `.glb` file.

    Parameters
    ----------
    body : Body
    extras : mapping, optional
        What the file says of itself (`asset.extras`): anything that JSON can hold.

    Raises
    ------
    ValueError
        If the extras hold a number that JSON has no word for (infinity, not-a-number).
    """
    dressed = dress(body)
    positions = dressed.positions.astype(np.float32)
    short = len(positions) <= _MOST_SHORT_POINTS
    indices = [
        faces.astype(np.uint16 if short else np.uint32)
        for faces in (dressed.skin, dressed.garment)
        if len(faces)
    ]
    binary = _Binary()
    attributes = {
        "POSITION": binary.add(positions, _FLOAT, "VEC3", _VERTICES, bounds=True),
        "NORMAL": binary.add(dressed.normals.astype(np.float32), _FLOAT, "VEC3", _VERTICES),
    }
    materials = [
        _material(name, colour)
        for name, colour, faces in (
            ("Skin", SKIN_COLOUR, dressed.skin),
            ("Garment", GARMENT_COLOUR, dressed.garment),
        )
        if len(faces)
    ]
    component = _UNSIGNED_SHORT if short else _UNSIGNED_INT
    primitives = [
        {
            "attributes": attributes,
            "indices": binary.add(faces.ravel(), component, "SCALAR", _INDICES),
            "material": material,
            "mode": _TRIANGLES,
        }
        for material, faces in enumerate(indices)
    ]
    asset: dict[str, object] = {"version": "2.0", "generator": GENERATOR}
    if extras:
        asset["extras"] = dict(extras)
    document = {
        "asset": asset,
        "scene": 0,
        "scenes": [{"name": "Avatar", "nodes": [0]}],
        "nodes": [{"name": "Avatar", "mesh": 0}],
        "meshes": [{"name": "Avatar", "primitives": primitives}],
        "materials": materials,
        "accessors": binary.accessors,
        "bufferViews": binary.views,
        "buffers": [{"byteLength": len(binary.data)}],
    }
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    return _container(text, bytes(binary.data))


class _Binary:
    """The buffer as it grows, with the views and accessors that say what lies where."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, object]] = []
        self.accessors: list[dict[str, object]] = []

    def add(
        self,
        values: NDArray[np.generic],
        component: int,
        kind: str,
        target: int,
        *,
        bounds: bool = False,
    ) -> int:
        """Append an array, (n,) or (n, 3); returns the number of its accessor."""
        content = np.ascontiguousarray(values).tobytes()
        self.views.append(
            {
                "buffer": 0,
                "byteOffset": len(self.data),
                "byteLength": len(content),
                "target": target,
            }
        )
        accessor: dict[str, object] = {
            "bufferView": len(self.views) - 1,
            "componentType": component,
            "count": len(values),
            "type": kind,
        }
        if bounds:
            # As the file's float32 says them: rounded from it, they would lie beside the points.
            accessor["min"] = values.min(axis=0).tolist()
            accessor["max"] = values.max(axis=0).tolist()
        self.accessors.append(accessor)
        self.data += _padded(content, b"\0")
        return len(self.accessors) - 1


def _material(name: str, colour: tuple[float, float, float]) -> dict[str, object]:
    red, green, blue = (round(float(light), 4) for light in linear(colour))
    return {
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 0.8,
        },
    }


def _container(text: bytes, data: bytes) -> bytes:
    chunks = [(b"JSON", _padded(text, b" ")), (b"BIN\0", _padded(data, b"\0"))]
    body = b"".join(_CHUNK.pack(len(content), name) + content for name, content in chunks)
    return _HEADER.pack(_MAGIC, _VERSION, _HEADER.size + len(body)) + body


def _padded(content: bytes, filler: bytes) -> bytes:
    """The content, filled up to a multiple of four bytes."""
    return content + filler * (-len(content) % 4)
