"""Known answer 4: affine transfers conserve linear and angular momentum, forces or none."""

import numpy as np
import pytest
from reference.step import momentum
from verification.scenes import angular_momentum, ball, box, march, oracle, scene, simulate


def tumbling(precision, spline, **numerics):
    return scene(
        [
            box(center=(-0.13, 0.0, 0.02), velocity=(1.5, 0.2, 0.0), spin=(3.0, -5.0, 8.0)),
            ball(center=(0.13, 0.03, 0.0), radius=0.12, velocity=(-1.5, 0.0, 0.3), spin=(-9.0, 2.0, 1.0)),
        ],
        precision=precision,
        spline=spline,
        **numerics,
    )


AFFINE = [
    {"transfer": "apic"},
    {"transfer": "polypic", "polypic_modes": 8},
    {"transfer": "polypic", "polypic_modes": 27},
    {"transfer": "asflip", "flip_alpha": 0.0},
    {"transfer": "aflip", "aflip_damping": 0.5},
    {"transfer": "aflip", "aflip_damping": 0.0},
]
IDS = ["apic", "polypic8", "polypic27", "asflip", "aflip", "aflip0"]


@pytest.mark.parametrize("numerics", AFFINE, ids=IDS)
def test_momentum_stays(precision, spline, eps, numerics):
    """Two tumbling lumps collide and flow: sum m v and L = sum x cross m v + axial(m C D) stay.

    P2G and G2P conserve both exactly, a symmetric tau adds none, and x += dt v leaves x cross v. Modes beyond
    C carry none, being orthogonal to the linear ones. asflip goes without its share of FLIP, which brings
    back velocities whose C has changed. What is left is rounding: each of the n particles' momenta is rounded
    once a transfer with a random sign, so after N steps the sum wanders by eps sqrt(2 N n) |m v| for
    independent errors; a factor 10 covers the longer sums on the nodes. Float32's arithmetic may round with
    a bias, so the bound grows with N there: 100 eps a hundred steps.
    """
    sim = simulate(tumbling(precision, spline, **numerics))
    L = angular_momentum(sim)
    start = oracle(sim)[0]
    flux = (start.m * np.linalg.norm(start.v, axis=1)).sum()
    arm = np.linalg.norm(start.x, axis=1).max()
    steps = 100
    march(sim, steps)
    assert np.linalg.norm(momentum(oracle(sim)[0]) - momentum(start)) <= steps * eps * flux
    assert np.linalg.norm(angular_momentum(sim) - L) <= steps * eps * flux * arm
    assert np.asarray(sim.state.J_P).min() < 0.999  # it did flow


def test_asflip_keeps_a_rigid_spin(spline):
    """With its FLIP share asflip keeps L of a spinning ball: the share is v_p - sum w v_i^n, here zero.

    C holds grad v exactly, so the velocity on the grid is omega cross x at all nodes. The snow is soft, and
    one step of 1 us turns it by 1e-5: L stays to 1e-12.
    """
    spun = ball(radius=0.12, spin=(3.0, -9.0, 5.0))
    sim = simulate(scene([spun], spline=spline, transfer="asflip", dt=1e-6, snow={"E0": 1e-9}))
    L = angular_momentum(sim)
    np.testing.assert_allclose(angular_momentum(march(sim, 1)), L, rtol=0, atol=1e-12 * np.linalg.norm(L))
