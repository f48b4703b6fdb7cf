"""OBJ files as other programs write them: each holds the same box of 1 m3, or is refused by its line."""

import numpy as np
import pytest
from meshes import CORNERS, SIDES, TRIANGLES

ROWS = [f"v {x:g} {y:g} {z:g}" for x, y, z in CORNERS.tolist()]
FACES = ["f " + " ".join(str(i + 1) for i in side) for side in SIDES]
PLAIN = "\n".join([*ROWS, *FACES]) + "\n"


def four_by_four() -> str:
    """Corners in fours, each followed by its face, which counts back."""
    sides = ["\n".join([*(ROWS[i] for i in side), "f -4 -3 -2 -1"]) for side in SIDES]
    return "\n".join(sides) + "\n"


def between() -> str:
    """All corners first, then objects; the second has a corner that nothing names."""
    return "\n".join(["o a", *ROWS, *FACES[:3], "o b", "v 9 9 9", *FACES[3:]]) + "\n"


FILES = {
    "as it should be": PLAIN,
    "no line break at the end": PLAIN.rstrip(),
    "tabs, CR LF": PLAIN.replace(" ", "\t").replace("\n", "\r\n"),
    "CR alone": PLAIN.replace("\n", "\r"),
    "spaces around": "\n".join(f"  {line}   " for line in PLAIN.splitlines()),
    "comments behind": "\n".join(f"{line} # side 1 2 3" for line in PLAIN.splitlines()),
    "comment glued on": PLAIN.replace("f 1 3 4 2", "f 1 3 4 2#side"),
    "Latin-1": "# géométrie\ng Bücher\n".encode("latin-1") + PLAIN.encode(),
    "UTF-8 with a mark": "﻿# Schnee 雪\n".encode() + PLAIN.encode(),
    "mark before a corner": "﻿".encode() + PLAIN.encode(),
    "UTF-16 with a mark": ("o 雪\n" + PLAIN).encode("utf-16"),
    "UTF-16 without": PLAIN.encode("utf-16-le"),
    "UTF-16 big-endian without": PLAIN.encode("utf-16-be"),
    "UTF-32": PLAIN.encode("utf-32"),
    "corners between faces": four_by_four(),
    "objects": between(),
    "counted back": "\n".join([*ROWS, *("f " + " ".join(str(i - 8) for i in side) for side in SIDES)]),
    "faces first": "\n".join([*FACES, *ROWS]),
    "textures and normals": "\n".join(
        ["vt 0 0", "vn 0 0 1", *ROWS, *("f " + " ".join(f"{i + 1}/1/1" for i in side) for side in SIDES)]
    ),
    "normals": "\n".join(["vn 0 0 1", *ROWS, *("f " + " ".join(f"{i + 1}//1" for i in s) for s in SIDES)]),
    "of several kinds": "\n".join(
        ["vt 0 0", *ROWS, *FACES[:2], *("f " + " ".join(f"{i + 1}/-1" for i in s) for s in SIDES[2:])]
    ),
    "colours": "\n".join([*(f"{row} 0.1 0.2 0.3" for row in ROWS), *FACES]),
    "colours of some, weights of others": "\n".join(
        [*(f"{row} 0.1 0.2 0.3" for row in ROWS[:3]), *(f"{row} 1.0" for row in ROWS[3:6]), *ROWS[6:], *FACES]
    ),
    "continued lines": PLAIN.replace("f 1 3 4 2", "f 1 3 \\\n4 \\\r\n 2").replace(
        "v 0.5 1 2.75", "v 0.5 \\\n1 2.75", 1
    ),
    "a comment that ends in a backslash": "# C:\\snow\\\n" + PLAIN,
    "triangles and quads": "\n".join(
        [*ROWS, *("f " + " ".join(str(i + 1) for i in t) for t in TRIANGLES[:6].tolist()), *FACES[3:]]
    ),
    "groups, materials, lines, points": "mtllib a b.mtl\nusemtl v\ns off\ng f 1 2 3\nl 1 2\np 1\n" + PLAIN,
    "a face that repeats a corner": PLAIN.replace("f 1 3 4 2", "f 1 3 4 4 2") + "f 1 1 2\nf 2 2 2\n",
    "a corner that nothing names": "v 100 100 100\n" + four_by_four(),
    "exponents and signs": PLAIN.replace("0.5", "+5.0E-1").replace("f 1 ", "f +1 "),
    "every face twice": PLAIN + "\n".join(FACES),
    "a face turned round": PLAIN.replace("f 5 6 8 7", "f 7 8 6 5"),
    "inside out": "\n".join([*ROWS, *("f " + " ".join(str(i + 1) for i in s[::-1]) for s in SIDES)]),
    "every second inside out": "\n".join(
        [*ROWS, *("f " + " ".join(str(i + 1) for i in s[:: 1 - 2 * (k % 2)]) for k, s in enumerate(SIDES))]
    ),
}


@pytest.mark.parametrize("what", FILES)
def test_the_box_is_read(what, is_box):
    """8 corners and 12 triangles, of 1 m3."""
    found = is_box("a.obj", FILES[what])
    assert (len(found.vertices), len(found.faces)) == (8, 12)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("v 0.5 1 2.75", "v 0,5 1 2.75", 'line 1 has "0,5" where a number belongs'),
        ("v 0.5 1 2.75", "v 0.5 1", "line 1 has a corner of fewer than three numbers"),
        ("f 1 3 4 2", "f 0 3 4 2", 'line 9 has "0" where the number of a corner belongs'),
        ("f 1 3 4 2", "f 1 3 4 9", "the face of line 9 names a corner that is not there, of 8"),
        ("f 1 3 4 2", "f 1 3 4 -9", "the face of line 9 names a corner that is not there, of 8"),
        ("f 1 3 4 2", "f a b c", 'line 9 has "a" where the number of a corner belongs'),
    ],
)
def test_what_is_wrong_is_told_by_its_line(old, new, words, refused):
    """The sentence names the line and what stands there."""
    assert words in refused("a.obj", PLAIN.replace(old, new, 1))


def test_many_lines_are_read_in_any_order(surface):
    """A thousand boxes of four-by-four corners: 1000 m3, each where it is."""
    text = []
    for k in range(1000):
        moved = CORNERS + 4.0 * np.array([k % 10, k // 10 % 10, k // 100])
        for side in SIDES:
            text += [f"v {x} {y} {z}" for x, y, z in moved[side].tolist()] + ["f -4 -3 -2 -1"]
    found = surface("a.obj", "\n".join(text))
    assert (len(found.vertices), len(found.faces), found.open_edges) == (8000, 12000, 0)
    assert found.volume == pytest.approx(1000.0)
    assert found.high == pytest.approx(np.array([37.5, 39.0, 39.25]))
