"""Run a scene over ranks that choose their shares anew at each sort, and keep what comes of it."""

import sys
from pathlib import Path

import numpy as np

import neve
from neve.ranks import domain, launch
from neve.ranks.simulation import RankSimulation, follow, leading


def main(scene, out):
    """Advance two frames on the leader, and write the state and how often shares were chosen."""
    with leading():
        sim = RankSimulation(neve.load(scene), threads=1)
        for _ in range(2):
            sim.advance(0.02)
        np.savez(out, rebalanced=[each.rebalanced for each in sim.tallies()], **sim.arrays())


domain.UNEVEN = 0.0
if launch.leads():
    main(Path(sys.argv[1]), sys.argv[2])
else:
    sys.exit(follow())
