"""`neve run --fine`: as many particles as it says, of any scene."""

import pytest
import trimesh
from scripts import ROOT

from neve.cli import main
from neve.io.frames import read_frame
from neve.sampling import fill
from neve.sampling.fineness import ENOUGH, FINE, finer, particles_of
from neve.scene.reading.load import load, scene_from
from neve.scene.reading.presets import presets


@pytest.mark.parametrize("name", presets())
def test_presets_become_fine(name):
    """Two million particles within the rounding of dx, 3 %, and nothing but dx is another; twice is once."""
    scene = load(name)
    fine = finer(scene)
    assert particles_of(fine) == pytest.approx(FINE, rel=0.03)
    assert fine.numerics.dx < scene.numerics.dx
    same = fine.numerics.model_copy(update={"dx": scene.numerics.dx})
    assert fine.model_copy(update={"numerics": same}) == scene
    assert finer(fine) == fine


def test_particles_of_a_closed_mesh_are_counted_without_distances(monkeypatch):
    """What is inside follows from the triangles; distances to them, which take long, are not computed."""
    monkeypatch.setattr("neve.geometry.sdf._grid", None)
    mesh = trimesh.load(ROOT / "src/neve/assets/meshes/castle.ply", process=False)
    found = particles_of(load("castle", ["numerics.dx=0.0123"]))
    assert found == pytest.approx(mesh.volume * 8 / 0.0123**3, rel=1e-3)


@pytest.mark.parametrize(
    "source",
    [
        {"shape": "sphere", "radius": 0.4},
        {"shape": "text", "text": "ice", "center": [0, 0, 1]},
        {"shape": "layer", "size": [1, 2], "depth": 0.3},
    ],
    ids=lambda source: source["shape"],
)
def test_the_estimate_is_what_is_placed(source):
    """The number of particles that are placed, within their own scatter and, of letters, their outline."""
    scene = scene_from({"sources": [source], "numerics": {"dx": 0.06}})
    placed = len(fill(scene.sources[0], scene.numerics, 0).x)
    assert particles_of(scene) == pytest.approx(placed, rel=0.05)


def test_a_scene_with_many_stays_as_it_is():
    """A scene of a million particles or more is fine."""
    scene = scene_from({"sources": [{"shape": "box", "size": [1, 1, 1]}], "numerics": {"dx": 0.019}})
    assert particles_of(scene) > ENOUGH
    assert finer(scene) is scene


def code(*arguments):
    """Exit code of a command line."""
    with pytest.raises(SystemExit) as end:
        main([str(a) for a in arguments])
    return end.value.code


def test_the_command_runs_the_fine_scene(tmp_path, capsys, monkeypatch):
    """`--fine` says which grid it takes, and the run has it; a dx beside it is refused."""
    monkeypatch.setattr("neve.sampling.fineness.FINE", 3000)
    file, out = tmp_path / "ball.toml", tmp_path / "out"
    file.write_text(
        '[[sources]]\nshape = "sphere"\nradius = 0.3\n[numerics]\ndx = 0.1\n[run]\nfilm = false\n'
    )
    fine = finer(load(file))
    assert code("run", file, "--fine", "--out", out, "--frames", "1") == 0
    assert f"--fine: numerics.dx = {fine.numerics.dx:g}" in capsys.readouterr().err
    assert load(out).numerics.dx == fine.numerics.dx
    assert len(read_frame(out / "frames", 0).x) == pytest.approx(3000, rel=0.05)
    assert code("run", out, "--fine", "--resume") == 2
    assert "a run that is resumed keeps its own: leave --fine out" in capsys.readouterr().err
    assert code("run", file, "--fine", "--set", "numerics.dx=0.05", "--out", tmp_path / "b") == 2
    assert "--fine chooses numerics.dx" in capsys.readouterr().err
    assert code("run", file, "--fine", "--set", "numerics={dx=0.05}", "--out", tmp_path / "b") == 2
    assert "--fine chooses numerics.dx" in capsys.readouterr().err
    assert code("run", file, "--fine", "--set", "numerics.dt=1e-4", "--out", tmp_path / "b") == 2
    assert "numerics.dt = 0.0001 s would stay" in capsys.readouterr().err
