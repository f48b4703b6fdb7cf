"""What a run has written up to its checkpoint, so that a resume notices what has changed since.

A checkpoint is written as a whole and checked as a whole; what it says of the other files needs no checksum
of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

_FRAMES, _NAMES, _TABLES = "inventory.frames", "inventory.table_names", "inventory.tables"


@dataclass
class Inventory:
    """Hold marks of files.

    Attributes:
        frames: mark of each frame file (see `neve.io.npz.mark_of`), by its number
        tables: number of rows and CRC-32 of each table (see `neve.io.table.Table.mark`), by its name
    """

    frames: dict[int, int] = field(default_factory=dict)
    tables: dict[str, tuple[int, int]] = field(default_factory=dict)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the inventory as arrays."""
        return {
            _FRAMES: np.array(sorted(self.frames.items()), np.int64).reshape(-1, 2),
            _NAMES: np.array(sorted(self.tables), np.str_),
            _TABLES: np.array([self.tables[name] for name in sorted(self.tables)], np.int64).reshape(-1, 2),
        }

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Inventory | None:
        """Return the inventory among `arrays`, None if there is none. Errors: ValueError."""
        if _FRAMES not in arrays:
            return None
        frames, names, tables = arrays[_FRAMES], arrays[_NAMES], arrays[_TABLES]
        if frames.dtype != np.int64 or tables.dtype != np.int64 or names.shape != (len(tables),):
            raise ValueError("its inventory")
        return cls(
            {int(number): int(mark) for number, mark in frames},
            {str(name): (int(size), int(crc)) for name, (size, crc) in zip(names, tables, strict=True)},
        )
