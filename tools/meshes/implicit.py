"""Shapes as functions: distance to a surface, negative inside [m], for points (n, 3) [m].

The distances are exact or, where a comment says so, close enough near the surface. Formulas: elementary
geometry; the smooth union is the polynomial one (quadratic in the difference of the two distances).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Field = Callable[[Array], Array]


def union(*parts: Array) -> Array:
    """Return the distance to what lies in any part."""
    return np.minimum.reduce(parts)


def common(*parts: Array) -> Array:
    """Return the distance to what lies in all parts."""
    return np.maximum.reduce(parts)


def smooth_union(width: float, *parts: Array) -> Array:
    """Return the union with its hollow edges filled over about `width` [m]."""
    whole = parts[0]
    for part in parts[1:]:
        share = np.maximum(width - np.abs(whole - part), 0.0) / width
        whole = np.minimum(whole, part) - 0.25 * width * share**2
    return whole


def ellipsoid(p: Array, center: tuple[float, float, float], half: tuple[float, float, float]) -> Array:
    """Return about the distance to an ellipsoid: exact on the surface and to first order beside it."""
    q = (p - center) / half
    scaled = np.linalg.norm(q, axis=1)
    slope = np.linalg.norm(q / half, axis=1)
    return np.where(slope > 1e-12, scaled * (scaled - 1.0) / np.maximum(slope, 1e-12), -min(half))


def cone_capsule(p: Array, a: tuple, b: tuple, ra: float, rb: float) -> Array:
    """Return about the distance to balls of radius ra at a to rb at b and all between them."""
    start, way = np.asarray(a, float), np.subtract(b, a)
    along = np.clip((p - start) @ way / (way @ way), 0.0, 1.0)
    return np.linalg.norm(p - start - along[:, None] * way, axis=1) - (ra + (rb - ra) * along)


def box(p: Array, center: tuple, half: tuple) -> Array:
    """Return the distance to an upright box."""
    q = np.abs(p - np.asarray(center)) - np.asarray(half)
    return np.linalg.norm(np.maximum(q, 0.0), axis=1) + np.minimum(q.max(axis=1), 0.0)


def prism(flat: Array, z: Array, low: float, high: float) -> Array:
    """Return the distance to an upright prism: `flat` is the distance to its outline in the plane."""
    upright = np.maximum(low - z, z - high)
    outside = np.hypot(np.maximum(flat, 0.0), np.maximum(upright, 0.0))
    return outside + np.minimum(np.maximum(flat, upright), 0.0)


def ring_teeth(angle: Array, radius: Array, count: int, half_width: float) -> Array:
    """Return the distance to `count` radial slabs of this half width, evenly around the z axis."""
    pitch = 2.0 * np.pi / count
    turned = (angle + 0.5 * pitch) % pitch - 0.5 * pitch
    return np.abs(radius * np.sin(turned)) - half_width


def rotated(p: Array, angle: float, axis: int) -> Array:
    """Return the points turned by -angle [rad] about an axis: the shape turns by +angle."""
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    q = p.copy()
    c, s = np.cos(angle), np.sin(angle)
    q[:, i], q[:, j] = c * p[:, i] + s * p[:, j], -s * p[:, i] + c * p[:, j]
    return q


def slope(field: Field, p: Array, step: float) -> Array:
    """Return the unit gradient of the field at p by central differences, (n, 3)."""
    g = np.empty_like(p)
    for axis in range(3):
        e = np.zeros(3)
        e[axis] = step
        g[:, axis] = field(p + e) - field(p - e)
    return g / np.maximum(np.linalg.norm(g, axis=1, keepdims=True), 1e-30)
