"""Particles that leave the domain of one GPU go to that of another, before all are sorted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve.cuda.memory import Buffer
from neve.cuda.several.grid import DomainGrid
from neve.cuda.several.peers import Peers
from neve.cuda.steps.sorting import permute
from neve.domains.transport import Piece, Route

if TYPE_CHECKING:
    from neve.cuda.model import DeviceModel
    from neve.cuda.several.state import DomainState
    from neve.cuda.stages import CudaStages


class Migration:
    """Move particles to the domains that own their homes."""

    def __init__(self, stages: Sequence[CudaStages], peers: Peers) -> None:
        self._stages, self._peers = stages, peers
        self._cuts, self._counts, self._begins = (
            [Buffer(each.driver, 4 * len(stages)) for each in stages] for _ in range(3)
        )

    def move(self, models: Sequence[DeviceModel], state: DomainState, grid: DomainGrid) -> int:
        """Move them, and return how many have moved. Errors: DeviceError for too little memory."""
        leaving = [self._leaving(d, models[d], state, grid) for d in range(len(models))]
        moved = int(self._peers.total([each.sum(keepdims=True) for each in leaving])[0])
        if not moved:
            return 0
        counts = {
            (d, e): leaving[d][e : e + 1]
            for d in range(len(models))
            for e in np.flatnonzero(leaving[d]).tolist()
        }
        sent = self._packed(models, state, leaving)
        arriving = {
            route: Buffer(self._stages[route[1]].driver, int(count[0]) * state.parts[route[1]].row_bytes)
            for route, count in self._peers.swap(counts).items()
        }
        pieces = [{route: Piece(b.address, b.size) for route, b in each.items()} for each in (sent, arriving)]
        self._peers.enter()
        self._peers.begin(*pieces).finish()
        self._peers.leave()
        for route in sorted(arriving):
            part = state.parts[route[1]]
            part.append(arriving[route].address, arriving[route].size // part.row_bytes)
        state.place_rows()
        state.moved()
        return moved

    def _leaving(self, d: int, model: DeviceModel, state: DomainState, grid: DomainGrid) -> NDArray[np.int64]:
        """Return how many particles of domain d belong to each domain; to its own, 0: they stay."""
        stages, part, partition = self._stages[d], state.parts[d], state.partition
        assert partition is not None
        step = stages.prepare(model, part, grid.parts[d], 0.0)
        grid.parts[d].fill_sorting(step.sorting, part.count)
        cuts = np.array(partition.cuts, np.int32)
        stages.driver.upload(self._cuts[d].address, cuts.tobytes(), cuts.nbytes)
        stages.driver.fill(self._counts[d].address, 0, self._counts[d].size)
        to = step.domain
        to.cuts, to.counts, to.begins = (
            buffer[d].address for buffer in (self._cuts, self._counts, self._begins)
        )
        to.axis, to.number, to.domains = partition.axis, d, partition.domains
        stages.each(model, "find_owners", part.count)
        counts = np.zeros(partition.domains, np.uint32)
        stages.driver.download(counts.ctypes.data, self._counts[d].address, counts.nbytes)
        return counts.astype(np.int64)

    def _packed(
        self, models: Sequence[DeviceModel], state: DomainState, leaving: Sequence[NDArray[np.int64]]
    ) -> dict[Route, Buffer]:
        """Put the particles that leave behind those that stay, and then into a buffer for each route."""
        out = {}
        for d, (stages, part) in enumerate(zip(self._stages, state.parts, strict=True)):
            if not leaving[d].any():
                continue
            stay = part.count - int(leaving[d].sum())
            begins = (stay + np.cumsum(leaving[d]) - leaving[d]).astype(np.uint32)
            begins[d] = 0
            stages.driver.upload(self._begins[d].address, begins.tobytes(), begins.nbytes)
            stages.each(models[d], "part_particles", part.count)
            permute(stages, models[d], part)
            for e in np.flatnonzero(leaving[d]).tolist():
                count = int(leaving[d][e])
                out[d, e] = Buffer(stages.driver, count * part.row_bytes)
                part.take(out[d, e].address, int(begins[e]), count)
            part.count = stay
        return out
