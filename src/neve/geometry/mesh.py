"""Read a mesh file into triangles in metres, z up, and refuse one that encloses nothing."""

from __future__ import annotations

import json
import math
import os
import struct
import warnings
import weakref
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neve.geometry.declared import require_modest
from neve.geometry.files import Surface, Unreadable, read
from neve.geometry.triangles import Triangles, tidied
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.files import where
from neve.scene.schema.file_shapes import Mesh

Array = NDArray[np.float64]

SAMPLES = 4000
"""Points around an open surface at which its winding number is asked for."""
FARTHEST = 1e6
"""Distance of a vertex from the origin of its solid, along each axis [m]."""
FAR_CELLS = 1e4
"""Distance of a solid from its origin, in cells, from which on single precision is told: 1e-3 of a cell."""
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
    made_of = (_mark(path), mesh.up, mesh.metres, mesh.origin, mesh.thickness > 0)
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
    if not np.isfinite(vertices[faces]).all():
        raise SceneError(f"{_key(mesh, name)} has a vertex whose coordinates are no finite numbers")
    if mesh.origin is not None:
        vertices = vertices - _origin(vertices[np.unique(faces)], mesh)
    if mesh.up == "y":
        vertices = vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    reach = float(np.abs(vertices[faces]).max()) * mesh.metres
    if reach > FARTHEST:
        raise SceneError(
            f"{_key(mesh, name)} reaches beyond 1e6 m (to {reach:.3g} m) from its origin: set "
            f'{name}.origin = "center" (or a point of the file), {name}.unit or a smaller {name}.scale'
        )
    surface = tidied(vertices * mesh.metres, faces, sheet=mesh.thickness > 0)
    if not len(surface.faces):
        raise SceneError(f"{_key(mesh, name)} has no area: all of its triangles are points or lines")
    return surface


def _origin(vertices: Array, mesh: Mesh) -> Array:
    """Return the point of the file that becomes the origin of the solid, in its own units and axes (3,)."""
    if isinstance(mesh.origin, tuple):
        return np.array(mesh.origin)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle = 0.5 * (low + high)
    if mesh.origin == "bottom":
        up = 1 if mesh.up == "y" else 2
        middle[up] = low[up]
    return np.asarray(middle)


def warn_if_far(surface: Triangles, mesh: Mesh, dx: float, name: str) -> None:
    """Warn with SceneWarning of a mesh so far from its origin that single precision shifts it visibly."""
    low, high = surface.low, surface.high
    far = float(np.maximum(np.abs(low), np.abs(high)).max())
    if far > FAR_CELLS * dx and far > 10 * float((high - low).max()):
        warnings.warn(
            f"{_key(mesh, name)} lies {far:.3g} m from its origin, where single precision is coarse: set "
            f'{name}.origin = "center" (or a point of the file), and {name}.center to where that goes',
            SceneWarning,
            stacklevel=2,
        )


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


def _read(path: Path, key: str) -> Surface:
    """Return vertices (n, 3) and faces (m, 3) of all that the file holds, in its own units and axes."""
    notes: list[str] = []
    try:
        require_modest(path, key)
        with np.errstate(all="ignore"):
            surface = read(path, notes)
    except SceneError:
        raise
    except MemoryError:
        raise SceneError(f"{key} cannot be read: it takes too much memory, or is damaged") from None
    except OSError as error:
        reason = (error.strerror or str(error)).rstrip(".")
        raise SceneError(f"{key} cannot be read: {reason[:1].lower()}{reason[1:]}") from None
    except Unreadable as error:
        raise SceneError(f"{key} cannot be read: {error}") from None
    except (
        ArithmeticError,
        AttributeError,
        LookupError,
        RecursionError,
        TypeError,
        ValueError,
        struct.error,
    ):
        # tables of a glTF file that are not what their names say
        raise SceneError(
            f"{key} cannot be read: it is damaged, or not the kind of file that its name says"
        ) from None
    for note in notes:
        warnings.warn(f"{key} {note}", SceneWarning, stacklevel=2)
    return surface
