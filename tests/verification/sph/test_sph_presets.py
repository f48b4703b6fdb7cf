"""What the presets of smoothed particles promise, coarse and short."""

import warnings

import numpy as np

import neve
from neve.scene.errors import SceneWarning


def test_the_bridge_breaks_and_piles_up():
    """It is born above the posts, hangs between them, then lies on the ground with the ball in it.

    Snow is pressed where the ball is. Its momentum is what gravity gave it less what ground, posts and ball
    took, to the rounding of float32.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        sim = neve.Simulation(neve.load("bridge", ["numerics.dx=0.1"]), threads=1)

    def between():
        x = np.asarray(sim.state.x)
        return x[np.abs(x[:, 0]) < 0.3, 2]

    assert between().min() > 1.0
    before = sim.diagnostics()
    sim.advance(0.3)
    assert 0.4 < between().mean() < 0.95
    sim.advance(1.0)
    assert between().mean() < 0.4
    assert (np.asarray(sim.state.x)[:, 2] > 0.8).any()  # some stays on the posts
    assert np.asarray(sim.state.J_P).min() < 0.8
    ball = sim.solids()[-1][1].position
    assert ball[2] < 0.4
    assert np.asarray(sim.state.x)[:, 2].min() > -1e-3
    now = sim.diagnostics()
    fallen = now.mass * sim.time * np.array([0.0, 0.0, -9.81])
    gained = np.subtract(now.momentum, before.momentum)
    left = gained - fallen + sim.exchanged[:, :3].sum(axis=0)
    assert np.abs(sim.exchanged[:, 2]).min() > 0.01 * np.linalg.norm(fallen)  # all four took part
    np.testing.assert_allclose(left, 0.0, atol=1e-6 * np.linalg.norm(fallen))


def coarse(name, dx):
    """Return a preset with that dx, as a simulation."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        return neve.Simulation(neve.load(name, [f"numerics.dx={dx}"]), threads=1)


def test_snowballs_pile_up():
    """On the table stands a heap: steeper than 30 degrees from where 90 % of it is to its top.

    Round grains without cohesion lie at 22 to 30 degrees (from memory): it coheres. By the material point
    method the same scene stands at 42 degrees: friction of smoothed particles is drag and holds nothing, so
    that the heap spreads (docs/sph.md).
    """
    sim = coarse("heap", 0.06)
    sim.advance(2.0)
    x = np.asarray(sim.state.x)
    x = x[x[:, 2] > 0.4 - 0.03]
    assert len(x) > 0.8 * sim.count
    r = np.sort(np.hypot(x[:, 0], x[:, 1]))[int(0.9 * len(x))]
    assert np.hypot(x[:, 0], x[:, 1]).max() < 0.75
    assert np.degrees(np.arctan2(np.percentile(x[:, 2], 99) - 0.4, r)) > 30.0


def test_weights_pack_the_snow_below_them():
    """The heavier the block, the deeper it is and the denser the snow between it and the ground.

    Snow that carries the heaviest has hardened until it does not yield: its law bears
    s = (lam0 + 2 G0) theta_c exp(xi (1 - J_P)) along one axis, so 1 - J_P is at least ln(rho g h / s_0) / xi.
    The lightest presses with less than s_0: snow beside it is as dense as that below it, to 5 %.
    """
    sim = coarse("weights", 0.06)
    snow = sim.scene.snow.constants()
    modulus = snow["E0"] * (1 - snow["nu"]) / ((1 + snow["nu"]) * (1 - 2 * snow["nu"]))
    pressures = [9.81 * 0.24 * body.density for body in sim.scene.bodies]
    packed = 1 - np.log(pressures[2] / (modulus * snow["theta_c"])) / snow["xi"]
    assert pressures[0] < modulus * snow["theta_c"]
    sim.advance(0.5)
    x, density = np.asarray(sim.state.x), np.asarray(sim.columns()["density"]())
    heights, dense = [], []
    for solid, pose in sim.solids():
        if solid.motion != "dynamic":
            continue
        off = x - pose.position
        below = (np.abs(off[:, :2]).max(axis=1) < 0.12) & (off[:, 2] < 0)
        heights.append(pose.position[2])
        dense.append(np.median(density[below]))
    aside = np.abs(np.abs(x[:, 0]) - 0.28) < 0.05
    assert heights[0] > heights[1] + 0.05
    assert heights[1] > heights[2] + 0.05
    assert dense[2] > dense[1] > dense[0]
    assert dense[2] > np.median(density[aside]) / packed
    assert abs(dense[0] / np.median(density[aside]) - 1) < 0.05


def test_a_pressed_cube_survives_the_fall():
    """It stands there whole; the loose one has slumped to a flatter heap and shed snow. It is denser.

    The jaws leave it 0.2 m and a particle spacing of its 0.32 m. With the speed of a fall of 1.1 m
    comes rho g h of work per volume; snow that hardens as s_0 exp(xi e) takes that up at the compression e of
    s_0 (exp(xi e) - 1) / xi = rho g h. So much flatter is the loose one at least, to half a particle
    spacing; the pressed one, of which s_0 is exp(xi (1 - J_P)) times as large, loses a layer at most.
    """
    spacing, side = 0.05, 0.32
    sim = coarse("pressed", spacing)
    snow = sim.scene.snow.constants()
    modulus = snow["E0"] * (1 - snow["nu"]) / ((1 + snow["nu"]) * (1 - 2 * snow["nu"]))
    work, first = snow["rho0"] * 9.81 * (1.3 - side / 2), modulus * snow["theta_c"]
    flatter = np.log1p(snow["xi"] * work / first) / snow["xi"]
    source = np.asarray(sim.state.source)
    sim.advance(0.5)
    source, J_P = np.asarray(sim.state.source), np.asarray(sim.state.J_P)
    assert np.median(J_P[source == 1]) < (0.2 + spacing) / side
    assert np.median(J_P[source == 0]) > 0.95
    sim.advance(1.0)
    spread, height, shed = [], [], []
    for number in (0, 1):
        x = np.asarray(sim.state.x)[np.asarray(sim.state.source) == number]
        off = x - np.median(x, axis=0)
        spread.append(np.percentile(np.hypot(off[:, 0], off[:, 1]), 90))
        height.append(np.percentile(x[:, 2], 99))
        shed.append(np.mean(np.linalg.norm(off, axis=1) > 0.25))
    assert shed[1] < 0.03 < shed[0]
    assert spread[0] > 1.2 * spread[1]
    assert height[0] < (1 - flatter) * side + spacing / 2
    assert height[1] > side - spacing


def test_a_wave_breaks_a_wall_of_snow():
    """The wave moves the wall by more than its thickness and lifts part of it on the water."""
    sim = coarse("wave", 0.06)
    wet = np.asarray(sim.columns()["phase"]()) == 1.0
    assert 0.6 < wet.mean() < 0.9
    sim.advance(1.2)
    x, wet = np.asarray(sim.state.x), np.asarray(sim.columns()["phase"]()) == 1.0
    assert x[~wet, 0].mean() > 0.18 + 0.2
    assert np.median(x[~wet, 2]) > np.median(x[wet, 2]) + 0.05
    assert x[wet, 0].max() > 0.5
    assert (np.abs(x[:, 1]) < 0.33).all()
    assert x[:, 2].min() > -0.03
