"""Ctrl-C on the command line, from the first moment on, and SIGTERM and SIGHUP, which ask a process to end.

Python turns Ctrl-C into an exception wherever the program is. In the middle of an import that leaves half a
module, and an ImportError or a traceback of somebody else's; so there it waits until the import is done, and
before there is anything to tidy up it ends the process. The other two, which would end a process at once,
are told the same way: `timeout`, systemd, a batch system or a terminal that closes means the whole program.
They often come twice, so only Ctrl-C can hurry what is being tidied up.

This module is the first to be imported, so it imports only what is compiled into Python.
"""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]  # `signal` without its enumerations, which take a while
import _thread
import os
import sys
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType
    from typing import Self

CTRL_C: int = _signal.SIGINT
ASKING: tuple[int, ...] = tuple(getattr(_signal, n) for n in ("SIGTERM", "SIGHUP") if hasattr(_signal, n))
"""Signals by which others ask a process to end; Windows has no SIGHUP."""

_PAUSE = 0.01
"""Wall time [s] after which an import is looked at again."""

_listens = _is_ready = _waits = False
_first: int | None = None
_held: Held | None = None


def is_command_line() -> bool:
    """Tell whether this process is Neve's command line and no other program that uses Neve."""
    program = os.path.basename(sys.argv[0]) if sys.argv else ""
    return program in ("neve", "neve.exe", "neve-script.py") or sys.orig_argv[1:3] in (
        ["-m", "neve"],
        ["-m", "neve.cli"],
    )


def listen() -> None:
    """Hear Ctrl-C, SIGTERM and SIGHUP from now on, unless somebody else does or they are ignored."""
    global _listens
    try:
        for number in (CTRL_C, *ASKING):
            if is_as_python_has_it(number):
                _signal.signal(number, hear)
    except ValueError:  # not the main thread
        return
    _listens = True


def is_as_python_has_it(number: int) -> bool:
    """Tell whether a signal is handled as in any Python program: nobody else hears it, nor is it ignored."""
    usual = _signal.default_int_handler if number == CTRL_C else _signal.SIG_DFL
    return bool(_signal.getsignal(number) == usual)


def note(number: int) -> None:
    """Keep the first signal that was heard: the exit code is about it."""
    global _first
    if _first is None:
        _first = number


def code() -> int:
    """Return the exit code of a command that was stopped: 128 + the signal's number, as the shell has it."""
    return 128 + (CTRL_C if _first is None else _first)


def check() -> None:
    """Raise KeyboardInterrupt if something else than Ctrl-C, the usual way to end a server, has ended it."""
    if _first in ASKING:
        raise KeyboardInterrupt


class Deaf:
    """Start processes in the block that never get these signals, whoever sends them: this one ends them.

    A terminal or a batch system sends them to every process of a program. Here they wait until the block is
    done; Windows, which cannot block them, changes nothing.
    """

    def __enter__(self) -> None:
        if hasattr(_signal, "pthread_sigmask"):
            self._before = _signal.pthread_sigmask(_signal.SIG_BLOCK, (CTRL_C, *ASKING))

    def __exit__(self, *error: object) -> None:
        if hasattr(_signal, "pthread_sigmask"):
            _signal.pthread_sigmask(_signal.SIG_SETMASK, self._before)


class Ready:
    """In the block these signals are an exception, as Ctrl-C is in Python, but not in an import."""

    def __enter__(self) -> None:
        global _is_ready, _first
        self._before, _is_ready, _first = _is_ready, True, None

    def __exit__(self, *error: object) -> None:
        global _is_ready
        _is_ready = self._before


class Held:
    """In the block the first signal raises nothing but calls what `then` names, at once or when it is named.

    For an event loop, which an exception at any moment leaves in pieces. A second Ctrl-C is an exception.
    """

    def __init__(self) -> None:
        self._call: Callable[[], object] | None = None
        self.is_heard = False

    def __enter__(self) -> Self:
        global _held
        _held = self
        return self

    def __exit__(self, *error: object) -> None:
        global _held
        _held = None

    def then(self, call: Callable[[], object]) -> None:
        """Name what ends the work of the block."""
        self._call = call
        if self.is_heard:
            call()

    def tell(self) -> None:
        """Take note of a signal."""
        self.is_heard = True
        if self._call is not None:
            self._call()


def hear(number: int, frame: FrameType | None) -> None:
    """Handle one of the signals."""
    global _waits
    if number in ASKING and _first is not None and not _waits:  # a second one, or one after Ctrl-C
        return
    _waits = False
    note(number)
    if _held is not None and not _held.is_heard:
        _held.tell()
    else:
        interrupt(frame, "")


def interrupt(frame: FrameType | None, sentence: str) -> None:
    """Raise KeyboardInterrupt with `sentence` in `frame`; from within an import, once it is done."""
    global _waits
    if _listens and not _is_ready:
        try:  # noqa: SIM105 (contextlib is not there yet)
            os.write(2, b"neve: stopped\n")
        except OSError:
            pass
        os._exit(code())
    if _is_importing(frame):
        _waits = True
        _thread.start_new_thread(_again, (_thread.get_ident(), CTRL_C if _first is None else _first))
        return
    raise KeyboardInterrupt(sentence) if sentence else KeyboardInterrupt


def _again(thread: int, number: int) -> None:
    time.sleep(_PAUSE)
    if hasattr(_signal, "pthread_kill"):
        _signal.pthread_kill(thread, number)
    else:
        _thread.interrupt_main()


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False
