"""The log of a run: `log.csv`, and the watch over the energy of the snow."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

from neve.diagnostics import Balance, row_of
from neve.io.log import FLOW, HEAT, IMPLICIT, columns, stages
from neve.registry import METHODS
from neve.run.outputs.context import FrameContext, RunContext
from neve.run.outputs.registry import register_output
from neve.scene.schema.outputs import Need, Scheduled, Sizes
from neve.scene.values.fields import entry
from neve.schedule import Schedule

if TYPE_CHECKING:
    from neve.diagnostics import Diagnostics


ROW_BYTES = 350
"""Of a row; measured."""


class LogOptions(Scheduled):
    """Hold an entry with kind = "log"."""

    kind: Literal["log"] = entry(
        "log", "Sums over all snow and what the steps were like, a row each in log.csv.", ""
    )

    def file(self) -> str:
        """Return the name of the file."""
        return "log.csv"

    def need(self, sizes: Sizes, due: int) -> Need:
        """Return about the bytes of the table."""
        return Need((due + 1) * ROW_BYTES)


class EnergyWatch:
    """Detect that snow gains more energy than colliders and gravity gave it."""

    SHARE = 0.01
    """Growth from row to row that is reported, as a share of the kinetic and elastic energy."""

    def __init__(self, last_row: Mapping[str, str] | None, advice: str) -> None:
        """Start at the beginning of a run, or after the last row of the log of a resumed run.

        advice: what to do about such growth, the end of the sentence
        """
        self._advice = advice
        self._before = None if last_row is None else Balance.of_row(last_row)
        self._reported = False

    def excess(self, now: Diagnostics, frame: int) -> float | None:
        """Return how much energy [J] nothing accounts for since the last call; log it the first time."""
        before, self._before = self._before, Balance.of(now)
        if before is None:
            return None
        excess = self._before.growth(before)
        moving = max(before.kinetic_and_elastic, self._before.kinetic_and_elastic)
        if excess > self.SHARE * moving and not self._reported:
            self._reported = True
            logging.getLogger("neve").warning(
                "in frame %d the energy of the snow grew by %.2g J (%.2g %% of what moves) without work: %s",
                frame,
                excess,
                100.0 * excess / moving,
                self._advice,
            )
        return excess


@register_output("log", LogOptions, unasked=lambda scene: True)
class LogOutput:
    """Write a row of `log.csv`.

    The time of a checkpoint, which is written after the row, counts in the next row.
    """

    def begin(self, run: RunContext, schedule: Schedule) -> None:
        """Start the log, or continue it after the row of frame `done`."""
        method = run.scene.numerics.method
        self._stages = stages(method)
        open_, heated = run.scene.is_open, run.scene.heat is not None
        implicit = run.scene.numerics.is_implicit
        self._more = (*(FLOW if open_ else ()), *(HEAT if heated else ()), *(IMPLICIT if implicit else ()))
        names = columns(method, open_, heated, implicit)
        self._log = run.table(run.folder.log.name, names, run.frames_done(schedule))
        watched = "excess" in self._log.columns and not run.scene.is_keyed
        self._watch = EnergyWatch(self._log.last, METHODS.get(method).when_energy_grows) if watched else None

    def write(self, context: FrameContext) -> None:
        """Add the row of this frame."""
        sim, stats, totals = context.sim, context.sim.stats, context.sim.diagnostics()
        moved = context.frame > 0  # the initial state took no step
        seconds = {**(stats.stage_seconds if moved else {}), **context.timer.take()}
        values: dict[str, float | None] = {**sim.solver.log_values(totals), **row_of(totals, self._more)}
        if "excess" in self._log.columns:
            values["excess"] = None
        if self._watch:
            values["excess"] = self._watch.excess(totals, context.frame)
        self._log.append(
            {
                "frame": context.frame,
                "time": float(sim.time),
                "steps": int(sim.steps),
                "dt_min": float(stats.dt_min) if moved else None,
                "dt_mean": float(stats.dt_mean) if moved else None,
                "bound": stats.bound if moved else None,
                "rejected": int(stats.rejected) if moved else None,
                **values,
                **{f"seconds_{stage}": round(seconds.get(stage, 0.0), 6) for stage in self._stages},
            }
        )

    def close(self, context: FrameContext) -> None:
        """Do nothing: each row is complete."""
