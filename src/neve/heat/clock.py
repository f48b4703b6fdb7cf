"""When heat flows, and what the core needs of a scene's heat."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.scene.schema.scene import Scene
from neve.solver import Blowup

if TYPE_CHECKING:
    from neve._core import HeatModel, HeatReport

INTERVAL = 0.01
"""Time between two passes over the heat, of motion [s]."""
CLOCK = "heat_clock"
"""Name of what `HeatClock.save` returns in a checkpoint."""

R = TypeVar("R", bound="HeatReport")


def heat_model(scene: Scene) -> HeatModel | None:
    """Return the heat of `scene` for the core, None if it has none."""
    heat = scene.heat
    if heat is None:
        return None
    return _core.HeatModel(
        air=heat.air_temperature,
        exchange=heat.air_exchange,
        sun=heat.sun * (1.0 - heat.albedo),
        towards=scene.light.towards_sun,
        conductivity=0.0 if heat.conductivity == "density" else float(heat.conductivity),
        speed=heat.heat_speed,
        sinters=heat.sintering,
    )


class HeatClock:
    """Let heat flow every INTERVAL, and keep the books.

    Attributes:
        taken: heat from air and sun so far [J]
    """

    def __init__(self, saved: Mapping[str, NDArray[Any]] | None = None) -> None:
        """Start at zero, or go on from what `save` returned."""
        self._due, self.taken = map(float, saved[CLOCK]) if saved is not None else (0.0, 0.0)

    def save(self) -> dict[str, NDArray[Any]]:
        """Return what an exact resume needs."""
        return {CLOCK: np.array([self._due, self.taken])}

    def advance(self, flow: Callable[[float], R], dt: float, steps: int, time: float) -> R | None:
        """Let heat flow once it is due, `dt` [s] of motion after the last call.

        flow: lets heat flow for so long [s]. steps, time: where the run stands. Returns the report of the
        flow, None if it was not due. Errors: Blowup for heat that is not finite, or that no number
        of rounds lets flow.
        """
        self._due += dt
        if self._due < INTERVAL * (1.0 - 1e-9):
            return None
        report = flow(self._due)
        if report.endless:
            raise Blowup(
                f"heat asks for {report.rounds:,} rounds in {self._due:.3g} s of motion after step {steps} "
                f"(t = {time:.6g} s): lower heat.heat_speed, heat.conductivity or heat.air_exchange"
            )
        self._due = 0.0
        self.taken += report.taken
        if not report.finite:
            raise Blowup(f"a particle has no finite heat after step {steps} (t = {time:.6g} s): check [heat]")
        return report
