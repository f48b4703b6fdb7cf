"""What public ports of Gissler et al. 2020 get wrong: with each error the sums would be others than ours.

Each case returns what the core has, what it should be, and what it would be with the error.
"""

import numpy as np
import pytest
from verification.sph.common import GAMMA, SNOW, Oracle, add_floor, block, kernel, prepare, solve, world
from verification.sph.test_sph_sums import DT, SPIN, G, state

MU_C = 0.3
MU_B = MU_C * 2.0 * 0.05


def clamp_of_all_entries():
    """1 - theta_c in the six entries off the diagonal."""
    model, snow = world(), block((3, 3, 3))
    c, s = np.cos(0.6), np.sin(0.6)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    F = R @ np.diag([0.9, 1.1, 1.001]) @ R.T
    snow.F_E[...] = F
    prepare(snow, model)
    for name in ("given", "pressed", "sheared"):
        getattr(snow, name)[...] = 0.0
    assert snow.advance(model, DT, 1e9, 1e9).taken
    low, high = 1 - SNOW["theta_c"], 1 + SNOW["theta_s"]
    return snow.F_E[0], R @ np.diag([low, high, 1.001]) @ R.T, np.clip(F, low, high)


def poisson_in_the_numerator():
    """G = E nu / (2 (1 + nu))."""
    snow, _ = state(J_P_min=1e-3, J_P_max=1e3)
    right = Oracle(snow).G
    return snow.G, right, right * SNOW["nu"]


def solved():
    """A state and its oracle after both solves, and the acceleration of shear that follows from one."""
    snow, model = state(mu_c=MU_C)
    solve(snow, model, DT, tolerance=1e-11)
    o = Oracle(snow, G)
    o.G = np.array(snow.G)

    def acceleration(a, v_b, dt2=DT * DT, gradient=o.gradient, o=o):
        v = o.v + DT * (np.array(snow.given) + np.array(snow.pressed))
        F = o.F
        for u, u_b, by in ((v, o.v_b, DT), (a, v_b, dt2)):
            D = gradient(u, u_b)
            F = F + by * 0.5 * (D + np.swapaxes(D, 1, 2)) @ o.F
        return o.stress_divergence(o.stress(0.5 * (F + np.swapaxes(F, 1, 2)))) / o.rho[:, None]

    return snow, o, acceleration


def shear_a_hundred_times():
    """The acceleration of shear times 100."""
    snow, o, acceleration = solved()
    right = acceleration(np.array(snow.sheared), 0 * o.v_b)
    return snow.sheared, right, 100 * right


def dt_in_place_of_its_square():
    """M a = a - dt div (...) / rho: far too stiff."""
    snow, o, acceleration = solved()
    a = np.array(snow.sheared)
    return a, acceleration(a, 0 * o.v_b), acceleration(a, 0 * o.v_b, DT)


def moving_walls_in_the_operator():
    """The boundaries' velocities as their accelerations, in M."""
    snow, o, acceleration = solved()
    a = np.array(snow.sheared)
    return a, acceleration(a, 0 * o.v_b), acceleration(a, o.v_b / DT)


def one_correction_for_both():
    """L of particle i in the stress of its neighbours, too."""
    snow, o, acceleration = solved()
    a = np.array(snow.sheared)
    right = acceleration(a, 0 * o.v_b)

    def wrong(s):
        third = np.einsum("iaa->i", s)[:, None, None] / 3 * np.eye(3)
        dev = s - third
        own = np.einsum("iab,j,ijb->ia", third + dev @ o.L, o.V, o.g)
        other = np.einsum("jab,ibc,j,ijc->ia", dev, o.L, o.V, o.g)
        other += np.einsum("jab,j,ijb->ia", third, o.V, o.g)
        return own + other + np.einsum("iaa->i", s)[:, None] / 3 * np.einsum("j,ijb->ib", o.V_b, o.g_b)

    o.stress_divergence = wrong
    return a, right, acceleration(a, 0 * o.v_b)


def velocities_in_place_of_differences():
    """D from v_i in place of v_j - v_i."""
    snow, _ = state()
    o = Oracle(snow)
    u = np.random.default_rng(5).standard_normal((snow.count, 3))
    D_s = np.einsum("j,ia,ijb->iab", o.V, u, o.g)
    return snow.velocity_gradient(u), o.gradient(u, np.zeros_like(o.x_b)), D_s @ np.swapaxes(o.L, 1, 2)


