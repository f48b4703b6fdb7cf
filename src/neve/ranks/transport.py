"""The transport of domains that are the ranks of an MPI launch, one each; see `neve.domains.transport`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.domains.transport import Piece, Route

_ARRAY, _PIECE = 2, 3
MOST = 2**30
"""Bytes of a message: an MPI counts them in 31 bits. What is longer goes in several, which come in order."""


class Copies:
    """Pieces that are under way."""

    def __init__(self, requests: Sequence[Any]) -> None:
        self._requests = requests

    def finish(self) -> None:
        """Wait until what was sent here has come, and what was sent from here may be written over."""
        for request in self._requests:
            request.Wait()


class Mpi:
    """Carry arrays and pieces of memory between ranks.

    Attributes:
        domains: how many ranks there are. sent: bytes of pieces that this one has sent so far
    """

    def __init__(self, comm: Any) -> None:
        from mpi4py import MPI

        self._comm, self._mpi = comm, MPI
        self.domains = int(comm.size)
        self.sent = 0

    def swap(self, sent: Mapping[Route, NDArray[Any]]) -> dict[Route, NDArray[Any]]:
        """Send arrays; return those that were sent to this rank. All ranks call it together."""
        me = int(self._comm.rank)
        heads: list[Any] = [None] * self.domains
        for (_, to), array in sent.items():
            heads[to] = array.shape, array.dtype.str
        received, requests, kept = {}, [], []
        for other, head in enumerate(self._comm.alltoall(heads)):
            if head is not None:
                received[other, me] = np.empty(head[0], np.dtype(head[1]))
                parts = _parts(received[other, me])
                requests += [self._comm.Irecv(part, other, _ARRAY) for part in parts]
        for (_, to), array in sent.items():
            kept.append(np.ascontiguousarray(array))
            requests += [self._comm.Isend(part, to, _ARRAY) for part in _parts(kept[-1])]
        Copies(requests).finish()
        return received

    def begin(self, sent: Mapping[Route, Piece], received: Mapping[Route, Piece]) -> Copies:
        """Begin to copy each piece that is sent to where its route is received, of the same size."""
        at = self._mpi.buffer.fromaddress
        requests = [
            self._comm.Irecv(at(*part), route[0], _PIECE)
            for route, piece in received.items()
            for part in _pieces(piece)
        ]
        requests += [
            self._comm.Isend(at(*part), route[1], _PIECE)
            for route, piece in sent.items()
            for part in _pieces(piece)
        ]
        self.sent += sum(piece.size for piece in sent.values())
        return Copies(requests)

    def most(self, found: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Return the maximum over all ranks, number by number."""
        out = np.empty_like(found[0])
        self._comm.Allreduce(np.maximum.reduce(list(found)), out, self._mpi.MAX)
        return out

    def total(self, found: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Return the sum over all ranks, one after another."""
        mine = np.add.reduce(list(found))
        each = np.empty((self.domains, *mine.shape), mine.dtype)
        self._comm.Allgather(np.ascontiguousarray(mine), each)
        out: NDArray[Any] = each[0].copy()
        for other in each[1:]:
            out += other
        return out

    def send(self, array: NDArray[Any], to: int) -> None:
        """Send one array to a rank that receives it."""
        whole = np.ascontiguousarray(array)
        self._comm.send((np.shape(array), whole.dtype.str), to, _ARRAY)
        for part in _parts(whole):
            self._comm.Send(part, to, _ARRAY)

    def receive(self, source: int) -> NDArray[Any]:
        """Return the array that a rank sends."""
        shape, kind = self._comm.recv(None, source, _ARRAY)
        array = np.empty(shape, np.dtype(kind))
        for part in _parts(array):
            self._comm.Recv(part, source, _ARRAY)
        return array


def _parts(array: NDArray[Any]) -> Iterator[NDArray[np.uint8]]:
    """Yield the bytes of an array, message by message; those of an empty one in one that is empty."""
    whole = array.reshape(-1).view(np.uint8)
    for begin in range(0, max(1, len(whole)), MOST):
        yield whole[begin : begin + MOST]


def _pieces(piece: Piece) -> Iterator[Piece]:
    """Yield a piece, message by message."""
    for begin in range(0, piece.size, MOST):
        yield Piece(piece.at + begin, min(MOST, piece.size - begin))
