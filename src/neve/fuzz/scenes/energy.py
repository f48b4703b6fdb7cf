"""The energy of a run, step by step, without the swing of explicit steps, and what nothing accounts for.

An explicit step moves velocities first and positions with the new ones (symplectic Euler). Of a stable linear
vibration of angular frequency w it keeps, to rounding, not the energy of a state but the shadow energy

    H_n = 1/2 <v_n, v_n+1> + V(x_n)

with the inner product of the kinetic energy and V the elastic and potential energy; the sum of kinetic energy
and V swings between H / (1 + a) and H / (1 - a), a = w dt / 2. Transfers, plastic flow and contact make H
less. So a rise of H is energy from nowhere, be the swing small or large. A blow that changes velocities
within one step is no vibration: there H falls too far and comes back while the plain sum does not rise, so
what counts is the smaller of both rises. Neither would see the linear instability of a step with w dt > 2, in
which H is kept while both its terms grow; so the plain sum alone is judged too, by a wide margin.

Source: Hairer, Lubich and Wanner, Geometric numerical integration, 2nd ed. 2006, IX.3 (modified energy of the
symplectic Euler method) [M].
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.diagnostics import Balance
from neve.simulation import Simulation

if TYPE_CHECKING:
    from neve.mpm.solver import MpmSolver

MOST_GAIN = 0.05
"""Rise of the shadow energy that is allowed, as a share of all that was put in since the start."""

MOST_SURGE = 0.25
"""Rise that is allowed as a share of what moved and was strained at most since the lowest H before it."""

LEAST_SURGE, LEAST_AFLIP_SURGE = 1e-3, 1e-2
"""A rise below this share of all that was put in is no surge: snow at rest is no measure.

