"""Endless ground: bare earth with clods and stones, as fine as the picture shows it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.render.melt_water import Puddle
from neve.render.path_tracing.engine import attribute, triangles, wetted
from neve.render.path_tracing.lens import Lens
from neve.render.path_tracing.textures import fractal

Array = NDArray[np.float64]

CLODS = 16.0
"""Size of the largest clods in grid spacings of the snow."""
DEPTH = 1.7
"""Depth of the relief in grid spacings; it lies below the plane, so that snow rests on its peaks."""
SOIL, DRY, STONE, RIME = (
    np.array(c)
    for c in ((0.060, 0.050, 0.042), (0.150, 0.128, 0.105), (0.17, 0.16, 0.15), (0.42, 0.445, 0.48))
)
WET = np.array([0.40, 0.38, 0.37])
"""Reflectance of wet earth over that of dry: our choice."""
FILLED = 0.55
"""Share of the depth of the relief to which water fills it where it is wettest."""
HAZE = np.array([0.42, 0.44, 0.47])
"""Reflectance of what lies far away, over which the air's light has come."""
FAR = 400.0
"""How far it reaches in distances from the camera to its target."""
LEAST_FACING = 0.02
"""Cosine between the direction to the eye and normals of the ground, at least."""
LEAST = 1e-3
"""Height of a camera over the ground, in the same unit, from which the ground is laid out at least."""


def ground(
    lens: Lens, position: Array, rotation: Array, dx: float, name: str, puddle: Puddle | None = None
) -> Any:
    """Return the mesh of a plane through `position` whose normal is the last column of `rotation`.

    Its vertices lie where every second pixel of the picture meets the plane, closer to each other than what
    can be seen, and coarsely around; the relief is a function of the place alone. dx [m]: of the snow's grid.
    puddle: water that lies on it.
    """
    eye = (lens.eye - position) @ rotation
    if abs(eye[2]) < LEAST * lens.distance:  # in the plane itself nothing of it is seen
        eye[2] = LEAST * lens.distance
    u, v = _grid(lens, eye, rotation)
    far = np.hypot(u - eye[0], v - eye[1])
    pixel = 1.2 * np.hypot(far, eye[2]) / lens.focal
    height, color = relief(u, v, pixel, dx)
    film = None
    if puddle:
        height, color, film = wet_relief(height, color, puddle.wetness(u, v).astype(np.float64), dx)
    away = far / lens.distance
    veil = 1.0 - np.exp(-((np.maximum(away - 2.0, 0.0) / 25.0) ** 2))
    color = color + (HAZE - color) * veil[..., None]
    # Low hills end the view: level ground ends in a line drawn with a ruler.
    rise = np.clip((away - 25.0) / 150.0, 0.0, 1.0) ** 2
    hills = np.maximum(fractal(u, v, 160.0 * lens.distance, 4, 0.45, pixel, 401) + 0.15, 0.0)
    height = (1.0 - veil) * height + rise * hills * (0.05 * far)
    local = np.stack([u, v, height], axis=-1)
    vertices = local.reshape(-1, 3) @ rotation.T + position
    return triangles(
        name,
        vertices,
        _sides(*u.shape),
        {"bsdf": _earth() if film is None else _wet_earth()},
        normals=surface_normals(local, eye).reshape(-1, 3) @ rotation.T,
        colors=color.reshape(-1, 3),
        wet=None if film is None else film.ravel(),
    )


def relief(u: Array, v: Array, pixel: Array, dx: float) -> tuple[Array, Array]:
    """Return height [m], above 0 for stones alone, and reflectance (..., 3) of earth at places u, v [m]."""
    ridged = 1.0 - 2.0 * np.abs(fractal(u, v, CLODS * dx, 9, 0.55, pixel, 57))
    clods = fractal(u, v, 0.6 * CLODS * dx, 9, 0.6, pixel, 11)
    up = np.clip(0.45 * ridged + 0.40 * clods, -1.0, 1.0)
    stones = np.clip((fractal(u, v, 1.6 * dx, 2, 0.3, pixel, 91) - 0.62) * 3.0, 0.0, 1.0)
    height = 0.5 * DEPTH * dx * (up - 1.0) + 0.35 * dx * np.sqrt(stones)
    tint = fractal(u, v, 50.0 * dx, 6, 0.6, pixel, 131)
    dry = np.clip(0.35 + 0.45 * tint + 0.35 * up, 0.0, 1.0)[..., None]
    color = SOIL + (DRY - SOIL) * dry
    # Rime lies in patches, on what stands out first.
    rime = np.clip((fractal(u, v, 34.0 * dx, 7, 0.66, pixel, 211) + 0.6 * up - 0.50) * 2.2, 0.0, 0.85)[
        ..., None
    ]
    color = color + (RIME - color) * rime
    color = color + (STONE * (1.0 + 0.3 * tint[..., None]) - color) * np.minimum(4.0 * stones, 1.0)[..., None]
    grit = fractal(u, v, 0.7 * dx, 3, 0.8, pixel, 177)[..., None]
    return height, np.clip(color * (1.0 + 0.30 * grit), 0.01, 0.8)


