"""A drum in every format of meshes that Neve reads, in the plain ways and in odder ones: what is damaged."""

from __future__ import annotations

import base64
import json
import math
import struct
from typing import Any

import numpy as np

SIDES = 12
"""Corners around the drum: it has 2 polygons of so many corners, and a quad on each edge of them."""
CORNERS = np.array(
    [
        [0.5 * math.cos(turn), 0.5 * math.sin(turn), z]
        for z in (-0.4, 0.4)
        for turn in (2.0 * math.pi * np.arange(SIDES) / SIDES).tolist()
    ]
)
QUADS = [[k, (k + 1) % SIDES, SIDES + (k + 1) % SIDES, SIDES + k] for k in range(SIDES)]
POLYGONS = [list(range(SIDES))[::-1], list(range(SIDES, 2 * SIDES)), *QUADS]
TRIANGLES = np.array([[p[0], p[k], p[k + 1]] for p in POLYGONS for k in range(1, len(p) - 1)])


def solids() -> dict[str, tuple[bytes, ...]]:
    """Return whole files of the drum by what they end in."""
    text = {
        "format ascii 1.0": "",
        "format binary_little_endian 1.0": "<",
        "format binary_big_endian 1.0": ">",
    }
    return {
        "obj": (_obj(), _obj_counting_back()),
        "ply": tuple(_ply(kind, order) for kind, order in text.items()),
        "stl": (_stl(), _stl_text()),
        "glb": (_glb(),),
        "gltf": (json.dumps(_tree(_embedded(_data()))).encode(),),
    }


def _obj() -> bytes:
    rows = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in CORNERS.tolist()]
    faces = ["f " + " ".join(f"{i + 1}/1/1" for i in polygon) for polygon in POLYGONS]
    return "\n".join(["# a drum", "o drum", "vt 0 0", "vn 0 0 1", *rows, *faces, ""]).encode()


def _obj_counting_back() -> bytes:
    """Return the drum with the corners of each face above it, in UTF-16 and with tabs and colours."""
    lines = []
    for polygon in POLYGONS:
        lines += [f"v\t{x:.6g}\t{y:.6g}\t{z:.6g}\t1 1 1" for x, y, z in CORNERS[polygon].tolist()]
        lines.append("f " + " ".join(f"{k - len(polygon)}" for k in range(len(polygon))) + " # a face")
    return "\r\n".join(lines).encode("utf-16")


def _ply(kind: str, order: str) -> bytes:
    head = [
        "ply", kind, f"element vertex {len(CORNERS)}", *(f"property float {axis}" for axis in "xyz"),
        f"element face {len(POLYGONS)}", "property list uchar int vertex_indices", "property uchar flags",
        "end_header\n",
    ]  # fmt: skip
    if order:
        body = CORNERS.astype(order + "f4").tobytes()
        for polygon in POLYGONS:
            body += bytes([len(polygon)]) + np.array(polygon, order + "i4").tobytes() + b"\1"
    else:
        rows = [" ".join(f"{x:.6g}" for x in row) for row in CORNERS.tolist()]
        rows += [" ".join(map(str, (len(polygon), *polygon, 1))) for polygon in POLYGONS]
        body = "\n".join([*rows, ""]).encode()
    return "\n".join(head).encode() + body


def _stl() -> bytes:
    records = b"".join(struct.pack("<12fH", 0, 0, 0, *CORNERS[face].ravel(), 0) for face in TRIANGLES)
    return b"a drum".ljust(80) + struct.pack("<I", len(TRIANGLES)) + records


def _stl_text() -> bytes:
    lines = ["solid drum"]
    for face in TRIANGLES:
        corners = [f"vertex {x:.6g} {y:.6g} {z:.6g}" for x, y, z in CORNERS[face].tolist()]
        lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid drum", ""]).encode()


def _data() -> bytes:
    """Return the corners as normalised whole numbers, the triangles, and one corner that is replaced."""
    whole = np.zeros((len(CORNERS), 4), "<i2")
    whole[:, :3] = np.rint(CORNERS * 2 * 32767)
    last = np.array([len(CORNERS) - 1], "<u2").tobytes() + b"\0\0"
    return bytes(whole.tobytes() + TRIANGLES.astype("<u2").tobytes() + last + whole[-1].tobytes())


def _tree(buffer: dict[str, Any]) -> dict[str, Any]:
    """Return the tree of a glTF file: a node that shows the drum, and one below it, turned and mirrored."""
    points, faces = 8 * len(CORNERS), 6 * len(TRIANGLES)
    replaced = {
        "count": 1,
        "indices": {"bufferView": 2, "componentType": 5123},
        "values": {"bufferView": 2, "byteOffset": 4},
    }
    return {
        "asset": {"version": "2.0"},
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"mesh": 0, "scale": [0.5, 0.5, 0.5], "children": [1]},
            {"mesh": 0, "translation": [3, 0, 0], "rotation": [0, 0, 0.6, 0.8], "scale": [-1, 1, 1]},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5122, "normalized": True, "count": len(CORNERS),
                "type": "VEC3", "sparse": replaced,
            },
            {"bufferView": 1, "componentType": 5123, "count": 3 * len(TRIANGLES), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points, "byteStride": 8},
            {"buffer": 0, "byteOffset": points, "byteLength": faces},
            {"buffer": 0, "byteOffset": points + faces, "byteLength": 12},
        ],
        "buffers": [buffer],
    }  # fmt: skip


def _embedded(data: bytes) -> dict[str, Any]:
    uri = f"data:application/octet-stream;base64,{base64.b64encode(data).decode()}"
    return {"byteLength": len(data), "uri": uri}


def _glb() -> bytes:
    data = _data()
    text = json.dumps(_tree({"byteLength": len(data)})).encode()
    text, data = text + b" " * (-len(text) % 4), data + b"\0" * (-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
