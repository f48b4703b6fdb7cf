"""Change the disk: every file that Neve writes, replaces or deletes goes through this module.

A reader finds the old file or the new one, never a half of either. A symbolic link is never followed to what
is written or deleted: a file takes the place of the link, and a folder that is a link is refused by who owns
the folder (`linked`). All errors are OSError; who calls turns them into a sentence.
"""

from __future__ import annotations

import contextlib
import errno
import io
import itertools
import os
import re
import shutil
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import BinaryIO, cast

_TEMPORARY = re.compile(r"\..+\.\d+(-\d+)?\.(tmp|part\.\w+)", re.DOTALL)
_KEPT = 40
"""Characters of a file's name in that of its temporary file, which must not become too long itself."""
_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
_BINARY = getattr(os, "O_BINARY", 0)
_count = itertools.count()


class _Writer(io.RawIOBase):
    """Write to a file descriptor, which it does not own."""

    def __init__(self, handle: int) -> None:
        self._handle = handle

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def write(self, data: object) -> int:
        return os.write(self._handle, data)  # type: ignore[arg-type]

    def seek(self, offset: int, whence: int = 0) -> int:
        return os.lseek(self._handle, offset, whence)


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a temporary file in the folder of `path` and move it to `path` when the block ends well.

    The bytes reach the disk (fsync) before the move, so a crash at any moment leaves `path` as it was or as
    it should be. If the block fails, the temporary file is removed and `path` is untouched.
    """
    with temporary_of(path) as temporary:
        handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _NO_LINK | _BINARY, 0o666)
        try:
            file = io.BufferedWriter(_Writer(handle), 2**20)
            try:
                yield cast(BinaryIO, file)
                file.flush()
                os.fsync(handle)
            except BaseException:
                with contextlib.suppress(OSError):  # closing flushes again, and a full disk refuses again
                    file.close()
                raise
            file.close()
        finally:
            os.close(handle)


@contextlib.contextmanager
def temporary_of(path: Path) -> Iterator[Path]:
    """Yield a new name in the folder of `path` for a file that moves to `path` when the block ends well.

    If the block fails, or makes no file, what lies there is removed.
    """
    temporary = path.with_name(f".{path.name[:_KEPT]}.{os.getpid()}-{next(_count)}.tmp")
    _discard(temporary)  # of a process that had the same number
    try:
        yield temporary
        os.replace(temporary, path)
    except BaseException:
        _discard(temporary)
        raise


@contextlib.contextmanager
def made_by_library(path: Path) -> Iterator[Path]:
    """Yield a path of the same ending for a library to write to, which then takes the place of `path`."""
    with temporary_of(path) as temporary:
        place = temporary.with_name(f".{temporary.stem.strip('.')}.part{path.suffix}")
        try:
            yield place
            move(place, temporary)
        finally:
            remove(place)


def move(path: Path, to: Path) -> None:
    """Let a whole file, written by another program, take the place of `to`, once it has reached the disk."""
    handle = os.open(path, os.O_RDWR | _NO_LINK | _BINARY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
    os.replace(path, to)


def append(path: Path, data: bytes) -> None:
    """Add `data` to the end of the file `path`, or leave the file as it was."""
    handle = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | _NO_LINK | _BINARY, 0o666)
    try:
        end = os.fstat(handle).st_size
        try:
            rest = memoryview(data)
            while rest:
                with contextlib.suppress(InterruptedError):  # then nothing was written
                    rest = rest[os.write(handle, rest) :]
            os.fsync(handle)
        except BaseException:
            with contextlib.suppress(OSError):
                os.ftruncate(handle, end)
            raise
    finally:
        os.close(handle)


def sync_folder(folder: Path) -> None:
    """Let the names in `folder` reach the disk, where the system can: what was moved there stays moved."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def make_folder(path: Path) -> None:
    """Make the folder `path` and those above it, where they are missing."""
    if path.is_dir():
        return
    if path.parent != path:
        make_folder(path.parent)
    try:
        os.mkdir(path)
    except FileExistsError:
        if not path.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(path)) from None


def remove(path: Path) -> None:
    """Remove the file or link `path`, if it is there."""
    with contextlib.suppress(FileNotFoundError):
        os.unlink(path)


def remove_files(folder: Path, names: Iterable[str]) -> None:
    """Remove the files `names` in `folder`, which must not be a link: what it points to is not ours."""
    if os.unlink not in os.supports_dir_fd:
        for name in names:
            remove(folder / name)
        return
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | _NO_LINK)
    try:
        for name in names:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(name, dir_fd=handle)
    finally:
        os.close(handle)


def remove_tree(path: Path) -> None:
    """Remove a file, a folder with all that is in it, or a link but not what it points to, if it is there.

    What another process puts into the folder meanwhile is removed as well, unless it goes on.
    """
    for last in (False, False, True):
        if not path.is_dir() or path.is_symlink():
            remove(path)
            return
        try:
            shutil.rmtree(path)
            return
        except OSError as error:
            if last or error.errno != errno.ENOTEMPTY:
                raise


def remove_if_empty(folder: Path) -> None:
    """Remove a folder unless something is in it; a link stays."""
    with contextlib.suppress(OSError):
        os.rmdir(folder)


def sweep(folder: Path) -> None:
    """Remove the temporary files that a killed process left in `folder`."""
    for path in folder.iterdir():
        if is_temporary(path.name):
            _discard(path)


def is_temporary(name: str) -> bool:
    """Tell whether `name` is that of a temporary file of a write."""
    return _TEMPORARY.fullmatch(name) is not None


def linked(root: Path, path: Path) -> Path | None:
    """Return the first part of `path` below the folder `root` that is a symbolic link; None if none is.

    `root` itself, which the user has named, may be one.
    """
    part = root
    for name in path.relative_to(root).parts:
        part = part / name
        if part.is_symlink():
            return part
    return None


def read_bytes(path: Path, most: int = -1) -> bytes:
    """Return what is in the regular file `path`, or its first `most` bytes.

    A pipe or a device, which may never end, is refused.
    """
    with open_regular(path) as file:
        return file.read(most)


def open_regular(path: Path) -> BinaryIO:
    """Open the regular file `path` for reading; anything else is refused at once."""
    handle = os.open(path, os.O_RDONLY | _BINARY | getattr(os, "O_NONBLOCK", 0))
    try:
        if stat.S_ISDIR(mode := os.fstat(handle).st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(mode):
            raise OSError(errno.EINVAL, "it is not a regular file", str(path))
        return open(handle, "rb")
    except BaseException:
        os.close(handle)
        raise


def free(path: Path) -> int | None:
    """Return the free bytes of the disk of `path`, or of the nearest folder above it; None if unknown."""
    for place in (path, *path.absolute().parents):
        try:
            return shutil.disk_usage(place).free
        except OSError:
            continue
    return None


def _discard(path: Path) -> None:
    with contextlib.suppress(OSError):
        remove(path)
