"""Describe the space that a source fills, in axes of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from neve.geometry.pose import rotation_matrix
from neve.sampling.filling import MeshSpace, mesh_space
from neve.sampling.lettering import Letters, letters
from neve.scene.schema.scene import (
    Numerics,
    SnowBox,
    SnowCylinder,
    SnowLayer,
    SnowMesh,
    SnowSource,
    SnowSphere,
    SnowText,
)

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Region:
    """Hold a part of space inside a box, seen from the middle of that box in the source's own axes.

    Attributes:
        center: origin of the axes in the world [m], (3,)
        rotation: matrix from the source's axes to the world's [1], (3, 3)
        size: edges of the smallest box around the region [m], (3,)
        volume: of the region [m3]
        inside: points of the box, from its middle [m] (n, 3) -> whether they are in the region (n,)
        depth: points of the region, from the box's middle [m] (n, 3) -> distance below its surface [m] (n,);
            a layer's surface is its top
        lowest: height of the region's lowest point; of letters, of the box around them [m]
        middle: of the box, from the origin of the source's axes [m], (3,)
    """

    center: Array
    rotation: Array
    size: Array
    volume: float
    inside: Callable[[Array], Mask]
    depth: Callable[[Array], Array]
    lowest: float
    middle: Array = field(default_factory=lambda: np.zeros(3))


def region(source: SnowSource, numerics: Numerics, name: str) -> Region:
    """Return the space that `source` fills, with details finer than the particles' distance.

    `name` tells the source in errors.

    Errors: SceneError for letters that the font does not have, or a mesh that cannot be filled.
    """
    if isinstance(source, SnowBox):
        return _box(source.center, source.rotation, source.size)
    if isinstance(source, SnowLayer):
        (x, y), (a, b) = source.center, source.size
        sheet = _box((x, y, source.base + 0.5 * source.depth), (0.0, 0.0, 0.0), (a, b, source.depth))
        return replace(sheet, depth=lambda p: np.asarray(0.5 * source.depth - p[:, 2]))
    if isinstance(source, SnowSphere):
        return _sphere(source.center, source.radius)
    if isinstance(source, SnowCylinder):
        return _cylinder(source.center, source.rotation, source.radius, source.height)
    if isinstance(source, SnowMesh):
        return _mesh(source, mesh_space(source, numerics, name))
    assert isinstance(source, SnowText)
    sign = letters(source, numerics.spacing, name)
    block = _box(source.center, source.rotation, (sign.width, source.depth, sign.height))
    volume = sign.area * source.depth
    return replace(block, volume=volume, inside=sign.covers, depth=_below_letters(sign, source.depth))


def _sphere(center: tuple[float, ...], r: float) -> Region:
    middle, size = np.array(center), np.full(3, 2.0 * r)
    return Region(middle, np.eye(3), size, 4.0 / 3.0 * pi * r**3, _ball(r), _below_ball(r), center[2] - r)


def _cylinder(center: tuple[float, ...], rotation: tuple[float, ...], r: float, h: float) -> Region:
    axes, size = _axes(rotation), np.array([2.0 * r, 2.0 * r, h])
    up = min(abs(float(axes[2, 2])), 1.0)
    lowest = center[2] - 0.5 * h * up - r * sqrt(1.0 - up * up)
    return Region(np.array(center), axes, size, pi * r * r * h, _disc(r), _below_disc(r, h), lowest)


def _box(center: tuple[float, ...], rotation: tuple[float, ...], size: tuple[float, ...]) -> Region:
    middle, edges, axes = np.array(center), np.array(size), _axes(rotation)

    def depth(x: Array) -> Array:
        return np.asarray((0.5 * edges - np.abs(x)).min(axis=1))

    lowest = float(middle[2] - 0.5 * np.abs(axes[2]) @ edges)
    return Region(middle, axes, edges, float(np.prod(edges)), _everywhere, depth, lowest)


def _mesh(source: SnowMesh, space: MeshSpace) -> Region:
    axes, middle, center = _axes(source.rotation), 0.5 * (space.low + space.high), np.array(source.center)
    return Region(
        center=center,
        rotation=axes,
        size=space.high - space.low,
        volume=space.volume,
        inside=lambda x: space.distance(x + middle) < 0,
        depth=lambda x: np.maximum(-space.distance(x + middle), 0.0),
        lowest=float(center[2] + (space.corners @ axes[2]).min()) - space.margin,
        middle=middle,
    )


def _axes(rotation: tuple[float, ...]) -> Array:
    return rotation_matrix(np.radians(rotation))


def _everywhere(x: Array) -> Mask:
    return np.ones(len(x), dtype=bool)


def _ball(radius: float) -> Callable[[Array], Mask]:
    return lambda x: np.einsum("ij,ij->i", x, x) <= radius**2


def _below_ball(radius: float) -> Callable[[Array], Array]:
    return lambda x: np.asarray(radius - np.linalg.norm(x, axis=1))


def _disc(radius: float) -> Callable[[Array], Mask]:
    return lambda x: x[:, 0] ** 2 + x[:, 1] ** 2 <= radius**2


def _below_disc(radius: float, height: float) -> Callable[[Array], Array]:
    return lambda x: np.minimum(radius - np.hypot(x[:, 0], x[:, 1]), 0.5 * height - np.abs(x[:, 2]))


def _below_letters(sign: Letters, depth: float) -> Callable[[Array], Array]:
    return lambda x: np.minimum(sign.depth(x), 0.5 * depth - np.abs(x[:, 1]))
