"""How long a run of a sweep has taken, kept in its folder for the next table."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from neve.io.atomic import write_text
from neve.io.run_folder import RunFolder
from neve.system import disk

FILE = "sweep_run.json"
UNFINISHED = -1


@dataclass(frozen=True)
class Spent:
    """Hold the wall time of a run [s], over all calls that it took, and the last frame if it came to it."""

    seconds: float = 0.0
    frame: int = UNFINISHED


def read(folder: Path) -> Spent | None:
    """Return what the run in `folder` has taken; None if it does not say."""
    try:
        held = json.loads(disk.read_bytes(folder / FILE))
        return Spent(float(held["seconds"]), int(held["frame"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None


@contextlib.contextmanager
def counted(folder: Path, last: int, anew: bool) -> Iterator[None]:
    """Add the wall time of the block to what the run has taken; last: its frame if the block succeeds.

    anew: the block replaces the run that lies there. A process that is killed adds nothing.
    """
    begin, frame = time.monotonic(), UNFINISHED
    before = None if anew else read(folder)
    try:
        yield
        frame = last
    finally:
        run = RunFolder(folder)
        if run.is_run():
            seconds = (before.seconds if before else 0.0) + time.monotonic() - begin
            if not (folder / FILE).exists():
                run.own(FILE)
            write_text(folder / FILE, json.dumps({"seconds": seconds, "frame": frame}))
