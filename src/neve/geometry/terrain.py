"""Turn a map of heights into ground in metres, and say what is doubtful about it."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.geometry.maps.found import Map
from neve.geometry.maps.reading import read_map
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.files import where
from neve.scene.schema.file_shapes import Terrain

if TYPE_CHECKING:
    from neve._core import HeightField

Array = NDArray[np.float64]
MAX_SIDE = 2**20
"""Samples along a side of a map."""
FARTHEST = 1e6
"""Height, and extent, that a map may have [m]."""
FLAT = 1e-3
"""Relief over the shorter side of a map below which whole numbers look as if they were metres."""
STEEP = 5.0
"""Relief over the longer side of a map above which its pixels look as if they were degrees."""
STAND_INS = (-9999.0, -32768.0, -32767.0, -99999.0, -999.0, -9999999.0)
"""Numbers that often stand for missing heights."""
LONELY = 500.0
"""Units between such a number and the next larger one."""
TURNED = 0.01
"""Degrees to which a rotation that the scene states is that of the file."""


def height_field(terrain: Terrain, name: str) -> HeightField:
    """Return the heights of `terrain` [m] over a rectangle around its centre.

    `name`: used in messages.

    Warns with SceneWarning of what is doubtful about the file. Errors: SceneError, one sentence: unreadable,
    of colours or another rank, not finite, without a size, turned.
    """
    key = f"{name}.file = {json.dumps(terrain.file, ensure_ascii=False)}"
    path = where(terrain.file, "terrains")
    found = read_map(path, key)
    shape = found.values.shape
    if len(shape) != 2 or min(shape) < 2:
        axes = f"{len(shape)} axes" if len(shape) != 2 else f"{shape[0]} x {shape[1]} numbers"
        raise SceneError(f"{key} has {axes}: a height map has two axes, x and y, each of 2 numbers or more")
    if max(shape) > MAX_SIDE:
        raise SceneError(f"{key} has a side of {max(shape):,} heights, more than {MAX_SIDE:,}: cut the map")
    _require_whole(found, key)
    size = extent(terrain, found, name, key)
    heights = found.values * (found.unit * terrain.height / (found.full or 1.0))
    if max(np.abs(heights).max(), size.max()) > FARTHEST:
        raise SceneError(f"{key} reaches beyond 1e6 m: set {name}.size, or a smaller {name}.height")
    for doubt in (*found.doubts, *_doubts(terrain, found, heights, size, name)):
        warnings.warn(f"{key} {doubt}", SceneWarning, stacklevel=2)
    return _core.geometry.HeightField(np.ascontiguousarray(heights, dtype=np.float32), size)


def _require_whole(found: Map, key: str) -> None:
    """Refuse gaps: what the file marks as such, and numbers that no height is.

    Errors: SceneError, one sentence.
    """
    if lost := np.count_nonzero(~np.isfinite(found.values)):
        raise SceneError(f"{key} has gaps, {lost} in all, where the height is no finite number: fill them")
    low, high = float(found.values.min()), float(found.values.max())
    beyond = np.abs(found.values) > 1e15
    if beyond.any() and not beyond.all():
        worst = low if -low > high else high
        raise SceneError(
            f"{key} has gaps, {np.count_nonzero(beyond)} in all, where numbers such as {worst:.3g} stand for "
            "missing heights: fill them"
        )


def extent(terrain: Terrain, found: Map, name: str, key: str) -> Array:
    """Return the extent along x and y [m]: that of the scene, or of the file.

    Errors: SceneError if there is none, or if the file is turned and the scene does not say so.
    """
    is_turned = abs(found.turn) > 0.0 and abs(terrain.rotation[2] - found.turn) > TURNED
    if terrain.size is None and is_turned and found.pixel is not None:
        raise SceneError(
            f"{key} is turned by {found.turn:.6g} degrees from the east: set {name}.rotation = "
            f"[0, 0, {found.turn:.6g}] to place it so, or {name}.size to take it as if it were not turned"
        )
    if terrain.size is not None:
        return np.array(terrain.size, dtype=np.float64)
    if found.pixel is None:
        raise SceneError(f"{name}.size is missing, and {key} {found.no_size}")
    return np.asarray(np.multiply(found.pixel, np.array(found.values.shape) - 1), dtype=np.float64)


def _doubts(terrain: Terrain, found: Map, heights: Array, size: Array, name: str) -> Iterator[str]:
    """Yield the ends of sentences about numbers that may not mean what they make."""
    low, high = float(found.values.min()), float(found.values.max())
    relief = float(heights.max()) - float(heights.min())
    if abs(found.turn) > 0.0 and abs(terrain.rotation[2] - found.turn) > TURNED:
        yield (
            f"is turned by {found.turn:.6g} degrees from the east, which counts only with {name}.rotation = "
            f"[0, 0, {found.turn:.6g}]"
        )
    is_small = 0.0 < relief < FLAT * float(size.min()) or (found.pixel is not None and terrain.height == 1.0)
    if found.full is not None and high > low and is_small:
        yield (
            f"has whole numbers from {low:g} to {high:g}, of which {name}.height = {terrain.height:g} makes "
            f"{relief:.3g} m of relief on {size[0]:g} m by {size[1]:g} m: if they are metres, set "
            f"{name}.height = {found.full:g}"
        )
    if found.pixel is not None and terrain.size is None and relief > STEEP * float(size.max()):
        yield (
            f"has {relief:.4g} m of relief on {size[0]:.4g} m by {size[1]:.4g} m: if its pixels are degrees, "
            f"set {name}.size"
        )
    if low in STAND_INS and high > low:
        above = float(found.values[found.values > low].min())
        if above - low > LONELY or (low == STAND_INS[4] and above >= 0.0):
            count = np.count_nonzero(found.values == low)
            yield (
                f"has the height {low:g} at {count} of {found.values.size} places, a number that often "
                "stands for missing ones: fill them if it does"
            )
