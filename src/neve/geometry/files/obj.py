"""Read Wavefront OBJ files: corners and polygons; all else in them says nothing of the surface.

Source: Wavefront Advanced Visualizer, appendix B1, object files (.obj) [M].
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from neve.geometry.files.polygons import triangulated
from neve.geometry.files.wording import Array, Faces, Surface, Unreadable, numbers, parsed, plain, shown

CONTINUED = re.compile(rb"\\[ \t]*$")
BEHIND = re.compile(rb"/\S*")
NUMBER = re.compile(rb"[+-]?0*[1-9][0-9]{0,17}")
SPACE, NEW_LINE = ord(" "), ord("\n")


@dataclass
class Lines:
    """Hold what stands behind the first word of all lines of one kind, and the numbers of these lines."""

    bodies: list[bytes] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)

    def words(self) -> NDArray[np.int64]:
        """Return how many words each line has (n,)."""
        signs = np.frombuffer(b"\n".join(self.bodies), np.uint8)
        begins = (signs > SPACE) & np.concatenate([[True], signs[:-1] <= SPACE])
        return np.bincount(np.cumsum(signs == NEW_LINE)[begins], minlength=len(self.bodies))


def read_obj(data: bytes) -> Surface:
    """Return vertices (n, 3) and triangles (m, 3) of an OBJ file.

    A negative index counts back from the corners above its line. Errors: Unreadable, which names the line.
    """
    rows, faces = _lines(plain(data))
    vertices = _corners(rows)
    counts = faces.words()
    corners = _indices(faces, int(counts.sum()))
    lines = np.array(faces.numbers, dtype=np.int64)
    above = np.searchsorted(np.array(rows.numbers, dtype=np.int64), lines)
    corners = np.where(corners < 0, corners + np.repeat(above, counts), corners - 1)
    lost = np.flatnonzero((corners < 0) | (corners >= len(vertices)))
    if len(lost):
        line = int(np.repeat(lines, counts)[lost[0]])
        raise Unreadable(f"the face of line {line} names a corner that is not there, of {len(vertices)}")
    return vertices, triangulated(vertices, corners, counts)


def _lines(text: bytes) -> tuple[Lines, Lines]:
    """Return the lines of corners and those of faces, without comments, continued ones as one."""
    rows, faces = Lines(), Lines()
    kinds = {b"v": rows, b"f": faces, b"fo": faces}  # "fo" is what old files call a face
    commented, continued = b"#" in text, b"\\" in text
    lines = enumerate(text.splitlines(), 1)
    for number, line in lines:
        kind, _, body = line.partition(b" ")
        if kind not in kinds:
            word = line.split(None, 1)[:1]
            if not word or word[0] not in kinds:
                continue
            kind, body = word[0], line.lstrip()[len(word[0]) :]
        if commented:
            body = body.partition(b"#")[0]
        while continued and CONTINUED.search(body):
            body = CONTINUED.sub(b" ", body) + next(lines, (0, b""))[1].partition(b"#")[0]
        kinds[kind].bodies.append(body)
        kinds[kind].numbers.append(number)
    return rows, faces


def _corners(rows: Lines) -> Array:
    """Return the first three numbers of each row (n, 3); weights and colours may follow them."""
    counts = rows.words()
    if (counts < 3).any():
        line = rows.numbers[int((counts < 3).argmax())]
        raise Unreadable(f"line {line} has a corner of fewer than three numbers")
    together = parsed(b"\n".join(rows.bodies), np.float64)
    if len(together) == counts.sum():
        first = np.cumsum(counts) - counts
        return np.asarray(together[first[:, None] + np.arange(3)])
    found = [
        numbers(body.split()[:3], f"line {line}")
        for body, line in zip(rows.bodies, rows.numbers, strict=True)
    ]
    return np.array(found).reshape(-1, 3)


def _indices(faces: Lines, count: int) -> Faces:
    """Return the `count` numbers of corners as they stand, of all faces in a row: what is before a slash."""
    text = b"\n".join(faces.bodies)
    found = parsed(BEHIND.sub(b"", text) if b"/" in text else text, np.int64)
    if len(found) == count and found.all():
        return found
    found = np.zeros(count, np.int64)
    words = (
        (word, line) for body, line in zip(faces.bodies, faces.numbers, strict=True) for word in body.split()
    )
    for i, (word, line) in enumerate(words):
        head = word.partition(b"/")[0]
        if not NUMBER.fullmatch(head):
            raise Unreadable(f"line {line} has {shown(word)} where the number of a corner belongs")
        found[i] = int(head)
    return found
