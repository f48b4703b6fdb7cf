"""A source that takes too many particles or too much memory is told before anything is computed or filled."""

import re
import sys

import numpy as np
import pytest

from neve import Simulation, _core
from neve import build as scene_build
from neve.mpm import initial
from neve.sampling import fill
from neve.sampling.emitters.section import Section
from neve.sampling.emitters.stream import stream
from neve.sampling.room import (
    MOST,
    PARTICLE_BYTES,
    STATE_BYTES,
    expected,
    require_room,
    require_room_for_all,
)
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Scene
from neve.system import memory


def scene(dx, **source):
    """A scene of one source."""
    return Scene.model_validate({"numerics": {"dx": dx}, "sources": [source]})


def told(scene):
    """The sentence with which the source is refused."""
    with pytest.raises(SceneError) as caught:
        fill(scene.sources[0], scene.numerics, 0)
    return str(caught.value)


def test_the_number_that_is_too_large_is_the_one_that_is_told():
    """Thin layers, balls and boxes: no sentence says that a smaller number is more than a larger one."""
    for source in (
        {"shape": "layer", "size": [1e4, 1e4], "depth": 1e-3},
        {"shape": "sphere", "radius": 17.0},
        {"shape": "box", "size": [1e5, 1e-8, 1e5]},
        {"shape": "text", "text": "A B" * 20, "height": 8.0, "depth": 30.0},
    ):
        said = told(scene(0.1, **source))
        numbers = [float(n) for n in re.findall(r"([0-9.]+e\+[0-9]+) (?:particles|points)", said)]
        assert max(numbers) >= MOST * 0.98, said
        assert "more than 2.7e+08" in said


