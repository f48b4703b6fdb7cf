"""Run random scenes and judge them: no crash, no NaN, nothing lost, mass exact, no energy from nowhere."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from neve.fuzz.outcome import Outcome
from neve.fuzz.scenes.draw import draw
from neve.fuzz.scenes.energy import MOST_GAIN, MOST_SURGE, MOST_SWING
from neve.fuzz.scenes.judges import JUDGES, Judge
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene
from neve.simulation import Simulation
from neve.solver import Blowup

PARTS = 30
"""So often in its duration a scene is looked at."""

MOST_SENTENCE = 600
"""Characters of a sentence."""

KEY = re.compile(r"\b(world|numerics|snow|sources|colliders|bodies|run|camera)(\.[\w.]+)?\b")
"""What a sentence about a scene names."""

MOST_STEPS = 20_000
"""Steps after which a scene counts as stuck; one whose snow is pressed to ice, which is stiff, ends there."""


def endure(seed: int, number: int, method: str | None = None) -> Outcome:
    """Run scene `number` of the campaign `seed`, drawn for one method if that is named.

    Facts of the outcome: method; particles; steps; rejected: steps that were rejected and tried again; gain,
    surge and swing of `neve.fuzz.scenes.energy.Budget`; judged: whether they count (see
    `neve.fuzz.scenes.judges`); cut_short: whether the scene ended early, with snow pressed to ice.
    """
    where = f"fuzz scene {seed}/{number}"
    try:
        scene, situation = draw(seed, number, method)
        trial = _Trial(scene, situation)
    except SceneError as error:
        fault = unclear(str(error), where)
        return Outcome(seed, number, "failed" if fault else "refused", "", fault or str(error))
    try:
        fault = trial.run()
    except Blowup as stop:
        fault = f"gave up: {stop}"
    judge, numerics = trial.judge, scene.numerics
    facts = {
        "method": numerics.method,
        "particles": trial.sim.count,
        "steps": trial.sim.steps,
        "rejected": trial.rejected,
        "gain": judge.budget.gain,
        "surge": judge.budget.surge,
        "swing": judge.budget.swing,
        "judged": judge.is_judged,
        "cut_short": trial.is_cut_short,
    }
    laws = "+".join(dict.fromkeys(scene.snow_of(source).law for source in scene.sources))
    kind = ", ".join((laws, *judge.kind, numerics.precision, f"dx {numerics.dx:.2g}"))
    about = f"{situation:10} {trial.sim.count:6,} particles {trial.sim.steps:6,} steps  {kind}"
    return Outcome(seed, number, "failed" if fault else "held", about, fault, facts=facts)


def endure_mpm(seed: int, number: int) -> Outcome:
    """Run a scene by the material point method."""
    return endure(seed, number, "mpm")


def endure_particles(seed: int, number: int) -> Outcome:
    """Run a scene as particles in contact."""
    return endure(seed, number, "particles")


def endure_sph(seed: int, number: int) -> Outcome:
    """Run a scene as smoothed particles."""
    return endure(seed, number, "sph")


def unclear(sentence: str, where: str) -> str:
    """Return what is wrong with the sentence of a refusal, "" if it is one that names what it is about."""
    if "\n" in sentence or not sentence.strip() or len(sentence) > MOST_SENTENCE:
        return f"refused in other than one sentence: {sentence}"
    if not KEY.search(sentence.removeprefix(where)):
        return f"refused without a key: {sentence}"
    return ""


def summary(outcomes: Sequence[Outcome]) -> str:
    """Say how many steps there were, and how far energy grew."""
    ran = [outcome.facts for outcome in outcomes if "steps" in outcome.facts]
    judged = [facts for facts in ran if facts["judged"]]
    gain, surge, swing = (
        100 * max((float(facts[name]) for facts in judged), default=0.0)
        for name in ("gain", "surge", "swing")
    )
    methods = Counter(str(facts["method"]) for facts in ran)
    return (
        f"{', '.join(f'{count:,} by {method}' for method, count in sorted(methods.items()))}; "
        f"{sum(facts['steps'] for facts in ran):,} steps, "
        f"{sum(facts['rejected'] for facts in ran):,} of them shortened; "
        f"{sum(facts['cut_short'] for facts in ran):,} scenes cut short with snow pressed to ice; "
        f"energy judged in {len(judged):,}: "
        f"largest gain {gain:.2g} % of what was put in (allowed {100 * MOST_GAIN:g} %), "
        f"surge {surge:.2g} % of what moved and was strained (allowed {100 * MOST_SURGE:g} %), "
        f"swing {swing:.2g} % (allowed {100 * MOST_SWING:g} %)"
    )


class _Trial:
    """A scene on its way. Errors: SceneError for a scene that is refused."""

    def __init__(self, scene: Scene, situation: str) -> None:
        self.scene = scene
        self.sim = Simulation(scene, threads=1)
        if situation == "coincident":
            _stack(self.sim)
        self.judge: Judge = JUDGES[scene.numerics.method](self.sim)
        self.rejected = 0
        self.is_cut_short = False

    def run(self) -> str:
        """Run the scene; return its fault, "" if there is none. Errors: Blowup."""
        sim, judge = self.sim, self.judge
        judge.begin()
        mass = _mass_by_id(sim)

        def enough() -> bool:
            judge.record()
            return sim.steps > MOST_STEPS or judge.energy_fault() != ""

        for part in range(PARTS):
            sim.advance(self.scene.run.duration / PARTS, enough)
            self.rejected += sim.stats.rejected
            fault = _fault(sim, mass) or judge.energy_fault() or judge.fault()
            if fault:
                return f"{fault}, after {sim.steps} steps"
            if sim.steps > MOST_STEPS:
                self.is_cut_short = judge.is_ice()
                return "" if self.is_cut_short else f"stuck: more than {MOST_STEPS:,} steps"
            judge.after(part, PARTS)
        return judge.fault_of_end()


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
        value = np.asarray(getattr(state, field.name))
        if np.any(np.isnan(value) if field.name == "rest" else ~np.isfinite(value)):  # infinite in sleep
            return f"{field.name} is not finite"
    if sim.scene.is_open:
        return _fault_of_open(sim, mass)
    if not np.array_equal(np.sort(state.id), np.arange(len(mass))):
        return "a particle was lost"
    if not np.array_equal(_mass_by_id(sim), mass):
        return "a particle changed its mass"
    return ""


def _fault_of_open(sim: Simulation, mass: np.ndarray[tuple[int], np.dtype[np.float64]]) -> str:
    """Return what is wrong where particles come and go, "" if nothing is; `mass`: of those at the start."""
    ids, m = np.asarray(sim.state.id), np.asarray(sim.state.m, dtype=np.float64)
    if len(np.unique(ids)) != len(ids):
        return "two particles have one number"
    old = ids < len(mass)
    if not np.array_equal(m[old], mass[ids[old]]):
        return "a particle changed its mass"
    books = sim.diagnostics()
    expected = float(mass.sum()) + books.emitted_mass - books.removed_mass
    if abs(books.mass - expected) > 1e-12 * (float(mass.sum()) + books.emitted_mass):
        return f"{books.mass:.17g} kg are there, where the books have {expected:.17g} kg"
    return ""
