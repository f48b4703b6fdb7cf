"""Each sum of smoothed particles against NumPy over all pairs: what public ports get wrong fails here."""

from itertools import pairwise

import numpy as np
import pytest
from verification.sph.common import Oracle, add_floor, block, kernel, prepare, solve, world

from neve import _core

G = (0.3, -0.2, -9.81)
DT = 2e-3
SPIN = (1.0, -2.0, 3.0)


def state(mode="slip", mu_c=0.3, velocity=(0.4, -0.3, 0.2), spin=SPIN, **snow_constants):
    """Snow that is strained, moves at random and lies on a floor that moves and turns; its model."""
    model = world(G, **snow_constants)
    snow = block((6, 5, 5), jitter=0.3, low=(-0.12, -0.1, 0.02))
    rng = np.random.default_rng(3)
    snow.v[...] = 0.5 * rng.standard_normal((snow.count, 3))
    e = 0.01 * rng.standard_normal((snow.count, 3, 3))
    snow.F_E[...] = np.eye(3) + 0.5 * (e + np.swapaxes(e, 1, 2))
    snow.rho_birth[...] = 400.0
    add_floor(snow, model, 0.4, mode, mu_c, velocity, spin)
    prepare(snow, model)
    return snow, model


def same(a, b, rel=1e-11):
    """Whether arrays agree to `rel` of the largest number."""
    a, b = np.asarray(a), np.asarray(b)
    np.testing.assert_allclose(a, b, rtol=0, atol=rel * np.abs(b).max())


