"""glTF files, text and binary: the same box of 1 m3 by every way in which glTF can say where corners are."""

import base64
import json
import struct

import numpy as np
import pytest
from meshes import CORNERS, TRIANGLES

MIDDLE = np.array([1.0, 2.0, 3.0])
UNIT = (CORNERS - MIDDLE) / [0.5, 1.0, 0.25]
"""The corners of the cube from -1 to 1 that the box is of."""
TURN = [0.0, 0.0, np.sin(np.pi / 4), np.cos(np.pi / 4)]
"""A quarter turn about z, as x, y, z, w."""


class Maker:
    """Put a tree and its data together."""

    def __init__(self):
        self.data = b""
        self.tree = {
            "asset": {"version": "2.0"},
            "bufferViews": [],
            "accessors": [],
            "meshes": [],
            "nodes": [],
        }

    def view(self, data, **more):
        """Add bytes; return their view."""
        self.data += b"\0" * (-len(self.data) % 4)
        views = self.tree["bufferViews"]
        views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)} | more)
        self.data += data
        return len(views) - 1

    def accessor(self, values, kind, what="VEC3", **more):
        """Add numbers of a type; return their accessor."""
        code = {"b": 5120, "B": 5121, "h": 5122, "H": 5123, "I": 5125, "f": 5126}[kind]
        about = {"componentType": code, "count": len(values), "type": what}
        data = np.ascontiguousarray(
            np.asarray(values), "<" + {"b": "i1", "B": "u1"}.get(kind, kind)
        ).tobytes()
        self.tree["accessors"].append({"bufferView": self.view(data)} | about | more)
        return len(self.tree["accessors"]) - 1

    def mesh(self, points=CORNERS, indices=TRIANGLES, kind="H", **more):
        """Add a mesh of one piece; return it."""
        piece = {
            "attributes": {"POSITION": points if isinstance(points, int) else self.accessor(points, "f")}
        }
        if indices is not None:
            piece["indices"] = self.accessor(np.ravel(indices), kind, "SCALAR")
        self.tree["meshes"].append({"primitives": [piece | more]})
        return len(self.tree["meshes"]) - 1

    def node(self, **about):
        """Add a node; return it."""
        self.tree["nodes"].append(about)
        return len(self.tree["nodes"]) - 1

    def text(self, uri="data:application/octet-stream;base64,", **tables):
        """The file as text, its data in it or in another file."""
        where = uri + base64.b64encode(self.data).decode() if uri.endswith("base64,") else uri
        buffers = {"buffers": [{"byteLength": len(self.data), "uri": where}]}
        return json.dumps({k: v for k, v in self.tree.items() if v} | buffers | tables)

    def glb(self, **tables):
        """The file in binary."""
        buffers = {"buffers": [{"byteLength": len(self.data)}]}
        head = json.dumps({k: v for k, v in self.tree.items() if v} | buffers | tables).encode()
        head, data = head + b" " * (-len(head) % 4), self.data + b"\0" * (-len(self.data) % 4)
        chunks = (
            struct.pack("<I4s", len(head), b"JSON") + head + struct.pack("<I4s", len(data), b"BIN\0") + data
        )
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def shown(**node):
    """A file with the box in one node, which `node` moves."""
    m = Maker()
    m.node(mesh=m.mesh(), **node)
    return m


def of_points(points, **node):
    """A file with the box of an accessor made by `points`."""
    m = Maker()
    m.node(mesh=m.mesh(points(m)), **node)
    return m


def sparse(m, whole=True):
    """Corners of which two are replaced; or all, of an accessor without data."""
    rows = np.arange(8) if not whole else np.array([2, 5])
    wrong = CORNERS.copy()
    wrong[rows] = 77.0
    index = m.accessor(wrong, "f")
    about = m.tree["accessors"][index]
    if not whole:
        del about["bufferView"]
    about["sparse"] = {
        "count": len(rows),
        "indices": {"bufferView": m.view(rows.astype("<u2").tobytes()), "componentType": 5123},
        "values": {"bufferView": m.view(CORNERS[rows].astype("<f4").tobytes())},
    }
    return index


def interleaved(m):
    """Corners between normals and colours, 28 bytes apart, of which the first 12 are skipped."""
    rows = np.zeros((8, 7), "<f4")
    rows[:, 3:6] = CORNERS
    view = m.view(rows.tobytes(), byteStride=28)
    m.tree["accessors"].append(
        {"bufferView": view, "byteOffset": 12, "componentType": 5126, "count": 8, "type": "VEC3"}
    )
    return len(m.tree["accessors"]) - 1


