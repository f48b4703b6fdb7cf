"""Read a mesh file into triangles in metres, z up, and refuse one that encloses nothing."""

from __future__ import annotations

import contextlib
import json
import logging
import math
import os
import warnings
import weakref
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.declared import require_modest
from neve.geometry.triangles import Triangles, tidied
from neve.reproducible import determinant, product
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.files import where
from neve.scene.schema.file_shapes import Mesh

Array = NDArray[np.float64]

SAMPLES = 4000
"""Points around an open surface at which its winding number is asked for."""
DOUBT = 0.25
"""Distance of a winding number from a whole one, from which on a point is neither inside nor outside."""
DOUBTFUL_SHARE = 0.03
"""Share of doubtful points from which on a mesh encloses nothing."""


def read_mesh(mesh: Mesh, name: str) -> Triangles:
    """Return the surface in the file of `mesh` [m]: the file's origin is 0, z is up.

    `name`: used in messages. Warns with SceneWarning of a mesh with small holes: they are closed.
    Errors: SceneError, one sentence: unreadable, empty, no area, not finite, or open without a `thickness`.
    """
    path = where(mesh.file, "meshes")
    made_of = (_mark(path), mesh.up, mesh.metres)
    surface = _in_use.get(made_of)
    if surface is None:
        _in_use[made_of] = surface = _surface(path, mesh, name)
    if mesh.thickness == 0:
        _require_inside(surface, mesh, name)
    return surface


_in_use: weakref.WeakValueDictionary[object, Triangles] = weakref.WeakValueDictionary()
"""What was read of a file and is still in use: a thousand colliders of one file are read once."""


def _mark(path: Path) -> tuple[object, ...]:
    """Return what tells a file from a changed one; an object like no other if nothing does.

    A .gltf file names others, which may change by themselves.
    """
    try:
        about = os.stat(path)
    except (OSError, ValueError):
        return (object(),)
    if path.suffix.lower() == ".gltf":
        return (object(),)
    return (str(path), about.st_dev, about.st_ino, about.st_size, about.st_mtime_ns, about.st_ctime_ns)


def _surface(path: Path, mesh: Mesh, name: str) -> Triangles:
    """Return the surface in the file at `path` [m], whether it has an inside or not. Errors: SceneError."""
    vertices, faces = _read(path, _key(mesh, name))
    if not len(faces):
        raise SceneError(
            f"{_key(mesh, name)} holds no triangles: it is empty, or not the kind of file that its name says"
        )
    if not np.isfinite(vertices).all():
        raise SceneError(f"{_key(mesh, name)} has a vertex whose coordinates are no finite numbers")
    if mesh.up == "y":
        vertices = vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    if (np.abs(vertices) * mesh.metres).max() > 1e6:
        raise SceneError(
            f"{_key(mesh, name)} reaches beyond 1e6 m: set {name}.unit or a smaller {name}.scale"
        )
    surface = tidied(vertices * mesh.metres, faces)
    if not len(surface.faces):
        raise SceneError(f"{_key(mesh, name)} has no area: all of its triangles are points or lines")
    return surface


def warn_if_small(surface: Triangles, mesh: Mesh, dx: float, name: str) -> None:
    """Warn with SceneWarning of a mesh that is smaller than two cells along each axis."""
    length = float((surface.high - surface.low).max()) + mesh.thickness
    if length < 2 * dx * (1 - 1e-9):
        warnings.warn(
            f"{_key(mesh, name)} is {length:.3g} m large, less than two cells of numerics.dx = {dx:g}: set "
            f"{name}.scale = {_up(mesh.scale * 2 * dx / length)} or larger, another {name}.unit, or "
            f"numerics.dx = {length / 2:.2g} or smaller",
            SceneWarning,
            stacklevel=2,
        )


