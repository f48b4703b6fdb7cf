"""What frames say of particles besides: the source that each came from, and `run.fields`."""

import numpy as np
import pytest

from neve import Simulation
from neve.export.run import Choices, export_run
from neve.flow.births import Births
from neve.io.frames import read_frame
from neve.run import run_scene
from neve.scene.reading.load import load

SCENE = """
[run]
duration = 0.1
fps = 20
film = false
[numerics]
dx = 0.1
[[sources]]
shape = "box"
size = [1.0, 0.4, 0.2]
center = [0, 0, 0.1]
[[sources]]
shape = "sphere"
radius = 0.2
center = [0, 0, 0.45]
velocity = [0, 0, -2]
[[colliders]]
shape = "plane"
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "slab.toml"
    path.write_text(SCENE, encoding="utf-8")
    return load(path)


def below(x):
    """Whether particles of the first frame are in the box, and not in the sphere on it."""
    return x[:, 2] < 0.2 + 1e-6


def test_source_is_that_of_the_start_in_every_frame(scene, tmp_path):
    """Equal snows in two sources are told apart in frames, after a resume, and in exports."""
    first, second = tmp_path / "straight", tmp_path / "resumed"
    run_scene(scene, first, frames=3, quiet=True)
    run_scene(scene, second, frames=1, quiet=True)
    run_scene(scene, second, frames=3, resume=True, quiet=True)
    start = read_frame(first / "frames", 0)
    in_box = below(start.x)
    assert len(np.unique(start.material)) == 1
    for out in (first, second):
        for k in range(4):
            found = read_frame(out / "frames", k).more["source"]
            assert found.dtype == np.uint16
            np.testing.assert_array_equal(found == 0, in_box)
    assert (first / "frames/000003.npz").read_bytes() == (second / "frames/000003.npz").read_bytes()
    folder, _ = export_run(first, Choices("ply"), tmp_path / "ply")
    head = next(folder.glob("*.ply")).read_bytes()[:1000]
    assert b" source\n" in head


def test_added_snow_is_another_source(scene):
    """Snow that is thrown in has the next index, in the order of birth; one source is named on demand."""
    sim = Simulation(scene)
    sim.advance(0.01)
    before = sim.count
    sim.add(scene.sources[1].model_copy(update={"center": (0.0, 0.0, 2.0)}))
    again = Simulation.restore(sim.scene, sim.arrays())
    for one in (sim, again):
        found = np.asarray(one.columns()["source"]())
        assert list(np.unique(found)) == [0, 1, 2]
        np.testing.assert_array_equal(found == 2, one.state.id >= before)


def test_births_of_other_scenes_are_refused(scene):
    """A checkpoint whose births do not fit the sources is damaged."""
    arrays = Simulation(scene).arrays()
    for wrong in (
        [[0, 0]],
        [[0, 0], [-1, 1]],
        [[1, 0], [2, 1]],
        [[0.0, 0], [5, 1]],
        [[0, 0], [5, -1]],
        [0, 5],
    ):
        with pytest.raises(ValueError, match="births"):
            Simulation.restore(scene, arrays | {"births": np.array(wrong)})


def test_source_of_an_empty_source_is_nobodys():
    """Two sources with the same first id: the earlier one has no particles; emitters come after sources."""
    ids = np.array([3, 0, 2, 1])
    births = Births.of_sources([2, 0, 2])
    np.testing.assert_array_equal(births.of(ids, 3), [2, 0, 2, 0])
    for owner, count in ((-1, 2), (-1, 1), (-2, 2), (-1, 1)):
        births.add(owner, count)
    assert births.table[3:].tolist() == [[4, -1], [7, -2], [9, -1]]
    np.testing.assert_array_equal(births.of(np.arange(10), 3), [0, 0, 2, 2, 3, 3, 3, 4, 4, 3])


def test_every_field_can_be_asked_for(scene, tmp_path):
    """Each column of the particles goes into the frames by its name, and comes back in the rows of its id."""
    names = tuple(name for name in Simulation(scene).columns() if name not in ("x", "v", "id"))
    asked = scene.model_copy(update={"run": scene.run.model_copy(update={"fields": names})})
    sim = run_scene(asked, tmp_path / "run", frames=1, quiet=True)
    content = read_frame(tmp_path / "run/frames", 1)
    order = np.argsort(sim.state.id)
    for name in names:
        found = content.more[name] if name in content.more else getattr(content, name)
        np.testing.assert_array_equal(found, np.asarray(sim.columns()[name]())[order])
