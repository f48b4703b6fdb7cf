"""Read heights from a tile of the Shuttle Radar Topography Mission (SRTM), an HGT file."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from neve.geometry.maps.found import Map, Place, degree, require_size, unreadable
from neve.scene.errors import SceneError

VOID = -32768
"""Stands for a missing height (SRTM Topography, document of the data, section 2.1.2 [M])."""
SIDES = {1201: "3 arc seconds", 3601: "1 arc second"}
"""Samples along a side of a tile of one degree."""
WGS84 = 4326
"""EPSG code of longitude and latitude on that ellipsoid."""
PLACE = re.compile(r"([NS])(\d{2})([EW])(\d{3})(?![0-9])", re.IGNORECASE)
"""Latitude and longitude of the south-west corner, with which a file's name begins."""


def read_hgt(path: Path, key: str) -> Map:
    """Read a tile of one degree: whole metres of 16 bits, big-endian, row by row from the north.

    The size follows from the name, such as N46E007.hgt: a degree at the middle of the tile (WGS 84). The tile
    is taken for a rectangle there; its true edges differ by 1 % in the Alps.

    `key`: begin of sentences.

    Errors: SceneError, one sentence.
    """
    try:
        length = path.stat().st_size
    except OSError as error:
        raise unreadable(key, error) from None
    side = math.isqrt(length // 2)
    if side not in SIDES or length != 2 * side * side:
        known = " or ".join(f"{n} x {n} ({step})" for n, step in SIDES.items())
        raise SceneError(
            f"{key} has {length:,} bytes: an .hgt file has {known} heights of 2 bytes, and nothing else"
        )
    require_size(side * side, "heights", key)
    try:
        rows = np.fromfile(path, dtype=">i2").reshape(side, side)
    except (OSError, ValueError) as error:
        raise unreadable(key, error) from None
    values = rows[::-1].T.astype(np.float64)
    values[values == VOID] = np.nan
    place = PLACE.match(path.name)
    if place is None or int(place[2]) > 89:
        return Map(values, None, no_size="has a name that says no place, as N46E007.hgt does")
    south = int(place[2]) * (1 if place[1].upper() == "N" else -1)
    west = int(place[4]) * (1 if place[3].upper() == "E" else -1)
    east, north = degree(south + 0.5)
    step = 1.0 / (side - 1)
    matrix = np.array([[step, 0.0, west], [0.0, step, south]])
    return Map(values, None, (east * step, north * step), place=Place(matrix, WGS84))
