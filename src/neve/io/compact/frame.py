"""The arrays of a compact frame. docs/run_folder.md describes them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from numpy.typing import NDArray

from neve.io.compact.numbers import shortened, take_columns
from neve.io.compact.places import is_placed, placed, take_positions

Arrays = Mapping[str, NDArray[Any]]


def packed(arrays: Arrays, edge: float, exact: Collection[str]) -> dict[str, NDArray[Any]] | None:
    """Return the compact arrays of a frame; None if a number of it is not finite, or too far away.

    arrays: of a frame, by name, each with a row for a particle, but those that are `exact`
    edge: of a block [m]
    """
    parts = [placed(arrays["x"], edge)]
    parts += [shortened(name, values) for name, values in arrays.items() if name not in ("x", *exact)]
    out = {name: values for name, values in arrays.items() if name in exact}
    for part in parts:
        if part is None:
            return None
        out |= part
    return out


def unpacked(arrays: Arrays) -> dict[str, NDArray[Any]]:
    """Return the arrays of a frame as a plain file has them; they may be plain already.

    Errors: ValueError, KeyError or TypeError for what is no compact frame.
    """
    left = dict(arrays)
    if not is_placed(left):
        return left
    x = take_positions(left)
    return {"x": x, **take_columns(left, len(x))}
