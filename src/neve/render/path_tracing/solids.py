"""Colliders and bodies as meshes with materials: paint, metal, rubber, wood, stone."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.colliders.triangles import triangles as surface
from neve.geometry.heights import thinned, triangulated
from neve.render.lighting import STEEL
from neve.render.path_tracing.engine import bitmap, mitsuba, triangles
from neve.render.path_tracing.textures import tile

if TYPE_CHECKING:
    from neve.colliders.solid import Solid

Array = NDArray[np.float64]

SHARP = math.cos(math.radians(35.0))
"""Faces that turn by more than this at an edge keep their own normals there."""
WIDE = 1e3
"""Half of the side of an endless plane that is painted [m]."""
GROUND = "ground"
"""What terrain is made of that has no finish: it is no solid with a coat of paint."""
SIDE = 512
"""Pixels along a texture's side."""
MOST_HEIGHTS = 1024
"""Samples of a height map along each side at most: a larger one is thinned."""


class Materials:
    """Make the material of each solid, once for all frames."""

    def __init__(self) -> None:
        self._textures: dict[tuple[str, tuple[float, ...]], dict[str, Any]] = {}

    def of(self, solid: Solid) -> dict[str, Any]:
        """Return the bsdf of a solid, by its finish and colour."""
        finish = solid.finish or ("paint" if solid.terrain is None else GROUND)
        color = tuple(float(c) for c in solid.color or STEEL)
        key = finish, color
        if key not in self._textures:
            self._textures[key] = {"type": "twosided", "bsdf": _coat(finish, np.asarray(color))}
        return self._textures[key]


def _coat(finish: str, color: Array) -> dict[str, Any]:
    wear = tile(SIDE, 4, 8, 0.66, 131)
    if finish == GROUND:  # without a relief, whose pixels a camera that is near would see as facets
        return {"type": "diffuse", "reflectance": _tinted(color, 1.0 + 0.18 * wear)}
    if finish == "stone":
        grit = tile(SIDE, 48, 4, 0.8, 177)
        tone = 1.0 + 0.22 * wear + 0.20 * grit
        look: dict[str, Any] = {"type": "diffuse", "reflectance": _tinted(color, tone)}
        return _bumped(look, 0.5 * wear + 0.35 * grit, 0.012)
    if finish == "wood":
        rows = tile(SIDE, 8, 6, 0.6, 307)
        fibre = np.repeat(tile(SIDE, 64, 3, 0.7, 311)[:, ::16], 16, axis=1)
        return {
            "type": "roughplastic",
            "alpha": 0.3,
            "diffuse_reflectance": _tinted(color, 1 + 0.25 * rows + 0.25 * fibre),
        }
    if finish == "metal":
        rough = np.clip(0.32 + 0.12 * wear, 0.1, 0.7)
        return {
            "type": "principled",
            "base_color": _tinted(np.minimum(2.2 * color, 0.92), 1.0 + 0.05 * wear),
            "metallic": 1.0,
            "roughness": bitmap(rough[..., None]),
        }
    if finish == "rubber":
        return {
            "type": "principled",
            "base_color": _tinted(color, 1.0 + 0.12 * wear),
            "roughness": 0.75,
            "specular": 0.4,
        }
    # Paint that has weathered: lighter where it is worn, with a dull gloss.
    worn = np.clip(wear - 0.35, 0.0, 1.0)
    speckled = tile(SIDE, 96, 3, 0.8, 23)
    tone = 1.0 + 0.14 * wear + 0.10 * speckled + 0.5 * worn
    look = {"type": "roughplastic", "alpha": 0.35, "diffuse_reflectance": _tinted(color, tone)}
    return _bumped(look, 0.3 * wear + 0.25 * speckled, 0.004)


def _tinted(color: Array, tone: NDArray[Any]) -> dict[str, Any]:
    return bitmap(np.clip(color * tone[..., None], 0.0, 0.95))


def _bumped(bsdf: dict[str, Any], height: NDArray[Any], strength: float) -> dict[str, Any]:
    """Return a material with a relief; strength: height of 1 in sides of the texture."""
    return {"type": "bumpmap", "arbitrary": bitmap(strength * height[..., None]), "bsdf": bsdf}


def solid_shape(solid: Solid, position: Array, rotation: Array, bsdf: Any, name: str) -> Any:
    """Return a solid as a mesh of Mitsuba, where it is in the frame.

    Its texture is laid on from the six sides along its own axes, one tile for each two metres, or for the
    solid's size where it is smaller.
    """
    vertices, faces = outline(solid)
    corners, normals = _creased(vertices, faces)
    reach = float(np.abs(vertices).max()) if not solid.endless else 1.0
    places = _boxed(corners, _face_normals(corners), 1.0 / min(2.0, max(2.0 * reach, 1e-6)))
    order = np.arange(len(corners)).reshape(-1, 3)
    return triangles(
        name, corners @ rotation.T + position, order, {"bsdf": bsdf}, normals @ rotation.T, places
    )


def loaded(bsdf: dict[str, Any]) -> Any:
    """Return a material as Mitsuba's own object."""
    return mitsuba().load_dict(bsdf)


def outline(solid: Solid) -> tuple[Array, NDArray[np.int64]]:
    """Return vertices (n, 3) [m] in the solid's own frame and faces (m, 3), anticlockwise from outside."""
    if solid.terrain is not None:
        return _field(np.asarray(solid.terrain.heights, np.float64), solid.terrain.size)
    vertices, faces = surface(solid, WIDE, MOST_HEIGHTS)
    return vertices, faces.astype(np.int64)


def _field(heights: Array, size: tuple[float, float]) -> tuple[Array, NDArray[np.int64]]:
    """Return the triangles of a terrain; beyond its edge it goes on level, as far as can be seen."""
    x, y, z = thinned(heights, size, MOST_HEIGHTS)
    far = 50.0 * max(size)
    x, y = np.concatenate([[-far], x, [far]]), np.concatenate([[-far], y, [far]])
    corners, faces = triangulated(x, y, np.pad(z, 1, mode="edge"))
    return corners, faces.astype(np.int64)


def _face_normals(corners: Array) -> Array:
    """Return the unit normal of each triangle of `corners` (3 m, 3), (m, 3)."""
    a, b, c = corners[0::3], corners[1::3], corners[2::3]
    n = np.cross(b - a, c - a)
    return np.asarray(n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-30))


def _creased(vertices: Array, faces: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return the corners of all faces (3 m, 3) and their normals: smooth, but for sharp edges."""
    corners = vertices[faces.ravel()]
    flat = np.repeat(_face_normals(corners), 3, axis=0)
    _, same = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    at = same.ravel()[faces.ravel()]
    a, b, c = corners[0::3], corners[1::3], corners[2::3]
    area = np.repeat(np.linalg.norm(np.cross(b - a, c - a), axis=1), 3)[:, None]
    total = np.zeros((at.max() + 1, 3))
    np.add.at(total, at, flat * area)
    smooth = total[at]
    smooth /= np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-30)
    return corners, np.where((smooth * flat).sum(axis=1, keepdims=True) > SHARP, smooth, flat)


def _boxed(corners: Array, normals: Array, scale: float) -> Array:
    """Return texture coordinates (3 m, 2): the two axes along which each face extends most."""
    along = np.repeat(np.abs(normals).argmax(axis=1), 3)
    first, second = np.array([1, 0, 0])[along], np.array([2, 2, 1])[along]
    rows = np.arange(len(corners))
    return np.stack([corners[rows, first], corners[rows, second]], axis=1) * scale
