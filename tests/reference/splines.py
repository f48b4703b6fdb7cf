"""B-splines that tie a particle to the grid nodes around it."""

import numpy as np

# Nodes touched along one axis; distance from x/dx to the first of them is found with `OFFSET`; and the second
# moment D = sum_i w_ip (x_i - x_p)(x_i - x_p)^T = MOMENT dx^2 I, the same for every position of the particle.
NODES = {"quadratic": 3, "cubic": 4}
OFFSET = {"quadratic": 0.5, "cubic": 1.0}
MOMENT = {"quadratic": 1.0 / 4.0, "cubic": 1.0 / 3.0}


def value(spline, r):
    """Evaluate the spline N at the signed distance r [cells].

    The outer pieces are written as powers of the distance to the edge: the expanded polynomials, such as the
    paper's -r^3/6 + r^2 - 2 r + 4/3 = (2 - r)^3/6, lose all digits there, and f/m of a light node needs them.
    """
    a = np.abs(r)
    if spline == "quadratic":
        return np.where(a < 0.5, 0.75 - a**2, np.where(a < 1.5, 0.5 * (1.5 - a) ** 2, 0.0))
    return np.where(a < 1, a**3 / 2 - a**2 + 2 / 3, np.where(a < 2, (2 - a) ** 3 / 6, 0.0))


def slope(spline, r):
    """Evaluate dN/dr at the signed distance r [cells]."""
    a, side = np.abs(r), np.sign(r)
    if spline == "quadratic":
        return side * np.where(a < 0.5, -2 * a, np.where(a < 1.5, a - 1.5, 0.0))
    return side * np.where(a < 1, 1.5 * a**2 - 2 * a, np.where(a < 2, -((2 - a) ** 2) / 2, 0.0))


def stencil(spline, x, dx):
    """Find the nodes around each particle with their weights.

    Args:
        spline: "quadratic" or "cubic".
        x: positions [m] (n, 3).
        dx: cell size [m].

    Returns:
        ijk: node numbers (n, K, 3), K = 27 or 64; node i stands at i dx.
        w: w_ip = N(x) N(y) N(z) [1] (n, K).
        grad_w: gradient of w_ip with respect to x_p [1/m] (n, K, 3).
    """
    k = NODES[spline]
    base = np.floor(x / dx - OFFSET[spline]).astype(np.int64)
    cube = np.stack(np.meshgrid(*[np.arange(k)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    ijk = base[:, None, :] + cube[None, :, :]
    r = x[:, None, :] / dx - ijk
    N, dN = value(spline, r), slope(spline, r) / dx
    w = N.prod(axis=-1)
    grad_w = np.empty_like(r)
    grad_w[..., 0] = dN[..., 0] * N[..., 1] * N[..., 2]
    grad_w[..., 1] = N[..., 0] * dN[..., 1] * N[..., 2]
    grad_w[..., 2] = N[..., 0] * N[..., 1] * dN[..., 2]
    return ijk, w, grad_w
