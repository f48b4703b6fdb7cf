"""Real numbers as float16, and whole numbers in runs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

_SCALE, _VALUES, _COUNTS = "_scale", "_values", "_counts"
"""Ends of the names of arrays that belong to another one."""
_MOST = float(np.finfo(np.float16).max)


def shortened(name: str, values: NDArray[Any]) -> dict[str, NDArray[Any]] | None:
    """Return the arrays that stand for the column `name`, (n, ...); None if a number of it is not finite.

    The error of a real number is at most 2^-11 of it, or 2^-25 times the scale of its column, whichever is
    larger; whole numbers are exact.
    """
    if values.dtype.kind == "f":
        return _halved(name, values) if np.isfinite(values).all() else None
    return _in_runs(name, values) if values.dtype.kind in "iu" and values.ndim == 1 else {name: values}


def take_columns(arrays: dict[str, NDArray[Any]], n: int) -> dict[str, NDArray[Any]]:
    """Return the columns, of n rows, whose arrays `shortened` returned; others as they are.

    Errors: ValueError, KeyError or TypeError for arrays that it does not return.
    """
    left, out = dict(arrays), {}
    for name in [name for name in left if name.endswith(_COUNTS)]:
        whole = name.removesuffix(_COUNTS)
        out[whole] = _from_runs(whole, left.pop(whole + _VALUES), left.pop(name), n)
    if alone := [name for name in left if name.endswith(_VALUES)]:
        raise ValueError(f"{alone[0]} has no counts")
    for name in [name for name in left if name.endswith(_SCALE)]:
        halved = name.removesuffix(_SCALE)
        out[halved] = left.pop(halved).astype(np.float32) * np.float32(left.pop(name))
    for name, values in left.items():
        out[name] = values.astype(np.float32) if values.dtype == np.float16 else values
    return out


def _halved(name: str, values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Return real numbers as float16, and their scale, a power of two, where they are too large for that."""
    top = float(np.abs(values).max(initial=0.0))
    if top <= _MOST:
        return {name: values.astype(np.float16)}
    scale = 2.0 ** math.ceil(math.log2(top / _MOST))
    halves = (values.astype(np.float64) / scale).astype(np.float16)
    return {name: halves, name + _SCALE: np.asarray(np.float64(scale))}


def _step(name: str) -> int:
    """Return by how much whole numbers grow from particle to particle within a run: names count on."""
    return int(name == "id")


def _in_runs(name: str, values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Return whole numbers as runs, the first of each and how many there are, if that is shorter."""
    rises = np.diff(values.astype(np.int64)) != _step(name)
    first = np.flatnonzero(np.concatenate([np.ones(min(len(values), 1), np.bool_), rises]))
    counts = np.diff(first, append=len(values)).astype(np.uint32)
    if len(first) * (values.itemsize + counts.itemsize) >= values.nbytes:
        return {name: values}
    return {name + _VALUES: values[first], name + _COUNTS: counts}


def _from_runs(name: str, values: NDArray[Any], counts: NDArray[Any], n: int) -> NDArray[Any]:
    """Return the whole numbers, (n,), of which these are the runs. Errors: ValueError."""
    kinds = values.dtype.kind in "iu" and counts.dtype.kind == "u"
    if not kinds or values.ndim != 1 or values.shape != counts.shape or int(counts.sum(dtype=np.uint64)) != n:
        raise ValueError(f"{name} is not in runs")
    out = np.repeat(values, counts)
    if _step(name) and n:
        within = np.arange(n) - np.repeat(np.cumsum(counts) - counts, counts)
        numbers = out.astype(np.int64) + within
        if numbers.max() > np.iinfo(values.dtype).max:
            raise ValueError(f"{name} is beyond its numbers")
        out = numbers.astype(values.dtype)
    return out
