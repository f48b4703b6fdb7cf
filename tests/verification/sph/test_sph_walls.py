"""Smoothed particles and solids: friction, weight, what stays outside, and bodies that the snow moves."""

import numpy as np
import pytest
from meshes import ball, written
from verification.sph.common import Oracle, add_floor, block, prepare, smoothed, world

from neve.scene.errors import SceneError

G = 9.81
DOWN = (0.0, 0.0, -G)
GROUND = {"shape": "plane"}


@pytest.mark.parametrize(
    ("mode", "mu_c"),
    [*(("separate", mu_c) for mu_c in (0.01, 0.1, 1.0, 10.0, 125.0, 1250.0)), ("sticky", 0.3)],
)
def test_one_step_of_friction_is_the_closed_form(mode, mu_c):
    """A particle above a floor keeps 1 / d of its velocity.

    d = 1 - dt mu_b sum_b V_b (x . grad W) / (x^2 + 0.01 h^2), mu_b = mu_c 2 m/s times the particle spacing,
    up to 100 m2/s here, and a thousand times that of mu_c = 1 where snow sticks. At a spacing of 4 cm and dt
    1 ms d = 1 + 0.35 s/m2 mu_b: it rises without bounds, no step turns the velocity round.
    """
    model = world()
    snow = block((1, 1, 1), spacing=0.04, low=(0.0, 0.0, 0.02))
    snow.v[...] = [1.0, 0.0, 0.0]
    add_floor(snow, model, extent=0.2, mode=mode, mu_c=mu_c)
    prepare(snow, model)
    dt = 1e-3
    snow.find_given(model, dt)
    mu_b = 2.0 * 0.04 * (1000.0 if mode == "sticky" else mu_c)
    _, d = Oracle(snow).friction(dt, mu_b)
    kept = 1.0 + dt * float(snow.given[0, 0])
    assert kept == pytest.approx(1.0 / d[0], rel=1e-9)
    assert d[0] - 1.0 == pytest.approx(0.35 * mu_b, rel=0.05)
    assert 0.0 < kept < 1.0


def test_friction_is_linear_and_never_holds():
    """Friction is drag: the share that is kept does not depend on the speed; a slope never holds snow.

    By Coulomb's law with mu_c = 0.5 snow on a slope of 11 degrees (tan = 0.2) would stay.
    """
    shares = []
    for speed in (0.01, 1.0):
        model = world()
        snow = block((1, 1, 1), spacing=0.02, low=(0.0, 0.0, 0.01))
        snow.v[...] = [speed, 0.0, 0.0]
        add_floor(snow, model, extent=0.1, mu_c=0.5)
        prepare(snow, model)
        snow.find_given(model, 1e-3)
        shares.append(float(snow.given[0, 0]) / speed)
    assert shares[0] == pytest.approx(shares[1], rel=1e-9)
    slope = np.radians(11.0)
    gravity = (G * np.sin(slope), 0.0, -G * np.cos(slope))
    sim = smoothed(
        [{"shape": "box", "center": (0, 0, 0.1), "size": (0.3, 0.3, 0.2)}], [GROUND | {"mu_c": 0.5}], gravity
    )
    sim.advance(0.3)
    d = sim.diagnostics()
    assert d.momentum[0] / d.mass > 0.05


def test_without_friction_a_block_slides_freely():
    """On a plane with mu_c = 0 a block falls along the slope with g sin a, within 1 %: its particles
    are no bumps."""
    slope = np.radians(20.0)
    gravity = (G * np.sin(slope), 0.0, -G * np.cos(slope))
    sim = smoothed(
        [{"shape": "box", "center": (0, 0, 0.1), "size": (0.4, 0.4, 0.2)}],
        [GROUND | {"mu_c": 0.0}],
        gravity,
        {"E0": 1e6},
        sampling="regular",
    )
    sim.advance(0.3)
    d = sim.diagnostics()
    assert d.momentum[0] / d.mass == pytest.approx(0.3 * gravity[0], rel=0.01)


def resting(collider, center=(0.0, 0.0, 0.62), time=0.4):
    """A small block that falls on a collider whose top is at 0.5 m."""
    sim = smoothed(
        [{"shape": "box", "center": center, "size": (0.2, 0.2, 0.2)}],
        [collider | {"mode": "sticky"}],
        DOWN,
        {"E0": 5e5},
    )
    sim.advance(time)
    return sim


