"""Files are whole or not there: full disks, read-only disks, kills between writing and moving."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import neve
from neve.io import atomic
from neve.io.atomic import replacing, write_bytes, write_text
from neve.io.errors import RunError
from neve.io.frames import arrays_of, make_frame, read_frame, write_frame
from neve.io.log import columns, read_log
from neve.io.table import Table
from neve.system import disk
from neve.system.disk import sweep

resource = pytest.importorskip("resource")
ROOT = Path(neve.__file__).parents[1]


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def old(tmp_path):
    """A file that must survive whatever happens while a new one is written."""
    path = tmp_path / "checkpoint"
    path.write_bytes(b"old")
    return path


def frame_of(n):
    rng = np.random.default_rng(1)
    x = rng.random((n, 3), np.float32)
    pose = (np.array([1.0, 2.0, 3.0]), np.eye(3))
    return make_frame(x, x, x[:, 0], np.arange(n)[::-1], np.zeros(n, np.uint16), [pose], 0.5)


def row(frame):
    return dict.fromkeys(columns("mpm"), 0.1) | {"frame": frame, "bound": "wave", "dt_min": None}


def test_write_replaces_the_file(old):
    """A write that ends well leaves the new content and no temporary file."""
    write_text(old, "né")
    assert old.read_bytes() == "né".encode()
    assert names(old.parent) == ["checkpoint"]


def test_permissions_are_those_of_a_plain_file(tmp_path):
    """The file may be read by whom the umask allows, not by its owner alone."""
    (tmp_path / "plain").touch()
    write_bytes(tmp_path / "atomic", b"")
    assert (tmp_path / "atomic").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, ValueError])
def test_failure_in_the_block_leaves_the_old_file(old, interruption):
    """Whatever ends the block early, the old file stays and the temporary one goes."""

    def write():
        with replacing(old) as file:
            file.write(b"half of the n")
            raise interruption

    with pytest.raises(interruption):
        write()
    assert (old.read_bytes(), names(old.parent)) == (b"old", ["checkpoint"])


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOSPC, "the disk is full; free some space and continue with --resume"),
        (errno.EDQUOT, "the disk quota is used up; free some space"),
        (errno.EROFS, "the disk is read-only"),
        (errno.EACCES, "permission is denied"),
        (errno.EIO, os.strerror(errno.EIO).lower()),
    ],
)
@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_refusals_are_one_sentence(old, monkeypatch, call, number, words):
    """A disk that refuses while writing or moving gives one sentence with the file and the reason."""

    def refuse(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(disk.os, call, refuse)
    with pytest.raises(RunError) as caught:
        write_bytes(old, b"new")
    assert str(caught.value).startswith(f"{old} could not be written: {words}")
    assert str(caught.value).count(".") == str(old).count(".") + 1
    assert (old.read_bytes(), names(old.parent)) == (b"old", ["checkpoint"])


def test_missing_folder_is_one_sentence(tmp_path):
    """Writing into a folder that is gone names the file."""
    with pytest.raises(RunError, match=r"gone/x could not be written: no such file or directory\."):
        write_bytes(tmp_path / "gone" / "x", b"")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")
def test_full_device_of_the_system(tmp_path):
    """The system's own full disk, met by the log: one sentence."""
    log = Table(tmp_path / "log.csv", columns("mpm"))
    log.path = Path("/dev/full")
    with pytest.raises(RunError, match="the disk is full"):
        log.append(row(0))


def test_limit_of_the_system_on_file_size(tmp_path):
    """A real limit met half-way through a frame: one sentence, the old frame stays, no temporary file."""
    write_frame(tmp_path, 0, frame_of(10))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, before[1]))
    try:
        with pytest.raises(RunError, match=r"000000\.npz could not be written: the file grew past the size"):
            write_frame(tmp_path, 0, frame_of(10_000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert names(tmp_path) == ["000000.npz"]
    assert len(read_frame(tmp_path, 0).x) == 10


def test_full_disk_leaves_no_half_row_in_the_log(tmp_path):
    """A row that fits only in part is taken back, so that the file stays a table."""
    log = Table(tmp_path / "log.csv", columns("mpm"))
    log.append(row(0))
    whole = log.path.read_bytes()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole) + 20, before[1]))
    try:
        with pytest.raises(RunError, match=r"log\.csv could not be written"):
            log.append(row(1))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert log.path.read_bytes() == whole


