"""STL files of text and binary ones with wrong counts, trailing bytes and odd names: the same box of 1 m3."""

import struct

import numpy as np
import pytest
from meshes import CORNERS, TRIANGLES

from neve.scene.errors import SceneWarning

RECORDS = b"".join(
    struct.pack("<12fH", 0, 0, 0, *CORNERS[t].ravel(), 0x1234)
    for t in TRIANGLES  # colours as attributes
)


def binary(count=12, head=b"made by hand", records=RECORDS, tail=b""):
    """A binary file."""
    return head.ljust(80, b" ") + struct.pack("<I", count) + records + tail


def text(name="box", upper=False, end="\n"):
    """A file of text."""
    rows = [f"solid {name}"]
    for t in TRIANGLES:
        rows += ["facet normal 0 0 0", " outer loop"]
        rows += [f"\tvertex {x:e}   {y:e} {z:e}" for x, y, z in CORNERS[t].tolist()]
        rows += [" endloop", "endfacet"]
    found = end.join([*rows, f"endsolid {name}", ""])
    return found.upper() if upper else found


SILENT = {
    "as it should be": binary(),
    "trailing bytes": binary(tail=b"x" * 37),
    "trailing zeros as long as a triangle": binary(tail=b"\0" * 100),
    "trailing text as long as a triangle": binary(tail=b"~" * 50),
    "named solid": binary(head=b"solid box facet"),
    "named solid, trailing": binary(head=b"solid box", tail=b"\xff" * 11),
    "empty header": binary(head=b"\0" * 80),
    "text": text(),
    "no name": text(""),
    "name of keywords": text("vertex 1 2 3 facet endsolid outer loop endloop"),
    "name in Latin-1": text("Bücher").encode("latin-1"),
    "name in UTF-8": text("雪 box"),
    "marked": b"\xef\xbb\xbf" + text().encode(),
    "UTF-16": text("雪").encode("utf-16"),
    "upper case": text(upper=True),
    "CR LF": text(end="\r\n"),
    "CR": text(end="\r"),
    "spaces before": "\n  " + text(),
    "no last line": text().rpartition("endsolid")[0],
    "all in one line": text(end=" "),
    "two solids": text().replace("endfacet\nfacet", "endfacet\nendsolid a\nsolid b\nfacet", 1),
}


@pytest.mark.parametrize("what", SILENT)
def test_the_box_is_read(what, is_box, recwarn):
    """8 corners and 12 triangles, of 1 m3, and nothing to say."""
    found = is_box("a.stl", SILENT[what])
    assert (len(found.vertices), len(found.faces)) == (8, 12)
    assert not [str(w.message) for w in recwarn if "triangles" in str(w.message)]


@pytest.mark.parametrize("count", [0, 0xFFFFFFFF, 7], ids=str)
def test_a_count_that_is_too_small_or_unknown_is_told(count, is_box):
    """All 12 are read, with a warning that names both counts."""
    with pytest.warns(SceneWarning, match=rf"says {count} triangles in its header, and 12 follow"):
        is_box("a.stl", binary(count))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (binary(13), "its header says 13 triangles, and 12 follow: it is cut short"),
        (binary()[:-3], "its header says 12 triangles, and 11 follow: it is cut short"),
        (binary(0, tail=b"x"), "its header says 0 triangles, and 601 bytes follow"),
        (text()[:900], "its last corner is cut short"),
        (text().replace("endfacet", "", 1), "it is cut short, or damaged"),
        (text().replace("1.000000e+00", "one", 1), '"one" where a number belongs'),
    ],
)
def test_what_is_missing_is_told(content, words, refused):
    """One sentence with the numbers."""
    assert words in refused("a.stl", content)


def test_loops_of_more_than_three_corners_are_polygons(surface):
    """Quads in a file of text, which the format forbids and some programs write."""
    rows = ["solid quads"]
    for side in ([0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]):
        rows += [
            "facet normal 0 0 0",
            "outer loop",
            *(f"vertex {x} {y} {z}" for x, y, z in CORNERS[side].tolist()),
        ]
        rows += ["endloop", "endfacet"]
    assert surface("a.stl", "\n".join([*rows, "endsolid"])).volume == pytest.approx(1.0)


def test_numbers_too_far_out_are_told(surface):
    """5 000 000 m from the origin single precision has steps of 0.5 m: half the width of the box."""
    far = CORNERS + np.array([0.0, 5e5, 0.0])
    records = b"".join(struct.pack("<12fH", 0, 0, 0, *far[t].ravel(), 0) for t in TRIANGLES)
    with pytest.warns(SceneWarning, match=r"single precision, 0\.031 apart so far from its origin"):
        surface("a.stl", binary(records=records))
