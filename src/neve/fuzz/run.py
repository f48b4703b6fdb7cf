"""The command `neve fuzz`: run the campaign and tell its outcomes as they come."""

from __future__ import annotations

import json
import logging
import sys
import warnings
from dataclasses import asdict

from neve.fuzz.campaign import MOST_GAIN, MOST_SURGE, Outcome, endure
from neve.scene.errors import SceneWarning


def run(
    seed: int = 0,
    scenes: int = 200,
    only: int | None = None,
    threads: int | None = None,
    as_json: bool = False,
) -> bool:
    """Run the scenes 0 to `scenes` - 1 of the campaign `seed`, or `only` one; return whether all held."""
    logging.getLogger("neve").setLevel(logging.ERROR)
    warnings.simplefilter("ignore", SceneWarning)
    outcomes = []
    for number in range(scenes) if only is None else [only]:
        outcomes.append(endure(seed, number, threads))
        if not as_json:
            print(text_of(outcomes[-1]), flush=True)
    bad = [outcome for outcome in outcomes if outcome.fault]
    if as_json:
        json.dump([asdict(outcome) for outcome in outcomes], sys.stdout, indent=2)
        print()
    else:
        steps = sum(outcome.steps for outcome in outcomes)
        judged = [outcome for outcome in outcomes if outcome.judged]
        gain = max((outcome.gain for outcome in judged), default=0.0)
        surge = max((outcome.surge for outcome in judged), default=0.0)
        print(
            f"{len(outcomes) - len(bad)} of {len(outcomes)} scenes held, {steps:,} steps, "
            f"{sum(outcome.rejected for outcome in outcomes):,} of them shortened; largest growth of energy "
            f"{100 * gain:.2g} % of what was put in (allowed {100 * MOST_GAIN:g} %), "
            f"{100 * surge:.2g} % of what moved between two looks (allowed {100 * MOST_SURGE:g} %)"
        )
        for outcome in bad:
            print(f"scene {outcome.number} did not hold: neve fuzz --seed {seed} --only {outcome.number}")
    return not bad


def text_of(outcome: Outcome) -> str:
    """Put an outcome into a line."""
    return (
        f"{outcome.number:4} {outcome.situation:10} {outcome.particles:6,} particles "
        f"{outcome.steps:6,} steps {outcome.seconds:5.1f} s  {outcome.description}"
        f"{': ' + outcome.fault if outcome.fault else ''}"
    )
