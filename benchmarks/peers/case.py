"""What a peer is given of the snow: particles, grid, constants. A file takes it to the peer's environment."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

J_P_BOUNDS = (0.6, 20.0)  # of J_P inside the hardening exponent, as in Neve
ARRAYS = ("x", "v", "m", "V0", "low")


@dataclass(frozen=True)
class Case:
    """Hold what a run needs; arrays are float32, lengths in metres."""

    x: np.ndarray  # (n, 3) positions [m]
    v: np.ndarray  # (n, 3) velocities [m/s]
    m: np.ndarray  # (n,) masses [kg]
    V0: np.ndarray  # (n,) initial volumes [m3]
    low: np.ndarray  # (3,) index of the first node of the dense grid
    shape: tuple[int, int, int]  # nodes of the dense grid
    cells: tuple[int, int, int]  # size of the block
    dx: float  # [m]
    dt: float  # [s]
    rho0: float  # [kg/m3]
    E0: float  # [Pa]
    nu: float  # [1]
    xi: float  # [1]
    theta_c: float  # [1]
    theta_s: float  # [1]
    gravity: float  # along z [m/s2]
    mu_c: float  # friction of the ground z = 0 [1]

    def save(self, path: Path) -> None:
        """Write the case to a file of NumPy arrays."""
        numbers = {name: value for name, value in asdict(self).items() if name not in ARRAYS}
        np.savez(path, numbers=json.dumps(numbers), **{name: getattr(self, name) for name in ARRAYS})

    @classmethod
    def load(cls, path: Path | str) -> Case:
        """Return the case of a file."""
        with np.load(path) as file:
            values: dict[str, Any] = json.loads(str(file["numbers"]))
            values |= {name: file[name] for name in ARRAYS}
        for name in ("shape", "cells"):
            values[name] = tuple(values[name])
        return cls(**{field.name: values[field.name] for field in fields(cls)})

    def by_rows(self) -> np.ndarray:
        """Return the rows of the particles in the order of the grid's rows, which suits a cache."""
        cell = np.floor(self.x / self.dx - 0.5).astype(np.int64) - self.low
        return np.lexsort((cell[:, 2], cell[:, 1], cell[:, 0]))