Explicit steps of motions that are not small make energy of the order of dt, both ways; `aflip`, which damps
least, shows it: in a press 0.6 % of what was put in in 540 steps, and 0.2 % in steps a fifth as long.
"""

MOST_SWING = 0.5
"""Kinetic and elastic energy beyond all that was put in, as a share of it."""


class Moment(NamedTuple):
    """What a step says about the energy of the state before it.

    shared: 1/2 <v_n, v_n+1> [J]; before, after: sums of both states; rounding: bound on what rounding may
    have added since the start, that of strains included, and that of solids in which snow starts by
    rounding [J].
    """

    shared: float
    before: Balance
    after: Balance
    rounding: float


class Budget:
    """The energy that was put into the snow of a run, and the largest rises that nothing accounts for.

    Put in are the energy at the start, the work of colliders, and what the snow fell. gain: largest rise of
    both the shadow energy and the plain sum, each from its lowest before, over all that was put in until then
    [1]; surge: largest rise over the largest sum of kinetic and elastic energy since then [1]; swing: largest
    sum of kinetic and elastic energy over all that was put in, less 1 [1].
    """

    def __init__(self, transfer: str = "apic") -> None:
        self.gain = self.surge = self.swing = 0.0
        self._least_surge = LEAST_AFLIP_SURGE if transfer == "aflip" else LEAST_SURGE
        self._start: Balance | None = None
        self._put_in = 0.0
        self._lowest = self._lowest_sum = self._alive = 0.0

    def record(self, moment: Moment) -> None:
        """Take in one step."""
        before, after = moment.before, moment.after
        shadow = moment.shared + before.elastic + before.potential - 0.5 * (before.work + after.work)
        plain = before.kinetic_and_elastic + before.potential - before.work
        if self._start is None:
            self._start, self._lowest, self._lowest_sum = before, shadow, plain
        start = self._start
        for now in (before, after):
            put_in = (
                start.kinetic_and_elastic + max(now.work, 0.0) + max(start.potential - now.potential, 0.0)
            )
            self._put_in = max(self._put_in, put_in)
        self._alive = max(self._alive, before.kinetic_and_elastic)
        if shadow < self._lowest:
            self._lowest, self._alive = shadow, before.kinetic_and_elastic
        self._lowest_sum = min(self._lowest_sum, plain)
        rise = max(min(shadow - self._lowest, plain - self._lowest_sum) - moment.rounding, 0.0)
        self.gain = max(self.gain, rise / max(self._put_in, 1e-300))
        if rise > self._least_surge * self._put_in:
            self.surge = max(self.surge, rise / max(self._alive, 1e-300))
        over = before.kinetic_and_elastic - moment.rounding - self._put_in
        self.swing = max(self.swing, over / max(self._put_in, 1e-300))

    def fault(self) -> str:
        """Return what is wrong with the energy, "" if nothing is."""
        if self.gain > MOST_GAIN:
            return f"energy grew by {100 * self.gain:.3g} % of what was put in"
        if self.surge > MOST_SURGE:
            return f"energy surged by {100 * self.surge:.3g} % of what moved and was strained"
        if self.swing > MOST_SWING:
            return f"energy swung to {100 * self.swing:.3g} % more than was put in"
        return ""


class Meter:
    """Read the moments of a run; `step` is to be called after each step of `sim`."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._solver: MpmSolver = sim.solver  # type: ignore[assignment]
        self._exchanged = np.zeros((len(self._solver.solids), 7))
        state = self._solver.state
        self._pair = self._solver.model.core.State(int(state.count), state.modes.shape[1])
        self._pair.F_E[:] = np.eye(3)
        self._eps = float(np.finfo(state.x.dtype).eps)
        self._mass = float(np.sum(state.m, dtype=np.float64))
        self._put_in = self._strained = 0.0
        self._steps = 0
        self._pushed_out = self._lift_out_of_solids()
        self._before = self._seen()

    def _lift_out_of_solids(self) -> float:
        """Return at most how much gravity does on snow that is pushed out of solids that it starts in [J].

        The push is a displacement without a velocity, so no work of the solid tells of it.
        """
        model, state = self._solver.model, self._solver.state
        x, m = state.x.astype(np.float64), state.m.astype(np.float64)
        depth = [m @ np.maximum(-model.distance(i, x), 0.0) for i in range(len(self._solver.solids))]
        return float(np.linalg.norm(self._sim.scene.world.gravity) * sum(depth))

    def _seen(self) -> tuple[Balance, dict[str, NDArray[Any]]]:
        """Return sums and velocities now, rows in the order of birth."""
        state = self._solver.state
        order = np.argsort(state.id)
        columns = {name: np.asarray(getattr(state, name))[order] for name in ("x", "m", "v", "C", "modes")}
        return Balance.of(self._solver.diagnostics(self._sim.exchanged + self._exchanged)), columns

    def step(self) -> Moment:
        """Return what the last step says about the state before it."""
        self._steps += 1
        self._exchanged += self._solver.take_exchanged()  # with bodies, Simulation has taken it
        (before, old), (after, new) = self._before, self._seen()
        self._before = after, new
        shared = 0.25 * (self._kinetic(old, new, 1.0) - self._kinetic(old, new, -1.0))
        g, x = np.abs(self._sim.scene.world.gravity), np.abs(new["x"].astype(np.float64))
        scale = float(np.sum(new["m"] * (x @ g)))
        self._put_in = max(self._put_in, before.kinetic_and_elastic, abs(after.work))
        self._strained += self._energy_of_rounded_strain()
        rounding = self._eps * self._steps * (scale + self._put_in) + self._strained + self._pushed_out
        return Moment(shared, before, after, rounding)

    def _energy_of_rounded_strain(self) -> float:
        """Return at most how much a step's rounding of F_E adds to the elastic energy on average [J].

        Three diagonal entries near 1 are rounded by eps / 2 at most, each way alike, so that on average the
        squares add up: 3/2 (eps / 2)^2 sum V0 (lam + 2 mu), at most 3/8 eps^2 m c^2 with the fastest wave c.
        """
        return 0.375 * self._eps**2 * self._mass * self._solver.report.wave**2

    def _kinetic(self, old: dict[str, NDArray[Any]], new: dict[str, NDArray[Any]], sign: float) -> float:
        """Return the kinetic energy of the velocities `new` + `sign` `old`, of all modes [J]."""
        pair = self._pair
        pair.x[:], pair.m[:] = new["x"], new["m"]
        for name in ("v", "C", "modes"):
            getattr(pair, name)[:] = new[name] + sign * old[name]
        totals = self._solver.model.core.totals(self._solver.model.native, pair)
        return float(totals.kinetic + totals.affine)
