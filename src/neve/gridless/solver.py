"""Most of a solver without a grid: its solids, sums, files and changes."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.build import PlacedSolids, material_table, require_same_sources, with_one_more
from neve.colliders.solid import Solid
from neve.diagnostics import row_of
from neve.geometry.pose import Pose
from neve.rigid.going_on import going_on
from neve.scene.schema.scene import Scene, Source
from neve.scene.values.curves import keyed
from neve.solver import Solver, advance_bodies


@dataclass(frozen=True, kw_only=True)
class GridlessDiagnostics:
    """Hold the sums over all particles at one instant, in double precision in a fixed order.

    mass [kg], momentum (3,) [kg m/s]; energies [J]: kinetic, elastic, potential (-m g . x); affine is none.
    `work` [J]: of the solids on the snow so far. Of the rigid bodies: bodies_momentum (3,) [kg m/s],
    bodies_kinetic and bodies_potential [J].
    """

    mass: float
    momentum: tuple[float, float, float]
    kinetic: float
    elastic: float
    potential: float
    work: float
    particles: int
    affine: float = 0.0
    bodies_momentum: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bodies_kinetic: float = 0.0
    bodies_potential: float = 0.0


class GridlessSolver(Solver):
    """Hold what solvers without a grid share; a subclass fills `state` and `placed` and takes steps.

    Attributes:
        placed: the scene's solids in the core
    """

    fixed = (*Solver.fixed, "dx", "particles_per_cell", "sampling", "seed")
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

    def _set_time(self, time: float) -> None:
        """Give gravity the value that it has at `time` [s]."""
        if self.scene.world.keyframes:
            self.placed.set_gravity(keyed(self.scene.world, "gravity", time))

    def _move_bodies(self, time: float, dt: float) -> NDArray[np.float64] | None:
        """Let bodies feel what the snow did to them in the step of dt [s] that ends at `time` [s].

        Returns what `take_exchanged` would, if there are bodies. Errors: Blowup.
        """
        if self.placed.rigid is None:
            return None
        with self.timer.stage("bodies"):
            exchanged = self.take_exchanged()
            advance_bodies(self.placed, dt, exchanged, time)
        return exchanged

    def _sums(self, totals: Any, exchanged: NDArray[np.float64]) -> dict[str, Any]:
        """Return the values of `GridlessDiagnostics` from the `totals` of the core."""
        px, py, pz = totals.momentum
        return {
            "mass": totals.mass,
            "momentum": (px, py, pz),
            "kinetic": totals.kinetic,
            "elastic": totals.elastic,
            "potential": totals.potential,
            "work": float(exchanged[:, 6].sum()),
            "particles": self.count,
            **self.placed.totals_of_bodies(),
        }

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

    @property
    def solids(self) -> Sequence[Solid]:
        """Colliders and rigid bodies."""
        return self.placed.solids

    def poses(self, time: float) -> list[Pose]:
        """Return the pose of each solid at `time` [s]."""
        return self.placed.poses(time)

    def take_exchanged(self) -> NDArray[np.float64]:
        """Return what snow and each solid exchanged since the last call, (n, 7)."""
        return np.asarray(self.state.take_exchanged(len(self.placed.solids)))

    def _go_on_in(self, scene: Scene) -> None:
        """Go on with the same particles in another scene. Errors: SceneError."""
        require_same_sources(self.scene, scene)
        placed = going_on(self.scene, scene, self.placed, self.place_solids)
        table = material_table(scene)
        rows = np.array([table.index(scene.snow_of(source)) for source in scene.sources], dtype=np.uint16)
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
