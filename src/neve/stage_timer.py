"""Measure the wall time of named stages: of the time step, and of what a run writes and draws."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable, Iterator


class StageTimer:
    """Add up the wall time [s] spent in each stage.

    stages: names that are present from the start, with 0 s

    `seconds` holds the time of each stage since the start, or since the last `take`.
    """

    def __init__(self, stages: Iterable[str] = ()) -> None:
        self.seconds = dict.fromkeys(stages, 0.0)

    @contextlib.contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the wall time of the `with` block to the stage `name`, also if the block raises."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start

    def take(self) -> dict[str, float]:
        """Return the seconds of each stage and set every stage back to zero."""
        seconds, self.seconds = self.seconds, dict.fromkeys(self.seconds, 0.0)
        return seconds
