"""Recorded: play the frames of a finished or running run."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from time import monotonic
from typing import Any

import numpy as np

from neve.build import material_table, solids
from neve.colliders.solid import Solid
from neve.io.errors import RunError
from neve.io.frames import Frame, frame_numbers, frame_rate, read_frame
from neve.io.run_folder import RunFolder
from neve.scene.errors import SceneError
from neve.scene.reading.load import load
from neve.viewer.modes import Columns, available, measure
from neve.viewer.players.figures import of_run
from neve.viewer.players.player import Player
from neve.viewer.players.snapshot import Snapshot
from neve.viewer.protocol import commands
from neve.viewer.protocol.commands import Command
from neve.viewer.protocol.messages import PlayerState
from neve.viewer.tools.change import changed

KEPT = 512 * 2**20
"""Bytes of frames that stay in memory, so that playing in a circle does not read them again."""


class Recorded(Player):
    """Play the frames of a run folder at the run's own pace times `speed`, in a circle."""

    def __init__(self, run: RunFolder) -> None:
        """Read the scene and find the frames. Errors: RunError, SceneError."""
        super().__init__(run.path.resolve().name, load(run.path))
        self.run = run
        self._numbers = frame_numbers(run.frames)
        if not self._numbers:
            raise RunError(f"{run.path} holds no frames to play: run it first, neve run.")
        self._solids = solids(self.scene)
        self._rho0 = np.array([snow.rho0 for snow in material_table(self.scene)], np.float32)
        first = read_frame(run.frames, self._numbers[0])  # a damaged run is reported before a server starts
        self._modes = available(set(self._columns(first)))
        self._memory: OrderedDict[int, Frame] = OrderedDict()
        self._bytes = 0
        self._playing = False
        self._speed = 1.0
        self._at = 0  # place in self._numbers
        self._anchor = (0.0, 0)  # clock and place from which the pace is counted
        self._looked = monotonic()

    def solids(self) -> tuple[Solid, ...]:
        """Return the solids in the order of a snapshot's poses."""
        return self._solids

    def color_modes(self) -> list[str]:
        """Return the names of the colour modes that the frames have columns for."""
        return list(self._modes)

    def state(self) -> PlayerState:
        """Return whether it plays, how fast, and how many frames there are to seek in."""
        return {
            "playing": self._playing,
            "speed": self._speed,
            "frames": len(self._numbers),
            "recording": False,
            "recorded": len(self._numbers),
            "undo": "",
            "redo": "",
        }

    def _begin(self) -> None:
        self._scene_changed()
        self._show_frame()

    def _busy(self) -> bool:
        return self._playing

    def _go_on(self) -> None:
        """Show the frame whose time has come; wait for it, open for commands."""
        clock, start = self._anchor
        rate = float(frame_rate(self._numbers, self.scene.run.fps)) * self._speed
        due = start + int((monotonic() - clock) * rate)
        if due <= self._at:
            self._take_commands(max(0.001, clock + (self._at - start + 1) / rate - monotonic()))
            return
        self._look_for_more()
        if due >= len(self._numbers):
            due = 0
            self._anchor = (monotonic(), 0)
        self._at = due
        self._show_frame()

    def _look_for_more(self) -> None:
        """See, once a second, whether the run has gone on."""
        if monotonic() - self._looked < 1.0:
            return
        self._looked = monotonic()
        numbers = frame_numbers(self.run.frames)
        if len(numbers) != len(self._numbers) and numbers:
            self._numbers = numbers
            self._state_changed()
            if self.plots:
                self._tell_figures()

    def _tell_figures(self) -> None:
        try:
            self.on_message(of_run(self.run).message(0))
        except RunError as error:
            self._refuse(str(error))

    def _show_frame(self) -> None:
        self._at = min(self._at, len(self._numbers) - 1)
        try:
            frame = self._frame(self._numbers[self._at])
        except RunError as error:
            self._playing = False
            self._refuse(str(error))
            self._state_changed()
            return
        columns = self._columns(frame)
        known = set(self._modes)
        self._show(
            Snapshot(
                x=frame.x,
                values={m: measure(m, columns, 2 * self.radius()) for m in self.modes & known},
                poses=tuple(zip(frame.solid_position, frame.solid_rotation, strict=True)),
                time=frame.time,
                frame=self._at,
                facts={"particles": len(frame.x)},
                scene=self.number,
            )
        )

    def _place_of(self, seek: commands.Seek) -> int:
        """Return the place in the list of frames that a page looks for."""
        if seek.time is None:
            return min(seek.frame, len(self._numbers) - 1)
        times = np.array(self._numbers) / self.scene.run.fps
        return int(np.abs(times - seek.time).argmin())

    def _columns(self, frame: Frame) -> Columns:
        """Return what a frame has for the colour modes; density is rho0 / J_P, without the elastic strain."""
        J_P, material = frame.J_P, frame.material
        columns: dict[str, Callable[[], Any]] = {"x": lambda: frame.x, "v": lambda: frame.v}
        if J_P is not None:
            columns["J_P"] = lambda: J_P
        if material is not None:
            columns["material"] = lambda: material
        if J_P is not None and material is not None:
            columns["density"] = lambda: self._rho0[np.minimum(material, len(self._rho0) - 1)] / J_P
        return {name: _same(values) for name, values in frame.more.items()} | columns

    def _frame(self, number: int) -> Frame:
        """Return a frame from memory or from its file. Errors: RunError."""
        if number in self._memory:
            self._memory.move_to_end(number)
            return self._memory[number]
        frame = read_frame(self.run.frames, number)
        self._memory[number] = frame
        self._bytes += _size(frame)
        while self._bytes > KEPT and len(self._memory) > 1:
            self._bytes -= _size(self._memory.popitem(last=False)[1])
        return frame

    def _do(self, command: Command) -> None:
        match command:
            case commands.Play() | commands.Pause():
                self._playing = isinstance(command, commands.Play)
            case commands.Frame():
                self._playing = False
                self._at = (self._at + 1) % len(self._numbers)
            case commands.Speed():
                self._speed = command.factor
            case commands.Restart():
                self._at = 0
            case commands.Seek():
                self._at = self._place_of(command)
            case commands.Set() if command.path.split(".")[0] in ("light", "camera"):
                self.scene = changed(self.scene, command.path, command.value)
                self._scene_changed()
            case commands.ColorMode():
                pass
            case commands.Plot():
                self.plots = True
                self._tell_figures()
                return
            case _:
                raise SceneError("a recorded run cannot be changed; neve view SCENE computes one")
        self._anchor = (monotonic(), self._at)
        self._state_changed()
        self._show_frame()


def _size(frame: Frame) -> int:
    arrays = (frame.x, frame.v, frame.J_P, frame.id, frame.material)
    return sum(array.nbytes for array in arrays if array is not None)


def _same(values: Any) -> Callable[[], Any]:
    return lambda: values
