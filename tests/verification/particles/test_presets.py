"""What the presets of particles in contact promise, coarse and short."""

import warnings

import numpy as np
import pytest

import neve
from neve.scene.errors import SceneWarning


def start(name, *changes):
    """Make a coarse simulation of a preset; what a coarse grid is warned of is not told."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        return neve.Simulation(neve.load(name, list(changes)), threads=1)


def test_wall_plough_heaps_up_a_berm():
    """Ahead of the wall snow stands higher than farther on and than it lay, more of it over the same ground,
    and nearly all of it is pressed; behind the wall the ground is swept.
    """
    sim = start("wall_plough", "numerics.dx=0.08")
    before, mass = np.quantile(np.asarray(sim.state.x)[:, 2], 0.95), sim.diagnostics().mass
    sim.advance(1.8)
    x, J = np.asarray(sim.state.x), np.asarray(sim.state.J_P)
    wall = sim.solids()[1][1].position[0] + 0.07
    middle = np.abs(x[:, 1]) < 0.4
    berm = middle & (x[:, 0] > wall) & (x[:, 0] < wall + 0.6)
    beyond = middle & (x[:, 0] > wall + 0.9) & (x[:, 0] < 1.5)
    behind = middle & (x[:, 0] > wall - 0.8) & (x[:, 0] < wall - 0.2)
    top = np.quantile(x[berm, 2], 0.95)
    assert top > before + 0.025
    assert top > np.quantile(x[beyond, 2], 0.95) + 0.02
    assert berm.sum() / 0.6 > 1.3 * beyond.sum() / (1.5 - wall - 0.9)
    assert (J[berm] < 0.95).mean() > 0.85
    assert np.median(J[berm]) < 0.85 * np.median(J[beyond])
    assert behind.sum() < 0.05 * berm.sum()
    assert sim.diagnostics().mass == mass


def test_snowman_melts_under_his_hat():
    """In the sun he loses height and his hat comes down; his water runs off, far over the ground, and the
    balance of heat holds.
    """
    sim = start("melt", "numerics.dx=0.08", "heat.heat_speed=40000.0")

    def hat():
        """The height of his hat [m]."""
        return next(pose.position[2] for solid, pose in sim.solids() if solid.name == "bodies.0")

    def head():
        """The height below which 99 % of what is not water lies [m]."""
        return np.quantile(np.asarray(sim.state.x)[sim.columns()["phase"]() < 0.5, 2], 0.99)

    first, high, tall = sim.diagnostics(), hat(), head()
    wide = np.hypot(*np.asarray(sim.state.x)[:, :2].T).max()
    shares = [0.0]
    for _ in range(3):
        sim.advance(0.5)
        shares.append(sim.diagnostics().water / first.mass)
    now = sim.diagnostics()
    assert np.all(np.diff(shares) > 0.05)
    assert shares[-1] > 0.4
    assert now.heat - first.heat == pytest.approx(now.heat_taken, rel=1e-9)
    assert hat() < high - 0.1
    assert head() < tall - 0.1
    water = np.asarray(sim.state.x)[sim.columns()["phase"]() >= 1]
    assert np.median(np.hypot(*water[:, :2].T)) > wide  # half of it lies outside of where he stood
    assert np.median(water[:, 2]) < 0.05
    assert sim.scene.caption == "heat x 40000 real time"


def test_boots_leave_prints_that_stay():
    """Where the first boot stood snow is much lower and denser than beside it, and so it is 0.6 s later."""
    sim = start("walk_live", "numerics.dx=0.05")
    seen = []
    for seconds in (0.85, 0.6):
        sim.advance(seconds)
        x, J = np.asarray(sim.state.x), np.asarray(sim.state.J_P)
        print_ = (np.abs(x[:, 0] + 0.7) < 0.08) & (np.abs(x[:, 1] + 0.075) < 0.04)
        beside = (np.abs(x[:, 0] + 0.7) < 0.08) & (np.abs(x[:, 1] - 0.3) < 0.1)
        assert print_.sum() > 40
        seen.append([np.quantile(x[print_, 2], 0.9), J[print_].mean()])
        assert seen[-1][0] < 0.7 * np.quantile(x[beside, 2], 0.9)
        assert seen[-1][1] < 0.8 * J[beside].mean()
    assert seen[1] == pytest.approx(seen[0], rel=0.03)


def test_prints_of_snow_that_sleeps_are_those_of_snow_that_does_not():
    """Where the first boot stood the snow is as high, to half a radius, and as dense, to a tenth.

    Its height is that below which nine tenths lie: a loose particle that fell into the print is none of it.
    """
    height, density = [], []
    for sleep in ("true", "false"):
        sim = start("walk_live", "numerics.dx=0.08", f"numerics.sleep={sleep}")
        sim.advance(0.4)
        sim.advance(0.45)
        assert (sim.diagnostics().asleep > 0.3 * sim.count) == (sleep == "true")
        x, J = np.asarray(sim.state.x), np.asarray(sim.state.J_P)
        print_ = (np.abs(x[:, 0] + 0.7) < 0.08) & (np.abs(x[:, 1] + 0.075) < 0.04)
        height.append(np.quantile(x[print_, 2], 0.9))
        density.append(1.0 / J[print_].mean())
    assert height[0] == pytest.approx(height[1], abs=0.5 * sim.radius)
    assert density[0] == pytest.approx(density[1], rel=0.1)
