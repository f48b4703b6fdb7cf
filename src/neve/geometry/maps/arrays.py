"""Read heights or a mask from an array of NumPy."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from neve.geometry.maps.found import Map, full_range, require_size, unreadable
from neve.scene.errors import SceneError


def read_array(path: Path, key: str, kinds: str = "iuf") -> Map:
    """Read the array heights[x, y] of an NPY file.

    `key`: begin of sentences; `kinds`: of numbers that are read, by their letters in NumPy.

    Errors: SceneError, one sentence.
    """
    try:
        with warnings.catch_warnings():  # a header may promise more than there is: mapped, it is noticed
            warnings.simplefilter("ignore")
            values = np.load(path, mmap_mode="r", allow_pickle=False)
    except Exception as error:  # whatever a damaged file makes its reader stumble over
        raise unreadable(key, error) from None
    if not isinstance(values, np.ndarray) or values.dtype.kind not in kinds:
        raise SceneError(f"{key} holds no numbers: a map is an array of whole or real numbers")
    require_size(values.size, "heights", key)
    bits = 8 * values.dtype.itemsize if values.dtype.kind in "iu" else 32
    return Map(values.astype(np.float64), full_range(bits))


def read_flags(path: Path, key: str) -> Map:
    """Read the array mask[x, y] of an NPY file: numbers, or true and false.

    `key`: begin of sentences.

    Errors: SceneError, one sentence.
    """
    return read_array(path, key, "biuf")
