"""Run random scenes and judge them: no crash, no NaN, nothing lost, mass exact, no energy from nowhere."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from neve.diagnostics import Balance, Diagnostics
from neve.fuzz.outcome import Outcome
from neve.fuzz.scenes.draw import draw
from neve.scene.schema.scene import Scene
from neve.scene.values.choices import TRANSFERS
from neve.simulation import Simulation
from neve.solver import Blowup

PARTS = 30
"""So often in its duration a scene is looked at."""

MOST_GAIN = 0.05
"""Growth of energy that is allowed, as a share of all that was put in since the start."""

MOST_SURGE = 0.25
"""Growth of energy between two records that is allowed, as a share of what moves and is strained then."""

MOST_STEPS = 20_000
"""Steps after which a scene counts as stuck."""


def endure(seed: int, number: int) -> Outcome:
    """Run scene `number` of the campaign `seed`.

    Facts of the outcome: particles; steps; rejected: steps that were rejected and tried again; gain: largest
    growth of energy over all that was put in [1]; surge: largest growth between two records over what moved
    and was strained then [1]; judged: whether the transfer bounds energy, so that both count.
    """
    scene, situation = draw(seed, number)
    trial = _Trial(scene)
    try:
        fault = trial.run(stacked=situation == "coincident")
    except Blowup as stop:
        fault = f"gave up: {stop}"
    numerics = scene.numerics
    laws = "+".join(dict.fromkeys(scene.snow_of(source).law for source in scene.sources))
    facts = {
        "particles": trial.particles,
        "steps": trial.steps,
        "rejected": trial.rejected,
        "gain": trial.budget.gain,
        "surge": trial.budget.surge,
        "judged": trial.judged,
    }
    kind = ", ".join((laws, numerics.transfer, numerics.spline, numerics.precision, f"dx {numerics.dx:.2g}"))
    about = f"{situation:10} {trial.particles:6,} particles {trial.steps:6,} steps  {kind}"
    return Outcome(seed, number, "failed" if fault else "held", about, fault, facts=facts)


def summary(outcomes: Sequence[Outcome]) -> str:
    """Say how many steps there were, and how far energy grew."""
    ran = [outcome.facts for outcome in outcomes if "steps" in outcome.facts]
    judged = [facts for facts in ran if facts["judged"]]
    gain = max((facts["gain"] for facts in judged), default=0.0)
    surge = max((facts["surge"] for facts in judged), default=0.0)
    return (
        f"{sum(facts['steps'] for facts in ran):,} steps, "
        f"{sum(facts['rejected'] for facts in ran):,} of them shortened; "
        f"largest growth of energy {100 * gain:.2g} % of what was put in "
        f"(allowed {100 * MOST_GAIN:g} %), {100 * surge:.2g} % of what moved between two looks "
        f"(allowed {100 * MOST_SURGE:g} %)"
    )


class _Trial:
    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.particles = self.steps = self.rejected = 0
        self.budget = Budget()
        self.judged = TRANSFERS[scene.numerics.transfer].has_bounded_energy

    def run(self, stacked: bool) -> str:
        sim = Simulation(self.scene, threads=1)
        self.particles = sim.state.count
        if stacked:
            _stack(sim)
        mass = _mass_by_id(sim)
        self.budget.record(sim.diagnostics())
        for _ in range(PARTS):
            sim.advance(self.scene.run.duration / PARTS)
            self.steps = sim.steps
            self.rejected += sim.stats.rejected
            fault = _fault(sim, mass)
            if fault:
                return fault
            self.budget.record(sim.diagnostics())
            if self.judged and self.budget.fault():
                return self.budget.fault()
            if sim.steps > MOST_STEPS:
                return f"stuck: more than {MOST_STEPS:,} steps"
        return ""


class Budget:
    """The energy that was put into the snow of a run, and what cannot be accounted for.

    Put in are the energy at the start, the work of colliders, and what the snow fell. `gain` compares
    with all of it, and so does not see energy that comes from nowhere after as much was dissipated;
    `surge` compares one record with the next, and so does not see what comes between them while as much
    is dissipated.
    """

    def __init__(self) -> None:
        self.gain = self.surge = 0.0
        self._start: Balance | None = None
        self._put_in = 0.0

    def record(self, totals: Diagnostics) -> None:
        """Take in the energies of a state, whose sums are `totals`."""
        now = Balance.of(totals)
        if self._start is None:
            self._start = self._before = now
            self._put_in = now.kinetic_and_elastic
            return
        start, before, self._before = self._start, self._before, now
        fallen = max(start.potential - now.potential, 0.0)
        self._put_in = max(self._put_in, start.kinetic_and_elastic + max(now.work, 0.0) + fallen)
        self.gain = max(self.gain, _growth(start, now) / max(self._put_in, 1e-300))
        alive = max(before.kinetic_and_elastic, now.kinetic_and_elastic)
        self.surge = max(self.surge, _growth(before, now) / max(alive, 1e-300))

    def fault(self) -> str:
        """Return what is wrong with the energy, "" if nothing is."""
        if self.gain > MOST_GAIN:
            return f"energy grew by {100 * self.gain:.3g} % of what was put in"
        if self.surge > MOST_SURGE:
            return f"energy surged by {100 * self.surge:.3g} % between two records"
        return ""


def _growth(before: Balance, now: Balance) -> float:
    """Return the growth of energy [J] without work, beyond the rounding of a float32 potential."""
    rounding = 1e-6 * (abs(before.potential) + abs(now.potential))
    return max(now.growth(before) - rounding, 0.0)


def _stack(sim: Simulation) -> None:
    """Put every tenth particle exactly on top of the one before it."""
    x = sim.state.x
    x[1::10] = x[0::10][: len(x[1::10])]


def _mass_by_id(sim: Simulation) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    state = sim.state
    return np.asarray(state.m, dtype=np.float64)[np.argsort(state.id)]


def _fault(sim: Simulation, mass: np.ndarray[tuple[int], np.dtype[np.float64]]) -> str:
    state = sim.state
    for field in sim.solver.fields:
        if not np.all(np.isfinite(getattr(state, field.name))):
            return f"{field.name} is not finite after {sim.steps} steps"
    if not np.array_equal(np.sort(state.id), np.arange(len(mass))):
        return "a particle was lost"
    if not np.array_equal(_mass_by_id(sim), mass):
        return "a particle changed its mass"
    return ""