def cut_at_half_of_the_support():
    """The kernel's sum over what is nearer than h / 2, though it reaches h."""
    snow, _ = state()
    o = Oracle(snow)
    near = np.linalg.norm(o.x[:, None] - o.x[None], axis=2) < o.h / 2
    J = np.abs(np.linalg.det(o.F))
    cut = (np.where(near, o.W, 0.0) @ o.m) / (1.0 - J * (o.W_b @ o.V_b))
    return snow.rho, o.rho, cut


def density_without_boundaries():
    """V = m / rho of the snow alone in the sums, where rho has boundaries in it."""
    snow, _ = state()
    o = Oracle(snow)
    u = np.random.default_rng(5).standard_normal((snow.count, 3))
    right = o.gradient(u, np.zeros_like(o.x_b))
    o.V = o.m / (o.W @ o.m)
    return snow.velocity_gradient(u), right, o.gradient(u, np.zeros_like(o.x_b))


def velocity_for_acceleration():
    """a_friction = v' / dt."""
    snow, model = state(mu_c=MU_C)
    snow.find_given(model, DT)
    o = Oracle(snow, G)
    right, _ = o.friction(DT, MU_B, SPIN)
    return np.asarray(snow.given) - G, right, right + (o.v + DT * np.array(G)) / DT


def product_for_sum():
    """|x|^2 times 0.01 h^2 below the line of the friction."""
    snow, model = state(mu_c=MU_C)
    snow.find_given(model, DT)
    o = Oracle(snow, G)
    right, _ = o.friction(DT, MU_B, SPIN)
    x = o.x[:, None] - o.x_b[None]
    r2, soft = np.sum(x * x, axis=2), 0.01 * o.h**2
    k = MU_B * o.V_b * np.sum(x * o.g_b, axis=2) / (r2 * soft)
    carried = np.einsum("ij,ija->ia", k, o.v_b[None] + np.cross(SPIN, x))
    fallen = o.v + DT * np.array(G)
    wrong = ((fallen - DT * carried) / (1 - DT * k.sum(axis=1))[:, None] - fallen) / DT
    return np.asarray(snow.given) - G, right, wrong


def volumes_asked_for_twice():
    """The sum of a boundary particle's kernels goes on where it stood, for each particle that asks."""
    snow, model = state()
    right = Oracle(snow).V_b
    for _ in range(3):
        prepare(snow, model)
    W, _ = kernel(np.array(snow.boundary_x)[:, None] - np.array(snow.boundary_x)[None], snow.support)
    return np.sort(snow.boundary_V), np.sort(right), np.sort(GAMMA / (4 * W.sum(axis=1)))


@pytest.mark.parametrize(
    "case",
    [
        clamp_of_all_entries,
        poisson_in_the_numerator,
        shear_a_hundred_times,
        dt_in_place_of_its_square,
        moving_walls_in_the_operator,
        one_correction_for_both,
        velocities_in_place_of_differences,
        cut_at_half_of_the_support,
        density_without_boundaries,
        velocity_for_acceleration,
        product_for_sum,
        volumes_asked_for_twice,
    ],
)
def test_no_port_s_error_is_in_the_core(case):
    """The core agrees with what should be to 1e-8 of the largest; the error is a million times that away."""
    core, right, wrong = map(np.asarray, case())
    scale = np.abs(right).max()
    assert np.abs(core - right).max() < 1e-8 * scale
    assert np.abs(core - wrong).max() > 1e-2 * scale


@pytest.mark.parametrize("side", [5, 20, 40])
def test_volumes_take_a_kernel_for_each_neighbour(side):
    """Kernels of 2 d over a square lattice: those of the 3 x 3 places around each, not of all n^2 pairs.

    Nor is a volume summed again when snow asks for it: steps take none.
    """
    d = 0.05
    snow, model = block((2, 2, 2)), world()
    add_floor(snow, model)
    assert snow.support == pytest.approx(2 * d)
    along = np.arange(side) * 1.1 * d  # two places on lie beyond the support
    at = np.stack(np.meshgrid(along, along, indexing="ij"), axis=-1).reshape(-1, 2)
    x = np.c_[at - at.mean(axis=0), np.full(len(at), -d)]
    before = snow.boundary_kernels
    snow.set_boundary(x, np.tile([0.0, 0.0, 1.0], (len(x), 1)), np.zeros(len(x), dtype=np.int32))
    once = (3 * side - 2) ** 2
    assert snow.boundary_kernels - before == once
    for _ in range(3):
        prepare(snow, model)
    assert snow.boundary_kernels - before == once
