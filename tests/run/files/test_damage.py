"""Damaged folders of a run: one sentence, or the bytes of a run that nobody has hurt."""

import csv
import io
import json
import random
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from neve.io.card import FORMAT, Card, read_card, write_card
from neve.io.checkpoint import read_checkpoint, write_checkpoint
from neve.io.errors import RunError
from neve.io.frames import arrays_of, make_frame, read_frame, write_frame
from neve.io.npz import mark_of, read_npz, write_npz
from neve.run import run, run_scene
from neve.run.outputs.fragments import count_run
from neve.scene.reading.load import load


@pytest.fixture
def snow(scene_file):
    """A scene with fragments."""
    text = scene_file.read_text().replace("[run]", "[run]\nfragments = true\nfilm = false")
    scene_file.write_text(text)
    return load(scene_file)


@pytest.fixture
def half(fake, snow, tmp_path):
    """The folder of a run that was stopped after four of eight frames."""
    run(fake.Simulation(snow), tmp_path / "half", frames=4, quiet=True)
    return tmp_path / "half"


@pytest.fixture
def whole(fake, snow, tmp_path):
    """The folder of the same run in one go."""
    run(fake.Simulation(snow), tmp_path / "whole", quiet=True)
    return tmp_path / "whole"


def content(folder):
    """Every file with its bytes; of the log the columns without wall times."""
    found = {str(p.relative_to(folder)): p.read_bytes() for p in Path(folder).rglob("*") if p.is_file()}
    rows = list(csv.DictReader(io.StringIO(found["log.csv"].decode())))
    timeless = [{k: v for k, v in row.items() if not k.startswith("seconds_")} for row in rows]
    return found | {"log.csv": timeless}


def refused(call, *arguments):
    """What a call returns, and the sentence by which it refuses."""
    try:
        return call(*arguments), ""
    except RunError as error:
        return None, str(error)


def frame(n=6):
    x = np.random.default_rng(1).random((n, 3), np.float32)
    pose = (np.zeros(3), np.eye(3))
    return make_frame(x, x, x[:, 0], np.arange(n, dtype=np.uint32), np.zeros(n, np.uint16), [pose], 0.5)


def test_every_bit_of_a_frame(tmp_path):
    """A flipped bit anywhere in a frame file is one sentence, or changes nothing that is read."""
    write_frame(tmp_path, 0, frame())
    path, whole = tmp_path / "000000.npz", read_frame(tmp_path, 0)
    data = path.read_bytes()
    noticed = 0
    for bit in range(0, 8 * len(data), 61):
        hurt = bytearray(data)
        hurt[bit // 8] ^= 1 << bit % 8
        path.write_bytes(hurt)
        found, sentence = refused(read_frame, tmp_path, 0)
        noticed += "000000.npz is damaged" in sentence
        assert sentence or all(np.array_equal(a, b) for a, b in zip(found, whole, strict=True))
    assert noticed > 0.5 * 8 * len(data) / 61  # the rest are dates, versions and rights, which nobody reads


def test_cut_and_mixed_frames(tmp_path):
    """A frame that ends early, has bytes of another file in it, or is empty, is one sentence."""
    write_frame(tmp_path, 0, frame())
    path = tmp_path / "000000.npz"
    data, rng = path.read_bytes(), random.Random(1)
    for _ in range(200):
        start, length = rng.randrange(len(data)), rng.randrange(1, 200)
        cut = data[:start] + rng.choice([b"", rng.randbytes(length)]) + data[start + length :]
        path.write_bytes(cut if rng.random() < 0.7 else data[:start])
        _, sentence = refused(read_frame, tmp_path, 0)
        assert "damaged" in (sentence or "damaged")


WRONG = {
    "x too short": {"x": np.zeros((5, 3), np.float32)},
    "x of words": {"x": np.array(["a"] * 6)},
    "x of one number": {"x": np.float32(3)},
    "x without numbers": {"x": np.full((6, 3), np.nan, np.float32)},
    "ids of reals": {"id": np.zeros(6)},
    "time of many": {"time": np.zeros(2)},
    "time of words": {"time": np.array("now")},
    "solids of two kinds": {"solid_position": np.zeros((2, 3), np.float32)},
    "material of records": {"material": np.zeros(6, [("a", "i4")])},
}


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG.keys())
def test_a_frame_whose_arrays_are_wrong(tmp_path, wrong):
    """An archive that is whole, with arrays of the wrong length or kind, is no frame."""
    with open(tmp_path / "000000.npz", "wb") as file:
        write_npz(file, {**arrays_of(frame()), **wrong})
    with pytest.raises(RunError, match=r"000000\.npz is damaged or is no frame"):
        read_frame(tmp_path, 0)


