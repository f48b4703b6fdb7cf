"""Scenes of thousands of parts: read in time, or refused in one sentence before time is spent."""

import numpy as np
import pytest
import trimesh

from neve import Simulation
from neve.build import coupled
from neve.geometry import mesh as mesh_files
from neve.mpm.initial import make_model
from neve.run.large import in_words
from neve.scene.errors import SceneError
from neve.scene.reading import presets
from neve.scene.reading.load import load, scene_from
from neve.scene.reading.presets import MOST_BYTES, MOST_ENTRIES


def told(path):
    """The sentence by which a scene file is refused."""
    with pytest.raises(SceneError) as caught:
        load(path)
    return str(caught.value)


def test_too_many_parts_are_told_before_the_file_is_parsed(tmp_path, monkeypatch):
    """The headings are counted first; lists that are written otherwise are counted once they are read."""
    file = tmp_path / "s.toml"
    file.write_text(" [[ colliders ]]\nshape = 'plane'\n" * (MOST_ENTRIES + 1))
    with monkeypatch.context() as patch:
        patch.setattr(presets.tomllib, "loads", lambda text: pytest.fail("the file was parsed"))
        assert "colliders has 10,001 entries, more than 10,000" in told(file)
    file.write_text(f"sources = [{'{},' * (MOST_ENTRIES + 1)}]")
    assert "sources has 10,001 entries, more than 10,000" in told(file)


def test_a_scene_file_of_any_length_is_refused_at_once(tmp_path):
    """No more of it is read than may be: here a file of 1 TB that takes no room on the disk."""
    file = tmp_path / "s.toml"
    with file.open("wb") as sparse:
        sparse.truncate(10**12)
    assert f"at most {MOST_BYTES / 1e6:g} MB" in told(file)


def test_a_mesh_of_many_colliders_is_read_once(tmp_path, monkeypatch):
    """Fifty colliders of one file; and again once the file is another."""
    path = tmp_path / "ball.stl"
    trimesh.creation.icosphere(subdivisions=1, radius=0.3).export(path)
    reads = []
    read = mesh_files.read
    monkeypatch.setattr(mesh_files, "read", lambda *a: reads.append(a) or read(*a))
    mesh = {"shape": "mesh", "file": str(path), "unit": "m"}
    colliders = [mesh | {"center": [i, 0.0, 0.0]} for i in range(50)]
    scene = scene_from({"sources": [{"shape": "sphere"}], "colliders": colliders, "numerics": {"dx": 0.1}})
    solids, _ = coupled(scene)
    assert len(reads) == 1
    assert len({id(solid.mesh) for solid in solids}) == 1
    trimesh.creation.icosphere(subdivisions=2, radius=0.4).export(path)
    again, _ = coupled(scene)
    assert len(reads) == 2
    assert again[0].reach == pytest.approx(0.4, rel=1e-3)
    assert solids[0].reach == pytest.approx(0.3, rel=1e-3)


def test_what_is_not_near_a_box_does_not_reach_into_it():
    """Shapes of all kinds, turned: where `near` leaves one out, every point of the box is outside of it."""
    rng = np.random.default_rng(7)
    colliders = [{"shape": "plane", "normal": [1.0, 2.0, 3.0]}, {"shape": "mesh", "file": "neve:pine"}]
    for i in range(60):
        size = float(rng.uniform(0.05, 1.0))
        sizes = {
            "box": {"size": (size * rng.uniform(0.1, 3.0, 3)).tolist()},
            "sphere": {"radius": size},
            "cylinder": {"radius": size / 3, "height": 3 * size},
        }
        shape = list(sizes)[i % 3]
        turned = {} if shape == "sphere" else {"rotation": rng.uniform(-180, 180, 3).tolist()}
        center = rng.uniform(-3, 3, 3).tolist()
        colliders.append({"shape": shape, "center": center, **sizes[shape], **turned})
    sources = [{"shape": "sphere", "center": [0.0, 0.0, 50.0]}]
    model = make_model(scene_from({"sources": sources, "colliders": colliders, "numerics": {"dx": 0.1}}))
    left_out = 0
    for _ in range(20):
        low = rng.uniform(-3, 3, 3)
        high = low + rng.uniform(0.01, 1.0, 3)
        points = low + rng.random((500, 3)) * (high - low)
        for i in set(range(len(colliders))) - set(model.near(low, high)):
            left_out += 1
            assert model.distance(i, points).min() > 0
    assert left_out > 500


def test_a_large_scene_says_so_before_its_first_frame():
    """Thousands of parts or millions of particles."""
    ball = {"shape": "sphere"}
    assert in_words(scene_from({"sources": [ball]})) == ""
    many = scene_from({"sources": [ball], "colliders": [{"shape": "plane"}] * 1000, "numerics": {"dx": 1.0}})
    assert in_words(many).startswith("1 source, 1,000 colliders, about ")
    fine = {"sources": [{"shape": "box", "size": [1.0, 1.0, 1.0]}], "numerics": {"dx": 0.01}}
    assert in_words(scene_from(fine)) == "1 source, about 8e+06 particles"


def test_snow_of_a_hundred_kinds_has_a_row_for_each():
    """Each particle follows the snow of its own source."""
    sources = [
        {"shape": "box", "size": [0.2, 0.2, 0.2], "center": [float(i), 0, 0], "snow": {"E0": 1e5 + i}}
        for i in range(100)
    ]
    sim = Simulation(scene_from({"sources": sources, "numerics": {"dx": 0.1}}), threads=1)
    assert np.array_equal(sim.state.material, np.rint(sim.state.x[:, 0]).astype(int))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"[{'.'.join(['a'] * 20000)}]\nb = 1", "nested too deeply"),
        ("\n".join(f"k{i} = 1" for i in range(20000)), "k0 is not a known key"),
        (f'[[sources]]\nshape = "text"\ntext = "{"A" * 10001}"', "at most 10,000 characters"),
    ],
    ids=["deep tables", "unknown keys", "a long text"],
)
def test_endless_tables_keys_and_texts_are_one_sentence(text, words, tmp_path):
    """Whatever a file repeats."""
    (tmp_path / "s.toml").write_text(text)
    assert words in told(tmp_path / "s.toml")


def test_a_long_override_is_not_repeated_as_a_whole():
    """The sentence names its beginning."""
    with pytest.raises(SceneError) as caught:
        scene_from({}, [f"sources.0.radius={'[' * 5000}"])
    assert len(str(caught.value)) < 500
