"""Shapes that no formula gives: layers with masks, letters, meshes and height maps."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from neve.scene.schema.shapes import ROTATION, Array, Shape, Vector
from neve.scene.schema.snowfall import Lying, Snowfall
from neve.scene.values.allowed import words
from neve.scene.values.fields import (
    ZERO,
    Angle3,
    Coordinate,
    Distance,
    FarPoint3,
    Length,
    Point2,
    Point3,
    Size2,
    check_file,
    entry,
    file_entry,
    wrong,
)
from neve.scene.values.outline import area_of, crossing, holds

MESHES = (".obj", ".ply", ".stl", ".glb", ".gltf")
"""What a mesh file may end in."""
MAPS = (".png", ".tif", ".tiff", ".asc", ".hgt", ".npy")
"""What a height map may end in."""
MASKS = (".png", ".tif", ".tiff", ".asc", ".npy")
"""What the mask of a layer may end in."""
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Length of each unit of a mesh file [m]."""


MOST_CORNERS = 1000
"""Of the outline of a layer."""


class Layer(Shape):
    """Spread a layer of even depth, whose surface is its top, flat or on the ground."""

    roles = ("source",)

    shape: Literal["layer"] = entry("layer", "A layer with upright sides.")
    center: Point2 = entry((0.0, 0.0), "Centre of the layer seen from above.", "m")
    size: Size2 = entry(
        (2.0, 2.0),
        "Extent along x and y; not used with an outline, or with a mask that has a place of its own.",
        "m",
    )
    depth: Length = entry(0.2, "Thickness of the layer, measured upright, on a slope as well.", "m")
    base: Coordinate = entry(
        0.0, "Height of the layer's underside: over z = 0, or on terrain over the ground.", "m"
    )
    on: Literal["level", "terrain"] = entry(
        "level",
        '"level": flat at the height `base`; "terrain": it follows the ground below it, the highest of all '
        "terrains and planes among the colliders. The volume is that of the flat layer.",
        "",
    )
    outline: tuple[Point2, ...] = entry(
        (), "Corners of the layer seen from above, measured from its center, in order; left out, `size`.", "m"
    )
    mask: str = file_entry(
        "A picture (PNG, TIFF), GeoTIFF, Esri ASCII grid (ASC) or NumPy array mask[x, y] (NPY) that says "
        "where snow lies, relative to the scene file; with an outline, where both say so. With coordinates "
        "it lies on terrain with coordinates where they say; otherwise it is stretched over the terrain that "
        "the layer lies on, or over the layer ([masks](meshes.md#masks)).",
        MASKS,
    )
    mask_means: Literal["cover", "depth"] = entry(
        "cover",
        'What the numbers of the mask say. "cover": whether snow lies there: numbers other than 0, in '
        'pictures without coordinates more than half of the largest; "depth": how deep it is, as a factor on '
        "`depth`: of 8 or 16 bits the share of their full range, others themselves. Missing numbers mean no "
        "snow.",
        "",
    )

    @model_validator(mode="after")
    def _check_mask(self) -> Layer:
        if self.mask and not self.mask.lower().endswith(MASKS):
            raise wrong("mask", f"must end in {words(MASKS)}")
        if self.mask_means != "cover" and not self.mask:
            raise wrong("mask_means", "needs a mask; name one, or leave mask_means out")
        return self

    @model_validator(mode="after")
    def _check_outline(self) -> Layer:
        if not self.outline:
            return self
        if not 3 <= len(self.outline) <= MOST_CORNERS:
            raise wrong("outline", f"must have 3 to {MOST_CORNERS} corners; it has {len(self.outline)}")
        if found := crossing(np.array(self.outline)):
            raise wrong("outline", f"crosses itself: its sides from the corners {found[0]} and {found[1]} do")
        if not area_of(np.array(self.outline)) > 0:
            raise wrong("outline", "must have an area: its corners lie on a line")
        return self

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Its lowest and highest x and y, from its center [m], (2,) each."""
        corners, half = np.array(self.outline), 0.5 * np.array(self.size)
        return (corners.min(axis=0), corners.max(axis=0)) if self.outline else (-half, half)

    @property
    def place(self) -> Vector:
        """Its middle, half of its depth above its base."""
        x, y = (float(v) for v in np.array(self.center) + 0.5 * np.add(*self.bounds))
        return x, y, self.base + 0.5 * self.depth

    def half_extents(self) -> Vector:
        """Return half of its extent along x and y and half of its depth [m]."""
        a, b = (float(v) for v in 0.5 * np.subtract(*self.bounds[::-1]))
        return a, b, 0.5 * self.depth

    def volume(self) -> float:
        """Return its area seen from above times its depth [m3]; 0 if only its mask tells."""
        if self.mask:
            return 0.0
        return area_of(np.array(self.outline)) * self.depth if self.outline else super().volume()

    def within(self, x: Array) -> NDArray[np.bool_]:
        """Return which points `x` [m] (n, 3) of its box, from the middle of it, its outline holds, (n,)."""
        if not self.outline:
            return super().within(x)
        return holds(np.array(self.outline), x[:, :2] + 0.5 * np.add(*self.bounds))

    def thinnest(self) -> tuple[str, float] | None:
        """Return its depth or its shorter side [m]."""
        if self.outline:
            return "depth", self.depth
        return min(("depth", self.depth), ("size", min(self.size)), key=lambda pair: pair[1])

    @staticmethod
    def depth_of(half: Array, x: Array) -> Array:
        """Return the distance from its top [m]."""
        return np.asarray(half[2] - x[:, 2])


class Mesh(Shape):
    """Fill a closed mesh; with a `thickness`, the space around the faces of any mesh."""

    shape: Literal["mesh"] = entry("mesh", "A triangle mesh from a file ([meshes](meshes.md)).")
    file: str = file_entry(
        'An OBJ, PLY, STL, GLB or GLTF file, relative to the scene file; "neve:NAME" is a mesh that comes '
        "with Neve.",
        MESHES,
        "meshes",
    )
    unit: Literal["m", "cm", "mm", "in", "ft"] = entry("m", "Unit of the numbers in the file.", "")
    scale: Length = entry(1.0, "Factor on the numbers in the file, on top of their unit.", "1")
    up: Literal["z", "y"] = entry(
        "z", 'Which axis of the file points up; "y" in most GLB and many OBJ files.', ""
    )
    origin: Literal["center", "bottom"] | FarPoint3 | None = entry(
        None,
        "Which point of the file becomes the origin of the solid, in the file's own numbers and axes, such "
        'as [500000, 5000000, 0] of map coordinates; "center" is the middle of the box around all, "bottom" '
        "the middle of its lower side. Left out, the origin of the file.",
    )
    thickness: Distance = entry(
        0.0,
        "Of an open mesh, such as a sheet: how thick the solid around it is; 0 for a closed one.",
        "m",
    )
    detail: Length | None = entry(
        None,
        "Spacing of the grid of distances that stands for the mesh; finer features are lost. Left out, half "
        "of numerics.dx, or more where that would take too much memory.",
        "m",
    )
    center: Point3 = entry(ZERO, "Where the origin goes: that of the file, or `origin`.", "m")
    rotation: Angle3 = entry(ZERO, ROTATION, "degrees")

    @property
    def metres(self) -> float:
        """Return the length in the world of one unit of the file [m]."""
        return METRES[self.unit] * self.scale

    @model_validator(mode="after")
    def _check_mesh(self) -> Mesh:
        check_file(self.file, MESHES, "a mesh")
        return self


class Terrain(Shape):
    """Fill the ground below a height map; beyond its edges the height of the edge goes on."""

    roles = ("collider",)
    endless = True

    shape: Literal["terrain"] = entry("terrain", "Ground from a height map.")
    file: str = file_entry(
        "A PNG or TIFF picture of one channel seen from above (x to the right, y upward), a GeoTIFF, an Esri "
        "ASCII grid (ASC), an SRTM tile (HGT), or a NumPy array heights[x, y] (NPY), relative to the scene "
        'file; "neve:NAME" is a map that comes with Neve ([terrain](meshes.md#terrain)).',
        MAPS,
        "terrains",
    )
    size: Size2 | None = entry(
        None, "Extent along x and y; left out, that which a GeoTIFF, ASCII grid or SRTM tile states.", "m"
    )
    height: Length = entry(
        1.0,
        "Of a map of 8 or 16 bits: the height of its full range, 255 or 65535 (of heights in whole metres, "
        "65535). Of a map of real or longer numbers, an ASCII grid or an SRTM tile: a factor on them.",
        "m",
    )
    center: Point3 = entry(ZERO, "Middle of the map, at the height of the value 0.", "m")
    rotation: Angle3 = entry(ZERO, ROTATION, "degrees")

    @model_validator(mode="after")
    def _check_map(self) -> Terrain:
        check_file(self.file, MAPS, "a height map")
        return self


MOST_LETTERS = 10_000
"""Characters of a text."""


class Text(Shape):
    """Set letters: they stand upright in their own x-z plane and are `depth` thick along y."""

    roles = ("source", "emitter")

    shape: Literal["text"] = entry(
        "text", "Letters that stand upright in their own x-z plane, to be read looking along +y."
    )
    text: str = entry(
        "NEVE",
        "What is written, in any script of the font; a line break starts a new line.",
        "",
        min_length=1,
    )
    font: str = file_entry(
        'A .ttf or .otf file, relative to the scene file; "" is the font that comes with Neve.',
        (".ttf", ".otf"),
    )
    height: Length = entry(
        1.0, "Height of a capital letter (of the tallest glyph if the font has no capitals).", "m"
    )
    depth: Length = entry(0.4, "Thickness of the letters along their own y.", "m")
    center: Point3 = entry((0.0, 0.0, 1.0), "Centre of the box around all letters.", "m")
    rotation: Angle3 = entry(ZERO, ROTATION, "degrees")

    def thinnest(self) -> tuple[str, float] | None:
        """Return its depth [m]."""
        return "depth", self.depth

    def reach(self) -> float:
        """Return about half of the diagonal of the box around all letters [m]."""
        lines = self.text.splitlines()
        return 0.5 * self.height * math.hypot(max(map(len, lines)), 1.5 * len(lines))

    @model_validator(mode="after")
    def _check_letters(self) -> Text:
        if not self.text.strip():
            raise wrong("text", "must hold at least one letter that is not a space")
        if len(self.text) > MOST_LETTERS:
            raise wrong("text", f"must have at most {MOST_LETTERS:,} characters; it has {len(self.text):,}")
        return self


FROM_FILES: tuple[type[Shape], ...] = (Layer, Text, Mesh, Terrain, Snowfall, Lying)
"""The shapes that are read from files, or may be, or follow from the others."""
