"""Describe what is read from a mesh file: by bodies that snow meets and by sources of snow."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from neve.scene.schema.allowed import words
from neve.scene.schema.fields import Distance, Length, Part, entry, file_entry, wrong

MESHES = (".obj", ".ply", ".stl", ".glb", ".gltf")
"""What a mesh file may end in."""

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Length of each unit of a mesh file [m]."""


class MeshFile(Part):
    """Name a mesh file, and say how its numbers are meant."""

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
    thickness: Distance = entry(
        0.0,
        "Of an open mesh, such as a sheet: how thick the body around it is; 0 for a closed one.",
        "m",
    )
    detail: Length | None = entry(
        None,
        "Spacing of the grid of distances that stands for the mesh; finer features are lost. Left out, half "
        "of numerics.dx, or more where that would take too much memory.",
        "m",
    )

    @model_validator(mode="after")
    def _file(self) -> MeshFile:
        check_file(self.file, MESHES, "a mesh")
        return self

    @property
    def metres(self) -> float:
        """Return the length in the world of one unit of the file [m]."""
        return METRES[self.unit] * self.scale


def check_file(name: str, suffixes: tuple[str, ...], what: str) -> None:
    """Refuse a `file` that is left out or ends in none of `suffixes`.

    Errors: PydanticCustomError.
    """
    if not name:
        raise wrong("file", f"must name {what}, a file that ends in {words(suffixes)}")
    if not name.startswith("neve:") and not name.lower().endswith(suffixes):
        raise wrong("file", f"must end in {words(suffixes)}")
