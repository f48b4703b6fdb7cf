"""Unpack the strips and tiles of a TIFF file into rows of numbers."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

NONE, LZW, DEFLATE, ADOBE_DEFLATE, PACKBITS = 1, 5, 32946, 8, 32773
LZMA, ZSTD = 34925, 50000
BY_LIBTIFF = (LZW, PACKBITS, LZMA, ZSTD)
"""Bytes that Pillow's libtiff unpacks."""
READ = (NONE, ADOBE_DEFLATE, DEFLATE, *BY_LIBTIFF)
NAMES = {
    LZW: "LZW",
    PACKBITS: "PackBits",
    LZMA: "LZMA",
    ZSTD: "Zstandard",
    34887: "LERC",
    2: "CCITT run lengths",
    3: "CCITT fax 3",
    4: "CCITT fax 4",
    6: "JPEG (old)",
    7: "JPEG",
    34712: "JPEG 2000",
    34892: "JPEG (lossy DNG)",
    50001: "WebP",
    50002: "JPEG XL",
    52546: "JPEG XL",
}
"""Compressions by their number in the tag (TIFF 6.0; libtiff's and GDAL's own from 32000 on [M])."""
HORIZONTAL, FLOATING = 2, 3
"""Predictors (TIFF 6.0, section 14; Adobe TIFF technical note 3)."""


@dataclass(frozen=True)
class Layout:
    """Hold how the numbers of one picture lie in its strips or tiles.

    Attributes:
        order: "<" or ">"
        kind: NumPy's word for a number without its order, such as "f4"; "b1" for one bit
        channels: numbers of a pixel that lie beside each other
        compression, predictor: numbers of the tags
    """

    order: str
    kind: str
    channels: int
    compression: int
    predictor: int

    @property
    def size(self) -> int:
        """Bytes of a number."""
        return int(self.kind[1:])

    def row_bytes(self, columns: int) -> int:
        """Return the bytes of a row."""
        numbers = columns * self.channels
        return -(-numbers // 8) if self.kind == "b1" else numbers * self.size


def unpacked(chunk: bytes, rows: int, columns: int, layout: Layout) -> NDArray[Any]:
    """Return the numbers (rows, columns, channels) of a strip or tile, in the order of the machine.

    Errors: ValueError, OSError, zlib.error or another of the reader's if it is damaged.
    """
    length = rows * layout.row_bytes(columns)
    if layout.compression == NONE:
        raw = chunk[:length]
    elif layout.compression in (DEFLATE, ADOBE_DEFLATE):
        raw = zlib.decompressobj().decompress(chunk, length)
    else:
        raw = _by_libtiff(chunk, rows, layout.row_bytes(columns), layout.compression)
    if len(raw) != length:
        raise ValueError("a strip or tile is short")
    return _numbers(np.frombuffer(raw, np.uint8).reshape(rows, -1), columns, layout)


def _numbers(raw: NDArray[np.uint8], columns: int, layout: Layout) -> NDArray[Any]:
    """Return the numbers of rows of bytes, their differences summed."""
    shape = (len(raw), columns, layout.channels)
    if layout.kind == "b1":
        return np.unpackbits(raw, axis=1)[:, : columns * layout.channels].reshape(shape)
    if layout.predictor == FLOATING:
        steps = raw.reshape(len(raw), -1, layout.channels)
        planes = np.cumsum(steps, axis=1, dtype=np.uint8).reshape(len(raw), layout.size, -1)
        apart = np.ascontiguousarray(planes.transpose(0, 2, 1))  # the highest bytes come first
        return apart.view(f">{layout.kind}").astype(layout.kind).reshape(shape)
    if layout.predictor == HORIZONTAL:
        whole = f"u{layout.size}"
        steps = raw.view(f"{layout.order}{whole}").reshape(shape)
        return np.cumsum(steps, axis=1, dtype=whole).view(layout.kind)
    return raw.view(f"{layout.order}{layout.kind}").astype(layout.kind).reshape(shape)


def _by_libtiff(chunk: bytes, rows: int, columns: int, compression: int) -> bytes:
    """Return `rows` times `columns` bytes that Pillow's libtiff unpacks.

    It is given a little-endian TIFF file that has `chunk` as its only strip, of numbers of 8 bits without a
    predictor, so that it does nothing but unpack.
    """
    from PIL.TiffImagePlugin import TiffImageFile

    short, long, one_channel, whole = 3, 4, 1, 1
    tags = (
        (256, long, columns),
        (257, long, rows),
        (258, short, 8),
        (259, short, compression),
        (262, short, 1),
        (273, long, 8),
        (277, short, one_channel),
        (278, long, rows),
        (279, long, len(chunk)),
        (339, short, whole),
    )
    even = chunk + b"\0" * (len(chunk) % 2)
    entries = b"".join(struct.pack("<HHII", number, form, 1, value) for number, form, value in tags)
    head = struct.pack("<2sHI", b"II", 42, 8 + len(even))
    image = TiffImageFile(io.BytesIO(head + even + struct.pack("<H", len(tags)) + entries + b"\0" * 4))
    return bytes(image.tobytes())


def is_built(compression: int) -> bool:
    """Whether the libtiff of this machine's Pillow unpacks `compression`."""
    from PIL import Image

    words = {LZMA: "lzma", ZSTD: "zstd"}
    try:
        if compression in words:
            Image.new("L", (1, 1)).save(io.BytesIO(), "TIFF", compression=words[compression])
    except (OSError, RuntimeError, ValueError, KeyError):
        return False
    return True
