"""Write and read .npz archives: what `np.load` opens, the same bytes for the same arrays.

The archive carries a CRC-32 of each array, header and values, so damage is noticed when it is read. Nothing
in a file is believed before that: neither a size, so that a small file cannot fill the memory, nor a header.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from neve.system import disk

MOST_RATIO = 64
"""Bytes of arrays for each byte of file that are believed. Neve compresses hardly; who does gets less."""
_CHUNK = 2**20
_PIECE = 2**22
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def write_npz(file: BinaryIO, arrays: Mapping[str, Any], deflated: Collection[str] = ()) -> int:
    """Write named arrays into an open file; return the mark of the archive (see `mark_of`).

    deflated: names of those that are compressed, in little time

    `np.savez` leaves its archive open when the disk is full and complains later from a destructor; here the
    error reaches the caller at once and nothing else is printed.
    """
    with zipfile.ZipFile(file, "w", compresslevel=1) as archive:
        for name, value in arrays.items():
            archive.compression = zipfile.ZIP_DEFLATED if name in deflated else zipfile.ZIP_STORED
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                _write_array(member, np.asanyarray(value))
        return _mark(archive.infolist())


def _write_array(file: IO[bytes], array: NDArray[Any]) -> None:
    """Write what `np.lib.format.write_array` does, without a copy of an array that lies in one piece."""
    whole = next((a for a in (array, array.T) if a.flags.c_contiguous), None)
    if whole is None or not array.size or array.dtype.hasobject or array.dtype.kind not in "biufc":
        np.lib.format.write_array(file, array, allow_pickle=False)
        return
    np.lib.format.write_array_header_1_0(file, np.lib.format.header_data_from_array_1_0(array))
    data = whole.reshape(-1).view(np.uint8).data
    for start in range(0, len(data), _PIECE):
        file.write(data[start : start + _PIECE])


def read_npz(path: Path) -> dict[str, NDArray[Any]]:
    """Read all arrays of an archive, checking every byte against its checksum.

    Errors: OSError if the file cannot be opened; ValueError if it is no whole archive of arrays.
    """
    with disk.open_regular(path) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                members = archive.infolist()
                _believe(members, file)
                return {member.filename[:-4]: _array(_content(archive, member)) for member in members}
        except Exception as error:  # whatever a damaged file makes its reader stumble over
            raise ValueError(str(error)) from error


def mark_of(path: Path) -> int | None:
    """Return a number that tells archives with other arrays apart; None for a file that is no archive.

    It is a CRC-32 of the names, sizes and CRC-32 of the arrays, which stand at the end of the file, so that
    it costs little. Errors: OSError if the file cannot be opened.
    """
    with disk.open_regular(path) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                return _mark(archive.infolist())
        except Exception:  # as above
            return None


def _mark(members: Iterable[zipfile.ZipInfo]) -> int:
    facts = [(member.filename, member.file_size, member.CRC) for member in members]
    return zlib.crc32(repr(facts).encode())


def _believe(members: list[zipfile.ZipInfo], file: BinaryIO) -> None:
    """Refuse an archive that says to hold more than it can, or something else than arrays."""
    size = file.seek(0, io.SEEK_END)
    if sum(member.file_size for member in members) > MOST_RATIO * size:
        raise ValueError("larger than any archive of its size")
    names = {member.filename for member in members}
    if len(names) < len(members) or not all(name.endswith(".npy") for name in names):
        raise ValueError("not an archive of arrays")
    if any(member.compress_type not in _METHODS for member in members):
        raise ValueError("compressed by a method that is not read")


def _content(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytearray:
    """Return the bytes of a member. Reading a little at a time keeps a wrong size from filling the memory."""
    content = bytearray(member.file_size)
    view, end = memoryview(content), 0
    with archive.open(member) as file:
        while part := file.read(_CHUNK):
            view[end : end + len(part)] = part  # a ValueError if there is more
            end += len(part)
    if end != len(content):
        raise ValueError("cut short")
    return content


def _array(content: bytearray) -> NDArray[Any]:
    """Return the array whose .npy file has these bytes, as a view of them."""
    head = io.BytesIO(content[: 2**16])
    version = np.lib.format.read_magic(head)
    read = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}[version]
    shape, is_fortran, dtype = read(head)
    count = 1
    for length in shape:
        count *= length
    start = head.tell()
    if dtype.hasobject or min(shape, default=0) < 0 or len(content) - start != count * dtype.itemsize:
        raise ValueError("its size is not that of its array")
    if not count or not dtype.itemsize:
        return np.zeros(shape, dtype)
    values = np.frombuffer(content, dtype, count, start)
    return values.reshape(shape[::-1]).T if is_fortran else values.reshape(shape)
