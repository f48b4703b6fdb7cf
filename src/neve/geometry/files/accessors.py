"""Read the numbers of a glTF file: buffers, views of them and accessors, also sparse and normalised ones.

Source: Khronos glTF 2.0, sections 3.6 (binary data) and 3.6.2 (accessors).
"""

from __future__ import annotations

import base64
import binascii
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from neve.geometry.files.wording import Unreadable
from neve.system import disk

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
COMPRESSED = ("EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_draco_mesh_compression")
"""Extensions whose data another program must unpack first."""


def whole(value: Any, what: str) -> int:
    """Return a count, an index or a length of a tree. Errors: Unreadable if it is not whole."""
    if isinstance(value, bool) or not isinstance(value, int | float) or value != value or value < 0:
        raise Unreadable(f"its {what} is no whole number")
    if value > 2**53 or int(value) != value:
        raise Unreadable(f"its {what} is no whole number")
    return int(value)


def item(tree: dict[str, Any], table: str, index: Any) -> Any:
    """Return entry `index` of a table of the tree. Errors: Unreadable if there is none."""
    entries = tree.get(table, [])
    at = whole(index, f"index into {table}")
    if not isinstance(entries, list) or at >= len(entries) or not isinstance(entries[at], dict):
        raise Unreadable(f"it names number {at} of its {table}, and there are {len(entries)}")
    return entries[at]


def refuse_compressed(part: dict[str, Any]) -> None:
    """Refuse a part of the tree whose data is packed by an extension. Errors: Unreadable, which names it."""
    for name in COMPRESSED:
        if name in part.get("extensions", {}):
            raise Unreadable(f"it is compressed with {name}, which is not read: export it without")


class Accessors:
    """Read accessors of one file by their index.

    tree: the JSON; binary: the chunk of data of a GLB file, or None; folder: where other files lie.
    """

    def __init__(self, tree: dict[str, Any], binary: bytes | None, folder: Path) -> None:
        self.tree, self.binary, self.folder = tree, binary, folder
        self._buffers: dict[int, bytes] = {}

    def numbers(self, index: Any, widths: tuple[int, ...]) -> NDArray[np.float64]:
        """Return the numbers of an accessor (count, width); normalised ones as the reals they stand for.

        Section 3.6.2.2: c / 255, max(c / 127, -1), c / 65535, max(c / 32767, -1).
        """
        raw, normalized = self._values(index, widths)
        if not normalized or raw.dtype.kind == "f":
            return raw.astype(np.float64)
        return np.maximum(raw.astype(np.float64) / np.iinfo(raw.dtype).max, -1.0)

    def indices(self, index: Any) -> NDArray[np.int64]:
        """Return the whole numbers of an accessor of scalars (count,)."""
        raw, _ = self._values(index, (1,))
        if raw.dtype.kind == "f":
            raise Unreadable("the corners of its triangles are named by real numbers")
        return raw.astype(np.int64).reshape(-1)

    def _values(self, index: Any, widths: tuple[int, ...]) -> tuple[NDArray[Any], bool]:
        about = item(self.tree, "accessors", index)
        count = whole(about.get("count"), "count of an accessor")
        width = WIDTHS.get(about.get("type", ""), 0)
        if width not in widths:
            raise Unreadable(
                f"accessor {index} is of the type {about.get('type')}, which does not fit its use"
            )
        kind = self._kind(about)
        if "bufferView" in about:
            found = self._strided(about, kind, count, width)
        else:
            found = np.zeros((count, width), kind)
        if "sparse" in about:
            found = self._replaced(found, about["sparse"])
        return found, bool(about.get("normalized", False))

    @staticmethod
    def _kind(about: dict[str, Any]) -> np.dtype[Any]:
        number = about.get("componentType")
        if number not in COMPONENTS:
            raise Unreadable(f"its data has the component type {number}, which glTF 2.0 does not know")
        return np.dtype(COMPONENTS[number])

    def _replaced(self, found: NDArray[Any], sparse: dict[str, Any]) -> NDArray[Any]:
        """Return `found` with the values of a sparse accessor in their places (section 3.6.2.3)."""
        count = whole(sparse.get("count"), "count of a sparse accessor")
        where = sparse["indices"]
        rows = self._strided(where, self._kind(where), count, 1).reshape(-1).astype(np.int64)
        values = self._strided(sparse["values"], found.dtype, count, found.shape[1])
        if count and int(rows.max()) >= len(found):
            raise Unreadable("a sparse accessor replaces a value that is not there")
        out = found.copy()
        out[rows] = values
        return out

    def _strided(self, about: dict[str, Any], kind: np.dtype[Any], count: int, width: int) -> NDArray[Any]:
        """Return `count` rows of a view, of which each begins `byteStride` after the one before."""
        view = item(self.tree, "bufferViews", about["bufferView"])
        data = self._view(view)
        begin = whole(about.get("byteOffset", 0), "byteOffset")
        size = kind.itemsize * width
        stride = whole(view.get("byteStride", size), "byteStride")
        if stride < size:
            raise Unreadable(f"it has values of {size} bytes, {stride} bytes apart")
        if count and begin + (count - 1) * stride + size > len(data):
            raise Unreadable(
                f"an accessor of {count} values ends beyond its data: it is cut short, or damaged"
            )
        if not count:
            return np.zeros((0, width), kind)
        return np.ndarray((count, width), kind, data, begin, (stride, kind.itemsize)).copy()

    def _view(self, view: dict[str, Any]) -> bytes:
        refuse_compressed(view)
        data = self._buffer(whole(view["buffer"], "index into buffers"))
        begin = whole(view.get("byteOffset", 0), "byteOffset")
        end = begin + whole(view.get("byteLength"), "byteLength")
        if end > len(data):
            raise Unreadable(f"a view ends at byte {end} of {len(data)}: it is cut short, or damaged")
        return data[begin:end]

    def _buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            self._buffers[index] = self._loaded(index)
        return self._buffers[index]

    def _loaded(self, index: int) -> bytes:
        about = item(self.tree, "buffers", index)
        refuse_compressed(about)
        uri = about.get("uri")
        if uri is None:
            if index or self.binary is None:
                raise Unreadable(f"buffer {index} has no data")
            return self.binary
        if not isinstance(uri, str):
            raise Unreadable(f"buffer {index} has a uri that is no text")
        if uri[:5].lower() == "data:":
            return _embedded(uri)
        return _beside(self.folder, uri)


def _embedded(uri: str) -> bytes:
    """Return the data that a uri holds itself (RFC 2397)."""
    head, comma, body = uri.partition(",")
    if not comma:
        raise Unreadable("it has a data uri without data")
    raw = unquote_to_bytes(body)
    if not head.lower().endswith(";base64"):
        return raw
    try:
        return base64.b64decode(raw + b"=" * (-len(raw) % 4))
    except (binascii.Error, ValueError):
        raise Unreadable("it has a data uri that is no base64") from None


def path_of(folder: Path, uri: str) -> Path:
    """Return the file that a relative uri names, percent-encoded or not (RFC 3986)."""
    literal = folder / uri
    return literal if "%" in uri and literal.exists() else folder / unquote(uri)


def _beside(folder: Path, uri: str) -> bytes:
    if "://" in uri:
        raise Unreadable(f"its data is elsewhere, at {uri[:60]}: put it beside the file")
    path = path_of(folder, uri)
    try:
        return disk.read_bytes(path)
    except FileNotFoundError:
        raise Unreadable(f"the file {path.name} with its data is not there") from None
