"""When something is due during a run: every frame, every few seconds of wall time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol


class Schedule(Protocol):
    """Anything that can say whether it is time."""

    def due(self, frame: int) -> bool:
        """Tell whether something is due at the end of `frame`; asked once for each frame, in order."""
        ...


class EveryFrame:
    """Be due at each frame, the initial state (frame 0) included."""

    def due(self, frame: int) -> bool:
        """Say yes."""
        return True


class EverySeconds:
    """Be due at the first frame, then whenever `seconds` [s] of wall time have passed since it last was.

    What hangs on it must not change the simulation: the clock differs from run to run.
    """

    def __init__(self, seconds: float, clock: Callable[[], float] = time.monotonic) -> None:
        if not seconds >= 0.0:
            raise ValueError(f"EverySeconds({seconds}): the time must be 0 s or more.")
        self.seconds = seconds
        self._clock = clock
        self._last: float | None = None

    def due(self, frame: int) -> bool:
        """Say whether the time has passed, and if so start it again."""
        now = self._clock()
        if self._last is not None and now - self._last < self.seconds:
            return False
        self._last = now
        return True


class Never:
    """Be due at no frame: for what acts only when the run ends."""

    def due(self, frame: int) -> bool:
        """Say no."""
        return False
