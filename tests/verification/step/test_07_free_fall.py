"""Known answer 7: snow falls together, as symplectic Euler says."""

import numpy as np
import pytest
from verification.scenes import box, march, scene, simulate, wide

G, DT, N = 9.81, 5e-4, 200


def test_free_fall(spline, transfer, precision, eps):
    """v = v0 - g n dt and z = z0 + v0 n dt - g dt^2 n (n + 1) / 2 for every particle; F_E stays I.

    All weights sum to one within 5 eps and a rounding of |v| eps follows at each of n steps in P2G and G2P:
    n (5 + 2) eps |v|, |v| <= 2 m/s here; positions sum n of them with dt, plus eps |x| / 2 a step. Velocity
    differences between neighbours, at most that error over dx, strain them: n dt (7 n eps |v| / dx), which
    strains F by 2e-9 in float64 after 200 steps and presses back with less than 1e-3 Pa.
    """
    sim = simulate(
        scene(
            [box(center=(0.3, -0.2, 0.6), velocity=(0.3, -0.2, 0.5))],
            gravity=(0.0, 0.0, -G),
            dt=DT,
            precision=precision,
            spline=spline,
            transfer=transfer,
        )
    )
    start = wide(sim)
    march(sim, N)
    end = wide(sim)
    speed, v_error = 2.0, 7 * N * eps * 2.0
    fall_v, fall_x = np.array([0, 0, -G * N * DT]), np.array([0, 0, -G * DT**2 * N * (N + 1) / 2])
    np.testing.assert_allclose(end["v"], start["v"] + fall_v, atol=v_error, rtol=0)
    x_error = N * DT * v_error + N * eps * speed
    np.testing.assert_allclose(end["x"], start["x"] + N * DT * start["v"] + fall_x, atol=x_error, rtol=0)
    np.testing.assert_allclose(end["F_E"] - np.eye(3), 0, atol=N * DT * v_error / 0.05)
    np.testing.assert_array_equal(end["m"], start["m"])


@pytest.mark.parametrize("cells", [0.9, 4.5])
def test_flight_of_cells_a_step(spline, transfer, precision, eps, cells):
    """Without forces x = x0 + t v even where each step finds new blocks.

    At 0.9 cells a step Neve takes them; where the scene asks for 4.5 cells a step it takes shorter ones.
    Velocity errors are those of free fall, 7 n eps |v|; |x| reaches 5 m, eps |x| / 2 a step.
    """
    v = np.array([180.0, -120.0, 60.0])
    speed = np.linalg.norm(v)
    dt, time = cells * 0.05 / speed, 0.02
    description = scene(
        [box(velocity=tuple(v))], dt=dt, precision=precision, spline=spline, transfer=transfer,
        snow={"E0": 1e-9},
    )  # fmt: skip
    sim = simulate(description)
    start = wide(sim)
    sim.advance(time)
    end, n = wide(sim), sim.steps
    assert (sim.stats.rejected > 0) == (cells > 1)
    error = time * 7 * n * eps * speed + n * eps * 5
    np.testing.assert_allclose(end["x"], start["x"] + time * v, rtol=0, atol=error)
