"""What a GLB file holds, read by the definition of its container and of glTF's accessors.

Reference: *glTF 2.0 Specification*, sections 4.4 and 3.6.2.
"""

import json
import struct

import numpy as np

KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def read(glb):
    """The document, and the binary chunk's bytes."""
    magic, version, length = struct.unpack_from("<4sII", glb)
    assert (magic, version, length) == (b"glTF", 2, len(glb))
    json_length, json_type = struct.unpack_from("<I4s", glb, 12)
    bin_length, bin_type = struct.unpack_from("<I4s", glb, 20 + json_length)
    assert (json_type, bin_type) == (b"JSON", b"BIN\0")
    assert 28 + json_length + bin_length == len(glb)
    return json.loads(glb[20 : 20 + json_length]), glb[28 + json_length :]


def values(document, binary, number):
    """An accessor's numbers, an element a row; floats where they are normalized."""
    accessor = document["accessors"][number]
    view = document["bufferViews"][accessor["bufferView"]]
    kind, width = np.dtype(KINDS[accessor["componentType"]]), WIDTHS[accessor["type"]]
    row = view.get("byteStride", width * kind.itemsize) // kind.itemsize
    array = np.frombuffer(binary, kind, accessor["count"] * row, view["byteOffset"])
    array = array.reshape(-1, row)[:, :width]
    return array / np.iinfo(kind).max if accessor.get("normalized") else array
