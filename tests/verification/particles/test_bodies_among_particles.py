"""Particles and the bodies that they move: momentum of both, energy, weight, bits."""

import numpy as np
import pytest

from neve.scene.reading.load import scene_from
from neve.simulation import Simulation

G = 9.81
HEAP = {"shape": "box", "size": [0.6, 0.6, 0.3], "center": [0.0, 0.0, 0.15]}
GROUND = {"shape": "plane"}
BALL = {"shape": "sphere", "radius": 0.15, "center": [0.5, 0, 0.1], "velocity": [-4, 0, 0]}
BOX = {"shape": "box", "size": [0.2] * 3, "center": [-0.45, 0, 0.1], "velocity": [1, 0, 0], "spin": [1, 2, 3]}


def simulate(bodies, gravity=-G, colliders=(GROUND,), threads=1, **numerics):
    """Bodies around coarse snow of 400 kg/m3."""
    described = scene_from(
        {
            "world": {"gravity": [0, 0, gravity]},
            "numerics": {"method": "particles", "dx": 0.1, "precision": "float64"} | numerics,
            "sources": [HEAP],
            "colliders": list(colliders),
            "bodies": list(bodies),
        }
    )
    return Simulation(described, threads=threads)


def rigid(sim):
    return sim.solver.placed.rigid


def total(sim):
    """Momentum, and angular momentum about the origin, of snow and bodies together."""
    m, x, v = (np.asarray(a) for a in (sim.state.m, sim.state.x, sim.state.v))
    now = sim.diagnostics()
    linear = np.add(now.momentum, now.bodies_momentum)
    return linear, np.cross(x, m[:, None] * v).sum(axis=0) + rigid(sim).angular_momentum


@pytest.mark.parametrize("mode", ["separate", "sticky", "slip"])
@pytest.mark.parametrize("density", [20.0, 8000.0])
def test_momentum(density, mode):
    """What the snow gains the bodies lose, whatever their mass: a ball hits it, and a box that turns.

    A step adds rounding of some eps of all momenta at hand; double precision, a hundred steps: 1e-13.
    """
    sim = simulate([BALL | {"density": density, "mode": mode}, BOX | {"mode": mode}], 0.0, ())
    before, speed = total(sim)[0], rigid(sim).poses()[0].velocity[0]
    sim.advance(0.06)
    assert abs(rigid(sim).poses()[0].velocity[0] - speed) > 0.05
    scale = sum(rigid(sim).mass * 4.0) + sim.diagnostics().mass * 4.0
    np.testing.assert_allclose(total(sim)[0], before, rtol=0, atol=1e-13 * scale)


def test_energy_only_falls():
    """Snow and a light body that hits it: contact without restitution takes energy, and gives none back."""
    sim = simulate([BALL | {"density": 20.0}], 0.0, ())

    def energy():
        d = sim.diagnostics()
        return d.kinetic + d.elastic + d.bodies_kinetic

    start = lowest = energy()
    for _ in range(30):
        sim.advance(2e-3)
        assert energy() <= lowest + 2e-3 * start
        lowest = min(lowest, energy())
    assert lowest < 0.7 * start


@pytest.mark.parametrize("density", [20.0, 400.0])
def test_weight_is_carried(density):
    """A box comes to rest on snow, which then bears m g; the impulses account for its velocity exactly."""
    box = {"shape": "box", "size": [0.4, 0.4, 0.2], "center": [0, 0, 0.41], "density": density}
    sim = simulate([box], precision="float32")
    sim.advance(0.6)
    before = rigid(sim).poses()[0].velocity
    sim.advance(0.1)
    pose, mass = rigid(sim).poses()[0], density * 0.4 * 0.4 * 0.2
    force = sim.stats.exchanged[1, :3] / 0.1
    np.testing.assert_allclose(
        force, mass * ((pose.velocity - before) / 0.1 + [0, 0, G]), rtol=0, atol=1e-4 * mass * G
    )
    assert force[2] == pytest.approx(mass * G, rel=0.05)
    assert 0.3 < pose.position[2] < 0.42


def test_same_bits():
    """A wheel at a joint and a ball in snow: threads and a resume change no bit."""
    wheel = {
        "shape": "cylinder", "radius": 0.15, "height": 0.2, "rotation": [90, 0, 0], "center": [0, 0, 0.46],
        "joint": "hinge", "axis": [0, 1, 0], "motor": {"target": 10.0}, "parent": 0,
    }  # fmt: skip
    carrier = {"shape": "box", "size": [0.1] * 3, "center": [0, 0, 0.9], "joint": "slide", "mass": 5.0}
    ball = {"shape": "sphere", "radius": 0.15, "center": [0.2, 0.4, 0.4], "velocity": [0, 0, -3]}
    sims = [simulate([carrier, wheel, ball], precision="float32", threads=t) for t in (1, 2, 1)]
    for sim in sims:
        sim.advance(0.04)
    sims[2] = Simulation.restore(sims[2].scene, sims[2].arrays(), threads=3)
    for sim in sims:
        sim.advance(0.04)
    arrays = [sim.arrays() for sim in sims]
    for name, value in arrays[0].items():
        for other in arrays[1:]:
            np.testing.assert_array_equal(value, other[name], err_msg=name)
    assert np.abs(sims[0].exchanged[2:]).max(axis=1).min() > 0


def test_bodies_go_on_in_a_changed_scene():
    """A change of a collider leaves a falling body where it is; a body that begins elsewhere is put there."""
    sim = simulate([BALL, BOX], 0.0, [GROUND | {"point": [0, 0, -1]}])
    sim.advance(0.02)
    place = rigid(sim).poses()[0].position
    moved = sim.scene.bodies[1].model_copy(update={"center": (-1.0, 0.0, 0.5)})
    sim.change(sim.scene.model_copy(update={"colliders": (), "bodies": (sim.scene.bodies[0], moved)}))
    np.testing.assert_allclose(rigid(sim).poses()[0].position, place, atol=1e-12)
    np.testing.assert_allclose(rigid(sim).poses()[1].position, (-1.0, 0.0, 0.5), atol=1e-12)