def quantized(kind, normalized):
    """Corners as whole numbers, as KHR_mesh_quantization allows."""
    most = np.iinfo({"b": "i1", "h": "i2", "B": "u1", "H": "u2"}[kind]).max
    low = -1 if kind in "bh" else 0
    values = np.where(UNIT > 0, most, low * most)
    size = np.array([1.0, 2.0, 0.5]) / (1 - low) / (1 if normalized else most)
    middle = MIDDLE if low else MIDDLE - [0.5, 1.0, 0.25]
    m = of_points(
        lambda m: m.accessor(values, kind, normalized=normalized),
        translation=middle.tolist(),
        scale=size.tolist(),
    )
    m.tree["extensionsRequired"] = m.tree["extensionsUsed"] = ["KHR_mesh_quantization"]
    return m


def strips(mode):
    """Each side of the box as a strip, or as a fan."""
    m = Maker()
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    runs = sides if mode == 6 else [[a, b, d, c] for a, b, c, d in sides]
    for run in runs:
        m.node(mesh=m.mesh(indices=run, mode=mode))
    return m


def instanced():
    """Eight boxes of an eighth by instances, moved, scaled and turned; the node above stretches them."""
    m = Maker()
    cube = m.mesh(UNIT * 0.5)
    places = 0.5 * UNIT * 0.5
    node = {"translation": MIDDLE.tolist(), "scale": [1.0, 2.0, 0.5], "mesh": cube}
    parts = {
        "TRANSLATION": m.accessor(places, "f"),
        "SCALE": m.accessor(np.full((8, 3), 0.5), "f"),
        "ROTATION": m.accessor(np.rint(np.tile(TURN, (8, 1)) * 32767), "h", "VEC4", normalized=True),
    }
    m.node(**node, extensions={"EXT_mesh_gpu_instancing": {"attributes": parts}})
    m.tree["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    return m


def nested():
    """A node in a node in a node: moved, turned, scaled by a matrix."""
    m = Maker()
    turned = UNIT[:, [1, 0, 2]] * [1, -1, 1]  # a quarter turn back about z
    m.node(children=[1], translation=MIDDLE.tolist())
    m.node(children=[2], matrix=np.diag([0.5, 1.0, 0.25, 1.0]).T.ravel().tolist())
    m.node(mesh=m.mesh(turned), rotation=TURN)
    m.tree["scenes"] = [{"nodes": []}, {"nodes": [0]}]
    m.tree["scene"] = 1
    return m


def morphed():
    """Half of a morph target that is twice too far."""
    m = Maker()
    target = {"POSITION": m.accessor(2.0 * (CORNERS - UNIT), "f")}
    m.node(mesh=m.mesh(UNIT, targets=[target, target]), weights=[0.5, 0.0])
    return m


def skinned():
    """Corners on two joints; the node's own place does not count (section 3.7.3.3)."""
    m = Maker()
    bind = np.tile(np.eye(4), (2, 1, 1))
    bind[:, :3, 3] = [[-1.0, 0.0, 0.0], [0.0, -2.0, 0.0]]
    mesh = m.mesh(CORNERS)
    attributes = m.tree["meshes"][mesh]["primitives"][0]["attributes"]
    attributes["JOINTS_0"] = m.accessor(np.tile([0, 1, 0, 0], (8, 1)), "B", "VEC4")
    attributes["WEIGHTS_0"] = m.accessor(np.tile([0.25, 0.75, 0, 0], (8, 1)), "f", "VEC4")
    m.node(mesh=mesh, skin=0, translation=[50.0, 0.0, 0.0])
    m.node(translation=[1.0, 0.0, 0.0]), m.node(translation=[0.0, 2.0, 0.0])
    matrices = m.accessor(bind.swapaxes(1, 2).reshape(2, 16), "f", "MAT4")
    m.tree["skins"] = [{"joints": [1, 2], "inverseBindMatrices": matrices}]
    return m


def without_indices():
    """Three corners of its own for each triangle."""
    m = Maker()
    m.node(mesh=m.mesh(CORNERS[TRIANGLES.ravel()], None))
    return m


def without_nodes():
    """A mesh that no node shows, in a file without nodes."""
    m = Maker()
    m.mesh()
    return m


def of_kinds():
    """Lines and points beside the triangles."""
    m = shown()
    m.node(mesh=m.mesh(CORNERS * 9, mode=1)), m.node(mesh=m.mesh(CORNERS * 9, mode=0))
    return m


FILES = {
    "plain": shown(),
    "8-bit indices": (lambda m: (m.node(mesh=m.mesh(kind="B")), m)[1])(Maker()),
    "32-bit indices": (lambda m: (m.node(mesh=m.mesh(kind="I")), m)[1])(Maker()),
    "no indices": without_indices(),
    "sparse": of_points(sparse),
    "sparse without data": of_points(lambda m: sparse(m, whole=False)),
    "interleaved": of_points(interleaved),
    **{
        f"{kind}, {'normalised' if normalized else 'whole'}": quantized(kind, normalized)
        for kind in "bBhH"
        for normalized in (True, False)
    },
    "strips": strips(5),
    "fans": strips(6),
    "instances": instanced(),
    "nested": nested(),
    "mirrored": of_points(lambda m: UNIT * [-1, 1, 1], translation=[1, 2, 3], scale=[-0.5, 1.0, 0.25]),
    "morphed": morphed(),
    "skinned": skinned(),
    "no nodes": without_nodes(),
    "lines and points": of_kinds(),
}


@pytest.mark.parametrize("binary", [False, True], ids=["gltf", "glb"])
@pytest.mark.parametrize("what", FILES)
def test_the_box_is_read(what, binary, is_box):
    """1 m3 at its place, closed, outside out; whole numbers and quarter turns of 16 bits within 3e-5."""
    made = FILES[what]
    is_box(f"a.{'glb' if binary else 'gltf'}", made.glb() if binary else made.text(), within=5e-5)


def test_mirrored_instances_beside_others(surface):
    """A box and its mirror image, which is turned round: 2 m3."""
    m = Maker()
    box = m.mesh()
    m.node(mesh=box), m.node(mesh=box, scale=[-1.0, 1.0, 1.0])
    found = surface("a.glb", m.glb())
    assert found.volume == pytest.approx(2.0)
    assert found.low[0] == pytest.approx(-1.5)


@pytest.mark.parametrize(
    ("name", "uri"),
    [
        ("buffer file.bin", "buffer%20file.bin"),
        ("buffer file.bin", "buffer file.bin"),
        ("Bücher.bin", "B%C3%BCcher.bin"),
        ("100%25.bin", "100%25.bin"),
        ("100%.bin", "100%25.bin"),
        ("a#b.bin", "a%23b.bin"),
        ("sub/b.bin", "./sub/b.bin"),
    ],
)
def test_names_of_data(name, uri, is_box, tmp_path):
    """Percent-encoded or not, in folders below."""
    made = shown()
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_bytes(made.data)
    is_box("a.gltf", made.text(uri))


def test_data_uris(is_box):
    """Base64 without its last signs, of another kind, in capitals, and percent-encoded."""
    made = shown()
    whole = base64.b64encode(made.data).decode()
    for uri in (
        "data:application/gltf-buffer;base64," + whole.rstrip("="),
        "DATA:;BASE64," + whole,
        "data:application/octet-stream," + "".join(f"%{byte:02x}" for byte in made.data),
    ):
        is_box("a.gltf", made.text(uri))


def test_text_with_a_mark_and_binary_by_another_name(is_box):
    """What a file is shows by its beginning."""
    is_box("a.gltf", "﻿".encode() + shown().text().encode())
    is_box("b.gltf", shown().glb())
    is_box("c.glb", shown().text())


BAD = {
    "Draco": ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "requires KHR_draco_mesh_compression,"),
    "meshopt": ({"extensionsRequired": ["EXT_meshopt_compression"]}, "requires EXT_meshopt_compression,"),
    "two": ({"extensionsRequired": ["A_b", "KHR_materials_unlit", "C_d"]}, "requires A_b and C_d, which"),
    "old": ({"asset": {"version": "1.0"}}, "it is glTF 1.0: export it as glTF 2.0"),
    "a loop": ({"nodes": [{"mesh": 0, "children": [1]}, {"children": [1]}]}, "node 1 is shown twice, or"),
    "lost mesh": ({"nodes": [{"mesh": 3}]}, "number 3 of its meshes, and there are 1"),
    "lost file": ({"buffers": [{"byteLength": 168, "uri": "none.bin"}]}, "the file none.bin with its data"),
    "the net": ({"buffers": [{"byteLength": 168, "uri": "https://a.b/c.bin"}]}, "its data is elsewhere"),
    "short data": ({"buffers": [{"byteLength": 9, "uri": "data:,abcdefghi"}]}, "it is cut short"),
    "bad index": ({"scenes": [{"nodes": ["a"]}]}, "its node of a scene is no whole number"),
    "turn": ({"nodes": [{"mesh": 0, "rotation": [1, 2]}]}, "the rotation of a node is not 4 numbers"),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD)
def test_what_is_not_read_is_told_by_its_name(what, refused):
    """One sentence that names the extension, the table or the file."""
    tables, words = BAD[what]
    assert words in refused("a.gltf", shown().text(**tables))


def test_compressed_data_that_is_not_required(refused, is_box):
    """Draco with a way round is passed over; without one it is told, as is meshopt."""
    packed = {"extensions": {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}}
    m = shown()
    m.tree["meshes"][0]["primitives"][0] |= packed
    is_box("a.glb", m.glb())
    del m.tree["accessors"][0]["bufferView"]
    assert "it is compressed with KHR_draco_mesh_compression, which is not read" in refused("a.glb", m.glb())
    m = shown()
    m.tree["bufferViews"][0]["extensions"] = {"EXT_meshopt_compression": {"mode": "ATTRIBUTES"}}
    assert "it is compressed with EXT_meshopt_compression, which is not read" in refused("a.glb", m.glb())


def test_cut_short(refused):
    """A binary file says how long it is."""
    whole = shown().glb()
    assert f"it says to have {len(whole)} bytes, and has {len(whole) - 8}: it is cut short" in refused(
        "a.glb", whole[:-8]
    )
