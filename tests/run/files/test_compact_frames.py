"""Compact frames: errors within their bounds, sizes, and what is damaged or cannot be compact."""

import random

import numpy as np
import pytest

from neve.io.errors import RunError
from neve.io.frames import EXACT, arrays_of, frame_path, make_frame, read_frame, stored, write_frame
from neve.io.npz import write_npz

EDGE = 0.32  # of a block: four cells of 0.08 m
POSES = [(np.array([1.0, 2.0, 3.0]), np.eye(3)), (np.array([0.1, 1e4, -3.0]), -np.eye(3))]


def frame(x, v=None, seed=0, **more):
    """A frame of particles at x [m], in the order of their id, with two solids."""
    rng, n = np.random.default_rng(seed), len(x)
    v = rng.normal(0, 3, (n, 3)) if v is None else v
    J_P = rng.uniform(0.6, 1.5, n)
    material = np.repeat(np.arange(3, dtype=np.uint16), (n + 2) // 3)[:n]
    return make_frame(np.asarray(x), v, J_P, np.arange(n, dtype=np.uint32), material, POSES, 0.1, more)


def back(folder, content, edge=EDGE):
    """What is read of a frame that was written compact."""
    write_frame(folder, 0, content, edge)
    return read_frame(folder, 0)


PLACES = {
    "around the origin": lambda rng: rng.uniform(-2, 2, (5000, 3)),
    "on faces of blocks": lambda rng: EDGE * rng.integers(-4, 5, (5000, 3)),
    "just below faces": lambda rng: np.nextafter(
        np.float32(EDGE) * rng.integers(-4, 5, (500, 3)).astype(np.float32), np.float32(-np.inf)
    ),
    "far away": lambda rng: np.array([1e4, -1e4, 5]) + rng.uniform(-2, 2, (5000, 3)),
    "far apart": lambda rng: rng.choice([-1e4, 0, 1e4], (5000, 3)) + rng.uniform(-2, 2, (5000, 3)),
    "in a box of more blocks than numbers": lambda rng: rng.choice([-4e8, 0, 4e8], (900, 3)),
    "one": lambda rng: np.array([[0.1, -0.2, 0.3]]),
    "none": lambda rng: np.zeros((0, 3)),
}


@pytest.mark.parametrize("places", PLACES.values(), ids=PLACES.keys())
def test_a_position_is_half_a_step_off_at_most(tmp_path, places):
    """Half of a 65536th of the edge, and the rounding of a float32 of the position itself."""
    content = frame(places(np.random.default_rng(1)))
    x, found = content.x.astype(np.float64), back(tmp_path, content).x.astype(np.float64)
    assert found.shape == x.shape
    assert (np.abs(found - x) <= EDGE / 131072 * (1 + 1e-9) + 2**-24 * (np.abs(x) + EDGE)).all()


def test_positions_do_not_drift(tmp_path):
    """What is read of a compact frame and written compact again is the same."""
    once = back(tmp_path, frame(np.random.default_rng(2).uniform(-2, 2, (5000, 3))))
    assert np.array_equal(back(tmp_path, once).x, once.x)


@pytest.mark.parametrize("size", [1e-6, 1.0, 6e4, 7e4, 3e9, 1e30])
def test_other_numbers_have_eleven_bits(tmp_path, size):
    """Of numbers of any size the error is 2^-11, or 2^-25 of the scale where they are far below it."""
    rng = np.random.default_rng(3)
    values = (size * rng.uniform(-1, 1, (4000, 6)) * 10.0 ** rng.uniform(-3, 0, (4000, 1))).astype(np.float32)
    found = back(tmp_path, frame(rng.uniform(0, 1, (4000, 3)), tau=values)).more["tau"]
    scale = max(1.0, 2.0 ** np.ceil(np.log2(size / 65504)))
    assert found.dtype == np.float32
    off = np.abs(found.astype(np.float64) - values)
    assert (off <= np.maximum(2**-11 * np.abs(values.astype(np.float64)), 2**-25 * scale)).all()


def test_what_must_be_exact_is(tmp_path):
    """Names, material, mass, volume, solids and time, to the bit and with their types."""
    n, rng = 3000, np.random.default_rng(4)
    more = {"m": rng.uniform(1, 2, n), "V0": rng.uniform(1e-6, 2e-6, n), "source": np.zeros(n, np.uint16)}
    content = frame(rng.uniform(0, 1, (n, 3)), **more)
    found = back(tmp_path, content)
    for name in ("id", "material", "solid_position", "solid_rotation"):
        assert getattr(found, name).dtype == getattr(content, name).dtype
        assert np.array_equal(getattr(found, name), getattr(content, name))
    for name in more:
        assert found.more[name].dtype == content.more[name].dtype
        assert np.array_equal(found.more[name], content.more[name])
    assert found.time == content.time
    assert set(EXACT) >= {"m", "V0", "time"}


@pytest.mark.parametrize("kept", [0.02, 0.5, 0.98])
def test_names_with_gaps(tmp_path, kept):
    """Where sinks have taken particles out, few or most, the names of the others come back."""
    rng = np.random.default_rng(5)
    id = np.flatnonzero(rng.uniform(size=20000) < kept).astype(np.uint32)
    x = rng.uniform(0, 1, (len(id), 3))
    content = make_frame(x, x, None, id, None, [], 0.0)
    found = back(tmp_path, content)
    assert np.array_equal(found.id, id)
    assert found.J_P is found.material is None


@pytest.mark.parametrize(("mixed", "most"), [(False, 14.3), (True, 16.1)])
def test_bytes_of_a_particle(tmp_path, mixed, most):
    """14 bytes of numbers; the block takes next to nothing where neighbours are near, 2 where all mix."""
    rng = np.random.default_rng(6)
    x = np.stack(np.meshgrid(*[np.arange(0, 2, 0.04)] * 3, indexing="ij"), -1).reshape(-1, 3)
    content = frame(rng.permutation(x) if mixed else x)
    write_frame(tmp_path, 0, content, EDGE)
    write_frame(tmp_path, 1, content)
    compact, plain = (frame_path(tmp_path, k).stat().st_size / len(x) for k in (0, 1))
    assert 14.0 < compact < most
    assert plain > 34.0


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 1e12])
def test_what_has_no_block_is_plain(wrong):
    """A frame whose positions or velocities are not finite, or that is beyond all blocks, is kept plain."""
    x = np.zeros((4, 3))
    x[2, 1] = wrong
    assert set(stored(frame(x), EDGE)) == set(arrays_of(frame(x)))
    if not np.isfinite(wrong):
        assert set(stored(frame(np.zeros((4, 3)), x), EDGE)) == set(arrays_of(frame(x)))


