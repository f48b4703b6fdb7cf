"""The figures that are made as fields: boot, castle, hare. x is forward, z up [m]."""

from __future__ import annotations

import numpy as np
from implicit import (
    Array,
    box,
    common,
    cone_capsule,
    ellipsoid,
    prism,
    ring_teeth,
    rotated,
    smooth_union,
    union,
)

LUG_DEPTH = 0.013  # of the boot's tread [m]
SOLE = 0.036  # height of the top of the boot's sole [m]


def sole_outline(x: Array, y: Array) -> Array:
    """Return the distance to the outline of the boot's sole in the plane: heel, waist, ball and toe."""
    p = np.stack([x, y, np.zeros_like(x)], -1)
    heel = cone_capsule(p, (-0.108, 0.0, 0.0), (-0.03, 0.002, 0.0), 0.040, 0.037)
    waist = cone_capsule(p, (-0.03, 0.002, 0.0), (0.05, 0.004, 0.0), 0.037, 0.052)
    toe = cone_capsule(p, (0.05, 0.004, 0.0), (0.104, -0.004, 0.0), 0.052, 0.045)
    return smooth_union(0.02, heel, waist, toe)


def lugs(x: Array, y: Array) -> Array:
    """Return the distance to the boot's lugs in the plane: bent bars, cut in two, a bare waist between
    ball and heel."""
    bent = x - 0.35 * np.abs(y)
    pitch = 0.0285
    row = np.abs((bent + 0.008) % pitch - 0.5 * pitch) - 0.0092
    split = 0.0045 - np.abs(y)
    waist = 0.015 - np.abs(x + 0.034)
    edge = sole_outline(x, y)
    border = common(row, split, edge + 0.003)
    return common(border, waist)


def boot(p: Array) -> Array:
    """Return the distance to a winter boot for a right foot: 0.30 m long, toe to +x, lugs on z = 0; the
    origin is on the ground under the middle of the sole."""
    x, y, z = p.T
    edge = sole_outline(x, y)
    groove = 0.0025 * np.maximum(1.0 - np.abs(z - 0.031) / 0.003, 0.0)  # between sole and welt
    sole = prism(edge - 0.005 + groove, z, LUG_DEPTH, SOLE + 0.004)
    draft = 0.0014 * (1.0 - z / LUG_DEPTH)  # lugs are a little narrower at their foot
    tread = prism(lugs(x, y) + draft, z, 0.0, LUG_DEPTH + 0.004)
    upper = boot_upper(p)
    rim = z - 0.074 - 0.12 * np.maximum(x, 0.0) - 0.2 * np.maximum(-0.06 - x, 0.0)
    rand = common(upper - 0.0045, rim, 0.03 - z, edge)
    leather = common(upper, 0.03 - z, np.where(z < 0.055, edge + 0.0045, -1.0))
    inner = prism(shaft_ring(x, y, 0.30) + 0.016, z, 0.235, 0.4)
    body = union(smooth_union(0.004, leather, cuff(x, y, z)), rand, boot_laces(p))
    return union(sole, tread, common(body, -inner))


def shaft_ring(x: Array, y: Array, z: Array | float) -> Array:
    """Return about the distance to the boot's shaft in the plane at height z."""
    wide = 0.050 + 0.055 * np.clip(np.asarray(z) - 0.13, 0.0, 0.2)
    long = wide + 0.009
    q = np.stack([(x + 0.078) / long, y / wide], -1)
    return (np.linalg.norm(q, axis=1) - 1.0) * wide


def boot_upper(p: Array) -> Array:
    """Return the distance to the boot above its sole, without cuff and laces."""
    x, y, z = p.T
    shaft = prism(shaft_ring(x, y, z), z, 0.06, 0.268)
    edge_of_foot = sole_outline(x, y) + 0.008
    heel = cone_capsule(p, (-0.100, 0.0, 0.055), (-0.086, 0.0, 0.12), 0.044, 0.047)
    instep = cone_capsule(p, (-0.072, 0.0, 0.125), (0.050, 0.003, 0.052), 0.052, 0.046)
    ball = ellipsoid(p, (0.045, 0.004, 0.045), (0.085, 0.051, 0.045))
    toe = ellipsoid(p, (0.093, -0.002, 0.043), (0.053, 0.044, 0.040))
    foot = prism(edge_of_foot, z, -0.1, 0.050)
    return smooth_union(0.03, smooth_union(0.045, shaft, instep), heel, ball, toe, foot)


