"""Tables and frames of a run read back what was written; damaged ones give it back, or one sentence."""

import contextlib
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from neve.fragments import COLUMNS as FRAGMENTS
from neve.io.checkpoint import read_checkpoint, write_checkpoint
from neve.io.errors import RunError
from neve.io.frames import Frame, make_frame, read_frame, write_frame
from neve.io.log import columns
from neve.io.table import Table, read_table
from neve.registry import METHODS
from neve.run.outputs.solids import COLUMNS as SOLIDS

TABLES = {"log": columns(METHODS.names()[0]), "solids": SOLIDS, "fragments": FRAGMENTS}
WORDS = ("bound", "kind", "solid")
CELL = st.none() | st.floats() | st.integers(-(2**70), 2**70)
WORD = st.text(st.characters(codec="utf-8"), max_size=8)
"""Words of a column: names in robot files may hold any character, ends of lines too."""


def rows(names):
    """Rows of a table, frames in order: numbers, nothing, and any word where words stand."""
    cells = {name: WORD if name in WORDS else CELL for name in names if name != "frame"}
    return st.lists(st.fixed_dictionaries(cells), max_size=4).map(
        lambda found: [{"frame": k, **row} for k, row in enumerate(found)]
    )


def sentence_of(call, path):
    """The result of a call, or None and its sentence, which is one line and names the file."""
    try:
        return call()
    except RunError as error:
        sentence = str(error)
    assert path.name in sentence
    assert "\n" not in sentence
    return None


@st.composite
def hurt(draw, data):
    """Bytes with a few places cut out, doubled, flipped or written over."""
    data = bytearray(data)
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, len(data)))
        match draw(st.sampled_from(["flip", "cut", "double", "end", "write", "line"])):
            case "flip" if at < len(data):
                data[at] ^= 1 << draw(st.integers(0, 7))
            case "cut":
                del data[at : at + draw(st.integers(1, 40))]
            case "double":
                data[at:at] = data[at : at + draw(st.integers(1, 200))]
            case "end":
                del data[at:]
            case "line":
                data[at:at] = draw(
                    st.sampled_from([b"\n", b"\r", b'"', b",,,\n", b"\x00", b"\xff", b"\n1,2\n"])
                )
            case _:
                data[at : at + 4] = draw(st.binary(min_size=1, max_size=8))
    return bytes(data)


@pytest.mark.parametrize("name", TABLES)
def test_a_table_reads_back_what_was_written(name, tmp_path):
    """Numbers to the last bit, nan and nothing as nothing, words as they are; also after a resume."""
    path, names = tmp_path / f"{name}.csv", TABLES[name]

    @given(rows(names), st.integers(-1, 4))
    def holds(written, through):
        table = Table(path, names)
        for row in written:
            table.append(row)
        found = read_table(path, names)
        assert len(found) == len(written)
        for row, cells in zip(written, found, strict=True):
            assert [key for key, value in row.items() if not same(value, cells[key])] == []
        Table(path, names, keep_through=through)
        assert read_table(path, names) == [row for row in found if int(row["frame"]) <= through]

    holds()


def same(value, cell):
    """Whether a cell says what was written."""
    if isinstance(value, str):
        return cell == value
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return cell == ""
    return type(value)(cell) == value


@pytest.mark.parametrize("name", TABLES)
def test_a_damaged_table_is_rows_or_a_sentence(name, tmp_path):
    """Whatever was done to the file, to read it or to go on with it gives rows, or one sentence."""
    path, names = tmp_path / f"{name}.csv", TABLES[name]
    table = Table(path, names)
    for frame in range(3):
        table.append({key: "w" if key in WORDS else 0.5 for key in names} | {"frame": frame})
    whole = path.read_bytes()

    @given(hurt(whole))
    def holds(data):
        path.write_bytes(data)
        found = sentence_of(lambda: read_table(path, names), path)
        assert found is None or all(row["frame"].isdecimal() and len(row) == len(names) for row in found)
        again = sentence_of(lambda: Table(path, names, keep_through=1), path)
        if again is not None:
            assert all(int(row["frame"]) <= 1 for row in read_table(path, names))

    holds()


def floats(*shape):
    return arrays.arrays(np.float32, shape, elements=st.floats(-(2.0**99), 2.0**99, width=32))


@st.composite
def frames(draw):
    """Frames of up to eight particles and two solids."""
    n, s = draw(st.integers(0, 8)), draw(st.integers(0, 2))
    poses = [(draw(floats(3)), draw(floats(3, 3))) for _ in range(s)]
    optional = draw(st.booleans())
    return make_frame(
        draw(floats(n, 3)),
        draw(floats(n, 3)),
        draw(floats(n)) if optional else None,
        np.array(draw(st.permutations(range(n))), np.uint32),
        draw(arrays.arrays(np.uint16, n)) if optional else None,
        poses,
        draw(st.floats(0, 1e5)),
    )


def equal(a: Frame, b: Frame) -> bool:
    return all(
        (x is None) == (y is None) and (x is None or np.array_equal(x, y)) for x, y in zip(a, b, strict=True)
    )


def test_a_frame_reads_back_what_was_written(tmp_path):
    """To the last bit, with no particle and no solid too."""

    @given(frames())
    def holds(frame):
        write_frame(tmp_path, 7, frame)
        assert equal(read_frame(tmp_path, 7), frame)

    holds()


def test_a_damaged_frame_is_the_same_or_a_sentence(tmp_path):
    """A checksum sees what was changed: what is read is what was written, or one sentence names the file."""
    x = np.random.default_rng(1).random((6, 3), np.float32)
    frame = make_frame(x, x, x[:, 0], np.arange(6), np.zeros(6, np.uint16), [(np.zeros(3), np.eye(3))], 0.5)
    write_frame(tmp_path, 0, frame)
    path = tmp_path / "000000.npz"

    @given(hurt(path.read_bytes()))
    def holds(data):
        path.write_bytes(data)
        found = sentence_of(lambda: read_frame(tmp_path, 0), path)
        assert found is None or equal(found, frame)

    holds()


def test_a_damaged_checkpoint_is_the_same_or_a_sentence(tmp_path):
    """The same for the checkpoint."""
    path = tmp_path / "checkpoint.npz"
    values = {"x": np.random.default_rng(1).random((6, 3)), "id": np.arange(6, dtype=np.uint32)}
    write_checkpoint(path, 3, "about = 'a'\n", "1.2.3", values)
    whole = read_checkpoint(path)

    @given(hurt(path.read_bytes()))
    def holds(data):
        path.write_bytes(data)
        found = sentence_of(lambda: read_checkpoint(path), path)
        if found is None:
            return
        assert found.frame == whole.frame
        with contextlib.suppress(RunError):  # an array that is gone is told when it is asked for
            assert all(np.array_equal(found.arrays[name], value) for name, value in values.items())

    holds()
