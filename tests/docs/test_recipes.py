"""The recipes do what their page says, on coarser cells."""

import re
import runpy
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from neve import Simulation
from neve.scene.reading.load import load

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples/recipes"


class Recipe:
    """A simulation of a recipe, with its first mass and its particles by their number."""

    def __init__(self, name):
        self.sim = Simulation(load(FOLDER / f"{name}.toml", ["numerics.dx=0.05"]))
        self.mass = self.sim.diagnostics().mass

    def to(self, time):
        """Positions and velocities at `time` [s]; all snow is there."""
        if time > self.sim.time:
            self.sim.advance(time - self.sim.time)
        assert self.sim.diagnostics().mass == pytest.approx(self.mass, rel=1e-6)
        order = np.argsort(self.sim.state.id)
        return (np.asarray(a, np.float64)[order] for a in (self.sim.state.x, self.sim.state.v))


@cache
def page():
    return (ROOT / "docs/recipes.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["conveyor", "drum", "container", "cannon"])
def test_the_page_has_the_scene(name):
    """Word for word, and its command."""
    scenes = re.findall(r"```toml\n(.*?)```", page(), flags=re.DOTALL)
    assert (FOLDER / f"{name}.toml").read_text(encoding="utf-8") in scenes
    assert f"    neve run examples/recipes/{name}.toml\n" in page()


def test_the_meshes_are_those_of_their_program(tmp_path):
    """Byte for byte."""
    program = tmp_path / "meshes.py"
    program.write_bytes((FOLDER / "meshes.py").read_bytes())
    runpy.run_path(str(program), run_name="__main__")
    made = {path.name: path.read_bytes() for path in tmp_path.glob("*.obj")}
    assert made == {path.name: path.read_bytes() for path in FOLDER.glob("*.obj")}


def test_the_conveyor_carries_snow():
    """It moves up the belt with its speed, and at the end all lies on the floor beyond it."""
    recipe = Recipe("conveyor")
    a = np.radians(10)
    up = np.array([np.cos(a), 0.0, np.sin(a)])
    x, v = recipe.to(0.8)
    assert (v @ up).mean() == pytest.approx(1.2, rel=0.02)
    assert np.abs(v - 1.2 * up).mean() < 0.05
    later, _ = recipe.to(1.0)
    np.testing.assert_allclose((later - x).mean(axis=0), 0.2 * 1.2 * up, atol=0.01)
    x, _ = recipe.to(3.0)
    assert (x[:, 0] > 1.28 - 0.05).mean() > 0.99
    assert np.quantile(x[:, 2], 0.99) < 0.6
    assert recipe.sim.exchanged[0, 6] > 0  # work of the belt: friction, and the way up


def test_snow_avalanches_in_the_drum_and_none_is_lost():
    """All stays between the walls; it is carried up one side and slides down over itself, again and again."""
    recipe = Recipe("drum")
    down, angles = [], []
    for t in np.arange(0.5, 5.0, 0.1):
        x, v = recipe.to(t)
        r = np.hypot(x[:, 0], x[:, 2] - 0.7)
        assert r.max() < 0.5 + 0.01
        assert np.abs(x[:, 1]).max() < 0.25 + 0.01
        angles.append(np.degrees(np.arctan2(-x[:, 0].mean(), 0.7 - x[:, 2].mean())))
        around = (v[:, 0] * (x[:, 2] - 0.7) - v[:, 2] * x[:, 0]) / np.maximum(r, 0.05)  # > 0 with the wall
        down.append((around < -0.3).mean())
    assert 40 < np.mean(angles) < 90  # up the side that rises
    slides = np.count_nonzero(np.diff((np.array(down) > 0.25).astype(int)) == 1)
    assert slides >= 3
    assert np.mean(np.array(down) < 0.05) > 0.3  # between them it rides on the wall


def test_the_bin_fills_keeps_and_is_tipped():
    """All is within its walls at 1.1 s and rests; at the end it lies on the floor, and the bin is empty."""
    recipe = Recipe("container")
    x, v = recipe.to(1.1)
    low, high = np.array([-0.9, -0.3, 0.7]), np.array([-0.1, 0.3, 1.3])
    assert ((x > low - 0.01) & (x < high + 0.01)).all()
    assert np.linalg.norm(v, axis=1).mean() < 0.1
    weight = recipe.mass * 9.81
    recipe.to(1.15)
    assert recipe.sim.stats.exchanged[0, 2] / 0.05 == pytest.approx(-weight, rel=0.1)
    x, v = recipe.to(3.2)
    assert (x[:, 0] > 0.3).mean() > 0.99
    assert np.quantile(x[:, 2], 0.99) < 0.5
    assert np.linalg.norm(v, axis=1).mean() < 0.1


def test_the_cannon_hits_where_it_aims():
    """At 7 m/s, 40 degrees up from 1.34 m, snow lands 5.5 m on, round x = 2.9 m; the books close."""
    sim = Simulation(load(FOLDER / "cannon.toml", ["numerics.dx=0.1"]))
    sim.advance(1.6)
    now = sim.diagnostics()
    assert now.emitted_mass == pytest.approx(1.6 * 30.0, rel=0.02)
    assert now.mass == pytest.approx(now.emitted_mass - now.removed_mass, rel=1e-9)
    x = np.asarray(sim.state.x, np.float64)
    landed = x[x[:, 2] < 0.1]
    assert len(landed) > 0.1 * len(x)
    assert np.median(landed[:, 0]) == pytest.approx(2.9, abs=0.7)
    assert x[:, 2].max() < 1.34 + 4.5**2 / (2 * 9.81) + 1.5
