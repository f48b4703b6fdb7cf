"""Particles in contact as a solver: state, contacts, and the step with its size control."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.build import wakes_all
from neve.diagnostics import MECHANICS, Diagnostics
from neve.flow.births import Births
from neve.flow.flow import Flow
from neve.gridless.solver import GridlessSolver
from neve.heat.clock import HeatClock
from neve.heat.enthalpy import columns as heat_columns
from neve.particles.constants import BOND_GAP, radius_at_birth, without_counterpart
from neve.particles.initial import (
    FIELDS,
    birth_bounds,
    from_arrays,
    place_solids,
    reach,
    set_constants,
    snow_of,
)
from neve.particles.open_snow import OpenParticles
from neve.sampling.fineness import particles_of
from neve.sampling.room import require_room_for_all
from neve.scene.schema.scene import Scene, Source
from neve.solver import Arrays, Blowup, StepSummary

if TYPE_CHECKING:
    from neve._core import ParticleReport, Particles

CONTACTS = ("contact_begin", "contact_row", "contact_memory")
"""Names of what `Particles.contacts` returns in a checkpoint."""
SOFTEST = 1e-12
"""Least k / m of a particle that the time step allows for [1/s2]: where there is no snow."""
FEWEST = 6
"""Contacts of a particle that the time step allows for at least: new ones come within a step."""
MARGIN = 0.95
"""Time step over the longest that is proven to be stable [1]."""


@dataclass(frozen=True, kw_only=True)
class ParticleDiagnostics(Diagnostics):
    """Hold the sums over all particles, and how many bonds and contacts there are.

    Elastic energy is of bonds, contacts and the springs of friction.
    """

    bonds: int
    contacts: int


class ParticleSolver(GridlessSolver):
    """Advance snow as particles that push, pull, rub and are compacted.

    Attributes:
        state: the particles, a `neve._core.Particles`
    """

    fields = FIELDS
    has_heat = True
    has_flow = True
    unread = (*GridlessSolver.unread, "strain_max")
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
    unread_of = staticmethod(without_counterpart)

    def __init__(self, scene: Scene, saved: Arrays | None = None) -> None:
        """Fill the sources, or go on from `saved`. Errors: SceneError for a source that cannot be used."""
        super().__init__(scene, saved)
        self.heat = HeatClock(saved)
        self.placed = place_solids(scene)
        self._let_flow(Flow(scene))
        sources, emitters = len(scene.sources), len(scene.emitters)
        if saved is None:
            if emitters and not scene.sinks:
                require_room_for_all(particles_of(scene), scene.numerics)
            self.state = from_arrays(scene, snow_of(scene, self.placed, range(sources)))
            self.births = Births.of_sources(np.bincount(self.state.source, minlength=sources).tolist())
            self._derive()
            self._bond(0)
        else:
            self.state = from_arrays(scene, saved)
            self.births = Births.of_arrays(saved["births"], saved["born"], sources, emitters)
            self.flow.restore(saved)
            self._require_whole()
            self._derive()
            self.state.set_contacts(self._near, *(np.asarray(saved[name]) for name in CONTACTS))
            self.state.last_dt, self.state.order = float(saved["last_dt"]), int(saved["order"])
            if self.placed.rigid:
                self.placed.rigid.restore(saved)

    def _require_whole(self) -> None:
        """See that what was saved can be. Errors: ValueError."""
        if not self.count:
            return
        if int(np.max(self.state.id)) >= self.births.count:
            raise ValueError("a particle was born later than any")
        if int(np.max(self.state.source)) >= len(self.scene.bearers):
            raise ValueError("a particle comes from a source that is not there")

    def _let_flow(self, flow: Flow) -> None:
        """Let snow come and go by `flow` from now on."""
        self.flow, self._born = flow, birth_bounds(self.scene, flow.at_birth())

    def _derive(self) -> None:
        self._set_constants()
        self._near = reach(self.scene, self.state, self._born)

    def _set_constants(self) -> None:
        set_constants(self.scene, self.state, self._born)
        stiffest = max(self.state.stiffest, self._born.stiffest, SOFTEST)
        self._least_rate = self.state.rate_of(FEWEST * stiffest)

    def _bond(self, first: int) -> None:
        """Bond the snow of birth numbers from `first` on."""
        self._prepare(reach(self.scene, self.state, self._born, fresh=True))
        self.state.make_bonds(first, BOND_GAP)

    def _prepare(self, near: float) -> None:
        with self._listing():
            self.state.prepare(near, MARGIN / self._least_rate)

    @contextmanager
    def _listing(self) -> Iterator[None]:
        """Time the listing of neighbours. Errors: Blowup for a particle that is lost."""
        with self.timer.stage("neighbours"):
            try:
                yield
            except OverflowError as error:
                raise Blowup(
                    f"a particle has more than {int(str(error)):,} others within {self._near:.4g} m: "
                    "give emitters room, or lower the pressure on the snow"
                ) from None
            except ValueError as error:
                raise Blowup(
                    f"particle {error} is lost, or more than {2**19 * self._near:.4g} m from the origin: "
                    "lower numerics.cfl or the velocities"
                ) from None

    def begin(self, steps: int, time: float) -> None:
        """See who sleeps, list neighbours, and see how stiff contacts are. Errors: Blowup."""
        self._set_time(time)
        self._derive()
        self.flow.begin()
        self.state.may_sleep = max((key.t for key in self.scene.world.keyframes), default=0.0) <= time
        self._prepare(self._near)
        self._report = self.state.stiffness_now()
        self._require_finite(self._report, steps, time)

    def step(self, steps: int, time: float, remaining: float) -> StepSummary:
        """Take one step, of the dt that the contacts allow, or the scene's if it is less. Errors: Blowup."""
        if self.placed.solids_move:
            with self.timer.stage("bodies"):
                self.placed.place_solids(time)
        dt, bound = self._longest(self._report.speed)
        dt = self._whole(dt, bound, remaining, steps)
        self._ends = dt >= remaining * (1 - 1e-9)
        with self.timer.stage("step"):
            self._report = self.state.step(self.placed.native, dt)
        return StepSummary(dt, bound, 0)

    def _longest(self, fastest: float) -> tuple[float, str]:
        """Return the time step [s] and what bounds it.

        MARGIN of what is stable for any motion of the particles that there are (`stable_rate` in the core);
        and the way of a particle or a solid, `cfl` of the distance of two particles.
        """
        stable = MARGIN / max(self._report.rate, self._least_rate)
        return self._bounded([(stable, "contact"), *self._ways(fastest)])

    def end_step(self, steps: int, time: float, dt: float) -> NDArray[np.float64] | None:
        """Check the particles, renew used lists of neighbours, move the bodies. Errors: Blowup."""
        self._require_finite(self._report, steps, time)
        self._set_time(time)
        if self.state.is_due:
            with self._listing():
                self.state.renew(self.placed.native, steps)
        if self.scene.is_open:
            self._come_and_go(time, dt)
        if self.scene.heat is not None:  # which needs all pairs as they are now
            self._pass_heat(dt, steps, time)
        return self._move_bodies(time, dt)

    def _come_and_go(self, time: float, dt: float) -> None:
        """Let snow come and go in the step of dt [s] that ends at `time` [s]. Errors: Blowup."""
        snow = OpenParticles(self.scene, self.placed, self.state, self._settle)
        came, went = self.flow.advance(snow, self.births, self._report.speed, time, dt, self._ends)
        if came or went:
            snow.settle()
            self._report = self.state.stiffness_now()

    def _settle(self, state: Particles, newborn: int | None) -> None:
        """Go on with the particles `state`: list their pairs, and bond those from `newborn` on."""
        self.state = state
        self._derive()
        self._prepare(self._near)
        if newborn is not None:
            state.bond_newborn(newborn, BOND_GAP)

    def _pass_heat(self, dt: float, steps: int, time: float) -> None:
        """Let heat flow, once it is due: `dt` [s] of motion later than at the last call. Errors: Blowup."""
        with self.timer.stage("heat"):
            solids = self.placed.native
            if self.heat.advance(lambda due: self.state.pass_heat(due, solids), dt, steps, time) is None:
                return
            self._set_constants()  # what freezes is stiffer
            self._report = self.state.stiffness_now()

    @property
    def stiffest(self) -> float:
        """Largest sum of the stiffness of a particle's contacts over its mass, of the last step [1/s2]."""
        return float(self._report.stiffest)

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
            **self.flow.books(),
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
        return {**super().save(), **contacts, **last, **self.births.arrays(), **self.flow.save()}

    @property
    def radius(self) -> float | NDArray[Any]:
        """Radius of each particle [m], (n,); where there is none, of one in a source."""
        if not self.count:
            return radius_at_birth(self.scene.numerics.spacing**3)
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
        self._go_on_flowing()
        if wakes:
            self.state.rest[...] = 0.0
        self._derive()

    def add(self, source: Source, time: float) -> None:
        """Add the snow of `source` at `time` [s], and the source to the scene. Errors: SceneError."""
        before, first = self.count, self.births.count
        others = len(self.scene.sources)
        scene, placed, fresh, _ = self._with_source(source, time)
        state = self.state.with_particles(np.arange(before, dtype=np.uint32), len(fresh["m"]))
        state.source[state.source >= others] += 1  # emitters are numbered after the sources
        for name, values in fresh.items():
            getattr(state, name)[before:] = values
        state.id[before:] = self.births.add(others, len(fresh["m"]))
        self.scene, self.placed, self.state = scene, placed, state
        self._go_on_flowing()
        self._derive()
        self._bond(first)

    def _go_on_flowing(self) -> None:
        """Let snow come and go by the scene as it is now, on from where it stands."""
        flow = Flow(self.scene)
        flow.take_over(self.flow)
        self._let_flow(flow)
