"""A process that runs trials: `python -m neve.fuzz.worker MODULE:FUNCTION`.

It reads a line of JSON, [seed, number], for each trial and answers with the outcome, a line too. It ends
when its input does.
"""

from __future__ import annotations

import faulthandler
import json
import os
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import replace

from neve.fuzz.outcome import Outcome
from neve.fuzz.registry import named


def attempt(trial: Callable[[int, int], Outcome], seed: int, number: int) -> Outcome:
    """Run one trial; whatever it raises but Ctrl-C is a failure."""
    started = time.perf_counter()
    try:
        outcome = trial(seed, number)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        sentence = " ".join(traceback.format_exception_only(error)[-1].split())
        facts = {"traceback": traceback.format_exc()}
        outcome = Outcome(seed, number, "failed", "", f"crashed: {sentence}", 0.0, facts)
    return replace(outcome, seconds=round(time.perf_counter() - started, 3))


def serve(place: str) -> None:
    """Run the trials that standard input names."""
    faulthandler.enable()
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what a trial prints is no answer
    trial = named(place)
    for line in sys.stdin:
        seed, number = json.loads(line)
        answers.write(attempt(trial, seed, number).as_json() + "\n")
        answers.flush()


if __name__ == "__main__":
    serve(sys.argv[1])
