"""What domains exchange in each step: the nodes that several of them have."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from neve.cuda.layout import ADD, ALL_COLOURS, BLOCK_NODES, COPY, TAKE
from neve.cuda.several.grid import BORDER, INTERIOR, UNION, DomainGrid, Listed
from neve.cuda.several.peers import Copies, Peers
from neve.domains.transport import Piece, Route

if TYPE_CHECKING:
    from neve.cuda.model import DeviceModel
    from neve.cuda.stages import CudaStages

NODE_THREADS = 64
"""Threads of a block, as in `core/cuda/grid/domain.hpp`."""


class Exchange:
    """Scatter from the particles of all domains, so that nodes hold the same sums wherever they are."""

    def __init__(self, stages: Sequence[CudaStages], peers: Peers, precision: str) -> None:
        self._stages, self._peers = stages, peers
        self._bytes = 4 * BLOCK_NODES * np.dtype(precision).itemsize

    def scatter(self, models: Sequence[DeviceModel], grid: DomainGrid) -> None:
        """Scatter; what is inside a domain while the nodes at its border are under way.

        Each domain adds what the domains have, its own included, in the order of their numbers.
        """
        self._scatter_from(models, grid, BORDER)
        self._peers.enter()
        pending = self._send(models, grid, {route: route for route in grid.routes})
        for d, lists in enumerate(grid.lists):
            own = lists[UNION]
            self._launch(models, d, "pack_halo", own, grid.packed((d, d), self._size(models[d], own)), TAKE)
        self._scatter_from(models, grid, INTERIOR)
        pending.finish()
        for there, lists in enumerate(grid.lists):
            own = lists[UNION]
            for here in sorted({there, *(d for d, e in grid.routes if e == there)}):
                if here == there:
                    self._launch(models, there, "unpack_halo", own, grid.packed((there, there), 0), ADD)
                else:
                    route = here, there
                    self._launch(models, there, "unpack_halo", lists[route], grid.arriving(route, 0), ADD)
        self._peers.leave()

    def _scatter_from(self, models: Sequence[DeviceModel], grid: DomainGrid, homes: str) -> None:
        for model, stages, lists in zip(models, self._stages, grid.lists, strict=True):
            for name in stages.scatters:
                stages.scatter_some(model, name, lists[homes])

    def scatter_in_order(self, models: Sequence[DeviceModel], grid: DomainGrid) -> None:
        """Scatter colour by colour: to each node come the same numbers in the same order as on one GPU.

        One home of a colour covers a block. After the turn of the colour its domain gives what the nodes
        have now to the others.
        """
        for name in self._stages[0].scatters:
            for colour in range(ALL_COLOURS):
                for d, stages in enumerate(self._stages):
                    stages.scatter_colour(models[d], name, grid.parts[d], colour)
                self._peers.enter()
                self._send(models, grid, {route: (*route, colour) for route in grid.routes}).finish()
                for route in grid.routes:
                    listed = grid.lists[route[1]][*route, colour]
                    self._launch(models, route[1], "unpack_halo", listed, grid.arriving(route, 0), COPY)
                self._peers.leave()

    def _send(
        self, models: Sequence[DeviceModel], grid: DomainGrid, names: Mapping[Route, Hashable]
    ) -> Copies:
        """Pack for each route the nodes of the list of that name, and begin to copy them."""
        sent, received = {}, {}
        for route, name in names.items():
            lists = grid.lists[route[0]]
            room, size = (self._size(models[route[0]], lists[word]) for word in (route, name))
            sent[route] = Piece(grid.packed(route, room), size)
            received[route] = Piece(grid.arriving(route, room), size)
            self._launch(models, route[0], "pack_halo", lists[name], sent[route].at, COPY)
        return self._peers.begin(sent, received)

    def _launch(
        self, models: Sequence[DeviceModel], d: int, name: str, listed: Listed, values: int, meeting: int
    ) -> None:
        """Start a kernel for a list of blocks on the lane of a domain."""
        stages, halo = self._stages[d], self._stages[d].step.halo
        halo.blocks, halo.count = listed
        halo.values, halo.meeting = values, meeting
        with stages.driver.on(self._peers.lanes[d]):
            stages.launch(models[d], name, halo.count, NODE_THREADS)

    def _size(self, model: DeviceModel, listed: Listed) -> int:
        """Return the size of all that the nodes of a list of blocks have [bytes]."""
        return self._bytes * (1 + bool(model.has_force) + bool(model.has_play)) * listed[1]
