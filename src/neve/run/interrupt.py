"""Stop a run between two frames when the user presses Ctrl-C, or the system asks the process to end."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from types import FrameType, TracebackType
from typing import Any, Self

from neve.system import stopping


class Interrupt:
    """Hold back the first signal until the frame is done; let a second Ctrl-C through at once.

    In a `with` block on the main thread the first SIGINT, SIGTERM or SIGHUP only sets `requested`. Elsewhere
    (other threads may not set handlers, and a caller's own handler stays) nothing changes. SIGTERM and SIGHUP
    often come in pairs, so a second one is not a hurry.
    """

    def __init__(self, quiet: bool = False) -> None:
        self.requested = False
        self._quiet = quiet
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in (stopping.CTRL_C, *stopping.ASKING):
                before = signal.getsignal(number)
                if before is stopping.hear or stopping.is_as_python_has_it(number):
                    self._before[number] = before
                    signal.signal(number, self._hear)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)

    def _hear(self, number: int, frame: FrameType | None) -> None:
        if self.requested:
            if number == stopping.CTRL_C:
                stopping.interrupt(frame, "stopped at once")
            return
        self.requested = True
        stopping.note(number)
        if not self._quiet:  # a plain write: printing is not safe inside a signal handler
            with contextlib.suppress(OSError):
                os.write(2, b"\nfinishing this frame (press Ctrl-C again to stop at once)\n")