def cuff(x: Array, y: Array, z: Array) -> Array:
    """Return the distance to the padded roll around the boot's opening."""
    ring = shaft_ring(x, y, 0.265) + 0.006
    return np.hypot(ring, 0.75 * (z - 0.262)) - 0.0165


def boot_laces(p: Array) -> Array:
    """Return the distance to five crossed laces over the boot's instep and the tongue's edge."""
    rows = np.linspace(0.0, 1.0, 6)
    left = np.array([[_front(0.092 + 0.135 * s, 0.020) for s in rows]])[0]
    right = left * (1.0, -1.0, 1.0)
    parts = [np.full(len(p), 1.0)]
    for i in range(5):
        parts += [_lace(p, left[i], right[i + 1]), _lace(p, right[i], left[i + 1])]
    for ends in (left, right):
        parts += [np.linalg.norm(p - end, axis=1) - 0.0062 for end in ends]
    return union(*parts)


def _lace(p: Array, a: Array, b: Array) -> Array:
    top = 0.5 * (a + b) + 0.006 * np.array([0.8, 0.0, 0.6])
    return union(*(cone_capsule(p, tuple(end), tuple(top), 0.0042, 0.0042) for end in (a, b)))


def _front(height: float, aside: float) -> Array:
    """Return the foremost point of the boot's upper at a height [m] and a place aside of its middle."""
    x = np.linspace(0.05, -0.08, 800)
    line = np.stack([x, np.full_like(x, aside), np.full_like(x, height)], -1)
    return np.asarray(line[np.argmax(boot_upper(line) < 0.0)])


def castle(p: Array) -> Array:
    """Return the distance to a castle of four towers, walls and a gate: 2.4 x 2.4 x 1.3 m, gate to -y; the
    origin is in the middle of its base. Nothing is thinner than 0.1 m, walls are 0.24 m thick."""
    x, y, z = p.T
    quarter = np.stack([np.abs(x) - 0.90, np.abs(y) - 0.90, z], -1)
    walls = union(
        *(wall(q, -0.90) for q in (p, p * (1, -1, 1), p[:, [1, 0, 2]], p[:, [1, 0, 2]] * (1, -1, 1)))
    )
    return union(common(union(walls, gatehouse(p)), -gateway(p)), tower(quarter))


def tower(p: Array) -> Array:
    """Return the distance to a round tower around the z axis: a foot, a wide head, eight teeth, a roof."""
    x, y, z = p.T
    r = np.hypot(x, y)
    body = prism(r - 0.24, z, 0.0, 0.85)
    foot = common(r - 0.30 + 0.25 * z, -z, z - 0.24)
    head = prism(r - 0.24 - 0.9 * np.clip(z - 0.69, 0.0, 0.067), z, 0.69, 0.86)
    teeth = common(
        prism(r - 0.30, z, 0.80, 0.98), 0.19 - r, ring_teeth(np.arctan2(y, x) + 0.3927, r, 8, 0.062)
    )
    slope = np.array([0.44, 0.215]) / np.hypot(0.44, 0.215)  # normal of the cone's side in (r, z)
    roof = common(r * slope[0] + (z - 1.30) * slope[1], 0.84 - z)
    return union(body, foot, head, teeth, roof)


def wall(p: Array, y: float) -> Array:
    """Return the distance to a straight wall along x at this y with teeth on it."""
    curtain = box(p, (0.0, y, 0.29), (0.90, 0.12, 0.29))
    ledge = box(p, (0.0, y, 0.555), (0.90, 0.145, 0.035))
    pitch = 0.233
    q = p.copy()
    q[:, 0] = p[:, 0] % pitch - 0.5 * pitch
    teeth = common(box(q, (0.0, y, 0.63), (0.065, 0.145, 0.08)), np.abs(p[:, 0]) - 0.90)
    return union(curtain, ledge, teeth)


