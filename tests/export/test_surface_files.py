"""OBJ and GLB: read back by trimesh; the surface is closed and holds the snow."""

import json
import struct

import numpy as np
import pytest
import trimesh

from neve.build import solids
from neve.colliders.triangles import triangles
from neve.export.formats.glb import Scene
from neve.export.run import Choices, export_run
from neve.export.solids import FAR, MOST_HEIGHTS
from neve.scene.reading.load import load
from neve.surface.mesh import snow_surface


@pytest.fixture
def meshes(run_path):
    """Each mesh of frame 3 in a format, in metres with z up, by name."""

    def read(to):
        folder, _ = export_run(run_path, Choices(to, up="z"), frames=slice(3, 4), out=run_path.parent / to)
        more = {"split_objects": True, "maintain_order": True, "group_material": False} if to == "obj" else {}
        loaded = trimesh.load_scene(folder / f"snow_000003.{to}", process=False, **more)
        return {
            name: loaded.geometry[loaded.graph[name][1]].copy().apply_transform(loaded.graph[name][0])
            for name in loaded.graph.nodes_geometry
        }

    return read


def spacing_of(run_path):
    return load(run_path).numerics.spacing


def test_obj_holds_the_surface_and_the_solids(meshes, run_path, frame):
    """The closed mesh of the snow to seven digits, and each solid at its place."""
    found = meshes("obj")
    want = snow_surface(frame(3).x, spacing_of(run_path))
    assert set(found) == {"snow", "colliders_0", "colliders_1", "bodies_0"}
    np.testing.assert_allclose(found["snow"].vertices, want.vertices, rtol=1e-6, atol=1e-6)
    assert np.array_equal(found["snow"].faces, want.faces)
    check_snow_and_solids(found, run_path, frame(3))


def test_glb_holds_the_surface_and_the_solids(meshes, run_path, frame):
    """The same, to the bit, with velocities."""
    found = meshes("glb")
    want = snow_surface(frame(3).x, spacing_of(run_path), v=frame(3).v)
    assert set(found) == {"snow", "colliders.0", "colliders.1", "bodies.0"}
    assert np.array_equal(found["snow"].vertices.astype(np.float32), want.vertices)
    assert np.array_equal(found["snow"].vertex_attributes["_VELOCITY"], want.velocity)
    check_snow_and_solids(found, run_path, frame(3))


def check_snow_and_solids(found, run_path, content):
    """Closed, outward, about the snow's volume; corners of solids are Q X + p."""
    snow = found["snow"]
    assert snow.is_watertight
    # each particle fills s^3; in a ball of eight spacings the level of a half may lie a third off
    assert snow.volume == pytest.approx(len(content.x) * spacing_of(run_path) ** 3, rel=0.34)
    for i, solid in enumerate(solids(load(run_path))):
        mesh = found.get(solid.name, found.get(solid.name.replace(".", "_")))
        corners, faces = triangles(solid, FAR, MOST_HEIGHTS)
        places = corners @ content.solid_rotation[i].T + content.solid_position[i]
        np.testing.assert_allclose(mesh.triangles, places[faces], atol=2e-6 * max(1.0, np.abs(places).max()))


def test_a_glb_keeps_the_rules_of_its_format(run_path):
    """Lengths, alignment, bounds of positions, y up: what the specification of glTF 2.0 asks for."""
    folder, _ = export_run(run_path, Choices("glb"), frames=slice(2, 3))
    data = (folder / "snow_000002.glb").read_bytes()
    magic, version, whole, length, kind = struct.unpack("<4sIII4s", data[:20])
    assert (magic, version, whole, kind) == (b"glTF", 2, len(data), b"JSON")
    assert length % 4 == 0
    document = json.loads(data[20 : 20 + length])
    size, kind = struct.unpack("<I4s", data[20 + length : 28 + length])
    assert (size, kind) == (len(data) - 28 - length, b"BIN\0")
    assert document["buffers"] == [{"byteLength": size}]
    end = 0
    for view in document["bufferViews"]:
        assert view["byteOffset"] == end
        assert view["byteOffset"] % 4 == 0
        end += view["byteLength"]
    assert end == size
    first = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    values = np.frombuffer(data, "<f4", 3 * first["count"], 28 + length).reshape(-1, 3)
    assert first["min"] == values.min(axis=0).tolist()
    assert first["max"] == values.max(axis=0).tolist()


def test_a_scene_without_anything_is_a_file(tmp_path):
    """Nothing is empty that may not be: trimesh finds no geometry and no fault."""
    with open(tmp_path / "a.glb", "wb") as file:
        Scene({}).write(file)
    assert len(trimesh.load_scene(tmp_path / "a.glb").geometry) == 0
