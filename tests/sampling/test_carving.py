"""Snow that would start inside a solid is left out, and said."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import meshes
import numpy as np
import pytest

from neve.mpm.initial import build
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.load import scene_from

SNOW = {"shape": "box", "center": [0.0, 0.0, 0.5], "size": [1.0, 1.0, 1.0]}
FINE = {"dx": 0.05}


def scene(collider: dict[str, Any], **more: Any) -> Any:
    """Return a scene of a block of snow and one collider."""
    return scene_from({"sources": [SNOW], "numerics": FINE, "colliders": [collider], **more})


INSIDE: dict[str, tuple[dict[str, Any], Any]] = {
    "plane": ({"point": [0, 0, 0.3]}, lambda x: x[:, 2] - 0.3),
    "sphere": (
        {"center": [0.5, 0, 0.5], "radius": 0.3},
        lambda x: np.linalg.norm(x - [0.5, 0, 0.5], axis=1) - 0.3,
    ),
    "box": (
        {"center": [0, 0, 1], "size": [0.4, 2, 0.6], "rotation": [0, 0, 90]},
        lambda x: np.maximum(np.abs(x[:, 1]) - 0.2, np.abs(x[:, 2] - 1) - 0.3),
    ),
    "cylinder": (
        {"center": [0, 0, 0], "radius": 0.3, "height": 0.8},
        lambda x: np.maximum(np.hypot(x[:, 0], x[:, 1]) - 0.3, np.abs(x[:, 2]) - 0.4),
    ),
}


@pytest.mark.parametrize("shape", INSIDE)
def test_snow_inside_a_shape_is_left_out(shape: str) -> None:
    """What is left lies outside, what lay outside is left, and the warning counts the others.

    Particles may lie a thousandth of a cell, 5e-5 m, inside, so that snow may lie on a surface.
    """
    keys, distance = INSIDE[shape]
    with pytest.warns(SceneWarning) as told:
        _, state, _ = build(scene({"shape": shape, **keys}))
    _, whole, _ = build(scene_from({"sources": [SNOW], "numerics": FINE}))
    x = np.asarray(whole.x, dtype=np.float64)
    outside = np.count_nonzero(distance(x) > -5e-5)
    assert distance(np.asarray(state.x, dtype=np.float64)).min() > -5e-5 - 1e-6
    assert state.count == outside
    assert [str(warning.message) for warning in told] == [
        f"sources.0 starts with {whole.count - outside} inside colliders.0, of {whole.count} particles: they "
        "are left out"
    ]
    assert state.m.sum() == pytest.approx(whole.m.sum() * outside / whole.count, rel=1e-5), (
        "the others keep their mass"
    )


def test_snow_beside_solids_is_silent() -> None:
    """Snow that lies on the ground and leans on a wall loses nothing."""
    ground = {"shape": "plane"}
    wall = {"shape": "box", "center": [1.0, 0, 0.5]}
    ball = {"shape": "sphere", "center": [0, 0, 1.5], "radius": 0.5}
    tables = {"sources": [SNOW], "numerics": FINE, "colliders": [ground, wall, ball]}
    for sampling in ("jittered", "poisson", "regular"):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            _, state, _ = build(scene_from(tables, [f"numerics.sampling={sampling}"]))
        assert state.count > 7000


def test_each_particle_counts_once() -> None:
    """Two solids over one another: a particle counts for the first; every source has a warning of its own."""
    bar = {"shape": "box", "center": [0, 0, 0.25], "size": [2, 2, 0.5]}
    tables = {
        "sources": [SNOW, SNOW | {"center": [5, 0, 0.5]}],
        "numerics": FINE | {"sampling": "regular"},
        "colliders": [bar, {"shape": "plane", "point": [0, 0, 0.75]}],
    }
    with pytest.warns(SceneWarning) as told:
        _, state, _ = build(scene_from(tables))
    assert [str(warning.message) for warning in told] == [
        "sources.0 starts with 32000 inside colliders.0 and 16000 inside colliders.1, of 64000 particles: "
        "they are left out",
        "sources.1 starts with 48000 inside colliders.1, of 64000 particles: they are left out",
    ]
    assert state.count == 32000


def test_source_wholly_inside_is_refused() -> None:
    """A source of which nothing is left is no source."""
    with pytest.raises(
        SceneError, match=r"^sources\.0 starts wholly inside colliders\.0: move one of them\.$"
    ):
        build(scene({"shape": "sphere", "center": [0, 0, 0.5], "radius": 2}))


def test_snow_inside_meshes_and_terrain(tmp_path: Path) -> None:
    """A turned box from a file carves what the same box carves, a terrain what its plane does.

    The distance grid is linear where the box's faces are flat, and a ridge is rounded within a spacing,
    dx / 2, of an edge: particles differ in a share of that of the box's inside. The plane is exact.
    """
    place: dict[str, Any] = {"center": [0.3, 0, 0.5], "rotation": [10, 20, 30]}
    path = meshes.written(meshes.box(0.5, 0.6, 0.7), tmp_path / "a.ply")
    _, exact, _ = build(scene({"shape": "box", "size": [0.5, 0.6, 0.7], **place}))
    _, state, _ = build(scene({"shape": "mesh", "file": path, **place}))
    assert state.count == pytest.approx(exact.count, abs=0.01 * (64000 - exact.count))
    np.save(tmp_path / "a.npy", np.array([[0.1, 0.1], [0.5, 0.5]]))
    terrain = {"shape": "terrain", "file": str(tmp_path / "a.npy"), "size": [1.0, 1.0], "center": [0, 0, 0.2]}
    _, state, _ = build(scene(terrain))
    x = np.asarray(state.x, dtype=np.float64)
    assert (x[:, 2] - 0.2 - 0.3 - 0.4 * x[:, 0]).min() > -1e-4
    assert state.count == pytest.approx(32000, rel=0.01), "half of the block"
