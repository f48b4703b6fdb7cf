"""Each particle has its own snow.

Material table and stiffness factor act, and only on their own particles.
"""

import numpy as np
import pytest
from verification.scenes import ball, columns, march, scene, simulate, wide

import neve

FLOOR = [{"shape": "plane", "point": (0, 0, -0.11), "normal": (0, 0, 1)}]
APART = 2.0  # [m]; ten blocks of 0.2 m, so that no node is shared
CHANGES = {"E0": 4e4, "nu": 0.35, "xi": 3.0, "theta_c": 0.01, "theta_s": 0.002, "rho0": 250.0}


def drop(*snows, precision="float64", **numerics):
    lumps = [
        ball(center=(APART * k, 0, 0), radius=0.11, velocity=(0, 0, -5), snow=snow)
        for k, snow in enumerate(snows)
    ]
    return scene(lumps, FLOOR, precision=precision, dt=1e-4, **numerics)


def of_source(sim, k, names=("x", "v", "F_E", "J_P")):
    """The particles of the k-th lump, in the order of their id, in the lump's own frame."""
    c = wide(sim)
    mine = np.abs(c["x"][:, 0] - APART * k) < APART / 2
    out = {name: c[name][mine] for name in names}
    out["x"] = out["x"] - [APART * k, 0, 0]
    return out


@pytest.mark.parametrize("key", list(CHANGES))
def test_every_parameter_acts(key):
    """One parameter changed on one of two lumps: the other does what it does alone, and this one differs.

    The lumps share no node, so the first is the same to rounding of float64 (100 steps: 1e-11); a parameter
    that did not reach its particles would leave the lumps equal.
    """
    plain = march(simulate(drop({})), 100)
    pair = march(simulate(drop({}, {key: CHANGES[key]})), 100)
    alone = march(simulate(drop({key: CHANGES[key]})), 100)
    a, b = of_source(plain, 0), of_source(pair, 0)
    np.testing.assert_allclose(b["v"], a["v"], rtol=0, atol=1e-11)
    assert np.abs(of_source(alone, 0)["v"] - a["v"]).max() > 1e-3


def test_table_rows_reach_their_particles():
    """A table of two snows equals two runs of one each, with the same particles: 1e-10 after 100 steps.

    The second lump's arrays are moved into a scene that knows its snow alone.
    """
    other = {"E0": 4e4, "xi": 3.0, "theta_c": 0.01}
    pair = simulate(drop({}, other))
    arrays = pair.arrays()
    mine = arrays["material"] == 1
    assert mine.any()
    assert not mine.all()
    only = {
        name: value[mine] if len(np.atleast_1d(value)) == len(mine) else value
        for name, value in arrays.items()
    }
    only["material"] = np.zeros_like(only["material"])
    only["births"] = np.zeros((1, 2), dtype=np.int64)
    single = march(neve.Simulation.restore(drop(other), only, threads=1), 100)
    a, b = of_source(march(pair, 100), 1), of_source(single, 1)
    for name, value in a.items():
        np.testing.assert_allclose(b[name], value, rtol=0, atol=1e-10, err_msg=name)


def test_stiffness_factor_multiplies_E0():
    """stiffness = 3 with E0 is E0 x 3 with stiffness 1.

    1e-11 after 100 steps (mu0, lam0 differ by rounding).
    """
    description, stiff = drop({"E0": 5e4}), drop({"E0": 15e4})
    sim = simulate(description)
    sim.state.stiffness[:] = 3.0
    a, b = wide(march(sim, 100)), wide(march(simulate(stiff), 100))
    np.testing.assert_allclose(a["v"], b["v"], rtol=0, atol=1e-11)
    soft = wide(march(simulate(description), 100))
    assert np.abs(a["v"] - soft["v"]).max() > 1e-2


def test_mass_follows_density(precision):
    """m = rho0 V per source; the two lumps have the same volume to the sampling's share."""
    c = columns(simulate(drop({"rho0": 100.0}, {"rho0": 400.0}, precision=precision)))
    np.testing.assert_allclose(c["m"] / c["V0"], np.where(c["material"] == 0, 100.0, 400.0), rtol=1e-6)
