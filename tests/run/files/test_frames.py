"""Frame files: what is read back, and what is refused."""

import io
import zipfile

import numpy as np
import pytest

from neve.io.errors import RunError
from neve.io.frames import arrays_of, frame_path, make_frame, read_frame, rows_by_id, write_frame
from neve.io.npz import read_npz, write_npz

SOLIDS = [(np.array([1.0, 2.0, 3.0]), np.eye(3)), (np.zeros(3), -np.eye(3))]


def frame():
    """A frame of two particles, out of the order of their id, and two solids."""
    x = np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])
    return make_frame(x, -x, np.array([1.0, 0.5]), np.array([7, 3]), np.array([0, 1]), SOLIDS, 0.25)


def test_a_frame_is_read_as_it_was_written(tmp_path):
    """Particles in the order of their id; solids in the order in which they were given."""
    write_frame(tmp_path, 4, frame())
    back = read_frame(tmp_path, 4)
    assert back.id.tolist() == [3, 7]
    assert back.x.tolist() == [[3.0, 4.0, 5.0], [0.0, 1.0, 2.0]]
    assert back.solid_position.tolist() == [[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]]
    assert back.solid_rotation[1].tolist() == (-np.eye(3)).tolist()
    assert back.time == 0.25


def test_a_frame_of_an_older_neve_is_refused_in_one_sentence(tmp_path):
    """An older Neve called the arrays of solids body_position and body_rotation."""
    old = {name.replace("solid_", "body_"): value for name, value in arrays_of(frame()).items()}
    with frame_path(tmp_path, 4).open("wb") as file:
        write_npz(file, old)
    with pytest.raises(
        RunError, match=r"000004\.npz was written by an older Neve; run its scene\.toml again"
    ):
        read_frame(tmp_path, 4)


@pytest.mark.parametrize("id", [[], [0], [2, 0, 1], [5, 1, 3], [10**9, 7, 10**6]])
def test_rows_come_in_the_order_of_their_id(id):
    """With and without gaps, as a sort would put them."""
    id = np.array(id, np.uint32)
    assert id[rows_by_id(id)].tolist() == sorted(id.tolist())


def test_arrays_come_back_whatever_their_layout(tmp_path):
    """By rows, by columns, strided, empty, without dimension, of words: values, and bytes as of `np.save`."""
    a = np.arange(24.0).reshape(2, 3, 4)
    arrays = {"rows": a, "columns": a.T, "strided": a[:, ::2], "empty": a[:0], "none": np.float64(3)}
    arrays |= {"words": np.array(["ab", "c"]), "big": a.astype(">f4"), "bools": a > 3, "whole": np.arange(3)}
    with (tmp_path / "a.npz").open("wb") as file:
        write_npz(file, arrays)
    back = read_npz(tmp_path / "a.npz")
    assert list(back) == list(arrays)
    with zipfile.ZipFile(tmp_path / "a.npz") as archive:
        for name, values in arrays.items():
            assert np.array_equal(back[name], values)
            assert back[name].dtype == values.dtype
            buffer = io.BytesIO()
            np.save(buffer, values)
            assert archive.read(f"{name}.npy") == buffer.getvalue()
