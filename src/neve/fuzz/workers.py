"""Processes that run the trials of a campaign, so that a crash or a hang ends one trial and nothing else."""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from neve.fuzz.outcome import Outcome, outcome_of

MOST_SAID = 4000
"""Characters of a dead worker's last words that are kept."""


def outcomes(
    place: str, trials: Iterable[tuple[int, int]], jobs: int, limit: float, scratch: Path
) -> Iterator[Outcome]:
    """Run the function "module:function" of `place` for each (seed, number); yield outcomes as they come.

    jobs: processes at once. limit: seconds [s] for a trial; then its process, with all that it started, is
    killed. scratch: a folder in which each process gets a TMPDIR of its own.
    """
    waiting = iter(trials)
    workers: list[_Worker] = []
    selector = selectors.DefaultSelector()
    try:
        for index in range(jobs):
            worker = _Worker(place, scratch / str(index))
            if not worker.take(next(waiting, None)):
                break
            workers.append(worker)
            selector.register(worker.answers, selectors.EVENT_READ, worker)
        while busy := [worker for worker in workers if worker.trial]:
            soonest = min(worker.started for worker in busy) + limit
            ready = {id(key.data) for key, _ in selector.select(max(soonest - time.monotonic(), 0.0))}
            for worker in busy:
                outcome = worker.hear(limit, id(worker) in ready)
                if outcome is None:
                    continue
                if worker.is_dead:
                    selector.unregister(worker.answers)
                    worker.end()
                yield outcome
                was_dead = worker.is_dead
                if worker.take(next(waiting, None)) and was_dead:
                    selector.register(worker.answers, selectors.EVENT_READ, worker)
    finally:
        for worker in workers:
            worker.end()
        selector.close()


class _Worker:
    """A process, which is started when it is needed, and the trial that it is at."""

    def __init__(self, place: str, scratch: Path) -> None:
        self.place, self.scratch = place, scratch
        self.trial: tuple[int, int] | None = None
        self.started = 0.0
        self.is_dead = True
        self._heard = b""

    def take(self, trial: tuple[int, int] | None) -> bool:
        """Begin the next trial; return whether there is one."""
        self.trial = trial
        if trial is None:
            return False
        if self.is_dead:
            self._start()
        self.started = time.monotonic()
        with contextlib.suppress(BrokenPipeError):  # it died meanwhile: its answer will say so
            self._orders.write(f"{json.dumps(trial)}\n".encode())
            self._orders.flush()
        return True

    def _start(self) -> None:
        self.scratch.mkdir(parents=True)
        threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        self._errors = open(self.scratch / "stderr", "w+b")  # noqa: SIM115 (closed by end())
        self._process = subprocess.Popen(
            [sys.executable, "-m", "neve.fuzz.worker", self.place],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env={**os.environ, **threads, "TMPDIR": str(self.scratch)},
            start_new_session=True,  # a group: all that it starts can be killed, and Ctrl-C is not for it
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._orders, self.answers = self._process.stdin, self._process.stdout
        self.is_dead, self._heard = False, b""

    def hear(self, limit: float, is_ready: bool) -> Outcome | None:
        """Return the outcome of the trial if there is one: the answer, a death, or a hang."""
        assert self.trial is not None
        if is_ready:
            said = os.read(self.answers.fileno(), 1 << 16)
            self._heard += said
            if self._heard.endswith(b"\n"):
                answer, self._heard = self._heard, b""
                return outcome_of(answer.decode())
            if not said:
                return self._fallen(f"died: {_death(self._process.pid)}")
        if time.monotonic() - self.started > limit:
            return self._fallen(f"stuck: not done after {limit:g} s")
        return None

    def _fallen(self, sentence: str) -> Outcome:
        assert self.trial is not None
        self.is_dead = True
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace")[-MOST_SAID:]
        seconds = round(time.monotonic() - self.started, 3)
        return Outcome(*self.trial, "failed", "", sentence, seconds, {"stderr": said})

    def end(self) -> None:
        """Kill the process with all that it started, and remove its folder."""
        if not self.scratch.exists():
            return
        self.is_dead = True
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        for file in (self._errors, self._process.stdin, self._process.stdout):
            with contextlib.suppress(OSError):
                if file is not None:
                    file.close()
        shutil.rmtree(self.scratch, ignore_errors=True)


def _death(pid: int) -> str:
    """Name the way a child ended, and leave its number taken, so that its group can still be killed."""
    ended = os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
    assert ended is not None
    if ended.si_code == os.CLD_EXITED:
        return f"exit code {ended.si_status}"
    return f"killed by {signal.Signals(ended.si_status).name}"


@contextlib.contextmanager
def scratch() -> Iterator[Path]:
    """Make a folder for the processes, and remove it."""
    with tempfile.TemporaryDirectory(prefix="neve-fuzz-", ignore_cleanup_errors=True) as folder:
        yield Path(folder)
