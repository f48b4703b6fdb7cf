"""PLY: a file of points for each frame, binary, with any fields.

The format is that of Turk (1994): a header in ASCII, then the rows of the elements in their order.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.export.format import Format, replacing
from neve.export.moment import Moment

CHUNK = 2**16
"""Particles that are put in order at once."""
_TYPES = {"f4": "float", "u4": "uint", "i4": "int"}
AXES = ("x", "y", "z")


class Ply(Format):
    """Write `snow_NNNNNN.ply`: x, y, z, then a property for each number of each field.

    The velocity is vx, vy, vz; another vector such as `a` is a_x, a_y, a_z, a matrix a_xx, a_xy ... a_zz.
    Whole numbers have 4 bytes: the format has no longer ones, and some programs read no shorter ones.
    """

    ending = "ply"

    def write(self, moment: Moment) -> None:
        """Write the file of a frame."""
        columns = [*zip(AXES, moment.x.T, strict=True)]
        for name, values in moment.fields.items():
            columns += _numbers(name, values)
        layout = np.dtype([(name, _kind(values)) for name, values in columns])
        with replacing(self.path(self.names(moment.frame)[0])) as file:
            file.write(_header(moment, layout).encode("ascii"))
            for first in range(0, len(moment.x), CHUNK):
                some = slice(first, first + CHUNK)
                rows = np.empty(len(moment.x[some]), layout)
                for name, values in columns:
                    rows[name] = values[some]
                file.write(rows.tobytes())


def _header(moment: Moment, layout: np.dtype[Any]) -> str:
    """Return the lines before the rows."""
    properties = [f"property {_TYPES[layout[name].str[1:]]} {name}" for name in layout.names or ()]
    return "\n".join(
        [
            "ply",
            "format binary_little_endian 1.0",
            "comment Neve: metres and seconds unless scaled",
            f"comment time {moment.time!r}",
            f"element vertex {len(moment.x)}",
            *properties,
            "end_header\n",
        ]
    )


def _kind(values: NDArray[Any]) -> str:
    """Return the type of a property that holds these values."""
    if values.dtype.kind == "f":
        return "<f4"
    return "<u4" if values.dtype.kind == "u" else "<i4"


def _numbers(name: str, values: NDArray[Any]) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield name and column of each number of a field."""
    if values.ndim == 1:
        yield name, values
    elif values.ndim == 2:
        for i, axis in enumerate(AXES):
            yield f"v{axis}" if name == "v" else f"{name}_{axis}", values[:, i]
    else:
        for i, row in enumerate(AXES):
            for j, column in enumerate(AXES):
                yield f"{name}_{row}{column}", values[:, i, j]
