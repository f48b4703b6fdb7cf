"""Sort the particles on the GPU by home block and cell, and number the blocks of nodes that homes cover."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from neve.cuda.steps.reports import NOBODY, extremes

if TYPE_CHECKING:
    from neve.cuda.grid import DeviceGrid
    from neve.cuda.model import DeviceModel
    from neve.cuda.stages import CudaStages
    from neve.cuda.state import DeviceState

SORT_THREADS, SCAN_THREADS = 128, 256
"""Threads of a block, as in `core/cuda/grid/sort.hpp`."""


def sort(stages: CudaStages, model: DeviceModel, state: DeviceState, grid: DeviceGrid) -> None:
    """Sort the particles, and lay out the grid. Errors: ValueError, DeviceError."""
    step, count = stages.prepare(model, state, grid, 0.0), state.count
    grid.current = grid.scattered = False
    grid.fill_sorting(step.sorting, count)
    _find_homes(stages, model, state, grid)
    step.home_count = grid.homes
    grid.fill_homes(step.nodes)
    _sort_homes(stages, model, grid)
    stages.each(model, "rank_homes", grid.homes)
    stages.each(model, "count_homes", count)
    stages.launch(model, "scan_homes", min(grid.homes, 1), SCAN_THREADS)
    stages.each(model, "place_particles", count)
    stages.launch(model, "order_homes", grid.homes, SORT_THREADS)
    permute(stages, model, state)
    state.moved()
    _find_blocks(stages, model, grid)
    grid.count, grid.current = count, True


def permute(stages: CudaStages, model: DeviceModel, state: DeviceState) -> None:
    """Put the rows in the order that `step.sorting.order` has."""
    sorting = stages.step.sorting
    for sorting.width, sorting.from_, sorting.to in state.each_column():
        stages.each(model, "permute", state.count)
    state.fill(stages.step.particles)


def _find_homes(stages: CudaStages, model: DeviceModel, state: DeviceState, grid: DeviceGrid) -> None:
    """Number the homes; a table that is too small is enlarged."""
    step = stages.step
    while True:
        step.results = grid.clear_results()
        grid.home_table.clear(step.sorting.homes, grid.counter("homes"))
        stages.each(model, "find_homes", state.count)
        found = stages.found(grid, "sort")
        if not found["full"]:
            break
        grid.home_table.capacity *= 4
    if found["lost"]:
        raise ValueError(_lost(state, int(found["lost"]) ^ NOBODY))
    grid.homes = int(found["homes"])
    grid.lightest = -extremes(found)["less_mass"] if state.count else 0.0


def _lost(state: DeviceState, number: int) -> str:
    row = int(np.flatnonzero(np.asarray(state.id) == number)[0])
    where = ", ".join(f"{a:f}" for a in np.asarray(state.x)[row])
    return f"particle {number} at ({where}) m is beyond the lattice"


def _sort_homes(stages: CudaStages, model: DeviceModel, grid: DeviceGrid) -> None:
    sorting, run = stages.step.sorting, 2
    while run // 2 < grid.homes:
        spans = [run - 1]
        while run >> (len(spans) + 1) > 0:
            spans.append(run >> (len(spans) + 1))
        for sorting.span in spans:
            stages.each(model, "sort_homes", grid.homes)
        run *= 2


def _find_blocks(stages: CudaStages, model: DeviceModel, grid: DeviceGrid) -> None:
    """Number the blocks of nodes, and give them room."""
    step = stages.step
    while True:
        step.results = grid.clear_results()
        grid.block_table.clear(step.sorting.blocks, grid.counter("blocks"))
        stages.each(model, "find_blocks", 8 * grid.homes)
        found = stages.found(grid, "sort")
        if not found["full"]:
            break
        grid.block_table.capacity *= 4
    step.block_count = grid.blocks = int(found["blocks"])
    grid.fill_nodes(step.nodes, model)
    stages.each(model, "link_homes", 8 * grid.homes)