def gatehouse(p: Array) -> Array:
    """Return the distance to the house over the gate, with teeth on its corners and sides."""
    block = box(p, (0.0, -0.94, 0.40), (0.36, 0.21, 0.40))
    ledge = box(p, (0.0, -0.94, 0.775), (0.39, 0.24, 0.035))
    q = p - np.array([0.0, -0.94, 0.0])
    q[:, 0] = np.abs(q[:, 0])
    q[:, 1] = np.abs(q[:, 1])
    corners = [box(q, (0.325, 0.175, 0.85), (0.065, 0.065, 0.075))]
    corners.append(box(q, (0.11, 0.175, 0.85), (0.060, 0.065, 0.075)))
    return union(block, ledge, *corners)


def gateway(p: Array) -> Array:
    """Return the distance to the opening of the gate: a round arch through the front."""
    x, y, z = p.T
    arch = union(common(np.abs(x) - 0.17, z - 0.32), np.hypot(x, z - 0.32) - 0.17)
    frame = union(common(np.abs(x) - 0.215, z - 0.32), np.hypot(x, z - 0.32) - 0.215)
    return union(common(arch, np.abs(y + 0.94) - 0.4), common(frame, np.abs(y + 1.17) - 0.06))


def hare(p: Array) -> Array:
    """Return the distance to a hare that sits upright: 0.5 m high, looks to +x, sits on z = 0; the origin
    is on the ground between its feet."""
    x, y, z = p.T
    body = smooth_union(
        0.05,
        ellipsoid(rotated(p - (-0.035, 0.0, 0.150), 0.20, 1), (0, 0, 0), (0.100, 0.088, 0.145)),
        ellipsoid(p, (-0.055, 0.0, 0.085), (0.115, 0.105, 0.085)),
        ellipsoid(p, (0.030, 0.0, 0.190), (0.055, 0.060, 0.075)),
    )
    q = np.stack([x, np.abs(y), z], -1)
    haunch = ellipsoid(rotated(q - (-0.025, 0.082, 0.075), -0.35, 1), (0, 0, 0), (0.078, 0.040, 0.066))
    foot = cone_capsule(q, (-0.035, 0.088, 0.024), (0.105, 0.080, 0.022), 0.024, 0.022)
    arm = cone_capsule(q, (0.040, 0.045, 0.165), (0.085, 0.034, 0.025), 0.031, 0.020)
    paw = ellipsoid(q, (0.098, 0.034, 0.018), (0.030, 0.021, 0.019))
    legs = smooth_union(0.014, smooth_union(0.02, haunch, foot), smooth_union(0.02, arm, paw))
    tail = ellipsoid(p, (-0.172, 0.0, 0.070), (0.042, 0.042, 0.042))
    whole = smooth_union(0.016, smooth_union(0.022, body, legs), tail)
    whole = smooth_union(0.035, whole, hare_head(q))
    return common(whole, -z)


def hare_head(q: Array) -> Array:
    """Return the distance to the hare's head and ears; q: points with |y| in place of y."""
    at = np.array([0.035, 0.0, 0.300])
    skull = ellipsoid(q - at, (0.0, 0.0, 0.0), (0.068, 0.056, 0.058))
    muzzle = ellipsoid(q - at, (0.052, 0.0, -0.016), (0.036, 0.031, 0.029))
    cheek = ellipsoid(q - at, (0.034, 0.024, -0.022), (0.032, 0.028, 0.028))
    nose = ellipsoid(q - at, (0.088, 0.0, -0.006), (0.010, 0.011, 0.008))
    head = smooth_union(0.012, smooth_union(0.025, skull, muzzle, cheek), nose)
    eye = ellipsoid(q - at, (0.042, 0.0375, 0.014), (0.0150, 0.0150, 0.0165))
    head = union(head, eye)
    e = rotated(rotated(q - at - (-0.014, 0.024, 0.045), -0.20, 0), -0.12, 1)
    ear = ellipsoid(e, (0.0, 0.0, 0.078), (0.021, 0.031, 0.092))
    hollow = ellipsoid(e, (0.020, 0.0, 0.082), (0.013, 0.018, 0.068))
    ear = -smooth_union(0.008, -ear, hollow)
    return smooth_union(0.02, head, ear)


