"""`solids.csv`: places, motions and forces of all solids in every frame, and a resume."""

import csv

import numpy as np
import pytest

from neve.run import run_scene
from neve.scene.schema.scene import Scene
from neve.simulation import Simulation


@pytest.fixture
def falling():
    """Snow that falls on a slope below a plate that sinks and turns."""
    return Scene.model_validate(
        {
            "numerics": {"dx": 0.1, "precision": "float64"},
            "sources": [{"shape": "box", "size": [0.4] * 3, "center": [0, 0, 0.3], "velocity": [0, 0, -1]}],
            "colliders": [
                {"shape": "plane", "normal": [0.1, 0.0, 1.0]},
                {"shape": "box", "size": [1, 1, 0.2], "center": [0, 0, 0.65], "velocity": [0, 0, -1],
                 "spin": [0, 0, 2]},
            ],
            "run": {"fps": 50, "duration": 0.12, "film": False},
        }
    )  # fmt: skip


def table(out):
    with open(out / "solids.csv", newline="") as file:
        return list(csv.DictReader(file))


def vectors(rows, solid, name):
    """The vectors `name` of a solid, a row for each frame."""
    return np.array([[float(row[f"{name}{c}"]) for c in "xyz"] for row in rows if row["solid"] == solid])


def test_rows_tell_places_and_forces(falling, tmp_path):
    """The plate is where its script has it, and the forces are those that moved the snow.

    Sum of force / fps over frames and solids = momentum of the snow before - after + m g t: in double
    precision to 1e-12 of the weight's impulse.
    """
    before = Simulation(falling, threads=1).diagnostics()
    sim = run_scene(falling, tmp_path / "run", threads=1, quiet=True)
    rows = table(tmp_path / "run")
    assert [(row["frame"], row["solid"]) for row in rows] == [
        (str(k), f"colliders.{i}") for k in range(7) for i in (0, 1)
    ]
    assert vectors(rows, "colliders.1", "")[6] == pytest.approx([0, 0, 0.65 - 0.12])
    half = 0.5 * 2.0 * 0.12
    last = rows[-1]
    assert [float(last[f"rotation_{c}"]) for c in "wxyz"] == pytest.approx([np.cos(half), 0, 0, np.sin(half)])
    assert [float(last[f"velocity_{c}"]) for c in "xyz"] == [0, 0, -1]
    assert [float(last[f"omega_{c}"]) for c in "xyz"] == [0, 0, 2]
    assert all(row["force_x"] == row["torque_z"] == "" for row in rows[:2])
    total = sum(
        vectors(rows[2:], solid, "force_").sum(axis=0) / 50 for solid in ("colliders.0", "colliders.1")
    )
    after = sim.diagnostics()
    weight = after.mass * 9.81 * 0.12 * np.array([0.0, 0.0, -1.0])
    assert np.linalg.norm(total) > 0.1 * np.linalg.norm(weight)
    lost = np.subtract(before.momentum, after.momentum)
    assert total == pytest.approx(lost + weight, abs=1e-12 * np.abs(weight).max())


def test_stopping_changes_nothing(falling, tmp_path):
    """A run that was stopped and resumed has the same rows as one in one go."""
    run_scene(falling, tmp_path / "straight", threads=1, frames=4, quiet=True)
    run_scene(falling, tmp_path / "parted", threads=1, frames=2, quiet=True)
    run_scene(falling, tmp_path / "parted", threads=1, frames=4, resume=True, quiet=True)
    texts = [(tmp_path / name / "solids.csv").read_bytes() for name in ("straight", "parted")]
    assert texts[0] == texts[1]


def test_no_solids_no_table(falling, tmp_path):
    """Snow alone in the world leaves no empty table behind."""
    run_scene(falling.model_copy(update={"colliders": ()}), tmp_path / "run", threads=1, frames=1, quiet=True)
    assert not (tmp_path / "run/solids.csv").exists()
