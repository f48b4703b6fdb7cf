"""Alembic: read back by Alembic's own library, all frames in one file."""

import numpy as np
import pytest

from neve.build import solids
from neve.colliders.triangles import triangles
from neve.export.formats.alembic import Alembic
from neve.export.run import Choices, export_run
from neve.export.solids import FAR, MOST_HEIGHTS
from neve.io.errors import RunError
from neve.scene.reading.load import load
from neve.surface.mesh import snow_surface

alembic3d = pytest.importorskip("alembic3d", reason="pip install alembic3d, of the extra export")


def children(path):
    """The objects at the top of a file, by name."""
    top = alembic3d.Abc.IArchive(str(path)).getTop()
    return top, [top.getChild(i).getName() for i in range(top.getNumChildren())]


def at(k):
    """What selects the sample of frame k, by its time."""
    return alembic3d.Abc.ISampleSelector(k / 25)


def array(values):
    return np.array(values)


def test_points_and_surface_are_those_of_each_frame(run_path, frame):
    """Positions, velocities, ids, widths, J_P to the bit; the mesh is the surface, clockwise from outside."""
    folder, new = export_run(run_path, Choices("abc", up="z"))
    assert new == 5
    top, names = children(folder / "snow.abc")
    assert names == ["snow", "snow_surface", "camera", "colliders_0", "colliders_1", "bodies_0"]
    points = alembic3d.AbcGeom.IPoints(top, "snow").getSchema()
    surface = alembic3d.AbcGeom.IPolyMesh(top, "snow_surface").getSchema()
    assert points.getNumSamples() == surface.getNumSamples() == 5
    spacing = load(run_path).numerics.spacing
    for k in (0, 3, 4):
        want, sample, mesh = frame(k), points.getValue(at(k)), surface.getValue(at(k))
        assert points.getTimeSampling().getSampleTime(k) == pytest.approx(want.time)
        assert np.array_equal(array(sample.getPositions()), want.x)
        assert np.array_equal(array(sample.getVelocities()), want.v)
        assert list(sample.getIds()) == want.id.tolist()
        widths = points.getWidthsParam().getExpandedValue(at(k)).getVals()
        assert np.array_equal(array(widths), np.full(len(want.x), spacing, np.float32))
        fields = points.getArbGeomParams()
        J_P = alembic3d.AbcGeom.IFloatGeomParam(fields, "J_P").getExpandedValue(at(k)).getVals()
        assert np.array_equal(array(J_P), want.J_P)
        snow = snow_surface(want.x, spacing, v=want.v)
        assert np.array_equal(array(mesh.getPositions()), snow.vertices)
        assert np.array_equal(array(mesh.getVelocities()), snow.velocity)
        assert np.array_equal(array(mesh.getFaceIndices()).reshape(-1, 3)[:, ::-1], snow.faces)


@pytest.mark.parametrize(("up", "scale"), [("z", 1.0), ("y", 100.0)])
def test_solids_move_as_in_the_frames(run_path, frame, up, scale):
    """Corners of each solid are s R (Q X + p); one that stands still has one sample."""
    folder, _ = export_run(run_path, Choices("abc", up=up, scale=scale))
    top, _ = children(folder / "snow.abc")
    for i, solid in enumerate(solids(load(run_path))):
        place = alembic3d.AbcGeom.IXform(top, solid.name.replace(".", "_"))
        mesh = alembic3d.AbcGeom.IPolyMesh(place, "mesh").getSchema()
        own = array(mesh.getValue().getPositions())
        assert place.getSchema().getNumSamples() == (1 if solid.motion == "static" else 5)
        for k in (0, 4):
            matrix = array([list(row) for row in place.getSchema().getValue(at(k)).getMatrix()])
            want = frame(k)
            x, y, z = (
                scale
                * (
                    triangles(solid, FAR, MOST_HEIGHTS)[0] @ want.solid_rotation[i].T + want.solid_position[i]
                ).T
            )
            meant = np.stack([x, z, -y] if up == "y" else [x, y, z], axis=1)
            np.testing.assert_allclose(own @ matrix[:3, :3] + matrix[3, :3], meant, atol=1e-4 * scale)


def test_one_file_is_written_anew_or_not_at_all(run_path, frame, monkeypatch):
    """Other frames make another file, with their times; a stop leaves the old one."""
    folder, _ = export_run(run_path, Choices("abc"))
    assert export_run(run_path, Choices("abc"))[1] == 0
    before = (folder / "snow.abc").read_bytes()

    def stopped(self, moment):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Alembic, "write", stopped)
        with pytest.raises(KeyboardInterrupt):
            export_run(run_path, Choices("abc"), frames=slice(1, 4))
    assert (folder / "snow.abc").read_bytes() == before
    assert not [path for path in folder.iterdir() if path.name.startswith(".")]
    assert export_run(run_path, Choices("abc"), frames=slice(1, 5, 3))[1] == 2
    top, _ = children(folder / "snow.abc")
    points = alembic3d.AbcGeom.IPoints(top, "snow").getSchema()
    assert [points.getTimeSampling().getSampleTime(k) for k in range(2)] == pytest.approx([0.04, 0.16])
    (run_path / "frames/000002.npz").unlink()
    assert export_run(run_path, Choices("abc"))[1] == 4
    top, _ = children(folder / "snow.abc")
    points = alembic3d.AbcGeom.IPoints(top, "snow").getSchema()
    times = [points.getTimeSampling().getSampleTime(k) for k in range(4)]
    assert times == pytest.approx([0.0, 0.04, 0.12, 0.16])


def test_what_the_library_refuses_is_one_sentence(run_path):
    """A folder stands where the file belongs."""
    (run_path / "abc" / "snow.abc").mkdir(parents=True)
    (run_path / "abc" / "export.json").write_text('{"layout": 1, "options": {}, "files": [], "frames": {}}')
    with pytest.raises(RunError, match=r"snow\.abc could not be written"):
        export_run(run_path, Choices("abc"), force=True)
