"""Advance a scene over ranks, and keep what comes of it and how each rank took part.

mpirun -n 2 python shared.py SCENE OUT.npz THREADS UNEVEN BYTES

UNEVEN is the bound from which on shares are chosen anew, BYTES the most of a message.
"""

import sys
from pathlib import Path

import numpy as np

import neve
from neve.ranks import domain, launch, transport
from neve.ranks.simulation import RankSimulation, follow, leading

FRAMES, SECONDS = 2, 0.02
TAKEN = ("particles", "halo_blocks", "migrated", "rebalanced")


def main(scene, out, threads):
    """Advance two frames on the leader, and write the state and the tallies of all ranks."""
    with leading():
        sim = RankSimulation(neve.load(scene), threads=threads)
        for _ in range(FRAMES):
            sim.advance(SECONDS)
        tallies = sim.tallies()
        taken = {name: [getattr(each, name) for each in tallies] for name in TAKEN}
        np.savez(out, **taken, **sim.arrays())


if __name__ == "__main__":
    domain.UNEVEN, transport.MOST = float(sys.argv[4]), int(sys.argv[5])
    if launch.leads():
        main(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]))
    else:
        sys.exit(follow())
