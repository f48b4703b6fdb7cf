"""What the presets with a boot, a wheel and an avalanche promise, on coarse grids and for a short while."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.scene.reading.load import load
from neve.simulation import Simulation

QUICK_STEP = [
    "numerics.dx=0.02",
    "sources.0.size=[0.44, 0.3]",
    "bodies.0.motor.keyframes=[{t=0,value=0},{t=0.2,value=-0.16},{t=0.31,value=-0.16},{t=0.46,value=0.1}]",
    "bodies.1.motor.keyframes=[{t=0,value=0},{t=1,value=0}]",
]


def at(sim: Simulation, name: str) -> Any:
    """Where the solid of this name is."""
    return next(pose for solid, pose in sim.solids() if solid.name == name)


def number(sim: Simulation, name: str) -> int:
    """The row of the solid of this name in what was exchanged."""
    return [solid.name for solid, _ in sim.solids()].index(name)


def by_id(sim: Simulation) -> NDArray[np.float64]:
    """Places of the particles in the order in which they were made."""
    return np.asarray(sim.state.x[np.argsort(sim.state.id)], np.float64)


def test_boot_presses_with_its_weight_and_leaves_a_print() -> None:
    """Held down by 800 N and the weight of 5.5 kg, the snow carries both.

    The impulse of 0.04 s is (800 N + m g) times it, and the change of the momentum, to 1 % for
    the forces of the leg's joints. Afterwards the snow under the sole is lower by more than
    half a cell, and two cells beside the boot nothing has moved by a third of a cell.
    """
    scene = load("boot", QUICK_STEP)
    dx, depth = scene.numerics.dx, 0.062
    sim = Simulation(scene)
    before = by_id(sim)
    sim.advance(0.26)
    boot, mass = number(sim, "bodies.1"), 5.5
    impulse, speed = sim.exchanged[boot, 2], at(sim, "bodies.1").velocity[2]
    sim.advance(0.04)
    impulse = sim.exchanged[boot, 2] - impulse
    gained = mass * (at(sim, "bodies.1").velocity[2] - speed)
    assert abs(impulse - (800.0 + mass * 9.81) * 0.04 - gained) < 0.01 * 800.0 * 0.04
    sim.advance(0.17)
    assert at(sim, "bodies.1").position[2] > depth
    after = by_id(sim)
    under = (np.abs(after[:, 0]) < 0.1) & (np.abs(after[:, 1]) < 0.025)
    assert after[under, 2].max() < depth - 0.5 * dx
    beside = np.abs(before[:, 1]) > 0.07 + 2 * dx
    assert np.count_nonzero(beside) > 100
    assert np.linalg.norm(after[beside] - before[beside], axis=1).max() < dx / 3


def test_wheel_goes_ahead_sinks_slips_and_leaves_a_rut() -> None:
    """The wheel moves on by a metre, sinks, slips without spinning in place, and leaves a rut.

    Sunk: its lowest point is a quarter of a cell below the snow's surface at least. A rut: behind the wheel
    the snow is lower than ahead of it by a quarter of a cell at least.
    """
    scene = load("wheel", ["numerics.dx=0.08"])
    dx, surface, radius = scene.numerics.dx, 0.19, 0.35
    sim = Simulation(scene)
    start = at(sim, "bodies.3").position[0]
    sim.advance(1.4)
    wheel = at(sim, "bodies.3")
    place = wheel.position[0]
    assert place > start + 1.0
    assert wheel.position[2] - radius < surface - 0.25 * dx
    slip = 1.0 - wheel.velocity[0] / (radius * wheel.omega[1])
    assert 0.0 < slip < 0.9
    x = sim.state.x
    track = np.abs(x[:, 1]) < 0.06
    behind = x[track & (x[:, 0] > start + 0.5) & (x[:, 0] < place - radius), 2].max()
    ahead = x[track & (x[:, 0] > place + 2 * radius) & (x[:, 0] < 1.5), 2].max()
    assert behind < ahead - 0.25 * dx


def test_slab_slides_breaks_and_pushes_the_trees() -> None:
    """The slab falls by metres, pushes the trees downhill, and breaks.

    No particle is faster than a fall from the top to the lowest place allows. Broken: of pairs of particles
    that began within a cell some are more than three cells apart, so that no node of the grid joins them;
    measured: one in two hundred.
    """
    dx = 0.25
    sim = Simulation(load("avalanche", [f"numerics.dx={dx}", f"sources.0.variation.seam={dx}"]))
    before = by_id(sim)
    sim.advance(3.2)
    after = by_id(sim)
    way = (after - before).mean(0)
    assert way[0] > 4.0
    assert way[2] < -2.5
    fall = before[:, 2].max() - after[:, 2].min()
    assert np.linalg.norm(sim.state.v, axis=1).max() < np.sqrt(2 * 9.81 * fall)
    trees = [number(sim, f"colliders.{k}") for k in (1, 2, 3)]
    assert sim.exchanged[trees, 0].sum() > 0.0
    some = np.arange(0, len(before), 3)
    near = np.linalg.norm(before[some, None] - before[None, some], axis=2) < dx
    far = np.linalg.norm(after[some, None] - after[None, some], axis=2) > 3 * dx
    assert np.count_nonzero(near & far) > 0