def test_every_bit(tmp_path):
    """A flipped bit anywhere in a compact frame is one sentence, or changes nothing that is read."""
    write_frame(tmp_path, 0, frame(np.random.default_rng(7).uniform(-1, 1, (9, 3))), EDGE)
    path, whole = tmp_path / "000000.npz", read_frame(tmp_path, 0)
    data, noticed = path.read_bytes(), 0
    for bit in range(0, 8 * len(data), 53):
        hurt = bytearray(data)
        hurt[bit // 8] ^= 1 << bit % 8
        path.write_bytes(hurt)
        try:
            found = read_frame(tmp_path, 0)
        except RunError as error:
            noticed += "000000.npz is damaged" in str(error)
        else:
            assert all(np.array_equal(a, b) for a, b in zip(found, whole, strict=True))
    assert noticed > 0.5 * 8 * len(data) / 53


WRONG = {
    "blocks that are not there": {"x_block": np.full(9, 60000, np.uint16)},
    "blocks of reals": {"x_block": np.zeros(9)},
    "too few blocks": {"x_block": np.zeros(8, np.uint16)},
    "no blocks": {"x_blocks": np.zeros((0, 3), np.int32)},
    "blocks in a plane": {"x_blocks": np.zeros((9, 2), np.int32)},
    "places of reals": {"x_in_block": np.zeros((9, 3))},
    "one place": {"x_in_block": np.uint16(3)},
    "an edge of none": {"x_edge": np.float64(0)},
    "an endless edge": {"x_edge": np.float64(np.inf)},
    "many edges": {"x_edge": np.ones(3)},
    "edges of words": {"x_edge": np.array("a")},
    "runs too long": {"id_counts": np.array([2**31], np.uint32)},
    "runs of reals": {"id_values": np.zeros(1)},
    "more runs than values": {"id_counts": np.array([4, 5], np.uint32)},
    "names beyond their numbers": {"id_values": np.array([2**32 - 4], np.uint32)},
    "a scale of nothing": {"nothing_scale": np.float64(2)},
    "a scale of words": {"v_scale": np.array("a")},
    "velocities of none": {"v": np.zeros((9, 2), np.float16)},
}


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG.keys())
def test_arrays_that_do_not_belong_together(tmp_path, wrong):
    """An archive that is whole, with arrays of the wrong length, kind or range, is no frame."""
    arrays = stored(frame(np.random.default_rng(8).uniform(-1, 1, (9, 3))), EDGE)
    assert {"id_counts", "x_block"} <= set(arrays)
    with (tmp_path / "000000.npz").open("wb") as file:
        write_npz(file, {**arrays, **wrong})
    with pytest.raises(RunError, match=r"000000\.npz is damaged or is no frame"):
        read_frame(tmp_path, 0)


def test_an_array_that_is_missing(tmp_path):
    """Each array of a compact frame is needed, but those of optional columns."""
    arrays = stored(frame(np.random.default_rng(9).uniform(-1, 1, (9, 3))), EDGE)
    for name in random.Random(1).sample(sorted(arrays), len(arrays)):
        with (tmp_path / "000000.npz").open("wb") as file:
            write_npz(file, {key: values for key, values in arrays.items() if key != name})
        if name in ("J_P", "material"):
            assert getattr(read_frame(tmp_path, 0), name) is None
            continue
        with pytest.raises(RunError, match=r"000000\.npz is damaged or is no frame"):
            read_frame(tmp_path, 0)
