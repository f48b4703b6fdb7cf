"""PLY files of text and of both byte orders, of odd types, orders and elements: the same box of 1 m3."""

import struct

import pytest
from meshes import CORNERS, SIDES, TRIANGLES

CODES = {
    "char": "b",
    "uchar": "B",
    "short": "h",
    "ushort": "H",
    "int": "i",
    "uint": "I",
    "float": "f",
    "double": "d",
}
QUADS = SIDES
MIXED = [*SIDES[:2], *TRIANGLES[4:].tolist()]
PENTAGONS = [[a, b, c, d, d] for a, b, c, d in SIDES[:3]] + TRIANGLES[6:].tolist()


def ply(
    order="<", faces=QUADS, real="float", length="uchar", index="int", name="vertex_indices", axes="xyz",
    extra=False, end="\n",
):  # fmt: skip
    """A file of the box; `extra`: colours of corners, two lists of faces, and elements before and behind."""
    kinds = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}
    head = ["ply", f"format {kinds[order]} 1.0", "comment Bücher end_header? no", "obj_info snow"]
    body = []

    def put(kind, *values):
        if order:
            body.append(struct.pack(order + CODES[kind] * len(values), *values))
        else:
            body.append((" ".join(f"{v:g}" for v in values) + " ").encode())

    if extra:
        head += ["element camera 2", "property list uchar float view", "property int id"]
        for k in range(2):
            put("uchar", k + 1), put("float", *[0.5] * (k + 1)), put("int", 7)
    head += ["element vertex 8", "property uchar red"][: 2 if extra else 1]
    head += [f"property {real} {axis}" for axis in axes]
    for row in CORNERS.tolist():
        if extra:
            put("uchar", 200)
        put(real, *(row["xyz".index(axis)] for axis in axes))
    head += [f"element face {len(faces)}"] + ["property list uchar float texcoord"] * extra
    head += [f"property list {length} {index} {name}"] + ["property uchar flags"] * extra
    for face in faces:
        if extra:
            put("uchar", 2), put("float", 0.25, 0.75)
        put(length, len(face)), put(index, *face)
        if extra:
            put("uchar", 1)
        if not order:
            body.append(b"\n")
    if extra:
        head += ["element edge 1", "property int vertex1", "property int vertex2"]
        put("int", 0, 1)
    return end.join([*head, "end_header", ""]).encode("latin-1") + b"".join(body)


FILES = {
    f"{word}, {what}": ply(order, **options)
    for word, order in {"text": "", "little-endian": "<", "big-endian": ">"}.items()
    for what, options in {
        "quads": {},
        "triangles": {"faces": TRIANGLES.tolist()},
        "mixed": {"faces": MIXED},
        "repeated corners": {"faces": PENTAGONS},
        "doubles": {"real": "double"},
        "short lengths, unsigned corners": {"length": "ushort", "index": "uint"},
        "int lengths, byte corners": {"length": "int", "index": "uchar", "faces": MIXED},
        "vertex_index": {"name": "vertex_index"},
        "z y x": {"axes": "zyx"},
        "extra elements": {"extra": True},
        "extra elements, mixed": {"extra": True, "faces": MIXED},
        "real corners": {"index": "float"},
        "CR LF": {"end": "\r\n"},
    }.items()
} | {
    "CR": ply("", end="\r"),
    "mark": b"\xef\xbb\xbf" + ply(""),
    "UTF-16": ply("").decode("latin-1").encode("utf-16"),
}


@pytest.mark.parametrize("what", FILES)
def test_the_box_is_read(what, is_box):
    """8 corners and 12 triangles, of 1 m3."""
    found = is_box("a.ply", FILES[what])
    assert (len(found.vertices), len(found.faces)) == (8, 12)


def test_strips(surface):
    """A tetrahedron of edges 1 along the axes as one strip and as three with marks between: 1 / 6 m3."""
    for strip in ("6 0 1 2 3 0 1", "12 0 1 2 3 -1 0 3 1 -1 0 2 3", "7 -1 0 1 2 3 0 1"):
        found = surface(
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
            "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
            f"0 0 0\n1 0 0\n0 1 0\n0 0 1\n{strip}\n",
        )
        assert found.volume == pytest.approx(1 / 6)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (ply("<")[:-10], 'its header says 6 of the element "face", and there are 5: it is cut short'),
        (ply(">", MIXED)[:-10], "and there are 9: it is cut short"),
        (ply("<").replace(b"vertex 8", b"vertex 800"), 'says 800 of the element "vertex", and there are'),
        (ply("")[:-10], "it is cut short"),
        (ply("", [[0, 1, 9]]), "a face names corner 9, and there are 8 (counted from 0)"),
        (ply("<", [[0, 1, 2], [0, 1, -1]]), "a face names corner -1, and there are 8 (counted from 0)"),
        (ply("<").replace(b"property float x", b"property half x"), 'means nothing: "property half x"'),
        (ply("<").replace(b"float x", b"float u"), "its vertices have no x, y and z"),
        (ply("<").replace(b"binary_little_endian", b"binary_middle_endian"), "means nothing"),
        (b"ply\nformat ascii 1.0\n", "its header does not end"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told(content, words, refused):
    """One sentence with what the header says and what is there."""
    assert words in refused("a.ply", content)


def test_no_faces(refused):
    """A cloud of points encloses nothing."""
    assert "holds no triangles" in refused("a.ply", ply("<", []))
