"""`run.fields`: further fields in the frames, and in each format that has fields."""

import numpy as np
import pytest

from neve.export.axes import Axes
from neve.export.moment import turned
from neve.export.run import Choices, export_run
from neve.io.errors import RunError
from neve.io.frames import read_frame
from neve.registry import METHODS
from neve.run import painter, run, run_scene
from neve.scene.reading.load import load, scene_from
from neve.simulation import Simulation

SCENE = """
[run]
duration = 0.06
fps = 50
film = false
fields = ["F_E", "tau", "density", "m", "modes", "C"]
[numerics]
dx = 0.25
[[sources]]
shape = "box"
center = [0.0, 0.0, 0.4]
velocity = [0.0, 1.0, -3.0]
[[colliders]]
shape = "plane"
"""


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """A box of snow that hits the ground, with more fields."""
    monkeypatch.setattr(painter, "SIZE", (64, 36))
    (tmp_path / "scene.toml").write_text(SCENE)
    return load(tmp_path / "scene.toml")


@pytest.fixture
def out(scene, tmp_path):
    """Its run."""
    run_scene(scene, tmp_path / "run", threads=1, quiet=True)
    return tmp_path / "run"


def test_frames_hold_what_the_scene_names(scene, out):
    """The last frame has the state's own numbers, in the order of the ids; a resume has the same bits."""
    sim = Simulation(scene, threads=1)
    for _ in range(3):
        sim.advance(1 / 50)
    content = read_frame(out / "frames", 3)
    assert list(content.more) == ["F_E", "tau", "density", "m", "modes", "C"]
    order = np.argsort(sim.columns()["id"]())
    for name, values in content.more.items():
        assert np.array_equal(values, np.asarray(sim.columns()[name]())[order].astype(np.float32))
    assert np.abs(content.more["tau"]).max() > 0


def test_a_name_that_is_no_field_is_refused(scene, tmp_path):
    """Before anything is written, with the nearest name."""
    wrong = load(tmp_path / "scene.toml", ['run.fields=["F_P"]'])
    with pytest.raises(RunError, match=r'run\.fields\.0 = "F_P" is no field of the particles \(did you mean'):
        run(Simulation(wrong, threads=1), tmp_path / "no", quiet=True)
    assert not (tmp_path / "no").exists()


def test_tensors_turn_with_the_axes():
    """y up: A' = R A R^T; a symmetric matrix of six numbers xx yy zz xy xz yz becomes a whole one."""
    six = np.array([[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]])
    whole = np.array([[1.0, 4.0, 5.0], [4.0, 2.0, 6.0], [5.0, 6.0, 3.0]])
    for up in ("y", "z"):
        axes = Axes(up, 7.0)
        np.testing.assert_allclose(turned("tau", six, axes)[0], axes.turn @ whole @ axes.turn.T)


def test_ply_has_a_property_for_each_number(out):
    """F_E_xy is row x, column y."""
    meshio = pytest.importorskip("meshio")
    folder, _ = export_run(out, Choices("ply"), frames=slice(3, 4))
    back, want = meshio.read(folder / "snow_000003.ply").point_data, read_frame(out / "frames", 3).more
    assert np.array_equal(back["density"], want["density"])
    assert np.array_equal(back["F_E_xz"], want["F_E"][:, 0, 2])
    assert np.array_equal(back["C_zy"], want["C"][:, 2, 1])
    assert np.array_equal(back["tau_xy"], want["tau"][:, 3])
    assert np.array_equal(back["tau_zz"], want["tau"][:, 2])
    assert not [name for name in back if name.startswith("modes")]


def test_usd_multiplies_rows_from_the_left(out):
    """p' = p M in USD is F p of columns: M = F^T."""
    usd = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom

    folder, _ = export_run(out, Choices("usd", ("F_E", "tau")))
    stage = usd.Stage.Open(str(folder / "snow.usda"))
    primvars = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Snow"))
    want = read_frame(out / "frames", 2).more
    found = np.array([list(map(list, matrix)) for matrix in primvars.GetPrimvar("F_E").Get(2)])
    assert np.array_equal(found, want["F_E"].transpose(0, 2, 1).astype(np.float64))


def test_alembic_has_no_matrices(out):
    """One sentence, and vectors and numbers are fine."""
    pytest.importorskip("alembic3d")
    with pytest.raises(RunError, match="--fields: F_E is a matrix, which the format abc has no place for"):
        export_run(out, Choices("abc", ("F_E",)))
    assert export_run(out, Choices("abc", ("density", "m", "material")))[1] == 4
    assert export_run(out, Choices("abc"), force=True)[1] == 4


@pytest.mark.parametrize("method", METHODS.names())
def test_export_of_each_method(method, tmp_path):
    """PLY: places and further fields of each frame, as they are, of a ball that lands."""
    meshio = pytest.importorskip("meshio")
    scene = scene_from(
        {
            "numerics": {"method": method, "dx": 0.1},
            "sources": [{"shape": "sphere", "center": [0, 0, 0.24], "radius": 0.2, "velocity": [0, 0, -2.0]}],
            "colliders": [{"shape": "plane"}],
            "run": {"duration": 0.08, "fps": 25, "film": False, "fields": ["density", "m"]},
        }
    )
    run_scene(scene, tmp_path / "run", threads=1, quiet=True)
    folder, new = export_run(tmp_path / "run", Choices("ply"))
    assert new == 3
    for number in range(3):
        content = read_frame(tmp_path / "run" / "frames", number)
        data = meshio.read(folder / f"snow_{number:06d}.ply")
        assert len(content.x) > 200
        assert float(np.abs(data.points - content.x).max()) <= 1e-6
        for name in ("density", "m"):
            np.testing.assert_array_equal(data.point_data[name], content.more[name])
    assert not np.array_equal(content.more["density"], read_frame(tmp_path / "run/frames", 0).more["density"])
