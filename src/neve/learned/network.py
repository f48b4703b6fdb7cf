"""A small network for the energy of snow that flows, its stress, and the derivatives of that by the weights.

With principal logarithmic strains u_i in units of a strain (see `neve.learned.targets`) and a context y of
where the energy is expanded and of the snow's constants,

    z_k = sum_i softplus(a_k u_i + b_k),  z_K+1 = sum_i u_i,  z_K+2 = sqrt(|dev u|^2 + ROUND^2)
    H = W z + V y + d,   N = sum_h w_h softplus(H_h) + q_0/2 (sum_i u_i)^2 + q_1/2 sum_i u_i^2

so that N stays if axes change places and has all derivatives. dN/du_i is the Kirchhoff stress in units of
the stress that belongs to the strain. Sums over axes: Zaheer et al. 2017, "Deep sets" (from memory). The
core's `cpu/implicit/learned.hpp` has the same equations on lanes.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROUND = 0.05
"""Deviator below which its size is rounded off [1]."""


@dataclass(frozen=True)
class Network:
    """Hold the weights [1]: a, b (K,), W (H, K + 2), V (H, Y), w, d (H,), q (2,)."""

    a: Array
    b: Array
    W: Array
    V: Array
    w: Array
    d: Array
    q: Array

    def flat(self) -> Array:
        """Return all weights in one row (n,), in the order of the fields."""
        return np.concatenate([getattr(self, f.name).ravel() for f in fields(self)])

    def filled(self, row: Array) -> Network:
        """Return a network of this shape with the weights of `row` (n,)."""
        parts, begin = {}, 0
        for f in fields(self):
            own = getattr(self, f.name)
            parts[f.name] = row[begin : begin + own.size].reshape(own.shape)
            begin += own.size
        return Network(**parts)


def first(rng: np.random.Generator, steps: int, hidden: int, context: int, reach: float) -> Network:
    """Return random weights: a third of the `steps` at strains of one unit, where snow yields, the others
    up to `reach` units.
    """
    near = np.arange(steps) % 3 == 0
    at = np.where(near, rng.choice([-1.0, 1.0], steps), rng.uniform(-reach, reach, steps))
    a = np.where(near, rng.uniform(2, 6, steps), rng.uniform(0.3, 1.5, steps))
    inverse = np.concatenate([1 / a, [1.0, 1.0]])
    return Network(
        a=a,
        b=-a * at,
        W=rng.normal(0, 0.5 / np.sqrt(steps), (hidden, steps + 2)) * inverse,
        V=rng.normal(0, 0.3, (hidden, context)),
        w=rng.normal(0, 0.2 / hidden, hidden),
        d=rng.normal(0, 1, hidden),
        q=np.array([0.3, 0.8]),
    )


def softplus(x: Array) -> Array:
    """Return ln(1 + exp x)."""
    return np.logaddexp(0.0, x)


def sigmoid(x: Array) -> Array:
    """Return 1 / (1 + exp -x)."""
    out: Array = 0.5 * (1.0 + np.tanh(0.5 * x))
    return out


@dataclass(frozen=True)
class Pooled:
    """Hold sums over axes z (n, K + 2), and s (n, 3, K + 2) their derivatives by the strains."""

    steps: Array  # sigmoid(a u + b), (n, 3, K)
    z: Array
    s: Array


def pooled(net: Network, u: Array) -> Pooled:
    """Return what the hidden layer sees of strains u (n, 3)."""
    x = u[..., None] * net.a + net.b
    steps = sigmoid(x)
    trace = u.sum(1, keepdims=True)
    dev = u - trace / 3
    size = np.sqrt((dev**2).sum(1, keepdims=True) + ROUND**2)
    z = np.concatenate([softplus(x).sum(1), trace, size], axis=1)
    s = np.concatenate([steps * net.a, np.ones_like(u)[..., None], (dev / size)[..., None]], axis=2)
    return Pooled(steps, z, s)


def stress(net: Network, u: Array, y: Array) -> Array:
    """Return dN/du (n, 3) at strains u (n, 3) in the context y (n, Y)."""
    at = pooled(net, u)
    H = at.z @ net.W.T + y @ net.V.T + net.d
    Q = (net.w * sigmoid(H)) @ net.W
    out: Array = (at.s @ Q[..., None])[..., 0] + net.q[0] * u.sum(1, keepdims=True) + net.q[1] * u
    return out


def derivatives(net: Network, u: Array, y: Array) -> tuple[Array, Array]:
    """Return the stress as `stress` does, and its derivatives by all weights (n, 3, m), as in `flat`."""
    at, K = pooled(net, u), net.a.size
    H = at.z @ net.W.T + y @ net.V.T + net.d
    S = sigmoid(H)
    p, bend = net.w * S, net.w * S * (1 - S)
    Q = p @ net.W
    trace = u.sum(1, keepdims=True)
    T = (at.s @ Q[..., None])[..., 0] + net.q[0] * trace + net.q[1] * u
    R = at.s @ net.W.T  # dH_h/du_i, (n, 3, H)
    Rb = R * bend[:, None, :]
    C = (Rb @ net.W)[..., :K]
    slope, Qa = at.steps * (1 - at.steps), (Q[:, :K] * net.a)[:, None, :]
    sums, moments = at.steps.sum(1), (at.steps * u[..., None]).sum(1)
    n = len(u)
    parts = [
        at.steps * Q[:, None, :K] + Qa * slope * u[..., None] + C * moments[:, None, :],
        Qa * slope + C * sums[:, None, :],
        (p[:, None, :, None] * at.s[:, :, None, :] + Rb[..., None] * at.z[:, None, None, :]).reshape(
            n, 3, -1
        ),
        (Rb[..., None] * y[:, None, None, :]).reshape(n, 3, -1),
        R * S[:, None, :],
        Rb,
        np.stack([np.broadcast_to(trace, u.shape), u], axis=2),
    ]
    return T, np.concatenate(parts, axis=2)
