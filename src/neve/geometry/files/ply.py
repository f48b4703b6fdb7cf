"""Read PLY files: text and binary of either byte order, any elements and properties, faces of any corners.

Source: Turk, The PLY Polygon File Format, 1994 [M].
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.files.polygons import of_strip, triangulated
from neve.geometry.files.wording import Faces, Surface, Unreadable, numbers, plain, require_corners, shown

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8", "int64": "i8", "uint64": "u8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
CORNERS = ("vertex_indices", "vertex_index", "vertex_indexes", "vertices")
"""What the list of a face's corners is called."""


@dataclass
class Property:
    """Hold a property of an element: its name, its type, and of a list the type of its length."""

    name: str
    kind: str
    length: str = ""


@dataclass
class Element:
    """Hold an element of the header: its name, how many there are, and what each has."""

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)


Columns = dict[str, Any]
"""Of an element, by property: numbers (count,), or of a list its lengths (count,) and all its items (n,)."""


def read_ply(data: bytes) -> Surface:
    """Return vertices (n, 3) and triangles (m, 3) of a PLY file. Errors: Unreadable."""
    if not data.startswith(b"ply"):
        data = plain(data)
    order, elements, begin = _header(data)
    body: _Text | _Binary = _Binary(data, begin, order) if order else _Text(data[begin:])
    vertices, faces = np.zeros((0, 3)), [np.zeros((0, 3), np.int64)]
    listed = []
    for element in elements:
        columns = body.columns(element)
        if element.name == "vertex":
            if any(axis not in columns for axis in "xyz"):
                raise Unreadable("its vertices have no x, y and z")
            vertices = np.stack([np.asarray(columns[axis], np.float64) for axis in "xyz"], axis=1)
        elif found := next((columns[name] for name in CORNERS if name in columns), None):
            listed.append((element.name, *found))
    for name, lengths, items in listed:
        if name == "tristrips":
            lengths, items = _unrolled(lengths, items)
        require_corners(items, len(vertices))
        faces.append(triangulated(vertices, items, lengths))
    return vertices, np.concatenate(faces)


def _header(data: bytes) -> tuple[str, list[Element], int]:
    """Return the byte order ("" for text), the elements, and where they begin."""
    if data[:3] != b"ply" or data[3:4] not in (b"\n", b"\r", b" ", b"\t"):
        raise Unreadable("it does not begin with the word ply")
    elements: list[Element] = []
    order, begin = None, 0
    while True:
        words, begin = _line(data, begin)
        try:
            if words[:1] == ["end_header"]:
                break
            if words[:1] == ["format"]:
                order = ORDERS[words[1]]
            elif words[:1] == ["element"]:
                elements.append(Element(words[1], int(words[2])))
                if elements[-1].count < 0:
                    raise ValueError
            elif words[:2] == ["property", "list"]:
                elements[-1].properties.append(Property(words[4], TYPES[words[3]], TYPES[words[2]]))
            elif words[:1] == ["property"]:
                elements[-1].properties.append(Property(words[2], TYPES[words[1]]))
        except (KeyError, IndexError, ValueError):
            line = " ".join(words).encode("ascii", "replace")
            raise Unreadable(f"its header has a line that means nothing: {shown(line)}") from None
    if order is None:
        raise Unreadable("its header names no format")
    return order, elements, begin


def _line(data: bytes, begin: int) -> tuple[list[str], int]:
    """Return the words of the line at `begin`, and where the next begins: after LF, CR LF, or CR."""
    end = min((i for i in (data.find(b"\n", begin), data.find(b"\r", begin)) if i >= 0), default=-1)
    if end < 0:
        raise Unreadable("its header does not end: it is cut short, or no PLY file")
    after = end + 2 if data[end : end + 2] == b"\r\n" and data[:5].endswith(b"\r\n") else end + 1
    return data[begin:end].decode("latin-1").split(), after


