"""A body as a glTF 2.0 binary: metres, +Y up, facing +Z, two materials on one set of points.

Positions are floats, which every reader knows, rounded to what can be seen: their last bits are
zeros, and a server that compresses sends half as much. Normals of a file with a rig or with morph
targets take four bytes each and morph targets are whole numbers, by KHR_mesh_quantization: so it
stays under 600 kB, and with a target for each of 41 values under 1.5 MB as it travels.

Each point stands beside its mirror image: a body is symmetric, and compressors find again what
they have just seen.

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
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from model.anthropometry import TAKEN
from model.appearance import (
    GARMENT_COLOUR,
    SKIN_COLOUR,
    dress,
    dressed_moves,
    garment_cut,
    linear,
)
from model.geometry import Floats, Integers
from model.measurements import MEASUREMENTS, BodyKind, MeasurementSet
from model.morph_targets import MorphTargets
from model.rig import Rig, strongest
from model.template_mesh import Body, TemplateMesh

GENERATOR = "The Fitting Room"

_MAGIC, _VERSION = b"glTF", 2
_HEADER = struct.Struct("<4sII")
_CHUNK = struct.Struct("<I4s")

_BYTE, _UNSIGNED_BYTE, _SHORT, _UNSIGNED_SHORT, _UNSIGNED_INT = 5120, 5121, 5122, 5123, 5125
_FLOAT = 5126
_VERTICES, _INDICES = 34962, 34963
_TRIANGLES = 4

_QUANTIZED = ["KHR_mesh_quantization"]

# What positions, in metres, and normals are rounded to: powers of two, so that floats hold them.
_POSITION_GRAIN, _NORMAL_GRAIN = 2.0**-16, 2.0**-9

_DIGITS = 6
"""Significant ones of numbers in the extras."""

# 65,535 restarts a primitive, so that a point may not have that number.
_MOST_SHORT_POINTS = 65535


def to_glb(
    body: Body,
    extras: Mapping[str, object] | None = None,
    *,
    measured: MeasurementSet | None = None,
    morphs: MorphTargets | None = None,
    rig: Rig | None = None,
) -> bytes:
    """The body in its plain underwear as the bytes of a `.glb` file.

    Parameters
    ----------
    body : Body
    extras : mapping, optional
        What the file says of itself (`asset.extras`): anything that JSON can hold.
    morphs : MorphTargets, optional
        The body's live preview, as the mesh's morph targets; see `live_extras`.
    measured : MeasurementSet, optional
        What the body measures: told beside how that changes with the targets.
    rig : Rig, optional
        The skeleton of the body's template: the file can be posed then. Its bones are VRM's
        humanoid ones. Morph targets are for the body as it stands, and take no rig.

    Raises
    ------
    ValueError
        If the extras hold a number that JSON has no word for (infinity, not-a-number), or if both
        a rig and morph targets are given: the joints would stay where the body was.
    """
    if rig is not None and morphs is not None:
        raise ValueError("a file has a rig or morph targets, not both")
    dressed = dress(body)
    order = mirrored_order(body.template, body.kind)
    places = np.argsort(order)
    positions = _rounded(dressed.positions[order], _POSITION_GRAIN)
    short = len(positions) <= _MOST_SHORT_POINTS
    indices = [
        places[faces].astype(np.uint16 if short else np.uint32)
        for faces in (dressed.skin, dressed.garment)
        if len(faces)
    ]
    small = rig is not None or morphs is not None
    binary = _Binary()
    attributes = {
        "POSITION": binary.add(positions, _FLOAT, "VEC3", _VERTICES, bounds=True),
        "NORMAL": _add_normals(dressed.normals[order], binary, small=small),
    }
    if rig is not None:
        joints, weights = _influences(rig, body.template, body.kind)
        attributes["JOINTS_0"] = binary.add(joints[order], _UNSIGNED_BYTE, "VEC4", _VERTICES)
        attributes["WEIGHTS_0"] = binary.add(
            weights[order], _UNSIGNED_BYTE, "VEC4", _VERTICES, normalized=True
        )
    mesh: dict[str, object] = {"name": "Avatar"}
    targets = []
    if morphs is not None:
        targets = _targets(body, morphs, binary)
        soles = np.sort(places[morphs.soles])
        mesh |= {
            "weights": [0.0] * len(targets),
            "extras": live_extras(replace(morphs, soles=soles), measured or MeasurementSet({})),
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
    mesh["primitives"] = [
        {
            "attributes": attributes,
            "indices": binary.add(faces.ravel(), component, "SCALAR", _INDICES),
            "material": material,
            "mode": _TRIANGLES,
            **({"targets": targets} if targets else {}),
        }
        for material, faces in enumerate(indices)
    ]
    asset: dict[str, object] = {"version": "2.0", "generator": GENERATOR}
    if extras:
        asset["extras"] = dict(extras)
    document: dict[str, object] = {
        "asset": asset,
        "scene": 0,
        "scenes": [{"name": "Avatar", "nodes": [0]}],
        "nodes": [{"name": "Avatar", "mesh": 0}],
        "meshes": [mesh],
        "materials": materials,
        "accessors": binary.accessors,
        "bufferViews": binary.views,
    }
    if small:
        document |= {"extensionsUsed": _QUANTIZED, "extensionsRequired": _QUANTIZED}
    if rig is not None:
        document |= _skeleton(body, rig, binary)
    document["buffers"] = [{"byteLength": len(binary.data)}]
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    return _container(text, bytes(binary.data))


def live_extras(morphs: MorphTargets, measured: MeasurementSet) -> dict[str, object]:
    """What the mesh says of its morph targets (`mesh.extras`), SI units throughout.

    - `targetNames`: the entered measurements, a target each.
    - `targets`: of each its `name`, `unit`, `value` on this body and `step`: a value x is shown by
      the weight (x - value) / step.
    - `soles`: the vertices of which one may come to be the lowest. As much as the lowest of them
      then lies above or below the floor, the body is to be moved down or up.
    - `measurements`: of each measurement of the table its `name`, `unit`, `value` on this body and
      `slopes`, one for each target: it becomes value + Σ slope · (x - target's value).
    """
    return {
        "targetNames": list(morphs.names),
        "targets": [
            {
                "name": name,
                "unit": MEASUREMENTS[name].unit,
                "value": _number(value),
                "step": _number(step),
            }
            for name, value, step in zip(morphs.names, morphs.values, morphs.steps, strict=True)
        ],
        "soles": morphs.soles.tolist(),
        "measurements": [
            {
                "name": name,
                "unit": MEASUREMENTS[name].unit,
                "value": _number(measured[name]),
                "slopes": [_number(slope) for slope in slopes],
            }
            for name, slopes in zip(TAKEN, morphs.slopes, strict=True)
            if name in measured
        ],
    }


def _targets(body: Body, morphs: MorphTargets, binary: _Binary) -> list[dict[str, int]]:
    """The morph targets, with normals: without them light would stay as on the unchanged body.

    Parts of a metre, and of a normal's length. Rounding errors of many targets add up, but they
    weigh too: of few, points move in steps of 0.06 mm, of 41 in steps of 0.18 mm, for a tenth of
    each value.
    """
    order = mirrored_order(body.template, body.kind)
    positions, normals = dressed_moves(body, morphs.moves)
    count = len(morphs.names)
    return [
        {
            "POSITION": _add_whole(moves[order], binary, np.int16, 2 + count // 10),
            "NORMAL": _add_whole(turns[order], binary, np.int8, 2 + count // 4),
        }
        for moves, turns in zip(positions, normals, strict=True)
    ]


def _add_normals(normals: Floats, binary: _Binary, *, small: bool) -> int:
    """Normals as floats, or in four bytes each."""
    if small:
        return _add_whole(normals, binary, np.int8, 1)
    return binary.add(_rounded(normals, _NORMAL_GRAIN), _FLOAT, "VEC3", _VERTICES)


def _add_whole(values: Floats, binary: _Binary, kind: type[np.int8 | np.int16], grain: int) -> int:
    """Values from -1 to 1 as multiples of so many parts of 127 or of 32,767; beyond, cut off."""
    most = np.iinfo(kind).max
    whole = np.clip(np.round(values * (most / grain)) * grain, -most, most).astype(kind)
    component, stride = (_BYTE, 4) if kind is np.int8 else (_SHORT, 8)
    bounds = kind is np.int16
    return binary.add(
        whole, component, "VEC3", _VERTICES, bounds=bounds, normalized=True, stride=stride
    )


@lru_cache(maxsize=8)
def mirrored_order(template: TemplateMesh, kind: BodyKind) -> Integers:
    """Which point of a dressed body stands where in the file, beside its mirror image: (N,)."""
    cut, count = garment_cut(template, kind), len(template.vertices)
    edges, mirrored = (
        np.sort(ends.astype(np.int64), axis=1) @ (count, 1)
        for ends in (cut.ends, template.mirror[cut.ends])
    )
    by_edge = edges.argsort()
    found = by_edge[np.searchsorted(edges[by_edge], mirrored).clip(max=max(len(edges) - 1, 0))]
    alone = np.arange(len(edges))
    images = np.r_[template.mirror, count + np.where(edges[found] == mirrored, found, alone)]
    points = np.arange(len(images))
    return np.lexsort((points, np.minimum(points, images)))


@lru_cache(maxsize=8)
def _influences(
    rig: Rig, template: TemplateMesh, kind: BodyKind
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """The bones that each point follows and how much, those along the garment's edge too."""
    return strongest(garment_cut(template, kind).extend(rig.dense_weights))


def _skeleton(body: Body, rig: Rig, binary: _Binary) -> dict[str, object]:
    """The members of the document that a rig adds or changes."""
    places = rig.places(body.vertices)
    from_parent = places.copy()
    from_parent[1:] -= places[rig.parents[1:]]
    binds = np.tile(np.eye(4), (len(places), 1, 1))
    binds[:, 3, :3] = -places  # column by column, as the format has it
    # Nodes: the avatar, then the bones.
    bones: list[dict[str, object]] = []
    for bone, name in enumerate(rig.names):
        node: dict[str, object] = {
            "name": name,
            "translation": [round(float(x), 5) for x in from_parent[bone]],
        }
        if (children := np.flatnonzero(rig.parents == bone)).size:
            node["children"] = (children + 1).tolist()
        bones.append(node)
    skin = {
        "name": "Avatar",
        "joints": list(range(1, len(bones) + 1)),
        "skeleton": 1,
        "inverseBindMatrices": binary.add(
            binds.reshape(-1, 16).astype(np.float32), _FLOAT, "MAT4", None
        ),
    }
    return {
        "scenes": [{"name": "Avatar", "nodes": [0, 1]}],
        "nodes": [{"name": "Avatar", "mesh": 0, "skin": 0}, *bones],
        "skins": [skin],
    }


def _rounded(values: Floats, grain: float) -> NDArray[np.float32]:
    """Values as multiples of a grain; a zero has no sign, so that all zeros are alike."""
    return (np.round(values / grain) * grain + 0.0).astype(np.float32)


def _number(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


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
        target: int | None,
        *,
        bounds: bool = False,
        normalized: bool = False,
        stride: int = 0,
    ) -> int:
        """Append an array, (n,) or (n, k); returns the number of its accessor."""
        rows = values
        if stride:
            rows = np.zeros((len(values), stride // values.itemsize), dtype=values.dtype)
            rows[:, : values.shape[1]] = values
        content = np.ascontiguousarray(rows).tobytes()
        view: dict[str, object] = {
            "buffer": 0,
            "byteOffset": len(self.data),
            "byteLength": len(content),
        }
        if stride:
            view["byteStride"] = stride
        if target:
            view["target"] = target
        self.views.append(view)
        accessor: dict[str, object] = {
            "bufferView": len(self.views) - 1,
            "componentType": component,
            "count": len(values),
            "type": kind,
        }
        if normalized:
            accessor["normalized"] = True
        if bounds:
            # As the file's numbers say them: rounded from it, they would lie beside the points.
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
