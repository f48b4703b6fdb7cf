"""`neve drive --snow`: ground and snow of a fall as a texture for the page, `ground.json` beside them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.drive.packing import LARGEST, STEP, packed, steps
from neve.io.atomic import write_text
from neve.scene.errors import SceneError
from neve.snowfall.cover import Cover
from neve.snowfall.files import cover_of, read_lying

Array = NDArray[np.float64]

COVER, FILE = "cover.npz", "ground.json"
FORMAT = 1
LATTICE = 0.5
"""Distance of the points between which the page's ground is straight [m]: finer cells are put together."""


def write_ground(folder: str) -> Path:
    """Write ground and depth of the snow of a folder of `neve snow` or `neve age`; return the file.

    Errors: SceneError for a folder without a cover, or a cover with holes between its places; RunError.
    """
    path = Path(folder) / COVER
    found = read_lying(path, "--snow")
    if str(found["kind"]) != "cover":
        raise SceneError(f"--snow {folder}: {COVER} holds particles of a run, no cover of snow")
    content = ground_of(cover_of(found, f"--snow {folder}"), Path(folder).resolve().name)
    file = Path(folder) / FILE
    write_text(file, json.dumps(content, separators=(",", ":"), allow_nan=False) + "\n")
    return file


def ground_of(cover: Cover, name: str) -> dict[str, Any]:
    """Return what the file holds: of square cells, `ground` [`step` m] above the least and `depth` [STEP m].

    Both are (nx, ny), as `neve.drive.packing` packs them, of the lowest place of each column that lies under
    open space, the mean of all columns of a cell. Errors: SceneError.
    """
    low, snow = lowest(cover)
    if np.isnan(low).any():
        bare = 100.0 * np.isnan(low).mean()
        raise SceneError(
            f"--snow {name}: nothing lies below {bare:.3g} % of its rectangle, and a car needs ground "
            "everywhere: let it snow on a terrain or a plane, or on a mesh with --ground"
        )
    many = max(1, min(round(LATTICE / cover.raster.cell), *low.shape))
    ground, depth = (coarser(values, many) for values in (low, snow))
    base = float(ground.min())
    step = max(STEP, float(ground.max() - base) / LARGEST)
    return {
        "format": FORMAT,
        "name": name,
        "cell": many * cover.raster.cell,
        "nx": ground.shape[0],
        "ny": ground.shape[1],
        "step": step,
        "ground": packed(steps(ground - base, step)),
        "depth_step": STEP,
        "depth": packed(steps(depth)),
    }


def lowest(cover: Cover) -> tuple[Array, Array]:
    """Return height and depth of snow of the lowest place of each column (nx, ny) [m]; NaN without one."""
    column = cover.columns.column()
    last = np.flatnonzero(np.diff(column, append=-1))  # places of a column follow one another downward
    found = []
    for values in (cover.z, cover.depth):
        out = np.full(cover.raster.nx * cover.raster.ny, np.nan)
        out[column[last]] = values[last]
        found.append(out.reshape(cover.raster.nx, cover.raster.ny))
    return found[0], found[1]


def coarser(values: Array, many: int) -> Array:
    """Return the means of squares of so many cells along each side; what is left at the ends is cut off."""
    nx, ny = (n // many for n in values.shape)
    squares = values[: nx * many, : ny * many].reshape(nx, many, ny, many)
    return np.asarray(squares.mean(axis=(1, 3)))