@pytest.fixture
def cube(tmp_path):
    """The path of a cube of edge 1 m."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [(1, 3, 2), (2, 3, 4), (5, 6, 7), (6, 8, 7), (1, 2, 5), (2, 6, 5)]
    faces += [(3, 7, 4), (4, 7, 8), (1, 5, 3), (3, 5, 7), (2, 4, 6), (4, 8, 6)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in faces]
    (tmp_path / "cube.obj").write_text("\n".join(lines))
    return str(tmp_path / "cube.obj")


def test_a_mesh_is_refused_before_distances_to_it_are_computed(cube, monkeypatch):
    """1e9 particles in a cube of 1 m: the volume tells, and no grid is built."""

    def build(*_):
        pytest.fail("a grid of distances was built")

    monkeypatch.setattr(_core.geometry.SdfGrid, "build", build)
    said = told(scene(2e-3, shape="mesh", file=cube, up="z"))
    assert said.startswith("sources.0 would take 1e+09 particles with numerics.dx = 0.002, more than 2.7e+08")


def test_memory_is_asked_for_before_it_is_taken(monkeypatch):
    """8e6 particles need about 2 GB, and 1 GB is free: one sentence with both numbers."""
    need = 8e6 * PARTICLE_BYTES
    monkeypatch.setattr(memory, "free", lambda: int(need / 2))
    said = told(scene(0.01, shape="box", size=[1, 1, 1]))
    assert re.search(
        r"8e\+06 particles with numerics.dx = 0.01, which needs about 2\.\d+ GB of memory, and 960 MB", said
    )
    monkeypatch.setattr(memory, "free", lambda: None)
    assert memory.lacking(1e18) is None


@pytest.mark.parametrize(
    ("dx", "free", "said"),
    [
        (2e-3, None, r"emitters\.0 has a section of 1e\+12 particles .* more than 2\.7e\+08; use a larger"),
        (0.2, 10**9, r"emitters\.0 has a section of 1e\+08 particles .* needs about 20 GB .* 1 GB are free"),
    ],
)
def test_the_section_of_an_emitter_is_asked_for_before_it_is_laid_out(dx, free, said, monkeypatch):
    """A pipe of 1 km across: its cells were laid out one by one, whatever memory there was."""
    monkeypatch.setattr(memory, "free", lambda: free)
    monkeypatch.setattr(Section, "grid", lambda *_: pytest.fail("the section was laid out"))
    pipe = {"shape": "box", "size": [1000.0, 1000.0, 1.0], "velocity": [0.0, 0.0, -1.0]}
    whole = Scene.model_validate({"numerics": {"dx": dx}, "emitters": [pipe]})
    with pytest.raises(SceneError, match=said):
        stream(whole, 0)


def test_sources_that_fit_one_by_one_may_not_fit_together(monkeypatch):
    """Ten boxes of 1e6 particles: 10 GB are enough for the largest, 1 GB is not enough for all."""
    box = {"shape": "box", "size": [0.5, 0.5, 0.5]}
    many = {"numerics": {"dx": 0.01}, "sources": [box | {"center": [i, 0.0, 0.0]} for i in range(10)]}
    whole = Scene.model_validate(many)
    monkeypatch.setattr(memory, "free", lambda: 10**9)
    assert 0.9e6 < expected(whole.sources[0], whole.numerics) < 1.1e6
    require_room(np.full(3, 0.5), 0.125, whole.numerics, "sources.0")
    monkeypatch.setattr(scene_build, "filled", lambda *_: pytest.fail("a source was filled"))
    with pytest.raises(
        SceneError, match=r"all sources together would take 1e\+07 particles .* 1 GB are free"
    ):
        initial.build(whole)


def test_particles_are_asked_for_again_when_their_number_is_known(monkeypatch):
    """What stands in files counts as well: after filling, the arrays of the simulation are asked for."""
    numerics = scene(0.1, shape="box").numerics
    bytes_each = STATE_BYTES["float32"]
    monkeypatch.setattr(memory, "free", lambda: int(1e6 * bytes_each))
    require_room_for_all(0.9e6, numerics, held=True)
    with pytest.raises(SceneError, match="needs about"):
        require_room_for_all(1e6, numerics, held=True)
    with pytest.raises(SceneError, match=r"more than 2\.1e\+09"):
        require_room_for_all(3e9, numerics)


@pytest.mark.parametrize("precision", STATE_BYTES)
def test_a_simulation_takes_no_more_memory_than_is_asked_for(precision):
    """Arrays of the state and what steps need besides, for each particle."""
    box = {"shape": "box", "size": [1.0, 1.0, 1.0]}
    sim = Simulation(scene_from({"numerics": {"dx": 0.05, "precision": precision}, "sources": [box]}))
    sim.advance(1e-4)
    assert 0.5 * STATE_BYTES[precision] < sim.bytes / sim.count < 1.1 * STATE_BYTES[precision]


def test_what_is_free_is_known_here():
    """Linux says what is available: more than nothing, less than an exabyte."""
    if sys.platform == "linux":
        assert 1e6 < memory.free() < 1e18


@pytest.mark.parametrize("version", [1, 2])
def test_limits_of_containers_count(version, tmp_path):
    """The tightest group of the process and those above it: limit - use + cached files."""
    told, root = tmp_path / "cgroup", tmp_path / "fs"
    if version == 2:
        told.write_text("0::/outer/inner\n")
        home, names = root, ("memory.max", "memory.current", "inactive_file")
    else:
        told.write_text("3:cpu,cpuacct:/\n2:memory:/outer/inner\n")
        home, names = (
            root / "memory",
            ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
        )
    (home / "outer" / "inner").mkdir(parents=True)
    none = "max" if version == 2 else str(2**63 - 4096)
    for place, limit, use, cached in (
        (home / "outer", "1000", "700", 200),
        (home / "outer/inner", none, "600", 9),
    ):
        (place / names[0]).write_text(f"{limit}\n")
        (place / names[1]).write_text(f"{use}\n")
        (place / "memory.stat").write_text(f"anon 1\n{names[2]} {cached}\n")
    assert list(memory._groups(told, root)) == [500]
    told.write_text("0::/../elsewhere\n")
    assert list(memory._groups(told, root / "nothing")) == []


def test_a_damaged_font_is_named(tmp_path):
    """Whatever its reader stumbles over, the sentence has the key and the file."""
    from neve.sampling.fonts import FONT

    rng = np.random.default_rng(0)
    whole = FONT.read_bytes()
    refused = []
    for trial in range(20):
        damaged = bytearray(whole)
        for place in rng.integers(0, len(whole), 400):
            damaged[place] = rng.integers(256)
        path = tmp_path / f"{trial}.ttf"
        path.write_bytes(damaged)
        try:
            one = scene(0.1, shape="text", text="NEVE gQ", font=str(path), height=0.5)
            fill(one.sources[0], one.numerics, 0)
        except SceneError as error:
            refused.append((str(error), path.name))
    assert len(refused) > 5
    for said, name in refused:
        assert said.startswith(("sources.0.font = ", "sources.0.text: "))
        assert name in said


def test_a_needle_does_not_take_more_memory_than_a_grid_may(cube, monkeypatch):
    """One corner 300 km away: to the bricks of the grid its spike is a line, which its area does not tell."""
    from pathlib import Path

    from neve.geometry import sdf

    monkeypatch.setenv("NEVE_CACHE", "")
    monkeypatch.setattr(sdf, "DEFAULT_BYTES", 8 * 2**20)
    text = Path(cube).read_text().replace("v 1 1 1", "v 1 1 300000")
    Path(cube).write_text(text)
    source = scene(0.25, shape="mesh", file=cube, up="z").sources[0]
    with pytest.warns(match="detail is"):
        mesh = sdf.solid_mesh(source, 0.25, "sources.0")
    assert 0 < mesh.sdf.bytes <= sdf.DEFAULT_BYTES
