"""Change one constant from run to run and tabulate what becomes of the snow.

    python examples/04_sweep.py                          # four runs, a few seconds

A block of snow hits the ground at 4 m/s: the more the snow hardens, the less it is crushed.
"""

import sys

import numpy as np

import neve
from neve.scene import scene_from

BLOCK = {
    "numerics": {"dx": 0.08},
    "sources": [{"shape": "box", "size": [0.8, 0.8, 0.8], "center": [0.0, 0.0, 0.7], "velocity": [0, 0, -4]}],
    "colliders": [{"shape": "plane", "mu_c": 0.4}],
}
HARDENING = (2.5, 5.0, 10.0, 20.0)
END = 0.5  # simulated time [s]


def main(changes: list[str]) -> None:
    """Run the block with each hardening coefficient, and print height, width and compaction."""
    print(f"{'xi':>6} {'height [m]':>11} {'width [m]':>10} {'mean J_P':>9}")
    for xi in HARDENING:
        sim = neve.Simulation(scene_from(BLOCK, [f"snow.xi={xi}", *changes]))
        sim.advance(END)
        x = np.asarray(sim.state.x)
        low, high = np.percentile(x, (1, 99), axis=0)  # a few crumbs are not the block
        print(f"{xi:6g} {high[2]:11.3f} {high[0] - low[0]:10.3f} {np.mean(sim.state.J_P):9.4f}")


if __name__ == "__main__":
    main(sys.argv[1:])
