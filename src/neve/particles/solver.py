"""Particles in contact as a solver: state, contacts, and the step with its size control."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.build import wakes_all
from neve.diagnostics import MECHANICS
from neve.gridless.solver import GridlessDiagnostics, GridlessSolver
from neve.heat.clock import HeatClock
from neve.heat.enthalpy import columns as heat_columns
from neve.particles.constants import BOND_GAP
from neve.particles.initial import (
    FIELDS,
    from_arrays,
    place_solids,
    reach,
    set_constants,
    snow_of,
)
from neve.scene.schema.scene import Scene, Source
from neve.solver import Arrays, Blowup, StepSummary, joined

if TYPE_CHECKING:
    from neve._core import ParticleReport, Particles

CONTACTS = ("contact_begin", "contact_row", "contact_memory")
"""Names of what `Particles.contacts` returns in a checkpoint."""
FEWEST = 6
"""Contacts of a particle that the time step allows for at least: new ones come within a step."""


@dataclass(frozen=True, kw_only=True)
class ParticleDiagnostics(GridlessDiagnostics):
    """Hold the sums over all particles; elastic energy is of bonds, contacts and the springs of friction.

    bonds, contacts: how many there are; asleep: particles that no step moves.
    heat: enthalpy above that of ice at the melting point, heat_taken: from air and sun so far [J];
    water: liquid mass [kg]; heat_speed [1], 0 without heat.
    """

    bonds: int
    contacts: int
    asleep: int
    heat: float
    heat_taken: float
    water: float
    heat_speed: float


class ParticleSolver(GridlessSolver):
    """Advance snow as particles that push, pull, rub and are compacted.

    Attributes:
        state: the particles, a `neve._core.Particles`
    """

    fields = FIELDS
    has_heat = True
    stages = ("neighbours", "step", "bodies", "heat")
    log_columns = (
        *MECHANICS,
        "bonds",
        "contacts",
        "asleep",  # particles that no step moves
    )
    state: Particles
    place_solids = staticmethod(place_solids)
    snow_of = staticmethod(snow_of)

    def __init__(self, scene: Scene, saved: Arrays | None = None) -> None:
        """Fill the sources, or go on from `saved`. Errors: SceneError for a source that cannot be used."""
        super().__init__(scene, saved)
        self.heat = HeatClock(saved)
        self.placed = place_solids(scene)
        if saved is None:
            self.state = from_arrays(scene, snow_of(scene, self.placed, range(len(scene.sources))))
            self._derive()
            self._bond(0)
        else:
            self.state = from_arrays(scene, saved)
            self._derive()
            self.state.set_contacts(self._near, *(np.asarray(saved[name]) for name in CONTACTS))
            self.state.last_dt, self.state.order = float(saved["last_dt"]), int(saved["order"])
            if self.placed.rigid:
                self.placed.rigid.restore(saved)

    def _derive(self) -> None:
        self._set_constants()
        self._near = reach(self.state)

    def _set_constants(self) -> None:
        set_constants(self.scene, self.state)
        self._least_stiff = FEWEST * self.state.stiffest

    def _bond(self, first: int) -> None:
        """Bond the snow of birth numbers from `first` on."""
        self._prepare()
        self.state.make_bonds(first, BOND_GAP)

    def _prepare(self) -> None:
        with self._listing():
            self.state.prepare(self._near, 1.0 / math.sqrt(self._least_stiff))

    @contextmanager
    def _listing(self) -> Iterator[None]:
        """Time the listing of neighbours. Errors: Blowup for a particle that is lost."""
        with self.timer.stage("neighbours"):
            try:
                yield
            except ValueError as error:
                raise Blowup(
                    f"particle {error} is lost, or more than {2**19 * self._near:.4g} m from the origin: "
                    "lower numerics.cfl or the velocities"
                ) from None

    def begin(self, steps: int, time: float) -> None:
        """See who sleeps, list neighbours, and see how stiff contacts are. Errors: Blowup."""
        self._set_time(time)
        self._derive()
        self.state.may_sleep = max((key.t for key in self.scene.world.keyframes), default=0.0) <= time
        self._prepare()
        self._report = self.state.stiffness_now()
        self._require_finite(self._report, steps, time)

    def step(self, steps: int, time: float, remaining: float) -> StepSummary:
        """Take one step, of the dt that the contacts allow, or the scene's if it is less. Errors: Blowup."""
        if self.placed.solids_move:
            with self.timer.stage("bodies"):
                self.placed.place_solids(time)
        dt, bound = self._longest(self._report.speed)
        if not dt > 1e-9 * remaining:
            raise Blowup(
                f"after step {steps} contacts of particles ask for a time step of {dt:.3g} s: "
                "lower snow.E0 or the velocities"
            )
        dt = remaining / max(1, math.ceil(remaining / dt * (1 - 1e-9)))
        with self.timer.stage("step"):
            self._report = self.state.step(self.placed.native, dt)
        return StepSummary(dt, bound, 0)

    def _longest(self, fastest: float) -> tuple[float, str]:
        """Return the time step [s] and what bounds it.

        Half the limit 2 / sqrt(sum k / m) of the particle whose contacts are stiffest for its mass, where the
        exact limit is at least sqrt 2 / sqrt(sum k / m); and the way of a particle or a solid, `cfl` of the
        distance of two particles.
        """
        numerics = self.scene.numerics
        dt, bound = numerics.dt_max, "dt_max"
        stable = 1.0 / math.sqrt(self.stiffest)
        if stable < dt:
            dt, bound = stable, "contact"
        way = numerics.cfl * numerics.spacing
        for speed, name in ((fastest, "speed"), (self.placed.solid_speed, "solid")):
            if speed * dt > way:
                dt, bound = way / speed, name
        if numerics.dt != "auto" and float(numerics.dt) <= dt:
            return float(numerics.dt), "fixed"
        return dt, bound

    def end_step(self, steps: int, time: float, dt: float) -> NDArray[np.float64] | None:
        """Check the particles, renew used lists of neighbours, move the bodies. Errors: Blowup."""
        self._require_finite(self._report, steps, time)
        self._set_time(time)
        if self.state.is_due:
            with self._listing():
                self.state.renew(self.placed.native, steps)
        if self.scene.heat is not None:  # which needs all pairs as they are now
            self._pass_heat(dt, steps, time)
        return self._move_bodies(time, dt)

    def _pass_heat(self, dt: float, steps: int, time: float) -> None:
        """Let heat flow, once it is due: `dt` [s] of motion later than at the last call. Errors: Blowup."""
        with self.timer.stage("heat"):
            if self.heat.advance(self.state.pass_heat, dt, steps, time) is None:
                return
            self._set_constants()  # what freezes is stiffer
            self._report = self.state.stiffness_now()

    @property
    def stiffest(self) -> float:
        """Largest sum of the stiffness of a particle's contacts over its mass, of the last step [1/s2]."""
        return max(self._report.stiffest, self._least_stiff)

    def _require_finite(self, report: ParticleReport, steps: int, time: float) -> None:
        if report.finite:
            return
        wrong = ~(np.isfinite(self.state.x).all(axis=1) & np.isfinite(self.state.v).all(axis=1))
        rows = np.flatnonzero(wrong)
        which = f"particle {self.state.id[rows[0]]}" if len(rows) else "a particle"
        raise Blowup(
            f"{which} has no finite place or velocity after step {steps} (t = {time:.6g} s): "
            "lower numerics.cfl, or check E0 and velocities"
        )

    def diagnostics(self, exchanged: NDArray[np.float64]) -> ParticleDiagnostics:
        """Add up the state, in double precision in a fixed order."""
        t = self.state.totals(self.placed.native)
        return ParticleDiagnostics(
            **self._sums(t, exchanged),
            bonds=round(t.bonds),
            contacts=round(t.contacts),
            asleep=int(self.state.asleep),
            heat=t.heat if self.scene.heat else 0.0,
            heat_taken=self.heat.taken,
            water=t.water if self.scene.heat else 0.0,
            heat_speed=self.scene.heat.heat_speed if self.scene.heat else 0.0,
        )

    def save(self) -> dict[str, NDArray[Any]]:
        """Return the state, its contacts, the last dt, by which these are old, and the bodies."""
        contacts = dict(zip(CONTACTS, map(np.array, self.state.contacts()), strict=True))
        last = {
            "last_dt": np.array(self.state.last_dt),
            "order": np.array(self.state.order),
            **self.heat.save(),
        }
        return {**super().save(), **contacts, **last}

    @property
    def radius(self) -> NDArray[Any]:
        """Radius of each particle [m], (n,)."""
        return np.asarray(self.state.radius)

    def columns(self) -> dict[str, Callable[[], Any]]:
        """Return the fields of the state, the density, and with heat the temperature [deg C] and the phase.

        phase (n,) [1]: the share of water, 0 snow and ice, 1 water.
        """
        state = self.state
        found = super().columns()
        del found["rest"]  # infinite in sleep
        if self.scene.heat is not None:
            found |= heat_columns(lambda: (state.enthalpy, state.m))
        if self.scene.numerics.sleep:
            found["asleep"] = lambda: np.isinf(state.rest[:, 0]).astype(np.uint16)
        return found

    def change(self, scene: Scene) -> None:
        """Go on with the same particles and contacts in another scene. Bonds keep their strength.

        Errors: SceneError for sources that come or go, or snows that part.
        """
        wakes = wakes_all(self.scene, scene)
        self._go_on_in(scene)
        if wakes:
            self.state.rest[...] = 0.0
        self._derive()

    def add(self, source: Source, time: float) -> None:
        """Add the snow of `source` at `time` [s], and the source to the scene. Errors: SceneError."""
        scene, placed, fresh, first = self._with_source(source, time)
        there = self.save()
        both = joined(there, fresh, first)
        begin = np.concatenate([there["contact_begin"], np.full(len(fresh["m"]), there["contact_begin"][-1])])
        state = from_arrays(scene, both)
        self.scene, self.placed, self.state = scene, placed, state
        self._derive()
        contacts = (begin.astype(np.uint32), there["contact_row"], there["contact_memory"])
        state.set_contacts(self._near, *contacts)
        state.last_dt = float(there["last_dt"])
        self._bond(first)
