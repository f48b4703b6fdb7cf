"""Read a height map into a field of heights in metres."""

from __future__ import annotations

import contextlib
import json
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.scene.errors import SceneError
from neve.scene.reading.files import where
from neve.scene.schema.file_shapes import Terrain
from neve.system.memory import lacking

if TYPE_CHECKING:
    from neve._core import HeightField

Array = NDArray[np.float64]
MAX_SAMPLES = 2**27
"""Samples that a map may have."""
MAX_SIDE = 2**20
"""Samples along a side of a map."""
SAMPLE_BYTES = 40
"""Memory for each sample while a map is read [bytes]: the file's own, real numbers, and those scaled."""
BITS, PIXEL_SCALE, GEO_KEYS, NO_DATA = 258, 33550, 34735, 42113
"""Tags of a GeoTIFF (TIFF 6.0; OGC 19-008r4, section 7; GDAL's own for missing values)."""
MODEL_TYPE, GEOGRAPHIC = 1024, 2
"""The key that says whether pixels are measured in metres or in degrees (OGC 19-008r4, section 7.1)."""


@dataclass(frozen=True)
class _Map:
    """Hold what a file says: values[x, y], the full range of short whole numbers, the size of a pixel [m]."""

    values: Array
    full: float | None
    pixel: tuple[float, float] | None = None


def height_field(terrain: Terrain, name: str) -> HeightField:
    """Return the heights of `terrain` [m] over a rectangle around its centre.

    `name`: used in messages.

    Errors: SceneError, one sentence: unreadable, of colours or another rank, not finite, without a size.
    """
    key = f"{name}.file = {json.dumps(terrain.file, ensure_ascii=False)}"
    path = where(terrain.file, "terrains")
    found = _array(path, key) if path.suffix.lower() == ".npy" else _picture(path, key)
    shape = found.values.shape
    if len(shape) != 2 or min(shape) < 2:
        axes = f"{len(shape)} axes" if len(shape) != 2 else f"{shape[0]} x {shape[1]} numbers"
        raise SceneError(f"{key} has {axes}: a height map has two axes, x and y, each of 2 numbers or more")
    if max(shape) > MAX_SIDE:
        raise SceneError(f"{key} has a side of {max(shape):,} heights, more than {MAX_SIDE:,}: cut the map")
    if lost := np.count_nonzero(~np.isfinite(found.values)):
        raise SceneError(f"{key} has gaps, {lost} in all, where the height is no finite number: fill them")
    pixel = found.pixel or (0.0, 0.0)
    if terrain.size is None and found.pixel is None:
        raise SceneError(f"{name}.size is missing, and {key} does not say how many metres a pixel is")
    size = np.array(terrain.size or np.multiply(pixel, np.array(shape) - 1), dtype=np.float64)
    heights = found.values * (terrain.height / (found.full or 1.0))
    if max(np.abs(heights).max(), size.max()) > 1e6:
        raise SceneError(f"{key} reaches beyond 1e6 m: set {name}.size, or a smaller {name}.height")
    return _core.geometry.HeightField(np.ascontiguousarray(heights, dtype=np.float32), size)


def _array(path: Path, key: str) -> _Map:
    """Read the array heights[x, y] of a NumPy file."""
    try:
        with warnings.catch_warnings():  # a header may promise more than there is: mapped, it is noticed
            warnings.simplefilter("ignore")
            values = np.load(path, mmap_mode="r", allow_pickle=False)
    except Exception as error:  # whatever a damaged file makes its reader stumble over
        raise _unreadable(key, error) from None
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "iuf":
        raise SceneError(f"{key} holds no numbers: a height map is an array of whole or real numbers")
    _require_size(values.size, "heights", key)
    bits = 8 * values.dtype.itemsize if values.dtype.kind in "iu" else 32
    return _Map(values.astype(np.float64), _full(bits))


def _picture(path: Path, key: str) -> _Map:
    """Read a picture of one channel, seen from above: x to the right, y upward."""
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as image:
                tags = dict(getattr(image, "tag_v2", {}))
                mode, pixels = image.mode, image.width * image.height
                _require_size(pixels, "pixels", key)
                rows = np.asarray(image)
    except SceneError:
        raise
    except Exception as error:  # whatever a damaged file makes its reader stumble over
        raise _unreadable(key, error) from None
    if mode not in ("L", "I", "F") and not mode.startswith("I;16"):
        raise SceneError(
            f"{key} is a picture in colours: a height map has one channel, of 8 or 16 bits or of reals"
        )
    bits = tags[BITS][0] if BITS in tags else 8 if mode == "L" else 16
    if mode == "F":
        bits = 32
    values = rows.astype(np.float64)
    with contextlib.suppress(ValueError):
        values[values == float(str(tags.get(NO_DATA, "nan")).strip("\0 "))] = np.nan
    scale = tags.get(PIXEL_SCALE)
    pixel = (float(scale[0]), float(scale[1])) if scale and not _in_degrees(tags) else None
    return _Map(values[::-1].T, _full(bits), pixel)


def _require_size(count: int, what: str, key: str) -> None:
    if count > MAX_SAMPLES:
        raise SceneError(f"{key} has {count:.3g} {what}, more than {MAX_SAMPLES:.3g}: use a smaller map")
    if found := lacking(SAMPLE_BYTES * count):
        raise SceneError(f"{key} {found}: use a smaller map")


def _full(bits: int) -> float | None:
    """Return the full range of whole numbers of 8 or 16 bits; longer ones count as real numbers."""
    return 2.0**bits - 1.0 if bits <= 16 else None


def _in_degrees(tags: dict[int, Any]) -> bool:
    """Whether the pixels of a GeoTIFF are measured in degrees: keys come in fours, name first, value last."""
    keys = np.array(tags.get(GEO_KEYS, ()), dtype=np.int64)
    rows = keys[: len(keys) // 4 * 4].reshape(-1, 4)
    return bool(np.any((rows[1:, 0] == MODEL_TYPE) & (rows[1:, 3] == GEOGRAPHIC)))


def _unreadable(key: str, error: Exception) -> SceneError:
    if isinstance(error, OSError) and error.errno and error.strerror:
        return SceneError(f"{key} cannot be read: {error.strerror[:1].lower()}{error.strerror[1:]}")
    return SceneError(f"{key} cannot be read: it is damaged, or not the kind of file that its name says")
