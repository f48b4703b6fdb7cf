"""When something is due during a run: every few frames, every few seconds of simulated or of wall time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from fractions import Fraction
from typing import Protocol, runtime_checkable


class Schedule(Protocol):
    """Decide at which frames something is due."""

    def due(self, frame: int) -> bool:
        """Return whether something is due at the end of `frame`; asked once for each frame, in order."""
        ...


@runtime_checkable
class Regular(Protocol):
    """A schedule by the number of the frame alone, so that a resumed run continues it exactly."""

    def due(self, frame: int) -> bool:
        """Return whether something is due at the end of `frame`; may be asked at any time."""
        ...

    def interval(self, fps: int) -> Fraction:
        """Return the mean time [s] between two dues of a run with `fps` frames per simulated second."""
        ...


class EveryFrames:
    """Be due at frame 0, the initial state, and at every `n`-th frame after it.

    Errors: ValueError if n < 1.
    """

    def __init__(self, n: int = 1) -> None:
        if n < 1:
            raise ValueError(f"EveryFrames({n}): the number of frames must be 1 or more.")
        self.n = n

    def due(self, frame: int) -> bool:
        """Return whether `frame` is a multiple of n."""
        return frame % self.n == 0

    def interval(self, fps: int) -> Fraction:
        """Return n / fps [s]."""
        return Fraction(self.n, fps)


class EverySeconds:
    """Be due at the first frame at or after each multiple of `seconds` [s] of simulated time, 0 included.

    Frame k ends at the time k / fps. Times are compared as exact decimal numbers, as they are written: with
    30 frames per second, 0.1 s is every third frame.

    Errors: ValueError if seconds is not greater than 0.
    """

    def __init__(self, seconds: float, fps: int) -> None:
        if not seconds > 0.0:
            raise ValueError(f"EverySeconds({seconds}): the time must be greater than 0 s.")
        self.seconds = Fraction(repr(float(seconds)))
        self.fps = fps

    def due(self, frame: int) -> bool:
        """Return whether a multiple of `seconds` lies after frame - 1, and at or before `frame`."""
        return frame == 0 or self._multiples(frame) > self._multiples(frame - 1)

    def interval(self, fps: int) -> Fraction:
        """Return `seconds`."""
        return self.seconds

    def _multiples(self, frame: int) -> int:
        return int(Fraction(frame, self.fps) // self.seconds)


class EveryWallSeconds:
    """Be due at the first frame, then whenever `seconds` [s] of wall time have passed since it last was.

    What is written so must not matter to the results: wall time differs from run to run. What says how long
    it `took` becomes due less often, up to every `most` [s], so that it takes at most `share` of the time.

    Errors: ValueError if seconds < 0.
    """

    def __init__(
        self,
        seconds: float,
        clock: Callable[[], float] = time.monotonic,
        share: float = 1.0,
        most: float = math.inf,
    ) -> None:
        if not seconds >= 0.0:
            raise ValueError(f"EveryWallSeconds({seconds}): the time must be 0 s or more.")
        self.seconds = seconds
        self._clock, self._share, self._most = clock, share, most
        self._wait = seconds
        self._last: float | None = None

    def due(self, frame: int) -> bool:
        """Return whether the time has passed, and if so start it again."""
        now = self._clock()
        if self._last is not None and now - self._last < self._wait:
            return False
        self._last = now
        return True

    def took(self, seconds: float) -> None:
        """Take note of how long it takes to do what is due [s]."""
        self._wait = max(self.seconds, min(seconds / self._share, self._most))


class Never:
    """Be due at no frame: for what acts only when the run ends."""

    def due(self, frame: int) -> bool:
        """Return False."""
        return False
