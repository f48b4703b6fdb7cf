"""Read STL files, text and binary.

Source: 3D Systems, Stereolithography Interface Specification, 1989 [M]. A binary file is a header of 80
bytes, a count, and 50 bytes a triangle; files of text begin with "solid", but so do some binary ones.
"""

from __future__ import annotations

import re
import struct

import numpy as np

from neve.geometry.files.polygons import triangulated
from neve.geometry.files.wording import Surface, Unreadable, numbers, plain

HEAD, EACH = 84, 50
"""Bytes before the first triangle of a binary file, and of each."""
NAMES = re.compile(rb"(?im)^[ \t]*(?:end)?solid\b(?:(?!\bfacet[ \t]+normal\b)[^\r\n])*")
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("about", "<u2")])


def read_stl(data: bytes, notes: list[str]) -> Surface:
    """Return vertices (3 m, 3) and triangles (m, 3) of an STL file; tell in `notes` of a count that is wrong.

    Errors: Unreadable.
    """
    if not _is_exact(data):
        text = plain(data)
        if _is_text(text):
            return _text(text)
    if len(data) < HEAD:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    count = _count(data, notes)
    corners = np.frombuffer(data, RECORD, count, HEAD)["corners"].astype(np.float64).reshape(-1, 3)
    return corners, np.arange(3 * count, dtype=np.int64).reshape(-1, 3)


def _is_exact(data: bytes) -> bool:
    """Return whether a file has just the length that its binary count asks for."""
    return len(data) >= HEAD and len(data) == HEAD + EACH * struct.unpack_from("<I", data, 80)[0]


def _is_text(text: bytes) -> bool:
    head = text[:4096].lower()
    return head.lstrip().startswith(b"solid") and b"\0" not in head and (b"facet" in head or len(text) < HEAD)


def _count(data: bytes, notes: list[str]) -> int:
    """Return how many triangles a binary file holds, whatever it says. Errors: Unreadable if too few."""
    said = int(struct.unpack_from("<I", data, 80)[0])
    whole, rest = divmod(len(data) - HEAD, EACH)
    if said in (0, 0xFFFFFFFF) and whole:  # written before the writer knew
        if rest:
            raise Unreadable(f"its header says {said} triangles, and {len(data) - HEAD} bytes follow")
        notes.append(_wrong(said, whole))
        return whole
    if said > whole:
        raise Unreadable(f"its header says {said} triangles, and {whole} follow: it is cut short")
    if said < whole and rest == 0 and _are_triangles(data, said):
        notes.append(_wrong(said, whole))
        return whole
    return said


def _wrong(said: int, whole: int) -> str:
    return f"says {said} triangles in its header, and {whole} follow: all of them are read"


def _are_triangles(data: bytes, said: int) -> bool:
    """Return whether what follows the triangles of the count are more of them: numbers of the same size."""
    corners = np.frombuffer(data, RECORD, offset=HEAD)["corners"]
    rest = corners[said:]
    if not np.isfinite(rest).all() or not np.isfinite(corners[:said]).all():
        return False
    low, high = corners[:said].min(axis=(0, 1)), corners[:said].max(axis=(0, 1))
    room = 10.0 * float((high - low).max())
    return bool((rest >= low - room).all() and (rest <= high + room).all() and np.abs(rest).any())


def _text(text: bytes) -> Surface:
    """Return vertices and triangles of the loops in a file of text; a name may be any words."""
    words = NAMES.sub(b" ", text).split()
    lower = [word.lower() for word in words]
    at = np.array(
        [i for i, word in enumerate(lower) if word in (b"vertex", b"outer", b"endloop")], dtype=np.int64
    )
    kinds = np.array([lower[i][:1] for i in at.tolist()], dtype="S1")
    corner = at[kinds == b"v"]
    if len(corner) and corner[-1] + 3 >= len(words):
        raise Unreadable("its last corner is cut short")
    begun, ended = int((kinds == b"o").sum()), int((kinds == b"e").sum())
    if begun != ended or lower.count(b"facet") != lower.count(b"endfacet"):
        raise Unreadable(f"{begun} of its triangles begin and {ended} end: it is cut short, or damaged")
    tokens = [words[i + k] for i in corner.tolist() for k in (1, 2, 3)]
    vertices = numbers(tokens, "a vertex").reshape(-1, 3)
    counts = np.diff(np.searchsorted(corner, at[kinds == b"e"]), prepend=0)
    return vertices, triangulated(vertices, np.arange(int(counts.sum()), dtype=np.int64), counts)
