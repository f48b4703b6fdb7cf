"""Measure a run over ranks: time of a step, bytes of the halo, how evenly the snow is shared out.

    python benchmarks/ranks.py SCENE --set numerics.dx=0.02 --frames 2 --threads 2     # one rank
    mpirun -n 2 python benchmarks/ranks.py SCENE --set numerics.dx=0.02 --frames 2     # two

Prints a line of JSON: of the leader's fastest frame, after a first one, the time of a step in its stages.
`ghost_bytes`: what copies of particles at the border
would take in each step, sent once, instead of what they give to nodes (x, v, C and tau of each).
"""

import argparse
import json

import neve
from neve.ranks import launch

GHOST_NUMBERS = 3 + 3 + 9 + 6


def measure(arguments):
    """Run the scene on the leader, and return what is printed."""
    scene = neve.load(arguments.scene, arguments.set)
    if launch.size() == 1:
        from neve import Simulation as Kind
    else:
        from neve.ranks.simulation import RankSimulation as Kind
    sim = Kind(scene, threads=arguments.threads)
    frame = arguments.seconds or 1.0 / scene.run.fps
    sim.advance(frame)
    times = []
    for _ in range(arguments.frames):
        steps = sim.steps
        sim.advance(frame)
        stages = sim.stats.stage_seconds
        times.append({name: 1e3 * t / (sim.steps - steps) for name, t in stages.items() if t})
    best = min(times, key=lambda each: sum(each.values()))
    found = {
        "ranks": launch.size(), "threads": sim.threads, "particles": sim.count, "steps": sim.steps,
        "ms_per_step": round(sum(best.values()), 3),
        "stages_ms": {name: round(value, 3) for name, value in best.items()},
    }  # fmt: skip
    return found | (shares(sim, arguments.frames + 1) if launch.size() > 1 else {})


def shares(sim, frames):
    """What the ranks say of themselves."""
    each = sim.tallies()
    mean = sum(one.particles for one in each) / len(each)
    per_block = [one.particles / max(one.homes, 1) for one in each]
    return {
        "imbalance": max(one.particles for one in each) / mean,
        "halo_bytes": [one.halo_bytes for one in each],
        "border_homes": [one.border for one in each],
        "ghost_bytes": [
            round(one.border * n * GHOST_NUMBERS * 4) for one, n in zip(each, per_block, strict=True)
        ],
        "exchange_ms": [1e3 * one.exchanging / sim.steps for one in each],
        "gather_ms_per_frame": 1e3 * each[0].gathering / frames,
        "migrated": sum(one.migrated for one in each),
        "rebalanced": each[0].rebalanced,
    }


def main():
    """Lead or follow."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--frames", type=int, default=2)
    parser.add_argument("--seconds", type=float, help="of a frame; by default as the scene says")
    parser.add_argument("--threads", type=int)
    arguments = parser.parse_args()
    if launch.size() == 1:
        print(json.dumps(measure(arguments)))
        return
    from neve.ranks.simulation import follow, leading

    if not launch.leads():
        follow()
        return
    with leading():
        print(json.dumps(measure(arguments)))


if __name__ == "__main__":
    main()
