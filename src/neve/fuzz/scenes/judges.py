"""What must hold for a random scene beyond finite numbers and mass, by the method that moves its snow."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from neve.fuzz.scenes.energy import Budget
from neve.fuzz.scenes.meters import Meter, MpmMeter, ParticleMeter, SphMeter
from neve.mpm.state_checks import inspect
from neve.scene.schema.scene import Scene
from neve.scene.values.choices import TRANSFERS
from neve.simulation import Simulation
from neve.sph.constants import law_constants

if TYPE_CHECKING:
    from neve.mpm.solver import MpmSolver
    from neve.particles.solver import ParticleDiagnostics, ParticleSolver
    from neve.sph.solver import SphSolver

LARGE_STRAIN = 0.1
"""Strain from which on the stress of smoothed particles is that of no energy [1]."""

MOST_DEPTH = 0.5
"""How deep a smoothed particle may be in a solid, in distances of particles."""


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

    def _heat_fault(self, start: Any, now: Any) -> str:
        """Return whether the heat of `now` is what that of `start`, air and sun make it; "" if it is."""
        if self.sim.scene.heat is None or self.sim.scene.is_open:  # heat that snow brings is not booked
            return ""
        heat = float(np.abs(np.asarray(self.sim.state.enthalpy)).sum()) + abs(now.heat_taken)
        lost = abs(now.heat - start.heat - now.heat_taken)
        if lost > 1e-9 * heat:
            return f"heat of {lost:.3g} J came from nowhere, {lost / heat:.2g} of all"
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


def told_heat(scene: Scene) -> tuple[str, ...]:
    """Return a word that says how fast heat goes, none without heat."""
    return () if scene.heat is None else (f"heat x {scene.heat.heat_speed:.2g}",)


class MpmJudge(Judge):
    """Energy is judged as where the transfer bounds it; heat is what air and sun gave."""

    meter_of = MpmMeter

    def __init__(self, sim: Simulation) -> None:
        super().__init__(sim)
        numerics = sim.scene.numerics
        self.budget = Budget(numerics.transfer)
        self.kind = (numerics.transfer, numerics.spline, *told_heat(sim.scene))

    def begin(self) -> None:
        """Take in the state at the start."""
        super().begin()
        self._start = self.sim.solver.diagnostics(self.sim.exchanged)

    def fault(self) -> str:
        """Return what is wrong with heat, "" if nothing is."""
        return self._heat_fault(self._start, self.sim.solver.diagnostics(self.sim.exchanged))

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

    Energy is judged while snow melts and freezes too; momentum where none may fall asleep.
    """

    meter_of: ClassVar[type[Meter]] = ParticleMeter

    def begin(self) -> None:
        """Take in the state at the start, with all pairs that touch in it."""
        self.sim.solver.begin(0, 0.0)
        super().begin()
        sleep = ("sleep",) if self.sim.scene.numerics.sleep else ()
        comes = ("open",) if self.sim.scene.is_open else ()
        self.kind = ("particles", *comes, *sleep, *told_heat(self.sim.scene))
        self._start = self._now()
        self._most_moved = 0.0
        self._time, self._mass, self._pulled = self.sim.time, self._start.mass, 0.0
        self._saved: dict[str, np.ndarray] = {}
        self._left: list[int] = []

    def record(self) -> None:
        """Take in a step, and for how long gravity has pulled at which mass [kg s]."""
        super().record()
        self._pulled += self._mass * (self.sim.time - self._time)
        self._time = self.sim.time
        self._mass = float(np.sum(self.sim.state.m, dtype=np.float64))

    def _now(self) -> ParticleDiagnostics:
        solver: ParticleSolver = self.sim.solver  # type: ignore[assignment]
        return solver.diagnostics(self.sim.exchanged + self._meter.exchanged)

    def fault(self) -> str:
        """Return what is wrong with momentum and heat, "" if nothing is."""
        now, start, eps = self._now(), self._start, float(np.finfo(self.sim.state.x.dtype).eps)
        moved = now.kinetic + now.elastic + abs(now.work)
        self._most_moved = max(self._most_moved, float(np.sqrt(2.0 * now.mass * moved)))
        given = -(self.sim.exchanged + self._meter.exchanged)[:, :3].sum(axis=0)
        fall = self._pulled * np.array(self.sim.scene.world.gravity)
        came, went = np.array(now.emitted_momentum), np.array(now.removed_momentum)
        missing = float(np.abs(np.array(now.momentum) - start.momentum - given - fall - (came - went)).max())
        scale = self._most_moved + float(
            np.abs(start.momentum).max() + np.abs(fall).max() + np.abs(came).max() + np.abs(went).max()
        )
        if not self.sim.scene.numerics.sleep and missing > 8.0 * eps * (self._roundings() + 8) * scale:
            return f"momentum of {missing:.3g} N s came from nowhere, {missing / scale:.2g} of what moved"
        return self._heat_fault(start, now)

    def _roundings(self) -> float:
        """Return how often the velocity of each particle was added to."""
        return self.sim.steps

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


