"""The surface of lying snow: caps with round lips over edges, and dusting where it is thin."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from neve.geometry.edges import components
from neve.geometry.triangles import Triangles
from neve.reproducible import norms
from neve.snowfall.cover import Cover

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

DUST = 0.05
"""Depth below which snow lies as flakes, in cells."""
LIP = 0.3
"""How far a cap hangs over an edge, in depths there."""
RINGS = 5
"""Rows of faces from the top of a lip to its foot."""
SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1))
ENDS = (((1, 0), (1, 1)), ((0, 1), (0, 0)), ((1, 1), (0, 1)), ((0, 0), (1, 0)))
"""Corners at the ends of each side of a cell, anticlockwise from above."""


def skin(cover: Cover) -> Triangles:
    """Return the snow as closed surfaces: caps, then a flake on each place that has a dusting only.

    The top of a cap goes through the mean heights of the places around each corner of a cell, its underside
    through their surfaces. At a free edge its side is half an ellipse that hangs `LIP` depths over it.
    """
    is_thick = cover.depth > DUST * cover.raster.cell
    caps = _caps(cover, is_thick)
    dust = _flakes(cover, (cover.depth > 0.0) & ~is_thick)
    return Triangles(
        np.concatenate([caps.vertices, dust.vertices]),
        np.concatenate([caps.faces, dust.faces + len(caps.vertices)]).astype(np.int32),
    )


def _caps(cover: Cover, is_thick: NDArray[np.bool_]) -> Triangles:
    rows = np.flatnonzero(is_thick)
    if not len(rows):
        return Triangles(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    top = cover.z + cover.depth
    near = cover.columns.joined(top)[rows].astype(np.int64)
    near[(near >= 0) & ~is_thick[near]] = -1
    place = np.full(len(is_thick), -1)
    place[rows] = np.arange(len(rows))
    near = np.where(near >= 0, place[near], -1)
    corner, count = _corners(near, len(rows))
    weight = np.bincount(corner.ravel(), minlength=count)

    def mean(values: Array) -> Array:
        return np.asarray(np.bincount(corner.ravel(), np.repeat(values, 4), minlength=count) / weight)

    i, j = np.divmod(cover.columns.column()[rows], cover.raster.ny)
    step = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    x = np.empty((count, 2))
    x[corner.ravel()] = (np.stack([i, j], axis=1)[:, None] + step).reshape(-1, 2)
    x = np.array(cover.raster.low) + cover.raster.cell * x
    low, high = mean(cover.z[rows]), mean(top[rows])
    sides, out, bulge = _sides(cover, rows, near, corner, high - low, top)
    rings = _rings(x, low, high, out, bulge)
    faces = [_fan(corner), _fan(corner[:, ::-1]) + RINGS * count]
    a, b = sides[:, 0], sides[:, 1]
    for ring in range(RINGS):
        up, down = ring * count, (ring + 1) * count
        faces += [
            np.stack([a + up, a + down, b + down], axis=1),
            np.stack([a + up, b + down, b + up], axis=1),
        ]
    return _used(rings, np.concatenate(faces))


def _corners(near: Rows, count: int) -> tuple[Rows, int]:
    """Return the vertex at each corner of each cell, anticlockwise from (0, 0) (n, 4), and their number.

    Cells that are one surface share those between them.
    """
    number = {(0, 0): 0, (1, 0): 1, (1, 1): 2, (0, 1): 3}
    f, g = [], []
    for k, (dx, dy) in ((0, SIDES[0]), (2, SIDES[2])):
        here = np.flatnonzero(near[:, k] >= 0)
        for a in ENDS[k]:
            b = (a[0] - dx, a[1] - dy)
            f.append(4 * here + number[a])
            g.append(4 * near[here, k] + number[b])
    label = components(np.concatenate(f), np.concatenate(g), 4 * count)
    return label.reshape(-1, 4).astype(np.int64), int(label.max()) + 1


def _sides(
    cover: Cover, rows: Rows, near: Rows, corner: Rows, depth: Array, top: Array
) -> tuple[Rows, Array, Array]:
    """Return the sides where caps end (k, 2), and at each vertex the way out (n, 2) and how far lips hang.

    At walls and at the rim of the rectangle a cap ends upright.
    """
    number = {(0, 0): 0, (1, 0): 1, (1, 1): 2, (0, 1): 3}
    shut = cover.columns.walls(top)[rows]
    sides = []
    out, is_shut = np.zeros((len(depth), 2)), np.zeros(len(depth), bool)
    for k, side in enumerate(SIDES):
        ends = np.flatnonzero(near[:, k] < 0)
        pair = np.stack([corner[ends, number[end]] for end in ENDS[k]], axis=1)
        sides.append(pair)
        for c in (0, 1):
            np.add.at(out, pair[:, c], np.array(side, float))
            np.logical_or.at(is_shut, pair[:, c], shut[ends, k] != 0)
    length = norms(out)
    out /= np.maximum(length, 1e-12)[:, None]
    bulge = np.where((length > 0.5) & ~is_shut, np.minimum(LIP * depth, 0.75 * cover.raster.cell), 0.0)
    return np.concatenate(sides), out, bulge


def _rings(x: Array, low: Array, high: Array, out: Array, bulge: Array) -> Array:
    """Return the vertices from the top down, one ring after the other, (RINGS + 1) n rows of 3 [m].

    Half an ellipse: out by b sin t and up by (h/2) cos t from its middle, t from 0 to pi.
    """
    found = []
    for ring in range(RINGS + 1):
        t = math.pi * ring / RINGS
        side, height = math.sin(t), 0.5 + 0.5 * math.cos(t)
        if ring in (0, RINGS):
            side, height = 0.0, 1.0 - ring / RINGS
        found.append(np.column_stack([x + (side * bulge)[:, None] * out, low + height * (high - low)]))
    return np.concatenate(found)


def _fan(corner: Rows) -> Rows:
    return np.concatenate([corner[:, [0, 1, 2]], corner[:, [0, 2, 3]]])


def _used(vertices: Array, faces: Rows) -> Triangles:
    used, rows = np.unique(faces, return_inverse=True)
    return Triangles(np.ascontiguousarray(vertices[used]), rows.reshape(-1, 3).astype(np.int32))


def _flakes(cover: Cover, is_thin: NDArray[np.bool_]) -> Triangles:
    """Return an octahedron on each thin place that holds its snow: 4/3 r^2 c of volume, c half its height."""
    rows = np.flatnonzero(is_thin)
    rng = np.random.default_rng([len(cover.depth), 0xD057])
    volume = cover.depth[rows] * cover.raster.cell**2
    half = np.minimum(0.5 * np.sqrt(volume / cover.raster.cell), 0.25 * cover.raster.cell)
    radius = np.sqrt(0.75 * volume / np.maximum(half, 1e-300))
    middle = cover.x[rows]
    middle[:, :2] += (rng.random((len(rows), 2)) - 0.5) * (0.8 * cover.raster.cell)
    middle[:, 2] = cover.z[rows] + half
    turn = 0.5 * math.pi * rng.random(len(rows))
    c, s = (radius * np.array([f(t) for t in turn.tolist()]) for f in (math.cos, math.sin))
    zero = np.zeros(len(rows))
    arms = [
        (c, s, zero),
        (-s, c, zero),
        (-c, -s, zero),
        (s, -c, zero),
        (zero, zero, half),
        (zero, zero, -half),
    ]
    vertices = np.stack([middle + np.stack(arm, axis=1) for arm in arms], axis=1).reshape(-1, 3)
    form = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (1, 0, 5), (2, 1, 5), (3, 2, 5), (0, 3, 5)]
    faces = (6 * np.arange(len(rows))[:, None, None] + np.array(form, int)).reshape(-1, 3)
    return Triangles(vertices, faces.astype(np.int32))
