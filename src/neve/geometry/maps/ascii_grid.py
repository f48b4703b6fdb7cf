"""Read heights from an Esri ASCII grid."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neve.geometry.maps.found import Map, Place, in_degrees, require_size, unreadable
from neve.geometry.maps.well_known import Units, units_of
from neve.scene.errors import SceneError

KEYS = (
    *("ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy"),
    "nodata_value",
)
"""The words of a header (Esri, "Esri ASCII raster format"; dx and dy are GDAL's [M])."""
NO_DATA = "-9999"
"""Stands for a missing height if the header has no word for it."""
OTHERS = {b"DSAA": "a grid of Surfer", b"north": "an ASCII grid of GRASS", b"DSRB": "a grid of Surfer"}
PART = 2**24
"""Bytes of text whose numbers are read at a time."""
LONGEST = 200
"""Bytes of a line of the header at most."""


@dataclass(frozen=True)
class _Header:
    columns: int
    rows: int
    step: tuple[float, float]
    missing: float
    corner: tuple[float, float]
    """Middle of the south-western cell; NaN where the header does not say."""

    @property
    def latitude(self) -> float | None:
        """Of the middle of the map, if its numbers are degrees."""
        found = self.corner[1] + 0.5 * (self.rows - 1) * self.step[1]
        return None if math.isnan(found) else found

    def place(self, unit: float) -> Place | None:
        """Return where the map lies in its system, whose lengths are `unit` [m]; of degrees, 1."""
        if not all(map(math.isfinite, self.corner)):
            return None
        (dx, dy), (x, y) = self.step, self.corner
        return Place(unit * np.array([[dx, 0.0, x], [0.0, dy, y]]))


def read_ascii_grid(path: Path, key: str) -> Map:
    """Read rows of numbers from north to south, in lines of any length, below a header.

    Numbers are real numbers of metres; a file of the same name that ends in .prj says if lengths are feet.

    `key`: begin of sentences.

    Errors: SceneError, one sentence.
    """
    try:
        text = path.read_bytes()
        beside = path.with_suffix(".prj")
        units = units_of(beside.read_bytes()) if beside.is_file() else Units()
    except OSError as error:
        raise unreadable(key, error) from None
    text = text.removeprefix(b"\xef\xbb\xbf")  # a byte-order mark
    head, begin = _head(text, key)
    require_size(head.columns * head.rows, "heights", key)
    if 2 * head.columns * head.rows > len(text) - begin + 1:
        raise _count(key, head, "fewer")
    values = _numbers(text, begin, head, key)
    values[values == head.missing] = np.nan
    heights = values.reshape(head.rows, head.columns)[::-1].T
    if units.horizontal is None:
        told = in_degrees(head.latitude, head.step, heights.shape)
        return Map(heights, None, unit=units.vertical, no_size=told, place=head.place(1.0))
    pixel = (head.step[0] * units.horizontal, head.step[1] * units.horizontal)
    place = head.place(units.horizontal)
    return Map(heights, None, pixel, units.vertical, doubts=units.doubts, place=place)


def _head(text: bytes, key: str) -> tuple[_Header, int]:
    """Return the header and where the numbers begin."""
    for begin, what in OTHERS.items():
        if text.lstrip()[: len(begin)].lower() == begin.lower():
            raise SceneError(f"{key} is {what}, not one of Esri: save it as an Esri ASCII grid or a GeoTIFF")
    found: dict[str, str] = {}
    at = 0
    for line, end in _lines(text):
        words = line.split()
        if words and _is_number(words[0]):
            break
        if words:
            name = words[0].lower().decode(errors="replace")
            if name not in KEYS or len(words) != 2 or name in found:
                said = line[:40].decode(errors="replace").strip()
                raise SceneError(
                    f'{key} is no Esri ASCII grid: its header has "{said}", where a line is one of '
                    f"{', '.join(KEYS)} and a number"
                )
            found[name] = words[1].decode(errors="replace")
        at = end
    return _checked(found, key), at


def _lines(text: bytes) -> Iterator[tuple[bytes, int]]:
    """Yield lines, ended as on any system, and where the next one begins."""
    at = 0
    while at < len(text):
        end = re.compile(rb"\r\n|\n|\r").search(text, at, at + LONGEST)
        stop = end.end() if end else min(at + LONGEST, len(text))
        yield text[at:stop], stop
        at = stop


def _is_number(word: bytes) -> bool:
    try:
        float(word.replace(b",", b"."))
    except ValueError:
        return False
    return True


def _checked(found: dict[str, str], key: str) -> _Header:
    number = {name: _number(word, name, key) for name, word in found.items()}
    step = [number.get("cellsize", number.get(name, math.nan)) for name in ("dx", "dy")]
    for name in ("ncols", "nrows"):
        if not number.get(name, 0.0).is_integer() or number.get(name, 0.0) < 1:
            raise SceneError(f"{key} is no Esri ASCII grid: its header has no whole number as {name}")
    if not all(0.0 < one < math.inf for one in step):
        raise SceneError(
            f"{key} is no Esri ASCII grid: its header has no length as cellsize, or as dx and dy"
        )
    west, south = (
        number.get(f"{axis}llcenter", number.get(f"{axis}llcorner", math.nan) + 0.5 * length)
        for axis, length in zip("xy", step, strict=True)
    )
    missing = number.get("nodata_value", float(NO_DATA))
    return _Header(int(number["ncols"]), int(number["nrows"]), (step[0], step[1]), missing, (west, south))


def _number(word: str, name: str, key: str) -> float:
    try:
        return float(word)
    except ValueError:
        comma = ": numbers have points, not commas" if "," in word else ""
        raise SceneError(f'{key} is no Esri ASCII grid: its {name} is "{word}"{comma}') from None


def _numbers(text: bytes, begin: int, head: _Header, key: str) -> NDArray[np.float64]:
    most = head.columns * head.rows
    values = np.empty(most)
    count = 0
    while begin < len(text):
        end = min(begin + PART, len(text))
        while end < len(text) and not text[end : end + 1].isspace():  # numbers stay whole
            end += 1
        words = text[begin:end].split()
        try:
            part = np.fromiter(map(float, words), np.float64, len(words))
        except ValueError:
            raise _no_number(words, key) from None
        if count + len(part) > most:
            raise _count(key, head, "more")
        values[count : count + len(part)] = part
        count += len(part)
        begin = end
    if count != most:
        raise _count(key, head, "fewer")
    return values


def _no_number(words: list[bytes], key: str) -> SceneError:
    bad = next(word for word in words if not _is_number(word.replace(b",", b"x")))
    shown = bad[:30].decode(errors="replace")
    comma = ": numbers have points, not commas" if b"," in bad else ""
    return SceneError(f'{key} has "{shown}" among its numbers{comma}')


def _count(key: str, head: _Header, how: str) -> SceneError:
    return SceneError(
        f"{key} has {how} numbers than its header says, {head.columns} x {head.rows} (ncols x nrows): it is "
        "cut, or damaged"
    )
