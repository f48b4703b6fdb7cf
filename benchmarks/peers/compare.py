"""Run the same snow in Neve and in Taichi or Warp, batch by batch in turn, and print speeds and ratio.

    pip install . -r benchmarks/peers/requirements.txt
    python benchmarks/peers/compare.py [--peer warp] [--device cuda] [--particles 1m] [--json]

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
from typing import Any

import numpy as np

import neve
from neve.bench.run import BLOCKS, DT, cpu, landing_block

sys.path.append(str(Path(__file__).parent))
from case import case_of


def peer(name: str, device: str, sim: neve.Simulation) -> Any:
    """Return the same snow in a program of `name`, "taichi" or "warp", on `device`, "cpu" or "cuda"."""
    if name == "warp":
        from warp_snow import WarpSnow

        return WarpSnow(case_of(sim), device)
    import taichi as ti
    from taichi_snow import TaichiSnow

    ti.init(arch=ti.cuda if device == "cuda" else ti.cpu, log_level=ti.WARN)
    return TaichiSnow(case_of(sim))


def array(a: Any) -> np.ndarray:
    """Return an array of a peer."""
    return a.to_numpy() if hasattr(a, "to_numpy") else a.numpy()


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
    arguments = argparse.ArgumentParser(description="Neve against the same snow step in Taichi or Warp.")
    arguments.add_argument("--peer", choices=("taichi", "warp"), default="taichi")
    arguments.add_argument("--device", choices=("cpu", "cuda"), default="cpu")
    arguments.add_argument("--particles", choices=BLOCKS, default="1m")
    arguments.add_argument("--batches", type=int, default=7)
    arguments.add_argument("--steps", type=int, default=20, help="of a batch")
    arguments.add_argument("--warm", type=int, default=20, help="steps before the first batch")
    arguments.add_argument("--json", action="store_true")
    options = arguments.parse_args()

    sim = neve.Simulation(landing_block(BLOCKS[options.particles].cells, device=options.device))
    other = peer(options.peer, options.device, sim)
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
    other: Any,
    ours: list[float],
    theirs: list[float],
) -> None:
    """Print both speeds and their ratio, if both did the same work."""
    steps = options.warm + options.batches * options.steps
    here = outcome(sim.state.x, sim.state.v, sim.state.J_P)
    there = outcome(array(other.x), array(other.v), other.flowed())
    scale = {name: 1.0 if name == "flowed" else abs(value) for name, value in here.items()}
    off = {name: abs(here[name] - there[name]) / scale[name] for name in here}
    same = sim.steps == steps and max(off.values()) < 0.01
    work = sim.state.count * options.steps
    rates = {"neve": [work / t for t in ours], options.peer: [work / t for t in theirs]}
    ratios = [b / a for a, b in zip(ours, theirs, strict=True)]
    if options.json:
        facts = {
            "particles": sim.state.count,
            "steps": steps,
            "neve": here,
            options.peer: there,
            "same": same,
        }
        print(json.dumps({"cpu": cpu(), **facts, "particle_steps_per_s": rates, "ratios": ratios}, indent=2))
    else:
        print(f"{cpu()}; {sim.state.count:,} particles, {options.batches} x {options.steps} steps in turn")
        for name, values in rates.items():
            low, mid, high = min(values) / 1e6, statistics.median(values) / 1e6, max(values) / 1e6
            print(f"  {name:7}{mid:8.2f} M particle-steps/s  ({low:.2f}-{high:.2f})")
        for name in here:
            values = f"neve {here[name]:11.6f}  {options.peer} {there[name]:11.6f}"
            print(f"  {name:15} {values}  off {off[name]:.1e}")
    if not same:
        raise SystemExit("the two did not do the same work: no ratio")
    if not options.json:
        print(
            f"  neve / {options.peer} = {statistics.median(ratios):.1f}x  "
            f"({min(ratios):.1f}-{max(ratios):.1f}, batch by batch)"
        )


if __name__ == "__main__":
    main()
