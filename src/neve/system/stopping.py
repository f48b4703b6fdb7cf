"""Ctrl-C on the command line, from the first moment on.

Python turns Ctrl-C into an exception wherever the program is. In the middle of an import that leaves half a
module, and an ImportError or a traceback of somebody else's; so there it waits until the import is done, and
before there is anything to tidy up it ends the process. What this module imports is loaded in a moment.
"""

from __future__ import annotations

import _thread
import contextlib
import os
import signal
import sys
import time
from collections.abc import Iterator
from types import FrameType

STOPPED = 130
"""Exit code after Ctrl-C: 128 + SIGINT, as the shell has it."""

_PAUSE = 0.01
"""Wall time [s] after which an import is looked at again."""

_ready = False


def is_command_line() -> bool:
    """Tell whether this process is Neve's command line and no other program that uses Neve."""
    program = os.path.basename(sys.argv[0]) if sys.argv else ""
    return program in ("neve", "neve.exe", "neve-script.py") or sys.orig_argv[1:3] == ["-m", "neve.cli"]


def listen() -> None:
    """Hear Ctrl-C from now on, unless somebody else does."""
    with contextlib.suppress(ValueError):  # not the main thread
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, hear)


@contextlib.contextmanager
def ready() -> Iterator[None]:
    """In the block Ctrl-C is an exception, as usual in Python, but not in an import."""
    global _ready
    before, _ready = _ready, True
    try:
        yield
    finally:
        _ready = before


@contextlib.contextmanager
def as_usual() -> Iterator[None]:
    """In the block leave Ctrl-C to Python, whose event loop handles it only then in its own way."""
    ours = signal.getsignal(signal.SIGINT) is hear
    if ours:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        if ours:
            signal.signal(signal.SIGINT, hear)


def hear(number: int, frame: FrameType | None) -> None:
    """Handle a SIGINT."""
    interrupt(frame, "")


def interrupt(frame: FrameType | None, sentence: str) -> None:
    """Raise KeyboardInterrupt with `sentence` in `frame`; from within an import, once it is done."""
    if not _ready and signal.getsignal(signal.SIGINT) is hear:
        with contextlib.suppress(OSError):
            os.write(2, b"neve: stopped\n")
        os._exit(STOPPED)
    if _is_importing(frame):
        _thread.start_new_thread(_again, (_thread.get_ident(),))
        return
    raise KeyboardInterrupt(sentence) if sentence else KeyboardInterrupt


def _again(thread: int) -> None:
    time.sleep(_PAUSE)
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(thread, signal.SIGINT)
    else:
        _thread.interrupt_main()


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False
