"""A disk that refuses, at each call in turn: every write is atomic, every run goes on to the same bytes.

In the manner of SQLite's I/O error tests: the calls of the system that change the disk are counted, and in
the n-th of all runs the n-th of them fails. Afterwards each file is the old one or the new one, whole;
the error is one sentence; and the resumed run has the bytes of one that met no fault. The same for a second
Ctrl-C, which is an exception wherever it comes: right after the n-th call here.
"""

import csv
import errno
import io
import itertools
import os
import re
from pathlib import Path

import numpy as np
import pytest

import neve
from neve.geometry import cache
from neve.io.atomic import write_bytes
from neve.io.checkpoint import read_checkpoint
from neve.io.errors import RunError
from neve.io.frames import frame_numbers, read_frame
from neve.render.film import Film, FilmError
from neve.run import run_scene
from neve.scene.reading.load import load
from neve.system import disk

CHANGES = ("open", "write", "fsync", "replace", "unlink", "mkdir", "ftruncate", "close")
"""Functions of `os` by which `neve.system.disk` changes the disk."""
WRITES = ("open", "write", "fsync", "replace", "mkdir")
"""Those whose failure ends a write; the others tidy up after it."""


class Faulty:
    """The module `os`, in which call number `n` of those in `calls` fails, is half done or stopped.

    Nothing waits for a real disk (fsync), which is not what is tested here.
    """

    def __init__(self, n, fault, calls):
        self.left, self.fault, self.calls, self.met = n, fault, calls, ""

    def __getattr__(self, name):
        real = getattr(os, name)
        return self.counted(name, real) if name in self.calls else real

    def counted(self, name, real):
        real = real if name != "fsync" else lambda handle: None

        def call(*arguments, **words):
            self.left -= 1
            if self.left != 0:
                return real(*arguments, **words)
            self.met = name
            if self.fault == "stop":
                done = real(*arguments, **words)
                if name == "open":  # the signal is heard once the number of the file is kept
                    os.close(done)
                raise KeyboardInterrupt
            if self.fault == "short":
                handle, data = arguments
                return real(handle, memoryview(data)[: max(1, len(data) // 2)])
            if self.fault == errno.EINTR:
                raise InterruptedError(errno.EINTR, os.strerror(errno.EINTR))
            if name == "write":  # a part may be on the disk already
                real(arguments[0], memoryview(arguments[1])[: len(arguments[1]) // 2])
            if name == "close":
                real(*arguments)
            raise OSError(self.fault, os.strerror(self.fault))

        return call


def faults(monkeypatch, fault, calls, do):
    """Call `do(n)` with the n-th of `calls` failing, for n = 1, 2, ... as long as there is one."""
    for n in itertools.count(1):
        system = Faulty(n, fault[n % len(fault)] if isinstance(fault, tuple) else fault, calls)
        with monkeypatch.context() as patch:
            patch.setattr(disk, "os", system)
            error = None
            try:
                do(n)
            except (RunError, FilmError, KeyboardInterrupt) as refused:
                error = refused
        if not system.met:
            assert error is None
            return
        yield n, system.met, error


def sentence(error):
    """Tell whether an error is one sentence."""
    return str(error).endswith(".") and "\n" not in str(error) and "Errno" not in str(error)


@pytest.mark.parametrize("fault", [errno.ENOSPC, errno.EIO, errno.EACCES, "stop"])
def test_a_file_is_the_old_one_or_the_new_one(tmp_path, monkeypatch, fault):
    """Whatever call fails while a file is replaced: the old bytes or the new, and nothing beside them."""
    path = tmp_path / "file"
    new = bytes(range(256)) * 10_000

    def write(n):
        path.write_bytes(b"old")
        write_bytes(path, new)

    met = set()
    for _, call, error in faults(monkeypatch, fault, CHANGES, write):
        met.add(call)
        stopped = isinstance(error, KeyboardInterrupt)
        assert path.read_bytes() in ((b"old", new) if error is None or stopped else (b"old",))
        assert error is None or stopped or sentence(error)
        assert [p.name for p in tmp_path.iterdir()] == ["file"]
    assert met >= {"open", "write", "fsync", "replace", "close"}


@pytest.mark.parametrize("fault", ["short", errno.EINTR])
def test_writes_that_are_cut_short_go_on(tmp_path, monkeypatch, fault):
    """A write that takes a part, or is interrupted, is continued: no error and all bytes."""
    path, table = tmp_path / "file", tmp_path / "table"
    data = bytes(range(256)) * 10_000

    def write(n):
        table.write_bytes(b"head\n")
        write_bytes(path, data)
        disk.append(table, data)

    met = 0
    for met, _, error in faults(monkeypatch, fault, ("write",), write):
        assert error is None, met
        assert (path.read_bytes(), table.read_bytes()) == (data, b"head\n" + data)
    assert met >= 2


@pytest.mark.parametrize("fault", [errno.ENOSPC, errno.EIO, "stop"])
def test_a_row_is_added_or_not(tmp_path, monkeypatch, fault):
    """Whatever call fails while rows are added: all of them are there or none."""
    path = tmp_path / "table"

    def add(n):
        path.write_bytes(b"head\n")
        try:
            disk.append(path, b"a row\n" * 1000)
        except OSError as error:
            raise RunError("refused.") from error

    for _, call, error in faults(monkeypatch, fault, ("open", "write", "fsync"), add):
        assert error is not None, call
        assert path.read_bytes() == b"head\n"


def content(folder):
    """Every file with its bytes; of the log the columns without wall times."""
    found = {str(p.relative_to(folder)): p.read_bytes() for p in Path(folder).rglob("*") if p.is_file()}
    rows = list(csv.DictReader(io.StringIO(found["log.csv"].decode())))
    timeless = [{k: v for k, v in row.items() if not k.startswith("seconds_")} for row in rows]
    return found | {"log.csv": timeless}


@pytest.mark.parametrize("fault", [(errno.ENOSPC, errno.EIO), "stop"], ids=["refused", "stopped"])
def test_a_run_goes_on_after_any_fault(fake, scene_file, tmp_path, monkeypatch, fault):
    """The n-th write of a run fails, for all n: one sentence, whole files, and the same bytes afterwards."""
    text = scene_file.read_text().replace("[run]", "[run]\nfragments = true\nfilm = false")
    scene_file.write_text(text.replace("0.4", "0.05"))
    scene = load(scene_file)
    run_scene(scene, tmp_path / "straight", quiet=True)
    straight = content(tmp_path / "straight")

    def go(n):
        run_scene(scene, tmp_path / str(n), quiet=True)

    count = 0
    monkeypatch.setattr(disk, "os", Faulty(0, None, ("fsync",)))
    for count, call, error in faults(monkeypatch, fault, WRITES, go):
        out = tmp_path / str(count)
        assert not list(out.rglob("*.tmp"))
        for number in frame_numbers(out / "frames"):
            read_frame(out / "frames", number)
        if (out / "checkpoint").exists():
            read_checkpoint(out / "checkpoint")
        if error is not None:
            assert isinstance(error, KeyboardInterrupt) or sentence(error), call
            run_scene(scene, out, resume=(out / "run.json").exists(), quiet=True)
        assert content(out) == straight, (count, call)
    assert count > 60


def test_a_film_on_a_full_disk(tmp_path, monkeypatch):
    """The n-th write of a film fails: one sentence, the old film, nothing beside it but the parts."""
    picture = np.zeros((36, 64, 3), np.uint8)

    def make(n):
        path = tmp_path / str(n) / "film.mp4"
        path.parent.mkdir()
        path.write_bytes(b"old")
        film = Film(path, 24, (64, 36))
        film.add(picture)
        film.close()

    count = 0
    for count, call, error in faults(monkeypatch, errno.ENOSPC, WRITES, make):
        folder = tmp_path / str(count)
        assert error is not None or call in ("open", "fsync"), call
        if error is not None:
            assert sentence(error)
            assert (folder / "film.mp4").read_bytes() == b"old"
        assert {p.name for p in folder.iterdir()} <= {"film.mp4", ".film.mp4.parts"}
    assert count > 5


def _film(film):
    for frame in range(30):
        film.add(np.random.default_rng(frame).integers(0, 255, (360, 640, 3), dtype=np.uint8))
    film.close()


def test_ffmpeg_meets_a_full_disk(tmp_path):
    """ffmpeg itself, which writes the parts and the film, meets a limit: one sentence and the old film."""
    resource = pytest.importorskip("resource")
    path = tmp_path / "film.mp4"
    path.write_bytes(b"old")
    film = Film(path, 24, (640, 360))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, before[1]))
    try:
        with pytest.raises(FilmError) as caught:
            _film(film)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert sentence(caught.value)
    assert path.read_bytes() == b"old"
    assert {p.name for p in tmp_path.iterdir()} <= {"film.mp4", ".film.mp4.parts"}


def test_a_cache_on_a_full_disk(tmp_path, monkeypatch, caplog):
    """The folder of the cache refuses: nothing is kept, nothing raised, nothing left behind."""
    monkeypatch.setenv("NEVE_CACHE", str(tmp_path / "cache"))

    def keep(n):
        cache.keep("key", {"a": np.arange(5)})

    for _, call, error in faults(monkeypatch, errno.ENOSPC, WRITES, keep):
        assert error is None, call
        assert [p.name for p in (tmp_path / "cache").glob("*")] in ([], ["key.npz"])
        found = cache.recall("key")
        assert found is None or list(found["a"]) == [0, 1, 2, 3, 4]


MAY = {"system/disk.py", "viewer/protocol/document.py"}
"""Modules that change the disk themselves: the one for it, and one that writes a file of the sources."""


def test_nothing_writes_around_it():
    """No other module of Neve changes the disk: every write goes through `neve.system.disk`."""
    words = r"\.(unlink|rmdir|rename|touch|mkdir|symlink_to|hardlink_to|write_text|write_bytes)\("
    words += r"|shutil\.\w+\("
    words += r"|os\.(replace|rename|remove|makedirs|truncate)\(|[^.\w]open\([^)]*[\"'][wax]b?[\"']"
    root = Path(neve.__file__).parent
    found = [
        f"{path.relative_to(root).as_posix()}: {match[0]}"
        for path in sorted(root.rglob("*.py"))
        if path.relative_to(root).as_posix() not in MAY and "fuzz" not in path.parts
        for match in re.finditer(words, path.read_text(encoding="utf-8"))
    ]
    assert found == ["system/streams.py: " + found[0].partition(": ")[2]]  # the null device
