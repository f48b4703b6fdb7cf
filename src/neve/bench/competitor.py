"""Measure what another busy program costs: batches beside one that computes, and alone, in turn.

With c processors, as many threads and one competitor a fair share of the machine is c / (c + 1) of the speed.
"""

from __future__ import annotations

import signal
import subprocess
import sys
from dataclasses import dataclass
from time import perf_counter
from typing import Self

from neve import _core
from neve.bench.spread import Spread
from neve.simulation import Simulation

BATCHES = 9
"""Batches of each kind."""
SECONDS = 0.5
"""Least time of a batch [s]: many turns of the system's scheduler."""


@dataclass
class Shared:
    """Hold the speed of a step alone and beside a competitor, from batches in turn.

    Attributes:
        case: name of the case
        particles, threads, batches: sizes
        alone, beside: particle-steps a second
        kept: the latter over the former [1]
    """

    case: str
    particles: int
    threads: int
    batches: int
    alone: Spread
    beside: Spread
    kept: Spread

    def text(self) -> str:
        """Return the result as lines of text."""
        rows = [("alone", self.alone), ("beside one other program", self.beside)]
        lines = [
            f"{self.case}: {self.particles:,} particles, {self.threads} threads, median of {self.batches} "
            "pairs of batches"
        ]
        for name, rate in rows:
            least, largest = rate.least / 1e6, rate.largest / 1e6
            lines.append(f"  {rate.median / 1e6:.2f} M particle-steps/s {name} ({least:.2f}-{largest:.2f})")
        kept, fair = self.kept, self.threads / (self.threads + 1)
        lines.append(
            f"  keeps {kept.median:.0%} ({kept.least:.0%}-{kept.largest:.0%}); a fair share of as many "
            f"processors as threads is {fair:.0%}"
        )
        return "\n".join(lines)


class Competitor:
    """A program that computes as long as it is told to, in a `with` block; at first it rests."""

    def __enter__(self) -> Self:
        self._program = subprocess.Popen([sys.executable, "-c", "while True: pass"])
        self.compute(False)
        return self

    def __exit__(self, *error: object) -> None:
        self._program.kill()
        self._program.wait()

    @property
    def pid(self) -> int:
        """Number of its process."""
        return self._program.pid

    def compute(self, busy: bool) -> None:
        """Let it compute, or rest."""
        self._program.send_signal(signal.SIGCONT if busy else signal.SIGSTOP)


def measure_competitor(
    sim: Simulation, dt: float, steps: int, batches: int = BATCHES, seconds: float = SECONDS
) -> Shared:
    """Time batches of `steps` steps of `dt` [s] for `seconds` [s] each, beside a competitor and alone."""
    pairs: list[tuple[float, float]] = []
    with Competitor() as competitor:
        for _ in range(batches):
            rates = []
            for busy in (False, True):
                competitor.compute(busy)
                rates.append(_rate(sim, dt, steps, seconds))
            competitor.compute(False)
            pairs.append((rates[0], rates[1]))
    return Shared(
        case="competitor",
        particles=sim.count,
        threads=_core.threads(),
        batches=batches,
        alone=Spread.of([a for a, _ in pairs]),
        beside=Spread.of([b for _, b in pairs]),
        kept=Spread.of([b / a for a, b in pairs]),
    )


def _rate(sim: Simulation, dt: float, steps: int, seconds: float) -> float:
    """Advance for a while; return particle-steps a second."""
    before, start = sim.steps, perf_counter()
    while True:
        sim.advance(steps * dt)
        if (taken := perf_counter() - start) >= seconds:
            return sim.count * (sim.steps - before) / taken
