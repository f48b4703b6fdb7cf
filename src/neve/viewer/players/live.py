"""Live: simulate while the pages watch, and let them take part."""

from __future__ import annotations

import warnings
from time import monotonic
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from neve.build import with_one_more
from neve.colliders.solid import Solid
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.schema.scene import Scene
from neve.simulation import Simulation
from neve.viewer.modes import MODES, available
from neve.viewer.players.costs import Costs
from neve.viewer.players.figures import Figures, Sampler
from neve.viewer.players.history import History, going_on
from neve.viewer.players.player import WAIT, Begin, Player
from neve.viewer.players.recorder import Recorder
from neve.viewer.players.snapshot import of_simulation
from neve.viewer.protocol import commands
from neve.viewer.protocol.commands import Command
from neve.viewer.protocol.messages import PlayerState, RobotControl
from neve.viewer.tools import edit
from neve.viewer.tools.change import changed, is_live
from neve.viewer.tools.hands import Hands, controls_of
from neve.viewer.tools.placing import half_of, lifted
from neve.viewer.tools.throwing import ball_of

PAUSE = 1 / 30
"""Seconds of work between two snapshots, where steps are short enough."""

COPYING = 0.2
"""Greatest share of the player's time that goes into copying snapshots for the pages."""


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
        self._costs, self._figures = Costs(), Figures()
        self._due = 0.0  # clock from which the pages may see another snapshot
        self._hands = Hands()
        self._sources: list[int] = []  # number in the running scene of each source of `scene`
        self._slow: dict[str, SlowColors] = {}
        self._history = History()
        self._begun = scene
        self._first: Simulation | None = None  # made before the player started

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

    def begun(self) -> Scene:
        """Return the scene as it was when this run began, with the sources that were added since."""
        return self._begun

    def controls(self) -> list[RobotControl]:
        """Return the controls of motors and robots that a page can hold."""
        return controls_of(self._sim)

    def state(self) -> PlayerState:
        """Return whether it plays, and how fast."""
        return {
            "playing": self._playing,
            "speed": self._speed,
            "frames": 0,
            "recording": self._recorder.on,
            "recorded": self._recorder.frames,
            "undo": self._history.last,
            "redo": self._history.next,
        }

    def _begin(self) -> None:
        self._sim, self._first = self._first or self._made(), None
        self._begun = self.scene
        self._frame, self._chunk, self._costs = 0, 1e-3, Costs()
        self._sources = list(range(len(self.scene.sources)))
        self._hands = Hands()
        self._sampler = Sampler()
        self._plot(Figures())
        self._scene_changed()
        self._publish()

    def make_ready(self) -> None:
        """Fill the scene before the player starts, for who wants to know first whether it can begin.

        Errors: SceneError.
        """
        self._first = self._made()

    def _made(self) -> Simulation:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)
            return Simulation(self.scene, threads=self._threads)

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
            self._hands.act(sim, piece)
            sim.advance(piece, lambda: self._look_up(began))
        except (RuntimeError, ValueError) as error:  # lost numbers, or a drag that the scene refuses
            self._playing = self._one = False
            self._hands.drop()
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
        self._plot(self._figures)
        duration = self.scene.run.duration
        if 0.0 <= self._sim.time - duration < 1.0 / self._sim.scene.run.fps - 1e-9:
            self._note(f"run.duration = {duration:g} s is over: neve run ends here, the viewer goes on")
        if self._recorder.on:
            self._recorder.keep(self._sim)
        self._publish()
        if self._one:
            self._one = False
            self._state_changed()

    def _plot(self, figures: Figures) -> None:
        """Add the figures of this frame, and tell them to who plots them."""
        self._figures = figures
        figures.add(self._frame, self._sampler.values(self._sim, self.plots))
        if self.plots:
            self.on_message(figures.message(len(figures) - 1))

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
        self._chunk = max(piece * grow, 8 * self._sim.stats.dt_mean)
        self._costs.add(self._sim, piece, seconds)

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
        snapshot = of_simulation(
            self._sim, new, known, self._frame, self._costs.facts(self._sim), self.number
        )
        next_time = monotonic() + max(1.0, 10 * (monotonic() - began))
        self._slow |= {mode: SlowColors(snapshot.values[mode], next_time) for mode in slow - set(known)}
        self._show(snapshot)

    def _is_fresh(self, mode: str, count: int) -> bool:
        """Whether a slow mode can be shown as last measured: the simulation does not wait for a colour."""
        last = self._slow.get(mode)
        return last is not None and monotonic() < last.next_time and len(last.values) == count

    def _do(self, command: Command) -> None:
        """Do what a page asks; a change of the scene can be taken back."""
        before = self.scene
        self._obey(command)
        if self._history.keep(command, before, self.scene):
            self._state_changed()

    def _obey(self, command: Command) -> None:
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
            case Begin():
                self._open(command.name, command.scene)
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
            case commands.Undo():
                self._go_to(self._history.undo())
            case commands.Redo():
                self._go_to(self._history.redo())
            case commands.Throw():
                self._throw(command)
            case commands.Touch() | commands.Pull() | commands.Drive():
                self._hands.take(command, self._sim)
            case commands.Move():
                self._move(command)
            case commands.ColorMode():
                self._publish()  # the new colours, also while nothing moves
            case commands.Plot():
                self.plots = True
                self.on_message(self._figures.message(0))

    def _begin_with(self, scene: Scene, name: str = "") -> None:
        """Begin another scene. Errors: SceneError for one that cannot begin; then nothing has changed."""
        before = self.name, self.scene
        self.name, self.scene = name or self.name, scene
        try:
            self._begin()
        except SceneError:
            self.name, self.scene = before
            raise

    def _open(self, name: str, scene: Scene) -> None:
        """Begin a scene that has nothing to do with this one. Errors: SceneError, as above."""
        self._begin_with(scene, name)
        self._history = History()
        self._recorder.switch(False, self._sim, self.scene)
        self._playing = self._one = False
        self._state_changed()

    def _set(self, path: str, value: Any) -> None:
        new_scene = changed(self.scene, path, value)
        if is_live(self.scene, path):
            self._sim.change(changed(self._sim.scene, self._running(path), value))
        self._take_scene(new_scene)

    def _add(self, command: commands.Add) -> None:
        """Add an entry that stands on a point, or on the snow that is in its way."""
        numerics = self._sim.scene.numerics
        edit.added(self.scene, command, numerics.dx, self.meshes)  # refuses what there is not
        x = np.asarray(self._sim.columns()["x"]())
        rise = lifted(command.at, half_of(command.shape, numerics.dx, self.meshes), x, numerics)
        if rise > 0.0:
            a, b, c = command.at
            command = command.model_copy(update={"at": (a, b, c + rise)})
            self._note(
                f"there is snow in the way: the {command.shape} lies on top of it, {rise:.3g} m higher"
            )
        new_scene, source = edit.added(self.scene, command, numerics.dx, self.meshes)
        if source is None:
            self._sim.change(edit.added(self._sim.scene, command, numerics.dx, self.meshes)[0])
        else:
            self._grow(source)
            self._sources.append(len(self._sim.scene.sources) - 1)
            self._begun = with_one_more(self._begun, source)
        self._take_scene(new_scene)

    def _go_to(self, scene: Scene) -> None:
        """Go on in a scene of the history; where it has other snow, begin with it.

        Errors: SceneError for a scene that cannot begin; then nothing has changed.
        """
        old = self.scene
        counts = [[len(s.sources), len(s.emitters)] for s in (old, scene)]
        if counts[0] == counts[1]:
            self._sim.change(going_on(scene, self._sim, self._sources))
        else:
            self._begin_with(scene)
            self._note("the snow of the scene is another: it begins again")
        self._take_scene(scene)
        self._history.went(old)
        self._state_changed()

    def _enlarge(self, path: str) -> None:
        new_scene = edit.enlarged(self.scene, path)
        if is_live(self.scene, path):
            self._sim.change(edit.enlarged(self._sim.scene, self._running(path)))
        self._take_scene(new_scene)

    def _delete(self, name: str) -> None:
        new_scene = edit.deleted(self.scene, name)
        if name.startswith(("sources.", "emitters.")) and name.count(".") == 1:
            self._begin_with(new_scene)  # whose snow is whose is known at the start alone
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
        ball = ball_of(throw, 2 * self.radius())
        if ball is not None:
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
            self._hands.take(move, self._sim)
        else:
            self._sim.change(edit.placed(self._sim.scene, move))
            self._publish()
        self.scene = new_scene
        if move.done:
            self._scene_changed()
