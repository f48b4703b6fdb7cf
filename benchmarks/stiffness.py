"""Time slow loads on snow, explicit and implicit, over its stiffness: a layer, an oedometer, a plate.

    python benchmarks/stiffness.py [layer oedometer plate] [--cells 8] [--last 1e9] [--dt-max 1e-3]

For each Young's modulus and integrator: processor seconds for a simulated second (one thread), steps, and
what was measured. All are blocks of `--cells` cells height, 0.4 m.

    layer       elastic snow settles under its weight between smooth walls: how far the top has sunk over
                rho g H^2 / (2 M_c); of explicit steps, which go on to swing, the mean over all of them,
                weighted by sin^2, of which N swings leave 1 / (pi N^3) of their size
    oedometer   snow that yields is pressed by half of its height a second: the axial stress at the end over
                known answer 13
    plate       a plate half as wide as the snow is pushed into it by 0.1 m/s: its mean force over the last
                half of the time, over that of explicit steps
"""

from __future__ import annotations

import argparse
import time
from typing import Any, NamedTuple

import numpy as np

from neve.simulation import Simulation
from neve.validate.scenes import (
    box,
    column,
    duct,
    elastic,
    moduli,
    plane,
    simulation,
    stress,
)
from neve.validate.snow import oedometer

HEIGHT, RHO, NU, G = 0.4, 400.0, 0.2, 9.81
INTEGRATORS = ("explicit", "semi_implicit", "implicit")


class Run(NamedTuple):
    """A run: processor seconds for a simulated one, steps, and what was measured (see above)."""

    spent: float
    steps: int
    measured: float


def layer(E0: float, cells: int, seconds: float, **numerics: Any) -> Run:
    """Let a layer settle."""
    h = HEIGHT / cells
    sim = simulation(
        [box((0, 0, 0), (HEIGHT, HEIGHT, HEIGHT))],
        [*duct(HEIGHT, HEIGHT), plane((0, 0, 0), (0, 0, 1))],
        snow=elastic(E0=E0, nu=NU, rho0=RHO),
        gravity=(0.0, 0.0, -G),
        dx=h,
        **numerics,
    )
    start = column(sim, "x")[:, 2]
    top = start > HEIGHT - h
    times: list[float] = []
    sunk: list[float] = []
    looking = 0.0

    def look() -> bool:
        nonlocal looking
        begun = time.process_time()
        times.append(sim.time)
        sunk.append(float((start - column(sim, "x")[:, 2])[top].mean()))
        looking += time.process_time() - begun
        return False

    begun = time.process_time()
    sim.advance(seconds, look)
    spent = (time.process_time() - begun - looking) / seconds
    measured = sunk[-1]
    if numerics["integrator"] == "explicit":
        measured = float(np.average(sunk, weights=np.sin(np.pi * np.array(times) / sim.time) ** 2))
    return Run(spent, sim.steps, measured / (RHO * G * HEIGHT**2 / (2 * moduli(E0, NU)[2])))


def press(E0: float, cells: int, seconds: float, **numerics: Any) -> Run:
    """Press snow in an oedometer, which begins with the velocities of even compression."""
    h, rate = HEIGHT / cells, 0.5
    sim = simulation(
        [box((0, 0, 0), (HEIGHT, HEIGHT, HEIGHT))],
        [
            *duct(HEIGHT, HEIGHT),
            plane((0, 0, 0), (0, 0, 1)),
            plane((0, 0, HEIGHT), (0, 0, -1), velocity=[0.0, 0.0, -rate * HEIGHT]),
        ],
        snow={"E0": E0},
        dx=h,
        **numerics,
    )
    sim.state.v[:, 2] = -rate * np.asarray(sim.state.x)[:, 2]
    sim.state.C[:, 2, 2] = -rate
    middle = np.abs(column(sim, "x")[:, 2] / HEIGHT - 0.5) < 0.25
    spent = _advance(sim, seconds)
    s = 1 - rate * seconds
    answer = oedometer.answer(np.array([s]))[0][0] * E0 / oedometer.E0
    return Run(spent, sim.steps, float(stress(sim)[middle, 2, 2].mean() / s / answer))


def push(E0: float, cells: int, seconds: float, **numerics: Any) -> Run:
    """Push a plate into snow; what is measured is the force [N]."""
    h = HEIGHT / cells
    sim = simulation(
        [box((0, 0, 0), (HEIGHT, HEIGHT, HEIGHT))],
        [
            *duct(HEIGHT, HEIGHT),
            plane((0, 0, 0), (0, 0, 1)),
            {
                "shape": "box",
                "size": [HEIGHT / 2, HEIGHT / 2, 2 * h],
                "center": [HEIGHT / 2, HEIGHT / 2, HEIGHT + h],
                "velocity": [0.0, 0.0, -0.1],
                "mode": "separate",
                "mu_c": 0.3,
            },
        ],
        snow={"E0": E0},
        gravity=(0.0, 0.0, -G),
        dx=h,
        **numerics,
    )
    spent = _advance(sim, seconds / 2)
    before = float(sim.exchanged[-1, 2])
    spent = (spent + _advance(sim, seconds / 2)) / 2
    return Run(spent, sim.steps, (float(sim.exchanged[-1, 2]) - before) / (seconds / 2))


def _advance(sim: Simulation, seconds: float) -> float:
    """Return processor seconds for a simulated one."""
    begun = time.process_time()
    sim.advance(seconds)
    return (time.process_time() - begun) / seconds


CASES = {"layer": layer, "oedometer": press, "plate": push}


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cases", nargs="*", help=f"of {', '.join(CASES)}; all")
    parser.add_argument("--cells", type=int, default=8, help="height and width of the snow [cells]")
    parser.add_argument("--seconds", type=float, default=0.1, help="simulated time [s]")
    parser.add_argument("--first", type=float, default=1e6, help="smallest Young's modulus [Pa]")
    parser.add_argument("--last", type=float, default=1e9, help="largest Young's modulus [Pa]")
    parser.add_argument("--dt-max", type=float, default=1e-2, help="longest step [s]")
    parser.add_argument("--sampling", default="regular", help="of the particles, or jittered")
    given = parser.parse_args()
    powers = range(round(np.log10(given.first)), int(np.log10(given.last) + 1e-9) + 1)
    print("case       E0 [Pa]   integrator      CPU s / s   steps   measured   over explicit")
    for case in given.cases or CASES:
        for E0 in (10.0**power for power in powers):
            runs = {
                word: CASES[case](
                    E0,
                    given.cells,
                    given.seconds,
                    integrator=word,
                    dt_max=given.dt_max,
                    sampling=given.sampling,
                )
                for word in INTEGRATORS
            }
            whole = runs["explicit"]
            for word, run in runs.items():
                measured = run.measured / whole.measured if case == "plate" else run.measured
                print(
                    f"{case:<10} {E0:<9.0e} {word:<14} {run.spent:10.2f} {run.steps:7d} {measured:10.4f} "
                    f"{whole.spent / run.spent:15.1f}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
