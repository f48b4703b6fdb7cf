"""Choose the reader of a file of heights or of a mask."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from neve.geometry.maps.arrays import read_array, read_flags
from neve.geometry.maps.ascii_grid import read_ascii_grid
from neve.geometry.maps.found import Map
from neve.geometry.maps.hgt import read_hgt
from neve.geometry.maps.pictures import read_grey, read_picture
from neve.geometry.maps.tiff import read_bits, read_tiff
from neve.scene.schema.file_shapes import MAPS, MASKS

Reader = Callable[[Path, str], Map]

READERS: dict[str, Reader] = {
    ".png": read_picture,
    ".tif": read_tiff,
    ".tiff": read_tiff,
    ".asc": read_ascii_grid,
    ".hgt": read_hgt,
    ".npy": read_array,
}
assert set(READERS) == set(MAPS)
assert set(READERS) > set(MASKS)
OF_MASKS: dict[Reader, Reader] = {
    read_picture: read_grey,
    read_tiff: read_bits,
    read_array: read_flags,
}
"""Readers of masks in place of those of heights."""
PICTURES = (".png", ".tif", ".tiff")
PNG, TIFF = b"\x89PNG\r\n\x1a\n", (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
"""How such files begin (PNG; TIFF 6.0 and BigTIFF in both orders of bytes)."""


def read_map(path: Path, key: str) -> Map:
    """Read a file of heights.

    `key`: begin of sentences.

    Errors: SceneError, one sentence.
    """
    return _reader(path)(path, key)


def read_mask(path: Path, key: str) -> Map:
    """Read a file of a mask: as heights are, and pictures in colours by their brightness.

    `key`: begin of sentences.

    Errors: SceneError, one sentence.
    """
    reader = _reader(path)
    return OF_MASKS.get(reader, reader)(path, key)


def _reader(path: Path) -> Reader:
    """Return the reader of a file, by its ending; of pictures, by what they are whatever they are called."""
    suffix = path.suffix.lower()
    if suffix in PICTURES:
        try:
            with path.open("rb") as file:
                begin = file.read(8)
        except OSError:  # told by the reader
            begin = b""
        if begin == PNG or begin[:4] in TIFF:
            return read_picture if begin == PNG else read_tiff
    return READERS[suffix]
