"""Positions in 16 bits an axis within their block of the grid."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

STEPS = 65536
"""Places along the edge of a block."""
DEFLATED = ("x_block",)
"""Arrays that compress well in little time."""

_ARRAYS = ("x_edge", "x_blocks", "x_block", "x_in_block")
_FARTHEST = 2**31 - 2
"""Number of the farthest block along an axis."""
_FEW = 2**20
"""Blocks of a box that is looked at whole, however few particles there are."""


def placed(x: NDArray[Any], edge: float) -> dict[str, NDArray[Any]] | None:
    """Return positions x [m], (n, 3), as places in blocks of the `edge` [m]; None if some have no block.

    The error is at most edge / 2 / STEPS along each axis, besides that of a float32.
    """
    if not np.isfinite(x).all() or np.abs(x).max(initial=0.0) >= edge * _FARTHEST:
        return None
    place = np.empty((len(x), 3), np.uint16)
    block = np.empty((3, len(x)), np.int64)
    for axis in range(3):
        at = x[:, axis].astype(np.float64) / edge
        whole = np.floor(at)
        block[axis] = whole
        place[:, axis] = np.minimum((at - whole) * STEPS, STEPS - 1)
    blocks, number = _numbered(block)
    return dict(zip(_ARRAYS, (np.asarray(np.float64(edge)), blocks, number, place), strict=True))


def is_placed(arrays: Mapping[str, NDArray[Any]]) -> bool:
    """Return whether among `arrays` are those of `placed`."""
    return _ARRAYS[-1] in arrays


def take_positions(arrays: dict[str, NDArray[Any]]) -> NDArray[np.float32]:
    """Take the arrays of `placed` out of `arrays` and return the positions [m], (n, 3).

    Errors: ValueError for arrays that are no places in blocks; KeyError if one is missing.
    """
    edge, blocks, number, place = (arrays.pop(name) for name in _ARRAYS)
    n = len(place)
    kinds = edge.dtype.kind + blocks.dtype.kind + number.dtype.kind
    shapes = (edge.shape, blocks.shape, number.shape, place.shape)
    if kinds != "fiu" or place.dtype != np.uint16 or shapes != ((), (len(blocks), 3), (n,), (n, 3)):
        raise ValueError("its positions are no places in blocks")
    if not 0.0 < float(edge) < math.inf or int(number.max(initial=0)) >= max(len(blocks), 1):
        raise ValueError("its positions are in no block")
    x = np.empty((n, 3), np.float32)
    for axis in range(3):
        x[:, axis] = (blocks[:, axis].take(number) + (place[:, axis] + 0.5) / STEPS) * float(edge)
    return x


def _numbered(block: NDArray[np.int64]) -> tuple[NDArray[np.int32], NDArray[Any]]:
    """Return the blocks that occur, (b, 3), and of each column of `block` (3, n) the row among them, (n,)."""
    n = block.shape[1]
    if not n:
        return np.zeros((0, 3), np.int32), np.zeros(0, np.uint16)
    low = block.min(axis=1)
    extent = [int(size) for size in block.max(axis=1) - low + 1]
    size = math.prod(extent)
    if size > np.iinfo(np.int64).max:
        rows, number = np.unique(block.T, axis=0, return_inverse=True)
        return rows.astype(np.int32), _short(number.reshape(-1), len(rows))
    key = ((block[0] - low[0]) * extent[1] + (block[1] - low[1])) * extent[2] + (block[2] - low[2])
    if size > max(_FEW, 8 * n):
        found, number = np.unique(key, return_inverse=True)
    else:
        there = np.zeros(size, np.bool_)
        there[key] = True
        found = np.flatnonzero(there)
        numbers = np.empty(size, np.uint32)
        numbers[found] = np.arange(len(found), dtype=np.uint32)
        number = numbers[key]
    y, z = extent[1], extent[2]
    rows = np.stack([found // (y * z), found // z % y, found % z], axis=1) + low
    return rows.astype(np.int32), _short(number, len(rows))


def _short(number: NDArray[Any], count: int) -> NDArray[Any]:
    return number.astype(np.uint16 if count <= STEPS else np.uint32, copy=False)
