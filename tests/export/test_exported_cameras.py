"""The scene's camera in files: where it stands, looks and how wide, as other programs read it."""

import json
import math
import struct

import numpy as np
import pytest

from neve.build import solids
from neve.export.run import Choices, export_run
from neve.io.frames import read_frame
from neve.io.run_folder import RunFolder
from neve.render.shot import Shot
from neve.scene.reading.load import load, to_toml

CAMERAS = {
    "keyframes": {
        "target": (0.1, 0.2, 0.5),
        "keyframes": [
            {"t": 0.0, "position": (4.0, -6.0, 2.0), "fov": 40.0},
            {"t": 0.16, "position": (2.0, -4.0, 0.8), "fov": 25.0, "up": (0.2, 0.0, 1.0)},
        ],
        "aperture": 0.02,
        "focus": 3.5,
        "shutter": 0.5,
    },
    "follow": {"position": (2.0, -5.0, 1.5), "follow": "snow", "dolly": True, "fov": 30.0},
    "turntable": {"position": (2.0, -5.0, 1.5), "turntable": 90.0},
}
AXES = {"z": np.eye(3), "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])}


@pytest.fixture(params=CAMERAS)
def shot(request, run_path):
    """The run with another camera, and the views that this has, all frames seen."""
    scene = load(run_path)
    camera = type(scene.camera).model_validate(CAMERAS[request.param])
    scene = scene.model_copy(update={"camera": camera})
    RunFolder(run_path).scene.write_text(to_toml(scene))
    shot = Shot(camera, solids(scene), scene.numerics.dx)
    for number in range(5):
        content = read_frame(run_path / "frames", number)
        shot.see(content.time, content.x, content.v, content.id, content.solid_position)
    return run_path, shot


def check(matrix, fov, view, up, scale):
    """Compare a camera that looks along its -z with a view: position, direction, up, vertical angle."""
    turn = AXES[up]
    forward = np.subtract(view.target, view.position)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, view.up)
    right /= np.linalg.norm(right)
    np.testing.assert_allclose(matrix[:3, 3], scale * turn @ view.position, rtol=1e-6, atol=1e-6 * scale)
    np.testing.assert_allclose(-matrix[:3, 2], turn @ forward, atol=1e-6)
    np.testing.assert_allclose(matrix[:3, 0], turn @ right, atol=1e-6)
    np.testing.assert_allclose(matrix[:3, 1], turn @ np.cross(right, forward), atol=1e-6)
    assert math.degrees(fov) == pytest.approx(view.fov, rel=1e-5)


@pytest.mark.parametrize(("up", "scale"), [("z", 1.0), ("y", 100.0)])
def test_usd_has_the_camera_of_each_frame(shot, up, scale):
    """By UsdGeom: transform, angle of view from film and focal length, focus, f-number and shutter. The film
    is 36 mm wide, in tenths of a unit."""
    pxr = pytest.importorskip("pxr.Usd", reason="pip install usd-core, of the extra export")
    from pxr import UsdGeom

    run_path, views = shot
    folder, _ = export_run(run_path, Choices("usd", up=up, scale=scale))
    stage = pxr.Stage.Open(str(folder / "snow.usda"))
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    for number in (0, 1, 3, 4):
        view = views.at(number / 25)
        seen = camera.GetCamera(number)
        matrix = np.array(camera.ComputeLocalToWorldTransform(number)).T
        check(matrix, math.radians(seen.GetFieldOfView(seen.FOVVertical)), view, up, scale)
        assert seen.horizontalAperture / seen.verticalAperture == pytest.approx(16 / 9)
        assert seen.horizontalAperture * 0.1 * UsdGeom.GetStageMetersPerUnit(stage) == pytest.approx(0.036)
        distance = scale * math.dist(view.target, view.position)
        assert seen.clippingRange.min < 0.01 * distance < 100 * distance < seen.clippingRange.max
        own = views.camera
        assert seen.focusDistance == pytest.approx(scale * own.focus if own.focus else distance, rel=1e-5)
        diameter = 0.0 if not own.aperture else 0.1 * seen.focalLength / seen.fStop
        assert diameter == pytest.approx(2 * scale * own.aperture, rel=1e-5)
        opened = camera.GetShutterCloseAttr().Get() - camera.GetShutterOpenAttr().Get()
        assert opened == pytest.approx(own.shutter)


@pytest.mark.parametrize(("up", "scale"), [("y", 1.0), ("z", 10.0)])
def test_glb_has_the_camera_of_its_frame(shot, up, scale):
    """A node with a perspective camera, its matrix column by column."""
    run_path, views = shot
    folder, _ = export_run(run_path, Choices("glb", up=up, scale=scale))
    for number in (0, 2, 4):
        data = (folder / f"snow_{number:06d}.glb").read_bytes()
        document = json.loads(data[20 : 20 + struct.unpack("<I", data[12:16])[0]])
        (node,) = (node for node in document["nodes"] if "camera" in node)
        lens = document["cameras"][node["camera"]]["perspective"]
        check(np.reshape(node["matrix"], (4, 4)).T, lens["yfov"], views.at(number / 25), up, scale)
        assert lens["aspectRatio"] == pytest.approx(16 / 9)
        assert 0 < lens["znear"] < lens["zfar"]


@pytest.mark.parametrize(("up", "scale"), [("y", 1.0), ("z", 100.0)])
def test_alembic_has_the_camera_of_each_frame(shot, up, scale):
    """By Alembic's own reader: the transform, and the angle of view from film [cm] and focal length [mm]."""
    alembic3d = pytest.importorskip("alembic3d", reason="pip install alembic3d, of the extra export")
    run_path, views = shot
    folder, _ = export_run(run_path, Choices("abc", up=up, scale=scale))
    archive = alembic3d.Abc.IArchive(str(folder / "snow.abc"))
    place = alembic3d.AbcGeom.IXform(archive.getTop(), "camera")
    lens = alembic3d.AbcGeom.ICamera(place, "lens").getSchema()
    for number in (0, 2, 4):
        chosen = alembic3d.Abc.ISampleSelector(number / 25)
        matrix = place.getSchema().getValue(chosen).getMatrix()
        sample, view = lens.getValue(chosen), views.at(number / 25)
        fov = 2 * math.atan(0.5 * sample.getVerticalAperture() * 10 / sample.getFocalLength())
        check(np.array([[matrix[i][j] for j in range(4)] for i in range(4)]).T, fov, view, up, scale)
        assert sample.getHorizontalAperture() == pytest.approx(3.6)
        distance = scale * math.dist(view.target, view.position)
        own = views.camera
        assert sample.getFocusDistance() == pytest.approx(scale * own.focus if own.focus else distance)
        assert sample.getShutterClose() - sample.getShutterOpen() == pytest.approx(own.shutter / 25)
