"""Mesh and terrain colliders move as their simple shapes do: place, surface velocity, what snow feels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshes
import numpy as np
import pytest

from neve.mpm.initial import make_model
from neve.scene.reading.load import scene_from
from neve.simulation import Simulation

TURN = [
    {"t": 0.0, "position": [0.3, 0.0, 0.1], "rotation": [0, 0, 0]},
    {"t": 0.5, "position": [0.3, 0.2, 0.1], "rotation": [0, 0, 90]},
]
PUSH = [{"t": 0.0, "position": [0.3, 0.0, 0.1]}, {"t": 0.5, "position": [-0.7, 0.1, 0.1]}]
SIZE = (0.5, 0.9, 0.9)


def scene(keys: Any, collider: dict[str, Any]) -> Any:
    """Return a scene in which a paddle moves by `keys` into a block of snow, without gravity."""
    return scene_from(
        {
            "world": {"gravity": [0, 0, 0]},
            "numerics": {"dx": 0.1, "precision": "float64", "dt": 1e-3},
            "sources": [{"shape": "box", "center": [-0.25, 0, 0.1], "size": [0.5, 0.8, 0.5]}],
            "colliders": [{"keyframes": keys, **collider}],
        }
    )


@pytest.mark.parametrize("time", [0.0, 0.1, 0.37, 0.6])
def test_a_moving_mesh_is_where_its_keyframes_are(time: float, tmp_path: Path) -> None:
    """phi and normal at points of the world are those of the box of the same keyframes: single precision.

    The grid is linear where the box's nearest face is the same all around: at points 0.1 m or less from the
    middle of a face, seen from the box.
    """
    path = meshes.written(meshes.box(*SIZE), tmp_path / "a.ply")
    box = make_model(scene(TURN, {"shape": "box", "size": list(SIZE)}))
    mesh = make_model(scene(TURN, {"shape": "mesh", "file": path}))
    rng = np.random.default_rng(0)
    local = rng.uniform(-0.1, 0.1, (60, 3))
    axis, side = np.arange(60) % 3, np.where(np.arange(60) % 2, 0.5, -0.5)
    local[np.arange(60), axis] = side * np.array(SIZE)[axis] + rng.uniform(-0.04, 0.04, 60)
    [pose] = box.poses(time)
    x = np.ascontiguousarray(local @ pose.rotation.T + pose.position)
    for model in (box, mesh):
        model.native.place_solid(0, pose.position, pose.rotation, pose.velocity, pose.omega)
    (phi, normal), (phi_m, normal_m) = (model.native.surface(0, x) for model in (box, mesh))
    assert phi_m == pytest.approx(phi, abs=1e-6)
    assert normal_m == pytest.approx(normal, abs=1e-5)


@pytest.mark.parametrize(("mode", "keys"), [("sticky", TURN), ("separate", PUSH)], ids=["turn", "push"])
def test_snow_feels_a_moving_mesh_as_a_moving_box(mode: str, keys: Any, tmp_path: Path) -> None:
    """A paddle turns into snow that sticks to it, or pushes it with its face, as one of simple shape does.

    Sticky nodes get the velocity v + omega x r of the body, which knows no mesh; before a face the normal is
    the face's. What differs is which nodes count as inside at an edge, where the grid of distances is rounded
    by its spacing: 0.05 m of the face's half length 0.45 m, of which only the nearest edge touches snow: 5 %.
    """
    path = meshes.written(meshes.box(*SIZE), tmp_path / "a.ply")
    box = Simulation(scene(keys, {"shape": "box", "size": list(SIZE), "mode": mode}), threads=1)
    mesh = Simulation(scene(keys, {"shape": "mesh", "file": path, "mode": mode}), threads=1)
    for sim in (box, mesh):
        sim.advance(0.1)
    p, p_m = (np.asarray(sim.diagnostics().momentum) for sim in (box, mesh))
    assert np.linalg.norm(p) > 1.0, "the paddle has hit the snow"
    assert p_m == pytest.approx(p, abs=0.05 * float(np.linalg.norm(p)))
    assert mesh.exchanged[0] == pytest.approx(
        box.exchanged[0], abs=0.05 * float(np.abs(box.exchanged[0]).max())
    )
    order = [np.argsort(np.asarray(sim.state.id)) for sim in (box, mesh)]
    v, v_m = (np.asarray(sim.state.v)[i] for sim, i in zip((box, mesh), order, strict=True))
    assert np.linalg.norm(v_m - v) < 0.05 * np.linalg.norm(v)


def test_flat_terrain_is_a_plane(tmp_path: Path) -> None:
    """A terrain of one slope stands for its plane: snow that falls on it moves the same.

    phi = (z - h) n_z of a plane is its distance; heights are single precision, 6e-8 of 1 m, and a difference
    of that size may put a node on the other side, which moves it by what its contact is worth in one step.
    """
    np.save(tmp_path / "a.npy", np.array([[-0.2, -0.2], [0.2, 0.2]]))
    slope = 0.4 / 2.0
    tables: dict[str, Any] = {
        "numerics": {"dx": 0.05, "precision": "float64"},
        "sources": [{"shape": "sphere", "center": [0, 0, 0.25], "radius": 0.2, "velocity": [0, 0, -3]}],
    }
    plane = {"shape": "plane", "normal": [-slope, 0, 1]}
    ground = {"shape": "terrain", "file": str(tmp_path / "a.npy"), "size": [2, 2]}
    runs = [Simulation(scene_from({**tables, "colliders": [c]}), threads=1) for c in (plane, ground)]
    for sim in runs:
        sim.advance(0.05)
    x, x_m = (np.asarray(sim.state.x)[np.argsort(np.asarray(sim.state.id))] for sim in runs)
    assert len(x) == len(x_m)
    assert x_m == pytest.approx(x, abs=1e-4)
    assert runs[1].exchanged[0, 2] == pytest.approx(runs[0].exchanged[0, 2], rel=1e-3)
    assert runs[0].exchanged[0, 2] < -1.0, "the ball has hit the ground"
