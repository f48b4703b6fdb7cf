"""History: the scenes before and after each change of a page, to take it back and do it again."""

from __future__ import annotations

from time import monotonic
from typing import NamedTuple

from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene
from neve.simulation import Simulation
from neve.viewer.protocol import commands
from neve.viewer.protocol.commands import Command

MOST = 100
"""Changes that can be taken back."""

TOGETHER = 1.5
"""Seconds within which changes of the same value count as one: a key that is held, a slider."""


class Change(NamedTuple):
    """Hold what a change did, in words, and the scene on its other side."""

    words: str
    scene: Scene


class History:
    """Keep changes in the order in which they were made."""

    def __init__(self) -> None:
        self._done: list[Change] = []
        self._undone: list[Change] = []
        self._same = ("", 0.0)  # what was changed last, and the clock
        self._way = 0

    @property
    def last(self) -> str:
        """What `undo` would take back, or an empty text."""
        return self._done[-1].words if self._done else ""

    @property
    def next(self) -> str:
        """What `redo` would do again, or an empty text."""
        return self._undone[-1].words if self._undone else ""

    def keep(self, command: Command, before: Scene, after: Scene) -> bool:
        """Keep the change from `before` to `after`, if `command` is one that can be taken back; say whether.

        A drag of a solid, and changes of the same value that follow each other closely, are one change.
        """
        words = _words(command)
        if not words or before == after:
            return False
        same, now = words, monotonic()
        joined = self._same[0] == same and now - self._same[1] < TOGETHER and bool(self._done)
        self._same = ("", 0.0) if getattr(command, "done", False) else (same, now)
        self._undone.clear()
        if not joined:
            self._done = [*self._done[-MOST + 1 :], Change(words, before)]
        return True

    def undo(self) -> Scene:
        """Return the scene before the last change. Errors: SceneError if there was none."""
        if not self._done:
            raise SceneError("there is nothing to take back")
        self._way = -1
        return self._done[-1].scene

    def redo(self) -> Scene:
        """Return the scene after the change that was taken back last. Errors: SceneError if there is none."""
        if not self._undone:
            raise SceneError("there is nothing to do again")
        self._way = 1
        return self._undone[-1].scene

    def went(self, left: Scene) -> None:
        """Say that the scene of `undo` or `redo` is there now, and which was left for it."""
        here, there = (self._done, self._undone) if self._way < 0 else (self._undone, self._done)
        there.append(Change(here.pop().words, left))
        self._same = ("", 0.0)


def going_on(scene: Scene, sim: Simulation, sources: list[int]) -> Scene:
    """Return `scene` as a run can go on in it: with what the run has begun with, and what was thrown in.

    sources: number in the running scene of each source of `scene`.
    """
    running = sim.scene
    snow = list(running.sources)
    for k, source in zip(sources, scene.sources, strict=True):
        snow[k] = snow[k].model_copy(update={"snow": source.snow})
    kept = {name: getattr(running.numerics, name) for name in sim.solver.fixed}
    numerics = scene.numerics.model_copy(update=kept)
    return scene.model_copy(update={"sources": tuple(snow), "numerics": numerics, "run": running.run})


def _words(command: Command) -> str:
    match command:
        case commands.Set():
            return f"change of {command.path}"
        case commands.Add():
            return f"new {command.shape} in {command.kind}"
        case commands.Enlarge():
            return f"new entry of {command.path}"
        case commands.Delete():
            return f"deletion of {command.name}"
        case commands.Move():
            return f"move of {command.name}"
    return ""
