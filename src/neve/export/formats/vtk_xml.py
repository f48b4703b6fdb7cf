"""The XML files of VTK: arrays in binary behind a description.

The format is that of "VTK XML file formats" (docs.vtk.org).
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, BinaryIO
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

CHUNK = 2**22
"""Bytes that are written at once, or compressed as one block."""
_TYPES = {"f4": "Float32", "f8": "Float64", "u1": "UInt8", "u2": "UInt16", "u4": "UInt32", "u8": "UInt64"}
_TYPES |= {"i4": "Int32", "i8": "Int64"}
_COMPRESSOR = ' compressor="vtkZLibDataCompressor"'


def at(time: float) -> str:
    """Return the element that tells ParaView the time [s] of a file."""
    kind = 'type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii"'
    return f"<FieldData><DataArray {kind}>{time!r}</DataArray></FieldData>"


def collection(files: Mapping[str, float]) -> str:
    """Return the content of a .pvd file: times [s] of files, by name."""
    rows = [f'<DataSet timestep="{time!r}" part="0" file={quoteattr(name)}/>' for name, time in files.items()]
    head = '<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">'
    return "\n".join(['<?xml version="1.0"?>', head, "<Collection>", *rows, "</Collection>", "</VTKFile>\n"])


class Appended:
    """Collect arrays, which come behind the description in binary, each after its length in 8 bytes.

    compress: whether they are compressed, in blocks; before each array stand then, in 8 bytes each, the
    number of its blocks, their size, that of the last one if it is smaller (else 0), and their sizes when
    compressed.
    """

    def __init__(self, compress: bool = False) -> None:
        self._compress = compress
        self._arrays: list[NDArray[Any] | list[bytes]] = []
        self._end = 0

    def add(self, name: str, values: NDArray[Any]) -> str:
        """Take an array, a row for each tuple; return the element that describes it."""
        shape = f'NumberOfComponents="{int(np.prod(values.shape[1:], dtype=int))}"'
        element = f'<DataArray type="{_TYPES[values.dtype.str[1:]]}" Name={quoteattr(name)} {shape}'
        element += f' format="appended" offset="{self._end}"/>'
        if self._compress:
            parts = _compressed(values)
            self._arrays.append(parts)
            self._end += sum(map(len, parts))
        else:
            self._arrays.append(values)
            self._end += 8 + values.nbytes
        return element

    def write(self, file: BinaryIO, type: str, attributes: str, inner: Sequence[str]) -> None:
        """Write a whole file of a data set of this type, described by its attributes and inner elements."""
        head = f'<VTKFile type="{type}" version="1.0" byte_order="LittleEndian" header_type="UInt64"'
        lines = ['<?xml version="1.0"?>', f"{head}{_COMPRESSOR if self._compress else ''}>"]
        lines += [f"<{type}{attributes}>", *inner, f"</{type}>", '<AppendedData encoding="raw">', "_"]
        file.write("\n".join(lines).encode())
        for values in self._arrays:
            if isinstance(values, list):
                file.writelines(values)
            else:
                file.write(np.uint64(values.nbytes).tobytes())
                file.writelines(_chunks(values))
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def _chunks(values: NDArray[Any]) -> Iterator[bytes]:
    step = max(1, CHUNK // max(1, values.nbytes // max(1, len(values))))
    for first in range(0, len(values), step):
        yield np.ascontiguousarray(values[first : first + step]).tobytes()


def _compressed(values: NDArray[Any]) -> list[bytes]:
    """Return the head and the compressed blocks of an array."""
    sizes, parts = [], []
    for block in _chunks(values):
        sizes.append(len(block))
        parts.append(zlib.compress(block, 1))
    usual = sizes[0] if sizes else 0
    last = sizes[-1] if sizes and sizes[-1] != usual else 0
    head = np.array([len(parts), usual, last, *map(len, parts)], "<u8")
    return [head.tobytes(), *parts]
