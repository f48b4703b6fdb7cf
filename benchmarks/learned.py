"""Hold learned energies against the return map and explicit steps: a slope of snow and a ball that falls.

    python benchmarks/learned.py [--cells 6] [--seeds 2]

For each way and length of step: how far the slope [degrees] and the ball's height and width are from those of
explicit steps [%], and processor seconds, one thread. The heap is one of `stomakhin2013` soft enough to slide
(known answer 23 has its geometry); the ball of 0.3 m falls on the ground at 2 m/s, for 50 ms.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np

from neve.scene.reading.load import scene_from
from neve.simulation import Simulation
from neve.validate.grains.repose import repose

SNOW = {"law": "stomakhin2013", "E0": 2e4, "theta_c": 0.025, "theta_s": 0.004, "xi": 10.0}
WAYS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("explicit", {"integrator": "explicit"}),
    ("return map", {"integrator": "implicit", "implicit_strain": 1.0}),
    ("learned", {"integrator": "implicit", "implicit_strain": 1.0, "implicit_plasticity": "learned"}),
)


def slope(cells: int, seeds: int, **numerics: Any) -> float:
    """Return the mean slope of heaps [degrees]."""
    runs = [repose(25.0, cells, 0.5, snow=SNOW, seed=seed, **numerics) for seed in range(seeds)]
    return float(np.mean([run.angle for run in runs]))


def ball(**numerics: Any) -> np.ndarray:
    """Return the height of a ball's top and its width [m], after 50 ms on the ground."""
    sim = Simulation(
        scene_from(
            {
                "numerics": {"dx": 0.05, "precision": "float64"} | numerics,
                "sources": [
                    {"shape": "sphere", "radius": 0.15, "center": [0, 0, 0.15], "velocity": [0, 0, -2]}
                ],
                "colliders": [{"shape": "plane", "mu_c": 0.3}],
            }
        ),
        threads=1,
    )
    sim.advance(0.05)
    x = np.asarray(sim.state.x)
    return np.array([x[:, 2].max(), x[:, 0].std()])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cells", type=int, default=6, help="height of the heap [cells]")
    parser.add_argument("--seeds", type=int, default=2, help="heaps of each kind")
    given = parser.parse_args()
    print("way          dt [ms]   slope    error %   CPU s   ball height, width error %   CPU s")
    whole: tuple[float, np.ndarray] | None = None
    for name, how in WAYS:
        for dt in ("auto",) if name == "explicit" else (1e-3, 3e-3):
            begun = time.process_time()
            angle = slope(given.cells, given.seeds, dt=dt, **how)
            heap_seconds, begun = time.process_time() - begun, time.process_time()
            size = ball(dt=1e-4 if name == "explicit" else dt, **how)
            ball_seconds = time.process_time() - begun
            whole = whole or (angle, size)
            off = 100 * (size / whole[1] - 1)
            shown = dt if isinstance(dt, str) else f"{1e3 * dt:g}"
            print(
                f"{name:<12} {shown:>7} {angle:7.2f} {100 * (angle / whole[0] - 1):10.1f} {heap_seconds:7.1f}"
                f" {off[0]:12.2f} {off[1]:10.2f} {ball_seconds:13.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
