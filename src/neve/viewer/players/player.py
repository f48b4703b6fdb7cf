"""Player: a thread that has a run, keeps its latest snapshot, and takes commands from a queue."""

from __future__ import annotations

import contextlib
import logging
import queue
import re
import threading
from collections.abc import Callable
from pathlib import Path

from pydantic import BaseModel

from neve.colliders.solid import Solid
from neve.scene.errors import SceneError
from neve.scene.reading.paths import follow
from neve.scene.schema.scene import Scene
from neve.viewer.players.snapshot import Snapshot
from neve.viewer.protocol.commands import Command
from neve.viewer.protocol.messages import Message, PlayerState, RobotControl

KEY = re.compile(r"[a-z_]+(?:\.[A-Za-z_0-9]+)+")
"""The key of a value as a sentence has it: numerics.dx."""

WAIT = 0.25
"""Longest sleep of a player that has nothing to do [s]."""


class Begin(Command):
    """Play another scene. The server alone gives this command, for a name that it has looked up."""

    name: str
    scene: Scene


class Player:
    """Run in a thread of its own; the server sees `latest`, which is replaced and never written into.

    on_snapshot is called after each new snapshot, on_scene when what `describe` returns has changed,
    on_message with each other message to all pages, on_failure with what ended the thread. All are called
    from the player's thread and must not wait.
    """

    live = False

    def __init__(self, name: str, scene: Scene) -> None:
        self.name = name
        self.scene = scene
        """The scene as the panel shows it and as it would be saved."""
        self.number = 0
        """Counts the changes of what `describe` returns."""
        self.latest: Snapshot | None = None
        self.modes: set[str] = set()
        """Colour modes that some page looks at; the server sets them."""
        self.meshes: dict[str, Path] = {}
        """Meshes that pages have dropped, by name; the server fills it."""
        self.plots = False
        """Whether some page has asked for figures over time."""
        self.on_snapshot: Callable[[], None] = lambda: None
        self.on_scene: Callable[[], None] = lambda: None
        self.on_message: Callable[[Message], None] = lambda message: None
        self.on_failure: Callable[[BaseException], None] = lambda error: None
        self._queue: queue.SimpleQueue[Command] = queue.SimpleQueue()
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="neve-player", daemon=True)

    def make_ready(self) -> None:
        """Do before the start what may fail, for who wants to know. Errors: SceneError."""

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread and wait for it."""
        self._stopped.set()
        if self._thread.is_alive():
            self._thread.join()

    def submit(self, command: Command) -> None:
        """Put a command into the queue; it is done by the player's thread between two steps."""
        self._queue.put(command)

    def solids(self) -> tuple[Solid, ...]:
        """Return the solids in the order of a snapshot's poses."""
        raise NotImplementedError

    def radius(self) -> float:
        """Return the radius of a particle [m], as the scene says unless a solver says it."""
        return self.scene.numerics.spacing / 2

    def running(self) -> Scene:
        """Return the scene whose snow is shown, with what pages have thrown in."""
        return self.scene

    def begun(self) -> Scene:
        """Return the scene as the panel would have shown it when this run began."""
        return self.scene

    def color_modes(self) -> list[str]:
        """Return the names of the colour modes that can be shown."""
        raise NotImplementedError

    def controls(self) -> list[RobotControl]:
        """Return the controls of motors and robots that a page can hold."""
        return []

    def state(self) -> PlayerState:
        """Return whether it plays, how fast, and how many frames there are to seek in."""
        raise NotImplementedError

    def _run(self) -> None:
        try:
            self._begin()
            while not self._stopped.is_set():
                self._take_commands(0.0 if self._busy() else WAIT)
                if self._busy():
                    self._go_on()
        except BaseException as error:  # nothing above a thread catches this: the server ends with it
            self.on_failure(error)

    def _take_commands(self, wait: float) -> None:
        """Do all commands that are there; with none, wait up to `wait` [s] for the first."""
        try:
            command = self._queue.get(timeout=wait) if wait > 0 else self._queue.get_nowait()
            while True:
                self._try(command)
                command = self._queue.get_nowait()
        except queue.Empty:
            pass

    def _try(self, command: Command) -> None:
        try:
            self._do(command)
        except SceneError as error:
            self._refuse(str(error), getattr(command, "path", "") or blamed(self.scene, str(error)))
        except Exception as error:  # whatever one page has asked for, the others go on watching
            logging.getLogger("neve").exception("a command of a page failed")
            self._refuse(f"this could not be done: {' '.join(str(error).split())[:200]}")

    def _begin(self) -> None:
        raise NotImplementedError

    def _busy(self) -> bool:
        raise NotImplementedError

    def _go_on(self) -> None:
        raise NotImplementedError

    def _do(self, command: Command) -> None:
        raise NotImplementedError

    def _show(self, snapshot: Snapshot) -> None:
        self.latest = snapshot
        self.on_snapshot()

    def _scene_changed(self) -> None:
        self.number += 1
        self.on_scene()

    def _state_changed(self) -> None:
        self.on_message({"kind": "player", **self.state()})

    def _note(self, sentence: str) -> None:
        self.on_message({"kind": "note", "sentence": sentence})

    def _refuse(self, sentence: str, path: str = "") -> None:
        self.on_message({"kind": "refused", "sentence": sentence, "path": path})


def blamed(scene: Scene, sentence: str) -> str:
    """Return the key of the first value of `scene` that a sentence names, or an empty text."""
    for key in KEY.findall(sentence):
        with contextlib.suppress(KeyError, SceneError):
            if not isinstance(follow(scene, key.split(".")), BaseModel | tuple):
                return str(key)
    return ""
