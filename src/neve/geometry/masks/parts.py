"""Measure the part of a layer's mask where snow lies: its extent, and how much snow it holds."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.geometry.masks.raster import Ground, Raster, key_of, raster
from neve.geometry.pose import Pose
from neve.reproducible import product
from neve.scene.errors import SceneError
from neve.scene.schema.file_shapes import Layer, Terrain
from neve.scene.values.outline import holds

Array = NDArray[np.float64]

MOST_PLACES = 2_000_000
"""Places at which a mask is looked at to measure it, unless it has more cells."""
FINEST = 256
"""Places along a side of a cell."""
AT_ONCE = 2**20
"""Places that are looked at together."""
UPRIGHT = 1e-9
"""How far the z axis of a terrain on which a mask lies may be turned [1]."""


@dataclass(frozen=True, eq=False)
class MaskedPart:
    """Hold where a layer with a mask has snow.

    Attributes:
        depths: points [m] (n, 2) of the world -> depth of the snow there [m], (n,)
        low, high: corners of the smallest box around it along x and y [m], (2,)
        deepest: depth [m]
        volume: of the snow [m3]
    """

    depths: Callable[[Array], Array]
    low: Array
    high: Array
    deepest: float
    volume: float


@dataclass(frozen=True, eq=False)
class Under:
    """Hold the terrain that a layer lies on: its name in messages, and where it is."""

    terrain: Terrain
    name: str
    pose: Pose


def masked(layer: Layer, under: Under | None, name: str) -> MaskedPart:
    """Return where the mask of `layer` puts snow: within its outline, and on the map of what is `under` it.

    `name`: of the source, in messages.

    Errors: SceneError, one sentence: see `neve.geometry.masks.raster.raster`; no snow on the terrain or
    within the outline; a terrain that does not stand upright.
    """
    key = key_of(layer, name)
    limits: list[tuple[Callable[[Array], NDArray[np.bool_]], str]] = []
    if under is not None:
        ground, place = Ground.of(under.terrain, under.name), under.pose
        if place.rotation[2, 2] < 1.0 - UPRIGHT:
            raise SceneError(
                f"{key} needs an upright terrain: let {under.name}.rotation turn it about z alone"
            )
        mask = raster(layer, ground, name).moved(place.rotation[:2, :2], place.position[:2])
        limits.append((lambda x: _on(ground, place, x), f"overlap {under.name}: no snow lies on its map"))
    else:
        mask = raster(layer, None, name)
        at = layer.place[:2] if mask.overhang == 0.0 else layer.center
        mask = mask.moved(np.eye(2), np.array(at))
    if layer.outline:
        corners = np.array(layer.outline) + np.array(layer.center)
        limits.append((lambda x: holds(corners, x), f"overlap {name}.outline"))
    return _measured(layer, mask, limits, key)


def _on(ground: Ground, place: Pose, x: Array) -> NDArray[np.bool_]:
    local = product(x - place.position[:2], place.rotation[:2, :2])
    return np.asarray(np.all(np.abs(local) <= 0.5 * ground.size * (1.0 + 1e-9), axis=1))


def _measured(
    layer: Layer,
    mask: Raster,
    limits: Sequence[tuple[Callable[[Array], NDArray[np.bool_]], str]],
    key: str,
) -> MaskedPart:
    """Return the part of `mask` within `limits`, each with the end of the sentence if nothing is left.

    The volume is the sum over places on a lattice that divides each cell by an even number: exact where no
    limit cuts a cell, for a factor that is bilinear between the middles of cells as well.
    """
    cells = _cells(mask)
    fine = _fineness(len(cells))
    area, deepest = 0.0, 0.0
    low, high = np.full(2, math.inf), np.full(2, -math.inf)
    left = np.zeros(len(limits), dtype=np.int64)
    for places in _places(cells, fine):
        factor = mask.at_samples(places)
        x = product(places, mask.matrix[:, :2].T) + mask.matrix[:, 2]
        some = factor > 0.0
        for k, (holds_points, _) in enumerate(limits):
            some &= holds_points(x)
            left[k] += np.count_nonzero(some)
        if some.any():
            area += float(factor[some].sum())
            deepest = max(deepest, float(factor[some].max()))
            low, high = np.minimum(low, x[some].min(axis=0)), np.maximum(high, x[some].max(axis=0))
    if area == 0.0:
        told = next((end for (_, end), n in zip(limits, left, strict=True) if n == 0), "leave any snow")
        raise SceneError(f"{key} does not {told}: check where both are")
    edge = 0.5 / fine * np.abs(mask.matrix[:, :2]).sum(axis=1)
    if mask.is_smooth:  # half of a step from a place, along both axes, it may be deeper
        most = float(mask.values.max())
        deepest = min(most, deepest + most / fine)
    if deepest * layer.depth > 1e6:
        raise SceneError(f"{key} makes {deepest * layer.depth:.3g} m of snow: set a smaller depth")

    def depths(x: Array) -> Array:
        found = mask.at(x)
        for holds_points, _ in limits:
            found = np.where(found > 0.0, found * holds_points(x), 0.0)
        return layer.depth * found

    volume = layer.depth * area * mask.cell / fine**2
    return MaskedPart(depths, low - edge, high + edge, layer.depth * deepest, volume)


def _cells(mask: Raster) -> Array:
    """Return the samples (n, 2) in whose cells there may be snow."""
    has_snow = mask.values > 0.0
    if mask.is_smooth:  # it reaches to the next samples
        for axis in (0, 1):
            wide = np.moveaxis(has_snow.copy(), axis, 0)
            narrow = np.moveaxis(has_snow, axis, 0)
            wide[:-1] |= narrow[1:]
            wide[1:] |= narrow[:-1]
            has_snow = np.moveaxis(wide, 0, axis)
    return np.argwhere(has_snow).astype(np.float64)


def _fineness(cells: int) -> int:
    """Return the even number of places along a side of each of so many cells."""
    fine = int(math.sqrt(MOST_PLACES / cells))
    return min(max(fine - fine % 2, 2), FINEST)


def _places(cells: Array, fine: int) -> Iterator[Array]:
    """Yield places (n, 2) among the samples, `fine` along each side of each of `cells` (k, 2)."""
    offset = (np.arange(fine) + 0.5) / fine - 0.5
    lattice = np.stack(np.meshgrid(offset, offset, indexing="ij"), axis=-1).reshape(-1, 2)
    step = max(1, AT_ONCE // len(lattice))
    for begin in range(0, len(cells), step):
        yield (cells[begin : begin + step, None] + lattice).reshape(-1, 2)