class _Binary:
    """Read the elements of a binary file one after the other."""

    def __init__(self, data: bytes, begin: int, order: str) -> None:
        self.data, self.at, self.order = data, begin, order

    def columns(self, element: Element) -> Columns:
        """Return the columns of the next element. Errors: Unreadable if the file ends before it does."""
        if not element.count or not element.properties:
            return {p.name: (_none(), _none()) if p.length else np.zeros(0) for p in element.properties}
        if not any(p.length for p in element.properties):
            table = self._table(element, {})
            return {p.name: table[f"{k}"] for k, p in enumerate(element.properties)}
        lengths = self._first_lengths(element)
        try:
            table = self._table(element, lengths)
        except Unreadable:
            return self._one_by_one(element)
        if any((table[f"n{k}"] != n).any() for k, n in lengths.items()):
            self.at -= table.nbytes
            return self._one_by_one(element)
        found: Columns = {}
        for k, p in enumerate(element.properties):
            column = table[f"{k}"]
            found[p.name] = (
                (table[f"n{k}"].astype(np.int64), _whole(column.reshape(-1))) if p.length else column
            )
        return found

    def _table(self, element: Element, lengths: dict[int, int]) -> NDArray[Any]:
        """Return all rows, if the lists of the properties `lengths` have the same length in each."""
        fields: list[Any] = []
        for k, p in enumerate(element.properties):
            if p.length:
                fields += [(f"n{k}", self.order + p.length), (f"{k}", self.order + p.kind, (lengths[k],))]
            else:
                fields.append((f"{k}", self.order + p.kind))
        row = np.dtype(fields)
        if element.count * row.itemsize > len(self.data) - self.at:
            raise _short(element, (len(self.data) - self.at) // max(row.itemsize, 1))
        table = np.frombuffer(self.data, row, element.count, self.at)
        self.at += table.nbytes
        return table

    def _first_lengths(self, element: Element) -> dict[int, int]:
        """Return how long each list of the first row is."""
        at, lengths = self.at, {}
        for k, p in enumerate(element.properties):
            if p.length:
                lengths[k], at = self._length(element, p, at, 0)
                at += lengths[k] * np.dtype(p.kind).itemsize
            else:
                at += np.dtype(p.kind).itemsize
        return lengths

    def _length(self, element: Element, p: Property, at: int, row: int) -> tuple[int, int]:
        kind = np.dtype(self.order + p.length)
        if at + kind.itemsize > len(self.data):
            raise _short(element, row)
        length = int(np.frombuffer(self.data, kind, 1, at)[0])
        at += kind.itemsize
        if not 0 <= length * np.dtype(p.kind).itemsize <= len(self.data) - at:
            raise _short(element, row)
        return length, at

    def _one_by_one(self, element: Element) -> Columns:
        """Return the columns of rows whose lists are of different lengths."""
        parts: list[list[Any]] = [[] for _ in element.properties]
        sizes: list[list[int]] = [[] for _ in element.properties]
        data, at, room = self.data, self.at, len(self.data)
        kinds = [(np.dtype(p.kind).itemsize, p.length) for p in element.properties]
        big = self.order == ">"
        wide = [np.dtype(self.order + (p.length or "i4")) for p in element.properties]
        for row in range(element.count):
            for k, (size, length) in enumerate(kinds):
                n = 1
                if length:
                    step = wide[k].itemsize
                    if wide[k].kind == "f":
                        n = int(np.frombuffer(data[at : at + step].ljust(step, b"\0"), wide[k])[0])
                    else:
                        n = int.from_bytes(
                            data[at : at + step], "big" if big else "little", signed=wide[k].kind == "i"
                        )
                    at += step
                    sizes[k].append(n)
                if n < 0 or at + n * size > room:
                    raise _short(element, row)
                parts[k].append(data[at : at + n * size])
                at += n * size
        self.at = at
        found: Columns = {}
        for k, p in enumerate(element.properties):
            items = np.frombuffer(b"".join(parts[k]), self.order + p.kind)
            found[p.name] = (np.array(sizes[k], np.int64), _whole(items)) if p.length else items
        return found


class _Text:
    """Read the elements of a file of text one after the other: words, whatever lines they stand in."""

    def __init__(self, text: bytes) -> None:
        self.words, self.at = text.split(), 0

    def columns(self, element: Element) -> Columns:
        """Return the columns of the next element. Errors: Unreadable if the file ends before it does."""
        wide = len(element.properties)
        if not any(p.length for p in element.properties):
            end = self.at + element.count * wide
            if end > len(self.words):
                raise _short(element, (len(self.words) - self.at) // max(wide, 1))
            table = numbers(self.words[self.at : end], f"an element {element.name}").reshape(
                element.count, wide
            )
            self.at = end
            return {p.name: table[:, k] for k, p in enumerate(element.properties)}
        parts: list[list[bytes]] = [[] for _ in element.properties]
        sizes: list[list[int]] = [[] for _ in element.properties]
        words, at, room = self.words, self.at, len(self.words)
        for row in range(element.count):
            for k, p in enumerate(element.properties):
                n = 1
                if p.length:
                    if at >= room:
                        raise _short(element, row)
                    if not words[at].isdigit():
                        raise Unreadable(f"a list has {shown(words[at])} where its length belongs")
                    n = int(words[at])
                    at += 1
                    sizes[k].append(n)
                if at + n > room:
                    raise _short(element, row)
                parts[k] += words[at : at + n]
                at += n
        self.at = at
        what = f"an element {element.name}"
        return {
            p.name: (np.array(sizes[k], np.int64), _whole(numbers(parts[k], what))) if p.length
            else numbers(parts[k], what)
            for k, p in enumerate(element.properties)
        }  # fmt: skip


def _unrolled(lengths: Faces, items: Faces) -> tuple[Faces, Faces]:
    """Return the triangles of strips, as lists of three; -1 begins a new strip."""
    found = []
    for strip in np.split(items, np.cumsum(lengths)[:-1]):
        for run in np.split(strip, np.flatnonzero(strip < 0)):
            run = run[run >= 0]
            if len(run) >= 3:
                found.append(of_strip(run))
    faces = np.concatenate(found) if found else np.zeros((0, 3), np.int64)
    return np.full(len(faces), 3, np.int64), faces.reshape(-1)


def _whole(items: NDArray[Any]) -> Faces:
    """Return numbers of corners as whole ones; what is none becomes a corner that is not there."""
    if items.dtype.kind in "iu":
        return items.astype(np.int64)
    good = np.isfinite(items) & (np.abs(items) < 2**53)
    rounded = np.where(good, items, -2.0)
    return np.where(rounded == np.rint(rounded), rounded, -2.0).astype(np.int64)


def _none() -> Faces:
    return np.zeros(0, np.int64)


def _short(element: Element, found: int) -> Unreadable:
    name = shown(element.name.encode())
    return Unreadable(
        f"its header says {element.count} of the element {name}, and there are {found}: it is cut short"
    )
