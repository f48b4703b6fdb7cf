"""Describe the space that a source fills, in axes of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from neve.colliders.motion import turn
from neve.sampling.lettering import letters
from neve.scene.scene import SnowBox, SnowCylinder, SnowLayer, SnowSource, SnowSphere, SnowText

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Region:
    """Hold a part of space inside a box around the origin of the source's own axes.

    Attributes:
        center: origin of the axes in the world [m], (3,)
        rotation: matrix from the source's axes to the world's [1], (3, 3)
        size: edges of the smallest box around the region, centred on the origin [m], (3,)
        volume: of the region [m3]
        inside: points in own axes [m] (n, 3), all inside the box -> whether they belong to the region (n,)
    """

    center: Array
    rotation: Array
    size: Array
    volume: float
    inside: Callable[[Array], Mask]


def region(source: SnowSource, spacing: float, name: str) -> Region:
    """Return the space that `source` fills, with details finer than `spacing` [m]; `name` tells it in errors.

    Errors: SceneError for letters that the font does not have.
    """
    if isinstance(source, SnowBox):
        return _box(source.center, source.rotation, source.size)
    if isinstance(source, SnowLayer):
        (x, y), (a, b) = source.center, source.size
        return _box((x, y, source.base + 0.5 * source.depth), (0.0, 0.0, 0.0), (a, b, source.depth))
    if isinstance(source, SnowSphere):
        r = source.radius
        size = np.full(3, 2.0 * r)
        return Region(np.array(source.center), np.eye(3), size, 4.0 / 3.0 * pi * r**3, _ball(r))
    if isinstance(source, SnowCylinder):
        r, h = source.radius, source.height
        size = np.array([2.0 * r, 2.0 * r, h])
        return Region(np.array(source.center), _axes(source.rotation), size, pi * r * r * h, _disc(r))
    assert isinstance(source, SnowText)
    sign = letters(source, spacing, name)
    size = np.array([sign.width, source.depth, sign.height])
    return Region(
        np.array(source.center), _axes(source.rotation), size, sign.area * source.depth, sign.covers
    )


def _box(center: tuple[float, ...], rotation: tuple[float, ...], size: tuple[float, ...]) -> Region:
    edges = np.array(size)
    return Region(np.array(center), _axes(rotation), edges, float(np.prod(edges)), _everywhere)


def _axes(rotation: tuple[float, ...]) -> Array:
    return turn(np.radians(rotation))


def _everywhere(x: Array) -> Mask:
    return np.ones(len(x), dtype=bool)


def _ball(radius: float) -> Callable[[Array], Mask]:
    return lambda x: np.einsum("ij,ij->i", x, x) <= radius**2


def _disc(radius: float) -> Callable[[Array], Mask]:
    return lambda x: x[:, 0] ** 2 + x[:, 1] ** 2 <= radius**2
