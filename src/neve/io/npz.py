"""Write and read .npz archives: what `np.load` opens, the same bytes for the same arrays."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray


def write_npz(file: BinaryIO, arrays: Mapping[str, Any]) -> None:
    """Write named arrays, uncompressed, into an open file.

    `np.savez` leaves its archive open when the disk is full and complains later from a destructor; here the
    error reaches the caller at once and nothing else is printed.
    """
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for name, value in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(value), allow_pickle=False)


def read_npz(path: Path) -> dict[str, NDArray[Any]]:
    """Read all arrays of an archive, checking every byte against its checksum.

    Errors: OSError if the file cannot be opened; ValueError if it is no whole archive of arrays.
    """
    with open(path, "rb") as file:
        try:
            with np.load(file, allow_pickle=False) as archive:
                return {name: archive[name] for name in archive.files}
        except (zipfile.BadZipFile, EOFError, KeyError, AttributeError, NotImplementedError) as error:
            raise ValueError(str(error)) from error
