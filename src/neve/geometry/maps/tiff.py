"""Read heights from a TIFF file: its first picture of full size, and the mask that belongs to it."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.maps.found import Map, full_range, require_size, unreadable
from neve.geometry.maps.geotiff import placed
from neve.geometry.maps.pictures import ONE_CHANNEL
from neve.geometry.maps.tiff_chunks import FLOATING, HORIZONTAL, NAMES, READ, Layout, is_built, unpacked
from neve.scene.errors import SceneError
from neve.system.streams import hushed

SUBFILE, FILL_ORDER, ORIENTATION, EXTRA = 254, 266, 274, 338
BITS, COMPRESSION, PHOTOMETRIC, CHANNELS, PLANAR, PREDICTOR, FORMAT = 258, 259, 262, 277, 284, 317, 339
NO_DATA = 42113
"""Numbers of tags (TIFF 6.0; GDAL's own for missing values)."""
REDUCED, MASK = 1, 4
"""Bits of the tag NewSubfileType: a smaller copy, and a mask."""
MOST_PICTURES = 64
"""Pictures of a file that are looked at."""
COLOURS = {2: "red, green and blue", 3: "a palette", 5: "inks", 6: "YCbCr", 8: "CIE Lab", 9: "ICC Lab"}
FORMATS = {1: "u", 2: "i", 3: "f", 4: "u"}
KINDS = ("u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8", "f2", "f4", "f8")


def read_bits(path: Path, key: str) -> Map:
    """Read a TIFF file of one channel as `read_tiff` does; its numbers may also have one bit each.

    `key`: begin of sentences.

    Errors: SceneError, one sentence.
    """
    return read_tiff(path, key, True)


def read_tiff(path: Path, key: str, or_bits: bool = False) -> Map:
    """Read a TIFF file of one channel: whole or real numbers of 8 to 64 bits in any order of bytes.

    Its strips or tiles may be compressed (`neve.geometry.maps.tiff_chunks`). A channel of transparency or a
    mask marks gaps, as does the tag for missing values, which is compared in the numbers' own type.

    `key`: begin of sentences; `or_bits`: whether numbers of one bit are read as well.

    Errors: SceneError, one sentence.
    """
    from tifffile import TiffFile

    try:
        with _silent(), hushed(), TiffFile(path) as file:
            picture, mask, others = _pictures(file)
            numbers, alpha = _read(file, picture, key, or_bits)
            values = numbers.astype(np.float64)
            values[_missing(numbers, picture)] = np.nan
            if alpha is not None:
                values[alpha == 0] = np.nan
            if mask is not None:
                values[_read(file, mask, f"{key}: the mask", True)[0] == 0] = np.nan
            doubts = [f"has {others + 1} pictures: the first is read"] if others else []
            if _tag(picture, PHOTOMETRIC, 1) == 0:
                doubts.append("counts its numbers from white: they are read as they stand in the file")
            full = full_range(8 * numbers.itemsize) if numbers.dtype.kind in "iu" else None
            return placed(values, full, picture, tuple(doubts), _tag(picture, ORIENTATION, 1), key)
    except SceneError:
        raise
    except Exception as error:  # whatever a damaged file makes its reader stumble over
        raise unreadable(key, error) from None


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Keep what tifffile logs about odd tags from the user: what matters here is checked here."""
    logger = logging.getLogger("tifffile")
    was = logger.disabled
    logger.disabled = True
    try:
        yield
    finally:
        logger.disabled = was


def _pictures(file: Any) -> tuple[Any, Any, int]:
    """Return the first picture of full size, its mask or None, and how many others of full size there are."""
    pages = [file.pages[0]]
    for i in range(1, MOST_PICTURES):
        try:
            pages.append(file.pages[i])
        except IndexError:
            break
    kinds = [_tag(page, SUBFILE, 0) for page in pages]
    whole = [page for page, kind in zip(pages, kinds, strict=True) if not kind & (REDUCED | MASK)] or pages[
        :1
    ]
    masks = [page for page, kind in zip(pages, kinds, strict=True) if kind & MASK and not kind & REDUCED]
    fitting = [page for page in masks if _extent(page) == _extent(whole[0])]
    return whole[0], fitting[0] if fitting else None, len(whole) - 1


def _extent(page: Any) -> tuple[int, int]:
    return int(page.imagelength), int(page.imagewidth)


def _tag(page: Any, number: int, default: int) -> int:
    """Return the first number of a tag of whole numbers."""
    value = _tags(page, number)
    return value[0] if value else default


def _tags(page: Any, number: int) -> tuple[int, ...]:
    tag = page.tags.get(number)
    value = () if tag is None else tag.value
    return tuple(int(one) for one in (value if isinstance(value, tuple) else (value,)))


def _layout(page: Any, order: str, key: str, or_bits: bool) -> tuple[Layout, bool]:
    """Return how the numbers of a picture lie, and whether a second channel is that of transparency.

    Errors: SceneError for what is not read, by its true name.
    """
    colours = _tag(page, PHOTOMETRIC, 1)
    if colours in COLOURS:
        raise SceneError(f"{key} is a picture in colours ({COLOURS[colours]}): {ONE_CHANNEL}")
    channels = _tag(page, CHANNELS, 1)
    is_alpha = channels == 2 and _tags(page, EXTRA)[:1] in ((1,), (2,))
    if channels != 1 and not is_alpha:
        raise SceneError(f"{key} has {channels} bands: {ONE_CHANNEL}; save the one with the heights alone")
    bits, form = set(_tags(page, BITS) or (1,)), set(_tags(page, FORMAT) or (1,))
    if len(bits) > 1 or len(form) > 1:
        raise SceneError(f"{key} has bands of different kinds of numbers: {ONE_CHANNEL}")
    width, sort = bits.pop(), FORMATS.get(form.pop(), "c")
    kind = f"{sort}{width // 8}" if width % 8 == 0 else f"{width} bits"
    if kind not in KINDS and not (or_bits and width == 1):
        what = "complex numbers" if sort == "c" else f"numbers of {width} bits"
        raise SceneError(f"{key} has {what}: whole numbers of 8, 16, 32 and 64 bits and reals are read")
    kind = "b1" if width == 1 else kind
    compression, predictor = _tag(page, COMPRESSION, 1), _tag(page, PREDICTOR, 1)
    if compression not in READ or not is_built(compression):
        name = NAMES.get(compression, f"number {compression}")
        raise SceneError(
            f"{key} is compressed as {name}, which is not read here: save it with the compression DEFLATE"
        )
    is_sound = predictor in (1, HORIZONTAL) or (predictor == FLOATING and sort == "f")
    if not is_sound or (kind == "b1" and predictor != 1) or _tag(page, FILL_ORDER, 1) != 1:
        what = f"the predictor {predictor}" if _tag(page, FILL_ORDER, 1) == 1 else "bits in reverse order"
        raise SceneError(f"{key} has {what}, which is not read for such numbers: save it anew")
    beside = 1 if _tag(page, PLANAR, 1) == 2 else channels
    return Layout(order, kind, beside, compression, predictor), is_alpha


def _read(file: Any, page: Any, key: str, or_bits: bool) -> tuple[NDArray[Any], NDArray[Any] | None]:
    """Return the numbers of the first channel, rows from the top, and those of the second if it is one of
    transparency.
    """
    layout, is_alpha = _layout(page, file.byteorder, key, or_bits)
    rows, columns = _extent(page)
    require_size(rows * columns, "pixels", key)
    first = _plane(file, page, layout, 0)
    if not is_alpha:
        return first[..., 0], None
    return first[..., 0], (first[..., 1] if layout.channels == 2 else _plane(file, page, layout, 1)[..., 0])


def _plane(file: Any, page: Any, layout: Layout, plane: int) -> NDArray[Any]:
    """Return the numbers (rows, columns, channels) of a plane, put together from its strips or tiles."""
    rows, columns = _extent(page)
    if page.is_tiled:
        deep, wide = int(page.tilelength), int(page.tilewidth)
    else:
        deep, wide = min(int(page.rowsperstrip), rows), columns
    if not (0 < deep <= 2 * rows + 4096 and 0 < wide <= 2 * columns + 4096):
        raise ValueError("strips or tiles of no sensible size")
    kind = "u1" if layout.kind == "b1" else layout.kind
    made = np.full((rows, columns, layout.channels), _filling(page, kind), dtype=kind)
    across = -(-columns // wide)
    first = plane * across * -(-rows // deep)
    for i, top in enumerate(range(0, rows, deep)):
        for j, left in enumerate(range(0, columns, wide)):
            at = first + i * across + j
            begin, length = int(page.dataoffsets[at]), int(page.databytecounts[at])
            if not length:  # left out by its writer, because nothing is there
                continue
            file.filehandle.seek(begin)
            chunk = file.filehandle.read(min(length, file.filehandle.size - begin))
            height = deep if page.is_tiled else min(deep, rows - top)
            part = unpacked(chunk, height, wide, layout)
            made[top : top + deep, left : left + wide] = part[: rows - top, : columns - left]
    return made


def _no_data(page: Any) -> str:
    tag = page.tags.get(NO_DATA)
    return str(tag.value).strip("\0 ") if tag is not None else ""


def _filling(page: Any, kind: str) -> Any:
    """Return what stands where a file has no strip or tile: the value for missing heights, or 0."""
    values = _as_kind(_no_data(page), np.dtype(kind))
    return values[0] if values else 0


def _missing(numbers: NDArray[Any], page: Any) -> NDArray[np.bool_]:
    found = np.zeros(numbers.shape, dtype=bool)
    for value in _as_kind(_no_data(page), numbers.dtype):
        found |= numbers == value
    return found


def _as_kind(word: str, kind: np.dtype[Any]) -> list[Any]:
    """Return the numbers of type `kind` that a tag for missing values means.

    A real number is rounded to the type, and one beyond its range means its largest, or infinity; a whole
    number that the type does not have means none.
    """
    try:
        value = float(word)
        if kind.kind == "f":
            with np.errstate(over="ignore"):
                near = kind.type(value)
            most = np.finfo(kind).max
            ends = [np.copysign(most, near)] if np.isinf(near) and np.isfinite(value) else []
            return [near, *ends]
        whole = int(word) if word.lstrip("+-").isdigit() else int(value) if value.is_integer() else None
    except (ValueError, OverflowError):
        return []
    limits = np.iinfo(kind)
    return [] if whole is None or not limits.min <= whole <= limits.max else [kind.type(whole)]
