"""How the domains of a run tell each other of their borders.

A process has one or more of the domains. What a method is given and returns is of those; a transport of
several processes would carry the rest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Route = tuple[int, int]
"""From one domain to another, by their numbers."""


class Piece(NamedTuple):
    """Memory of a domain, wherever the domain is computed: its address and its size [bytes]."""

    at: int
    size: int


class Pending(Protocol):
    """Pieces that are under way."""

    def finish(self) -> None:
        """Let what comes next in each domain of this process find what was sent to it."""
        ...


class Transport(Protocol):
    """Carry arrays and pieces of memory between domains, and join what they have found.

    Attributes:
        domains: how many there are
    """

    domains: int

    def swap(self, sent: Mapping[Route, NDArray[Any]]) -> Mapping[Route, NDArray[Any]]:
        """Send arrays; return those that were sent to the domains of this process."""
        ...

    def begin(self, sent: Mapping[Route, Piece], received: Mapping[Route, Piece]) -> Pending:
        """Begin to copy each piece that is sent to where its route is received, of the same size.

        What has been started in the domains before is done before; what is started after it may run
        meanwhile, but must leave these pieces alone.
        """
        ...

    def most(self, found: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Return the maximum over all domains, number by number; found: of those of this process."""
        ...

    def total(self, found: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Return the sum over all domains in the order of their numbers; found: of those of this process."""
        ...


class OneProcess:
    """The transport of a process that has all domains: arrays are handed over as they are."""

    def __init__(self, domains: int) -> None:
        self.domains = domains

    def swap(self, sent: Mapping[Route, NDArray[Any]]) -> Mapping[Route, NDArray[Any]]:
        """Return what was sent."""
        return sent

    def most(self, found: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Return the maximum, number by number."""
        return np.asarray(np.maximum.reduce(list(found)))

    def total(self, found: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Return the sum, one domain after another."""
        out = found[0].copy()
        for each in found[1:]:
            out += each
        return out