# Side of the car's body, from the front clockwise as seen from +y, and of its glass house [m].
BODY = [
    (2.05, 0.10), (2.10, 0.34), (2.04, 0.50), (1.90, 0.58), (0.92, 0.70), (0.28, 1.13), (0.05, 1.20),
    (-0.75, 1.21), (-1.02, 1.16), (-1.62, 0.76), (-2.06, 0.72), (-2.12, 0.55), (-2.08, 0.10),
    (-1.9, 0.0), (1.9, 0.0),
]  # fmt: skip
PANES = {
    "front door": [(0.74, 0.74), (0.16, 1.10), (-0.26, 1.13), (-0.26, 0.74)],
    "rear door": [(-0.34, 0.74), (-0.34, 1.13), (-0.78, 1.13), (-1.10, 1.03), (-1.36, 0.80), (-1.36, 0.74)],
}
WINDSCREEN = [(1.2, 0.72), (0.84, 0.70), (0.26, 1.075), (0.6, 1.4)]
REAR_WINDOW = [(-2.0, 0.80), (-1.50, 0.80), (-1.04, 1.11), (-1.3, 1.5)]
AXLES, ARCH = (1.30, -1.28), 0.385  # where the wheels are, and the radius of their arches [m]


def polygon(x: Array, z: Array, corners: list[tuple[float, float]]) -> Array:
    """Return the distance to the outline of a polygon in the plane."""
    p = np.stack([x, z], -1)
    a = np.array(corners)
    b = np.roll(a, -1, axis=0)
    far = np.full(len(x), np.inf)
    inside = np.zeros(len(x), bool)
    for begin, end in zip(a, b, strict=True):
        way, off = end - begin, p - begin
        along = np.clip(off @ way / (way @ way), 0.0, 1.0)
        far = np.minimum(far, np.linalg.norm(off - along[:, None] * way, axis=1))
        crosses = (begin[1] > z) != (end[1] > z)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = begin[0] + (z - begin[1]) / (end[1] - begin[1]) * way[0]
        inside ^= crosses & (x < at)
    return np.where(inside, -far, far)


def car_side(y: Array, x: Array, z: Array) -> Array:
    """Return how far points are outside the car's flanks, which lean in above the belt and at the ends."""
    waist = 0.86 - 0.05 * np.clip((0.35 - z) / 0.35, 0.0, 1.0) ** 2 - 0.42 * np.clip(z - 0.70, 0.0, 1.0)
    ends = 0.16 * np.clip((np.abs(x) - 1.35) / 0.75, 0.0, 1.0) ** 2
    return (np.abs(y) - (waist - ends)) * 0.9


def rounded(width: float, a: Array, b: Array) -> Array:
    """Return the distance to what lies in both, its edge rounded over about `width` [m]."""
    return -smooth_union(width, -a, -b)


def car_whole(p: Array) -> Array:
    """Return the distance to the car without windows and arches."""
    x, y, z = p.T
    return rounded(0.14, polygon(x, z, BODY), car_side(y, x, z))


def car(p: Array) -> Array:
    """Return about the distance to the body of a car: 4.2 m long, 1.7 m wide, nose to +x, its sill on z = 0.

    Windows are open and show `car_glass`, arches show wheels that stand at x = 1.30 and -1.28 m, 0.13 m high.
    """
    x, y, z = p.T
    windows = [common(polygon(x, z, pane), 0.3 - np.abs(y)) for pane in PANES.values()]
    windows += [
        common(polygon(x, z, pane), np.abs(y) - 0.60 + 0.35 * (z - 0.74))
        for pane in (WINDSCREEN, REAR_WINDOW)
    ]
    arches = [common(np.hypot(x - at, z - 0.13) - ARCH, 0.52 - np.abs(y)) for at in AXLES]
    return common(car_whole(p), *(-part for part in (*windows, *arches)))


def car_glass(p: Array) -> Array:
    """Return the distance to the panes of `car`: one body that stands in it, 3 cm within its skin."""
    x, _, z = p.T
    return common(car_whole(p) + 0.03, 0.66 - z, np.abs(x + 0.25) - 1.55)
