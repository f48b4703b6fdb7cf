"""Run the same snow in Neve and in Taichi, batch by batch in turn, and print both speeds and their ratio.

    pip install . -r benchmarks/peers/requirements.txt
    python benchmarks/peers/compare.py [--particles 1m] [--batches 7] [--steps 20] [--json]

Both start from the same particles (a block landing on the ground at 5 m/s), take the same steps of the same
length with the same law, and are compared at the end: the mean position and velocity and the share of snow
that has flowed must agree, or the ratio is not printed. Compilation, set-up and first steps are not timed.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, sleep

import numpy as np
import taichi as ti

import neve
from neve.bench.run import BLOCKS, DT, cpu, landing_block
from neve.scene.schema.scene import Scene, Snow

sys.path.append(str(Path(__file__).parent))
from taichi_snow import J_P_BOUNDS, Case, TaichiSnow

MARGIN = (12, 12, 4)  # nodes of the dense grid around the block, and below the ground


def peer(sim: neve.Simulation) -> TaichiSnow:
    """Copy the particles of a new simulation into a Taichi program of the same scene."""
    scene, state = sim.scene, sim.state
    snow, numerics, ground = scene.snow, scene.numerics, scene.colliders[0]
    check(scene, snow)
    low = np.floor(state.x.min(axis=0) / numerics.dx).astype(int) - MARGIN
    high = np.ceil(state.x.max(axis=0) / numerics.dx).astype(int) + MARGIN
    case = Case(
        x=state.x, v=state.v, m=state.m, V0=state.V0, dx=numerics.dx, dt=float(numerics.dt),
        E0=snow.E0, nu=snow.nu, xi=snow.xi, theta_c=snow.theta_c, theta_s=snow.theta_s,
        gravity=scene.world.gravity[2], mu_c=ground.mu_c,
        low=low, shape=tuple(int(n) for n in high - low + 1),
    )  # fmt: skip
    return TaichiSnow(case)


def check(scene: Scene, snow: Snow) -> None:
    """Refuse a scene that the Taichi program would not run alike."""
    numerics, ground = scene.numerics, scene.colliders[0]
    alike = (
        (snow.J_P_min, snow.J_P_max) == J_P_BOUNDS
        and (numerics.spline, numerics.transfer, numerics.precision) == ("quadratic", "apic", "float32")
        and (ground.shape, ground.mode, ground.point, ground.normal)
        == ("plane", "separate", (0, 0, 0), (0, 0, 1))
        and scene.world.gravity[:2] == (0, 0)
        and len(scene.colliders) == 1
    )
    if not alike:
        raise SystemExit("the Taichi program does quadratic apic float32 on the ground z = 0 only")


def outcome(x: np.ndarray, v: np.ndarray, J_P: np.ndarray) -> dict[str, float]:
    """Return what the two must agree on: height, fall, spread, hardening, share that has flowed."""
    x, v = x.astype(np.float64), v.astype(np.float64)
    return {
        "mean z [m]": float(x[:, 2].mean()),
        "mean v_z [m/s]": float(v[:, 2].mean()),
        "rms v_x [m/s]": float(np.sqrt((v[:, 0] ** 2).mean())),
        "rms x [m]": float(np.sqrt((x[:, 0] ** 2).mean())),
        "mean J_P": float(J_P.mean(dtype=np.float64)),
        "flowed": float((np.abs(J_P - 1) > 1e-5).mean()),
    }


def timed(work: Callable[[], None]) -> float:
    """Return the wall time of `work` [s], after a pause in which the other's threads fall asleep."""
    sleep(0.2)
    begun = perf_counter()
    work()
    return perf_counter() - begun


def main() -> None:
    """Measure, check, print."""
    arguments = argparse.ArgumentParser(description="Neve against the same snow step in Taichi.")
    arguments.add_argument("--particles", choices=BLOCKS, default="1m")
    arguments.add_argument("--batches", type=int, default=7)
    arguments.add_argument("--steps", type=int, default=20, help="of a batch")
    arguments.add_argument("--warm", type=int, default=20, help="steps before the first batch")
    arguments.add_argument("--json", action="store_true")
    options = arguments.parse_args()

    ti.init(arch=ti.cpu, log_level=ti.WARN)
    sim = neve.Simulation(landing_block(BLOCKS[options.particles].cells))
    other = peer(sim)
    sim.advance(options.warm * DT)
    other.advance(options.warm)
    ours, theirs = [], []
    for _ in range(options.batches):
        ours.append(timed(lambda: sim.advance(options.steps * DT)))
        theirs.append(timed(lambda: other.advance(options.steps)))
    report(options, sim, other, ours, theirs)


def report(
    options: argparse.Namespace,
    sim: neve.Simulation,
    other: TaichiSnow,
    ours: list[float],
    theirs: list[float],
) -> None:
    """Print both speeds and their ratio, if both did the same work."""
    steps = options.warm + options.batches * options.steps
    here = outcome(sim.state.x, sim.state.v, sim.state.J_P)
    there = outcome(other.x.to_numpy(), other.v.to_numpy(), other.flowed())
    scale = {name: 1.0 if name == "flowed" else abs(value) for name, value in here.items()}
    off = {name: abs(here[name] - there[name]) / scale[name] for name in here}
    same = sim.steps == steps and max(off.values()) < 0.01
    work = sim.state.count * options.steps
    rates = {"neve": [work / t for t in ours], "taichi": [work / t for t in theirs]}
    ratios = [b / a for a, b in zip(ours, theirs, strict=True)]
    if options.json:
        facts = {"particles": sim.state.count, "steps": steps, "neve": here, "taichi": there, "same": same}
        print(json.dumps({"cpu": cpu(), **facts, "particle_steps_per_s": rates, "ratios": ratios}, indent=2))
    else:
        print(f"{cpu()}; {sim.state.count:,} particles, {options.batches} x {options.steps} steps in turn")
        for name, values in rates.items():
            low, mid, high = min(values) / 1e6, statistics.median(values) / 1e6, max(values) / 1e6
            print(f"  {name:7}{mid:8.2f} M particle-steps/s  ({low:.2f}-{high:.2f})")
        for name in here:
            print(f"  {name:15} neve {here[name]:11.6f}  taichi {there[name]:11.6f}  off {off[name]:.1e}")
    if not same:
        raise SystemExit("the two did not do the same work: no ratio")
    if not options.json:
        print(
            f"  neve / taichi = {statistics.median(ratios):.1f}x  ({min(ratios):.1f}-{max(ratios):.1f}, "
            "batch by batch)"
        )


if __name__ == "__main__":
    main()
