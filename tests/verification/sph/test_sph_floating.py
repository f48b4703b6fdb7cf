"""Bodies and snow in water: Archimedes' draught, buoyancy, and what a body and the water give each other."""

import numpy as np
import pytest
from verification.sph.common import smoothed
from verification.sph.test_sph_water import FLOOR, G, basin, is_water, tank, water

SPACING = 0.04


@pytest.mark.parametrize(("rho", "start"), [(250.0, 0.1), (750.0, 0.1)])
def test_a_body_floats_as_deep_as_archimedes_says(rho, start):
    """The share of a raft under water is rho / rho_water, to half a particle spacing of depth.

    start [m]: how deep it is at the start, too little or too much. With V the volume of the water, A and a
    the areas of basin and raft, water to the depth d of the raft stands at (V + a d) / A over the floor.
    """
    side, height, depth, width = 0.4, 0.2, 0.28, 0.64
    raft = {"shape": "box", "size": [side, side, height], "density": rho, "mu_c": 0.0}
    raft["center"] = [0, 0, depth - start + height / 2]
    pool = water((0, 0, depth / 2), (width, width, depth), overlap="cut")
    sim = smoothed(
        [pool],
        tank(width, width),
        (0.0, 0.0, -G),
        bodies=[raft],
        dx=SPACING,
        precision="float32",
        dt_max=5e-3,
    )
    volume = float(np.asarray(sim.state.V0).sum())
    sim.advance(1.0)
    draughts = []
    for _ in range(8):
        sim.advance(0.1)
        pose = sim.solids()[-1][1]
        level = volume / width**2
        draughts.append((level - (pose.position[2] - height / 2)) / (1.0 - side**2 / width**2))
    assert pose.rotation[2, 2] > 0.98  # it lies flat
    assert np.mean(draughts) == pytest.approx(height * rho / 1000.0, abs=SPACING / 2)


def test_a_heavy_body_sinks():
    """A box of 3,000 kg/m3 falls slower than its weight would have it, and lies on the floor in the end.

    At most one layer of particles of water, which cannot be halved, stays below it.
    """
    box = {"shape": "box", "size": [0.16] * 3, "center": [0, 0, 0.24], "density": 3000.0}
    sim = smoothed(
        [water((0, 0, 0.2), (0.4, 0.4, 0.4), overlap="cut")],
        tank(0.4, 0.4),
        (0.0, 0.0, -G),
        bodies=[box],
        dx=SPACING,
        precision="float32",
        dt_max=5e-3,
    )
    sim.advance(0.12)
    fallen = 0.24 - sim.solids()[-1][1].position[2]
    assert 0.1 * 0.5 * G * 0.12**2 < fallen < (1 - 1 / 3) * 0.5 * G * 0.12**2
    sim.advance(0.6)
    assert 0.08 - SPACING / 2 < sim.solids()[-1][1].position[2] < 0.08 + SPACING


@pytest.mark.parametrize("ratio", [1e-2, 1.0, 10.0])
def test_bodies_and_water_exchange_momentum(ratio):
    """A ball of water hits a box, a hundredth to ten times as dense: momentum to rounding, energy never up.

    The box's velocity is an unknown of the solve for pressure: with an explicit impulse the light one would
    be thrown about. The water is stopped by the heavy one, and hardly by the light one.
    """
    ball = {"shape": "sphere", "radius": 0.15, "center": (-0.22, 0.01, 0), "velocity": (2, 0, 0)}
    box = {"shape": "box", "size": [0.2, 0.3, 0.3], "center": [0.05, 0, 0], "density": 1000.0 * ratio}
    sim = smoothed([ball | {"phase": "water"}], bodies=[box | {"mu_c": 0.0}], dx=SPACING, dt_max=5e-3)

    def momentum():
        now = sim.diagnostics()
        return np.add(now.momentum, now.bodies_momentum)

    def energy():
        now = sim.diagnostics()
        return now.kinetic + now.bodies_kinetic

    before, first = momentum(), energy()
    least = first
    for _ in range(10):
        sim.advance(0.01)
        assert energy() <= least * (1 + 1e-9)
        least = energy()
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-12 * np.linalg.norm(before))
    v = sim.solids()[-1][1].velocity[0]
    body, fluid = sim.diagnostics().bodies_momentum[0], sim.diagnostics().momentum[0]
    assert body > 0.0
    assert v > 1.5 if ratio < 0.1 else fluid < 0.7 * before[0]


def test_snow_under_water_floats_up():
    """It is pushed up by more than its weight, rises as fast as the water lets it, and comes out.

    Without the water that must make way it would rise with (rho_w / rho - 1) g; with that of a ball around
    it, half of the water that it displaces, with (rho_w - rho) g / (rho + rho_w / 2): so as far from the
    floor as from the sides, since close to it more water has to come in from beside it.
    """
    rho, side, depth, width, time = 300.0, 0.2, 0.6, 0.5, 0.1
    sim = basin(
        [
            {"shape": "box", "center": (0, 0, 0.25), "size": (side, side, side)},
            water((0, 0, depth / 2), (width, width, depth), overlap="cut"),
        ],
        width,
        {"rho0": rho, "E0": 2e5, "plasticity": "none"},
        sampling="regular",
        precision="float32",
    )

    def height():
        return float(np.asarray(sim.state.x)[~is_water(sim), 2].mean())

    start = height()
    sim.advance(time)
    risen = height() - start
    weight = 0.5 * G * time**2
    assert 0.5 * (1000 - rho) / (rho + 500) * weight < risen < (1000 / rho - 1) * weight
    sim.advance(1.2)
    assert (
        np.asarray(sim.state.x)[~is_water(sim), 2].max()
        > np.asarray(sim.state.x)[is_water(sim), 2].mean() + 0.2
    )


def test_a_raft_gives_the_same_bits():
    """On one thread and on two, and after a resume."""

    def afloat(threads):
        raft = {"shape": "box", "size": [0.16, 0.16, 0.08], "center": [0.02, 0, 0.2], "density": 400.0}
        ball = {"shape": "sphere", "radius": 0.06, "center": (0, 0, 0.32), "velocity": (0, 0, -2)}
        return smoothed(
            [water((0, 0, 0.1), (0.32, 0.32, 0.2), overlap="cut"), ball],
            [*tank(0.32, 0.32)[:-1], FLOOR],
            (0.0, 0.0, -G),
            threads=threads,
            bodies=[raft],
            dx=SPACING,
            precision="float32",
            dt_max=5e-3,
        )

    one, two, half = afloat(1), afloat(2), afloat(1)
    for sim in (one, two):
        sim.advance(0.04)
        sim.advance(0.04)
    half.advance(0.04)
    again = type(half).restore(half.scene, half.arrays(), threads=2)
    again.advance(0.04)
    for other in (two, again):
        theirs = other.arrays()
        for name, values in one.arrays().items():
            np.testing.assert_array_equal(np.asarray(values), np.asarray(theirs[name]), err_msg=name)