class SphJudge(ParticleJudge):
    """Besides, no particle is deeper in a solid than half a distance of particles.

    Energy is judged where snow flows before it is strained by more than LARGE_STRAIN: the stress, linear in
    F, is that of an energy only as long as strains are small. It is not where there is water, which is pushed
    apart where it lies in what is full already.
    """

    meter_of = SphMeter

    def begin(self) -> None:
        """Take in the state at the start, and how far snow can be strained."""
        self._added, self._steps = 0.0, 0
        super().begin()
        self.kind = ("sph",)
        snows = [self.sim.scene.snow_of(source) for source in self.sim.scene.sources]
        flow = [law_constants(snow) for snow in snows if snow.plasticity != "none"]
        most = max((max(c["theta_c"], c["theta_s"]) for c in flow), default=0.0)
        wet = any(source.is_water for source in self.sim.scene.sources)
        self._is_judged = len(flow) == len(snows) and most <= LARGE_STRAIN and not wet

    def _roundings(self) -> float:
        """Return how often the velocity of each particle was added to: in each iteration of both solves."""
        solver: SphSolver = self.sim.solver  # type: ignore[assignment]
        solves = solver.diagnostics(self.sim.exchanged).solves  # means of this part
        iterations = solves.pressure_iterations + solves.shear_iterations
        return self._added + (self.sim.steps - self._steps) * (1.0 + iterations)

    def after(self, part: int, parts: int) -> None:
        """Keep the state in the middle, and count what was added to velocities in this part."""
        self._added, self._steps = self._roundings(), self.sim.steps
        super().after(part, parts)

    @property
    def is_judged(self) -> bool:
        """Whether critical strains are small, and all is snow."""
        return self._is_judged

    def fault(self) -> str:
        """Return what is wrong with momentum and solids, "" if nothing is."""
        solver: SphSolver = self.sim.solver  # type: ignore[assignment]
        solver.placed.place_solids(self.sim.time)
        spacing = self.sim.scene.numerics.spacing
        x = np.array(self.sim.state.x, dtype=np.float64)
        phi = np.array([solver.placed.distance(i, x) for i in range(len(solver.solids))])
        first = len(self.sim.scene.colliders)  # solid that can move into others
        for i in range(len(phi)):
            others = np.delete(phi, i, axis=0) if i >= first else phi[first:]
            depth = float(np.max(depths(phi[i], others), initial=0.0))
            if depth > MOST_DEPTH * spacing:
                return f"a particle is {depth / spacing:.2g} distances of particles deep in solid {i}"
        return super().fault()


def depths(phi: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how deep particles are in a solid, as far as not because others overlap with it (n,) [m].

    Apart, solids are as far from a particle inside another as it is deep in that, or farther: what is nearer
    is pressed from one into the other, as snow below a body that sinks into the ground is.

    phi: signed distances from the solid, (n,) [m]; others: from the others, (solids, n) [m].
    """
    nearest = np.min(others, axis=0, initial=np.inf)
    found: NDArray[np.float64] = np.minimum(-phi, np.maximum(nearest, 0.0))
    return found


JUDGES: dict[str, type[Judge]] = {"mpm": MpmJudge, "particles": ParticleJudge, "sph": SphJudge}
"""By numerics.method."""
