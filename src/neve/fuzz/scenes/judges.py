"""What must hold for a random scene beyond finite numbers and mass, by the method that moves its snow."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from neve.fuzz.scenes.energy import Budget
from neve.fuzz.scenes.meters import Meter, MpmMeter, ParticleMeter
from neve.mpm.state_checks import inspect
from neve.scene.values.choices import TRANSFERS
from neve.simulation import Simulation

if TYPE_CHECKING:
    from neve.mpm.solver import MpmSolver
    from neve.particles.solver import ParticleDiagnostics, ParticleSolver


class Judge:
    """Watch a simulation; `begin` is called once before its first step and `record` after each.

    Attributes:
        budget: of its energy. kind: words that say how the snow is moved
    """

    meter_of: ClassVar[type[Meter]]

    def __init__(self, sim: Simulation) -> None:
        self.sim = sim
        self.budget = Budget()
        self.kind: tuple[str, ...] = ()

    def begin(self) -> None:
        """Take in the state at the start."""
        self._meter = self.meter_of(self.sim)

    def record(self) -> None:
        """Take in a step."""
        self.budget.record(self._meter.step())

    @property
    def is_judged(self) -> bool:
        """Whether energy must not grow."""
        return True

    def energy_fault(self) -> str:
        """Return what is wrong with the energy, "" if nothing is."""
        return self.budget.fault() if self.is_judged else ""

    def fault(self) -> str:
        """Return what else is wrong, "" if nothing is."""
        return ""

    def is_ice(self) -> bool:
        """Tell whether steps are short for a reason that ends a scene early: snow pressed to ice."""
        return False

    def after(self, part: int, parts: int) -> None:
        """Note that a part of the scene, of so many, is done."""
        return

    def fault_of_end(self) -> str:
        """Return what is wrong at the end, "" if nothing is."""
        return ""


class MpmJudge(Judge):
    """Energy is judged as where the transfer bounds it."""

    meter_of = MpmMeter

    def __init__(self, sim: Simulation) -> None:
        super().__init__(sim)
        numerics = sim.scene.numerics
        self.budget = Budget(numerics.transfer)
        self.kind = (numerics.transfer, numerics.spline)

    @property
    def is_judged(self) -> bool:
        """Whether the transfer bounds the energy."""
        return TRANSFERS[self.sim.scene.numerics.transfer].has_bounded_energy

    def is_ice(self) -> bool:
        """Tell whether snow is pressed to the density of ice, and waves in it are what keeps steps short."""
        solver: MpmSolver = self.sim.solver  # type: ignore[assignment]
        return inspect(solver.model, solver.state).crowding > 1.0 and self.sim.stats.bound in (
            "wave",
            "retry",
        )


class ParticleJudge(Judge):
    """Momentum is what gravity and solids gave, heat what air and sun did; bits are those of a resumed run.

    Energy is judged until snow melts, which changes sizes and stiffness; momentum where none may fall asleep.
    """

    meter_of = ParticleMeter

    def begin(self) -> None:
        """Take in the state at the start, with all pairs that touch in it."""
        self.sim.solver.begin(0, 0.0)
        super().begin()
        heat = self.sim.scene.heat
        sleep = ("sleep",) if self.sim.scene.numerics.sleep else ()
        self.kind = ("particles", *sleep, *(() if heat is None else (f"heat x {heat.heat_speed:.2g}",)))
        self._start = self._now()
        self._most_moved = 0.0
        self._saved: dict[str, np.ndarray] = {}
        self._left: list[int] = []

    def _now(self) -> ParticleDiagnostics:
        solver: ParticleSolver = self.sim.solver  # type: ignore[assignment]
        return solver.diagnostics(self.sim.exchanged + self._meter.exchanged)

    @property
    def is_judged(self) -> bool:
        """Whether all snow is frozen still."""
        return not np.any(self.sim.state.liquid)

    def fault(self) -> str:
        """Return what is wrong with momentum and heat, "" if nothing is."""
        now, start, eps = self._now(), self._start, float(np.finfo(self.sim.state.x.dtype).eps)
        moved = now.kinetic + now.elastic + abs(now.work)
        self._most_moved = max(self._most_moved, float(np.sqrt(2.0 * now.mass * moved)))
        given = -(self.sim.exchanged + self._meter.exchanged)[:, :3].sum(axis=0)
        fall = now.mass * self.sim.time * np.array(self.sim.scene.world.gravity)
        missing = float(np.abs(np.array(now.momentum) - start.momentum - given - fall).max())
        scale = self._most_moved + float(np.abs(start.momentum).max() + np.abs(fall).max())
        if not self.sim.scene.numerics.sleep and missing > 8.0 * eps * (self.sim.steps + 8) * scale:
            return f"momentum of {missing:.3g} N s came from nowhere, {missing / scale:.2g} of what moved"
        heat = float(np.abs(np.asarray(self.sim.state.enthalpy)).sum()) + abs(now.heat_taken)
        lost = abs(now.heat - start.heat - now.heat_taken)
        if self.sim.scene.heat is not None and lost > 1e-9 * heat:
            return f"heat of {lost:.3g} J came from nowhere, {lost / heat:.2g} of all"
        return ""

    def after(self, part: int, parts: int) -> None:
        """Keep the state in the middle."""
        if part == parts // 2:
            self._saved = self.sim.arrays()
        self._left = [*self._left, part]

    def fault_of_end(self) -> str:
        """Return whether a run from the middle on, on two threads, has other bits, "" if not."""
        parts = len(self._left)
        twin = Simulation.restore(self.sim.scene, self._saved, threads=2)
        for _ in range(parts // 2 + 1, parts):
            twin.advance(self.sim.scene.run.duration / parts)
        mine, other = self.sim.arrays(), twin.arrays()
        for name, value in mine.items():
            if name != "exchanged" and not np.array_equal(value, other[name]):  # which the meter has taken
                return f"{name} is another after a resume on two threads"
        return ""


JUDGES: dict[str, type[Judge]] = {"mpm": MpmJudge, "particles": ParticleJudge}
"""By numerics.method."""
