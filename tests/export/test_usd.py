"""USD: composed and read back by OpenUSD, and passed by its validators."""

import numpy as np
import pytest

from neve.build import solids
from neve.colliders.triangles import triangles
from neve.export.run import Choices, export_run
from neve.export.solids import FAR, MOST_HEIGHTS
from neve.scene.reading.load import load

pxr = pytest.importorskip("pxr.Usd", reason="pip install usd-core, of the extra export")
from pxr import Usd, UsdGeom, UsdValidation  # noqa: E402 (once it is known to be there)


def stage_of(run_path, **choices):
    """Export all frames and open the stage."""
    folder, _ = export_run(run_path, Choices("usd", **choices))
    return Usd.Stage.Open(str(folder / "snow.usda"))


def complaints(stage):
    """What all validators of OpenUSD say about a stage."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [e.GetErrorAsString() for e in UsdValidation.ValidationContext(validators).Validate(stage)]


def test_points_are_those_of_each_frame(run_path, frame):
    """Through the clips, time code k is frame k: points, velocities, ids, widths and primvars, to the bit."""
    stage = stage_of(run_path)
    points = UsdGeom.Points(stage.GetPrimAtPath("/World/Snow"))
    primvars = UsdGeom.PrimvarsAPI(points)
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (0, 4, 25)
    for number in (0, 3, 4):
        want = frame(number)
        assert np.array_equal(points.GetPointsAttr().Get(number), want.x)
        assert np.array_equal(points.GetVelocitiesAttr().Get(number), want.v)
        assert np.array_equal(points.GetIdsAttr().Get(number), want.id)
        assert np.array_equal(primvars.GetPrimvar("J_P").Get(number), want.J_P)
        assert np.array_equal(primvars.GetPrimvar("material").Get(number), want.material)
        spacing = load(run_path).numerics.spacing
        assert np.array_equal(points.GetWidthsAttr().Get(number), np.full(len(want.x), spacing, np.float32))
        low, high = np.array(points.GetExtentAttr().Get(number))
        np.testing.assert_allclose(low, want.x.min(axis=0) - spacing / 2, rtol=1e-5)
        np.testing.assert_allclose(high, want.x.max(axis=0) + spacing / 2, rtol=1e-5)


@pytest.mark.parametrize(("up", "scale"), [("z", 1.0), ("y", 100.0)])
def test_solids_move_as_in_the_frames(run_path, frame, up, scale):
    """Corners in the stage are s R (Q X + p); the stage says which axis is up and how long its unit is."""
    stage = stage_of(run_path, up=up, scale=scale)
    assert UsdGeom.GetStageUpAxis(stage) == up.upper()
    assert UsdGeom.GetStageMetersPerUnit(stage) * scale == 1.0
    for i, solid in enumerate(solids(load(run_path))):
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath(f"/World/Solids/{solid.name.replace('.', '_')}"))
        assert len(mesh.GetFaceVertexIndicesAttr().Get()) == 3 * len(triangles(solid, FAR, MOST_HEIGHTS)[1])
        own = np.array(mesh.GetPointsAttr().Get())
        for number in (0, 4):
            matrix = np.array(mesh.ComputeLocalToWorldTransform(number))
            seen = own @ matrix[:3, :3] + matrix[3, :3]
            want = frame(number)
            x, y, z = (
                scale
                * (
                    triangles(solid, FAR, MOST_HEIGHTS)[0] @ want.solid_rotation[i].T + want.solid_position[i]
                ).T
            )
            meant = np.stack([x, z, -y] if up == "y" else [x, y, z], axis=1)
            np.testing.assert_allclose(seen, meant, atol=2e-6 * scale * max(1.0, np.abs(meant).max() / scale))


def test_the_validators_have_nothing_to_say(run_path):
    """Of a stage with all frames; they do see a stage that says nothing of its axis."""
    assert complaints(stage_of(run_path)) == []
    bare = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(bare, "/World")
    assert complaints(bare)


def test_a_stage_grows_with_the_frames(run_path):
    """Frames that come later join the clips."""
    export_run(run_path, Choices("usd"), frames=slice(0, 2))
    stage = stage_of(run_path)
    world = Usd.ClipsAPI(stage.GetPrimAtPath("/World"))
    assert [path.path for path in world.GetClipAssetPaths()] == [f"./snow_{k:06d}.usdc" for k in range(5)]
