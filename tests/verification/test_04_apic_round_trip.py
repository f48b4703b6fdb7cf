"""Known answer 4: the affine transfer conserves linear and angular momentum, forces or none."""

import numpy as np
import pytest
from reference.step import momentum
from verification.scenes import angular_momentum, ball, box, march, oracle, scene, simulate


def tumbling(precision, spline, snow=None):
    return scene(
        [
            box(center=(-0.13, 0.0, 0.02), velocity=(1.5, 0.2, 0.0), spin=(3.0, -5.0, 8.0)),
            ball(center=(0.13, 0.03, 0.0), radius=0.12, velocity=(-1.5, 0.0, 0.3), spin=(-9.0, 2.0, 1.0)),
        ],
        precision=precision,
        spline=spline,
        transfer="apic",
        snow=snow,
    )


@pytest.mark.parametrize("steps", [100])
def test_apic_conserves_momentum(precision, spline, eps, steps):
    """Two tumbling lumps collide and flow: sum m v and L = sum x cross m v + axial(m C D) stay.

    P2G and G2P conserve both exactly, a symmetric tau adds none, and x += dt v leaves x cross v. What is
    left is rounding: each of the n particles' momenta is rounded once a transfer with a random sign, so
    after N steps the sum wanders by eps sqrt(2 N n) |m v| for independent errors; a factor 10 covers the
    longer sums on the nodes. Float32's arithmetic may round with a bias, so the bound grows with N there:
    100 eps a hundred steps.
    """
    sim = simulate(tumbling(precision, spline))
    L = angular_momentum(sim)
    start = oracle(sim)[0]
    flux = (start.m * np.linalg.norm(start.v, axis=1)).sum()
    arm = np.linalg.norm(start.x, axis=1).max()
    march(sim, steps)
    assert np.linalg.norm(momentum(oracle(sim)[0]) - momentum(start)) <= steps * eps * flux
    assert np.linalg.norm(angular_momentum(sim) - L) <= steps * eps * flux * arm
    assert np.asarray(sim.state.J_P).min() < 0.999  # it did flow
