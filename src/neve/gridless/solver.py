"""Most of a solver without a grid: its solids, sums, files and changes."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.build import PlacedSolids, material_table, require_same_sources, with_one_more
from neve.diagnostics import row_of, sums_of
from neve.rigid.going_on import going_on
from neve.scene.schema.scene import Scene, Source
from neve.scene.values.choices import TRANSFERS
from neve.scene.values.curves import keyed
from neve.solver import Blowup, Solver


class GridlessSolver(Solver):
    """Hold what solvers without a grid share; a subclass fills `state` and `placed` and takes steps.

    Attributes:
        placed: the scene's solids in the core
    """

    fixed = (*Solver.fixed, "dx", "particles_per_cell", "sampling", "seed")
    unread = (
        "spline",
        "transfer",
        *dict.fromkeys(key for transfer in TRANSFERS.values() for key in transfer.options),
        "initial_volume",
    )
    placed: PlacedSolids

    @staticmethod
    @abstractmethod
    def place_solids(scene: Scene) -> PlacedSolids:
        """Return the solids of `scene` in the core, the bodies where they start. Errors: SceneError."""

    @staticmethod
    @abstractmethod
    def snow_of(scene: Scene, solids: PlacedSolids, indices: Sequence[int]) -> dict[str, NDArray[Any]]:
        """Return the particles of the sources of these indices as arrays of `fields`.

        Errors: as `neve.mpm.initial.snow_of`.
        """

    def _bounded(self, lengths: Iterable[tuple[float, str]]) -> tuple[float, str]:
        """Return the shortest of time steps [s] with their names, dt_max and numerics.dt among them."""
        numerics = self.scene.numerics
        dt, bound = numerics.dt_max, "dt_max"
        for length, name in lengths:
            if length < dt:
                dt, bound = length, name
        if numerics.dt != "auto" and float(numerics.dt) <= dt:
            return float(numerics.dt), "fixed"
        return dt, bound

    def _ways(self, fastest: float) -> list[tuple[float, str]]:
        """Return in what time [s] a particle of the speed `fastest` [m/s], and a solid, move by `cfl` of the
        distance of two particles.
        """
        way = self.scene.numerics.cfl * self.scene.numerics.spacing
        speeds = ((fastest, "speed"), (self.placed.solid_speed, "solid"))
        return [(way / speed, name) for speed, name in speeds if speed > 0.0]

    def _whole(self, dt: float, bound: str, remaining: float, steps: int) -> float:
        """Return the time step at most `dt` [s] of which `remaining` [s] is a whole multiple.

        Errors: Blowup if there would be more than a thousand million.
        """
        if not dt > 1e-9 * remaining:
            raise Blowup(
                f"after step {steps} the time step is bound to {dt:.3g} s ({bound}): "
                "lower snow.E0 or the velocities, or raise numerics.dt"
            )
        return remaining / max(1, math.ceil(remaining / dt * (1 - 1e-9)))

    def _set_time(self, time: float) -> None:
        """Give gravity the value that it has at `time` [s]."""
        if self.scene.world.keyframes:
            self.placed.set_gravity(keyed(self.scene.world, "gravity", time))

    def _sums(self, totals: Any, exchanged: NDArray[np.float64]) -> dict[str, Any]:
        """Return the values of `Diagnostics` that all have, from the `totals` of the core."""
        return {**sums_of(totals, exchanged, self.count), **self.placed.totals_of_bodies()}

    def log_values(self, totals: Any) -> Mapping[str, float]:
        """Return the values of the columns of the log, but the excess of energy."""
        return row_of(totals, self.log_columns)

    def save(self) -> dict[str, NDArray[Any]]:
        """Return the state and the bodies."""
        bodies = self.placed.rigid.save() if self.placed.rigid else {}
        return {**super().save(), **bodies}

    @property
    def count(self) -> int:
        """Number of particles."""
        return int(self.state.count)

    @property
    def bytes(self) -> int:
        """Memory of particles, sums and pairs [bytes]."""
        return int(self.state.bytes)

    def columns(self) -> dict[str, Callable[[], Any]]:
        """Return the fields of the state, and the density [kg/m3] (n,)."""
        state = self.state
        return super().columns() | {"density": lambda: np.asarray(state.m / (state.V0 * state.J_P))}

    def take_exchanged(self) -> NDArray[np.float64]:
        """Return what snow and each solid exchanged since the last call, (n, 7)."""
        return np.asarray(self.state.take_exchanged(len(self.placed.solids)))

    def _go_on_in(self, scene: Scene) -> None:
        """Go on with the same particles in another scene. Errors: SceneError."""
        require_same_sources(self.scene, scene)
        placed = going_on(self.scene, scene, self.placed, self.place_solids)
        table = material_table(scene)
        rows = np.array([table.index(scene.snow_of(bearer)) for bearer in scene.bearers], dtype=np.uint16)
        self.state.material[...] = rows[self.state.source]
        self.placed, self.scene = placed, scene

    def _with_source(
        self, source: Source, time: float
    ) -> tuple[Scene, PlacedSolids, dict[str, NDArray[Any]], int]:
        """Return the scene with `source`, its solids at `time` [s], the source's snow and its first id.

        Errors: SceneError.
        """
        scene = with_one_more(self.scene, source)
        placed = going_on(self.scene, scene, self.placed, self.place_solids)
        placed.place_solids(time)
        fresh = self.snow_of(scene, placed, [len(self.scene.sources)])
        ids = np.asarray(self.state.id)
        return scene, placed, fresh, int(ids.max()) + 1 if len(ids) else 0
