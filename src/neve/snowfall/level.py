"""A level layer of a scene as snow that lies."""

from __future__ import annotations

import math

import numpy as np

from neve.scene.schema.file_shapes import Layer
from neve.scene.values.surfaces import square
from neve.snowfall.cover import Books, Cover, Raster, columns_over
from neve.snowfall.layers import Layers
from neve.snowfall.surroundings import joined

CELLS = 32
"""Places along the longer side of the layer."""
THICKEST = 0.05
"""Of a layer of its state [m]."""


def is_level(layer: Layer) -> bool:
    """Return whether a layer is a rectangle of even depth on level ground."""
    return layer.on != "terrain" and not layer.mask and not layer.outline


def cover_of_layer(layer: Layer, density: float, celsius: float) -> Cover:
    """Return a level layer as snow on level ground, in layers of at most 5 cm [kg/m3, deg C], all new."""
    raster = Raster.over(layer.center, layer.size, max(layer.size) / CELLS)
    corners, faces = square()
    far = 10.0 * (max(layer.size) + max(map(abs, layer.center)))
    around = joined([("ground", "ground", corners * far + [0.0, 0.0, layer.base], faces)])
    columns = columns_over(raster, around)
    count, k = len(columns.z()), max(1, math.ceil(layer.depth / THICKEST))
    layers = Layers.fresh(np.full((count, k), layer.depth / k), density, celsius, np.zeros(k))
    depth = np.full(count, layer.depth)
    volume = layer.depth * raster.area
    books = Books(volume, volume, 0.0, 0.0, 0.0, 0, True)
    return Cover(raster, columns, columns.z(), depth, np.ones(count), layers, around, books)