@pytest.mark.parametrize(
    "collider",
    [
        {"shape": "plane", "point": (0, 0, 0.5)},
        {"shape": "box", "center": (0, 0, 0.25), "size": (0.8, 0.8, 0.5)},
        {"shape": "box", "center": (0, 0, 0.49), "size": (0.8, 0.8, 0.02)},
        {"shape": "sphere", "radius": 0.5, "center": (0, 0, 0)},
        {"shape": "cylinder", "radius": 0.4, "height": 0.5, "center": (0, 0, 0.25)},
    ],
    ids=["plane", "box", "sheet", "sphere", "cylinder"],
)
def test_any_shape_bears_snow(collider):
    """Snow that falls on a solid comes to rest on it: no particle inside, and the solid bears the weight."""
    sim = resting(collider)
    x = np.asarray(sim.state.x, dtype=np.float64)
    assert sim.solver.placed.distance(0, x).min() > -1e-6
    assert np.abs(np.asarray(sim.state.v)).max() < 0.3
    before = sim.diagnostics().momentum[2]
    sim.advance(0.2)
    now = sim.diagnostics()
    assert sim.stats.exchanged[0, 2] == pytest.approx(
        -0.2 * now.mass * G - (now.momentum[2] - before), rel=1e-9
    )
    assert sim.stats.exchanged[0, 2] == pytest.approx(-0.2 * now.mass * G, rel=0.1)


def test_a_mesh_bears_snow(tmp_path):
    """A ball of triangles acts as the ball does: heights agree to a third of the particle spacing."""
    path = written(ball(0.5), tmp_path / "ball.obj")
    heights = []
    for collider in (
        {"shape": "mesh", "file": path},
        {"shape": "sphere", "radius": 0.5, "center": (0, 0, 0)},
    ):
        sim = resting(collider)
        heights.append(np.asarray(sim.state.x)[:, 2].mean())
    assert heights[0] == pytest.approx(heights[1], abs=0.05 / 3)


def terrain(tmp_path, heights):
    """A terrain of 4 m by 4 m with these heights at samples 2.5 cm apart."""
    np.save(tmp_path / "heights.npy", heights)
    return {"shape": "terrain", "file": str(tmp_path / "heights.npy"), "size": [4.0, 4.0]}


def test_a_terrain_bears_snow(tmp_path):
    """On hills and hollows 0.1 m high snow comes to rest, none of it inside."""
    u = np.linspace(-2.0, 2.0, 161)
    ground = terrain(
        tmp_path, (0.5 + 0.05 * np.sin(4 * u)[:, None] * np.cos(3 * u)[None, :]).astype(np.float32)
    )
    sim = resting(ground)
    x = np.asarray(sim.state.x, dtype=np.float64)
    assert sim.solver.placed.distance(0, x).min() > -1e-3
    assert np.abs(np.asarray(sim.state.v)).max() < 0.3
    before = sim.diagnostics().momentum[2]
    sim.advance(0.2)
    now = sim.diagnostics()
    assert sim.stats.exchanged[0, 2] == pytest.approx(
        -0.2 * now.mass * G - (now.momentum[2] - before), rel=1e-9
    )


