"""The velocity modes of PolyPIC around a particle, found by Gram-Schmidt rather than from formulas."""

import numpy as np

COUNTS = (1, 4, 8, 27)


def exponents(count):
    """Return the powers (count, 3) of the leading monomial of each mode, in the order in which they are kept.

    1; x, y, z; the products of different axes; then all with a square. Last index fastest within a group.
    """
    powers = [(a, b, c) for a in range(3) for b in range(3) for c in range(3)]

    def group(power):
        return 0 if sum(power) == 0 else 1 if sum(power) == 1 else 1 + max(power)

    linear = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
    rest = [p for p in sorted(powers, key=group) if group(p) > 1]  # a stable sort
    return [(0, 0, 0), *linear, *rest][:count]


def basis(w, z, count):
    """Return the modes s_r (n, K, count) at the nodes: monomials made orthogonal under <a, b> = sum w a b.

    w: weights (n, K); z: x_i - x_p in cells (n, K, 3). The leading coefficients stay 1. The 27 are found in
    extended precision: a square that hardly any node feels is a difference of large numbers.
    """
    if count > 8:
        w, z = w.astype(np.longdouble), z.astype(np.longdouble)
    modes, duals = [], []
    for power in exponents(count):
        s = np.prod(z ** np.array(power), axis=-1)
        for other, dual in zip(modes, duals, strict=True):
            s = s - other * (dual * s).sum(1)[:, None]
        weighted = w * s
        modes.append(s)
        duals.append(weighted / (weighted * s).sum(1)[:, None])
    return np.stack(modes, axis=-1)


def norms(w, s):
    """<s_r, s_r> = sum_i w_ip s_r^2 (n, count)."""
    return np.einsum("pk,pkr->pr", w, s**2)


def square_norm(value, offset, nodes, x):
    """sum w s^2 of the square mode of one axis, made orthogonal to 1 and z, at x [cells] (n,)."""
    x = np.asarray(x, dtype=np.longdouble)
    z = np.floor(x - offset)[..., None] + np.arange(nodes) - x[..., None]
    w = value(z)
    s = z**2
    for other in (np.ones_like(z), z):
        s = s - other * ((w * other * s).sum(-1) / (w * other**2).sum(-1))[..., None]
    return (w * s**2).sum(-1)


def moved(c, before, after):
    """Scale the coefficients c (n, count - 4, 3) of particles that move from norms `before` to `after`.

    Where a square mode would weigh more than before, it is scaled so that it weighs the same.
    """
    kept = np.sqrt(np.minimum(before / np.maximum(after, 1e-30), 1.0)).astype(float)
    squares = np.array(exponents(27))[4 : 4 + c.shape[1]] == 2
    return c * np.where(squares[None], kept[:, None, :], 1.0).prod(-1)[..., None]


def coefficients(w, s, v):
    """c_r = <s_r, v> / <s_r, s_r> (n, count, 3) of the velocities v (n, K, 3) at the nodes [m/s]."""
    c = np.einsum("pk,pkr,pka->pra", w.astype(s.dtype), s, v.astype(s.dtype))
    return (c / norms(w, s)[..., None]).astype(float)


def field(s, c):
    """sum_r s_r c_r at the nodes [m/s] (n, K, 3)."""
    return np.einsum("pkr,pra->pka", s, c).astype(float)
