"""Polar decompositions of many 3x3 matrices at once."""

import numpy as np


def transpose(A):
    return np.swapaxes(A, -1, -2)


def polar_svd(F):
    """Decompose F = U diag(sigma) V^T with rotations U, V; a reflection makes the smallest sigma negative."""
    U, sigma, Vt = np.linalg.svd(F)
    sigma = sigma.copy()
    for Q in (U, transpose(Vt)):  # the views write through
        flip = np.linalg.det(Q) < 0
        Q[flip, :, 2] *= -1
        sigma[flip, 2] *= -1
    return U, sigma, transpose(Vt)


def rotation(F):
    """Find R of the polar decomposition F = R S."""
    U, _, V = polar_svd(F)
    return U @ transpose(V)


def column(values, axes=2):
    """Append axes, so that one value per particle multiplies that particle's vector or matrix."""
    values = np.asarray(values, dtype=float)
    return values.reshape(values.shape + (1,) * axes) if values.ndim else values
