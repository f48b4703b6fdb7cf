"""How long a step over ranks takes: a for each particle, b for each block of the halo, c for messages.

    mpirun -n 2 python benchmarks/ranks_model.py latency       # a message, a maximum, and to copy a block
    python benchmarks/ranks_model.py table A B MESSAGE MAXIMUM   # from figures in ns

A cube of snow, 8 particles a cell, is shared out along the curve as a run does it. A step takes as long as
that of the rank with most blocks in its halo: a particles + b blocks + 26 messages + 2 log2(ranks) maxima.
"""

import argparse
import math
import time

import numpy as np

from neve import _core
from neve.domains.halo import CORNERS, keys_of
from neve.ranks.ownership import cuts_of

HOME_PARTICLES = 512
NEIGHBOURS = 26
ROW_BYTES = 146
"""Of a particle in float32, without sleep and heat."""


def halo_of_a_cube(edge, ranks):
    """The most node blocks that a rank gives in each step, of a cube of edge^3 homes."""
    at = np.stack(np.meshgrid(*[np.arange(edge, dtype=np.int32)] * 3, indexing="ij"), -1).reshape(-1, 3)
    core = _core.f32.ranks
    keys = keys_of(at).astype(np.uint64)
    cuts = cuts_of(core.curve(keys), np.ones(len(keys)), ranks)
    owners = core.owners(keys, cuts).reshape((edge,) * 3)
    padded = np.full((edge + 2,) * 3, -1, np.int32)
    padded[1:-1, 1:-1, 1:-1] = owners
    given = np.zeros(ranks, np.int64)
    mine = padded[1:-1, 1:-1, 1:-1]
    for corner in CORNERS:  # a block of my tile, and the homes that cover it
        covers = np.stack([_shifted(padded, corner - other, edge) for other in CORNERS], -1)
        covers = np.sort(np.where(covers == mine[..., None], -1, covers), -1)
        others = (covers[..., 1:] != covers[..., :-1]) & (covers[..., 1:] >= 0)
        count = others.sum(-1) + (covers[..., 0] >= 0)
        np.add.at(given, mine.reshape(-1), count.reshape(-1))
    return int(given.max())


def _shifted(padded, by, edge):
    x, y, z = (slice(1 + d, 1 + d + edge) for d in by)
    return padded[x, y, z]


def shape_factor(ranks, homes=64):
    """Blocks in the halo of a rank over the two-thirds power of its homes."""
    edge = round((homes * ranks) ** (1 / 3))
    return halo_of_a_cube(edge, ranks) / (edge**3 / ranks) ** (2 / 3)


def table(a, b, message, maximum):
    """Print predictions; all in ns."""
    print("| particles | ranks | of a rank | its halo [MB] | step [ms] | efficiency | its particles [GB] |")
    print("|---|---|---|---|---|---|---|")
    for ranks in (64, 4096):
        factor = shape_factor(ranks)
        for particles in (4e7, 1e9):
            n = particles / ranks
            blocks = factor * (n / HOME_PARTICLES) ** (2 / 3)
            work = a * n
            whole = work + b * blocks + NEIGHBOURS * message + 2 * math.log2(ranks) * maximum
            print(
                f"| {particles:,.0f} | {ranks:,} | {n:,.0f} | {blocks / 1e3:.2g} | {whole / 1e6:.3g} | "
                f"{work / whole:.0%} | {ROW_BYTES * n / 1e9:.2g} |"
            )


def latency():
    """Print the least times of a small message, of a maximum, and to copy a block of the halo [ns]."""
    from neve.domains.transport import Piece
    from neve.ranks.world import world

    ours = world()
    me, other = ours.rank, 1 - ours.rank
    sizes = {1: 1024, 512: 512 * 1024}
    out = {}
    for blocks, size in sizes.items():
        sent, received = np.zeros(size, np.uint8), np.zeros(size, np.uint8)
        pieces = [
            {(me, other): Piece(sent.ctypes.data, size)},
            {(other, me): Piece(received.ctypes.data, size)},
        ]
        out[blocks] = _least(lambda pieces=pieces: ours.transport.begin(*pieces).finish(), ours)
    most = _least(lambda: ours.most([0.0] * 11), ours)
    if ours.leads:
        print(f"message {out[1]:.0f} ns, maximum {most:.0f} ns, block {(out[512] - out[1]) / 511:.1f} ns")


def _least(call, ours, batches=200, calls=50):
    best = math.inf
    for _ in range(batches):
        ours.comm.Barrier()
        start = time.perf_counter()
        for _ in range(calls):
            call()
        best = min(best, (time.perf_counter() - start) / calls)
    return 1e9 * best


def main():
    """Measure, or print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("latency", "table"))
    parser.add_argument("costs", nargs="*", type=float)
    arguments = parser.parse_args()
    if arguments.what == "latency":
        latency()
    else:
        table(*arguments.costs)


if __name__ == "__main__":
    main()
