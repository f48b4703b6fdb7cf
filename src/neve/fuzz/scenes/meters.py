"""Read what the energy of a run is, step by step, by the method that moves its snow."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from neve.diagnostics import Balance
from neve.fuzz.scenes.energy import Moment
from neve.simulation import Simulation

if TYPE_CHECKING:
    from neve.mpm.solver import MpmSolver
    from neve.particles.solver import ParticleSolver
    from neve.sph.solver import SphSolver

Columns = dict[str, NDArray[Any]]


class Meter(ABC):
    """Read the moments of a run; `step` is to be called after each step of `sim`.

    Attributes:
        exchanged: what snow and each solid exchanged since the start, (n, 7), which `sim` does not know
    """

    columns: ClassVar[tuple[str, ...]] = ("x", "m", "v")
    """What is read of the state."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self.exchanged = np.zeros((len(sim.solver.solids), 7))
        self._eps = float(np.finfo(sim.state.x.dtype).eps)
        self._put_in = self._noise = self._released = 0.0
        self._steps = 0
        self._before = self._seen()

    def _seen(self) -> tuple[Balance, Columns]:
        """Return sums and velocities now, rows in the order of birth."""
        solver = self._sim.solver
        order = np.argsort(solver.state.id)
        columns = {name: np.asarray(getattr(solver.state, name))[order] for name in self.columns}
        return Balance.of(solver.diagnostics(self._sim.exchanged + self.exchanged)), columns

    def step(self) -> Moment:
        """Return what the last step says about the state before it."""
        self._steps += 1
        self.exchanged += self._sim.solver.take_exchanged()  # with bodies, Simulation has taken it
        (before, old), (after, new) = self._before, self._seen()
        self._released += self._release(old, new)
        after = after._replace(emitted_energy=after.emitted_energy + self._released)
        self._before = after, new
        g, x = np.abs(self._sim.scene.world.gravity), np.abs(new["x"].astype(np.float64))
        scale = float(np.sum(new["m"] * (x @ g)))
        self._put_in = max(self._put_in, before.kinetic_and_elastic, abs(after.work))
        self._noise += self._energy_of_rounding(new)
        rounding = self._eps * self._steps * (scale + self._put_in) + self._noise
        return Moment(self._shared(old, new), before, after, rounding)

    @abstractmethod
    def _shared(self, old: Columns, new: Columns) -> float:
        """Return half the inner product of two velocities by the kinetic energy [J]."""

    def _release(self, old: Columns, new: Columns) -> float:
        """Return the energy that the law of the snow is known to have made in the step, or taken [J]."""
        return 0.0

    @abstractmethod
    def _energy_of_rounding(self, now: Columns) -> float:
        """Return at most how much the rounding of a step adds to the elastic energy on average [J]."""


