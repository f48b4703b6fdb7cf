"""Set down what a page adds: how large it is, and how far up it must go to lie on what is there."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.maps.reading import read_map
from neve.geometry.mesh import read_mesh
from neve.geometry.terrain import height_field
from neve.scene.reading.files import OWN, own_files
from neve.scene.schema.roles import SHAPES
from neve.scene.schema.scene import Numerics, Scene
from neve.scene.schema.shapes import Shape
from neve.scene.schema.tables import shapes
from neve.viewer.protocol.messages import Addable, vector

CELLS = 12
"""Cells of the grid along an edge of what is added."""
MAP_CELLS = 160
"""Cells of the grid along the longer side of a height map that states no size."""
RELIEF = 0.15
"""Height of the full range of such a map of whole numbers, over its longer side."""


def addable(kind: str, dx: float) -> list[Addable]:
    """Return the shapes of a list that need nothing but a place, and the meshes that come with Neve.

    Not a snowfall, which comes before a run, on all that is there.
    Endless ones are last: what is added lies where it is put, and hides nothing.
    """
    found = []
    for shape, model in shapes(Scene.model_fields[kind].annotation).items():
        if shape == "mesh":
            found += [f"mesh:{name}" for name in own_files("meshes")]
        elif "file" not in model.model_fields and shape != "snowfall":
            found.append(shape)
    found.sort(key=lambda shape: SHAPES[shape.partition(":")[0]].endless)
    return [{"shape": shape, "half": vector(half_of(shape, dx))} for shape in found]


def keys_of(shape: str, at: Any, dx: float, meshes: Mapping[str, Path] | None = None) -> dict[str, Any]:
    """Return the keys of an entry of `shape` that stands on `at` [m] (3,), some cells of `dx` large."""
    word, _, file = shape.partition(":")
    fields, size = SHAPES[word].model_fields, CELLS * dx
    keys: dict[str, Any] = {"shape": word}
    if file:
        name = str((meshes or {}).get(file, f"{OWN}{file}"))
        if word == "terrain":
            return keys | {"file": name, "center": list(at)} | _sizes_of_map(name, dx)
        return keys | {"file": name, "origin": "bottom", "center": list(at)}
    sizes = {"radius": 0.5 * size, "size": [size] * 3, "height": size, "depth": 0.5 * size}
    keys |= {key: value for key, value in sizes.items() if key in fields}
    if word == "layer":
        keys |= {"center": list(at[:2]), "size": [3 * size] * 2, "base": at[2]}
    elif "point" in fields:
        keys["point"] = list(at)
    elif "center" in fields:
        keys["center"] = [at[0], at[1], at[2] + 0.5 * size]
    return keys


def half_of(shape: str, dx: float, meshes: Mapping[str, Path] | None = None) -> tuple[float, ...]:
    """Return half of the edges [m] of the box that stands on the place of what is added; zeros if endless."""
    word, _, file = shape.partition(":")
    model: type[Shape] = SHAPES[word]
    if model.endless:
        return 0.0, 0.0, 0.0
    if file:
        return half_of_file(shape, str((meshes or {}).get(file, f"{OWN}{file}")), dx)
    keys = keys_of(shape, (0.0, 0.0, 0.0), dx)
    known = model.model_validate({key: value for key, value in keys.items() if key in model.model_fields})
    half = known.half_extents()
    return half if any(half) else (0.5 * CELLS * dx,) * 3


@cache
def half_of_file(shape: str, file: str, dx: float) -> tuple[float, ...]:
    """Return half of the edges [m] of the box about a mesh or a height map that stands on its place.

    Errors: SceneError: it cannot be read.
    """
    if shape.startswith("terrain:"):
        keys = {"shape": "terrain", "file": file, **_sizes_of_map(file, dx)}
        field = height_field(SHAPES["terrain"].model_validate(keys), file)  # type: ignore[arg-type]
        heights = np.asarray(field.heights)
        return (*(0.5 * float(side) for side in field.size), 0.5 * float(np.ptp(heights)))
    mesh = SHAPES["mesh"].model_validate({"shape": "mesh", "file": file, "origin": "bottom"})
    corners = np.asarray(read_mesh(mesh, file).vertices)  # type: ignore[arg-type]
    reach = np.abs(corners).max(axis=0)
    return float(reach[0]), float(reach[1]), 0.5 * float(reach[2])


def _sizes_of_map(file: str, dx: float) -> dict[str, Any]:
    """Return the keys that a height map needs beside its file: size, height, a turn. Errors: SceneError."""
    found = read_map(Path(file), file)
    if found.pixel is not None:
        return {"rotation": [0.0, 0.0, found.turn]} if found.turn else {}
    shape = np.array(found.values.shape[:2], float)
    longer = MAP_CELLS * dx
    keys: dict[str, Any] = {"size": (longer * shape / shape.max()).round(6).tolist()}
    return keys | ({"height": round(RELIEF * longer, 6)} if found.full is not None else {})


def lifted(at: Any, half: Any, x: NDArray[Any], numerics: Numerics) -> float:
    """Return how far up [m] a box of half edges `half` that stands on `at` must go to be clear of snow.

    x: positions of the snow [m] (n, 3). 0 if there is no snow in the box.
    """
    gap = numerics.spacing
    near = np.abs(x[:, :2] - np.asarray(at[:2])) < np.asarray(half[:2]) + 0.5 * gap
    column = x[near.all(axis=1), 2]
    inside = (column > at[2] - 0.5 * gap) & (column < at[2] + 2.0 * half[2] + 0.5 * gap)
    if not any(half) or not inside.any():
        return 0.0
    return float(column.max()) + gap - float(at[2])
