"""Show the progress of a run: a bar on a terminal, plain lines elsewhere, or warnings alone."""

from __future__ import annotations

import contextlib
import logging
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import TYPE_CHECKING, Protocol, Self, TextIO, cast

from neve.scene.checks.joined import MOST_ALIKE, kind_of
from neve.system.streams import Steady

if TYPE_CHECKING:
    from rich.progress import Progress as RichProgress
    from rich.progress import TaskID


class Progress(Protocol):
    """Follow a run; use it in a `with` block, so that the terminal is left tidy however the run ends."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    def update(self, frame: int, particles: int, steps: int) -> None:
        """Show that `frame` is done, with `steps` substeps since the start of the run."""
        ...

    def say(self, sentence: str) -> None:
        """Show a sentence for the user."""
        ...


def follow(name: str, first: int, last: int, quiet: bool = False, stream: TextIO | None = None) -> Progress:
    """Return the progress that suits where the messages go (`stream`, by default standard error)."""
    stream = cast(TextIO, Steady(stream or sys.stderr))  # a run does not depend on who reads
    if quiet:
        return Silence()
    if stream.isatty():
        return Bar(name, first, last, stream)
    return Lines(name, first, last, stream)


class Pace:
    """Measure how fast a run goes, as frames and substeps for each second of wall time."""

    def __init__(self, first: int, last: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._first = first
        self._last = last
        self._clock = clock
        self._start = clock()
        self._steps: int | None = None
        self.steps_per_second = 0.0
        self.seconds_left: float | None = None

    def update(self, frame: int, steps: int) -> None:
        """Take note that `frame` is done after `steps` substeps."""
        if self._steps is None:  # the first frame shown took no time here
            self._first, self._steps, self._start = frame, steps, self._clock()
            return
        passed = max(self._clock() - self._start, 1e-9)
        self.steps_per_second = (steps - self._steps) / passed
        if frame > self._first:
            self.seconds_left = passed / (frame - self._first) * (self._last - frame)

    def describe(self, particles: int) -> str:
        """Return the particle count, the pace and the time left in words."""
        text = f"{particles:,} particles"
        if self.steps_per_second > 0.0:
            text += f", {self.steps_per_second:,.3g} steps/s"
        if self.seconds_left is not None and self.seconds_left > 0.0:
            text += f", {duration(self.seconds_left)} left"
        return text


def duration(seconds: float) -> str:
    """Write a time span for a reader: 42 s, 3:07 min, 2:05 h."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02d} h"


class Silence:
    """Show nothing; errors are raised as always, and warnings are shown by `warnings_to`."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return

    def update(self, frame: int, particles: int, steps: int) -> None:
        """Show nothing."""

    def say(self, sentence: str) -> None:
        """Show nothing."""


class Lines:
    """Write a plain line at the first and the last frame and every few seconds between."""

    def __init__(
        self,
        name: str,
        first: int,
        last: int,
        stream: TextIO,
        every: float = 5.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._name, self._last, self._stream = name, last, stream
        self._every, self._clock = every, clock
        self._pace = Pace(first, last, clock)
        self._shown: float | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return

    def update(self, frame: int, particles: int, steps: int) -> None:
        """Write the line if it is time."""
        self._pace.update(frame, steps)
        now = self._clock()
        if self._shown is not None and now - self._shown < self._every and frame != self._last:
            return
        self._shown = now
        self.say(f"{self._name}: frame {frame} of {self._last}, {self._pace.describe(particles)}")

    def say(self, sentence: str) -> None:
        """Write the sentence on a line of its own."""
        print(sentence, file=self._stream, flush=True)


class Bar:
    """Draw a bar that fills, with particles, substeps per second and the time left."""

    def __init__(self, name: str, first: int, last: int, stream: TextIO) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn
        from rich.progress import Progress as RichProgress

        self._pace = Pace(first, last)
        self._bar: RichProgress = RichProgress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=20),
            TextColumn("frame {task.completed:.0f} of {task.total:.0f}, {task.fields[pace]}"),
            console=Console(file=stream),
            redirect_stdout=False,
            redirect_stderr=False,
        )
        self._task: TaskID = self._bar.add_task(name, total=last, completed=first, pace="")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()

    def update(self, frame: int, particles: int, steps: int) -> None:
        """Fill the bar up to `frame`."""
        self._pace.update(frame, steps)
        self._bar.update(self._task, completed=frame, pace=self._pace.describe(particles), refresh=True)

    def say(self, sentence: str) -> None:
        """Print the sentence above the bar."""
        self._bar.console.print(sentence, highlight=False, markup=False)


class Warnings(Silence):
    """Show no progress; print sentences as lines in the style of the command line."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = cast(TextIO, Steady(stream or sys.stderr))

    def say(self, sentence: str) -> None:
        """Write the sentence on a line of its own."""
        print(f"neve: {sentence}", file=self._stream, flush=True)


@contextlib.contextmanager
def warnings_to(progress: Progress) -> Iterator[None]:
    """Show warnings logged under "neve" in the block as sentences of `progress`, not of Python's logging.

    A run that shows no progress still warns: give it `Warnings`. Of more than MOST_ALIKE that say the same of
    other parts, or with other numbers, the others are counted at the end.
    """
    logger = logging.getLogger("neve")
    handler = _Handler(progress)
    before = logger.propagate
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield
    finally:
        logger.propagate = before
        logger.removeHandler(handler)
        handler.count()


class _Handler(logging.Handler):
    def __init__(self, progress: Progress) -> None:
        super().__init__()
        self._progress = progress
        self._seen: dict[str, list[str]] = {}
        self._more: Counter[str] = Counter()

    def emit(self, record: logging.LogRecord) -> None:
        said = record.getMessage()
        kind = kind_of(said)
        seen = self._seen.setdefault(kind, [])
        if said not in seen and len(seen) < MOST_ALIKE:
            seen.append(said)
            self._progress.say(f"warning: {said}")
        else:
            self._more[kind] += 1

    def count(self) -> None:
        """Say how many warnings were not shown because others had said the same."""
        for kind, times in self._more.items():
            self._progress.say(f"warning: {self._seen[kind][0].rstrip('.')} (and likewise {times:,} others)")