class MpmMeter(Meter):
    """Read the moments of the material point method."""

    columns = ("x", "m", "v", "C", "modes")

    def __init__(self, sim: Simulation) -> None:
        self._solver: MpmSolver = sim.solver  # type: ignore[assignment]
        state = self._solver.state
        self._pair = self._solver.model.particles(int(state.count))
        self._pair.F_E[:] = np.eye(3)
        self._mass = float(np.sum(state.m, dtype=np.float64))
        super().__init__(sim)
        self._noise = self._lift_out_of_solids()

    def _lift_out_of_solids(self) -> float:
        """Return at most how much gravity does on snow that is pushed out of solids that it starts in [J].

        The push is a displacement without a velocity, so no work of the solid tells of it.
        """
        model, state = self._solver.model, self._solver.state
        x, m = state.x.astype(np.float64), state.m.astype(np.float64)
        depth = [m @ np.maximum(-model.distance(i, x), 0.0) for i in range(len(self._solver.solids))]
        return float(np.linalg.norm(self._sim.scene.world.gravity) * sum(depth))

    def _energy_of_rounding(self, now: Columns) -> float:
        """Return at most how much a step's rounding of F_E adds to the elastic energy on average [J].

        Three diagonal entries near 1 are rounded by eps / 2 at most, each way alike, so that on average the
        squares add up: 3/2 (eps / 2)^2 sum V0 (lam + 2 mu), at most 3/8 eps^2 m c^2 with the fastest wave c.
        """
        return 0.375 * self._eps**2 * self._mass * self._solver.report.wave**2

    def _shared(self, old: Columns, new: Columns) -> float:
        return 0.25 * (self._kinetic(old, new, 1.0) - self._kinetic(old, new, -1.0))

    def _kinetic(self, old: Columns, new: Columns, sign: float) -> float:
        """Return the kinetic energy of the velocities `new` + `sign` `old`, of all modes [J]."""
        pair = self._pair
        pair.x[:], pair.m[:] = new["x"], new["m"]
        for name in ("v", "C", "modes"):
            getattr(pair, name)[:] = new[name] + sign * old[name]
        totals = self._solver.model.core.totals(self._solver.model.native, pair)
        return float(totals.kinetic + totals.affine)


class ParticleMeter(Meter):
    """Read the moments of particles in contact."""

    columns = ("x", "m", "v", "radius", "id")

    def _shared(self, old: Columns, new: Columns) -> float:
        v = old["v"].copy()  # of what has gone since
        at = np.searchsorted(new["id"], old["id"])
        there = at < len(new["id"])
        there[there] = new["id"][at[there]] == old["id"][there]
        v[there] = new["v"][at[there]]
        return 0.5 * float(np.sum(old["m"].astype(np.float64)[:, None] * old["v"] * v))

    def _energy_of_rounding(self, now: Columns) -> float:
        """Return at most how much a step's rounding of places adds to the elastic energy on average [J].

        Positions are rounded by eps / 2 of their components, overlaps by as much of the distance: for a
        particle 1/2 k (eps / 2)^2 (|x| + 2 r)^2, with k the sum of its contacts' stiffness, at most that of
        the particle whose contacts are stiffest for its mass.
        """
        solver: ParticleSolver = self._sim.solver  # type: ignore[assignment]
        x = now["x"].astype(np.float64)
        way = np.sqrt(np.sum(x * x, axis=1)) + 2.0 * now["radius"]
        return 0.125 * self._eps**2 * solver.stiffest * float(np.sum(now["m"] * way * way))


class SphMeter(Meter):
    """Read the moments of smoothed particles, whose implicit steps have no swing: 1/2 <v_n, v_n>."""

    columns = ("x", "m", "v", "p", "rho", "J_P")

    def _release(self, old: Columns, new: Columns) -> float:
        """Return the work of the pressure in plastic changes of volume, p V dJ_P / J_P.

        At the same F_E no elastic energy pays for it, nor takes it: pressed snow that yields sideways pushes,
        as J_P grows, and stretched snow pulls, as it falls. The other way round the work is lost.
        """
        grown = np.log(new["J_P"].astype(np.float64) / old["J_P"])
        return float(np.sum(new["p"] * (new["m"] / new["rho"]) * grown))

    def _shared(self, old: Columns, new: Columns) -> float:
        v = old["v"].astype(np.float64)
        return 0.5 * float(np.sum(old["m"].astype(np.float64)[:, None] * v * v))

    def _energy_of_rounding(self, now: Columns) -> float:
        """Return at most how much a step's rounding of F_E adds to the elastic energy on average [J].

        As of `MpmMeter`, with the modulus of each particle.
        """
        solver: SphSolver = self._sim.solver  # type: ignore[assignment]
        state = solver.state
        modulus = np.asarray(state.lam, dtype=np.float64) + 2.0 * np.asarray(state.G)
        return 0.375 * self._eps**2 * float(np.sum(np.asarray(state.m) / np.asarray(state.rho0) * modulus))
