"""TIFF files by hand: any order of bytes, compression, predictor and tags."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, TiffImagePlugin

PACKINGS = {1: None, 5: "tiff_lzw", 8: "deflate", 32773: "packbits", 34925: "lzma", 50000: "zstd"}
"""Compressions by number, and what Pillow calls them."""
SHORT, LONG, DOUBLE, ASCII, LONG8 = 3, 4, 12, 2, 16
CODES = {SHORT: "H", LONG: "I", DOUBLE: "d", LONG8: "Q"}


def heights(nx: int = 30, ny: int = 20) -> np.ndarray[Any, Any]:
    """Rows of 100 + 2 i + 5 j, i to the east and j to the north, the northernmost row first."""
    i, j = np.meshgrid(np.arange(nx), np.arange(ny))
    return (100.0 + 2.0 * i + 5.0 * j)[::-1]


def write(
    path: Path,
    rows: Any,
    *,
    order: str = "<",
    compression: int = 1,
    predictor: int = 1,
    tile: tuple[int, int] | None = None,
    big: bool = False,
    tags: dict[int, tuple[int, Any]] | None = None,
    mask: Any = None,
    planar: int = 1,
) -> str:
    """Write rows (ny, nx) or (ny, nx, channels), tiles (height, width) or strips of 7 rows, and its mask."""
    pictures = [(np.atleast_3d(np.asarray(rows)), tags or {})]
    if mask is not None:
        pictures.append((np.atleast_3d(np.asarray(mask, dtype=bool)), {254: (LONG, 4)}))
    head, wide = (16, "Q") if big else (8, "I")
    out = bytearray(head)
    link, where = (8, f"{order}Q") if big else (4, f"{order}I")
    for numbers, extra in pictures:
        entries, chunks = _entries(numbers, order, compression, predictor, tile, extra, planar)
        offsets = []
        for chunk in chunks:
            offsets.append(len(out))
            out += chunk + b"\0" * (len(chunk) % 2)
        entries[324 if tile else 273] = (LONG8 if big else LONG, offsets)
        entries[325 if tile else 279] = (LONG8 if big else LONG, [len(chunk) for chunk in chunks])
        struct.pack_into(where, out, link, len(out))
        link = _directory(out, entries, order, wide)
    mark = b"II" if order == "<" else b"MM"
    out[: 8 if big else 4] = mark + struct.pack(
        f"{order}HHH" if big else f"{order}H", *((43, 8, 0) if big else (42,))
    )
    path.write_bytes(out)
    return str(path)


def _directory(out: bytearray, entries: dict[int, tuple[int, Any]], order: str, wide: str) -> int:
    """Append a directory of tags and return where the place of the next one is to be written."""
    room = struct.calcsize(wide)
    beyond = len(out) + (8 if wide == "Q" else 2) + len(entries) * (4 + 2 * room) + room
    made, rest = struct.pack(f"{order}{'Q' if wide == 'Q' else 'H'}", len(entries)), b""
    for number, (kind, value) in sorted(entries.items()):
        values = value if isinstance(value, (list, tuple)) else [value]
        if kind == ASCII:
            content, count = value.encode() + b"\0", len(value) + 1
        else:
            content, count = struct.pack(f"{order}{len(values)}{CODES[kind]}", *values), len(values)
        if len(content) > room:
            rest, content = rest + content, struct.pack(f"{order}{wide}", beyond + len(rest))
        made += struct.pack(f"{order}HH{wide}", number, kind, count) + content.ljust(room, b"\0")
    link = len(out) + len(made)
    out += made + b"\0" * room + rest + b"\0" * (len(rest) % 2)
    return link


def _entries(
    numbers: Any, order: str, compression: int, predictor: int, tile: Any, extra: dict[int, Any], planar: int
) -> tuple[dict[int, tuple[int, Any]], list[bytes]]:
    ny, nx, channels = numbers.shape
    is_bits = numbers.dtype == bool
    form = {"u": 1, "i": 2, "f": 3, "b": 1}[numbers.dtype.kind]
    predictor = 1 if is_bits else predictor
    deep, across = tile or (7, nx)
    found = {
        256: (LONG, nx),
        257: (LONG, ny),
        258: (SHORT, [1 if is_bits else 8 * numbers.itemsize] * channels),
        259: (SHORT, compression),
        262: (SHORT, 1),
        277: (SHORT, channels),
        284: (SHORT, planar),
        317: (SHORT, predictor),
        339: (SHORT, [form] * channels),
    }
    found |= {322: (LONG, across), 323: (LONG, deep)} if tile else {278: (LONG, deep)}
    planes = [numbers[..., k : k + 1] for k in range(channels)] if planar == 2 else [numbers]
    chunks = []
    for plane in planes:
        for top in range(0, ny, deep):
            for left in range(0, nx, across):
                part = plane[top : top + deep, left : left + across]
                if tile:
                    room = ((0, deep - part.shape[0]), (0, across - part.shape[1]), (0, 0))
                    part = np.pad(part, room)
                chunks.append(_packed(_bytes(part, order, predictor), compression))
    return found | extra, chunks


def _bytes(part: Any, order: str, predictor: int) -> np.ndarray[Any, Any]:
    """Rows of bytes (ny, bytes) with the differences of a predictor (TIFF 6.0, section 14; note 3)."""
    ny = len(part)
    if part.dtype == bool:
        return np.packbits(part[..., 0], axis=1)
    if predictor == 1:
        return np.frombuffer(part.astype(part.dtype.newbyteorder(order)).tobytes(), np.uint8).reshape(ny, -1)
    if predictor == 2:
        whole = part.view(f"u{part.itemsize}")
        steps = np.concatenate([whole[:, :1], whole[:, 1:] - whole[:, :-1]], axis=1)
        return np.frombuffer(steps.astype(steps.dtype.newbyteorder(order)).tobytes(), np.uint8).reshape(
            ny, -1
        )
    flat = part.astype(part.dtype.newbyteorder(">")).tobytes()
    planes = np.frombuffer(flat, np.uint8).reshape(ny, -1, part.itemsize).transpose(0, 2, 1).reshape(ny, -1)
    step = part.shape[2]
    return np.concatenate([planes[:, :step], planes[:, step:] - planes[:, :-step]], axis=1)


def _packed(raw: np.ndarray[Any, Any], compression: int) -> bytes:
    if compression == 1:
        return raw.tobytes()
    if compression == 8:
        return zlib.compress(raw.tobytes())
    file = io.BytesIO()
    info = TiffImagePlugin.ImageFileDirectory_v2()
    info[278] = len(raw)  # one strip
    Image.fromarray(raw).save(file, "TIFF", compression=PACKINGS[compression], tiffinfo=info)
    with Image.open(io.BytesIO(file.getvalue())) as image:
        (begin,), (length,) = image.tag_v2[273], image.tag_v2[279]  # type: ignore[attr-defined]
    return file.getvalue()[begin : begin + length]


def geo(
    step: tuple[float, ...] = (10.0, 10.0),
    keys: dict[int, int] | None = None,
    matrix: tuple[float, float, float, float] | None = None,
    corner: tuple[float, float] = (5e5, 5.2e6),
) -> dict[int, tuple[int, Any]]:
    """Tags of a place: pixels of `step`, or X = a i + b j, Y = d i + e j with `matrix` (a, b, d, e), from the
    north-western `corner`; keys."""
    known = {1024: 1, 1025: 1, 3072: 32632, 3076: 9001} if keys is None else keys
    flat = [1, 1, 0, len(known), *(word for key in sorted(known) for word in (key, 0, 1, known[key]))]
    tags: dict[int, tuple[int, Any]] = {34735: (SHORT, flat)}
    if matrix is not None:
        a, b, d, e = matrix
        full = [a, b, 0.0, corner[0], d, e, 0.0, corner[1], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
        return tags | {34264: (DOUBLE, full)}
    ties = [0.0, 0.0, 0.0, *corner, 0.0]
    return tags | {33550: (DOUBLE, [*step, 0.0]), 33922: (DOUBLE, ties)}
