"""PLY: read back by meshio and trimesh."""

import numpy as np
import pytest
import trimesh

from neve.export.formats import ply
from neve.export.run import Choices, export_run

meshio = pytest.importorskip("meshio", reason="meshio, of the extra test, reads the files back")


def test_points_and_fields_are_those_of_the_frame(run_path, frame):
    """x, v, J_P, id and material of each frame, to the bit."""
    folder, new = export_run(run_path, Choices("ply"))
    assert new == 5
    for number in (0, 4):
        back, want = meshio.read(folder / f"snow_{number:06d}.ply"), frame(number)
        assert np.array_equal(back.points, want.x)
        for k, axis in enumerate("xyz"):
            assert np.array_equal(back.point_data[f"v{axis}"], want.v[:, k])
        for name in ("J_P", "id", "material"):
            assert np.array_equal(back.point_data[name], getattr(want, name))
    assert np.array_equal(trimesh.load(folder / "snow_000004.ply").vertices, frame(4).x)


def test_chunks_change_nothing(run_path, tmp_path, monkeypatch):
    """The file is written a few rows at a time, and has the same bytes as in one go."""
    whole, _ = export_run(run_path, Choices("ply"), tmp_path / "whole", slice(3, 4))
    monkeypatch.setattr(ply, "CHUNK", 7)
    parts, _ = export_run(run_path, Choices("ply"), tmp_path / "parts", slice(3, 4))
    assert (parts / "snow_000003.ply").read_bytes() == (whole / "snow_000003.ply").read_bytes()


def test_fields_axes_and_scale_are_as_asked(run_path, frame):
    """`--fields m,v --up y --scale 100`: centimetres with y up, and the masses from the checkpoint."""
    folder, _ = export_run(run_path, Choices("ply", ("m", "v"), "y", 100.0), frames=slice(4, 5))
    back, want = meshio.read(folder / "snow_000004.ply"), frame(4)
    x, y, z = np.float32(100) * want.x.T
    assert np.array_equal(back.points, np.stack([x, z, -y], axis=1))
    assert np.array_equal(back.point_data["vy"], np.float32(100) * want.v[:, 2])
    assert list(back.point_data) == ["m", "vx", "vy", "vz"]
    # 400 kg/m3 of snow in a ball of radius 0.4 m, sampled in cells of 0.2 m: the total within a quarter
    assert back.point_data["m"].sum() == pytest.approx(400 * 4 / 3 * np.pi * 0.4**3, rel=0.25)
