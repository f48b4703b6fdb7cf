"""Have robot files read by a process of its own first, with limits of time and memory."""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import json
import logging
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from neve.rigid.robot_files.limits import BYTES, PATIENCE, SECONDS
from neve.scene.errors import SceneError
from neve.system import stopping

LONG = 3.0
"""Time after which a word is said about a file that takes long [s]."""
HERE = "\0"
"""Stands for the begin of the sentence in answers that are kept."""
START = (
    "import json, runpy, sys; sys.path[:] = json.loads(sys.argv.pop());"
    " runpy.run_module('neve.rigid.robot_files.child', run_name='__main__')"
)


@dataclass(frozen=True)
class _Answer:
    """What became of a file: what it names, or a sentence; and the digest of all that was read."""

    files: tuple[Path, ...]
    error: str
    digest: bytes


_known: dict[Path, _Answer] = {}


def files_of(path: Path) -> list[Path]:
    """Return the files that the robot file `path` names and that are there; none of one that is refused."""
    return list(_answer(path, HERE).files)


def require_sound(path: Path, text: str) -> None:
    """Refuse a robot file that cannot be read, or that takes its reader down.

    Errors: SceneError, one sentence that begins with `text`.
    """
    if error := _answer(path, text).error:
        raise SceneError(error.replace(HERE, text))


def _answer(path: Path, text: str) -> _Answer:
    """Ask for what became of a file, or remember it if neither the file nor what it names has changed."""
    known = _known.get(path)
    if known is None or known.digest != _digest(path, known.files):
        files, error = _child.ask(path, text)
        known = _known[path] = _Answer(files, error, _digest(path, files))
    return known


def _digest(path: Path, files: tuple[Path, ...]) -> bytes:
    found = hashlib.sha256()
    for file in (path, *files):
        try:
            content = file.read_bytes()
        except (OSError, ValueError):
            content = b""
        found.update(f"{file}\0{len(content)}\0".encode(errors="replace") + content)
    return found.digest()


class _Child:
    """The process that reads, started at the first file and again after its death."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = 0
        self._lock = threading.Lock()
        self._is_late = False

    def ask(self, path: Path, text: str) -> tuple[tuple[Path, ...], str]:
        """Return the files that `path` names, and a sentence if it cannot be read."""
        with self._lock:
            process = self._running()
            try:
                with self._watched(process, path, text):
                    heard = self._talk(process, path)
            except BaseException:  # Ctrl-C too: a process that is asked nothing more
                self._end()
                raise
            if heard:
                answer = json.loads(heard)
                return tuple(map(Path, answer.get("files", ()))), answer.get("error", "")
            return (), f"{HERE} cannot be read as a robot: {self._death()}"

    def _talk(self, process: subprocess.Popen[bytes], path: Path) -> bytes:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdin.write(json.dumps({"path": str(path), "text": HERE}).encode() + b"\n")
            process.stdin.flush()
            return process.stdout.readline()
        except BrokenPipeError:
            return b""

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is not None and self._owner != os.getpid():  # a fork: the other one's process
            self._process = None
        if self._process is None or self._process.poll() is not None:
            self._end()
            self._owner = os.getpid()
            with stopping.Deaf():  # Ctrl-C is for the one who asks, and who ends this process
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-c", START, json.dumps([p for p in sys.path if p])],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.DEVNULL,
                    env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
                )
        return self._process

    @contextlib.contextmanager
    def _watched(self, process: subprocess.Popen[bytes], path: Path, text: str) -> Iterator[None]:
        """Say a word after a while, and kill the process where no limit of the system does."""
        self._is_late = False

        def stop() -> None:
            self._is_late = True
            process.kill()

        def say() -> None:
            name = text.replace(HERE, path.name)
            logging.getLogger("neve").warning(
                "%s takes the rigid-body engine long to read; it gets %g s", name, SECONDS
            )

        timers = [threading.Timer(LONG, say), threading.Timer(PATIENCE, stop)]
        for timer in timers:
            timer.daemon = True
            timer.start()
        try:
            yield
        finally:
            for timer in timers:
                timer.cancel()

    def _death(self) -> str:
        """Say of what the process died."""
        assert self._process is not None
        code = self._process.wait()
        self._end()
        if self._is_late or -code == getattr(signal, "SIGXCPU", 0):
            return f"the rigid-body engine is not done with it after {SECONDS} s"
        if -code in (signal.SIGABRT, getattr(signal, "SIGKILL", 0)):
            return f"the rigid-body engine gave up on it; it may need more than {BYTES >> 30} GiB of memory"
        return f"the rigid-body engine crashes on it ({_cause(code)})"

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is None or self._owner != os.getpid():
            return
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            with contextlib.suppress(OSError):
                if pipe is not None:
                    pipe.close()


def _cause(code: int) -> str:
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"exit code {code}"


_child = _Child()
atexit.register(_child._end)
