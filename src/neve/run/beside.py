"""Work beside the simulation: files are written while the next frame is computed, in order.

One thread does what is handed to it, first things first. So a checkpoint is written after all that it stands
for, and a process that is killed leaves what a run that waits for its files would have left, some frames
earlier.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from types import TracebackType
from typing import Self

DEPTH = 2
"""Frames that may be under way: one that is written, and one that waits."""

Job = Callable[[], None]


class Beside:
    """Do jobs in a thread of its own, in a `with` block; outside of it at once.

    An error of a job ends all after it; it is raised where the next job is handed over, or at the end.
    """

    def __init__(self) -> None:
        self._jobs: deque[tuple[int, Job]] = deque()
        self._given = self._done = 0  # jobs so far
        self._change = threading.Condition()
        self._error: BaseException | None = None
        self._busy: int | None = None  # frame of the job that is being done
        self._ends = False
        self._thread: threading.Thread | None = None

    def do(self, frame: int, job: Job) -> int:
        """Do `job` of `frame` after all jobs before it; return its number, for `wait`.

        Waits while jobs of DEPTH frames before it are not done. Errors: what an earlier job raised.
        """
        if self._thread is None:
            job()
            return self._done
        with self._change:
            self._change.wait_for(lambda: self._error or self._oldest() > frame - DEPTH)
            self._raise()
            self._jobs.append((frame, job))
            self._given += 1
            self._change.notify_all()
            return self._given

    def wait(self, number: int | None = None) -> None:
        """Wait until the job of this number is done, or all. Errors: what one of them raised."""
        with self._change:
            last = self._given if number is None else number
            self._change.wait_for(lambda: self._error or self._done >= last)
            self._raise()

    def __enter__(self) -> Self:
        self._thread = threading.Thread(target=self._run, name="neve-outputs", daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        thread, self._thread = self._thread, None
        with self._change:
            if error is not None and not isinstance(error, Exception):  # somebody is in a hurry
                self._jobs.clear()
            self._ends = True
            self._change.notify_all()
        if thread is not None:
            thread.join()
        if error is None:
            self._raise()

    def _oldest(self) -> float:
        frames = [] if self._busy is None else [self._busy]
        return min([*frames, *(frame for frame, _ in self._jobs)], default=float("inf"))

    def _raise(self) -> None:
        if self._error is not None:
            error, self._error = self._error, None
            self._jobs.clear()
            raise error

    def _run(self) -> None:
        while True:
            with self._change:
                self._change.wait_for(lambda: self._jobs or self._ends)
                if not self._jobs:
                    return
                self._busy, job = self._jobs.popleft()
            try:
                job()
            except BaseException as error:
                with self._change:
                    self._error = error
                    self._jobs.clear()
            with self._change:
                self._busy = None
                self._done += 1
                del job
                self._change.notify_all()
