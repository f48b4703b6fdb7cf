"""A folder for what took long to compute: files by the hash of all that they follow from."""

from __future__ import annotations

import contextlib
import logging
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.system import disk

LIMIT = 2 * 2**30
"""Bytes that the folder may take; beyond them the files that were not used for longest go."""

_log = logging.getLogger("neve")


def folder() -> Path | None:
    """Return where cached files lie: NEVE_CACHE, or `neve` in XDG_CACHE_HOME or ~/.cache; None for none.

    NEVE_CACHE set to nothing switches caching off; so does a system without a home.
    """
    own = os.environ.get("NEVE_CACHE")
    if own is not None:
        return Path(own).expanduser() if own else None
    shared = os.environ.get("XDG_CACHE_HOME")
    try:
        return Path(shared) / "neve" if shared and os.path.isabs(shared) else Path.home() / ".cache" / "neve"
    except RuntimeError:
        return None


def size() -> int:
    """Return how many bytes the cached files take."""
    return sum(stat.st_size for _, stat in _files())


def recall(key: str) -> dict[str, NDArray[Any]] | None:
    """Return the arrays that were kept as `key`; None if there are none, or the file is damaged."""
    kept_in = folder()
    if kept_in is None:
        return None
    path = kept_in / f"{key}.npz"
    try:
        with disk.open_regular(path) as file, np.load(file, allow_pickle=False) as arrays:
            found = {name: arrays[name] for name in arrays.files}
    except FileNotFoundError:
        return None
    except Exception as error:  # whatever a damaged file makes its reader stumble over
        _log.warning("%s is damaged (%s) and is made again", path, error)
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # used now: it is the last to go
    return found


def keep(key: str, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Keep `arrays` as `key`, whole or not at all; a folder that refuses is only logged."""
    kept_in = folder()
    if kept_in is None:
        return
    try:
        disk.make_folder(kept_in)
        with disk.replacing(kept_in / f"{key}.npz") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]
        _prune(spared=kept_in / f"{key}.npz")
    except OSError as error:
        _log.warning("nothing is kept in the cache folder %s: %s", kept_in, error.strerror or error)


def _files() -> list[tuple[Path, os.stat_result]]:
    kept_in = folder()
    found = []
    with contextlib.suppress(OSError):
        for path in kept_in.glob("*.npz") if kept_in else ():
            with contextlib.suppress(OSError):
                found.append((path, path.stat()))
    return found


def _prune(spared: Path) -> None:
    """Remove the files that were not used for longest until all fit in LIMIT."""
    files = sorted(_files(), key=lambda entry: entry[1].st_mtime)
    excess = sum(stat.st_size for _, stat in files) - LIMIT
    for path, stat in files:
        if excess <= 0:
            return
        if path != spared:
            with contextlib.suppress(OSError):
                disk.remove(path)
                excess -= stat.st_size