def wet_relief(height: Array, color: Array, wet: Array, dx: float) -> tuple[Array, Array, Array]:
    """Return height [m] and reflectance of earth that is `wet` (0 to 1), and the share of a film of water.

    Wet earth is dark; water fills its hollows up to a level that rises with wetness, and is flat there.
    """
    level = DEPTH * dx * (FILLED * wet - 1.0)
    under = np.clip((level - height) / (0.06 * DEPTH * dx), 0.0, 1.0) * np.clip(3.0 * wet, 0.0, 1.0)
    dark = color * (1.0 - (1.0 - WET) * np.clip(1.6 * wet, 0.0, 1.0)[..., None])
    film = np.maximum(under, 0.25 * wet)
    return np.where(level > height, height + under * (level - height), height), dark, film


def _grid(lens: Lens, eye: Array, rotation: Array) -> tuple[Array, Array]:
    """Return places (rows, columns) on the plane: rays around the foot of the camera, fine where it looks."""
    step = 2.0 / lens.focal
    side = 1 if eye[2] >= 0 else -1
    heading, half, low, high = _seen(lens, rotation, side)
    distance = lens.distance
    nearest = abs(eye[2]) / (FAR * distance)  # slope to the end of the ground
    horizon = np.geomspace(nearest, nearest + 8.0 * step, 64)  # hills are not two rings high
    fine = np.arange(max(low, nearest + 0.5 * step), min(high, 1.55), step)
    steep = np.linspace(min(max(high, nearest + step), 1.55), 1.5707, 24)
    flat = (
        np.geomspace(nearest, max(low, nearest + 0.5 * step), 24)[:-1]
        if low > nearest
        else np.array([nearest])
    )
    down = np.unique(np.concatenate([horizon, flat, fine, steep]))
    if half > 2.5:
        turn = np.arange(-math.pi, math.pi, step)
    else:
        turn = np.concatenate([np.arange(-half, half, step), np.linspace(half, 2 * math.pi - half, 40)])
    radius = abs(eye[2]) / np.tan(down)
    angle = heading + np.append(turn, turn[0])
    return (
        eye[0] + radius[:, None] * np.cos(angle)[None, :],
        eye[1] + radius[:, None] * np.sin(angle)[None, :],
    )


def _seen(lens: Lens, rotation: Array, side: int) -> tuple[float, float, float, float]:
    """Return what is seen of a plane [rad]: heading of the middle, half the width, least and most below it.

    Heading and depth below level are of rays in the plane's own frame, in which a camera that is upright in
    the world leans if the plane does. side: 1 if the camera is on the side of the normal, else -1.
    """
    across, along = 0.5 * lens.width / lens.focal, 0.5 * lens.height / lens.focal
    right, up, forward = lens.axes
    t, one = np.linspace(-1.0, 1.0, 33), np.ones(33)
    a, b = across * np.concatenate([t, t, one, -one]), along * np.concatenate([one, -one, t, t])
    x, y, z = ((a[:, None] * right + b[:, None] * up + forward) @ rotation).T
    ahead = forward @ rotation
    heading = math.atan2(ahead[1], ahead[0])
    below = np.arctan2(-side * z, np.hypot(x, y))
    turned = (np.arctan2(y, x) - heading + math.pi) % (2 * math.pi) - math.pi
    low, high, half = float(below.min()) - 0.02, float(below.max()) + 0.02, float(np.abs(turned).max()) + 0.05
    foot = -side * rotation[:, 2]
    depth = float(foot @ forward)
    if depth > 0 and abs(foot @ right) < across * depth and abs(foot @ up) < along * depth:
        return heading, math.pi, low, 0.5 * math.pi  # the point below the camera is in the picture
    return heading, half, low, high


def surface_normals(local: Array, eye: Array) -> Array:
    """Return unit normals (rows, columns, 3) of a grid of vertices whose last column is the first again.

    Far away triangles are long and thin, and flat ones would draw the grid on the hills as stripes. Just
    behind a crest they are turned towards the eye, or the triangle in front, which is seen, would be black.
    """
    around = np.empty_like(local)
    around[:, 1:-1] = local[:, 2:] - local[:, :-2]
    around[:, 0] = around[:, -1] = local[:, 1] - local[:, -2]
    outward = np.gradient(local, axis=0)
    normal = np.cross(outward, around)
    normal = _unit(normal * np.sign(normal[..., 2:]) * (1.0 if eye[2] >= 0 else -1.0))
    view = _unit(eye - local)
    facing = np.sum(normal * view, axis=-1, keepdims=True)
    return _unit(normal + view * np.maximum(LEAST_FACING - facing, 0.0))


def _unit(a: Array) -> Array:
    length: Array = np.linalg.norm(a, axis=-1, keepdims=True)
    return a / np.maximum(length, 1e-300)


def _sides(rows: int, columns: int) -> NDArray[np.uint32]:
    """Return the triangles of a grid of vertices, row by row."""
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)[None, :]).ravel()
    a, b, c, d = first, first + 1, first + columns, first + columns + 1
    return np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)]).astype(np.uint32)


def _earth() -> dict[str, Any]:
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": attribute("color")}}


def _wet_earth() -> dict[str, Any]:
    dry = {"type": "diffuse", "reflectance": attribute("color")}
    return {"type": "twosided", "bsdf": wetted(dry, attribute("color"), 0.12)}
