"""Snow in the shape of a mesh: where it is, how much, how deep, and what cannot be filled."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshes
import numpy as np
import pytest

from neve.sampling import fill
from neve.sampling.filling import measured_volume, mesh_space
from neve.sampling.regions import region
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.schema.scene import Numerics, Profile, Source

SAMPLINGS: list[Any] = ["jittered", "poisson", "regular"]
FINE = Numerics(dx=0.05)


def source(mesh: Any, folder: Path, **keys: Any) -> Source:
    """Return a source of the snow in a mesh of trimesh."""
    return Source.of("mesh", file=meshes.written(mesh, folder / "snow.ply"), **keys)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_mass_and_count(sampling: Any, tmp_path: Path) -> None:
    """The volume is the polyhedron's, to the file's single precision; n = 8 V / dx^3 within 5 %."""
    ball = meshes.ball(0.4)
    samples = fill(source(ball, tmp_path), Numerics(dx=0.05, sampling=sampling), 0)
    assert samples.volume.sum() == pytest.approx(ball.volume, rel=1e-6)
    assert np.ptp(samples.volume) == 0.0
    assert len(samples.x) == pytest.approx(8 * ball.volume / 0.05**3, rel=0.05)
    assert np.linalg.norm(samples.x, axis=1).max() < 0.4


def test_the_same_snow_as_a_box(tmp_path: Path) -> None:
    """A box from a file is filled with the very particles of a box: place, turn, spin, factors of depth.

    The distance is linear at the faces, and jittered points keep 0.15 spacings from them; single precision of
    the corners moves points by 1e-7.
    """
    place: dict[str, Any] = {
        "rotation": (10.0, 20.0, 30.0),
        "velocity": (1.0, 2.0, 3.0),
        "spin": (3.0, 2.0, 1.0),
    }
    profile = Profile(at=(0.0, 0.2), stiffness=(1.0, 3.0))
    snow = source(meshes.box(0.5, 0.8, 0.6), tmp_path, center=(3.0, 2.0, 1.0), profile=profile, **place)
    own = Source.of("box", size=(0.5, 0.8, 0.6), center=(3.0, 2.0, 1.0), profile=profile, **place)
    a, b = fill(snow, FINE, 0), fill(own, FINE, 0)
    assert len(a.x) == len(b.x)
    assert a.x == pytest.approx(b.x, abs=1e-6)
    assert a.v == pytest.approx(b.v, abs=1e-5)
    assert a.volume == pytest.approx(b.volume, rel=1e-6)
    deep = b.stiffness > 1.5  # ridges between the faces' domains are rounded within a spacing
    assert a.stiffness[deep] == pytest.approx(b.stiffness[deep], abs=0.2)


def test_origin_and_spin_are_those_of_the_file(tmp_path: Path) -> None:
    """A box that stands beside its file's origin: `center` moves the origin, and the spin is about it."""
    box = meshes.box(0.4, 0.4, 0.4)
    box.apply_translation([1.0, 0.0, 0.2])
    snow = source(box, tmp_path, center=(0.0, 5.0, 0.0), rotation=(0.0, 0.0, 90.0), spin=(0.0, 0.0, 2.0))
    samples = fill(snow, FINE, 0)
    assert samples.x.min(axis=0) == pytest.approx([-0.2, 5.8, 0.0], abs=0.02)
    assert samples.x.max(axis=0) == pytest.approx([0.2, 6.2, 0.4], abs=0.02)
    x, y, _ = (samples.x - [0.0, 5.0, 0.0]).T
    assert samples.v == pytest.approx(np.stack([-2 * y, 2 * x, 0 * x], axis=1))
    assert region(snow, FINE, "sources.0").lowest == pytest.approx(0.0, abs=1e-7)


def test_depth_of_a_ball(tmp_path: Path) -> None:
    """Depth is r - |x|: near the surface to the facets' sagitta, 0.5 %, plus h^2 / r; deep inside to the
    coarse grid's 8 h: a cone that is blended over 0.2 m loses up to a quarter of that at its tip.
    """
    profile = Profile(at=(0.0, 1.0), stiffness=(1.0, 2.0))
    samples = fill(source(meshes.ball(0.6), tmp_path, profile=profile), FINE, 0)
    depth, exact = samples.stiffness - 1.0, 0.6 - np.linalg.norm(samples.x, axis=1)
    near = exact < 0.1
    assert depth[near] == pytest.approx(exact[near], abs=0.005)
    assert depth[~near] == pytest.approx(exact[~near], abs=0.06)


