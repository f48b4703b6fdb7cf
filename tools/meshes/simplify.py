"""Leave out triangles that a surface does not need: edge collapses by quadric error.

Source: Garland & Heckbert 1997, "Surface simplification using quadric error metrics", SIGGRAPH, sections
3 to 5. Here many edges whose surroundings do not touch collapse at once, the cheapest of each
neighbourhood first.
"""

from __future__ import annotations

import numpy as np
from implicit import Array
from numpy.typing import NDArray

Faces = NDArray[np.int64]


def simplify(vertices: Array, faces: Faces, target: int, most: float) -> tuple[Array, Faces]:
    """Return the mesh with about `target` triangles or fewer; a closed manifold stays one.

    most: root of the largest error, about the distance to the old surface, that a collapse may make beyond
    which only the target asks for it [m]: collapses below it are made even when the target is reached.
    """
    x, f = vertices.copy(), faces.copy()
    Q = _quadrics(x, f)
    random = np.random.default_rng(0)
    for _ in range(200):
        edge, cost, place = _costs(x, f, Q)
        # On a flat all costs are alike: a random factor gives every neighbourhood a best one of its own.
        excess, order = (len(f) - target + 1) // 2, cost * random.uniform(0.5, 2.0, len(cost))
        cheap = np.argsort(order, kind="stable")[: max(len(edge) // 3, 64)]
        if excess <= 0:
            cheap = cheap[cost[cheap] < most**2]
        cheap = cheap[_allowed(x, f, edge[cheap], place[cheap], edge)]
        chosen = _apart(edge, cheap, len(x))
        if excess > 0:  # beyond the free ones, no more than the target asks for
            chosen = chosen[: max(excess, int(np.sum(cost[chosen] < most**2)))]
        if len(chosen) == 0:
            break
        a, b = edge[chosen].T
        x[a] = place[chosen]
        Q[a] += Q[b]
        new = np.arange(len(x))
        new[b] = a
        f = new[f]
        f = f[(f[:, 0] != f[:, 1]) & (f[:, 1] != f[:, 2]) & (f[:, 2] != f[:, 0])]
    used, f = np.unique(f, return_inverse=True)
    return x[used], f.reshape(-1, 3)


def _quadrics(x: Array, f: Faces) -> Array:
    """Return the sum of squared distances to the planes of each vertex' triangles, as (n, 4, 4) forms."""
    a, b, c = x[f[:, 0]], x[f[:, 1]], x[f[:, 2]]
    n = np.cross(b - a, c - a)
    area = np.linalg.norm(n, axis=1, keepdims=True)
    n = n / np.maximum(area, 1e-30)
    plane = np.concatenate([n, -np.sum(n * a, axis=1, keepdims=True)], axis=1)
    # Equal weights per triangle: the grid's triangles are alike, and the cost stays a squared length.
    form = (plane[:, :, None] * plane[:, None, :]).reshape(-1, 16)
    flat = np.concatenate([f[:, i] for i in range(3)])
    sums = [np.bincount(flat, np.tile(column, 3), len(x)) for column in form.T]
    return np.stack(sums, -1).reshape(-1, 4, 4)


def _costs(x: Array, f: Faces, Q: Array) -> tuple[Faces, Array, Array]:
    """Return all edges (n, 2), the error of collapsing each and where to."""
    pairs = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), axis=1)
    key = np.unique(pairs[:, 0] * len(x) + pairs[:, 1])
    edge = np.stack([key // len(x), key % len(x)], -1)
    q = Q[edge[:, 0]] + Q[edge[:, 1]]
    ends = x[edge[:, 0]], x[edge[:, 1]]
    middle = 0.5 * (ends[0] + ends[1])
    A = q[:, :3, :3] + 1e-3 * np.trace(q[:, :3, :3], axis1=1, axis2=2)[:, None, None] * np.eye(3)
    right = -q[:, :3, 3] - np.einsum("eij,ej->ei", q[:, :3, :3], middle)
    best = middle + np.linalg.solve(A, right[..., None])[..., 0]
    place, cost = best, _error(q, best)
    for other in ends:
        e = _error(q, other)
        better = e < 0.98 * cost
        place, cost = np.where(better[:, None], other, place), np.where(better, e, cost)
    # Among flats all is free: prefer short edges, so that triangles stay round.
    length = np.sum((ends[1] - ends[0]) ** 2, axis=1)
    return edge, np.maximum(cost, 0.0) + 1e-5 * length, place


def _error(q: Array, x: Array) -> Array:
    h = np.concatenate([x, np.ones((len(x), 1))], axis=1)
    return np.einsum("ei,eij,ej->e", h, q, h)


def _lists(owner: Faces, item: Faces, n: int) -> tuple[Faces, Faces]:
    """Return the items of each owner as one array and where each owner's begin."""
    order = np.argsort(owner, kind="stable")
    return item[order], np.searchsorted(owner[order], np.arange(n + 1))


def _expand(first: Faces, start: Faces) -> tuple[Faces, Faces]:
    """Return for each of `first` (owners) its number and the places of its items."""
    count = start[first + 1] - start[first]
    who = np.repeat(np.arange(len(first)), count)
    within = np.arange(len(who)) - np.repeat(np.cumsum(count) - count, count)
    return who, start[first][who] + within


def _allowed(x: Array, f: Faces, edge: Faces, place: Array, edges: Faces) -> NDArray[np.bool_]:
    """Say which edges can collapse: exactly two common neighbours, no triangle turns over or gets thin."""
    n = len(x)
    both = np.concatenate([edges, edges[:, ::-1]])
    neighbour, start = _lists(both[:, 0], both[:, 1], n)
    who, at = _expand(edge[:, 0], start)
    key = edge[who, 1] * n + neighbour[at]
    known = np.sort(both[:, 0] * n + both[:, 1])
    found = known[np.minimum(np.searchsorted(known, key), len(known) - 1)] == key
    fine = np.bincount(who[found], minlength=len(edge)) == 2
    incident, begin = _lists(f.reshape(-1), np.repeat(np.arange(len(f)), 3), n)
    for end in range(2):
        who, at = _expand(edge[:, end], begin)
        t = f[incident[at]]
        stays = ~np.any(t == edge[who, 1 - end][:, None], axis=1)
        who, t = who[stays], t[stays]
        old = x[t]
        new = np.where((t == edge[who, end][:, None])[..., None], place[who][:, None, :], old)
        n0 = np.cross(old[:, 1] - old[:, 0], old[:, 2] - old[:, 0])
        n1 = np.cross(new[:, 1] - new[:, 0], new[:, 2] - new[:, 0])
        l0, l1 = np.linalg.norm(n0, axis=1), np.linalg.norm(n1, axis=1)
        longest = np.max(np.sum((new - np.roll(new, 1, axis=1)) ** 2, axis=2), axis=1)
        # A needle of the old mesh has no direction to keep.
        bad = (np.sum(n0 * n1, axis=1) < 0.5 * l0 * l1) & (l0 > 1e-3 * longest) | (l1 < 0.02 * longest)
        fine &= np.bincount(who[bad], minlength=len(edge)) == 0
    return fine


def _apart(edge: Faces, order: Faces, n: int) -> Faces:
    """Return those of the edges `order` (best first) that are the best of all around them."""
    rank = np.full(len(edge), len(edge))
    rank[order] = np.arange(len(order))
    best = np.full(n, len(edge))
    for end in range(2):
        np.minimum.at(best, edge[:, end], rank)
    around = best.copy()
    for end in range(2):
        np.minimum.at(around, edge[:, end], best[edge[:, 1 - end]])
    a, b = edge[order].T
    return order[(around[a] == rank[order]) & (around[b] == rank[order])]
