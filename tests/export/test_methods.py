"""Runs of every method are exported: the files hold what the frames do."""

import numpy as np
import pytest

from neve.export.run import Choices, export_run
from neve.io.frames import read_frame
from neve.registry import METHODS
from neve.run import run_scene
from neve.scene.reading.load import scene_from


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
