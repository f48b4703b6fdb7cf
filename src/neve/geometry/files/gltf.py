"""Read glTF 2.0 files, text (.gltf) and binary (.glb): every mesh where the nodes of the scene put it.

Source: Khronos glTF 2.0, sections 3.5 (scenes), 3.7 (meshes, skins) and 4.4 (GLB); EXT_mesh_gpu_instancing;
KHR_mesh_quantization.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.files.accessors import Accessors, item, refuse_compressed, whole
from neve.geometry.files.polygons import of_strip
from neve.geometry.files.wording import Array, Faces, Surface, Unreadable, require_corners
from neve.reproducible import determinant, product

READ = ("KHR_mesh_quantization", "EXT_mesh_gpu_instancing")
"""Extensions that say where corners are, and are read."""
BESIDE = (
    "KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_xmp", "KHR_techniques_", "KHR_animation_",
    "KHR_audio", "KHR_physics_", "EXT_texture_", "EXT_lights_", "EXT_materials_", "MSFT_texture_",
    "MSFT_packing_", "ADOBE_materials_",
)  # fmt: skip
"""How the names of extensions begin that say nothing of where corners are."""
INSTANCES = "EXT_mesh_gpu_instancing"
TRIANGLES, STRIP, FAN = 4, 5, 6
MAGIC = b"glTF"


def read_gltf(data: bytes, folder: Path) -> Surface:
    """Return vertices (n, 3) and triangles (m, 3) of a glTF file; other files it names are in `folder`.

    The default scene is read; of a file without scenes all nodes, of one without nodes all meshes. A mirrored
    part is turned round, so that outside stays outside. Errors: Unreadable; OSError.
    """
    tree, binary = parted(data)
    _require_known(tree)
    vertices, faces, begin = [np.zeros((0, 3))], [np.zeros((0, 3), np.int64)], 0
    for points, rows in _Scene(tree, Accessors(tree, binary, folder)).pieces():
        require_corners(rows, len(points), "a triangle")
        vertices.append(points)
        faces.append(rows + begin)
        begin += len(points)
    return np.concatenate(vertices), np.concatenate(faces)


def parted(data: bytes) -> tuple[dict[str, Any], bytes | None]:
    """Return the tree of a file and its chunk of data, if it has one. Errors: Unreadable."""
    text, binary = data, None
    if data[:4] == MAGIC:
        text, binary = _chunks(data)
    try:
        tree = json.loads(text)
    except (ValueError, RecursionError):
        raise Unreadable("it is no glTF: its text is no JSON") from None
    if not isinstance(tree, dict):
        raise Unreadable("it is no glTF: its JSON is no table")
    return tree, binary


def _chunks(data: bytes) -> tuple[bytes, bytes | None]:
    """Return the text and the data of a binary file (section 4.4)."""
    if len(data) < 20:
        raise Unreadable("it is cut short")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise Unreadable(f"it is glTF {version}: export it as glTF 2.0")
    if length > len(data):
        raise Unreadable(f"it says to have {length} bytes, and has {len(data)}: it is cut short")
    found: dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<I4s", data, at)
        if at + 8 + size > len(data):
            raise Unreadable("a chunk of it ends beyond the file: it is cut short")
        found.setdefault(kind, data[at + 8 : at + 8 + size])
        at += 8 + size
    if b"JSON" not in found:
        raise Unreadable("it is damaged: it has no chunk of JSON")
    return found[b"JSON"], found.get(b"BIN\0")


def _require_known(tree: dict[str, Any]) -> None:
    """Refuse another version, and extensions that the file requires and that are not read, by their names."""
    asset = tree.get("asset")
    version = str(asset.get("version", "")) if isinstance(asset, dict) else ""
    if not version.startswith("2."):
        found = f"it is glTF {version[:10]}" if version else "it is no glTF, or of 1.0"
        raise Unreadable(f"{found}: export it as glTF 2.0")
    required = [str(name) for name in tree.get("extensionsRequired", [])]
    unknown = [name for name in required if name not in READ and not name.startswith(BESIDE)]
    if unknown:
        raise Unreadable(f"it requires {' and '.join(unknown)[:200]}, which is not read: export it without")


class _Scene:
    """Walk the nodes of a file and read what they show."""

    def __init__(self, tree: dict[str, Any], accessors: Accessors) -> None:
        self.tree, self.accessors = tree, accessors
        self.places: dict[int, Array] = {}
        self._read: dict[int, list[tuple[Array, Faces, dict[str, Any]]]] = {}

    def pieces(self) -> Iterator[Surface]:
        """Yield vertices and triangles in the axes of the file, mesh by mesh and place by place."""
        nodes = self.tree.get("nodes", [])
        shown = list(self._placed(self._roots(nodes)))
        if not any("mesh" in node for node in nodes):
            for index in range(len(self.tree.get("meshes", []))):
                yield from ((points, rows) for points, rows, _ in self._mesh(index, {}))
            return
        for index in shown:
            node = nodes[index]
            if "mesh" not in node:
                continue
            for points, rows, primitive in self._mesh(node["mesh"], node):
                if "skin" in node and "JOINTS_0" in primitive["attributes"]:
                    yield self._skinned(points, primitive, node["skin"]), rows
                    continue
                for place in self._instances(node, self.places[index]):
                    yield moved(points, rows, place)

    def _roots(self, nodes: list[Any]) -> list[int]:
        """Return the nodes at the top: of the default scene, or of all if there is no scene."""
        scenes = self.tree.get("scenes", [])
        if scenes:
            return [
                whole(n, "node of a scene")
                for n in item(self.tree, "scenes", self.tree.get("scene", 0)).get("nodes", [])
            ]
        below = {whole(c, "child of a node") for node in nodes for c in node.get("children", [])}
        return [n for n in range(len(nodes)) if n not in below]

    def _placed(self, roots: list[int]) -> Iterator[int]:
        """Yield every node below `roots`, after it got its place: the product of all above it."""
        waiting = [(root, np.eye(4)) for root in reversed(roots)]
        while waiting:
            index, above = waiting.pop()
            if index in self.places:
                raise Unreadable(f"node {index} is shown twice, or below itself")
            node = item(self.tree, "nodes", index)
            self.places[index] = place = product(above, _local(node))
            children = [whole(c, "child of a node") for c in node.get("children", [])]
            waiting += [(child, place) for child in reversed(children)]
            yield index

    def _mesh(self, index: Any, node: dict[str, Any]) -> list[tuple[Array, Faces, dict[str, Any]]]:
        """Return vertices, triangles and primitive of each piece of a mesh that has triangles."""
        about = item(self.tree, "meshes", index)
        known = self._read.get(index)
        if known is not None and "weights" not in node:
            return known
        weights = node.get("weights", about.get("weights", []))
        found = []
        for primitive in about.get("primitives", []):
            mode = primitive.get("mode", TRIANGLES)
            if mode not in (TRIANGLES, STRIP, FAN) or "POSITION" not in primitive["attributes"]:
                continue
            points = self._positions(primitive, weights)
            named = primitive.get("indices")
            run = np.arange(len(points)) if named is None else self.accessors.indices(named)
            found.append((points, _triangles(run, mode), primitive))
        if "weights" not in node:
            self._read[index] = found
        return found

    def _positions(self, primitive: dict[str, Any], weights: list[Any]) -> Array:
        """Return the corners of a piece (n, 3), shifted by its morph targets as far as they count."""
        position = primitive["attributes"]["POSITION"]
        if "bufferView" not in item(self.tree, "accessors", position):
            refuse_compressed(primitive)
        points = self.accessors.numbers(position, (3,))
        for weight, target in zip(weights, primitive.get("targets", []), strict=False):
            if weight and "POSITION" in target:
                shift = self.accessors.numbers(target["POSITION"], (3,))
                if shift.shape != points.shape:
                    raise Unreadable("a morph target has another number of corners than its mesh")
                points = points + float(weight) * shift
        return points

    def _instances(self, node: dict[str, Any], place: Array) -> Iterator[Array]:
        """Yield the places where a node shows its mesh: one, or those of EXT_mesh_gpu_instancing."""
        named = node.get("extensions", {}).get(INSTANCES, {}).get("attributes", {})
        parts = {
            key: self.accessors.numbers(named[key], (width,))
            for key, width in (("TRANSLATION", 3), ("ROTATION", 4), ("SCALE", 3))
            if key in named
        }
        if not parts:
            yield place
            return
        counts = {len(part) for part in parts.values()}
        if len(counts) > 1:
            raise Unreadable(f"the attributes of {INSTANCES} have different counts")
        for k in range(counts.pop()):
            one = {key.lower(): part[k].tolist() for key, part in parts.items()}
            yield product(place, _local(one))

    def _skinned(self, points: Array, primitive: dict[str, Any], index: Any) -> Array:
        """Return corners (n, 3) as the joints of a skin hold them: sum of w_j G_j B_j x (section 3.7.3)."""
        skin = item(self.tree, "skins", index)
        joints = [whole(j, "joint of a skin") for j in skin["joints"]]
        lost = [j for j in joints if j not in self.places]
        if lost:
            raise Unreadable(f"joint {lost[0]} of a skin is no node of its scene")
        bind = np.tile(np.eye(4), (len(joints), 1, 1))
        if "inverseBindMatrices" in skin:
            given = self.accessors.numbers(skin["inverseBindMatrices"], (16,))
            if len(given) < len(joints):
                raise Unreadable("a skin has fewer matrices than joints")
            bind = given[: len(joints)].reshape(-1, 4, 4).swapaxes(1, 2)
        moves = product(np.array([self.places[j] for j in joints]), bind)
        out, total = np.zeros_like(points), np.zeros(len(points))
        attributes = primitive["attributes"]
        for k in range(len(attributes)):
            if f"JOINTS_{k}" not in attributes:
                break
            rows = self.accessors.numbers(attributes[f"JOINTS_{k}"], (4,)).astype(np.int64)
            weights = self.accessors.numbers(attributes[f"WEIGHTS_{k}"], (4,))
            if (
                rows.shape != weights.shape
                or len(rows) != len(points)
                or (len(rows) and rows.max() >= len(joints))
            ):
                raise Unreadable("the joints of a mesh do not fit its skin")
            for c in range(4):
                move = moves[rows[:, c]]
                out += weights[:, c, None] * (
                    product(move[:, :3, :3], points[:, :, None])[..., 0] + move[:, :3, 3]
                )
                total += weights[:, c]
        return np.asarray(out / np.where(total > 0, total, 1.0)[:, None])


def moved(points: Array, rows: Faces, place: Array) -> Surface:
    """Return a piece where `place` (4, 4) puts it; what that mirrors is turned round."""
    out = product(points, place[:3, :3].T) + place[:3, 3]
    return out, rows[:, ::-1] if determinant(place[:3, :3]) < 0 else rows


def _triangles(run: NDArray[np.int64], mode: int) -> Faces:
    """Return the triangles of a run of corners (section 3.7.2.1)."""
    if mode == TRIANGLES:
        return run[: len(run) // 3 * 3].reshape(-1, 3)
    if len(run) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == STRIP:
        return of_strip(run)
    return np.stack([np.full(len(run) - 2, run[0]), run[1:-1], run[2:]], axis=1)


def _local(node: dict[str, Any]) -> Array:
    """Return the matrix (4, 4) of a node: `matrix`, column by column, or T R S (section 3.5.2)."""
    if "matrix" in node:
        return _vector(node["matrix"], 16, "matrix").reshape(4, 4).T
    x, y, z, w = _vector(node.get("rotation", (0.0, 0.0, 0.0, 1.0)), 4, "rotation")
    size = x * x + y * y + z * z + w * w
    s = 2.0 / size if size > 0 else 0.0
    turn = np.array(
        [
            [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
        ]
    )
    out = np.eye(4)
    out[:3, :3] = turn * _vector(node.get("scale", (1.0, 1.0, 1.0)), 3, "scale")
    out[:3, 3] = _vector(node.get("translation", (0.0, 0.0, 0.0)), 3, "translation")
    return out


def _vector(values: Any, count: int, what: str) -> Array:
    try:
        found = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        found = np.zeros(0)
    if found.shape != (count,):
        raise Unreadable(f"the {what} of a node is not {count} numbers")
    return found
