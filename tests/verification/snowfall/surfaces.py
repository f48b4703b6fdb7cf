"""Surfaces for snow to fall on."""

import numpy as np

from neve import _core
from neve.snowfall.surroundings import joined

FAR = 200.0


def plate(name, kind, x0, x1, y0, y1, z, slope=(0.0, 0.0)):
    """A rectangle at the height z over x = y = 0, seen from above."""
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float)
    heights = z + corners @ np.array(slope)
    return name, kind, np.column_stack([corners, heights]), np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def ground(z=0.0, slope=(0.0, 0.0)):
    """Ground without end."""
    return plate("ground", "ground", -FAR, FAR, -FAR, FAR, z, slope)


def box(low, high, name="box"):
    """A closed box between two corners."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))], np.int32)
    low, high = np.array(low, float), np.array(high, float)
    return name, "closed", low + corners * (high - low), faces


def columns_of(pieces, raster):
    """The places of `pieces` over a raster, and what joins them."""
    around = joined(pieces)
    columns = _core.snowfall.Columns(
        raster.low,
        raster.cell,
        (raster.nx, raster.ny),
        around.vertices,
        around.faces,
        around.part,
        list(around.kinds),
    )
    return columns, around


def places(columns, raster):
    """x and y of the middle of each place's cell, (n,) each."""
    i, j = np.divmod(columns.column(), raster.ny)
    return raster.low[0] + (i + 0.5) * raster.cell, raster.low[1] + (j + 0.5) * raster.cell


def counted(pieces, raster, flutter=0.0, wind=(0.0, 0.0), seed=0, tolerance=0.02, detail=0.05):
    """Columns, and what reaches each place: share, error and bucket."""
    columns, around = columns_of(pieces, raster)
    share, error, bucket, _ = _core.snowfall.exposure(
        columns=columns,
        solids=[around.tree],
        top=columns.z(),
        slope=columns.slope(),
        flutter=flutter,
        wind=wind,
        seed=seed,
        tolerance=tolerance,
        detail=detail,
        most=1 << 16,
    )
    return columns, share, error, bucket
