"""The import script for Blender, run by the program that NEVE_BLENDER names: Blender, or a Python with bpy.

`python -m venv bpy && bpy/bin/pip install bpy` (350 MB to load), then NEVE_BLENDER=bpy/bin/python.
"""

import json
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from neve.export.run import Choices, export_run
from neve.scene.reading.load import load

SCRIPT = Path(__file__).parents[2] / "examples/blender/import_snow.py"
PROBE = """
import json, runpy, sys
sys.argv = ["script", "--", *{arguments!r}]
runpy.run_path({script!r}, run_name="__main__")
import bpy
found = {{}}
for frame in (1, 4):
    bpy.context.scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    found[frame] = {{}}
    for thing in bpy.data.objects:
        made = thing.evaluated_get(graph)
        told = found[frame][thing.name] = dict(type=thing.type, place=list(made.matrix_world.translation))
        if thing.type in ("MESH", "POINTCLOUD"):
            data = made.data.attributes["position"].data
            told["x"] = [list(point.vector) for point in data]
            told["materials"] = [slot.name for slot in made.data.materials]
        if thing.type == "POINTCLOUD":
            told["radius"] = made.data.attributes["radius"].data[0].value
        if thing.type == "VOLUME":
            made.data.grids.load()
            told["grids"] = [grid.name for grid in made.data.grids]
            told["file"] = made.data.grids.frame_filepath
print("FOUND" + json.dumps(found))
"""


@pytest.fixture
def blender():
    """Run the script with arguments; return what objects there are in frames 1 and 4."""
    program = os.environ.get("NEVE_BLENDER")
    if not program:
        pytest.skip("NEVE_BLENDER names no Blender and no Python with bpy")

    def run(*arguments):
        probe = PROBE.format(arguments=[str(word) for word in arguments], script=str(SCRIPT))
        is_python = "python" in Path(program).name
        command = [program, *(["-c"] if is_python else ["--background", "--python-expr"]), probe]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
        told = re.search("^FOUND(.*)$", done.stdout, re.M)
        assert told, done.stdout + done.stderr
        return {int(k): value for k, value in json.loads(told[1]).items()}

    return run


def test_points_come_with_their_frames(run_path, frame, blender):
    """Places and radii of the points, the place of the plate that moves, materials, camera and sun."""
    export_run(run_path, Choices("usd"))
    found = blender(run_path, "--as", "points")
    for k in (1, 4):
        np.testing.assert_allclose(found[k]["Snow"]["x"], frame(k).x, atol=1e-6)
        np.testing.assert_allclose(found[k]["colliders_1"]["place"], frame(k).solid_position[1], atol=1e-6)
    snow = found[4]["Snow"]
    assert snow["type"] == "POINTCLOUD"
    assert snow["materials"] == ["snow"]
    assert snow["radius"] == pytest.approx(load(run_path).numerics.spacing / 2)
    np.testing.assert_allclose(found[4]["camera"]["place"], load(run_path).camera.position)
    assert "LIGHT" in {thing["type"] for thing in found[4].values()}


def test_a_surface_is_where_the_snow_is(run_path, frame, blender):
    """Alembic has y up, and Blender turns it back."""
    export_run(run_path, Choices("abc"))
    found = blender(run_path)
    for k in (1, 4):
        x = np.array(found[k]["snow_surface"]["x"])
        np.testing.assert_allclose(x.mean(axis=0), frame(k).x.mean(axis=0), atol=0.05)
    assert "snow" not in found[4]


def test_a_volume_shows_the_file_of_its_frame(run_path, blender):
    """Also with fewer frames than the run has, and a picture is rendered."""
    export_run(run_path, Choices("vdb"), frames=slice(1, 5))
    picture = run_path / "a.png"
    few = ("--size", "64x36", "--samples", "1", "--frame", "2", "--render", picture)
    found = blender(run_path, "--as", "volume", *few)
    for k in (1, 4):
        assert found[k]["Snow"]["grids"] == ["density", "velocity"]
        assert found[k]["Snow"]["file"].endswith(f"snow_{k:06d}.vdb")
    assert picture.stat().st_size > 500


def test_a_run_without_exports_is_told_what_to_do(run_path, blender):
    """The command that is missing."""
    with pytest.raises(AssertionError, match=r"has no such export: neve export .* --to usd"):
        blender(run_path)
