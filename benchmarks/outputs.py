"""What files and films cost a run: the wall time of its frames over that of the steps alone.

python benchmarks/outputs.py [--particles 1000000] [--steps 60] [--frames 10] [--at-once]

A block of snow meets the ground, 24 frames a second of so many steps each. First the steps alone, then a run
with all that a run writes unasked: frames, log, checkpoint, film. Times are means, since not every frame has
a checkpoint. `--at-once` writes while the steps wait, as before files were written beside them.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from neve import Simulation
from neve.run.beside import Beside
from neve.run.outputs.context import FrameContext
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Scene

FPS = 24


class Clock:
    """An output that notes when each frame is done."""

    def __init__(self) -> None:
        self.marks: list[float] = []

    def write(self, context: FrameContext) -> None:
        """Note the time."""
        self.marks.append(time.perf_counter())

    def close(self, context: FrameContext) -> None:
        """Do nothing."""


Clock.__module__ = "neve.run.outputs.clock"  # the run waits for nothing before it, as with Neve's own


def block(particles: int, steps: int) -> Scene:
    """Return a block of 1 m3 of about so many particles, with so many steps in a frame."""
    return scene_from(
        {
            "numerics": {"dx": (8 / particles) ** (1 / 3), "dt": 1 / FPS / steps},
            "snow": {"E0": 2e4},
            "sources": [{"shape": "box", "center": [0, 0, 0.55], "velocity": [0, 0, -2]}],
            "colliders": [{"shape": "plane"}],
            "run": {"fps": FPS},
        }
    )


def seconds_alone(scene: Scene, frames: int) -> float:
    """Return the mean wall time of a frame's steps [s], after the first frame."""
    sim = Simulation(scene)
    sim.advance(1 / FPS)
    start = time.perf_counter()
    for _ in range(frames):
        sim.advance(1 / FPS)
    return (time.perf_counter() - start) / frames


def seconds_of_run(scene: Scene, frames: int) -> float:
    """Return the mean wall time of a frame of a run [s], after the first one."""
    clock = Clock()
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder:
        Simulation(scene).run(Path(folder) / "run", frames=frames + 1, quiet=True, outputs=[clock])
    return (clock.marks[-1] - clock.marks[1]) / frames


def main() -> None:
    """Measure and print one line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--particles", type=int, default=1_000_000)
    parser.add_argument("--steps", type=int, default=60, help="steps in a frame")
    parser.add_argument("--frames", type=int, default=10)
    parser.add_argument("--at-once", action="store_true", help="write while the steps wait")
    asked = parser.parse_args()
    if asked.at_once:
        Beside.__enter__ = lambda self: self  # type: ignore[method-assign]
    scene = block(asked.particles, asked.steps)
    alone = seconds_alone(scene, asked.frames)
    run = seconds_of_run(scene, asked.frames)
    how = "while the steps wait" if asked.at_once else "beside the steps"
    print(f"{how}: {alone:.3f} s a frame alone, {run:.3f} s with outputs, loss {run / alone - 1:.1%}")


if __name__ == "__main__":
    main()
