"""VTK: read back by VTK itself."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from neve.build import solids
from neve.colliders.triangles import triangles
from neve.export.formats import vtk_grid
from neve.export.run import Choices, export_run
from neve.export.solids import FAR, MOST_HEIGHTS
from neve.io.checkpoint import read_checkpoint
from neve.scene.reading.load import load


def collected(path):
    """Time and file of each entry of a .pvd file."""
    return [(float(row.get("timestep")), row.get("file")) for row in ET.parse(path).iter("DataSet")]


def test_collections_name_every_frame_with_its_time(run_path, frame):
    """Also when the frames come in two exports; what stands still has one file."""
    export_run(run_path, Choices("vtk"), frames=slice(0, 5, 2))
    folder, new = export_run(run_path, Choices("vtk"))
    assert new == 2
    for kind, ending in (("snow", "vtp"), ("grid", "vti"), ("solids", "vtp")):
        rows = collected(folder / f"{kind}.pvd")
        assert rows == [(frame(k).time, f"{kind}_{k:06d}.{ending}") for k in range(5)]
        assert all((folder / name).is_file() for _, name in rows)
    assert (folder / "solids_still.vtp").is_file()


@pytest.fixture
def read():
    """Read a .vtp file with VTK."""
    xml = pytest.importorskip("vtkmodules.vtkIOXML", reason="pip install vtk: 566 MB, so not in any extra")

    def read(path):
        from vtkmodules.util.numpy_support import vtk_to_numpy

        reader = xml.vtkXMLPolyDataReader()
        reader.SetFileName(str(path))
        reader.Update()
        data = reader.GetOutput()
        groups = data.GetPointData(), data.GetCellData(), data.GetFieldData()
        arrays = {
            group.GetArrayName(i): vtk_to_numpy(group.GetArray(i))
            for group in groups
            for i in range(group.GetNumberOfArrays())
        }
        faces = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        return vtk_to_numpy(data.GetPoints().GetData()), arrays, faces, data

    return read


def test_particles_are_those_of_the_frame(run_path, frame, read):
    """Places, fields and the time, to the bit; each particle is a vertex."""
    folder, _ = export_run(run_path, Choices("vtk"))
    x, arrays, _, data = read(folder / "snow_000003.vtp")
    want = frame(3)
    assert np.array_equal(x, want.x)
    assert data.GetNumberOfVerts() == len(x)
    for name in ("v", "J_P", "id", "material"):
        assert np.array_equal(arrays[name], getattr(want, name))
    assert arrays["TimeValue"][0] == want.time


def test_solids_are_where_they_are_in_the_frame(run_path, frame, read):
    """Corners of the plate and the body: R X + p of the frame; the plane alone stands still."""
    folder, _ = export_run(run_path, Choices("vtk"))
    x, arrays, faces, _ = read(folder / "solids_000004.vtp")
    want = frame(4)
    for i, solid in enumerate(solids(load(run_path))):
        if i == 0:
            continue
        corners, _ = triangles(solid, FAR, MOST_HEIGHTS)
        mine = np.unique(faces[arrays["solid"] == i])
        moved = corners @ want.solid_rotation[i].T + want.solid_position[i]
        np.testing.assert_allclose(x[mine], moved, atol=1e-6)
    _, still, _, _ = read(folder / "solids_still.vtp")
    assert set(still["solid"]) == {0}


@pytest.fixture
def image(run_path):
    """Read the grid of frame 3 with VTK: density, velocity, origin and spacing."""
    xml = pytest.importorskip("vtkmodules.vtkIOXML", reason="pip install vtk: 566 MB, so not in any extra")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    def read(folder):
        reader = xml.vtkXMLImageDataReader()
        reader.SetFileName(str(folder / "grid_000003.vti"))
        reader.Update()
        data = reader.GetOutput()
        shape = data.GetDimensions()[::-1]
        density = vtk_to_numpy(data.GetPointData().GetArray("density")).reshape(shape).T
        velocity = vtk_to_numpy(data.GetPointData().GetArray("velocity")).reshape(*shape, 3)
        return (
            density,
            velocity.transpose(2, 1, 0, 3),
            np.array(data.GetOrigin()),
            np.array(data.GetSpacing()),
        )

    return read


def test_the_grid_holds_mass_centre_and_momentum(run_path, frame, image):
    """sum rho h^3 = M; sum rho x h^3 = M X, as B-splines keep linear functions; sum rho u h^3 = sum m v."""
    folder, _ = export_run(run_path, Choices("vtk"))
    density, velocity, origin, spacing = image(folder)
    want, arrays = frame(3), read_checkpoint(run_path / "checkpoint").arrays
    m = arrays["m"][np.argsort(arrays["id"])].astype(np.float64)
    cell = load(run_path).numerics.spacing
    assert spacing.tolist() == [cell] * 3
    rho = density.astype(np.float64) * cell**3
    assert rho.sum() == pytest.approx(m.sum(), rel=1e-5)
    places = origin + cell * np.stack(np.meshgrid(*map(np.arange, rho.shape), indexing="ij"), axis=-1)
    np.testing.assert_allclose(np.tensordot(rho, places, 3), m @ want.x, rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(np.tensordot(rho, velocity, 3), m @ want.v, rtol=1e-4, atol=1e-3)


def test_a_wide_grid_has_larger_cells(run_path, frame, image, monkeypatch):
    """Never more cells than are allowed; mass is kept."""
    monkeypatch.setattr(vtk_grid, "MOST_CELLS", 2000)
    folder, _ = export_run(run_path, Choices("vtk"))
    density, _, _, spacing = image(folder)
    assert spacing[0] == 2 * load(run_path).numerics.spacing
    assert density.size <= 2000
    mass = read_checkpoint(run_path / "checkpoint").arrays["m"].sum(dtype=np.float64)
    assert density.sum(dtype=np.float64) * spacing[0] ** 3 == pytest.approx(mass, rel=1e-5)