def test_kill_between_writing_and_moving(old):
    """A process killed just before the move leaves the old file; the next run sweeps the temporary one."""
    code = (
        "import os, sys; from pathlib import Path; from neve.io import atomic\n"
        "os.replace = lambda *_: os.kill(os.getpid(), 9)\n"
        "atomic.write_bytes(Path(sys.argv[1]), b'new')"
    )
    done = subprocess.run([sys.executable, "-c", code, str(old)], check=False)
    assert done.returncode == -9
    assert old.read_bytes() == b"old"
    assert len(names(old.parent)) == 2
    sweep(old.parent)
    assert names(old.parent) == ["checkpoint"]


def test_sweep_spares_other_files(tmp_path):
    """Only names that a write makes are swept."""
    for name in (".note.tmp", "a.1.tmp", ".x.12.tmp", ".hidden"):
        (tmp_path / name).touch()
    sweep(tmp_path)
    assert names(tmp_path) == [".hidden", ".note.tmp", "a.1.tmp"]


def test_frame_reads_back(tmp_path):
    """A frame comes back as written, sorted by id, and the same frame gives the same bytes."""
    frame = frame_of(5)
    assert list(frame.id) == [0, 1, 2, 3, 4]
    write_frame(tmp_path, 3, frame)
    write_frame(tmp_path, 4, frame)
    for name, value in arrays_of(read_frame(tmp_path, 3)).items():
        assert np.array_equal(value, getattr(frame, name))
    assert (tmp_path / "000003.npz").read_bytes() == (tmp_path / "000004.npz").read_bytes()


@pytest.mark.parametrize("ids", [[], [2, 0, 1, 3], [7, 2, 5, 3]])
def test_any_ids_are_sorted(ids):
    """Numbers by birth, numbers with gaps after some snow has gone, and no snow at all."""
    id, x = np.array(ids, np.uint32), np.arange(3.0 * len(ids)).reshape(-1, 3)
    frame = make_frame(x, x, x[:, 0], id, id, [], 0.0)
    assert list(frame.id) == sorted(ids)
    assert np.array_equal(frame.x, x[np.argsort(id)])


def test_damaged_and_missing_frames_are_one_sentence(tmp_path):
    """A frame cut short, of foreign content, or gone is named."""
    write_frame(tmp_path, 0, frame_of(5))
    data = (tmp_path / "000000.npz").read_bytes()
    (tmp_path / "000000.npz").write_bytes(data[: len(data) // 2])
    np.savez(tmp_path / "000001.npz", y=1)
    for number in (0, 1):
        with pytest.raises(RunError, match=rf"00000{number}\.npz is damaged or is no frame of a Neve run\."):
            read_frame(tmp_path, number)
    with pytest.raises(RunError, match=r"000002\.npz could not be read: it does not exist\."):
        read_frame(tmp_path, 2)


def test_log_reads_back_numbers_exactly(tmp_path):
    """Numbers keep all their digits; None and NaN are empty cells; a line cut short does not count."""
    log = Table(tmp_path / "log.csv", columns("mpm"))
    log.append(row(0) | {"mass": 1 / 3, "kinetic": float("nan")})
    with open(log.path, "a") as file:
        file.write("1,0.1,0.")
    (only,) = read_log(log.path, "mpm")
    assert (float(only["mass"]), only["kinetic"], only["dt_min"]) == (1 / 3, "", "")


def test_log_of_another_version_is_one_sentence(tmp_path):
    """A table with other columns is not continued, and the sentence says what moving it away costs."""
    path = tmp_path / "log.csv"
    path.write_text("frame,time\n0,0\n")
    with pytest.raises(RunError, match=r"no log of this version of Neve, .* starts without them"):
        Table(path, columns("mpm"), keep_through=3)
    assert path.read_text() == "frame,time\n0,0\n"


def test_png_holds_the_picture_to_the_bit(tmp_path):
    """A PNG is lossless: what is read back is what was written, the top row first."""
    image = np.random.default_rng(1).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    atomic.write_png(tmp_path / "a.png", image)
    with Image.open(tmp_path / "a.png") as read:
        assert (np.asarray(read) == image).all()
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


def test_a_folder_into_which_another_process_writes_is_removed(tmp_path, monkeypatch):
    """A file appears between the removal of the last one and that of the folder."""
    folder = tmp_path / "parts"
    folder.mkdir()
    late = iter(["late"])
    removed = os.rmdir

    def rmdir(path, *, dir_fd=None):
        for name in late:
            (folder / name).touch()
        removed(path, dir_fd=dir_fd)

    monkeypatch.setattr(os, "rmdir", rmdir)
    disk.remove_tree(folder)
    assert not folder.exists()
