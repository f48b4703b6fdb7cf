"""Shapes that are read from files: meshes, height maps and letters."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import model_validator

from neve.scene.schema.shapes import ROTATION, Shape
from neve.scene.values.fields import (
    ZERO,
    Angle3,
    Distance,
    FarPoint3,
    Length,
    Point3,
    Size2,
    check_file,
    entry,
    file_entry,
    wrong,
)

MESHES = (".obj", ".ply", ".stl", ".glb", ".gltf")
"""What a mesh file may end in."""
MAPS = (".png", ".tif", ".tiff", ".asc", ".hgt", ".npy")
"""What a height map may end in."""
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Length of each unit of a mesh file [m]."""


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

    roles = ("source",)

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


FROM_FILES: tuple[type[Shape], ...] = (Text, Mesh, Terrain)
"""The shapes that are read from files."""
