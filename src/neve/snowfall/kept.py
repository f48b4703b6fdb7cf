"""Falls that were counted before: kept in the cache folder, by the hash of all that they follow from."""

from __future__ import annotations

import contextlib
import hashlib
import json
from dataclasses import asdict
from functools import cache as once
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve import _core, reproducible
from neve.geometry import cache
from neve.scene.schema import snowfall as schema
from neve.scene.schema.snowfall import Snowfall
from neve.snowfall.cover import Books, Cover, Raster, ages, columns_over, let_fall, warn_of
from neve.snowfall.layers import Layers
from neve.snowfall.surroundings import Surroundings

WORTH = 200_000
"""Flakes from which on a fall is kept: about a second of processor time."""


def fallen_once(fall: Snowfall, surroundings: Surroundings, raster: Raster) -> Cover:
    """Return the cover that `let_fall` gives, to the bit; from the cache folder if it was counted before."""
    key = key_of(fall, surroundings, raster)
    found = cache.recall(key)
    if found is not None:
        with contextlib.suppress(KeyError, ValueError, TypeError):  # of another make: counted again
            cover = _cover(found, fall, surroundings, raster)
            warn_of(fall, cover.books)
            return cover
    cover = let_fall(fall, surroundings, raster)
    if cover.books.flakes >= WORTH:
        books = np.array(json.dumps(asdict(cover.books)))
        kept = {"depth": cover.depth, "share": cover.share, "thickness": cover.layers.thickness}
        cache.keep(key, {**kept, "books": books})
    return cover


def key_of(fall: Snowfall, surroundings: Surroundings, raster: Raster) -> str:
    """Return the SHA-256 of all that a cover follows from, the code that counts it among it."""
    numbers = [*raster.low, raster.cell, raster.nx, raster.ny]
    follows = [fall.open_depth, fall.new_density]
    words = [_code(), fall.model_dump_json(), follows, numbers, surroundings.kinds]
    digest = hashlib.sha256(f"neve fall {json.dumps(words)}".encode())
    for values in (surroundings.vertices, surroundings.faces, surroundings.part):
        digest.update(f"{values.dtype}{values.shape}".encode())
        digest.update(np.ascontiguousarray(values).data)
    return digest.hexdigest()


@once
def _code() -> str:
    """Return the SHA-256 of all code that counts: what was counted by other code is counted again."""
    digest = hashlib.sha256(np.__version__.encode())
    others = (Path(module.__file__ or "") for module in (_core, reproducible, schema))
    for path in (*others, *sorted(Path(__file__).parent.glob("*.py"))):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _cover(
    found: dict[str, NDArray[Any]], fall: Snowfall, surroundings: Surroundings, raster: Raster
) -> Cover:
    """Return the cover of kept arrays. Errors: KeyError, ValueError, TypeError for those of another make."""
    columns = columns_over(raster, surroundings)
    n = len(columns.z())
    depth, share, thickness = (found[name] for name in ("depth", "share", "thickness"))
    if (depth.shape, share.shape, thickness.shape) != ((n,), (n,), (n, fall.steps)):
        raise ValueError("arrays of other places")
    books = Books(**json.loads(str(found["books"])))
    layers = Layers.fresh(thickness, fall.new_density, fall.temperature, ages(fall))
    return Cover(raster, columns, columns.z(), depth, share, layers, surroundings, books)
