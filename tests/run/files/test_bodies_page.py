"""docs/bodies.md: each of its scenes runs, and does what the page says."""

import re
from pathlib import Path

import numpy as np
import pytest

from neve.run import painter, run_scene
from neve.scene.reading.load import load
from neve.simulation import Simulation

PAGE = (Path(__file__).parents[3] / "docs/bodies.md").read_text(encoding="utf-8")
BALL, GATE, WHEEL, ROBOT = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
COARSE = ["numerics.dx=0.1", "run.film=false"]

CAR = """<mujoco><worldbody><body name="car" pos="0 0 .1"><freejoint/>
  <geom name="hull" type="box" size=".2 .1 .05"/>
  <body name="wheel" pos="0 .15 0" quat="1 1 0 0"><joint name="axle" axis="0 0 -1"/>
    <geom type="cylinder" size=".1 .03"/></body></body></worldbody>
  <asset><mesh name="tip" file="parts/tip.obj"/></asset>
  <actuator><velocity name="drive" joint="axle" kv="1" ctrlrange="0 10"/></actuator></mujoco>"""
TIP = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def simulation(text, folder):
    path = folder / "scene.toml"
    path.write_text(text)
    return Simulation(load(path, COARSE), threads=1)


def place(sim, body):
    """The pose of a body by its name."""
    return next(pose for solid, pose in sim.solids() if solid.name == body)


def test_ball_falls_on_a_layer(tmp_path):
    """It falls freely from 0.6 m at 2 m/s, and the snow has slowed it down 0.3 s later."""
    sim = simulation(BALL, tmp_path)
    sim.advance(0.1)
    assert place(sim, "bodies.0").velocity[2] == pytest.approx(-2 - 0.981, rel=1e-5)
    sim.advance(0.2)
    assert np.abs(place(sim, "bodies.0").velocity[2]) < 1.0
    assert 0.05 < place(sim, "bodies.0").position[2] < 0.3


def test_gate_swings(tmp_path):
    """Snow that comes from the right pushes the gate to the left: it turns about +y by some degrees."""
    sim = simulation(GATE, tmp_path)
    sim.advance(0.1)
    assert place(sim, "bodies.0").omega[1] > 0.2
    assert place(sim, "bodies.0").position[0] < -0.1


def test_wheel_turns_once_it_is_down(tmp_path):
    """It is still until 0.2 s but for what the snow turns, and near 6 rad/s after 0.5 s."""
    sim = simulation(WHEEL, tmp_path)
    sim.advance(0.15)
    assert np.abs(place(sim, "bodies.1").omega).max() < 0.5
    assert place(sim, "bodies.1").position[2] < 0.4
    sim.advance(0.5)
    assert place(sim, "bodies.1").omega[1] == pytest.approx(6.0, rel=0.2)


def test_robot_goes_with_its_run(tmp_path, monkeypatch):
    """The robot of the page is found beside the scene; its run can be moved and gone on with elsewhere."""
    monkeypatch.setattr(painter, "SIZE", (64, 36))
    (tmp_path / "home" / "parts").mkdir(parents=True)
    (tmp_path / "home" / "car.xml").write_text(CAR)
    (tmp_path / "home" / "parts" / "tip.obj").write_text(TIP)
    text = f'{ROBOT}\n[[sources]]\nshape = "box"\nsize = [0.3, 0.3, 0.2]\ncenter = [0.5, 0, 0.1]\n'
    path = tmp_path / "home" / "scene.toml"
    path.write_text(f'{text}\n[[colliders]]\nshape = "plane"\n')
    scene = load(path, [*COARSE, "run.fps=100"])
    whole = run_scene(scene, tmp_path / "whole", threads=1, frames=4, quiet=True)
    run_scene(scene, tmp_path / "away", threads=1, frames=2, quiet=True)
    (tmp_path / "home").rename(tmp_path / "gone")
    moved = (tmp_path / "away").rename(tmp_path / "there")
    parted = run_scene(load(moved), moved, threads=1, frames=4, resume=True, quiet=True)
    assert [solid.name for solid, _ in parted.solids()] == ["colliders.0", "robots.0.hull", "robots.0.wheel"]
    assert np.array_equal(
        whole.solver.model.rigid.save()["engine"], parted.solver.model.rigid.save()["engine"]
    )
    rows = [(tmp_path / name / "solids.csv").read_bytes() for name in ("whole", "there")]
    assert rows[0] == rows[1]
