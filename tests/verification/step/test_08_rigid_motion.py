"""Known answer 8: a body without stress that moves rigidly stays without stress."""

import numpy as np
import pytest
from verification.scenes import ELASTIC, ball, march, scene, simulate, wide


def test_translation(spline, transfer, precision, eps):
    """A constant velocity has no gradient, so F_E = I: weights' gradients sum to 20 eps / dx and |v| = 3 m/s.

    The velocity itself moves by 7 eps |v| a step, as in free fall; over n = 50 steps of dt = 4e-4 s the
    strain is at most n dt (20 + 7 n) eps |v| / dx.
    """
    n, dt = 50, 4e-4
    description = scene(
        [ball(velocity=(2.0, -2.0, 1.0))], dt=dt, spline=spline, transfer=transfer, precision=precision
    )
    end = wide(march(simulate(description), n))
    bound = n * dt * (20 + 7 * n) * eps * 3 / 0.05
    np.testing.assert_allclose(end["F_E"] - np.eye(3), 0, atol=bound)
    np.testing.assert_allclose(end["J_P"], 1, atol=bound)


@pytest.mark.parametrize("transfer", ["apic", "polypic", "asflip"])
def test_rotation(spline, precision, eps, transfer):
    """A body that is made to turn, v = omega cross x and C = W before each step, has F_E = (I + dt W)^n.

    Affine transfers carry an affine field, so v_i = omega cross x_i at all nodes, those of the surface
    included, and every particle sees grad v = W. Each step strains F^T F by (I + dt W)^T (I + dt W) - I =
    dt^2 W^T W, in all at most n dt^2 omega^2 to first order. Rounding: W to 40 eps |v| / dx a step, with
    |v| < 2 m/s. The snow is soft (1 nPa), or it would push back: left alone, a turning body without stress
    flies apart.
    """
    n, dt, omega = 50, 1e-3, np.array([3.0, -4.0, 5.0])
    W = np.array([[0, -omega[2], omega[1]], [omega[2], 0, -omega[0]], [-omega[1], omega[0], 0]])
    soft = ELASTIC | {"E0": 1e-9}
    sim = simulate(scene([ball()], dt=dt, spline=spline, transfer=transfer, precision=precision, snow=soft))
    for _ in range(n):
        sim.state.v[:] = np.cross(omega, np.asarray(sim.state.x, float)).astype(precision)
        sim.state.C[:] = W.astype(precision)
        march(sim, 1)
    F = wide(sim)["F_E"]
    rounding = n * (dt * 40 * eps * 2 / 0.05 + 4 * eps)
    np.testing.assert_allclose(F - np.linalg.matrix_power(np.eye(3) + dt * W, n), 0, atol=rounding)
    strain = np.swapaxes(F, 1, 2) @ F - np.eye(3)
    bound = (1 + dt**2 * (omega @ omega)) ** n - 1  # n dt^2 omega^2 and its higher powers
    assert np.linalg.norm(strain, 2, axis=(1, 2)).max() <= bound + 4 * rounding
