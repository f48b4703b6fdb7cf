"""Stop a run between two frames when the user presses Ctrl-C."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from types import FrameType, TracebackType
from typing import Self

from neve.system import stopping


class Interrupt:
    """Hold back the first Ctrl-C until the frame is done; let the second one through at once.

    In a `with` block on the main thread the first SIGINT only sets `requested`. Elsewhere (other threads may
    not set handlers, and a caller's own handler stays) nothing changes.
    """

    def __init__(self, quiet: bool = False) -> None:
        self.requested = False
        self._quiet = quiet
        self._active = False

    def __enter__(self) -> Self:
        main = threading.current_thread() is threading.main_thread()
        self._before = signal.getsignal(signal.SIGINT)
        self._active = main and self._before in (signal.default_int_handler, stopping.hear)
        if self._active:
            signal.signal(signal.SIGINT, self._hear)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._active:
            signal.signal(signal.SIGINT, self._before)

    def _hear(self, number: int, frame: FrameType | None) -> None:
        if self.requested:
            stopping.interrupt(frame, "stopped at once")
        self.requested = True
        if not self._quiet:  # a plain write: printing is not safe inside a signal handler
            with contextlib.suppress(OSError):
                os.write(2, b"\nfinishing this frame (press Ctrl-C again to stop at once)\n")