def test_overlapping_parts_count_once(tmp_path: Path) -> None:
    """Two boxes of edge a, one moved by 3 a / 4: V = 1.75 a^3, of which the faces wind twice around a^3 / 4.

    The overlap is one part in seven of the length, measured with 24 layers of points: off by half a layer at
    most, 0.5 / 24 of 1.75.
    """
    a, b = meshes.box(0.4, 0.4, 0.4), meshes.box(0.4, 0.4, 0.4)
    b.apply_translation([0.3, 0.0, 0.0])
    samples = fill(source(meshes.joined(a, b), tmp_path), FINE, 0)
    assert samples.volume.sum() == pytest.approx(1.75 * 0.4**3, rel=0.5 / 24)
    assert len(samples.x) == pytest.approx(8 * 1.75 * 0.4**3 / 0.05**3, rel=0.05)


def test_cavity_stays_empty(tmp_path: Path) -> None:
    """A hollow ball of snow: no particle in the cavity, and the mass of the shell."""
    outer, inner = meshes.ball(0.5), meshes.ball(0.3)
    inner.invert()
    samples = fill(source(meshes.joined(outer, inner), tmp_path), FINE, 0)
    assert samples.volume.sum() == pytest.approx(outer.volume + inner.volume, rel=1e-6)
    assert np.linalg.norm(samples.x, axis=1).min() > 0.29


def test_measured_volume(tmp_path: Path) -> None:
    """Where nothing exact is known the inside is measured: a ball of r = 16 h within (h / r)^2 = 0.4 %."""
    space = mesh_space(source(meshes.ball(0.4, 4), tmp_path), FINE, "sources.0")
    measured = measured_volume(space.mesh, space.low, space.high)
    assert measured == pytest.approx(space.volume, rel=0.004)


def test_holes_and_sheets(tmp_path: Path) -> None:
    """A mesh with small holes is filled, with a warning; a sheet with a thickness is a wall of snow."""
    holed = meshes.without(meshes.ball(0.4), 5)
    with pytest.warns(SceneWarning, match="small holes"):
        samples = fill(source(holed, tmp_path), FINE, 0)
    assert samples.volume.sum() == pytest.approx(meshes.ball(0.4).volume, rel=0.02)
    with pytest.raises(SceneError, match=r"^sources\.3\.file = .* is open .* set sources\.3\.thickness"):
        fill(source(meshes.sheet(1.0), tmp_path), FINE, 3)
    wall = fill(source(meshes.sheet(1.0), tmp_path, thickness=0.2), FINE, 0)
    rim = 4 * 1.0 * np.pi / 2 * 0.1**2 + 4 / 3 * np.pi * 0.1**3
    assert wall.volume.sum() == pytest.approx(0.2 + rim, rel=0.02)
    assert np.abs(wall.x[:, 2]).max() == pytest.approx(0.1, abs=0.02)


def test_too_small_for_a_particle(tmp_path: Path) -> None:
    """A mesh that holds no particle is told like any other source."""
    numerics = Numerics(dx=0.05, sampling="poisson")
    with (
        pytest.warns(SceneWarning, match="less than two cells"),
        pytest.raises(SceneError, match="too small for"),
    ):
        fill(source(meshes.ball(0.001), tmp_path), numerics, 0)


def test_seeds_and_shapes_beside_meshes(tmp_path: Path) -> None:
    """Equal arguments give equal bits, also from the cache; other sources are where they were."""
    snow = source(meshes.ball(0.3), tmp_path)
    a, b = fill(snow, FINE, 0), fill(snow, FINE, 0)
    assert np.array_equal(a.x, b.x)
    assert np.linalg.norm(fill(Source.of("sphere", radius=0.3), FINE, 0).x - [0, 0, 0.5], axis=1).max() <= 0.3
