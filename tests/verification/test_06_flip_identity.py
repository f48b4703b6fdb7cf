"""Known answer 6.

Without forces FLIP leaves every velocity alone, and the blend fades what the grid cannot see.
"""

import numpy as np
from reference import splines
from verification.scenes import ELASTIC, ball, columns, march, scene, simulate, wide


def still(spline, precision="float64", radius=0.12, **numerics):
    return scene(
        [ball(radius=0.12)], spline=spline, precision=precision, transfer="flip", snow=ELASTIC, **numerics
    )


def scramble(sim, seed=6):
    v = np.random.default_rng(seed).standard_normal(sim.state.v.shape)
    sim.state.v[:] = v.astype(sim.state.v.dtype)
    return columns(sim)["v"]


def test_flip_is_the_identity(spline, precision):
    """v_p += sum w (v_i - v_i) with F_E = I, g = 0: the bracket is zero, so v_p is the same to the bit."""
    sim = simulate(still(spline, precision, flip_alpha=1.0))
    before = scramble(sim)
    march(sim, 1)
    np.testing.assert_array_equal(columns(sim)["v"], before)


def test_blend_is_linear(spline, precision, eps):
    """One step with alpha is (1 - alpha) PIC + alpha v to a few roundings of |v| <= 5."""
    results = {}
    for alpha in (0.0, 0.7):
        sim = simulate(still(spline, precision, flip_alpha=alpha))
        before = scramble(sim).astype(float)
        results[alpha] = wide(march(sim, 1))["v"]
    np.testing.assert_allclose(results[0.7], 0.3 * results[0.0] + 0.7 * before, atol=20 * eps, rtol=0)


def test_invisible_modes_fade_as_alpha_to_the_n(spline):
    """A velocity with sum w m v = 0 at every node sees no PIC part: after n steps it is alpha^n of itself.

    Such modes exist where particles outnumber nodes (64 a cell here); the null space of the transfer matrix
    gives one. The mode's particles drift by dt v a step, so the matrix changes by dt v / dx: with dt = 1e-9
    s, v <= 1 m/s, dx = 0.05 m and n = 5 steps that is 1e-7 in v, and the strain that appears, 1e-9, presses
    with nothing.
    """
    alpha, n = 0.9, 5
    sim = simulate(still(spline, flip_alpha=alpha, dt=1e-9, radius=0.06, particles_per_cell=64))
    x = np.array(sim.state.x)
    ijk, w, _ = splines.stencil(spline, x, 0.05)
    nodes, index = np.unique(ijk.reshape(-1, 3), axis=0, return_inverse=True)
    A = np.zeros((len(nodes), len(x)))
    np.add.at(A, (index.reshape(-1), np.repeat(np.arange(len(x)), w.shape[1])), w.reshape(-1))
    mode = np.random.default_rng(0).standard_normal((len(x), 3))
    mode -= np.linalg.pinv(A, rcond=1e-10) @ (A @ mode)
    mode /= np.abs(mode).max()
    assert np.abs(mode).max() > 0.5
    np.testing.assert_allclose(A @ mode, 0, atol=1e-9)
    sim.state.v[:] = mode
    before = wide(sim)["v"]
    march(sim, n)
    np.testing.assert_allclose(wide(sim)["v"], alpha**n * before, atol=2e-7, rtol=0)
