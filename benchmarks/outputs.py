"""What files and films cost a run: the wall time of its frames over that of the steps alone.

python benchmarks/outputs.py [--particles 1000000] [--steps 60] [--frames 10] [--at-once] [--parts]

A block of snow meets the ground, 24 frames a second of so many steps each. First the steps alone, then a run
with all that a run writes unasked: frames, log, checkpoint, film. Times are means, since not every frame has
a checkpoint. `--at-once` writes while the steps wait, as before files were written beside them.
`--parts` tells instead what each output takes of processor time on one thread, the least of several times.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from neve import Simulation
from neve.io.checkpoint import write_checkpoint
from neve.io.frames import BLOCK_CELLS, Frame, frame_of, stored, write_stored
from neve.render.film import SEGMENT_FRAMES, Film
from neve.run.beside import Beside
from neve.run.outputs.context import FrameContext
from neve.run.painter import Painter
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


def processor_ms(job: Callable[[], Any], times: int = 5) -> float:
    """Return the processor time of a job [ms], the least of several."""
    least = float("inf")
    for _ in range(times):
        start = time.process_time()
        job()
        least = min(least, time.process_time() - start)
    return 1e3 * least


def parts(scene: Scene, frames: int) -> Iterator[tuple[str, float]]:
    """Yield what each output of a frame takes of processor time on one thread [ms], after three frames."""
    sim = Simulation(scene, threads=1)
    sim.advance(3 / FPS)

    def copy() -> Frame:
        return frame_of(sim.columns(), [(p.position, p.rotation) for _, p in sim.solids()], sim.time)

    frame, edge = copy(), BLOCK_CELLS * scene.numerics.dx
    plain, compact, state = stored(frame, None), stored(frame, edge), sim.arrays()
    painter = Painter(scene, [solid for solid, _ in sim.solids()], 1, radius=sim.radius)
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as name:
        folder = Path(name)
        yield "frame, copied", processor_ms(copy)
        yield "frame, written plain", processor_ms(lambda: write_stored(folder, 0, plain))
        yield "frame, made compact", processor_ms(lambda: stored(frame, edge))
        yield "frame, written compact", processor_ms(lambda: write_stored(folder, 1, compact))
        yield "picture", processor_ms(lambda: painter.draw(frame))
        yield "picture, encoded", encoding_ms(sim, painter, folder / "film.mp4", frames, copy)
        yield "log", processor_ms(sim.diagnostics)
        yield "checkpoint, copied", processor_ms(sim.arrays)
        path = folder / "checkpoint"
        yield "checkpoint, written", processor_ms(lambda: write_checkpoint(path, 0, "", "", state))


def encoding_ms(
    sim: Simulation, painter: Painter, path: Path, frames: int, copy: Callable[[], Frame]
) -> float:
    """Return the processor time of putting a picture into a film, in this process and the encoder's [ms].

    A whole segment is filmed, of so many pictures to and fro, so that the start of the encoder counts little.
    """
    images = []
    for _ in range(frames):
        images.append(painter.draw(copy()))
        sim.advance(1 / FPS)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.process_time()
    film = Film(path, FPS, painter.size)
    there_and_back = [*images, *images[-2:0:-1]]
    for k in range(SEGMENT_FRAMES):
        film.add(there_and_back[k % len(there_and_back)])
    film.close()
    own, after = time.process_time() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    children = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return 1e3 * (own + children) / SEGMENT_FRAMES


def main() -> None:
    """Measure and print one line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--particles", type=int, default=1_000_000)
    parser.add_argument("--steps", type=int, default=60, help="steps in a frame")
    parser.add_argument("--frames", type=int, default=10)
    parser.add_argument("--at-once", action="store_true", help="write while the steps wait")
    parser.add_argument("--parts", action="store_true", help="processor time of each output")
    asked = parser.parse_args()
    if asked.parts:
        for name, ms in parts(block(asked.particles, asked.steps), asked.frames):
            print(f"{name:24}{ms:8.1f} ms", flush=True)
        return
    if asked.at_once:
        Beside.__enter__ = lambda self: self  # type: ignore[method-assign]
    scene = block(asked.particles, asked.steps)
    alone = seconds_alone(scene, asked.frames)
    run = seconds_of_run(scene, asked.frames)
    how = "while the steps wait" if asked.at_once else "beside the steps"
    print(f"{how}: {alone:.3f} s a frame alone, {run:.3f} s with outputs, loss {run / alone - 1:.1%}")


if __name__ == "__main__":
    main()
