"""What the presets with bodies and slopes promise, on coarse cells."""

import warnings

import numpy as np
import pytest

from neve.scene.errors import SceneWarning
from neve.scene.reading.load import load
from neve.simulation import Simulation


def started(name, dx, *changes):
    """A preset with cells of `dx` [m], which makes it quick and its layers thin, and other changes."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        return Simulation(load(name, [f"numerics.dx={dx}", *changes]), threads=1)


def body(sim):
    """The body that the snow moves: where it is, and its row in the tables of solids."""
    (found,) = [(pose, i) for i, (solid, pose) in enumerate(sim.solids()) if solid.motion == "dynamic"]
    return found


def by_birth(sim, *names):
    """Fields of the particles in the order of their birth, in double precision."""
    order = np.argsort(sim.state.id)
    return [np.array(getattr(sim.state, name), np.float64)[order] for name in names]


def test_the_ball_leaves_a_crater():
    """The ball comes to rest in the snow, which carries its weight, in a crater wider than itself.

    At rest: the mean force of the snow over 0.15 s is the weight to a tenth; what sways of the ball may
    change its speed by m |dv| <= 0.1 m g 0.15 s, |dv| <= 0.15 m/s. Sunk: its middle is below the surface,
    but its lowest point is not on the ground, which would carry it instead. A crater: in the inner half of
    its radius R no snow is higher than 0.8 R below its middle, so none lies on it (the ball itself is
    sqrt(3/4) R there, or lower); next to it, up to 1.3 R, the surface has sunk by more than half a cell,
    and outside 3 R by less than a fifth.
    """
    scene = load("ball_on_snow")
    ball, depth, dx = scene.bodies[0], scene.sources[0].depth, 0.09
    sim = started("ball_on_snow", dx)
    surface = by_birth(sim, "x")[0][:, 2].max()
    sim.advance(0.45)
    before = sim.exchanged.copy()
    sim.advance(0.15)
    pose, row = body(sim)
    mass = ball.density * 4 / 3 * np.pi * ball.radius**3
    assert (sim.exchanged - before)[row, 2] / 0.15 == pytest.approx(mass * 9.81, rel=0.1)
    assert np.linalg.norm(pose.velocity) < 0.15
    assert 1.05 * ball.radius < pose.position[2] < depth
    (x,) = by_birth(sim, "x")
    r = np.hypot(x[:, 0] - pose.position[0], x[:, 1] - pose.position[1]) / ball.radius
    assert x[r < 0.5, 2].max() < pose.position[2] - 0.8 * ball.radius
    assert x[(r > 1.0) & (r < 1.3), 2].max() < surface - 0.5 * dx
    assert x[r > 3.0, 2].max() == pytest.approx(surface, abs=0.2 * dx)


def spin_of(x, v, m):
    """Angular velocity about y of particles that move as one: angular momentum over moment of inertia."""
    d = x - np.average(x, axis=0, weights=m)
    u = v - np.average(v, axis=0, weights=m)
    return float(
        (m * (d[:, 2] * u[:, 0] - d[:, 0] * u[:, 2])).sum() / (m * (d[:, 0] ** 2 + d[:, 2] ** 2)).sum()
    )


def test_the_snowball_rolls_and_grows():
    """The snowball rolls more than a turn, keeps its snow, and carries three tenths of its mass more.

    Carried is snow of the layer that is within 1.6 R of the ball's centre and has been lifted out of the
    layer by more than the layer's depth. The turns are the sum of the spin over steps of 0.05 s.
    """
    scene = load("roll")
    layer, ball = scene.sources[0], scene.sources[2]
    sim = started("roll", 0.085)
    x, v, m = by_birth(sim, "x", "v", "m")
    own = np.linalg.norm(x - ball.center, axis=1) < 1.01 * ball.radius
    angle = 0.0
    for _ in range(28):
        angle += 0.05 * spin_of(x[own], v[own], m[own])
        sim.advance(0.05)
        x, v, m = by_birth(sim, "x", "v", "m")
    assert angle > 2 * np.pi
    centre = np.average(x[own], axis=0, weights=m[own])
    near = np.linalg.norm(x - centre, axis=1)
    assert m[own & (near < 1.1 * ball.radius)].sum() > 0.98 * m[own].sum(), "the ball is whole"
    slope = np.radians(layer.rotation[1])
    height = x @ [np.sin(slope), 0.0, np.cos(slope)]
    carried = ~own & (near < 1.6 * ball.radius) & (height > 2 * layer.size[2])
    assert m[carried].sum() > 0.3 * m[own].sum()


def test_the_cannonball_smashes_the_castle():
    """The tower that is hit loses its top, the one in the far corner keeps its own, and snow flies.

    Snow and ball share their momentum: the ball has lost at least a fifth of its speed, and what it lost
    is what the snow took, by the impulses that they exchanged (gravity takes part only along z).
    """
    scene = load("castle")
    ball = scene.bodies[0]
    sim = started("castle", 0.12, "sources.0.variation.seam=0.12")
    (x,) = by_birth(sim, "x")
    towers = [np.hypot(x[:, 0] - a, x[:, 1] - a) < 0.33 for a in (-0.9, 0.9)]
    tops = [x[tower, 2].max() for tower in towers]
    sim.advance(0.3)
    pose, row = body(sim)
    assert np.linalg.norm(pose.velocity) < 0.8 * np.linalg.norm(ball.velocity)
    mass = ball.density * 4 / 3 * np.pi * ball.radius**3
    lost = mass * (pose.velocity - np.array(ball.velocity))
    assert sim.exchanged[row, :2] == pytest.approx(lost[:2], rel=1e-3)
    (v,) = by_birth(sim, "v")
    assert (np.linalg.norm(v, axis=1) > 5.0).mean() > 0.01
    sim.advance(0.3)
    (x,) = by_birth(sim, "x")
    hit, kept = [x[np.hypot(x[:, 0] - a, x[:, 1] - a) < 0.33, 2].max() for a in (-0.9, 0.9)]
    assert hit < tops[0] - 0.2
    assert kept > tops[1] - 0.1
