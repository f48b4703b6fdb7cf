"""Mesh files that say to hold more than they do, or show it too often, are told before memory is filled."""

import json
import os
import struct

import numpy as np
import pytest

from neve.geometry import declared
from neve.geometry.mesh import read_mesh
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Collider
from neve.system import memory

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
FACES = np.array([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], "<u2")
DATA = CORNERS.tobytes() + FACES.tobytes()


def glb(**changes):
    """A file of one tetrahedron, with other tables in its tree."""
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "buffers": [{"byteLength": 72}],
    } | changes
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(DATA), len(text), b"JSON")
    return head + text + struct.pack("<I4s", len(DATA), b"BIN\0") + DATA


def read(path):
    """Read a mesh file as a collider does."""
    return read_mesh(Collider.of("mesh", file=str(path), unit="m"), "colliders.0")


def told(path):
    """The sentence by which a mesh file is refused."""
    with pytest.raises(SceneError) as caught:
        read(path)
    return str(caught.value)


PIECE = {"attributes": {"POSITION": 0}, "indices": 1}
EMPTY = {"componentType": 5126, "count": 2 * 10**9, "type": "VEC3"}
INDICES = {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}
ENDLESS = {
    "a mesh of many pieces": ({"meshes": [{"primitives": [PIECE] * 10_001}]}, "10,001 pieces"),
    "many instances": ({"nodes": [{"mesh": 0}] * 100_001}, "100,001 instances"),
    "zeros without data": (
        {"accessors": [EMPTY, INDICES]},
        "needs about 128 GB of memory, and 20 GB are free",
    ),
    "triangles shown often": (
        {
            "nodes": [{"mesh": 0}] * 1000,
            "accessors": [dict(INDICES), INDICES | {"count": 3 * 10**6}],
        },
        "1,000,000,000 triangles",
    ),
    "triangles for the memory": (
        {"nodes": [{"mesh": 0}] * 100, "accessors": [dict(INDICES), INDICES | {"count": 3 * 10**6}]},
        "needs about 30 GB",
    ),
}


@pytest.mark.parametrize(("changes", "words"), ENDLESS.values(), ids=ENDLESS.keys())
def test_what_a_scene_graph_multiplies_is_told(changes, words, tmp_path, monkeypatch):
    """By counts alone, with 20 GB of memory."""
    monkeypatch.setattr(memory, "free", lambda: 20 * 10**9)
    path = tmp_path / "a.glb"
    path.write_bytes(glb())
    assert len(read(path).faces) == 4
    path.write_bytes(glb(**changes))
    assert words in told(path)


def test_the_length_of_a_file_counts(tmp_path, monkeypatch):
    """A text of 1 MB needs a multiple of it."""
    monkeypatch.setattr(memory, "free", lambda: 10**6)
    path = tmp_path / "a.obj"
    path.write_text("# nothing\n" * 10**5)
    assert f"needs about {declared.READ_BYTES} MB of memory, and 1 MB are free" in told(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in folders here")
def test_a_buffer_that_never_ends_is_not_waited_for(tmp_path):
    """A glTF file whose data would come from a pipe or a device."""
    os.mkfifo(tmp_path / "pipe.bin")
    for uri in ("pipe.bin", "/dev/zero"):
        (tmp_path / "a.gltf").write_text(
            json.dumps({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 72, "uri": uri}]})
        )
        assert "it is not a regular file" in told(tmp_path / "a.gltf")
