"""Live: simulate while the pages watch, and let them take part."""

from __future__ import annotations

import warnings
from time import monotonic
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from neve.colliders.solid import Solid
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.load import load
from neve.scene.reading.presets import presets
from neve.scene.schema.scene import Scene, Source
from neve.simulation import Simulation
from neve.viewer.modes import MODES, available
from neve.viewer.players.player import WAIT, Player
from neve.viewer.players.recorder import Recorder
from neve.viewer.players.snapshot import of_simulation, present
from neve.viewer.protocol import commands
from neve.viewer.protocol.commands import Command
from neve.viewer.protocol.messages import Facts, PlayerState
from neve.viewer.tools import edit
from neve.viewer.tools.change import changed, is_live
from neve.viewer.tools.drag import DragController
from neve.viewer.tools.velocity import VelocityTool

PAUSE = 1 / 30
"""Seconds of work between two snapshots, where steps are short enough."""

COPYING = 0.2
"""Greatest share of the player's time that goes into copying snapshots for the pages."""

MOST_THROWN = 200_000
"""Particles of a ball that may be thrown."""


class SlowColors(NamedTuple):
    """Hold the values of a slow colour mode, (n,), and the clock time from which to measure again [s]."""

    values: NDArray[np.float32]
    next_time: float


class Live(Player):
    """Simulate a scene, at most `speed` times as fast as it happens.

    `scene` is what a restart begins with and what is saved. The running simulation's own scene also has the
    thrown balls, and colliders on their way to where a page drags them.
    """

    live = True

    def __init__(self, name: str, scene: Scene, threads: int | None, recorder: Recorder) -> None:
        super().__init__(name, scene)
        self._threads = threads
        self._recorder = recorder
        self._playing = self._one = False
        self._speed = 1.0
        self._frame = 0
        self._chunk = 1e-3  # simulated seconds of the next piece of work
        self._anchor = (0.0, 0.0)  # clock and simulated time from which the pace is counted
        self._spent: dict[str, float] = {}  # seconds of each stage, lately
        self._due = 0.0  # clock from which the pages may see another snapshot
        self._velocity_tool, self._drags = VelocityTool(), DragController()
        self._sources: list[int] = []  # number in the running scene of each source of `scene`
        self._slow: dict[str, SlowColors] = {}

    def solids(self) -> tuple[Solid, ...]:
        """Return the solids in the order of a snapshot's poses."""
        return tuple(self._sim.solver.solids)

    def color_modes(self) -> list[str]:
        """Return the names of the colour modes that the solver has columns for."""
        return available(set(self._sim.columns()))

    def radius(self) -> float:
        """Return the radius of a particle [m] that the solver has."""
        return self._sim.radius

    def running(self) -> Scene:
        """Return the scene whose snow is shown, with what pages have thrown in."""
        return self._sim.scene

    def state(self) -> PlayerState:
        """Return whether it plays, and how fast."""
        return {
            "playing": self._playing,
            "speed": self._speed,
            "frames": 0,
            "recording": self._recorder.on,
            "recorded": self._recorder.frames,
        }

    def _begin(self) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)
            self._sim = Simulation(self.scene, threads=self._threads)
        self._frame, self._chunk, self._spent = 0, 1e-3, {}
        self._sources = list(range(len(self.scene.sources)))
        self._velocity_tool, self._drags = VelocityTool(), DragController()
        self._scene_changed()
        self._publish()

    def _busy(self) -> bool:
        return self._playing or self._one

    def _go_on(self) -> None:
        """Simulate one piece, showing it on the way; wait before it if the page has asked for slow motion."""
        sim = self._sim
        end = (self._frame + 1) / sim.scene.run.fps
        piece = min(self._chunk, end - sim.time)
        if end - sim.time - piece < 0.3 * piece:
            piece = end - sim.time
        if self._must_wait(sim.time + piece):
            return
        began, start = monotonic(), sim.time
        try:
            self._drags.act(sim, piece)
            self._velocity_tool.act(sim, piece)
            sim.advance(piece, lambda: self._look_up(began))
        except (RuntimeError, ValueError) as error:  # lost numbers, or a drag that the scene refuses
            self._playing = self._one = False
            self._drags = DragController()
            self._refuse(str(error))
            self._state_changed()
            return
        self._pace(sim.time - start, monotonic() - began)
        if sim.time >= end - 1e-9:
            self._end_frame()
        elif monotonic() >= self._due:
            self._publish()

    def _end_frame(self) -> None:
        self._frame += 1
        if self._recorder.on:
            self._recorder.keep(self._sim)
        self._publish()
        if self._one:
            self._one = False
            self._state_changed()

    def _look_up(self, began: float) -> bool:
        """Show what is there, between two steps; return whether a command has waited long enough."""
        now = monotonic()
        if now >= self._due:
            self._publish()
        return now - began > PAUSE and not self._queue.empty()

    def _must_wait(self, time: float) -> bool:
        """Whether the pace is ahead of the clock; then some of that time passes here, open for commands."""
        clock, start = self._anchor
        ahead = (time - start) / self._speed - (monotonic() - clock)
        if self._one or ahead <= 0.0:
            if ahead < -0.2:  # too slow for the pace: do not race after it later
                self._anchor = (monotonic(), time)
            return False
        self._take_commands(min(ahead, WAIT))
        return ahead > 0.02 or not self._busy()

    def _pace(self, piece: float, seconds: float) -> None:
        """Choose the next piece so that it takes PAUSE, but has at least eight steps in it: each piece begins
        with a sort, which takes as long as a step. Commands of the pages cut it short."""
        grow = min(max(PAUSE / max(seconds, 1e-4), 0.5), 2.0)
        stats = self._sim.stats
        self._chunk = max(piece * grow, 8 * stats.dt_mean)
        for name, spent in stats.stage_seconds.items():
            self._spent[name] = 0.9 * self._spent.get(name, 0.0) + spent
        self._spent["all"] = 0.9 * self._spent.get("all", 0.0) + seconds
        self._spent["simulated"] = 0.9 * self._spent.get("simulated", 0.0) + piece

    def _publish(self) -> None:
        """Show the present state now, and the next one when it is worth the cost of copying it."""
        began = monotonic()
        self._copy()
        self._due = began + max(PAUSE, (monotonic() - began) / COPYING)

    def _copy(self) -> None:
        count = self._sim.count
        modes = self.modes & set(self.color_modes())
        slow = {mode for mode in modes if MODES[mode].slow}
        known = {mode: self._slow[mode].values for mode in slow if self._is_fresh(mode, count)}
        began = monotonic()
        new = modes - set(known)
        snapshot = of_simulation(self._sim, new, known, self._frame, self._facts(), self.number)
        next_time = monotonic() + max(1.0, 10 * (monotonic() - began))
        self._slow |= {mode: SlowColors(snapshot.values[mode], next_time) for mode in slow - set(known)}
        self._show(snapshot)

    def _is_fresh(self, mode: str, count: int) -> bool:
        """Whether a slow mode can be shown as last measured: the simulation does not wait for a colour."""
        last = self._slow.get(mode)
        return last is not None and monotonic() < last.next_time and len(last.values) == count

    def _facts(self) -> Facts:
        sim, spent = self._sim, self._spent
        total = max(spent.get("all", 0.0), 1e-9)
        return {
            "particles": sim.count,
            "steps": sim.steps,
            "dt": sim.stats.dt_mean,
            "bound": sim.stats.bound,
            "rejected": sim.stats.rejected,
            "pace": spent.get("simulated", 0.0) / total,
            "keyed": present(sim.scene, sim.time),
            "stages": {name: spent[name] / total for name in spent if name not in ("all", "simulated")},
        }

    def _do(self, command: Command) -> None:
        match command:
            case commands.Play() | commands.Pause():
                self._playing = isinstance(command, commands.Play)
                self._anchor = (monotonic(), self._sim.time)
                self._state_changed()
                self._publish()  # what a pause stops at
            case commands.Frame():
                self._playing, self._one = False, True
                self._state_changed()
            case commands.Speed():
                self._speed = command.factor
                self._anchor = (monotonic(), self._sim.time)
                self._state_changed()
            case commands.Restart():
                self._begin()
                self._anchor = (monotonic(), 0.0)
            case commands.Open():
                self._open(command.scene)
            case commands.Record():
                self._recorder.switch(command.on, self._sim, self.scene)
                self._state_changed()
            case commands.Set():
                self._set(command.path, command.value)
            case commands.Add():
                self._add(command)
            case commands.Enlarge():
                self._enlarge(command.path)
            case commands.Delete():
                self._delete(command.name)
            case commands.Throw():
                self._throw(command)
            case commands.Touch():
                self._velocity_tool.take(command)
            case commands.Move():
                self._move(command)
            case commands.ColorMode():
                self._publish()  # the new colours, also while nothing moves

    def _open(self, name: str) -> None:
        """Begin another of the scenes that come with Neve: only their names are taken, never a path."""
        if name not in presets():
            raise SceneError(f'no scene that comes with Neve is called "{name}"')
        self.name, self.scene = name, load(name)
        self._recorder.switch(False, self._sim, self.scene)
        self._playing = self._one = False
        self._begin()
        self._state_changed()

    def _set(self, path: str, value: Any) -> None:
        new_scene = changed(self.scene, path, value)
        if is_live(self.scene, path):
            self._sim.change(changed(self._sim.scene, self._running(path), value))
        self._take_scene(new_scene)

    def _add(self, command: commands.Add) -> None:
        new_scene, source = edit.added(self.scene, command)
        if source is None:
            self._sim.change(edit.added(self._sim.scene, command)[0])
        else:
            self._grow(source)
            self._sources.append(len(self._sim.scene.sources) - 1)
        self._take_scene(new_scene)

    def _enlarge(self, path: str) -> None:
        new_scene = edit.enlarged(self.scene, path)
        if is_live(self.scene, path):
            self._sim.change(edit.enlarged(self._sim.scene, self._running(path)))
        self._take_scene(new_scene)

    def _delete(self, name: str) -> None:
        new_scene = edit.deleted(self.scene, name)
        if name.startswith(("sources.", "emitters.")) and name.count(".") == 1:
            self.scene = new_scene
            self._begin()  # whose snow is whose is known at the start alone
        elif is_live(self.scene, name):
            self._sim.change(edit.deleted(self._sim.scene, self._running(name)))
        self._take_scene(new_scene)

    def _take_scene(self, new_scene: Scene) -> None:
        self.scene = new_scene
        self._scene_changed()
        self._publish()

    def _running(self, path: str) -> str:
        """Return the path in the running scene, where thrown balls stand between the sources."""
        keys = path.split(".")
        if keys[0] == "sources":
            keys[1] = str(self._sources[int(keys[1])])
        return ".".join(keys)

    def _throw(self, throw: commands.Throw) -> None:
        norm = sum(a * a for a in throw.direction) ** 0.5
        if norm < 1e-9:
            return
        many = 4.2 * (throw.radius / (2 * self.radius())) ** 3
        if many > MOST_THROWN:
            raise SceneError(f"a ball of {throw.radius:g} m has {many:.2g} particles: throw a smaller one")
        way = [a / norm for a in throw.direction]
        ball = Source.of(
            "sphere",
            center=tuple(o + 2 * throw.radius * w for o, w in zip(throw.origin, way, strict=True)),
            radius=throw.radius,
            velocity=tuple(throw.speed * w for w in way),
        )
        self._grow(ball)
        self._publish()

    def _grow(self, source: Any) -> None:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", SceneWarning)
                self._sim.add(source)
        except ValidationError as error:
            raise SceneError(f"this snow cannot be added: {error.errors()[0]['msg']}") from error

    def _move(self, move: commands.Move) -> None:
        """Move a solid to where a page drags it: at once while nothing plays, else at a finite speed."""
        new_scene = edit.placed(self.scene, move)
        if self._busy():
            self._drags.take(move)
        else:
            self._sim.change(edit.placed(self._sim.scene, move))
            self._publish()
        self.scene = new_scene
        if move.done:
            self._scene_changed()
