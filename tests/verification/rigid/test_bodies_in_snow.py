"""Bodies of the engine in snow: momentum of both, weight carried, light and heavy, joints, resumes."""

import numpy as np
import pytest

from neve.scene.reading.load import scene_from
from neve.simulation import Simulation
from neve.solver import Blowup

G = 9.81
HEAP = {"shape": "box", "size": [0.6, 0.6, 0.3], "center": [0.0, 0.0, 0.15]}


def scene(bodies, gravity=(0.0, 0.0, -G), sources=(HEAP,), colliders=({"shape": "plane"},), **numerics):
    """Bodies around coarse snow of 400 kg/m3."""
    return scene_from(
        {
            "world": {"gravity": list(gravity)},
            "numerics": {"dx": 0.1, **numerics},
            "sources": list(sources),
            "colliders": list(colliders),
            "bodies": list(bodies),
        }
    )


def total(sim):
    """Momentum of snow and bodies together [kg m/s]."""
    now = sim.diagnostics()
    return np.add(now.momentum, now.bodies_momentum)


@pytest.mark.parametrize("density", [20.0, 8000.0])
def test_momentum_of_snow_and_bodies_is_kept(density):
    """Without gravity snow and bodies exchange momentum and lose none: a body hits the snow and another body.

    A step adds rounding of some eps of all momenta at hand; double precision, a hundred steps: 1e-12.
    """
    ball = {
        "shape": "sphere",
        "radius": 0.15,
        "center": [0.5, 0, 0.1],
        "velocity": [-4, 0, 0],
        "density": density,
    }
    box = {
        "shape": "box",
        "size": [0.2] * 3,
        "center": [-0.45, 0, 0.1],
        "velocity": [1, 0, 0],
        "spin": [1, 2, 3],
    }
    sim = Simulation(scene([ball, box], [0, 0, 0], colliders=(), precision="float64"), threads=1)
    before, ball_before = total(sim), sim.solver.model.rigid.poses()[0].velocity[0]
    sim.advance(0.06)
    assert abs(sim.solver.model.rigid.poses()[0].velocity[0] - ball_before) > 0.05  # they met
    scale = sum(sim.solver.model.rigid.mass * 4.0) + sim.diagnostics().mass * 4.0
    assert total(sim) == pytest.approx(before, abs=1e-13 * scale)


@pytest.mark.parametrize("density", [20.0, 400.0, 8000.0])
def test_body_on_snow_carries_its_weight(density):
    """From a twentieth to twenty times the density of snow a box comes to rest on it; then snow bears m g.

    At rest means: what is left of its speed changes its momentum by less than 3 % of m g t in the last 0.1 s.
    """
    box = {"shape": "box", "size": [0.4, 0.4, 0.2], "center": [0, 0, 0.41], "density": density}
    sim = Simulation(scene([box]), threads=1)
    sim.advance(0.5)
    before = sim.solver.model.rigid.poses()[0].velocity
    sim.advance(0.1)
    pose = sim.solver.model.rigid.poses()[0]
    mass = density * 0.4 * 0.4 * 0.2
    force = sim.stats.exchanged[1, :3] / 0.1
    assert force == pytest.approx(mass * ((pose.velocity - before) / 0.1 + [0, 0, G]), abs=1e-4 * mass * G)
    assert force == pytest.approx([0, 0, mass * G], abs=0.03 * mass * G)
    assert 0.1 < pose.position[2] < 0.42
    assert np.abs(pose.velocity).max() < 0.05


