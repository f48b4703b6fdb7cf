"""The meshes that are made as turned surfaces, point by point: tyre, pine, rock, hat, carrot [m]."""

from __future__ import annotations

import numpy as np
from implicit import Array
from numpy.typing import NDArray

Faces = NDArray[np.int64]

RADIUS, HALF_WIDTH = 0.35, 0.125  # of the tyre, over its lugs
LUG = 0.026  # depth of its grooves
PITCHES = 20


def lathe(rings: list[Array]) -> tuple[Array, Faces]:
    """Return the closed surface through rings of as many points each, (n, 3); the first and the last ring
    are closed with a point in their middle. Seen along the way from first to last, rings turn clockwise.
    """
    n = len(rings[0])
    vertices = np.concatenate([rings[0].mean(0, keepdims=True), *rings, rings[-1].mean(0, keepdims=True)])
    around, ahead = np.arange(n), (np.arange(n) + 1) % n
    faces = [np.stack([np.zeros(n, int), 1 + ahead, 1 + around], -1)]
    for k in range(len(rings) - 1):
        a, b = 1 + k * n, 1 + (k + 1) * n
        faces.append(np.stack([a + around, a + ahead, b + ahead], -1))
        faces.append(np.stack([a + around, b + ahead, b + around], -1))
    end = 1 + (len(rings) - 1) * n
    faces.append(np.stack([np.full(n, end + n), end + around, end + ahead], -1))
    return vertices, np.concatenate(faces)


def tyre() -> tuple[Array, Faces]:
    """Return a tyre with its wheel: 0.70 m across, 0.25 m wide, axis along y, the origin in its middle.

    Three rows of tread blocks, grooves 2.6 cm deep: bent bars at the shoulders, set off by half a pitch
    from side to side, and small blocks between them. The rim is closed by a dished disc with a hub.
    """
    floor = RADIUS - LUG
    # Half of the profile from the middle of the disc outwards: (|y|, r).
    disc = [(0.070, 0.032), (0.078, 0.040), (0.078, 0.055), (0.050, 0.068), (0.046, 0.130), (0.052, 0.150)]
    rim = [(0.085, 0.190), (0.108, 0.197), (0.110, 0.207), (0.102, 0.213)]
    side = [(0.116, 0.232), (0.1225, 0.262), (0.121, 0.292)]
    # Where the rows of the tread begin and end: foot, edge, edge, foot; the middle row ends as it begins.
    shoulder, middle = (0.119, 0.105, 0.052, 0.047), (0.034, 0.030)
    rings = [_ring(y, r, None) for y, r in disc + rim + side]
    rings += [
        _ring(shoulder[0], floor - 0.012, None),
        _ring(shoulder[1] + 0.014, RADIUS - 0.004, "left", floor - 0.012),
    ]
    rings += [_ring(y, RADIUS, "left", floor) for y in shoulder[1:3]]
    rings += [_ring(shoulder[3], floor, "left", floor), _ring(middle[0], floor, "middle", floor)]
    rings += [_ring(y, RADIUS - 0.002, "middle", floor) for y in (middle[1], -middle[1])]
    rings += [_ring(-middle[0], floor, "middle", floor), _ring(-shoulder[3], floor, "right", floor)]
    rings += [_ring(-y, RADIUS, "right", floor) for y in shoulder[2:0:-1]]
    rings += [_ring(-shoulder[1] - 0.014, RADIUS - 0.004, "right", floor - 0.012)]
    rings += [_ring(-shoulder[0], floor - 0.012, None)]
    rings += [_ring(-y, r, None) for y, r in reversed(disc + rim + side)]
    return lathe(rings)


def _ring(y: float, top: float, row: str | None, floor: float = 0.0) -> Array:
    """Return one ring of the tyre at y: four points per pitch, at `top` on blocks and `floor` between."""
    pitch = 2.0 * np.pi / PITCHES
    cut, draft = 0.17, 0.035  # of a pitch: half a groove's width, and what its side leans
    share = np.array([-0.5 + cut - draft, -0.5 + cut, 0.5 - cut, 0.5 - cut + draft])
    if row == "middle":
        offset, bend = 0.0, -8.0 * y
    elif row is None:  # the sides follow the shoulders, the disc is not turned
        offset, bend = 0.25 * np.sign(y), 0.45 * min(1.0, max(top - 0.2, 0.0) / 0.1)
    else:
        offset, bend = (0.25 if row == "left" else -0.25), 6.0 * max(abs(y) - 0.04, 0.0)
    angle = (np.arange(PITCHES)[:, None] + share + offset + bend) * pitch
    r = np.tile([floor, top, top, floor] if row else [top] * 4, PITCHES)
    angle = angle.reshape(-1)
    return np.stack([-r * np.sin(angle), np.full_like(r, y), r * np.cos(angle)], -1)


