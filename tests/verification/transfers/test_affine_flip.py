"""Affine FLIP: its ends, a rate of decay that no step changes, and energy that only forces can bring."""

import numpy as np
import pytest
from reference import splines
from verification.scenes import ELASTIC, ball, damping, march, scene, simulate, wave, wide
from verification.stages import Lab

DX = 0.05
SOFT = {**ELASTIC, "E0": 100.0}
SNOW = scene([ball()], snow=SOFT).snow


def values(n=400, seed=21, strain=0.0):
    """Particles with random velocities, affine velocities and strains."""
    rng = np.random.default_rng(seed)
    return {
        "x": rng.uniform(-0.15, 0.15, (n, 3)),
        "v": rng.standard_normal((n, 3)),
        "C": rng.standard_normal((n, 3, 3)) / DX,
        "F_E": np.eye(3) + strain * rng.standard_normal((n, 3, 3)),
        "m": rng.uniform(0.01, 0.03, n),
        "V0": np.full(n, 5e-5),
    }


def ends(core, precision, spline, transfer, alpha, steps=1, dt=1e-4, **more):
    """Return the particles after some steps with the share alpha."""
    lab = Lab(core, precision, spline, transfer, dx=DX, alpha=alpha, **{**values(), **more})
    for _ in range(steps):
        lab.step(dt)
    return lab.columns()


def test_without_damping_nothing_changes(core, precision, spline):
    """alpha = 1 without forces: v and C are the same to the bit, their changes being exactly zero."""
    before = Lab(core, precision, spline, "aflip", dx=DX, **values()).columns()
    after = ends(core, precision, spline, "aflip", 1.0)
    np.testing.assert_array_equal(after["v"], before["v"])
    np.testing.assert_array_equal(after["C"], before["C"])


def test_full_damping_is_apic(core, precision, eps, spline):
    """alpha = 0: all is taken anew, as by APIC, strained snow included.

    The same bits as asflip without its share, which has force and momentum apart as well; apic adds them
    before they reach the grid, 100 roundings of the largest velocity beside it.
    """
    strained = values(strain=0.004)
    found = ends(core, precision, spline, "aflip", 0.0, 5, **strained)
    for name, value in ends(core, precision, spline, "asflip", 0.0, 5, **strained).items():
        np.testing.assert_array_equal(found[name], value, err_msg=name)
    apic = ends(core, precision, spline, "apic", 0.0, 5, **strained)
    np.testing.assert_allclose(found["v"], apic["v"], rtol=0, atol=100 * eps * np.abs(apic["v"]).max())
    np.testing.assert_allclose(found["C"], apic["C"], rtol=0, atol=100 * eps * np.abs(apic["C"]).max())


def test_blend_is_linear(core, precision, eps, spline):
    """One step with alpha is (1 - alpha) APIC + alpha (v, C) to a few roundings: |v| <= 5, |C| <= 5 / dx."""
    before = Lab(core, precision, spline, "aflip", dx=DX, **values()).columns()
    taken, kept = ends(core, precision, spline, "aflip", 0.0), ends(core, precision, spline, "aflip", 0.7)
    for name, size in (("v", 5.0), ("C", 5.0 / DX)):
        expected = 0.3 * taken[name] + 0.7 * before[name]
        np.testing.assert_allclose(kept[name], expected, rtol=0, atol=20 * eps * size)


