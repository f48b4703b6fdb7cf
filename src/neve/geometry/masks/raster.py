"""Read a mask, and lay it on the ground or over its layer."""

from __future__ import annotations

import json
import math
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neve.geometry.maps.found import Map
from neve.geometry.maps.reading import read_map, read_mask
from neve.geometry.terrain import extent
from neve.reproducible import product
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.files import where
from neve.scene.schema.file_shapes import Layer, Terrain

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Raster:
    """Hold a mask that is laid on the x-y plane.

    Attributes:
        values: factor on the depth of snow at sample (i, j) [1], (nx, ny)
        matrix: the middle of sample (i, j) is at matrix @ (i, j, 1) [m], (2, 3)
        overhang: how far the map goes beyond the middles of its outermost samples [samples]: 1/2 where
            samples are cells, 0 where they lie from edge to edge
        is_smooth: whether it is bilinear between the samples; else each stands for its cell
    """

    values: Array
    matrix: Array
    overhang: float
    is_smooth: bool

    @property
    def cell(self) -> float:
        """Area that a sample stands for [m2]."""
        (a, b), (c, d) = self.matrix[:, :2].tolist()
        return float(abs(a * d - b * c))

    def moved(self, rotation: Array, position: Array) -> Raster:
        """Return it turned by `rotation` (2, 2), with its origin at `position` [m] (2,)."""
        matrix = product(rotation, self.matrix)
        matrix[:, 2] += position
        return replace(self, matrix=matrix)

    def at(self, x: Array) -> Array:
        """Return the factor on the depth [1] (n,) at points x [m] (n, 2); 0 beyond the edges."""
        return self.at_samples(product(x - self.matrix[:, 2], _inverse(self.matrix[:, :2]).T))

    def at_samples(self, place: Array) -> Array:
        """Return the factor on the depth [1] (n,) at places (i, j) among the samples (n, 2)."""
        last = np.array(self.values.shape) - 1
        reach = self.overhang + 1e-9 * (last + 1)
        on = np.all((place >= -reach) & (place <= last + reach), axis=1)
        within = np.clip(place, 0.0, last)
        if not self.is_smooth:
            i, j = np.floor(within + 0.5).astype(np.int64).T
            return np.where(on, self.values[i, j], 0.0)
        i, j = np.minimum(np.floor(within), last - 1).astype(np.int64).T
        s, t = within[:, 0] - i, within[:, 1] - j
        v = self.values
        south = (1.0 - s) * v[i, j] + s * v[i + 1, j]
        north = (1.0 - s) * v[i, j + 1] + s * v[i + 1, j + 1]
        return np.where(on, (1.0 - t) * south + t * north, 0.0)


def key_of(layer: Layer, name: str) -> str:
    """Return the begin of sentences about the mask of the source `name`."""
    return f"{name}.mask = {json.dumps(layer.mask, ensure_ascii=False)}"


@dataclass(frozen=True, eq=False)
class Ground:
    """Hold the map of the terrain that a layer lies on.

    Attributes:
        file: what its file says
        size: extent along x and y [m], (2,)
    """

    file: Map
    size: Array

    @classmethod
    def of(cls, terrain: Terrain, name: str) -> Ground:
        """Read the map of `terrain`; `name`: in messages. Errors: SceneError, one sentence."""
        key = f"{name}.file = {json.dumps(terrain.file, ensure_ascii=False)}"
        file = read_map(where(terrain.file, "terrains"), key)
        return cls(file, extent(terrain, file, name, key))


def raster(layer: Layer, ground: Ground | None, name: str) -> Raster:
    """Return the mask of `layer`, from the middle of the terrain that it lies on and in its axes.

    Without terrain, from the middle of the layer: of its box, or where the mask has a place, of itself.

    Where both files have coordinates these place the mask on the terrain. A mask with coordinates in metres
    has its own size around the middle of any other terrain, or of the layer. Others lie from edge to edge.

    `name`: of the source, in messages.

    Warns with SceneWarning of what is doubtful about the file. Errors: SceneError, one sentence: unreadable,
    of another rank, with negative depths, empty, in another system of coordinates than the terrain.
    """
    key = key_of(layer, name)
    found = read_mask(Path(layer.mask), key)
    if found.values.ndim != 2 or min(found.values.shape) < 2:
        sides = " x ".join(str(n) for n in found.values.shape)
        raise SceneError(f"{key} has {sides} numbers: a mask has two axes, each of 2 numbers or more")
    values = _factors(layer, found, key)
    for doubt in found.doubts:
        warnings.warn(f"{key} {doubt}", SceneWarning, stacklevel=2)
    if not values.any():
        what = "no depth above 0" if layer.mask_means == "depth" else "nothing set"
        raise SceneError(f"{key} has {what}, so that no snow lies anywhere: choose another mask")
    is_smooth = layer.mask_means == "depth"
    if ground is not None and ground.file.place is not None and found.place is not None:
        return Raster(values, _on_ground(found, ground, key), 0.5, is_smooth)
    if found.pixel is not None:
        c, s = math.cos(math.radians(found.turn)), math.sin(math.radians(found.turn))
        axes = np.array([[c, -s], [s, c]])
        return Raster(values, _around_middle(values, axes * np.array(found.pixel)), 0.5, is_smooth)
    size = ground.size if ground is not None else np.subtract(*layer.bounds[::-1])
    return Raster(
        values, _around_middle(values, np.diag(size / (np.array(values.shape) - 1))), 0.0, is_smooth
    )


def _factors(layer: Layer, found: Map, key: str) -> Array:
    """Return the factor on the depth at each sample [1]: 0 or 1 of a cover."""
    values = np.where(np.isfinite(found.values), found.values, 0.0)
    if layer.mask_means == "depth":
        if (least := float(values.min())) < 0.0:
            raise SceneError(
                f"{key} has negative depths, down to {least:g}: mark what is missing, or set it to 0"
            )
        return values * (found.unit / (found.full or 1.0))
    is_picture = found.full is not None and found.place is None and found.pixel is None
    limit = 0.5 * float(values.max()) if is_picture else 0.0
    return ((values > limit) if is_picture else (values != 0.0)).astype(np.float64)


def _around_middle(values: Array, steps: Array) -> Array:
    """Return the matrix of samples with these `steps` [m] (2, 2), whose middle is the origin."""
    return np.column_stack([steps, -product(steps, 0.5 * (np.array(values.shape) - 1))])


def _on_ground(found: Map, ground: Ground, key: str) -> Array:
    """Return the matrix of a mask whose coordinates are those of the terrain's file."""
    ours, its = found.place, ground.file.place
    if ours is None or its is None:
        raise ValueError("a mask and a terrain with coordinates are needed")
    if ours.system and its.system and ours.system != its.system:
        raise SceneError(
            f"{key} is in another system of coordinates (EPSG:{ours.system}) than the terrain "
            f"(EPSG:{its.system}): project one of them"
        )
    to_samples = _inverse(its.matrix[:, :2])
    last = np.array(ground.file.values.shape) - 1
    steps = product(to_samples, ours.matrix[:, :2])
    first = product(to_samples, ours.matrix[:, 2] - its.matrix[:, 2])
    scale = ground.size / last
    return np.asarray(np.column_stack([steps, first - 0.5 * last]) * scale[:, None])


def _inverse(matrix: Array) -> Array:
    (a, b), (c, d) = matrix.tolist()
    return np.asarray(np.array([[d, -b], [-c, a]]) / (a * d - b * c))