def test_light_body_on_the_ground_bears_snow():
    """A box of a twentieth of the snow's density that lies on the ground bears the column of snow upon it.

    Elastic snow between smooth walls, a hundred times the box's weight. If the snow took the box for one in
    the air, it would sink past it: the ground would bear a quarter (measured). Allowed there: 5 %, half the
    lowest layer of cells. The column swings up and down, so that the mean force is its weight to a sixth.
    """
    walls = [
        {"shape": "plane", "point": [-0.4 * a, -0.4 * b, 0], "normal": [a, b, 0], "mu_c": 0}
        for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))
    ]
    column = {"shape": "box", "size": [0.8, 0.8, 1.0], "center": [0, 0, 0.7]}
    box = {"shape": "box", "size": [0.76, 0.76, 0.2], "center": [0, 0, 0.1], "density": 20}
    snow = {"plasticity": "none", "E0": 5e5}
    sim = Simulation(
        scene([box], sources=[{**column, "snow": snow}], colliders=({"shape": "plane"}, *walls)), threads=1
    )
    weight = sim.diagnostics().mass * G
    sim.advance(0.1)
    sim.advance(0.2)
    force = -sim.stats.exchanged[:, 2] / 0.2
    assert force[-1] == pytest.approx(weight, rel=0.17)
    assert abs(force[0]) < 0.05 * weight


def test_snow_turns_a_gate():
    """Snow that is thrown at a hanging gate swings it about its hinge and no other way."""
    hinge = {"joint": "hinge", "axis": [0, 1, 0], "anchor": [-0.4, 0, 0.6], "limits": [-10, 80]}
    gate = {"shape": "box", "size": [0.1, 0.8, 0.5], "center": [-0.4, 0, 0.35], "density": 300, **hinge}
    sim = Simulation(scene([gate], sources=[{**HEAP, "velocity": [-4, 0, 0]}]), threads=1)
    sim.advance(0.1)
    pose = sim.solver.model.rigid.poses()[0]
    arm = pose.rotation.T @ (np.array([-0.4, 0, 0.6]) - pose.position)
    assert arm == pytest.approx([0, 0, 0.25], abs=1e-9)
    assert pose.omega[1] > 0.5
    assert pose.omega[[0, 2]] == pytest.approx([0, 0], abs=1e-9)


def test_goes_on_with_the_same_bits():
    """Snow and bodies that were stopped and restored have the bits of those that went on."""
    wheel = {
        "shape": "cylinder",
        "radius": 0.15,
        "height": 0.2,
        "rotation": [90, 0, 0],
        "center": [0, 0, 0.46],
    }
    bodies = [
        {"shape": "box", "size": [0.1] * 3, "center": [0, 0, 0.9], "joint": "slide", "mass": 5.0},
        {**wheel, "joint": "hinge", "axis": [0, 1, 0], "parent": 0, "motor": {"target": 10.0}},
        {"shape": "sphere", "radius": 0.15, "center": [0.2, 0.4, 0.4], "velocity": [0, 0, -3]},
    ]
    described = scene(bodies)
    whole, first = Simulation(described, threads=1), Simulation(described, threads=1)
    for sim in (whole, first):
        sim.advance(0.04)
    second = Simulation.restore(described, first.arrays(), threads=1)
    for sim in (whole, second):
        sim.advance(0.04)
    assert np.array_equal(
        whole.solver.model.rigid.save()["engine"], second.solver.model.rigid.save()["engine"]
    )
    assert np.array_equal(whole.state.x, second.state.x)
    assert np.array_equal(whole.exchanged, second.exchanged)
    assert np.abs(whole.exchanged[2:]).max(axis=1).min() > 0  # wheel and ball were touched


def test_lost_body_ends_a_run_in_one_sentence():
    """A body that is thrown out of the world by a mad motor is named; no traceback of the engine."""
    flail = {"shape": "box", "size": [0.2] * 3, "center": [0, 0, 9], "joint": "slide", "axis": [0, 0, 1],
             "motor": {"kind": "torque", "target": 1e6}, "mass": 1e-9}  # fmt: skip
    sim = Simulation(scene([flail], dt=1e-3), threads=1)
    with pytest.raises(Blowup, match=r"bodies\.0 has no finite place or velocity at t = "):
        sim.advance(0.1)
