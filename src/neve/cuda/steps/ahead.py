"""Several steps without the host, until the GPU stops where it is needed (see `core/cuda/pace.hpp`)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from neve import _core
from neve.cuda.driver import Driver, Graph
from neve.cuda.layout import HALTS, LIMITS, MOST_STEPS, RATES, control_of
from neve.cuda.memory import Buffer

if TYPE_CHECKING:
    from neve._core import StepLimits
    from neve.cuda.grid import DeviceGrid
    from neve.cuda.model import DeviceModel
    from neve.cuda.stages import CudaStages

PACE_THREADS, NODE_THREADS = 128, 64
"""Threads of a block, as in `core/cuda`."""


class RunAhead:
    """The steps that one set of stages takes without the host."""

    def __init__(self, driver: Driver, precision: str) -> None:
        self._driver = driver
        self._layout = control_of(precision)
        self._control = Buffer(driver, self._layout.itemsize)
        self._graph: tuple[bytes, Graph] | None = None
        self._launched: set[int] = set()
        self._most, self._dt = 1, 0.0

    def control(self, limits: StepLimits, blend: tuple[float, float], report: Any, seconds: float) -> Any:
        """Return the control struct before steps of at most `seconds` [s] in all; blend: of the model."""
        out = np.zeros((), self._layout)
        for name in LIMITS:
            out[f"limits_{name}"] = getattr(limits, name)
        for name in RATES:
            out[name] = getattr(report, name)
        out["flip_alpha"], out["flip_damping"] = blend
        out["remaining"] = seconds
        return out

    def take(
        self, stages: CudaStages, model: DeviceModel, grid: DeviceGrid, control: Any
    ) -> list[tuple[float, str]]:
        """Take steps until the GPU stops, or enough of them; return the dt of each [s], and what bound it.

        After a stop fewer are asked for the next time, since what is launched after it is for nothing.
        """
        wanted = min(self._most, MOST_STEPS, self._left(float(control["remaining"])))
        self._driver.upload(self._control.address, control.tobytes(), self._layout.itemsize)
        stages.step.control = self._control.address
        try:
            self._launch(stages, model, grid, wanted)
            self._driver.download(control.ctypes.data, self._control.address, self._layout.itemsize)
        finally:
            stages.step.control = 0
        taken, halt = int(control["taken"]), HALTS[int(control["halt"])]
        if halt == "none":
            self._most = 2 * wanted
        elif halt != "finished":
            self._most = max(1, taken)
        records = control["record"][:taken].tolist()
        self._dt = records[-1][0] if records else 0.0
        return [(dt, _core.step_bounds[bound]) for dt, bound, _ in records]

    def _left(self, seconds: float) -> int:
        """Return about how many steps are left."""
        return max(1, math.ceil(min(seconds / self._dt, MOST_STEPS))) if self._dt > 0 else 1

    def _launch(self, stages: CudaStages, model: DeviceModel, grid: DeviceGrid, count: int) -> None:
        """Launch so many steps: as a graph, but for the first time, when kernels are still being loaded."""

        def one_step() -> None:
            stages.launch(model, "pace_step", 1, PACE_THREADS)
            stages.launch(model, "clear_nodes", grid.blocks, NODE_THREADS)
            stages.launch_step(model, grid)

        kernels = id(model.kernels())
        graph = self._graph_of(stages, kernels, one_step) if kernels in self._launched else None
        for _ in range(count):
            if graph is None:
                one_step()
            else:
                graph.launch()
        stages.launch(model, "pace_step", 1, PACE_THREADS)
        self._launched.add(kernels)

    def _graph_of(self, stages: CudaStages, kernels: int, one_step: Callable[[], None]) -> Graph | None:
        """Return the graph of a step, made anew where something has moved since; None without graphs."""
        given = bytes(stages.step) + kernels.to_bytes(8, "little")
        if self._graph is None or self._graph[0] != given:
            graph = self._driver.captured(one_step)
            if graph is None:
                return None
            self._graph = (given, graph)
        return self._graph[1]
