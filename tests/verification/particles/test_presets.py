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


def test_wall_plough_pushes_snow_together():
    """Before the wall there is more snow than lay there, and denser; behind it the ground is swept."""
    sim = start("wall_plough", "numerics.dx=0.12")
    first, mass = np.array(sim.state.x), sim.diagnostics().mass
    sim.advance(1.8)
    x, J = np.asarray(sim.state.x), np.asarray(sim.state.J_P)
    wall = sim.solids()[1][1].position[0] + 0.07

    def ahead(x):
        return (np.abs(x[:, 1]) < 0.6) & (x[:, 0] > wall) & (x[:, 0] < wall + 0.6)

    behind = (np.abs(x[:, 1]) < 0.5) & (x[:, 0] < wall - 0.2)
    assert ahead(x).sum() > 1.15 * ahead(first).sum()
    assert behind.sum() < 0.1 * ahead(x).sum()
    assert J[ahead(x)].min() < 0.95
    assert sim.diagnostics().mass == mass


def test_snowman_melts_under_his_hat():
    """The sun makes water of him, the balance holds, and the hat comes down."""
    sim = start("melt", "numerics.dx=0.12", "heat.heat_speed=40000.0")

    def hat():
        """The height of his hat [m]."""
        return next(pose.position[2] for solid, pose in sim.solids() if solid.name == "bodies.0")

    first, high = sim.diagnostics(), hat()
    sim.advance(1.5)
    now = sim.diagnostics()
    assert now.water > 0.15 * now.mass
    assert now.heat - first.heat == pytest.approx(now.heat_taken, rel=1e-9)
    assert hat() < high - 0.1
    assert sim.scene.caption == "heat x 40000 real time"


def test_boots_leave_prints():
    """Where the first boot stood snow is gone, and denser than beside it."""
    sim = start("walk_live", "numerics.dx=0.08")
    sim.advance(0.85)
    x, J = np.asarray(sim.state.x), np.asarray(sim.state.J_P)
    print_ = (np.abs(x[:, 0] + 0.7) < 0.06) & (np.abs(x[:, 1] + 0.075) < 0.03)
    beside = (np.abs(x[:, 0] + 0.7) < 0.06) & (np.abs(x[:, 1] - 0.3) < 0.06)
    assert x[print_, 2].max(initial=0.0) < 0.8 * x[beside, 2].max()
    assert J[print_].mean() < 0.97 * J[beside].mean()


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
