"""Measure the step on the GPU: wall time, and the time of each kernel by the GPU's own clock."""

from __future__ import annotations

from collections import defaultdict
from time import perf_counter
from typing import Any
from unittest import mock

import numpy as np

from neve.bench.run import DT, landing_block
from neve.cuda.stages import CudaStages
from neve.simulation import MOST_STEPS, Simulation

SIZES = {"1m": (50, 50, 50), "10m": (125, 100, 100)}
"""Blocks of snow in cells of 8 particles."""
TINY = {"1k": (5, 5, 5), "2k": (8, 6, 5)}
"""The same for a rehearsal."""
WARM, STEPS, BATCHES = 20, 20, 5

PARTICLE_NUMBERS = {"p2g": 3 + 3 + 9 + 6 + 2, "g2p": (3 + 9 + 1 + 2 + 2) + (3 + 3 + 9 + 9 + 6 + 1)}
"""Numbers that a kernel must read and write for each particle, with the default transfer."""


STEP_BYTES, STEP_FLOPS = 116, 2100
"""What a particle of the default step must move [bytes] and compute at least, as counted by hand."""
_CLOCK, _MEMORY_CLOCK, _BUS, _PROCESSORS = 13, 36, 37, 16  # CUdevice_attribute: kHz, kHz, bits, number
FP32_UNITS = {80: 64}
"""Of a multiprocessor, by architecture; 128 for all others that Neve compiles for."""


def peaks(driver: Any) -> dict[str, float]:
    """Return what the GPU can do at most, by its clocks: GB/s of memory, and G operations/s in float32.

    A fused multiply and add counts as two. Clocks that the driver does not tell are 0.
    """
    clock, memory = driver.attribute(_CLOCK), driver.attribute(_MEMORY_CLOCK)
    units = FP32_UNITS.get(driver.architecture, 128) * driver.attribute(_PROCESSORS)
    return {
        "peak_GB_per_second": 2 * memory * 1e3 * driver.attribute(_BUS) / 8 / 1e9,
        "peak_GFLOP_per_second": 2 * units * clock * 1e3 / 1e9,
    }


def shares(rate: float, peak: dict[str, float]) -> dict[str, float]:
    """Return which share of both a step takes that moves and computes what it must; where they are known."""
    used = {"peak_GB_per_second": STEP_BYTES * rate / 1e9, "peak_GFLOP_per_second": STEP_FLOPS * rate / 1e9}
    return {name.replace("peak", "share_of"): used[name] / top for name, top in peak.items() if top > 0}


def largest(found: dict[str, Any], seconds: float) -> tuple[int, int, int]:
    """Return the largest block that fits into the memory, and into half of `seconds`.

    found: what was measured of a smaller one
    """
    fits = 0.9 * found["memory_free"] / found["bytes_per_particle"]
    in_time = 0.5 * seconds * found["particles"] / (found["seconds_to_prepare"] + found["seconds_to_begin"])
    return 200, 200, max(1, int(min(fits, in_time) / (8 * 200 * 200)))


class Clock:
    """Mark the beginning and the end of every kernel."""

    def __init__(self, driver: Any) -> None:
        self._driver = driver
        self._marks: dict[str, list[tuple[Any, Any]]] = defaultdict(list)
        self._launch = CudaStages.launch

    def launch(self, stages: Any, model: Any, name: str, blocks: int, threads: int) -> None:
        """Launch a kernel between two marks."""
        first = self._driver.event()
        self._launch(stages, model, name, blocks, threads)
        self._marks[name].append((first, self._driver.event()))

    def milliseconds(self, steps: int) -> dict[str, float]:
        """Return the time of each kernel for a step [ms]."""
        total = {
            name: sum(self._driver.milliseconds(*pair) for pair in pairs)
            for name, pairs in self._marks.items()
        }
        return {name: value / steps for name, value in total.items()}


def stepped(sim: Simulation, steps: int, most: int = MOST_STEPS) -> float:
    """Take steps, up to `most` without the host; return the wall time of one [s]."""
    solver, done, begun = sim.solver, 0, perf_counter()
    while done < steps:
        now = sim.time + done * DT
        taken = solver.take_steps(sim.steps + done, now, (steps - done) * DT, most)
        done += len(taken)
        solver.end_step(sim.steps + done, now + sum(step.dt for step in taken), taken[-1].dt)
    return (perf_counter() - begun) / done


def fused(cells: tuple[int, int, int]) -> dict[str, Any]:
    """Return the same of the variant that gathers and scatters in one kernel; the host chooses each step."""
    with mock.patch.object(CudaStages, "fused", True):
        return measured(cells)


def measured(cells: tuple[int, int, int]) -> dict[str, Any]:
    """Return rates and times of a block of snow that lands."""
    begun = perf_counter()
    sim = Simulation(landing_block(cells, device="cuda"))
    prepared = perf_counter() - begun
    count = sim.count
    begun = perf_counter()
    sim.solver.begin(sim.steps, sim.time)
    begin = perf_counter() - begun
    stepped(sim, WARM)
    walls = [stepped(sim, STEPS) for _ in range(BATCHES)]
    stages = sim.solver.model.core
    clock = Clock(stages.driver)
    with mock.patch.object(CudaStages, "launch", lambda *arguments: clock.launch(*arguments)):
        stepped(sim, STEPS, most=1)
        stages.driver.synchronize()
        kernels = clock.milliseconds(STEPS)
    real = np.dtype(sim.scene.numerics.precision).itemsize
    bandwidth = {
        name: PARTICLE_NUMBERS[name] * real * count / (1e-3 * kernels[name]) / 1e9
        for name in PARTICLE_NUMBERS
        if kernels.get(name, 0) > 0
    }
    free, total = stages.driver.memory()
    rate, peak = count / float(np.median(walls)), peaks(stages.driver)
    return {
        "particles": count,
        "homes": sim.solver.grid.homes,
        "blocks": sim.solver.grid.blocks,
        "seconds_to_prepare": prepared,
        "seconds_to_begin": begin,
        "steps_of_a_batch": STEPS,
        "step_ms": [1e3 * wall for wall in sorted(walls)],
        "particle_steps_per_second": rate,
        "kernel_ms": kernels,
        "GB_per_second_of_particles": bandwidth,
        "bytes_per_particle": sim.bytes / count,
        "memory_used": total - free,
        "memory_free": free + sim.bytes,
        **peak,
        **shares(rate, peak),
        "finite": bool(np.isfinite(np.asarray(sim.state.x)).all()),
    }