@pytest.mark.parametrize("turn", [False, True])
def test_a_step_of_terrain_has_particles(tmp_path, turn):
    """The wall of a step of 0.8 m within one sample, along y or x: a particle for each square of the spacing.

    They lie at most half a spacing behind the wall, which is between 0 and 2.5 cm; and snow that flies at it
    is stopped by them, as by a box, within 20 % of the impulse.
    """
    u = np.linspace(-2.0, 2.0, 161)
    heights = np.where(u > 0.01, 0.8, 0.0).astype(np.float32)[:, None] * np.ones((1, 161), dtype=np.float32)
    ground = terrain(tmp_path, heights.T if turn else heights)
    along = (1, 0, 2) if turn else (0, 1, 2)
    block = {
        "shape": "box",
        "center": [(-0.2, 0.0, 0.4)[k] for k in along],
        "size": (0.3, 0.3, 0.3),
        "velocity": [(3.0, 0.0, 0.0)[k] for k in along],
    }
    sim = smoothed([block], [ground | {"mu_c": 0.0}])
    x = np.asarray(sim.state.boundary_x)[:, along]
    wall = (x[:, 2] > 0.2) & (x[:, 2] < 0.6) & (np.abs(x[:, 1]) < 0.15)
    assert wall.sum() == pytest.approx(0.4 * 0.3 / 0.05**2, rel=0.15)
    assert np.all((x[wall, 0] > 0.0) & (x[wall, 0] < 0.05))
    sim.advance(0.1)
    inside = sim.solver.placed.distance(0, np.asarray(sim.state.x))
    assert inside.min() > -1e-3
    box = {"shape": "box", "center": (0.5125, 0, 0.4), "size": (1.0, 4.0, 0.8), "mu_c": 0.0}
    other = smoothed([block | {"center": (-0.2, 0.0, 0.4), "velocity": (3.0, 0.0, 0.0)}], [box])
    other.advance(0.1)
    assert sim.exchanged[0, along[0]] == pytest.approx(other.exchanged[0, 0], rel=0.2)


@pytest.mark.parametrize(("radius", "said"), [(1e4, None), (1e6, r"colliders\.0 meets snow 1e\+06 m from")])
def test_ground_as_round_as_a_planet(radius, said):
    """A ball of 10 km bears snow as a plane does; what cannot be numbered from its middle is told."""
    cube = {"shape": "box", "size": [0.3, 0.3, 0.3], "center": [0.0, 0.0, 0.15]}
    heights = []
    for floor in ({"shape": "sphere", "radius": radius, "center": [0.0, 0.0, -radius]}, GROUND):
        if said and floor != GROUND:
            with pytest.raises(SceneError, match=said):
                smoothed([cube], [floor], DOWN)
            return
        sim = smoothed([cube], [floor], DOWN)
        sim.advance(0.1)
        heights.append(np.sort(np.asarray(sim.state.x)[:, 2]))
    assert np.abs(heights[0] - heights[1]).max() < 2e-3


def test_fast_snow_does_not_pass_a_sheet():
    """At 30 m/s, a hundred times its strength, snow stays on its side of a plate of 1 cm."""
    sim = smoothed(
        [{"shape": "box", "center": (0, 0, 0.3), "size": (0.2, 0.2, 0.2), "velocity": (0, 0, -30)}],
        [{"shape": "box", "center": (0, 0, 0.0), "size": (2.0, 2.0, 0.01)}],
    )
    sim.advance(0.03)
    x = np.asarray(sim.state.x)
    under = np.all(np.abs(x[:, :2]) < 1.0, axis=1)
    assert x[under, 2].min() > 0.0049


def test_a_moving_wall_pushes():
    """A plate at 1 m/s takes snow along, and its work is impulse times velocity."""
    wall = {"shape": "box", "center": (-0.25, 0, 0), "size": (0.1, 0.6, 0.6), "velocity": (1.0, 0, 0)}
    sim = smoothed([{"shape": "box", "center": (0, 0, 0), "size": (0.3, 0.3, 0.3)}], [wall])
    sim.advance(0.4)
    d = sim.diagnostics()
    assert d.momentum[0] / d.mass == pytest.approx(1.0, abs=0.35)
    work, impulse = sim.exchanged[0, 6], sim.exchanged[0, 0]
    assert work == pytest.approx(-impulse * 1.0, rel=1e-9)
    assert -impulse == pytest.approx(d.momentum[0], rel=1e-9)


BALL = {"shape": "sphere", "radius": 0.15, "center": [0.5, 0, 0.1], "velocity": [-4, 0, 0]}
BOX = {"shape": "box", "size": [0.2] * 3, "center": [-0.45, 0, 0.1], "velocity": [1, 0, 0], "spin": [1, 2, 3]}
HEAP = {"shape": "box", "size": [0.6, 0.6, 0.3], "center": [0.0, 0.0, 0.15]}


def angular(sim):
    """Angular momentum of the snow about the origin."""
    m, x, v = (np.asarray(a) for a in (sim.state.m, sim.state.x, sim.state.v))
    return np.cross(x, m[:, None] * v).sum(axis=0)


