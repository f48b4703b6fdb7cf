"""Known answer 3: what the particles bring to the grid is on the grid, and what the grid has comes back."""

import numpy as np
from verification.stages import Lab


def cloud(n=3000, seed=3):
    rng = np.random.default_rng(seed)
    return {
        "x": rng.uniform(-0.6, 0.6, (n, 3)),
        "v": rng.standard_normal((n, 3)),
        "m": rng.uniform(0.01, 0.03, n),
        "V0": np.full(n, 1e-5),
    }


def test_p2g_conserves(core, precision, eps, spline, transfer):
    """Sum m_i = sum m_p; sum (m v)_i = sum m v, with C = 0 and with a random C.

    The weights sum to 1 within 5 eps, and C (x_i - x_p) to zero within 5 eps |C| dx. A node adds the shares
    of k ~ 100 particles with k eps/2 at the worst, sqrt(k) eps in truth; the total over the nodes is taken
    in float64.
    """
    values = cloud()
    values["C"] = 3 * np.random.default_rng(4).standard_normal((len(values["m"]), 3, 3))
    lab = Lab(core, precision, spline, transfer, **values)
    lab.p2g(dt=1e-4)
    _, mass, momentum = lab.grid.nodes()
    m, v = np.asarray(lab.state.m, float), np.asarray(lab.state.v, float)
    tolerance = 15 * eps
    assert abs(mass.astype(float).sum() - m.sum()) <= tolerance * m.sum()
    flux = (m * np.linalg.norm(v, axis=1)).sum()
    assert np.linalg.norm(momentum.astype(float).sum(0) - m @ v) <= tolerance * flux


def test_internal_forces_are_balanced(core, precision, eps, spline, transfer):
    """Strained snow: sum f_i = -sum V0 tau sum grad w = 0, so a step without gravity leaves sum m v.

    dt V0 |tau| / dx per particle is the momentum that is moved about; its sum cancels to 20 eps of it.
    """
    values = cloud()
    n = len(values["m"])
    values["F_E"] = np.eye(3) + 0.004 * np.random.default_rng(5).standard_normal((n, 3, 3))
    lab = Lab(core, precision, spline, transfer, **values)
    dt = 1e-4
    lab.p2g(dt)
    lab.grid_update(dt)
    _, mass, v_i = (np.asarray(a, float) for a in lab.grid.nodes())
    m, v = np.asarray(lab.state.m, float), np.asarray(lab.state.v, float)
    tau = np.abs(np.asarray(lab.state.tau, float)).max(-1)
    moved = (m * np.linalg.norm(v, axis=1)).sum() + dt * (values["V0"] * tau).sum() / 0.05
    assert np.linalg.norm(mass @ v_i - m @ v) <= 30 * eps * moved


def test_round_trip_keeps_momentum(core, precision, eps, spline, transfer):
    """P2G, grid, G2P: sum m v again, PIC part and FLIP change alike; no forces, no gravity."""
    lab = Lab(core, precision, spline, transfer, **cloud())
    m, v = np.asarray(lab.state.m, float), np.asarray(lab.state.v, float)
    before, flux = m @ v, (m * np.linalg.norm(v, axis=1)).sum()
    lab.step(1e-6)
    m, v = np.asarray(lab.state.m, float), np.asarray(lab.state.v, float)
    assert np.linalg.norm(m @ v - before) <= 30 * eps * flux


def test_a_thin_sheet_keeps_its_mass(core, precision, eps, spline):
    """A sheet 0.12 cells thick, whose nodes hold little mass, is no worse.

    The sums have no absolute floor.
    """
    values = cloud(2000)
    values["x"][:, 2] = np.random.default_rng(9).uniform(0, 0.12 * 0.05, 2000)
    values["m"] = values["m"] * 1e-9
    lab = Lab(core, precision, spline, "apic", **values)
    lab.p2g(1e-4)
    _, mass, _ = lab.grid.nodes()
    m = np.asarray(lab.state.m, float)
    assert abs(mass.astype(float).sum() - m.sum()) <= 15 * eps * m.sum()