def test_compressed_frames_are_read(tmp_path):
    """Who saves frames again to spare the disk still reads them."""
    np.savez_compressed(tmp_path / "000000.npz", **arrays_of(frame()))
    assert np.array_equal(read_frame(tmp_path, 0).x, frame().x)


def bomb(path, declared, content):
    """An archive of an array that is compressed to almost nothing, and says to be `declared` bytes."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("x.npy", content)
    data = bytearray(path.read_bytes())
    at = data.rindex(b"PK\x01\x02")
    struct.pack_into("<I", data, at + 24, declared)
    path.write_bytes(data)


@pytest.mark.parametrize("declared", [2**31, 3_000])
def test_a_small_file_does_not_fill_the_memory(tmp_path, declared):
    """An archive that holds, or says to hold, far more than its size is refused before it is unpacked."""
    import tracemalloc

    path = tmp_path / "000000.npz"
    bomb(path, declared, bytes(200_000_000))
    tracemalloc.start()
    try:
        with pytest.raises(RunError, match="damaged"):
            read_frame(tmp_path, 0)
        assert tracemalloc.get_traced_memory()[1] < 20_000_000
    finally:
        tracemalloc.stop()


def test_a_header_that_says_too_much(tmp_path):
    """The shape in the header of an array is not believed."""
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("x.npy", head.getvalue() + bytes(80))
    with pytest.raises(ValueError, match="its size"):
        read_npz(tmp_path / "a.npz")


def test_arrays_of_all_kinds_come_back(tmp_path):
    """Empty, scalar, Fortran-ordered, words: what is written is read, with the mark that writing gave."""
    arrays = {"a": np.zeros((0, 3)), "b": 1.5, "c": np.asfortranarray(np.arange(6.0).reshape(2, 3)), "d": "é"}
    with open(tmp_path / "a.npz", "wb") as file:
        mark = write_npz(file, arrays)
    found = read_npz(tmp_path / "a.npz")
    assert all(np.array_equal(found[name], value) for name, value in arrays.items())
    assert mark_of(tmp_path / "a.npz") == mark


@pytest.mark.parametrize(
    "text",
    [
        '{"run_format": Infinity}',
        '{"run_format": 1e999}',
        '{"run_format": true}',
        '{"run_format": "2"}',
        '{"run_format": 2, "crc32": 7}',
        "[" * 100_000,
        '{"run_format":' + "[" * 100_000,
        "[2]",
        "\x00\x01",
        "",
        '{"neve": "1"}',
        '{"run_format": ' + "9" * 5000 + "}",
    ],
    ids=range(12),
)
def test_cards_that_cannot_be(half, snow, text):
    """Whatever stands in run.json, it is one sentence, and --force still replaces the run."""
    (half / "run.json").write_text(text)
    with pytest.raises(RunError, match=r"run\.json is damaged"):
        run_scene(snow, half, resume=True, quiet=True)
    run_scene(snow, half, frames=1, force=True, quiet=True)


def test_every_bit_of_the_card(tmp_path):
    """A flipped bit of run.json is noticed, or changes nothing."""
    path, card = tmp_path / "run.json", Card(FORMAT, "1.2", ("log.csv", "preview.mp4"))
    write_card(path, card)
    data = path.read_bytes()
    for bit in range(0, 8 * len(data), 5):
        hurt = bytearray(data)
        hurt[bit // 8] ^= 1 << bit % 8
        path.write_bytes(hurt)
        found, sentence = refused(read_card, path)
        assert found == card or "damaged" in sentence


def checkpoint_with(path, **changes):
    """Write the checkpoint `path` again with other arrays, whole and with right checksums."""
    saved = read_checkpoint(path)
    head = {"frame": saved.frame, "scene": saved.scene, "neve": saved.neve}
    for name in [name for name in changes if name in head]:
        head[name] = changes.pop(name)
    write_checkpoint(path, **head, arrays={**saved.arrays, **changes}, inventory=saved.inventory)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"frame": 3}, "does not fit its scene (frame 3 at"),
        ({"frame": -1}, "lacks parts of its state"),
        ({"frame": "two"}, "lacks parts of its state"),
        ({"scene": "[["}, "it holds no scene"),
        ({"scene": "about = 'another'\n[numerics]\ndx = 0.25"}, "was made with another scene"),
        ({"time": "noon"}, "does not fit its scene"),
    ],
)
def test_a_checkpoint_that_does_not_fit(half, snow, changes, words):
    """A checkpoint that is whole but not of this scene or moment is one sentence."""
    checkpoint_with(half / "checkpoint", **changes)
    before = content(half)
    with pytest.raises(RunError) as caught:
        run_scene(snow, half, resume=True, quiet=True)
    assert words in str(caught.value)
    assert content(half) == before


def test_a_pipe_is_not_waited_for(half, snow):
    """A pipe in the place of a file, which would never end, is one sentence."""
    import os

    if not hasattr(os, "mkfifo"):
        pytest.skip("no pipes in folders here")
    for name in ("log.csv", "checkpoint"):
        kept = (half / name).read_bytes()
        (half / name).unlink()
        os.mkfifo(half / name)
        with pytest.raises(RunError, match="not a regular file"):
            run_scene(snow, half, resume=True, quiet=True)
        (half / name).unlink()
        (half / name).write_bytes(kept)


def lines(path, change):
    """Change the list of lines of a table."""
    text = path.read_text().splitlines(keepends=True)
    change(text)
    path.write_text("".join(text))


@pytest.mark.parametrize("name", ["log.csv", "solids.csv", "fragments.csv"])
@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.insert(2, text[1]),
        lambda text: text.extend(text[1:]),
        lambda text: text.reverse() or text.insert(0, text.pop()),
    ],
    ids=["one twice", "all twice", "backwards"],
)
def test_doubled_rows_are_put_right(half, whole, snow, capsys, name, change):
    """Rows that stand twice or out of order: told, and the table is the one of a run in one go."""
    lines(half / name, change)
    run_scene(snow, half, resume=True, quiet=True)
    assert f"{name} had rows that were doubled or out of order" in capsys.readouterr().err
    assert content(half) == content(whole)


@pytest.mark.parametrize("name", ["log.csv", "solids.csv"])
def test_lost_rows_are_told(half, snow, capsys, name):
    """Rows that are lost and that nothing tells are named; the run goes on."""
    lines(half / name, lambda text: text.pop(3))
    run_scene(snow, half, resume=True, quiet=True)
    assert f"{name} lacks the rows of frame 2, which were lost" in capsys.readouterr().err
    (half / name).unlink()
    run_scene(snow, half, resume=True, quiet=True)
    assert f"{name} is gone: a new one begins after frame 8" in capsys.readouterr().err


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.pop(2),
        lambda text: text.__setitem__(slice(1, 4), []),
        lambda text: text.__setitem__(2, text[2].replace(".", ".1", 1)),
        lambda text: text.__delitem__(slice(1, None)),
    ],
    ids=["one row", "three rows", "a changed number", "all rows"],
)
def test_lost_fragments_are_counted_again(half, whole, snow, capsys, change):
    """What frames tell is written again: the table is the one of a run in one go."""
    lines(half / "fragments.csv", change)
    run_scene(snow, half, resume=True, quiet=True)
    assert "fragments.csv is counted again from the frames" in capsys.readouterr().err
    assert content(half) == content(whole)


@pytest.mark.parametrize("rubbish", ["\x00\x00", "a,b", "1,2,3\n" * 3, '"never closed', "9" * 4000])
def test_rubbish_in_a_table(half, snow, rubbish):
    """Rubbish among the rows is one sentence with the line; after them it is cut away."""
    for name in ("log.csv", "solids.csv", "fragments.csv"):
        kept = (half / name).read_text()
        lines(half / name, lambda text: text.insert(2, f"{rubbish}\n"))
        with pytest.raises(RunError, match=rf"{name} is damaged \(line \d+ is no row"):
            run_scene(snow, half, resume=True, quiet=True)
        (half / name).write_text(kept + rubbish)
    run_scene(snow, half, resume=True, quiet=True)


def test_frames_that_are_gone_or_swapped(half, whole, snow, capsys):
    """The last frame is written again from the checkpoint; others are told, by name."""
    for number in (4, 1):
        (half / "frames" / f"{number:06d}.npz").unlink()
    (half / "frames" / "000002.npz").write_bytes((half / "frames" / "000003.npz").read_bytes())
    run_scene(snow, half, resume=True, quiet=True)
    assert "000001.npz is gone or not as the run wrote it and 1 more" in capsys.readouterr().err
    hurt, right = content(half), content(whole)
    assert {name for name in right if right[name] != hurt.get(name)} >= {
        "frames/000001.npz",
        "frames/000002.npz",
    }
    assert hurt["frames/000004.npz"] == right["frames/000004.npz"]


def test_fragments_of_frames_of_another_run(half, snow):
    """Frames and a checkpoint with other particles are not counted as if they were of one run."""
    saved = read_checkpoint(half / "checkpoint")
    checkpoint_with(half / "checkpoint", id=saved.arrays["id"] + 7)
    with pytest.raises(RunError, match="of different runs"):
        count_run(half)


def test_a_checkpoint_without_a_inventory(half, whole, snow):
    """A checkpoint that does not say what was written is resumed as well."""
    saved = read_checkpoint(half / "checkpoint")
    write_checkpoint(half / "checkpoint", saved.frame, saved.scene, saved.neve, saved.arrays)
    run_scene(snow, half, resume=True, quiet=True)
    assert content(half) == content(whole)
    assert json.loads((half / "run.json").read_text())["begun"]