def total(sim):
    """Momentum, and angular momentum about the origin, of snow and bodies together."""
    now = sim.diagnostics()
    linear = np.add(now.momentum, now.bodies_momentum)
    return linear, angular(sim) + sim.solver.placed.rigid.angular_momentum


@pytest.mark.parametrize("mode", ["separate", "sticky"])
@pytest.mark.parametrize("density", [100.0, 4000.0])
def test_momentum_of_snow_and_bodies(density, mode):
    """What the snow gains the bodies lose, to rounding: a ball hits it, and a box that turns."""
    bodies = [BALL | {"density": density, "mode": mode}, BOX | {"density": density, "mode": mode}]
    sim = smoothed([HEAP], bodies=bodies, dx=0.1)
    before, speed = total(sim)[0], sim.solver.placed.rigid.poses()[0].velocity[0]
    sim.advance(0.06)
    assert abs(sim.solver.placed.rigid.poses()[0].velocity[0] - speed) > 0.05
    scale = sum(sim.solver.placed.rigid.mass * 4.0) + sim.diagnostics().mass * 4.0
    np.testing.assert_allclose(total(sim)[0], before, rtol=0, atol=1e-13 * scale)


@pytest.mark.parametrize("ratio", [1e-3, 1e-1, 1.0, 1e3])
@pytest.mark.parametrize("mode", ["separate", "sticky"])
def test_no_body_is_thrown_about(ratio, mode):
    """A box that slides and turns on snow, a thousandth to a thousand times as dense: no energy comes up.

    The velocity of a light one is found with that of the snow that it rubs on: an explicit impulse would turn
    it round, to a speed as many times higher as the layer of snow beside it is heavier. What snow gains in
    angular momentum, the body is given the opposite of, to rounding.
    """
    body = {"shape": "box", "size": [0.3, 0.3, 0.1], "center": [0, 0, 0.36], "density": 400.0 * ratio}
    body |= {"mode": mode, "velocity": [1.0, 0.5, 0.0], "spin": [0.0, 0.0, 3.0]}
    sim = smoothed([HEAP | {"size": [0.4, 0.4, 0.3]}], bodies=[body])

    def energy():
        now = sim.diagnostics()
        return now.kinetic + now.elastic + now.bodies_kinetic

    first, before = energy(), total(sim)[0]
    least = first
    scale = np.linalg.norm(before) + 1e-3 * float(np.sum(sim.state.m))
    for _ in range(20):
        spin, centre = angular(sim), np.array(sim.solids()[0][1].position)
        sim.advance(1.0, enough=lambda: True)
        assert energy() <= least * (1 + 1e-9)
        least = energy()
        given = sim.stats.exchanged[0]
        left = angular(sim) - spin + given[3:6] + np.cross(centre, given[:3])
        np.testing.assert_allclose(left, 0.0, atol=1e-11 * scale)
    assert least < first
    np.testing.assert_allclose(total(sim)[0], before, rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize("density", [30.0, 400.0])
def test_a_body_rests_on_snow(density):
    """A box comes to rest on a bed of snow, 2.5 cm at most from where mpm has it (0.394 m).

    The snow then bears its weight, and the impulses account for its velocity.
    """
    bed = {"shape": "box", "size": [1.2, 1.2, 0.3], "center": [0.0, 0.0, 0.15]}
    box = {"shape": "box", "size": [0.4, 0.4, 0.2], "center": [0, 0, 0.42], "density": density}
    sim = smoothed([bed], [GROUND], DOWN, bodies=[box], precision="float32")
    rigid = sim.solver.placed.rigid
    sim.advance(0.6)
    before = rigid.poses()[0].velocity[2]
    sim.advance(0.2)
    after = rigid.poses()[0]
    assert abs(after.velocity[2]) < 0.05
    assert after.position[2] == pytest.approx(0.40, abs=0.025)
    mass = float(rigid.mass[0])
    gained = mass * (after.velocity[2] - before)
    # impulse of the snow on the body, to rounding of float32 in its poses
    assert sim.stats.exchanged[1, 2] - 0.2 * mass * G == pytest.approx(gained, abs=1e-4 * mass)