@pytest.mark.parametrize("alpha", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("transfer", ["flip", "aflip", "asflip"])
def test_particles_gain_no_more_than_the_grid(core, precision, eps, spline, transfer, alpha):
    """The energy of v and C grows by no more than 1/2 sum m_i (|v_i|^2 - |v_i^n|^2), forces and all.

    Under <q, q> = sum m (|v|^2 + D |C|^2) the way to the grid is the adjoint P* of the way back P, and
    |P v| <= |v|: |q + P dv|^2 = |q|^2 + 2 <P* q, dv> + |P dv|^2 <= |q|^2 + |v + dv|^2 - |v|^2. The other end,
    P (v + dv), has |v + dv|^2 at most, and |v| <= |q|; between the two the norm is convex. Forces of strained
    snow over 2 ms move the grid by as much as it moves.
    """
    dt = 2e-3
    lab = Lab(core, precision, spline, transfer, dx=DX, alpha=alpha, **values(strain=0.02))
    before = lab.core.totals(lab.model, lab.state)
    lab.p2g(dt)
    _, m, momentum = (np.asarray(a, float) for a in lab.grid.nodes())
    lab.grid_update(dt)
    v = np.asarray(lab.grid.nodes()[2], float)
    start = (momentum**2).sum(1) / np.where(m > 0, m, 1)
    given = 0.5 * (m @ (v**2).sum(1) - start.sum())
    lab.g2p(dt)
    after = lab.core.totals(lab.model, lab.state)
    gained = after.kinetic + after.affine - before.kinetic - before.affine
    energy = before.kinetic + before.affine + 0.5 * m @ (v**2).sum(1)
    assert given > 0.02 * before.kinetic  # the forces do count
    assert gained <= given + 100 * eps * energy


@pytest.mark.parametrize("alpha", [0.5, 0.99, 1.0])
def test_asflip_takes_no_affine_velocity_for_nothing(core, precision, eps, spline, alpha):
    """C = 0 and random v, without forces: energy falls in every step, to rounding.

    v keeps what C would hold too: with C' as APIC has it alpha = 1 gains 1 % or more within six steps.
    """
    still = values() | {"C": np.zeros((400, 3, 3))}
    lab = Lab(core, precision, spline, "asflip", dx=DX, alpha=alpha, **still)
    energies = []
    for _ in range(6):
        t = lab.core.totals(lab.model, lab.state)
        energies.append(t.kinetic + t.affine)
        lab.step(0.0)
    assert (np.diff(energies) <= 100 * eps * energies[0]).all()


def test_asflip_leaves_a_rigid_motion_alone(core, precision, eps, spline):
    """v = omega cross x and C = W: the same after twenty steps, however much of FLIP."""
    W = np.array([[0, -3.0, 1.0], [3.0, 0, -2.0], [-1.0, 2.0, 0]])
    start = values()
    turning = start | {"v": start["x"] @ W.T, "C": np.tile(W, (400, 1, 1))}
    after = ends(core, precision, spline, "asflip", 0.95, 20, dt=0.0, **turning)
    np.testing.assert_allclose(after["C"], turning["C"], rtol=0, atol=2000 * eps / DX)
    np.testing.assert_allclose(after["v"], turning["v"], rtol=0, atol=2000 * eps)


def share(spline, k, offsets):
    """Return how much of a wave exp(i k x) of the grid is left after one way to the particles and back.

    `offsets`: the places of the particles in a cell [cells]; k: radians per cell. On the way to the grid and
    back a node's amplitude is multiplied by the mean over the particles of |sum w e|^2 + |sum w z e|^2 / D
    with e = exp(i k (x_i - x_p)), z = x_i - x_p in cells and D = sum w z^2.
    """
    x = np.array([[o, 0.0, 0.0] for o in offsets])
    ijk, w, _ = splines.stencil(spline, x, 1.0)
    z = (ijk - x[:, None, :])[..., 0]
    e = np.exp(1j * k * z)
    linear = np.abs((w * z * e).sum(1)) ** 2 / splines.MOMENT[spline]
    return float(np.mean(np.abs((w * e).sum(1)) ** 2 + linear))


def faded(cells, steps, dt, spline, **numerics):
    """Return what is left of a shear wave of so many cells, in a rod that is too soft to answer.

    Measured in the middle third of a rod of 12 waves, out of reach of its ends.
    """
    length, k = 12 * cells * DX, 2 * np.pi / (cells * DX)
    rod = {"shape": "box", "center": [0, 0, 0], "size": [length, 2 * DX, 2 * DX]}
    how = {"sampling": "regular", "initial_volume": "sampled", "dx": DX, "dt": dt, "spline": spline}
    sim = simulate(scene([rod], snow=SOFT, **how, **numerics))
    x = np.array(sim.state.x)
    ijk, w, _ = splines.stencil(spline, x, DX)
    moved = 1e-3 * w * np.cos(k * DX * ijk[..., 0])  # as if it came from the grid
    sim.state.v[:, 2] = moved.sum(1)
    arm = DX * ijk[..., 0] - x[:, :1]
    sim.state.C[:, 2, 0] = (moved * arm).sum(1) / (splines.MOMENT[spline] * DX**2)
    start = wide(sim)
    march(sim, steps)
    middle = np.abs(start["x"][:, 0]) < length / 6
    v, end = start["v"][middle, 2], wide(sim)["v"][middle, 2]
    return float(v @ end / (v @ v))


@pytest.mark.parametrize("cells", [3, 4, 8])
def test_apic_fades_by_the_step_and_aflip_by_the_second(spline, cells):
    """A shear wave keeps the share s in a step of APIC, however short: s^n after n of them.

    A step of aflip leaves alpha + (1 - alpha) s with alpha = exp(-r dt), r = aflip_damping c / dx: in short
    steps exp(-r t (1 - s)), from which each is r dt s / 2 <= 5 % of the exponent away. Here r t = 1 while a
    wave crosses 1e-3 of a cell, so that stress changes v by (k c t)^2 / 2 < 3e-6.
    """
    s = share(spline, 2 * np.pi / cells, (-0.25, 0.25))
    r = 1000 * wave(SNOW) / DX
    for steps in (2, 5):
        assert faded(cells, steps, 1e-6, spline, transfer="apic") == pytest.approx(s**steps, abs=1e-5)
    for steps in (10, 40):
        dt = 1 / (r * steps)
        left = faded(cells, steps, dt, spline, transfer="aflip", aflip_damping=1000)
        alpha = np.exp(-r * dt)
        assert left == pytest.approx((alpha + (1 - alpha) * s) ** steps, abs=1e-5)
        assert np.log(left) == pytest.approx(s - 1, rel=0.05)


def test_the_fastest_snow_sets_the_rate():
    """r = aflip_damping max c / dx over the snows of a scene, c = sqrt((lam + 2 mu) / rho0) unhardened.

    A velocity that no node sees fades as exp(-r t) in free flight: two particles in one place, of opposite
    velocities, in a step that moves them by 1e-9 of a cell.
    """
    soft, stiff = {"E0": 1e3}, {"E0": 1e6, "rho0": 250.0}
    sources = [ball((-1, 0, 0), 0.05, snow=soft), ball((1, 0, 0), 0.05, snow=stiff)]
    sim = simulate(scene(sources, transfer="aflip", aflip_damping=2.0, dt=1e-9, initial_volume="sampled"))
    sim.state.x[1] = sim.state.x[0]
    sim.state.m[1] = sim.state.m[0]
    sim.state.v[:2, 0] = [1.0, -1.0]
    start = wide(sim)["v"]
    assert np.abs(start).sum() == 2
    march(sim, 5)
    r = 2.0 * np.sqrt(1e6 * 0.8 / (1.2 * 0.6) / 250.0) / DX
    assert damping(sim) == pytest.approx(r, rel=1e-12)
    np.testing.assert_allclose(wide(sim)["v"], np.exp(-5e-9 * r) * start, rtol=0, atol=1e-9)
