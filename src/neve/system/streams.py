"""Standard output and error, which may be closed, full or gone: a run goes on without them."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO

GONE = 141
"""Exit code of a command whose reader has gone: 128 + SIGPIPE, as the shell has it."""


class Steady:
    """Write to a stream; what it does not take is dropped without a word."""

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write `text`, or drop it."""
        if self._stream is not None:
            with contextlib.suppress(OSError, ValueError):  # full or gone; closed
                self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Pass on what was written."""
        if self._stream is not None:
            with contextlib.suppress(OSError, ValueError):
                self._stream.flush()

    def isatty(self) -> bool:
        """Tell whether a person reads it."""
        with contextlib.suppress(OSError, ValueError):
            return self._stream is not None and self._stream.isatty()
        return False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


class _Raw(io.RawIOBase):
    """Write to standard output, and remember why it takes no more."""

    def __init__(self, handle: int) -> None:
        self._handle = handle
        self.error: OSError | None = None

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._handle

    def isatty(self) -> bool:
        return os.isatty(self._handle)

    def write(self, data: Any) -> int:
        if self.error is not None:
            return memoryview(data).nbytes
        try:
            return os.write(self._handle, data)
        except OSError as error:
            self.error = error
            raise


def make_whole() -> None:
    """Open the streams that the process was started without, and see to it that standard error never raises.

    Else the first file that is opened gets the number of the missing stream, and messages of libraries get
    into it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            with contextlib.suppress(OSError):
                os.open(os.devnull, os.O_RDWR)  # takes the lowest free number
    plain = sys.__stdout__
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115 (for as long as the process lives)
    elif plain is not None and sys.stdout is plain:
        plain.flush()
        buffer = io.BufferedWriter(_Raw(plain.fileno()))
        sys.stdout = io.TextIOWrapper(buffer, plain.encoding, plain.errors, line_buffering=plain.isatty())
    if not isinstance(sys.stderr, Steady):
        sys.stderr = Steady(sys.stderr)


@contextlib.contextmanager
def hushed() -> Iterator[None]:
    """Drop what C libraries write to standard error in the block: their words are no sentences of Neve."""
    try:
        kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    except OSError:  # no standard error, or no handle left
        yield
        return
    os.dup2(nowhere, 2)
    os.close(nowhere)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def output_error() -> OSError | None:
    """Return why standard output does not take what was written; None if it does."""
    raw = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    if not isinstance(raw, _Raw):
        return None
    with contextlib.suppress(OSError, ValueError):
        sys.stdout.flush()
    return raw.error
