"""Make smooth random fields in space that depend on nothing but the place and a seed."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import norms

Array = NDArray[np.float64]
Bits = NDArray[np.uint64]

DEVIATION = 0.4
"""Standard deviation of `fractal` before it is cut to [-1, 1]: about one value in a hundred is cut."""

CHUNK = 8192
"""Points worked on at once, so that scratch stays in the processor's cache."""

NEIGHBOURS = 8
"""Random points nearest to a place among which the walls of its Voronoi cell are looked for."""

_PRIMES = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


def fractal(x: Array, feature_size: float, octaves: int, seed: int) -> Array:
    """Return fractal noise in [-1, 1] at points `x`.

    fBm(x) = sum_o 2^-o N_o(2^o x / feature_size), N_o gradient noise on a unit lattice with random gradients
    at its nodes, each octave with its own seed and offset; scaled to standard deviation DEVIATION.
    The value at a point does not depend on the other points.

    Args:
        x: points [m], (n, 3)
        feature_size: lattice spacing of the first octave [m]
        octaves: number of octaves [1]
        seed: any whole number

    Returns: (n,) [1]

    Source: Perlin 1985 and 2002 for gradient noise and its fade; the hash and the scaling are ours.
    """
    total = np.zeros(len(x))
    for octave in range(octaves):
        key = _mix(np.array([(seed * 64 + octave) % 2**64], dtype=np.uint64))
        offset = _unit(key, np.arange(1, 4, dtype=np.uint64)) * 256.0
        total += 0.5**octave * _gradient_noise(x * (2.0**octave / feature_size) + offset, key)
    deviation = _octave_deviation() * math.sqrt(sum(0.25**octave for octave in range(octaves)))
    return np.asarray(np.clip(total * (DEVIATION / deviation), -1.0, 1.0))


def clods(x: Array, size: Array, feature_size: float, seam: float, octaves: int, seed: int) -> Array:
    """Return at points `x` the noise of snow pressed together from clods: 0 inside them, -1 in their seams.

    The clods are the Voronoi cells of random points (a Poisson process), on average one in feature_size^3.
    `across` is the profile of a seam over the distance to the nearest wall of the point's own cell. Octave o
    has cells and seams 2^-o as large and 2^-o as deep; the deepest counts.
    The value at a point does not depend on the other points.

    Args:
        x: points [m], (n, 3), in a centred box of edges `size` [m] (3,)
        feature_size: mean size of a clod, the cube root of its mean volume [m]
        seam: width of the seams [m]
        octaves: number of octaves [1]; with more than one, clods have seams of their own
        seed: any whole number

    Returns: (n,) [1]

    Source: cells of random points as a texture are Worley 1996; the seams are ours.
    """
    from scipy.spatial import cKDTree

    total = np.zeros(len(x))
    for octave in range(octaves):
        cell = feature_size * 0.5**octave
        rng = np.random.default_rng([seed % 2**64, octave, 0xC10D])
        room = size + 6.0 * cell  # three cells beyond the snow on every side
        count = max(NEIGHBOURS, int(rng.poisson(np.prod(room / cell))))
        points = (rng.random((count, 3)) - 0.5) * room
        far, near = cKDTree(points).query(x, k=NEIGHBOURS)
        apart = norms(points[near[:, 1:]] - points[near[:, :1]])
        wall = np.min((far[:, 1:] ** 2 - far[:, :1] ** 2) / (2.0 * apart), axis=1)
        total = np.minimum(total, 0.5**octave * across(wall, seam * 0.5**octave))
    return total


def across(distance: Array, width: float) -> Array:
    """Return the noise of a seam at distances from its middle [m]: -1 there, 0 from half its width [m] on.

    n = 3 t^2 - 2 t^3 - 1 with t = min(2 distance / width, 1).
    """
    t = np.minimum(2.0 * distance / width, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t) - 1.0)


def _gradient_noise(p: Array, key: Bits) -> Array:
    """Blend at `p` (n, 3) the eight linear functions g . (p - node) of the surrounding lattice nodes."""
    if len(p) > CHUNK:
        return np.concatenate([_gradient_noise(p[i : i + CHUNK], key) for i in range(0, len(p), CHUNK)])
    total = np.zeros(len(p))
    sides = [_sides(p[:, k], _PRIMES[k]) for k in range(3)]
    for (wx, dx, hx), (wy, dy, hy), (wz, dz, hz) in product(*sides):
        hashed = _mix(key + hx + hy + hz)
        slope = dx * _component(hashed, 0) + dy * _component(hashed, 1) + dz * _component(hashed, 2)
        total += wx * wy * wz * slope
    return total


def _sides(p: Array, prime: np.uint64) -> list[tuple[Array, Array, Bits]]:
    """Return weight, distance and hash of the lattice planes below and above `p` (n,) along one axis."""
    cell = np.floor(p)
    f = p - cell
    fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0)
    below = cell.astype(np.int64).view(np.uint64) * prime
    return [(1.0 - fade, f, below), (fade, f - 1.0, below + prime)]


def _octave_deviation() -> float:
    """Return the standard deviation of gradient noise with gradients uniform in [-1, 1]^3.

    At a point of the cell the variance is sum_corners w^2 |d|^2 / 3 with w = product of w(d_k) over the axes;
    the mean over the cell is, by symmetry, 8 A^2 B with A = int w^2 dt = 181/462 and
    B = int w^2 t^2 dt = 535/18018 over [0, 1], w = 1 - 10 t^3 + 15 t^4 - 6 t^5.
    """
    a, b = 181 / 462, 535 / 18018
    return math.sqrt(8.0 * a * a * b)


def _component(hashed: Bits, k: int) -> Array:
    """Read bits 21 k to 21 k + 20 as a number in [-1, 1)."""
    return ((hashed >> np.uint64(21 * k)) & np.uint64(0x1FFFFF)).astype(np.float64) * 2.0**-20 - 1.0


def _unit(key: Bits, n: Bits) -> Array:
    return _mix(key + n * _PRIMES[0]).astype(np.float64) * 2.0**-64


def _mix(z: Bits) -> Bits:
    """Scatter the bits of `z`: the output function of SplitMix64 (Steele, Lea and Flood 2014)."""
    z = z + _PRIMES[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))