def pine() -> tuple[Array, Faces]:
    """Return a snow-laden pine: 2.4 m high, 1.5 m across, the origin on the ground in its middle.

    Seven tiers of branches hang over one another; their tips reach out and down, as many as 11 around.
    """
    around = 44
    angle = np.arange(around) * 2.0 * np.pi / around
    rings = [_star(angle, 0.10, 0.0, 0, 0, 0), _star(angle, 0.075, 0.26, 0, 0, 0)]
    low = np.array([0.30, 0.63, 0.95, 1.25, 1.53, 1.79, 2.02])
    tiers = np.array([0.64, 0.56, 0.47, 0.38, 0.29, 0.20, 0.12])
    for k, (z, r) in enumerate(zip(low, tiers, strict=True)):
        turn = 0.9 * k
        if k:
            rings.append(_star(angle, 0.42 * r, z + 0.10, 0.0, 0.0, turn))
        else:
            rings.append(_star(angle, 0.16, z + 0.06, 0.0, 0.0, turn))
        rings.append(_star(angle, 0.93 * r, z, 0.16, 0.14 * r, turn))
        rings.append(_star(angle, r, z + 0.045, 0.16, 0.14 * r, turn))
        rings.append(_star(angle, 0.70 * r, z + 0.20 * (1.0 - 0.09 * k), 0.09, 0.05 * r, turn))
    rings += [_star(angle, 0.045, 2.20, 0.0, 0.0, 0.0), _star(angle, 0.012, 2.40, 0, 0, 0)]
    return lathe(rings)


def _star(angle: Array, r: float, z: float, out: float, droop: float, turn: float) -> Array:
    """Return a ring whose 11 tips reach out by this share of r and hang down by `droop` [m]."""
    tip = np.cos(11.0 * angle + 11.0 * turn) + 0.35 * np.cos(3.0 * angle + 5.0 * turn)
    radius = r * (1.0 + out * tip)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z - droop * tip], -1)


def rock() -> tuple[Array, Faces]:
    """Return a boulder, about 1 x 0.9 x 0.7 m, the origin on the ground under its middle.

    A ball cut by planes of random directions, the edges worn, with a little roughness.
    """
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=4)
    direction = np.asarray(ball.vertices)
    random = np.random.default_rng(11)
    normals = random.normal(size=(18, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = random.uniform(0.66, 0.95, 18)
    facing = np.maximum(direction @ normals.T, 1e-6)
    worn = 34.0  # the larger, the sharper the edges
    radius = np.sum((facing / offsets) ** worn, axis=1) ** (-1.0 / worn)
    for frequency, strength in ((4.0, 0.006), (9.0, 0.006)):
        phase = random.uniform(0.0, 6.28, (6, 1))
        waves = random.normal(size=(6, 3)) * frequency
        radius *= 1.0 + strength * np.sum(np.sin(waves @ direction.T + phase), axis=0) / 2.0
    x = direction * radius[:, None] * (0.58, 0.50, 0.42)
    x[:, 2] = np.maximum(x[:, 2], -0.30) + 0.30
    return x, np.asarray(ball.faces)


def hat() -> tuple[Array, Faces]:
    """Return a top hat: 0.26 m high, its brim 0.42 m across, the origin under its middle."""
    profile = [(0.200, 0.000), (0.208, 0.006), (0.210, 0.013), (0.203, 0.020), (0.150, 0.022)]
    band = [(0.141, 0.026), (0.139, 0.034), (0.139, 0.066), (0.133, 0.070)]
    crown = [(0.131, 0.120), (0.134, 0.180), (0.141, 0.240), (0.141, 0.250), (0.132, 0.258), (0.06, 0.260)]
    angle = np.arange(48) * 2.0 * np.pi / 48
    return lathe([_star(angle, r, z, 0.0, 0.0, 0.0) for r, z in profile + band + crown])


def carrot() -> tuple[Array, Faces]:
    """Return a carrot with rings and a bend: 0.26 m long along z, 0.07 m thick, the origin at its end."""
    z = np.linspace(0.0, 1.0, 40)
    radius = 0.035 * (1.0 - z) ** 0.75 * np.minimum(1.0, 0.72 + 4.0 * z) + 0.002
    radius *= 1.0 + 0.045 * np.sin(47.0 * z + 2.0 * np.sin(9.0 * z))
    angle = np.arange(24) * 2.0 * np.pi / 24
    bend = 0.012 * np.sin(2.3 * z)
    rings = [_star(angle, r, 0.26 * h, 0.0, 0.0, 0.0) for r, h in zip(radius, z, strict=True)]
    return lathe([ring + np.array([x, 0.0, 0.0]) for ring, x in zip(rings, bend, strict=True)])
