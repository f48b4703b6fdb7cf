"""Look at what a mesh file says to hold, before it is read.

Many instances of one mesh, or counts without data, would fill the memory.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from neve.geometry.files.accessors import path_of
from neve.geometry.files.gltf import INSTANCES
from neve.scene.errors import SceneError
from neve.system import disk
from neve.system.memory import lacking

MOST_PIECES = 10_000
"""Pieces of a mesh file with data or a material of their own."""
MOST_INSTANCES = 100_000
"""Places in a mesh file where one of its meshes is shown."""
MOST_FACES = 2**27
"""Triangles of a mesh file, each as often as it is shown."""
READ_BYTES, FACE_BYTES = 16, 300
"""Memory for each byte of a file while it is read, and for each triangle while a surface is made [bytes]."""


def require_modest(path: Path, key: str) -> None:
    """Refuse a mesh file that would take more memory or pieces than it may; `key` names it.

    What is damaged passes: who reads the file finds it. Errors: SceneError; OSError if it cannot be opened.
    """
    suffix = path.suffix.lower()
    with disk.open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        _require_memory(READ_BYTES * size, key)
        if suffix not in (".glb", ".gltf"):
            return
        head = file.read(20)
        text = _json_of_glb(head, file) if head[:4] == b"glTF" else head + file.read()
    try:
        tree = json.loads(text)
        _require_modest_tree(tree, key)
        files = [path_of(path.parent, uri) for uri in _uris(tree)]
    except SceneError:
        raise
    except Exception:  # whatever a damaged file makes us stumble over
        return
    for other in files:
        if other.exists():  # who reads the file says what is missing
            disk.open_regular(other).close()


def _json_of_glb(head: bytes, file: Any) -> bytes:
    """Return the first chunk of a binary file (Khronos glTF 2.0, section 4.4); nothing if there is none."""
    if len(head) < 20:
        return b""
    (length,) = struct.unpack_from("<I", head, 12)
    return bytes(file.read(length))


def _uris(tree: dict[str, Any]) -> Iterator[str]:
    for buffer in tree.get("buffers", []):
        if not (uri := buffer.get("uri", "data:")).startswith("data:"):
            yield uri


def _require_modest_tree(tree: dict[str, Any], key: str) -> None:
    """Refuse a scene graph by its counts (Khronos glTF 2.0, sections 3.5 to 3.7)."""
    accessors, meshes = tree.get("accessors", []), tree.get("meshes", [])
    without_data = [a for a in accessors if "bufferView" not in a or "sparse" in a]
    _require_memory(64.0 * sum(max(int(a.get("count", 0)), 0) for a in without_data), key)
    _require_few(sum(len(mesh["primitives"]) for mesh in meshes), "pieces", key)
    shown = [(node["mesh"], _times(node, accessors)) for node in tree.get("nodes", []) if "mesh" in node]
    _require_few(sum(times for _, times in shown), "instances of meshes", key, MOST_INSTANCES)
    faces = [sum(_faces(primitive, accessors) for primitive in mesh["primitives"]) for mesh in meshes]
    total = sum(faces[i] * times for i, times in shown)
    if total > MOST_FACES:
        raise SceneError(
            f"{key} has {total:,} triangles, each as often as it is shown, more than {MOST_FACES:,}"
        )
    _require_memory(FACE_BYTES * total, key)


def _times(node: dict[str, Any], accessors: list[Any]) -> int:
    """Return how often a node shows its mesh."""
    named = node.get("extensions", {}).get(INSTANCES, {}).get("attributes", {})
    return max((int(accessors[index].get("count", 0)) for index in named.values()), default=1)


def _faces(primitive: dict[str, Any], accessors: list[Any]) -> int:
    index = primitive.get("indices", primitive["attributes"].get("POSITION"))
    corners = max(int(accessors[index].get("count", 0)), 0)
    return corners if primitive.get("mode") in (5, 6) else corners // 3  # strips and fans share corners


def _require_few(count: int, what: str, key: str, most: int = MOST_PIECES) -> None:
    if count > most:
        raise SceneError(f"{key} has {count:,} {what}, more than {most:,}: join them")


def _require_memory(size: float, key: str) -> None:
    if found := lacking(size):
        raise SceneError(f"{key} {found}: use a smaller mesh")
