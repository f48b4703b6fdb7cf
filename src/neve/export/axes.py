"""The axes and the unit of length that a file has, and how the world's become them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import product

Floats = NDArray[np.float32]
Up = Literal["y", "z"]

_TURNS = {"z": np.eye(3), "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])}
"""R of x' = s R x; with y up, x stays, and what was y points away from the viewer."""


@dataclass(frozen=True)
class Axes:
    """Turn the world's axes (z up) into those of a file, and metres into its unit: x' = s R x.

    up: the axis of the file that points up. scale: s, units of the file in a metre
    """

    up: Up = "z"
    scale: float = 1.0

    @property
    def turn(self) -> NDArray[np.float64]:
        """R, (3, 3)."""
        return _TURNS[self.up]

    def lengths(self, x: NDArray[Any]) -> Floats:
        """Return positions or velocities (n, 3) as the file has them: s R x."""
        turned = self.directions(x)
        return turned if self.scale == 1.0 else turned * np.float32(self.scale)

    def directions(self, x: NDArray[Any]) -> Floats:
        """Return vectors (n, 3) without a length: R x."""
        x = np.asarray(x, np.float32)
        return x if self.up == "z" else x[:, [0, 2, 1]] * np.array([1, 1, -1], np.float32)

    def tensors(self, a: NDArray[Any]) -> Floats:
        """Return matrices (n, 3, 3) in the axes of the file: R A R^T."""
        a = np.asarray(a, np.float32)
        if self.up == "z":
            return a
        sign = np.array([1, 1, -1], np.float32)
        return np.asarray(a[:, [0, 2, 1]][:, :, [0, 2, 1]] * (sign[:, None] * sign))

    def pose(self, position: NDArray[Any], rotation: NDArray[Any]) -> NDArray[np.float64]:
        """Return the matrix (4, 4) from a solid's own axes, its lengths scaled already, to the file's.

        position (3,) [m], rotation (3, 3): of the solid in the world. Points are columns.
        """
        matrix = np.eye(4)
        matrix[:3, :3] = product(self.turn, np.asarray(rotation, np.float64))
        matrix[:3, 3] = self.scale * product(self.turn, np.asarray(position, np.float64))
        return matrix
