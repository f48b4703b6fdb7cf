"""Neve itself, as `worker.py` runs it: what every program has."""

from __future__ import annotations

from importlib.metadata import version

import numpy as np
from case import Case

import neve
from neve.bench.run import landing_block


class Program:
    """Run the block in Neve.

    Attributes:
        version: of the peer; law, precision: words for the table
        dt: the longest step that `advance` takes [s]; particles: how many there are
    """

    law, precision = "Stomakhin 2013", "float32"

    def __init__(self, case: Case, threads: int, device: str) -> None:
        """Take the particles of `case`; device: "cpu" or "cuda"."""
        self.version = version("neve")
        self.sim = neve.Simulation(landing_block(case.cells, device=device), threads=threads)
        self.dt, self.particles = case.dt, self.sim.state.count

    def advance(self, seconds: float) -> tuple[int, float]:
        """Simulate at least `seconds` and wait for it; return the steps taken and the seconds simulated."""
        steps, time = self.sim.steps, self.sim.time
        self.sim.advance(seconds)
        return self.sim.steps - steps, self.sim.time - time

    def state(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return positions (n, 3), velocities (n, 3), and J_P (n,) if the law has it."""
        state = self.sim.state
        return np.array(state.x), np.array(state.v), np.array(state.J_P)
