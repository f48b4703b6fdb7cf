"""The door to Mitsuba 3, which is loaded when the first picture is asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

VARIANT = "scalar_rgb"
"""It needs no LLVM: the variant for that ends the whole process with the LLVM of some systems."""


class RenderError(RuntimeError):
    """One sentence for the user: why there is no picture."""


def mitsuba(threads: int = 0) -> Any:
    """Return the module of Mitsuba, ready to render on `threads` threads (0: all).

    Errors: RenderError if it is not installed, or cannot be loaded here.
    """
    try:
        import drjit
        import mitsuba as mi
    except ImportError as error:
        raise RenderError(
            f"path-traced pictures need Mitsuba 3 ({error}): pip install mitsuba mitsuba-oidn."
        ) from error
    if mi.variant() != VARIANT:
        mi.set_variant(VARIANT)
    if threads:
        drjit.set_thread_count(threads)
    return mi


def triangles(
    name: str,
    vertices: NDArray[Any],
    faces: NDArray[Any],
    properties: dict[str, Any],
    normals: NDArray[Any] | None = None,
    places: NDArray[Any] | None = None,
    colors: NDArray[Any] | None = None,
    wet: NDArray[Any] | None = None,
) -> Any:
    """Return a mesh of Mitsuba.

    vertices (n, 3) [m]; faces (m, 3); properties: "bsdf" and "interior", loaded or as dictionaries;
    normals (n, 3); places (n, 2): texture coordinates; colors (n, 3): reflectance at each vertex, as the
    attribute "vertex_color". wet (n,): how much of a film of water lies there, as "vertex_wet".
    """
    mi = mitsuba()
    held = mi.Properties()
    for key, value in properties.items():
        held[key] = mi.load_dict(value) if isinstance(value, dict) else value
    mesh = mi.Mesh(name, len(vertices), len(faces), held, normals is not None, places is not None)
    if colors is not None:
        mesh.add_attribute("vertex_color", 3, _flat(colors))
    if wet is not None:
        mesh.add_attribute("vertex_wet", 1, _flat(wet))
    parameters = mi.traverse(mesh)
    _fill(parameters, "vertex_positions", _flat(vertices))
    _fill(parameters, "faces", np.ascontiguousarray(faces, np.uint32).ravel())
    if normals is not None:
        _fill(parameters, "vertex_normals", _flat(normals))
    if places is not None:
        _fill(parameters, "vertex_texcoords", _flat(places))
    parameters.update()
    return mesh


def _fill(parameters: Any, key: str, values: NDArray[Any]) -> None:
    """Write numbers into a mesh, in place where its memory is at hand: Mitsuba's own way compares them with
    what was there first, one by one."""
    held = np.asarray(parameters[key])
    if held.flags.owndata or held.shape != values.shape or held.dtype != values.dtype:
        parameters[key] = values
    else:
        held[...] = values
        parameters.set_dirty(key)


def wetted(dry: dict[str, Any], under: dict[str, Any], roughness: float) -> dict[str, Any]:
    """Return a material: `dry` where the attribute "vertex_wet" is 0, under a film of water where it is 1.

    under: reflectance of what lies below the water; roughness: of the film.
    """
    film = {"type": "principled", "base_color": under, "roughness": roughness, "eta": 1.33}
    return {"type": "blendbsdf", "weight": attribute("wet"), "dry": dry, "film": film}


def attribute(name: str) -> dict[str, Any]:
    """Return the texture of what `triangles` was given for each vertex: "color" or "wet"."""
    return {"type": "mesh_attribute", "name": f"vertex_{name}"}


def bitmap(values: NDArray[Any], interpolated: bool = True) -> dict[str, Any]:
    """Return a texture that repeats, of linear values (h, w, 3) or (h, w, 1)."""
    return {
        "type": "bitmap",
        "bitmap": mitsuba().Bitmap(np.ascontiguousarray(values, np.float32)),
        "raw": True,
        "wrap_mode": "repeat",
        "filter_type": "bilinear" if interpolated else "nearest",
    }


def rgb(color: tuple[float, ...] | NDArray[Any]) -> dict[str, Any]:
    """Return a colour as Mitsuba reads it."""
    return {"type": "rgb", "value": [float(c) for c in color]}


def _flat(values: NDArray[Any]) -> NDArray[np.float32]:
    return np.ascontiguousarray(values, np.float32).ravel()
