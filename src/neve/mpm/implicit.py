"""Implicit steps: the solver of the core with what the scene says of it, and a count of its work."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from neve.learned.shipped import weights_of

if TYPE_CHECKING:
    from neve._core import Grid, GridReport, State
    from neve.mpm.model import Model


class SolveTotals(NamedTuple):
    """Mean iterations and systems of a step, the largest residual, and the share of steps whose contacts were
    still changing when they were followed no more [1]; columns of the log.
    """

    solve_iterations: float = 0.0
    solve_rounds: float = 0.0
    solve_residual: float = 0.0
    solve_unsettled: float = 0.0


class Implicit:
    """Find the velocities of the nodes, and of bodies, at the end of a step from the forces at its end.

    "semi_implicit": (M + beta dt^2 H) v = M (v_n + dt g) + dt f_n, Stomakhin et al. 2013, section 4.1, step
    6; "implicit": backward Euler by Newton's method. The equations are in `core/cpu/implicit/solver.hpp`.
    Snow that flows has the forces of its law's return map, or of local energies learned from it
    (`neve.learned`).
    """

    def __init__(self, model: Model) -> None:
        numerics = model.numerics
        newton = numerics.integrator == "implicit"
        self._native = model.core.ImplicitSolver(
            newton=newton,
            beta=1.0 if newton else numerics.implicit_beta,
            project=newton or numerics.implicit_system == "projected",
            tolerance=numerics.implicit_tolerance,
            most_iterations=numerics.implicit_iterations,
            midpoint=numerics.implicit_rule == "midpoint",
        )
        if newton and numerics.implicit_plasticity == "learned":
            for law in {snow.law for snow in model.snows}:
                self._native.learn(law, weights_of(law))
        self.begin()

    def begin(self) -> None:
        """Count anew."""
        self._steps = self._iterations = self._rounds = self._unsettled = 0
        self._residual = 0.0

    def solve(self, model: Model, state: State, grid: Grid, dt: float) -> GridReport:
        """Turn momenta, to which no force has been added, into velocities after dt [s].

        By the midpoint rule they are those after dt / 2, with which the particles move, and `finish` follows.
        """
        report = self._native.solve(model.native, state, grid, dt)
        self._iterations += self._native.iterations
        self._rounds += self._native.rounds
        return report

    def finish(self, state: State) -> None:
        """Give particles that have moved what the midpoint rule has left for them, after `solve`."""
        self._native.finish(state)

    @property
    def converged(self) -> bool:
        """Whether the last step was solved."""
        return bool(self._native.converged)

    @property
    def failure(self) -> str:
        """What to say of the last step, if it was not."""
        return (
            "has no velocity that solves the implicit step (forces left over: "
            f"{self._native.residual:.2g} of all, after {self._native.iterations} iterations)"
        )

    def accept(self) -> None:
        """Count the last step as taken."""
        self._steps += 1
        self._residual = max(self._residual, self._native.residual)
        self._unsettled += not self._native.contacts_settled

    def totals(self) -> SolveTotals:
        """Return the work of the steps since `begin`, that of rejected ones too."""
        steps = max(self._steps, 1)
        return SolveTotals(
            self._iterations / steps, self._rounds / steps, self._residual, self._unsettled / steps
        )


def implicit_of(model: Model) -> Implicit | None:
    """Return what solves the steps of `model`; None for explicit ones."""
    return Implicit(model) if model.numerics.is_implicit else None
