"""Known answer 6.

Without forces FLIP leaves every velocity alone, and the blend fades what the grid cannot see.
"""

import numpy as np
import pytest
from reference import splines
from verification.scenes import ELASTIC, ball, columns, march, scene, simulate, wide


@pytest.fixture(params=["flip", "asflip"])
def transfer(request):
    """The transfers with a share of FLIP."""
    return request.param


def still(spline, precision="float64", **numerics):
    return scene([ball(radius=0.12)], spline=spline, precision=precision, snow=ELASTIC, **numerics)


def scramble(sim, seed=6):
    v = np.random.default_rng(seed).standard_normal(sim.state.v.shape)
    sim.state.v[:] = v.astype(sim.state.v.dtype)
    return columns(sim)["v"]


def test_flip_is_the_identity(spline, precision, transfer):
    """v_p += sum w (v_i - v_i) with F_E = I, g = 0: the bracket is zero, so v_p is the same to the bit."""
    sim = simulate(still(spline, precision, transfer=transfer, flip_alpha=1.0))
    before = scramble(sim)
    march(sim, 1)
    np.testing.assert_array_equal(columns(sim)["v"], before)


def test_blend_is_linear(spline, precision, eps, transfer):
    """One step with alpha is (1 - alpha) PIC + alpha v to a few roundings of |v| <= 5."""
    results = {}
    for alpha in (0.0, 0.7):
        sim = simulate(still(spline, precision, transfer=transfer, flip_alpha=alpha))
        before = scramble(sim).astype(float)
        results[alpha] = wide(march(sim, 1))["v"]
    np.testing.assert_allclose(results[0.7], 0.3 * results[0.0] + 0.7 * before, atol=20 * eps, rtol=0)


def invisible(sim):
    """Return a velocity (n, 3), largest entry 1, with sum w m v = 0 at every node."""
    x = np.array(sim.state.x)
    ijk, w, _ = splines.stencil(sim.scene.numerics.spline, x, 0.05)
    nodes, index = np.unique(ijk.reshape(-1, 3), axis=0, return_inverse=True)
    A = np.zeros((len(nodes), len(x)))
    np.add.at(A, (index.reshape(-1), np.repeat(np.arange(len(x)), w.shape[1])), w.reshape(-1))
    mode = np.random.default_rng(0).standard_normal((len(x), 3))
    mode -= np.linalg.pinv(A, rcond=1e-10) @ (A @ mode)
    mode /= np.abs(mode).max()
    np.testing.assert_allclose(A @ mode, 0, atol=1e-9)
    return mode


def test_invisible_modes_fade_as_alpha_to_the_n(spline, transfer):
    """A velocity with sum w m v = 0 at every node sees no PIC part: after n steps it is alpha^n of itself.

    Such modes exist where particles outnumber nodes (64 a cell here); the null space of the transfer matrix
    gives one. The mode's particles drift by dt v a step, so the matrix changes by dt v / dx: with dt = 1e-9
    s, v <= 1 m/s, dx = 0.05 m and n = 5 steps that is 1e-7 in v, and the strain that appears, 1e-9, presses
    with nothing.
    """
    alpha, n = 0.9, 5
    sim = simulate(still(spline, transfer=transfer, flip_alpha=alpha, dt=1e-9, particles_per_cell=64))
    sim.state.v[:] = mode = invisible(sim)
    assert np.abs(mode).max() > 0.5
    before = wide(sim)["v"]
    march(sim, n)
    np.testing.assert_allclose(wide(sim)["v"], alpha**n * before, atol=2e-7, rtol=0)


def test_damping_does_not_depend_on_the_step(transfer):
    """flip_damping = r: such a mode is exp(-r t) of itself after the time t, whatever steps led there.

    With t = 0.4 us, r = 1e6 1/s and |v| <= 1 mm/s particles drift by 4e-10 m, 1e-8 cells, which the
    matrix follows: 1e-7 of the mode.
    """
    ends = []
    for steps in (1, 2, 4):
        sim = simulate(
            still(
                "quadratic", transfer=transfer, flip_damping=1e6, flip_alpha=0.3, dt=4e-7 / steps,
                particles_per_cell=64,
            )
        )  # fmt: skip
        sim.state.v[:] = 1e-3 * invisible(sim)
        before = wide(sim)["v"]
        ends.append(wide(march(sim, steps))["v"])
        np.testing.assert_allclose(ends[-1], np.exp(-0.4) * before, rtol=0, atol=1e-3 * 1e-7)


def displaced(transfer, squeeze, **numerics):
    """Return velocities before, after, and the displacement / dt, of soft scrambled snow after one step."""
    sim = simulate(still("quadratic", transfer=transfer, dt=1e-6, initial_volume="sampled", **numerics))
    sim.state.F_E[:] = squeeze * np.eye(3)
    sim.state.m[:] *= 1e12  # too heavy for its stress to matter
    before, x = scramble(sim), wide(sim)["x"]
    end = wide(march(sim, 1))
    return before, end["v"], (end["x"] - x) / 1e-6


def test_asflip_moves_apart_what_separates():
    """Snow at rest density follows its own velocity, squeezed snow (det F < exp(-0.001)) that of PIC.

    One step of 1 us strains by 1e-6 |v| / dx = 1e-4 at most, so gamma is decided by F alone, but for lanes
    within 1e-4 of 1: J_trial = 1 +- 3e-4 >= exp(-0.001). Velocities of 5 m/s, positions of 0.1 m: 1e-17 / dt.
    """
    before, v, way = displaced("asflip", 1.0, flip_alpha=1.0)
    np.testing.assert_allclose(v, before, rtol=0, atol=1e-9)
    np.testing.assert_allclose(way, before, rtol=0, atol=1e-9)
    before, v, way = displaced("asflip", 0.999, flip_alpha=1.0)
    pic = displaced("apic", 0.999)[1]
    np.testing.assert_allclose(v, before, rtol=0, atol=1e-9)
    np.testing.assert_allclose(way, pic, rtol=0, atol=1e-9)
    assert np.abs(before - pic).max() > 1
