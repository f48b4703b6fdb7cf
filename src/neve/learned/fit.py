"""Fit a network to samples by the method of Levenberg and Marquardt.

What is left over are two things: how the stress changes between a point and the expansion point, over
their distance, which is the error of the stiffness; and the stress at the expansion point, over its size.
A local energy Psi(F; F0) = N(F, F0) - (dN(F0, F0) - G(F0)) : F has the right force at F0 whatever N is
(Li et al. 2022); with a small second error the correction is small, and the energy hardly knows of rotations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.learned.network import Network, derivatives, stress
from neve.learned.samples import Samples

Array = NDArray[np.float64]

NEAR = 0.1
"""Distance of points below which the error of the stiffness counts less [units]."""


def _scales(on: Samples) -> tuple[Array, Array]:
    distance = np.sqrt(((on.u - on.u0) ** 2).sum(1, keepdims=True) + NEAR**2)
    return 1 / distance, 1 / np.sqrt(1 + (on.T0**2).sum(1, keepdims=True))


def residuals(net: Network, on: Samples) -> Array:
    """Return what is left over (6 n,), whose squares sum to the loss."""
    near, far = _scales(on)
    at = stress(net, on.u0, on.y) - on.T0
    change = stress(net, on.u, on.y) - on.T - at
    out: Array = np.concatenate([(near * change).ravel(), (far * at).ravel()]) / np.sqrt(len(on.u))
    return out


def linearised(net: Network, on: Samples) -> tuple[Array, Array]:
    """Return the residuals, and their derivatives by the weights (6 n, m)."""
    near, far = _scales(on)
    T0, D0 = derivatives(net, on.u0, on.y)
    T, D = derivatives(net, on.u, on.y)
    rows = 3 * len(on.u)
    at, change = T0 - on.T0, T - on.T - (T0 - on.T0)
    root = np.sqrt(len(on.u))
    r = np.concatenate([(near * change).ravel(), (far * at).ravel()]) / root
    D -= D0
    D *= near[..., None]
    D0 *= far[..., None]
    return r, np.concatenate([D.reshape(rows, -1), D0.reshape(rows, -1)]) / root


@dataclass(frozen=True)
class Errors:
    """Hold root mean square errors over the size of what is learned [1]: of stiffness, and of stress."""

    stiffness: float
    stress: float


def errors(net: Network, on: Samples) -> Errors:
    """Return the errors on samples."""
    near, far = _scales(on)
    r = residuals(net, on) * np.sqrt(len(on.u))
    rows = 3 * len(on.u)
    size = np.sqrt((near**2 * (on.T - on.T0) ** 2).sum()), np.sqrt((far**2 * on.T0**2).sum())
    return Errors(float(np.linalg.norm(r[:rows]) / size[0]), float(np.linalg.norm(r[rows:]) / size[1]))


def fit(net: Network, on: Samples, iterations: int) -> tuple[Network, list[float]]:
    """Return the fitted network, and the loss after each iteration, the first one before any [1]."""
    loss, damping = float((residuals(net, on) ** 2).sum()), 1e-2
    curve = [loss]
    for _ in range(iterations):
        r, D = linearised(net, on)
        A, b = D.T @ D, D.T @ r
        size = np.diag(A) + 1e-6 * np.diag(A).max()
        for _ in range(24):
            tried = net.filled(net.flat() - np.linalg.solve(A + np.diag(damping * size + 1e-9), b))
            now = float((residuals(tried, on) ** 2).sum())
            if now < loss:
                break
            damping *= 4
        else:
            break
        net, loss, damping = tried, now, max(damping / 3, 1e-9)
        curve.append(loss)
    return net, curve