def test_the_kernel_ends_at_its_support_and_sums_to_one():
    """On a lattice of half the support it sums to 1 within 1e-4; the gradient is its derivative."""
    at = np.stack(np.meshgrid(*[np.arange(-3, 4)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * 0.05
    W, _ = kernel(at, 0.1)
    assert W.sum() * 0.05**3 == pytest.approx(1.0, abs=1e-4)
    x = np.array([[0.02, 0.03, 0.01], [0.05, 0.04, 0.03], [0.1, 0.0, 0.0], [0.06, 0.06, 0.06]])
    W, g = kernel(x, 0.1)
    for k in range(3):
        step = 1e-6 * np.eye(3)[k]
        same((kernel(x + step, 0.1)[0] - kernel(x - step, 0.1)[0]) / 2e-6, g[:, k], 1e-6)
    assert W[2] == W[3] == 0.0


def test_pairs_reach_the_support_and_no_farther():
    """A cut-off at half of the support, where the kernel is a quarter of its peak, would lose most pairs."""
    snow, _ = state()
    o = Oracle(snow)
    assert snow.pairs[0] == (o.W > 0).sum() - snow.count
    assert snow.pairs[1] == (o.W_b > 0).sum()


def test_densities():
    """rho and rho_0 = J rho have the boundary in them; V_b is each boundary particle's own."""
    snow, _ = state()
    o = Oracle(snow)
    assert (o.W_b @ o.V_b).max() > 0.1  # the boundary counts
    same(snow.boundary_V, o.V_b)
    for name in ("rho0", "rho", "L"):
        same(getattr(snow, name), getattr(o, name))
    same(snow.J_P, 400.0 / o.rho0)


def test_moduli():
    """lam = E nu / ((1 + nu) (1 - 2 nu)), G = E / (2 (1 + nu)), hardened by exp(xi (rho_0 - 400) / rho_0)."""
    snow, _ = state(J_P_min=1e-3, J_P_max=1e3)
    o = Oracle(snow)
    same(snow.lam, o.lam)
    same(snow.G, o.G)


def test_the_rest_density_at_birth_is_that_of_the_first_sums():
    """Where none is given, J_P is 1 at first, at surfaces too; later it says how the rest density changed."""
    snow, model = block((5, 5, 5)), world()
    prepare(snow, model)
    np.testing.assert_array_equal(snow.rho_birth, snow.rho0)
    np.testing.assert_array_equal(snow.J_P, 1.0)
    snow.x[...] *= 0.98
    prepare(snow, model)
    assert np.all(np.asarray(snow.J_P) < 0.98)


def test_volumes_of_boundaries():
    """On a lattice V_b = gamma / sum W_bb', once for each; the sum does not grow with who asks for it."""
    snow, _ = state()
    at = np.stack(np.meshgrid(*[np.arange(-3, 4)] * 2, indexing="ij"), axis=-1).reshape(-1, 2) * 0.05
    W, _ = kernel(np.c_[at, np.zeros(len(at))], 0.1)
    assert np.asarray(snow.boundary_V).min() == pytest.approx(0.8 / W.sum(), rel=1e-12)


@pytest.mark.parametrize("mu_c", [0.0, 0.1, 1.0])
def test_friction_is_an_acceleration(mu_c):
    """`given` is gravity and (v' - v - dt g) / dt, not v' / dt; without friction it is gravity."""
    snow, model = state(mu_c=mu_c)
    snow.find_given(model, DT)
    o = Oracle(snow, G)
    expected, _ = o.friction(DT, 0.1 * mu_c, SPIN)
    same(np.asarray(snow.given) - G, expected) if mu_c else same(snow.given, np.tile(G, (snow.count, 1)))


def test_pressure():
    """The solved pressures fulfil A p = rho_0 - rho*, with either sign, and give -grad p / rho."""
    snow, model = state()
    pressure, _ = solve(snow, model, DT)
    assert pressure.converged
    o = Oracle(snow, G)
    p = np.array(snow.p)
    v = o.v + DT * np.array(snow.given)
    rho_star = o.rho - DT * o.rho * o.divergence(v, o.v_b)
    gradient = o.pressure_gradient(p)
    A = -(o.rho0 / np.asarray(snow.lam)) * p + DT**2 * o.divergence(gradient, np.zeros_like(o.x_b))
    assert np.mean(np.abs(o.rho0 - rho_star - A) / o.rho0) < 2e-9
    assert p.min() < 0 < p.max()
    same(snow.pressed, -gradient / o.rho[:, None], 1e-9)


def test_pressure_is_solved_at_each_particle():
    """Two particles pressed together in much snow at rest: the mean residual tells nothing of them."""
    model = world()
    left = []
    for largest in (1.0, 1e-3):
        snow = block((10, 10, 10))
        middle = np.argsort(np.linalg.norm(np.asarray(snow.x) - 0.225, axis=1))[:2]
        snow.rho_birth[...] = 400.0
        snow.x[middle[0]] = 0.7 * snow.x[middle[1]] + 0.3 * snow.x[middle[0]]
        snow.v[middle[0]] = 20.0 * (snow.x[middle[1]] - snow.x[middle[0]]) / 0.05
        prepare(snow, model)
        snow.find_given(model, DT)
        report = snow.solve_pressure(model, DT, 1e-3, largest, 500)
        assert report.converged
        assert report.residual <= 1e-3
        left.append(report.largest)
    assert left[1] <= 1e-3 < 1e-2 < left[0]


def test_no_pull_on_what_snow_may_leave():
    """With mode = "separate" boundaries mirror pressure alone; with "slip" tension, too."""
    free, held = (state(mode) for mode in ("separate", "slip"))
    for snow, model in (free, held):
        solve(snow, model, DT)
    o = Oracle(free[0], G)
    p = np.array(free[0].p)
    near = np.linalg.norm(np.einsum("j,ija->ia", o.V_b, o.g_b), axis=1) > 0
    assert (p[near] < 0).any()
    whole = -o.pressure_gradient(p) / o.rho[:, None]
    differs = np.linalg.norm(whole - np.asarray(free[0].pressed), axis=1) > 1e-9 * np.abs(whole).max()
    assert set(np.flatnonzero(differs)) == set(np.flatnonzero(near & (p < 0)))


def test_no_pull_of_shear_either():
    """Where tr s(F*) > 0 no boundary of mode "separate" acts on it: it would hold snow by its trace."""
    snow, model = state("separate")
    _, shear = solve(snow, model, DT, tolerance=1e-11)
    assert shear.converged
    o = Oracle(snow, G)
    a = np.array(snow.sheared)
    v = o.v + DT * (np.array(snow.given) + np.array(snow.pressed))
    traces = np.einsum("iaa->i", o.strained(o.F, v, o.v_b, DT)) - 3.0
    near = np.linalg.norm(np.einsum("j,ija->ia", o.V_b, o.g_b), axis=1) > 0
    leaves = np.flatnonzero(near & (traces > 0))
    assert 5 < len(leaves) < near.sum() - 5
    F = o.strained(o.F, v + DT * a, o.v_b, DT)
    F += _only_walls_that_hold(o, a, leaves)
    same(a, o.stress_divergence(o.stress(F), leaves) / o.rho[:, None], 1e-9)


def _only_walls_that_hold(o, a, leaves):
    """What the boundaries' part of tr D[a] adds to (1 + dt S) F of the particles that leave, less."""
    out = np.zeros_like(o.F)
    walls = np.einsum("j,ija->ia", o.V_b, o.g_b)
    for p in leaves:
        out[p] = DT**2 * (a[p] @ walls[p]) / 3 * o.F[p]
    return out


def test_stretched_snow_does_not_pull_the_ground():
    """Snow stretched by 0.5 % along all axes at rest on a floor that it may leave gives it no impulse."""
    for mode, pulls in (("separate", False), ("slip", True)):
        model, snow = world(), block((6, 6, 6), low=(-0.125, -0.125, 0.025))
        snow.F_E[...] = 1.005 * np.eye(3)
        add_floor(snow, model, 0.4, mode, mu_c=0.0)
        prepare(snow, model)
        solve(snow, model, DT)
        assert snow.advance(model, DT, 1e9, 1e9).taken
        given = snow.take_exchanged(1)[0]
        assert (given[2] > 1e-3) == pulls
        assert pulls or np.abs(given[:6]).max() == 0.0


def test_gradient():
    """D[u] is that of equations 17 and 18, of snow and boundary; its rotation is from differences of u."""
    snow, _ = state()
    o = Oracle(snow)
    u = np.random.default_rng(5).standard_normal((snow.count, 3))
    same(snow.velocity_gradient(u), o.gradient(u, np.zeros_like(o.x_b)))
    assert (
        np.abs(o.gradient(u + 7.0, np.full_like(o.x_b, 7.0)) - o.gradient(u, np.zeros_like(o.x_b))).max()
        < 1e-9
    )


def test_shear():
    """The solved acceleration is div s / rho of the strain at the end, (1 + dt S[v + dt a]) F."""
    snow, model = state()
    _, shear = solve(snow, model, DT, tolerance=1e-11)
    assert shear.converged
    o = Oracle(snow, G, xi=10.0)
    o.G = np.array(snow.G)
    a = np.array(snow.sheared)
    v = o.v + DT * (np.array(snow.given) + np.array(snow.pressed) + a)
    F = o.strained(o.F, v, o.v_b, DT)
    same(a, o.stress_divergence(o.stress(F)) / o.rho[:, None], 1e-9)
    explicit = o.stress_divergence(o.stress(o.F)) / o.rho[:, None]
    assert np.abs(a - explicit).max() > 0.05 * np.abs(explicit).max()  # and far from the explicit one


def test_short_steps_lead_to_the_explicit_acceleration():
    """Of a fixed state a(dt) -> div s(F) / rho: the difference falls with dt, at least as fast.

    With dt in place of dt squared in the operator it would stay.
    """
    snow, model = state(mu_c=0.0)
    o = Oracle(snow, G)
    o.G = np.array(snow.G)
    explicit = o.stress_divergence(o.stress(o.F)) / o.rho[:, None]
    left = []
    for dt in (4e-4, 2e-4, 1e-4, 5e-5):
        snow.find_given(model, dt)
        assert snow.solve_pressure(model, dt, 1e-11, 1.0, 5000).converged
        assert snow.solve_shear(dt, 1e-12, 500).converged
        left.append(np.abs(np.array(snow.sheared) - explicit).max())
    assert all(1.8 < a / b < 2.3 for a, b in pairwise(left)), left


def test_nothing_to_solve_is_solved():
    """At rest, unstrained and without gravity both right sides are zero: no iteration divides by them."""
    model = world()
    snow = block((4, 4, 4))
    prepare(snow, model)
    pressure, shear = solve(snow, model, DT)
    assert pressure.converged
    assert shear.converged
    assert shear.iterations == 0
    assert np.all(np.asarray(snow.sheared) == 0)
    assert np.abs(snow.pressed).max() < 1e-9


def test_single_precision_follows_double():
    """The same state in float32: accelerations agree to some 1e-3 of the largest."""
    results = []
    for core in (_core.f32, _core.f64):
        model = world(G, core=core)
        snow = block((5, 5, 5), jitter=0.3, core=core, low=(0.0, 0.0, 0.03))
        add_floor(snow, model)
        prepare(snow, model)
        reports = solve(snow, model, DT, tolerance=1e-5)
        assert all(report.converged for report in reports)
        order = np.argsort(np.asarray(snow.id))
        results.append([np.array(a)[order] for a in (snow.pressed, snow.sheared, snow.L)])
    for single, double in zip(*results, strict=True):
        same(single, double, 2e-3)
