"""The transport between GPUs of one process: pieces are copied from one GPU to the other, beside the step."""

from __future__ import annotations

import contextlib
import weakref
from collections.abc import Callable, Mapping, Sequence
from itertools import permutations
from typing import Any

from neve.cuda.driver import Driver
from neve.cuda.errors import DriverError
from neve.domains.transport import OneProcess, Piece, Route


class Peers(OneProcess):
    """GPUs that copy to each other, each on a lane: a stream of its own, beside that of the step.

    Attributes:
        lanes: of each domain
    """

    def __init__(self, drivers: Sequence[Driver]) -> None:
        super().__init__(len(drivers))
        self._drivers = tuple(drivers)
        for driver, other in permutations(dict.fromkeys(drivers), 2):
            driver.meet(other)
        self.lanes = [driver.lane() for driver in drivers]
        self._fences = [driver.fence() for driver in drivers]
        self._sent = [driver.fence() for driver in drivers]
        for driver, lane, *fences in zip(drivers, self.lanes, self._fences, self._sent, strict=True):
            weakref.finalize(self, _give_back, driver.destroy_lane, lane)
            for fence in fences:
                weakref.finalize(self, _give_back, driver.destroy_fence, fence)

    def enter(self) -> None:
        """Let each lane wait for all that has been started on all GPUs so far, and for nothing later.

        On all: what a lane sends is written where another GPU may still read what came before.
        """
        for driver, fence in zip(self._drivers, self._fences, strict=True):
            driver.set_fence(fence)
        for driver, lane in zip(self._drivers, self.lanes, strict=True):
            for fence in self._fences:
                driver.wait_for(fence, lane)

    def leave(self) -> None:
        """Let what is started on the GPUs from now on wait for the lanes."""
        for driver, fence, lane in zip(self._drivers, self._fences, self.lanes, strict=True):
            driver.set_fence(fence, lane)
            driver.wait_for(fence)

    def begin(self, sent: Mapping[Route, Piece], received: Mapping[Route, Piece]) -> Copies:
        """Copy each piece on the lane of its sender, after what is there."""
        for route, piece in sent.items():
            here, there = route
            self._drivers[here].send(
                self._drivers[there], received[route].at, piece.at, piece.size, self.lanes[here]
            )
        for here in {here for here, _ in sent}:
            self._drivers[here].set_fence(self._sent[here], self.lanes[here])
        return Copies(self, tuple(sent))

    def arrive(self, route: Route) -> None:
        """Let the lane of the receiver wait for what the sender has sent."""
        here, there = route
        self._drivers[there].wait_for(self._sent[here], self.lanes[there])


class Copies:
    """Copies under way between GPUs."""

    def __init__(self, peers: Peers, routes: Sequence[Route]) -> None:
        self._peers, self._routes = peers, routes

    def finish(self) -> None:
        """Let what comes next on the lane of each receiver wait for them."""
        for route in self._routes:
            self._peers.arrive(route)


def _give_back(give: Callable[[Any], None], what: Any) -> None:
    with contextlib.suppress(DriverError):  # after a kernel has failed nothing can be given back
        give(what)
