"""How many ranks this process was started with, and which one it is; imports MPI only if there are others."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from contextlib import AbstractContextManager

_SIZES = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE")
_RANKS = ("OMPI_COMM_WORLD_RANK", "PMI_RANK")
_LOCAL_SIZES = ("OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS")
"""Variables that Open MPI and MPICH set for what `mpirun` starts."""


def size(environment: Mapping[str, str] = os.environ) -> int:
    """Return the number of ranks: 1 for a process that nobody started with others."""
    return _number(environment, _SIZES, 1)


def rank(environment: Mapping[str, str] = os.environ) -> int:
    """Return the number of this one, from 0 on."""
    return _number(environment, _RANKS, 0)


def leads(environment: Mapping[str, str] = os.environ) -> bool:
    """Return whether this rank leads the others, or is alone."""
    return size(environment) == 1 or rank(environment) == 0


def local_size(environment: Mapping[str, str] = os.environ) -> int:
    """Return how many of the ranks are on this machine, as far as it is known."""
    return _number(environment, _LOCAL_SIZES, size(environment))


def _number(environment: Mapping[str, str], names: tuple[str, ...], otherwise: int) -> int:
    for name in names:
        if environment.get(name, "").isdigit():
            return int(environment[name])
    return otherwise


def leading() -> AbstractContextManager[None]:
    """Lead the other ranks in the block, if there are any. Errors: RanksError without MPI."""
    if size() == 1:
        return contextlib.nullcontext()
    from neve.ranks.simulation import leading as lead

    return lead()


def follow() -> int:
    """Follow the leader, and return the exit code. Without MPI the leader says so."""
    from neve.ranks.simulation import follow as follow_leader
    from neve.ranks.world import RanksError

    try:
        return follow_leader()
    except RanksError:
        return 2
