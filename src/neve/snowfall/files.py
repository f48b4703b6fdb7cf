"""Files of snow that lies: a cover with its layers, or the particles that a run left."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.scene.errors import SceneError
from neve.snowfall.cover import Books, Cover, Raster, columns_over
from neve.snowfall.layers import Layers
from neve.snowfall.surroundings import Surroundings
from neve.system import disk

Arrays = dict[str, NDArray[Any]]

FORMAT = 1
"""Version of the layout of these files."""


def arrays_of(cover: Cover) -> Arrays:
    """Return the arrays of a file that `cover_of` reads back."""
    raster, around = cover.raster, cover.surroundings
    return {
        "lying_format": np.array(FORMAT),
        "kind": np.array("cover"),
        "raster": np.array([*raster.low, raster.cell]),
        "cells": np.array([raster.nx, raster.ny]),
        "vertices": around.vertices,
        "faces": around.faces,
        "part": around.part,
        "names": np.array(json.dumps([around.kinds, around.names])),
        "depth": cover.depth,
        "share": cover.share,
        "books": np.array(json.dumps(vars(cover.books))),
        **{f"layers.{name}": values for name, values in cover.layers.arrays().items()},
    }


def read_lying(path: Path, key: str) -> Arrays:
    """Return the arrays of a file of lying snow. Errors: SceneError; `key` names the file in its sentence."""
    shown = json.dumps(str(path), ensure_ascii=False)
    try:
        with disk.open_regular(path) as file, np.load(file, allow_pickle=False) as archive:
            found = {name: archive[name] for name in archive.files}
        version, kind = int(found["lying_format"]), str(found["kind"])
    except OSError as error:
        raise SceneError(f"{key} = {shown} cannot be read: {error.strerror or error}") from error
    except Exception as error:  # whatever a damaged file makes its reader stumble over
        raise SceneError(f"{key} = {shown} is damaged, or no snow that lies: {NEEDS}") from error
    if version != FORMAT or kind not in ("cover", "particles"):
        raise SceneError(f"{key} = {shown} was written by another version of Neve: write it again")
    return found


NEEDS = "name a cover.npz of neve snow or neve age, or a rest.npz of neve snow RUN"


def cover_of(found: Arrays, key: str) -> Cover:
    """Return the cover of the arrays of a file. Errors: SceneError for a file that is damaged."""
    try:
        (x, y, cell), (nx, ny) = found["raster"].tolist(), found["cells"].tolist()
        raster = Raster((x, y), cell, nx, ny)
        kinds, names = json.loads(str(found["names"]))
        around = Surroundings(
            np.ascontiguousarray(found["vertices"], np.float64),
            np.ascontiguousarray(found["faces"], np.int32),
            np.ascontiguousarray(found["part"], np.int32),
            tuple(kinds),
            tuple(names),
        )
        columns = columns_over(raster, around)
        layers = Layers(
            **{name.partition(".")[2]: a for name, a in found.items() if name.startswith("layers.")}
        )
        count = len(columns.z())
        shapes = {a.shape for a in layers.arrays().values()}
        if len(shapes) > 1 or any(found[name].shape != (count,) for name in ("depth", "share")):
            raise ValueError("arrays of other places")
        if shapes.pop()[0] != count or not all(np.isfinite(a).all() for a in layers.arrays().values()):
            raise ValueError("layers of other places")
        books = Books(**json.loads(str(found["books"])))
    except (KeyError, ValueError, TypeError) as error:
        raise SceneError(f"{key} is damaged, or no cover of snow: {NEEDS}") from error
    return Cover(raster, columns, columns.z(), found["depth"], found["share"], layers, around, books)
