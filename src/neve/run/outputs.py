"""What a run leaves behind, as objects on schedules: frames, log, checkpoint, film and picture."""

from __future__ import annotations

import functools
import logging
from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

from neve.diagnostics import Balance
from neve.io.checkpoint import write_checkpoint
from neve.io.frames import Frame, make_frame, write_frame
from neve.io.log import STAGES, Log
from neve.schedule import EveryFrame, EverySeconds, Schedule

if TYPE_CHECKING:
    from neve.diagnostics import Diagnostics
    from neve.io.run_folder import RunFolder
    from neve.simulation import Simulation
    from neve.stage_timer import StageTimer


class FrameContext:
    """The end of a frame, as the outputs see it; they read and never change it."""

    def __init__(self, sim: Simulation, frame: int, last: int, timer: StageTimer) -> None:
        self.sim = sim
        self.frame = frame
        self.last = last
        self.timer = timer

    @property
    def finished(self) -> bool:
        """Tell whether this is the last frame of the run."""
        return self.frame == self.last

    @functools.cached_property
    def content(self) -> Frame:
        """The particles and bodies of this frame as a frame file holds them."""
        state = self.sim.state
        bodies = [(pose.position, pose.rotation) for _, pose in self.sim.bodies()]
        return make_frame(state.x, state.v, state.J_P, state.id, state.material, bodies, self.sim.time)


class Output(Protocol):
    """Write something about a run: a schedule, and what to do when it is due."""

    schedule: Schedule

    def write(self, context: FrameContext) -> None:
        """Write what belongs to this frame; called when the schedule says so."""
        ...

    def close(self, context: FrameContext) -> None:
        """Round off after the last frame, or after the frame in which the user stopped the run."""
        ...


class FrameOutput:
    """Write `frames/NNNNNN.npz`."""

    def __init__(self, folder: RunFolder) -> None:
        self.schedule: Schedule = EveryFrame()
        self._folder = folder

    def write(self, context: FrameContext) -> None:
        """Write the frame."""
        with context.timer.stage("write"):
            write_frame(self._folder.frames, context.frame, context.content)

    def close(self, context: FrameContext) -> None:
        """Do nothing: each frame is complete."""


class EnergyWatch:
    """Notice when snow gains energy from nowhere: more than colliders and gravity gave it."""

    SHARE = 0.01
    """Growth from frame to frame, as a share of the kinetic and elastic energy, from which on it is told."""

    def __init__(self, last_row: Mapping[str, str] | None) -> None:
        """Start at the beginning of a run, or after the last row of the log of one that goes on."""
        self._before = None if last_row is None else Balance.of_row(last_row)
        self._told = False

    def excess(self, now: Diagnostics, frame: int) -> float | None:
        """Return how much energy [J] nothing accounts for since the last call; log it the first time."""
        before, self._before = self._before, Balance.of(now)
        if before is None:
            return None
        excess = self._before.growth(before)
        lively = max(before.lively, self._before.lively)
        if excess > self.SHARE * lively and not self._told:
            self._told = True
            logging.getLogger("neve").warning(
                "in frame %d the energy of the snow grew by %.2g J (%.2g %% of what moves) without work: "
                "lower numerics.cfl or numerics.strain_max, or check xi, theta_c and theta_s",
                frame,
                excess,
                100.0 * excess / lively,
            )
        return excess


class LogOutput:
    """Write a row of `log.csv`.

    The time of a checkpoint, which is written after the row, counts in the next row.
    """

    def __init__(self, folder: RunFolder, done: int | None) -> None:
        """Start the log, or go on after the row of frame `done`."""
        self.schedule: Schedule = EveryFrame()
        self._log = Log(folder.log, keep_through=done)
        self._watch = EnergyWatch(self._log.last)

    def write(self, context: FrameContext) -> None:
        """Add the row of this frame."""
        sim, stats, totals = context.sim, context.sim.stats, context.sim.diagnostics()
        moved = context.frame > 0  # the initial state took no step
        seconds = {**(stats.stage_seconds if moved else {}), **context.timer.take()}
        x, y, z = (float(component) for component in totals.momentum)
        u, v, w = (float(component) for component in totals.bodies_momentum)
        excess = self._watch.excess(totals, context.frame)
        self._log.append(
            {
                "frame": context.frame,
                "time": float(sim.time),
                "steps": int(sim.steps),
                "dt_min": float(stats.dt_min) if moved else None,
                "dt_mean": float(stats.dt_mean) if moved else None,
                "bound": stats.bound if moved else None,
                "refusals": int(stats.refusals) if moved else None,
                "mass": float(totals.mass),
                "momentum_x": x,
                "momentum_y": y,
                "momentum_z": z,
                "kinetic": float(totals.kinetic),
                "elastic": float(totals.elastic),
                "potential": float(totals.potential),
                "affine": float(totals.affine),
                "work": float(totals.work),
                "bodies_momentum_x": u,
                "bodies_momentum_y": v,
                "bodies_momentum_z": w,
                "bodies_kinetic": float(totals.bodies_kinetic),
                "bodies_potential": float(totals.bodies_potential),
                "excess": excess,
                "particles": int(totals.particles),
                "blocks": int(totals.blocks),
                **{f"seconds_{stage}": round(seconds.get(stage, 0.0), 6) for stage in STAGES},
            }
        )

    def close(self, context: FrameContext) -> None:
        """Do nothing: each row is complete."""


class CheckpointOutput:
    """Write `checkpoint` every few seconds of wall time and at the end, after all else of its frame."""

    def __init__(self, folder: RunFolder, scene: str, neve: str, done: int | None) -> None:
        self.schedule: Schedule = EverySeconds(3.0)
        self._folder = folder
        self._scene = scene
        self._neve = neve
        self._written = done

    def write(self, context: FrameContext) -> None:
        """Write the state as of this frame."""
        with context.timer.stage("write"):
            write_checkpoint(
                self._folder.checkpoint, context.frame, self._scene, self._neve, context.sim.arrays()
            )
        self._written = context.frame

    def close(self, context: FrameContext) -> None:
        """Write the state unless it is there already."""
        if self._written != context.frame:
            self.write(context)
