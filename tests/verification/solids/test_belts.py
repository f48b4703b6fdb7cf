"""Solids whose surface moves past them, like conveyor belts."""

import numpy as np
import pytest

from neve import Simulation
from neve.diagnostics import Balance
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from

G, U, MU = 9.81, 1.0, 0.4
BELT = {"shape": "plane", "surface_velocity": [U, 0.0, 0.0], "mu_c": MU}
STONE = {"shape": "box", "center": [50.0, 0.0, 20.0], "size": [0.4, 0.4, 0.4], "density": 900.0}


def block(*colliders, turn=0.0, **more):
    """An elastic block of 0.3 x 0.3 x 0.2 m at rest on the plane z = 0, with gravity turned by `turn`."""
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    scene = {
        "world": {"gravity": [-G * s, 0.0, -G * c]},
        "numerics": {"dx": 0.05, "precision": "float64", "sampling": "regular"} | more.pop("numerics", {}),
        "snow": {"law": "neo_hookean", "plasticity": "none", "E0": 2e5},
        "sources": [{"shape": "box", "center": [0.0, 0.0, 0.1], "size": [0.3, 0.3, 0.2]}],
        "colliders": list(colliders),
    }
    return Simulation(scene_from(scene | more))


def velocity(sim):
    """The mean velocity of the snow."""
    m = np.asarray(sim.state.m)
    return (m[:, None] * np.asarray(sim.state.v)).sum(axis=0) / m.sum()


@pytest.mark.parametrize("more", [{}, {"bodies": [STONE]}, {"numerics": {"method": "particles"}}])
def test_friction_brings_snow_to_the_speed_of_the_belt(more):
    """v = mu g t until U: at rest the belt rubs with mu m g, and with nothing once the snow moves with it.

    The work of the belt is impulse times U, m U^2, twice the kinetic energy that the snow gets: the other
    half is heat, as for sand on a conveyor. A rigid body elsewhere changes nothing.
    """
    if more.get("numerics"):
        more = {**more, "numerics": {**more["numerics"], "precision": "float32"}}
    sim = block(BELT, **more)
    mass = float(np.asarray(sim.state.m).sum())
    sim.advance(0.18)
    rubbed, _, pressed = sim.exchanged[0, :3]
    assert rubbed == pytest.approx(MU * pressed, rel=0.02)  # Coulomb, however the block bounces
    np.testing.assert_allclose(velocity(sim)[:2], [MU * G * 0.18, 0.0], rtol=0.06, atol=1e-3)
    sim.advance(0.5)
    assert velocity(sim)[0] == pytest.approx(U, abs=0.01)
    impulse, work = sim.exchanged[0, :3], sim.exchanged[0, 6]
    assert impulse[0] == pytest.approx(-mass * velocity(sim)[0], rel=1e-4)
    assert work == pytest.approx(mass * U * U, rel=0.02)
    assert 0.5 * mass * velocity(sim)[0] ** 2 == pytest.approx(0.5 * work, rel=0.03)


def test_sticky_snow_moves_with_the_belt():
    """In the mean, since the block shakes; what the belt has along the normal does not count."""
    sim = block(BELT | {"mode": "sticky", "surface_velocity": [0.3, -0.4, 7.0]})
    sim.advance(0.2)
    start = np.asarray(sim.state.x).mean(axis=0)
    sim.advance(1.0)
    np.testing.assert_allclose(np.asarray(sim.state.x).mean(axis=0) - start, [0.3, -0.4, 0.0], atol=0.015)


@pytest.mark.parametrize(("turn", "speed"), [(15.0, U), (35.0, 0.0)])
def test_a_steep_belt_carries_what_friction_holds(turn, speed):
    """On a belt that runs up a slope snow gets to its speed if mu > tan(slope); else it slides down.

    Then dv/dt = g (mu cos - sin), with mu = 0.4 and tan = 0.7.
    """
    sim = block(BELT, turn=turn)
    sim.advance(1.0 if speed else 0.2)
    slope = np.radians(turn)
    sliding = G * (MU * np.cos(slope) - np.sin(slope)) * 0.2
    assert velocity(sim)[0] == pytest.approx(speed or sliding, rel=0.04, abs=0.01)


def test_only_the_part_along_a_face_counts():
    """A box that runs toward the snow beside it does not push it; a turned one carries snow by its axes."""
    front = {"shape": "box", "center": [-0.65, 0, 0.5], "size": [1, 1, 1]}
    runs = [block({"shape": "plane"}, front | {"surface_velocity": [u, 0, 0]}) for u in (0.0, U)]
    for sim in runs:
        sim.advance(0.1)
    np.testing.assert_allclose(*(np.asarray(sim.state.x) for sim in runs), atol=1e-6)
    turned = {"shape": "box", "center": [0, 0, -0.5], "size": [4, 4, 1], "rotation": [0, 0, 90]}
    sim = block(turned | {"surface_velocity": [U, 0, 0]})
    sim.advance(0.5)
    np.testing.assert_allclose(velocity(sim)[:2], [0.0, U], atol=0.01)


def test_energy_is_booked():
    """The snow never gains more than the belt's work, and rubbing takes half of that away: m U^2 / 2."""
    sim = block(BELT)
    mass, start = float(np.asarray(sim.state.m).sum()), Balance.of(sim.diagnostics())
    for _ in range(12):
        sim.advance(0.05)
        assert Balance.of(sim.diagnostics()).growth(start) < 1e-3 * mass * U * U
    assert Balance.of(sim.diagnostics()).growth(start) == pytest.approx(-0.5 * mass * U * U, rel=0.1)


def test_the_belt_bounds_the_step():
    """A fast belt is a fast solid: no more than cfl cells of it in a step."""
    sim = block(BELT | {"surface_velocity": [300.0, 0.0, 0.0]})
    sim.advance(1e-3)
    assert sim.stats.dt_min <= 0.4 * 0.05 / 300 * (1 + 1e-9)


def test_a_belt_can_be_stopped_and_moved_while_it_runs():
    """`change` stops it, so that friction brakes the snow; a belt that moves adds its own velocity."""
    sim = block(BELT)
    sim.advance(0.4)
    stopped = sim.scene.colliders[0].model_copy(update={"surface_velocity": (0.0, 0.0, 0.0)})
    sim.change(sim.scene.model_copy(update={"colliders": (stopped,)}))
    sim.advance(0.4)
    assert abs(velocity(sim)[0]) < 0.01
    sim = block(BELT | {"keyframes": [{"t": 0.0}, {"t": 5.0, "position": [0.0, 2.5, 0.0]}]})
    sim.advance(0.6)
    np.testing.assert_allclose(velocity(sim)[:2], [U, 0.5], atol=0.01)


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_round_solids_have_no_belt(shape):
    """They can spin."""
    with pytest.raises(SceneError, match=r"colliders\.0\.surface_velocity .*flat faces"):
        block({"shape": shape, "surface_velocity": [1.0, 0.0, 0.0]})
