"""Noise for what lies around the snow: a function of the place, so that nothing swims from frame to frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
TURN = np.array([[0.8, -0.6], [0.6, 0.8]], np.float32)
"""Turn between octaves, or their lattices show as a plaid."""


def noise(u: NDArray[Any], v: NDArray[Any], seed: int, period: int = 0) -> Floats:
    """Return smooth noise in [-1, 1] on a lattice of unit squares, which repeats after `period` squares."""
    fu, fv = np.floor(u), np.floor(v)
    i, j = fu.astype(np.int64), fv.astype(np.int64)
    a, b = (u - fu).astype(np.float32), (v - fv).astype(np.float32)
    p, q = a * a * a * (a * (6 * a - 15) + 10), b * b * b * (b * (6 * b - 15) + 10)
    i2, j2 = i + 1, j + 1
    if period:
        i, j, i2, j2 = (k % period for k in (i, j, i2, j2))
    c00, c10 = _corner(i, j, seed), _corner(i2, j, seed)
    c01, c11 = _corner(i, j2, seed), _corner(i2, j2, seed)
    low, high = c00 + (c10 - c00) * p, c01 + (c11 - c01) * p
    return np.asarray(low + (high - low) * q, np.float32)


def fractal(
    u: NDArray[Any],
    v: NDArray[Any],
    size: float,
    octaves: int,
    gain: float,
    pixel: NDArray[Any] | float,
    seed: int,
) -> Floats:
    """Return octaves of noise, each about half as large as the one before and `gain` times as strong.

    u, v: places [m]; size: of the largest features [m]; pixel: footprint of a pixel there [m], at which
    octaves fade out before they can alias.
    """
    total = np.zeros(np.shape(u), np.float32)
    weight = 1.0
    for octave in range(octaves):
        fade = np.clip(size / (2.0 * np.asarray(pixel)) - 0.5, 0.0, 1.0)
        if not np.any(fade > 0.0):
            break
        total += np.asarray(fade * weight, np.float32) * noise(u / size, v / size, seed + octave)
        u, v = TURN[0, 0] * u + TURN[0, 1] * v, TURN[1, 0] * u + TURN[1, 1] * v
        weight *= gain
        size *= 0.47
    return total


def tile(side: int, cells: int, octaves: int, gain: float, seed: int) -> Floats:
    """Return a square of fractal noise (side, side) that repeats without a seam, about in [-1, 1]."""
    at = (np.arange(side, dtype=np.float32) + 0.5) / side
    u, v = np.meshgrid(at, at, indexing="ij")
    total, weight, sum_ = np.zeros((side, side), np.float32), 1.0, 0.0
    for octave in range(octaves):
        count = cells * 2**octave
        total += weight * noise(u * count, v * count, seed + octave, count)
        sum_ += weight
        weight *= gain
    return total / np.float32(0.6 * sum_)


def _corner(i: NDArray[np.int64], j: NDArray[np.int64], seed: int) -> Floats:
    """Return random numbers in [-1, 1) of the nodes of a lattice."""
    with np.errstate(over="ignore"):
        bits = (i.astype(np.uint32) * np.uint32(0x9E3779B1)) ^ _scramble(
            j.astype(np.uint32) + np.uint32(seed)
        )
        return _scramble(bits).astype(np.float32) * np.float32(2.0**-31) - np.float32(1.0)


def _scramble(a: NDArray[np.uint32]) -> NDArray[np.uint32]:
    a = (a ^ (a >> np.uint32(16))) * np.uint32(0x7FEB352D)
    a = (a ^ (a >> np.uint32(15))) * np.uint32(0x846CA68B)
    return a ^ (a >> np.uint32(16))
