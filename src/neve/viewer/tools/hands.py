"""What pages do with the pointer and keys to a run that goes on: push, grab, drag, pull, hold controls."""

from __future__ import annotations

import math
from time import monotonic

import numpy as np

from neve.rigid.coupled_bodies import CoupledBodies
from neve.rigid.hand import Spring
from neve.scene.errors import SceneError
from neve.simulation import Simulation
from neve.viewer.protocol.commands import Drive, Move, Pull, Touch
from neve.viewer.protocol.messages import RobotControl
from neve.viewer.tools.drag import DragController
from neve.viewer.tools.velocity import VelocityTool

GONE = 1.0
"""Seconds after which a pull that no page renews ends."""


class Hands:
    """Hold what pages do at the moment."""

    def __init__(self) -> None:
        self._velocity_tool, self._drags = VelocityTool(), DragController()
        self._pulled: dict[str, float] = {}  # clock of the last command of each pull

    def take(self, command: Touch | Move | Pull | Drive, sim: Simulation) -> None:
        """Take what a page asks for. Errors: SceneError for what there is not to pull or to control."""
        match command:
            case Touch():
                self._velocity_tool.take(command)
            case Move():
                self._drags.take(command)
            case Pull():
                self._pull(command, sim)
            case Drive():
                drive(command, sim)

    def act(self, sim: Simulation, dt: float) -> None:
        """Change velocities and motions for a piece of `dt` [s]."""
        for name, since in list(self._pulled.items()):
            if monotonic() - since > GONE:
                self._let_go(name, sim)
        self._drags.act(sim, dt)
        self._velocity_tool.act(sim, dt)

    def drop(self) -> None:
        """Drop the solids that are dragged."""
        self._drags = DragController()

    def _pull(self, command: Pull, sim: Simulation) -> None:
        rigid = bodies_of(sim)
        if command.name not in {solid.name for solid in rigid.solids}:
            raise SceneError(f"{command.name} is no body, and only bodies can be pulled")
        if command.done:
            self._let_go(command.name, sim)
            return
        rigid.hand.springs[command.name] = Spring(np.array(command.grip), np.array(command.target))
        self._pulled[command.name] = monotonic()

    def _let_go(self, name: str, sim: Simulation) -> None:
        self._pulled.pop(name, None)
        bodies_of(sim).hand.springs.pop(name, None)


def bodies_of(sim: Simulation) -> CoupledBodies:
    """Return the bodies of a run. Errors: SceneError if it has none."""
    rigid = None if sim.solver.placed is None else sim.solver.placed.rigid
    if rigid is None:
        raise SceneError("this scene has no bodies or robots")
    return rigid


def drive(command: Drive, sim: Simulation) -> None:
    """Hold a control at a value within its range, or give it back to the scene. Errors: SceneError."""
    rigid = bodies_of(sim)
    ranges = {name: (low, high) for name, low, high, _ in rigid.controls()}
    if command.name not in ranges:
        raise SceneError(f"{command.name} is no control; there are {', '.join(ranges) or 'none'}")
    if command.value is None:
        rigid.hand.controls.pop(command.name, None)
    else:
        low, high = ranges[command.name]
        rigid.hand.controls[command.name] = min(high, max(low, command.value))


def controls_of(sim: Simulation) -> list[RobotControl]:
    """Return the controls of motors and robots."""
    try:
        found = bodies_of(sim).controls()
    except SceneError:
        return []
    return [
        {"name": name, "low": low, "high": high, "value": value if math.isfinite(value) else 0.0}
        for name, low, high, value in found
    ]
