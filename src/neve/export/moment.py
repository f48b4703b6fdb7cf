"""A moment of a run as a file gets it: particles, their fields and solids, in the axes of the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.export.axes import Axes
from neve.io.errors import RunError
from neve.io.frames import Frame, Life
from neve.spelling import hint, nearest

Floats = NDArray[np.float32]

USUAL = ("v", "J_P", "id", "material")
"""Fields of a frame that an export has unless others are asked for, as far as the run has them."""
_LENGTHS = ("v",)
"""Vector fields that are lengths, or lengths in a time."""
_SHAPES = ((), (3,), (6,), (3, 3))
"""Of a row of a field: a number, a vector, a symmetric matrix, a matrix."""
_SYMMETRIC = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])
"""Where the numbers xx, yy, zz, xy, xz, yz of a symmetric matrix stand in it."""


@dataclass(frozen=True)
class Moment:
    """Hold a moment, in the axes and the unit of length of the file.

    Attributes:
        frame: its number. time: [s]
        x, v: positions and velocities, (n, 3)
        id: names of the particles, (n,)
        fields: what is asked for, by name: (n,), (n, 3), or matrices (n, 3, 3)
        mass: of each particle [kg] (n,), where the format needs it; else empty
        poses: of each solid, matrices (4, 4), see `Axes.pose`
    """

    frame: int
    time: float
    x: Floats
    v: Floats
    id: NDArray[Any]
    fields: Mapping[str, NDArray[Any]]
    mass: NDArray[Any] = field(default_factory=lambda: np.zeros(0))
    poses: Sequence[NDArray[np.float64]] = ()


def columns_of(content: Frame) -> dict[str, NDArray[Any]]:
    """Return the fields that a frame has, by name: numbers, vectors and matrices."""
    found = {name: getattr(content, name) for name in USUAL}
    there = {name: values for name, values in found.items() if values is not None}
    return there | {name: values for name, values in content.more.items() if values.shape[1:] in _SHAPES}


def moment_of(
    number: int, content: Frame, axes: Axes, names: Sequence[str], life: Life | None, weigh: bool
) -> Moment:
    """Return frame `number` with the fields `names`, those of `life` among them.

    weigh: whether the mass is needed. Errors: RunError if the frame lacks a field.
    """
    have = columns_of(content)
    fields: dict[str, NDArray[Any]] = {}
    for name in names:
        if name in have:
            fields[name] = turned(name, have[name], axes)
        elif life is not None and name in life.columns:
            fields[name] = life.of(name, content.id)
        else:
            raise RunError(f"frame {number} has no {name}.")
    poses = zip(content.solid_position, content.solid_rotation, strict=True)
    return Moment(
        number,
        content.time,
        axes.lengths(content.x),
        fields["v"] if "v" in fields else axes.lengths(content.v),
        content.id,
        fields,
        _mass(have, content, life) if weigh else np.zeros(0),
        [axes.pose(position, rotation) for position, rotation in poses],
    )


def _mass(have: Mapping[str, NDArray[Any]], content: Frame, life: Life | None) -> NDArray[Any]:
    """Return the mass of the particles of a frame (n,), its own or the checkpoint's. Errors: RunError."""
    if "m" in have:
        return have["m"]
    return np.zeros(0) if life is None else life.of("m", content.id)


def turned(name: str, values: NDArray[Any], axes: Axes) -> NDArray[Any]:
    """Return a field in the axes of the file; numbers, names and directions of material stay as they are."""
    if values.ndim == 3:
        return axes.tensors(values)
    if values.ndim == 2 and values.shape[1] == 6:
        return axes.tensors(values[:, _SYMMETRIC])
    if values.ndim == 2:
        return axes.lengths(values) if name in _LENGTHS else axes.directions(values)
    return values


def check_names(asked: Sequence[str], known: Sequence[str], where: str) -> None:
    """Refuse a field that is not known. Errors: RunError, one sentence that begins with `where`."""
    for name in asked:
        if name not in known:
            raise RunError(
                f"{where}: there is no field {name}"
                f"{hint(nearest(name, known), 'this run has ' + ', '.join(known))}."
            )
