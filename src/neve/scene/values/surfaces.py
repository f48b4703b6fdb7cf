"""Surfaces of the shapes of a formula, as triangles of half extents 1, anticlockwise from outside."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Surface = tuple[NDArray[np.float64], NDArray[np.int32]]
"""Corners (n, 3) and triangles (m, 3)."""

ROWS, COLUMNS = 32, 64
"""Rows from pole to pole of a ball, and corners around it and around a cylinder."""


def square() -> Surface:
    """Return the square z = 0 from -1 to 1, seen from above."""
    corners = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    return corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def cube() -> Surface:
    """Return the cube from -1 to 1: corner 4 i + 2 j + k is at (+-1, +-1, +-1)."""
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))], np.int32)


def ball() -> Surface:
    """Return the ball of radius 1, its corners on the sphere: two poles and ROWS - 1 circles between them."""
    down = [math.pi * row / ROWS for row in range(1, ROWS)]
    circles = [_ring() * [math.sin(a), math.sin(a), 0.0] + [0.0, 0.0, math.cos(a)] for a in down]
    corners = np.concatenate([*circles, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    top, bottom = len(corners) - 2, len(corners) - 1
    j = np.arange(COLUMNS)
    k = (j + 1) % COLUMNS
    last = (ROWS - 2) * COLUMNS
    faces = [
        np.stack([np.full(COLUMNS, top), j, k], 1),
        np.stack([np.full(COLUMNS, bottom), last + k, last + j], 1),
    ]
    for row in range(ROWS - 2):
        a, b = row * COLUMNS, (row + 1) * COLUMNS
        faces += [np.stack([a + j, b + j, b + k], 1), np.stack([a + j, b + k, a + k], 1)]
    return corners, np.concatenate(faces).astype(np.int32)


def tube() -> Surface:
    """Return the cylinder of radius 1 around z from -1 to 1, with its ends."""
    ring = _ring()
    up = np.array([0.0, 0.0, 1.0])
    corners = np.concatenate([ring - up, ring + up, [-up, up]])
    j = np.arange(COLUMNS)
    k = (j + 1) % COLUMNS
    low, high = 2 * COLUMNS, 2 * COLUMNS + 1
    faces = [
        np.stack([j, k, COLUMNS + k], 1),
        np.stack([j, COLUMNS + k, COLUMNS + j], 1),
        np.stack([np.full(COLUMNS, low), k, j], 1),
        np.stack([np.full(COLUMNS, high), COLUMNS + j, COLUMNS + k], 1),
    ]
    return corners, np.concatenate(faces).astype(np.int32)


def _ring() -> NDArray[np.float64]:
    angles = [2 * math.pi * column / COLUMNS for column in range(COLUMNS)]
    return np.array([(math.cos(a), math.sin(a), 0.0) for a in angles])