def _require_inside(surface: Triangles, mesh: Mesh, name: str) -> None:
    """Refuse a surface that has no inside: whose winding number is in doubt at too many points around it.

    Where a surface has no boundary the winding number is whole anywhere (Jacobson et al. 2013, section 3).
    """
    holes = surface.open_edges
    if not holes:
        return
    if surface not in _doubt:
        _doubt[surface] = doubtful_share(surface)
    if _doubt[surface] > DOUBTFUL_SHARE:
        raise SceneError(
            f"{_key(mesh, name)} is open ({holes} edges have a face on one side only), so that it has no "
            f"inside: close it, or set {name}.thickness to make a solid of its faces"
        )
    warnings.warn(
        f"{_key(mesh, name)} has small holes ({holes} edges with a face on one side only), which are closed "
        "as smoothly as the rest allows: check the film, or mend the mesh",
        SceneWarning,
        stacklevel=2,
    )


_doubt: weakref.WeakKeyDictionary[Triangles, float] = weakref.WeakKeyDictionary()


def doubtful_share(surface: Triangles) -> float:
    """Return the share of points in the box around `surface`, with a margin, that are neither in nor out."""
    size = surface.high - surface.low
    margin = 0.1 * float(size.max())
    rng = np.random.default_rng(0)
    points = surface.low - margin + rng.random((SAMPLES, 3)) * (size + 2 * margin)
    winding = surface.tree.winding(points)
    return float(np.mean(np.abs(winding - np.rint(winding)) > DOUBT))


def _key(mesh: Mesh, name: str) -> str:
    return f"{name}.file = {json.dumps(mesh.file, ensure_ascii=False)}"


def _up(value: float) -> str:
    digits = 1 - math.floor(math.log10(value))
    return f"{math.ceil(value * 10.0**digits - 1e-9) / 10.0**digits:g}"


def _read(path: Path, key: str) -> tuple[Array, NDArray[np.int64]]:
    """Return vertices (n, 3) and faces (m, 3) of all that the file holds, in its own units and axes."""
    import trimesh

    try:
        require_modest(path, key)
        with _silence():
            loaded = trimesh.load(str(path), process=False, skip_materials=True)
            pieces = list(_pieces(loaded))
    except SceneError:
        raise
    except MemoryError:
        raise SceneError(f"{key} cannot be read: it takes too much memory, or is damaged") from None
    except OSError as error:
        reason = (error.strerror or str(error)).rstrip(".")
        raise SceneError(f"{key} cannot be read: {reason[:1].lower()}{reason[1:]}") from None
    except Exception:  # whatever a damaged file makes its reader stumble over
        raise SceneError(
            f"{key} cannot be read: it is damaged, or not the kind of file that its name says"
        ) from None
    begin, vertices, faces = 0, [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)]
    for corners, rows in pieces:
        if len(rows) and not (rows.min() >= 0 and rows.max() < len(corners)):
            raise SceneError(f"{key} cannot be read: a triangle has a corner that is not there")
        vertices.append(corners)
        faces.append(rows + begin)
        begin += len(corners)
    return np.concatenate(vertices), np.concatenate(faces)


def _pieces(loaded: Any) -> Iterator[tuple[Array, NDArray[np.int64]]]:
    """Yield vertices and faces of every mesh in what was loaded, each where the scene graph puts it."""
    if not hasattr(loaded, "graph"):
        yield from _of(loaded, np.eye(4))
        return
    tree = loaded.graph.transforms
    for node in loaded.graph.nodes_geometry:
        transform = np.eye(4)
        for edge in pairwise(tree.shortest_path(loaded.graph.base_frame, node)):
            if (step := tree.edge_data[edge].get("matrix")) is not None:
                transform = product(transform, np.asarray(step, dtype=np.float64))
        yield from _of(loaded.geometry[loaded.graph[node][1]], transform)


def _of(geometry: Any, transform: Array) -> Iterator[tuple[Array, NDArray[np.int64]]]:
    faces = getattr(geometry, "faces", None)
    if faces is None or not len(faces):  # lines, or points
        return
    vertices = (
        product(np.asarray(geometry.vertices, dtype=np.float64), transform[:3, :3].T) + transform[:3, 3]
    )
    rows = np.asarray(faces, dtype=np.int64)
    yield vertices, rows[:, ::-1] if determinant(transform[:3, :3]) < 0 else rows


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keep the reader's own remarks about materials and the like from the user."""
    logger = logging.getLogger("trimesh")
    before, logger.disabled = logger.disabled, True
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.disabled = before
