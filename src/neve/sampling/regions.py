"""Describe the space that a source fills, in axes of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from neve.colliders.motion import pose
from neve.geometry.masks.parts import MaskedPart, Under, masked
from neve.geometry.pose import rotation_matrix
from neve.reproducible import product
from neve.sampling.filling import MeshSpace, mesh_space
from neve.sampling.lettering import Letters, letters
from neve.scene.schema.file_shapes import Layer, Mesh, Terrain, Text
from neve.scene.schema.scene import Collider, Numerics, Source
from neve.scene.schema.shapes import Shape
from neve.scene.schema.sources import Emitter, Sink

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

    def holds(self, x: Array) -> Mask:
        """Return which points x of the world [m] (n, 3) are in the region, (n,)."""
        local = product(x - self.center, self.rotation) - self.middle
        slack = 1e-9 * self.size
        found = np.all(np.abs(local) <= 0.5 * self.size + slack, axis=1)
        found[found] = self.inside(local[found])
        return np.asarray(found)

    def bounds(self) -> tuple[Array, Array]:
        """Return the lowest and the highest corner [m] (3,) of a box along the world's axes around it."""
        middle = self.center + product(self.rotation, self.middle)
        half = 0.5 * product(np.abs(self.rotation), self.size)
        return middle - half, middle + half


def region(
    source: Source | Emitter | Sink, numerics: Numerics, name: str, colliders: Sequence[Collider] = ()
) -> Region:
    """Return the space that `source` fills, with details finer than the particles' distance.

    `name`: used in messages; `colliders`: of the scene, on whose terrain a mask may lie.

    Errors: SceneError for letters that the font does not have, or a mesh or a mask that cannot be filled.
    """
    if isinstance(source, Layer) and source.mask:
        return _masked(source, masked(source, _under(source, colliders), name))
    if isinstance(source, Mesh):
        return _mesh(source, mesh_space(source, numerics, name))
    if isinstance(source, Text):
        return _letters(source, letters(source, numerics.spacing, name))
    half = np.array(source.half_extents())
    axes, center = _axes(source), np.array(source.place)
    return Region(
        center=center,
        rotation=axes,
        size=2.0 * half,
        volume=source.volume(),
        inside=source.within,
        depth=lambda x: source.depth_of(half, x),
        lowest=source.lowest_of(half, float(center[2]), axes[2]),
    )


def _under(layer: Layer, colliders: Sequence[Collider]) -> Under | None:
    """Return the first terrain if the layer lies on one."""
    for i, collider in enumerate(colliders if layer.on == "terrain" else ()):
        if isinstance(collider, Terrain):
            return Under(collider, f"colliders.{i}", pose(collider, 0.0))
    return None


def _masked(layer: Layer, part: MaskedPart) -> Region:
    """Return the space of a layer with a mask, in the axes of the world, from the middle of its box."""
    middle, half = 0.5 * (part.low + part.high), 0.5 * part.deepest

    def above(x: Array) -> Array:
        return np.asarray(part.depths(x[:, :2] + middle) - (x[:, 2] + half))

    return Region(
        center=np.array([*middle, layer.base + half]),
        rotation=np.eye(3),
        size=np.array([*(part.high - part.low), part.deepest]),
        volume=part.volume,
        inside=lambda x: above(x) > 0.0,
        depth=lambda x: np.maximum(above(x), 0.0),
        lowest=layer.base,
    )


def _letters(source: Text, sign: Letters) -> Region:
    axes, center = _axes(source), np.array(source.place)
    half = 0.5 * np.array((sign.width, source.depth, sign.height))
    return Region(
        center=center,
        rotation=axes,
        size=2.0 * half,
        volume=sign.area * source.depth,
        inside=sign.covers,
        depth=lambda x: np.minimum(sign.depth(x), half[1] - np.abs(x[:, 1])),
        lowest=source.lowest_of(half, float(center[2]), axes[2]),
    )


def _mesh(source: Mesh, space: MeshSpace) -> Region:
    axes, middle, center = _axes(source), 0.5 * (space.low + space.high), np.array(source.place)
    return Region(
        center=center,
        rotation=axes,
        size=space.high - space.low,
        volume=space.volume,
        inside=lambda x: space.distance(x + middle) < 0,
        depth=lambda x: np.maximum(-space.distance(x + middle), 0.0),
        lowest=float(center[2] + product(space.corners, axes[2]).min()) - space.margin,
        middle=middle,
    )


def _axes(source: Shape) -> Array:
    return rotation_matrix(np.radians(source.turned))
