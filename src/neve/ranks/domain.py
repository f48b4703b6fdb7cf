"""The piece of space that this rank owns: particles that come and go, and nodes that others have too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.domains.transport import Piece, Route
from neve.ranks.ownership import UNEVEN, Keys, cuts_of, work_of
from neve.ranks.world import World
from neve.stage_timer import StageTimer

if TYPE_CHECKING:
    from neve._core import Grid, GridReport, Ranks, State
    from neve.mpm.model import Model

_NO_KEYS = np.zeros(0, np.uint64)
LEDGER = np.dtype([("block", "u8"), ("step", "u4"), ("part", "i2"), ("solid", "i2"), ("exchange", "f8", 7)])
"""A row of the ledger of exchanges with solids, as `core/cpu/grid/halo.hpp` has it."""


@dataclass(frozen=True)
class Layout:
    """What this rank exchanges with each neighbour until the next sort: numbers of node blocks."""

    neighbours: Sequence[int]
    given: Sequence[int]
    taken: Sequence[int]


class Tally(NamedTuple):
    """How a rank takes part in a run, since it joined.

    particles, homes: that it owns now. border: homes that give to nodes of others. halo_blocks, halo_bytes:
    node blocks and bytes that it sends in each step now. migrated: particles sent away. rebalanced: how often
    shares were chosen anew. exchanging, gathering: wall time in the halo, with waiting for others, and in the
    gathering after frames [s]. seconds: wall time of the stages of the last frame [s]
    """

    particles: int
    homes: int
    border: int
    halo_blocks: int
    halo_bytes: int
    migrated: int
    rebalanced: int
    exchanging: float
    gathering: float
    seconds: Mapping[str, float]


class Domain:
    """Exchange with the other ranks what the stages of a step need.

    Attributes:
        cuts: where the ranks but the first begin on the curve, (ranks - 1,)
        counted: node blocks in use that no lower rank has
    """

    def __init__(self, world: World, core: Ranks, cuts: Keys) -> None:
        self.world, self.core, self.cuts = world, core, cuts
        self._layout = Layout((), (), ())
        self._uneven = 1.0
        self._homes = _NO_KEYS
        self.counted = self._migrated = self._rebalanced = 0
        self._timer = StageTimer(("exchanging", "gathering"))

    # At a sort

    def find_owners(self, model: Model, state: State) -> None:
        """Find the blocks that the particles are in now. Errors: ValueError for a lost particle."""
        self._homes = self.core.homes_now(model.native, state)

    def migrate(self, state: State, grid: Grid) -> None:
        """Send particles to the ranks that own their blocks."""
        if self._uneven > UNEVEN:
            self._choose_cuts(grid)
        owners = self.core.owners(self._homes, self.cuts)
        rows = np.flatnonzero(owners != self.world.rank).astype(np.uint32)
        self._swap_particles(state, grid, rows, owners[rows])
        self._migrated += len(rows)

    def _choose_cuts(self, grid: Grid) -> None:
        """Choose cuts by the work of the blocks at the last sort."""
        keys, counts = self.core.homes(grid)
        each = self.world.comm.allgather((self.core.curve(keys), work_of(counts)))
        curve, work = (np.concatenate(parts) for parts in zip(*each, strict=True))
        self.cuts = cuts_of(curve, work, self.world.size)
        self._rebalanced += 1

    def _swap_particles(
        self, state: State, grid: Grid, rows: NDArray[np.uint32], to: NDArray[np.int32]
    ) -> None:
        """Let the particles at `rows` go to these ranks, and others come."""
        me, core = self.world.rank, self.core
        sent: dict[Route, NDArray[Any]] = {}
        for other in np.unique(to).tolist():
            going = rows[to == other]
            parts = core.homes_then(grid, going), going, core.pack(state, going)
            sent[me, other] = np.concatenate([part.view(np.uint8) for part in parts])
        received = self.world.transport.swap(sent)
        if not (sent or received):
            return
        core.note_order(state, grid)
        core.depart(state, grid, rows)
        size = core.row_bytes(state) + 12
        for _, data in sorted(received.items()):
            n = len(data) // size
            core.arrive(
                state,
                grid,
                data[: 8 * n].view(np.uint64),
                data[8 * n : 12 * n].view(np.uint32),
                data[12 * n :],
            )

    def after_sort(self, state: State, grid: Grid) -> None:
        """Find out with whom this rank shares nodes now, and agree on what all need to know."""
        me, core = self.world.rank, self.core
        ranks, keys = core.border(grid, self.cuts, me)
        mine = {(me, other): keys[ranks == other] for other in np.unique(ranks).tolist()}
        theirs = self.world.transport.swap(mine)
        neighbours = [to for _, to in sorted(mine) if (to, me) in theirs]
        counts = core.lay_halo(
            grid,
            [other < me for other in neighbours],
            [mine[me, other] for other in neighbours],
            [theirs[other, me] for other in neighbours],
        )
        self._layout = Layout(neighbours, [given for given, _ in counts], [taken for _, taken in counts])
        self._agree(state, grid)

    def _agree(self, state: State, grid: Grid) -> None:
        """Take over the lightest particle of all, and see how unevenly they are shared out."""
        _, counts = self.core.homes(grid)
        work = float(work_of(counts).sum())
        lightest = self.core.lightest(grid) if state.count else np.inf
        lightest, most = (self.world.most([-lightest, work]) * (-1.0, 1.0)).tolist()
        mean = float(self.world.transport.total([np.array([work])])[0]) / self.world.size
        self._uneven = most / mean if mean > 0 else 1.0
        self.core.set_lightest(grid, lightest)
        self.counted = self.core.counted(grid)

    # In a step

    def exchange(self, grid: Grid) -> None:
        """Give to the neighbours what this rank's border adds to their nodes, and take what they give."""
        sent_at, received_at, size = self.core.pieces(grid)
        sent: dict[Route, Piece] = {}
        received: dict[Route, Piece] = {}
        me, layout = self.world.rank, self._layout
        for other, given, taken in zip(layout.neighbours, layout.given, layout.taken, strict=True):
            if given:
                sent[me, other] = Piece(sent_at, given * size)
            if taken:
                received[other, me] = Piece(received_at, taken * size)
            sent_at, received_at = sent_at + given * size, received_at + taken * size
        with self._timer.stage("exchanging"):
            self.world.transport.begin(sent, received).finish()

    def update_grid(self, model: Model, grid: Grid, dt: float) -> GridReport:
        """Turn momenta into velocities where there are bodies.

        Each rank finds those of the bodies from all nodes near them: all have the same bodies, to the bit.
        """
        each = self.world.comm.allgather(self.core.update_nodes(model.native, grid, dt))
        keys = np.concatenate([keys for keys, _ in each])
        order = np.argsort(keys)
        values = np.concatenate([values for _, values in each])
        if len(keys):
            values = values.reshape(len(keys), -1)[order].reshape(-1)
        return self.core.meet_bodies(model.native, grid, dt, keys[order], values)

    def unsort(self, grid: Grid) -> None:
        """Let the next step sort: a particle has left its block, here or elsewhere."""
        self.core.unsort(grid)

    def tally(self, grid: Grid, seconds: Mapping[str, float]) -> Tally:
        """Return how this rank takes part; seconds: of the stages of the last frame."""
        _, counts = self.core.homes(grid)
        blocks = sum(self._layout.given)
        return Tally(
            int(counts.sum()),
            len(counts),
            self.core.border_homes(grid),
            blocks,
            blocks * self.core.pieces(grid)[2],
            self._migrated,
            self._rebalanced,
            **self._timer.seconds,
            seconds=dict(seconds),
        )

    def exchanged(self, grid: Grid, solids: int, to_all: bool) -> NDArray[np.float64]:
        """Return what snow and solids exchanged since the last call, (solids, 7), added up as on one rank.

        to_all: whether all ranks need it; otherwise the leader alone has it, and others get zeros.
        """
        mine = self.core.take_ledger(grid)
        comm = self.world.comm
        parts = comm.allgather(mine) if to_all else comm.gather(mine)
        total = np.zeros((solids, 7))
        if parts is None:
            return total
        rows = np.concatenate(parts).view(LEDGER)
        rows = rows[np.lexsort((rows["block"], rows["part"], rows["step"]))]
        np.add.at(total, rows["solid"], rows["exchange"])
        return total

    # At the end of a frame

    def gather(self, state: State, grid: Grid, whole: State | None) -> None:
        """Copy the particles of all ranks into `whole`, in the order of one rank; None on the others."""
        with self._timer.stage("gathering"):
            self._gather(state, grid, whole)

    def _gather(self, state: State, grid: Grid, whole: State | None) -> None:
        keys, counts = self.core.homes(grid)
        rows = np.arange(state.count, dtype=np.uint32)
        homes = self.world.comm.gather((keys, counts))
        transport = self.world.transport
        if whole is None:
            transport.send(self.core.pack(state, rows), 0)
            return
        for rank, places in enumerate(_places(homes)):
            data = self.core.pack(state, rows) if rank == self.world.rank else transport.receive(rank)
            self.core.unpack(whole, places, data)


def _places(homes: Sequence[tuple[Keys, NDArray[np.uint32]]]) -> list[NDArray[np.uint32]]:
    """Return the rows that the particles of each rank have where all homes stand by rising key."""
    keys = np.concatenate([keys for keys, _ in homes])
    counts = np.concatenate([counts for _, counts in homes]).astype(np.int64)
    order = np.argsort(keys)
    begins = np.empty(len(keys), np.int64)
    begins[order] = np.cumsum(counts[order]) - counts[order]
    out, first = [], 0
    for mine, _ in homes:
        these = slice(first, first + len(mine))
        n = counts[these]
        within = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n, n)
        out.append((np.repeat(begins[these], n) + within).astype(np.uint32))
        first = these.stop
    return out


def dealt(
    arrays: Mapping[str, NDArray[Any]], owners: NDArray[np.int32], rank: int, columns: Sequence[str]
) -> dict[str, NDArray[Any]]:
    """Return the arrays of a state with the particles of one rank alone; the others stand as they are."""
    rows = np.flatnonzero(owners == rank)
    return {name: value[rows] if name in columns else value for name, value in arrays.items()}
