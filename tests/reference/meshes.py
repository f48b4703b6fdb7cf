"""Bodies of triangles made by hand, and what NumPy finds by looking at every triangle."""

import numpy as np


def box(size=(1.0, 1.0, 1.0), center=(0.0, 0.0, 0.0)):
    """Return vertices (8, 3) and faces (12, 3) of a box, seen from outside counter-clockwise."""
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )  # -x +x -y +y -z +z
    return (corners - 0.5) * np.asarray(size) + np.asarray(center), split(quads)


def split(quads):
    """Cut quads (n, 4) along a diagonal into triangles (2 n, 3)."""
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def sphere(level, radius=1.0):
    """Return an octahedron whose faces are cut in four `level` times, the corners on the sphere."""
    v = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]], float)
    f = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    for _ in range(level):
        a, b, c = (v[f[:, k]] for k in range(3))
        n = len(f)
        parts = [v, unit(a + b), unit(b + c), unit(c + a)]
        ab, bc, ca = (len(v) + k * n + np.arange(n) for k in range(3))
        f = np.concatenate(
            [np.stack(t, 1) for t in ((f[:, 0], ab, ca), (ab, f[:, 1], bc), (ca, bc, f[:, 2]), (ab, bc, ca))]
        )
        v, f = merge(np.concatenate(parts), f)
    return radius * v, f


def torus(ring, tube, around, across):
    """Return a torus about z: `around` segments of the ring, `across` of the tube."""
    u, w = np.meshgrid(*(2 * np.pi * np.arange(n) / n for n in (around, across)), indexing="ij")
    r = ring + tube * np.cos(w)
    v = np.stack([r * np.cos(u), r * np.sin(u), tube * np.sin(w)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    at = lambda a, b: ((a % around) * across + b % across).ravel()  # noqa: E731
    return v, split(np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], 1))


def cut_finer(v, f, times):
    """Cut each triangle in four, `times` times, without moving the surface."""
    for _ in range(times):
        a, b, c = (v[f[:, k]] for k in range(3))
        n, m = len(v), len(f)
        v = np.concatenate([v, (a + b) / 2, (b + c) / 2, (c + a) / 2])
        ab, bc, ca = (n + k * m + np.arange(m) for k in range(3))
        f = np.concatenate(
            [np.stack(t, 1) for t in ((f[:, 0], ab, ca), (ab, f[:, 1], bc), (ca, bc, f[:, 2]), (ab, bc, ca))]
        )
        v, f = merge(v, f)
    return v, f


def join(*meshes):
    """Put several bodies into one list of triangles."""
    count = np.cumsum([0] + [len(v) for v, _ in meshes])
    return np.concatenate([v for v, _ in meshes]), np.concatenate(
        [f + n for (_, f), n in zip(meshes, count, strict=False)]
    )


def soup(v, f, seed=0):
    """Give each triangle corners of its own, and shuffle triangles and the corner each starts with."""
    rng = np.random.default_rng(seed)
    f = rng.permutation(f)
    f = np.array([np.roll(t, rng.integers(3)) for t in f])
    return v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)


def merge(v, f):
    """Make vertices that agree in twelve digits one."""
    _, first, index = np.unique(np.round(v, 12) + 0.0, axis=0, return_index=True, return_inverse=True)
    return v[first], index.reshape(-1)[f]


def unit(a):
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def native(v, f):
    """Hand vertices and faces to the core."""
    from neve import _core

    return _core.geometry.TriangleMesh(np.ascontiguousarray(v, float), np.ascontiguousarray(f, np.int32))


def distance(v, f, points):
    """Distance from each point to the nearest triangle (n,): the least over inside, edges and corners."""
    a, b, c = (v[f[:, k]][None] for k in range(3))
    x = points[:, None]
    n = unit(np.cross(b - a, c - a))
    height = np.sum((x - a) * n, -1)
    foot = x - height[..., None] * n
    inside = np.ones(height.shape, bool)
    best = np.full(height.shape, np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= np.sum(np.cross(q - p, foot - p) * n, -1) >= 0
        t = np.clip(np.sum((x - p) * (q - p), -1) / np.sum((q - p) ** 2, -1), 0, 1)
        best = np.minimum(best, np.linalg.norm(x - p - t[..., None] * (q - p), axis=-1))
    return np.where(inside, np.abs(height), best).min(1)


def winding(v, f, points):
    """Return the sum of solid angles over 4 pi (n,): Van Oosterom and Strackee 1983, equation 8."""
    a, b, c = (v[f[:, k]][None] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(p, axis=-1) for p in (a, b, c))
    above = np.sum(a * np.cross(b, c), -1)
    below = la * lb * lc + np.sum(a * b, -1) * lc + np.sum(b * c, -1) * la + np.sum(c * a, -1) * lb
    return np.arctan2(above, below).sum(1) / (2 * np.pi)


def ray(v, f, origins, directions):
    """Length t at which each ray first meets a triangle (n,), inf for none: by Cramer's rule."""
    a, b, c = (v[f[:, k]][None] for k in range(3))
    o, d = origins[:, None], np.broadcast_to(directions[:, None], (len(origins), len(f), 3))
    n = np.cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        det = -np.sum(d * n, -1)
        t = np.sum((o - a) * n, -1) / det
        side = np.cross(o - a, d)
        u, w = np.sum((c - a) * side, -1) / det, -np.sum((b - a) * side, -1) / det
        hit = (det != 0) & (u >= 0) & (w >= 0) & (u + w <= 1) & (t > 0)
    return np.where(hit, t, np.inf).min(1)
