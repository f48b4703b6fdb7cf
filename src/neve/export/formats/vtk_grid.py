"""Density and velocity on a box of cells as a VTK image, for slices, contours and volume rendering."""

from __future__ import annotations

import math
from pathlib import Path

from neve.export.format import replacing
from neve.export.formats.vtk_xml import Appended, at
from neve.export.grid import snow_grid
from neve.export.moment import Moment

MOST_CELLS = 2**24
"""Cells of the box at most; a wider spread of snow gets cells twice as large, or four times ..."""


def fitting(moment: Moment, cell: float) -> float:
    """Return the size of cells of which at most MOST_CELLS fill the box around the snow: `cell` times 2^k."""
    if not len(moment.x):
        return cell
    size = (moment.x.max(axis=0) - moment.x.min(axis=0)).astype(float)
    while math.prod(float(length) / cell + 8 for length in size) > MOST_CELLS:
        cell *= 2
    return cell


def write_image(path: Path, moment: Moment, cell: float, scale: float) -> None:
    """Write a .vti file: `density` [kg/m3] and `velocity` [units/s] at centres of cells. Errors: RunError."""
    size = fitting(moment, cell)
    density, velocity, first = snow_grid(moment, size, scale).dense()
    body = Appended(compress=True)
    extent = " ".join(f"0 {n - 1}" for n in density.shape)
    rows = [
        at(moment.time),
        f'<Piece Extent="{extent}">',
        '<PointData Scalars="density" Vectors="velocity">',
        body.add("density", density.T.reshape(-1)),  # x runs fastest
        body.add("velocity", velocity.transpose(2, 1, 0, 3).reshape(-1, 3)),
        "</PointData>",
        "<CellData/>",
        "</Piece>",
    ]
    origin = " ".join(repr(float(c)) for c in first)
    where = f' WholeExtent="{extent}" Origin="{origin}" Spacing="{size!r} {size!r} {size!r}"'
    with replacing(path) as file:
        body.write(file, "ImageData", where, rows)
