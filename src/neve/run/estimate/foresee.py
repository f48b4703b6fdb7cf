"""Foresee what a run takes: from the scene filled with snow, some of its steps, and a coarse likeness."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from neve.io.frames import block_edge, fields_of, frame_of, stored
from neve.run.beside import DEPTH
from neve.run.estimate.crowd import crowd
from neve.run.estimate.trial import Trial, likeness, pace, silence, trial
from neve.run.loop import last_frame
from neve.run.outputs.registry import entries, kinds, schedule_of
from neve.sampling.fineness import particles_of, placed_in
from neve.scene.schema.outputs import Need, Sizes
from neve.schedule import Regular
from neve.solver import Blowup

if TYPE_CHECKING:
    from neve.io.frames import Frame
    from neve.scene.schema.scene import Scene
    from neve.simulation import Simulation

MOST_FILLED = 500_000
"""Particles up to which the scene itself is filled and tried; beyond it a likeness of so many."""
LIKENESS = 3_000
"""Particles of the coarse likeness that runs to the end."""
COARSEST = 8.0
"""Factor on dx of a likeness at most."""

ROOM = 1.5
"""Memory of particles that are added to, over that of those that are there."""
PROGRAM, DRAWING = 100e6, 200e6
"""Memory of the program with its libraries, and of drawing films and pictures [bytes]; measured on Linux."""
SAMPLE_BYTES = 240
"""Memory for each particle while a source is filled [bytes]; see `neve.sampling.room`."""
ARCHIVED = 250
"""Bytes of an array in an archive besides its numbers."""
PICTURE_SECONDS = 0.25
"""For a picture of a film, where it is not measured [s]; one core, from 11,000 to 210,000 particles."""
STEPS = (0.85, 1.25)
"""Steps over those that are foreseen, if the likeness ran to the end: how far they were apart in trials."""
MORE_COARSE = 0.05
"""By how much wider for each doubling of dx beyond the first."""
CUT_SHORT = 2.0
"""By how much wider where the likeness did not run, as a factor on the share that it lacks."""
TIME = (0.7, 1.6)
"""Wall time of a step over what is foreseen: snow scatters, and the machine has other work."""


class Range(NamedTuple):
    """A number that is foreseen, and between which it should lie."""

    likely: float
    low: float
    high: float

    def scaled(self, factor: float) -> Range:
        """Return all three times `factor`."""
        return Range(*(value * factor for value in self))


@dataclass(frozen=True)
class Estimate:
    """Hold what a run takes.

    Attributes:
        particles: at the start; where snow comes or goes, the most at any time
        frames: number of the last frame
        steps: in all
        seconds: wall time on this machine
        memory: at most [bytes]
        device: name of the GPU that it runs on; "": the processor
        device_memory: of the GPU, at most [bytes]; device_free: what is free of it now
        disk: of the run folder at the end [bytes]; frame_bytes: of a file of frames/
        not_counted: kinds of outputs in it whose time and bytes are not known
        threads: that the run would use; None: as many as there are processors
        tried: share of the run that a coarse likeness has run through [1]
        trial_seconds: what the estimate took
    """

    particles: Range
    frames: int
    steps: Range
    seconds: Range
    memory: float
    disk: float
    frame_bytes: float
    not_counted: tuple[str, ...]
    threads: int | None
    tried: float
    trial_seconds: float
    device: str = ""
    device_memory: float = 0.0
    device_free: int | None = None


def estimate(
    scene: Scene, frames: int | None = None, threads: int | None = None, seconds: float = 10.0
) -> Estimate:
    """Return what a run of `scene` takes, after a trial of about so many `seconds`.

    frames: number of the last frame, by default that of the scene. threads: as of a run

    Particles are counted in the scene as it is filled; beyond MOST_FILLED, in one with a coarser grid. The
    wall time of a step is measured there, with the drawing of a picture. The number of steps is that of a
    likeness with about LIKENESS particles, run to the end if the time suffices (`neve.run.estimate.trial`).

    Errors: SceneError for a scene that cannot be run; Blowup for one that fails at once.
    """
    begin = time.monotonic()
    from neve.simulation import Simulation

    last = last_frame(scene, frames)
    expected = particles_of(scene)
    coarser = max(1.0, (expected / MOST_FILLED) ** (1 / 3))
    with silence():
        near = Simulation(likeness(scene, coarser) if coarser > 1.0 else scene, threads=threads)
    times = placed_in(scene) / placed_in(near.scene) if coarser > 1.0 else 1.0
    there = expected if scene.is_open else near.count * times
    foreseen = _trial(scene, there, last, 0.7 * seconds, threads)
    frame, saved = _frame(near), _saved(near)
    drawing = _drawing(near, frame)
    a_step = pace(near, min(0.2 * seconds, 0.3 if scene.is_open else 2.0))
    if foreseen is None:
        raise Blowup("the scene fails within its first steps: neve run says how")
    if scene.is_open:
        return _open(scene, last, foreseen, near, drawing, threads, begin)
    particles = near.count * times
    frame_bytes = _archive(stored(frame, block_edge(scene))) * times
    need, unknown = _needs(scene, last, Sizes(frame_bytes, saved * times, len(near.solids()) * ROW_BYTES))
    steps = _steps(foreseen, last, scene.run.fps)
    state = near.bytes * foreseen.growth + saved + _waiting(frame, scene)
    device = near.solver.device
    return Estimate(
        particles=Range(particles, particles * _less(coarser), particles / _less(coarser)),
        frames=last,
        steps=steps,
        seconds=_seconds(steps, a_step * times * foreseen.slower, need.pictures * drawing * times),
        memory=PROGRAM + max(SAMPLE_BYTES * particles, (DRAWING if need.pictures else 0.0) + state * times),
        disk=need.bytes,
        frame_bytes=frame_bytes,
        not_counted=unknown,
        threads=threads,
        tried=foreseen.covered,
        trial_seconds=time.monotonic() - begin,
        device=device.name if device else "",
        device_memory=near.bytes * foreseen.growth * times if device else 0.0,
        device_free=device.free + near.bytes if device else None,
    )


def guess(scene: Scene, frames: int | None = None, threads: int | None = None) -> Estimate | None:
    """Return an estimate within a second or two, or None if the run is short, or fails.

    It comes from the coarse likeness alone, whose every particle takes longer.
    """
    begin = time.monotonic()
    last = last_frame(scene, frames)
    expected = particles_of(scene)
    if expected * last < SHORT:
        return None
    foreseen = _trial(scene, expected, last, 1.0, threads)
    if foreseen is None:
        return None
    if scene.is_open:
        return _open(scene, last, foreseen, None, PICTURE_SECONDS, threads, begin)
    particles = foreseen.particles * placed_in(scene) / placed_in(likeness(scene, foreseen.coarser))
    frame_bytes = particles * FRAME_BYTES[scene.run.frames]
    solids = len(scene.colliders) + len(scene.bodies)
    need, unknown = _needs(scene, last, Sizes(frame_bytes, particles * SAVED_BYTES, solids * ROW_BYTES))
    steps = _steps(foreseen, last, scene.run.fps)
    drawing = need.pictures * PICTURE_SECONDS
    return Estimate(
        particles=Range(particles, 0.95 * particles, 1.05 * particles),
        frames=last,
        steps=steps,
        seconds=_seconds(steps, foreseen.seconds_per_work * particles, drawing),
        memory=PROGRAM + DRAWING + 2 * SAMPLE_BYTES * particles,
        disk=need.bytes,
        frame_bytes=frame_bytes,
        not_counted=unknown,
        threads=threads,
        tried=foreseen.covered,
        trial_seconds=time.monotonic() - begin,
    )


def _open(
    scene: Scene,
    last: int,
    foreseen: Trial,
    near: Simulation | None,
    drawing: float,
    threads: int | None,
    begin: float,
) -> Estimate:
    """Return the estimate of a run in which snow comes or goes: the likeness tells how much is there when.

    near: the scene itself or something near it, after some steps; drawing: seconds that a picture takes
    """
    some = crowd(scene, foreseen, last / scene.run.fps)
    each_frame, each_saved, each, each_waiting = (
        float(FRAME_BYTES[scene.run.frames]),
        float(SAVED_BYTES),
        float(SAMPLE_BYTES),
        float(DEPTH * sum(FRAME_BYTES[kind] for kind in {"plain", scene.run.frames})),
    )
    if near is not None and near.count:
        frame = _frame(near)
        each_frame = _archive(stored(frame, block_edge(scene))) / near.count
        each_waiting = _waiting(frame, scene) / near.count
        each_saved = _saved(near) / near.count
        each = near.bytes / near.count
    each_frame += 8.0 if scene.sinks and near is None else 0.0
    solids = len(scene.colliders) + len(scene.bodies)
    sizes = Sizes(some.mean * each_frame, some.most * each_saved, solids * ROW_BYTES)
    need, unknown = _needs(scene, last, sizes)
    state = some.most * (ROOM * each + each_saved + each_waiting)
    steps = _steps(foreseen, last, scene.run.fps)
    return Estimate(
        particles=Range(some.most, 0.9 * some.most, 1.1 * some.most),
        frames=last,
        steps=steps,
        seconds=_seconds(steps, foreseen.seconds_per_work * some.mean, need.pictures * drawing),
        memory=PROGRAM + (DRAWING if need.pictures else 0.0) + state,
        disk=need.bytes,
        frame_bytes=some.most * each_frame,
        not_counted=unknown,
        threads=threads,
        tried=foreseen.covered,
        trial_seconds=time.monotonic() - begin,
    )


SHORT = 4e5
"""Particles times frames, below which a run takes a minute at most with thousand steps a frame."""
ROW_BYTES = 200
"""Bytes of a row for a solid; measured."""
FRAME_BYTES, SAVED_BYTES = {"plain": 34, "compact": 15}, 122
"""Bytes of a particle in frames and in a checkpoint, as MPM writes them."""


def _trial(scene: Scene, particles: float, last: int, seconds: float, threads: int | None) -> Trial | None:
    coarser = min(COARSEST, (particles / LIKENESS) ** (1 / 3)) if particles > LIKENESS else 1.0
    return trial(scene, coarser, last / scene.run.fps, seconds, threads)


def _less(coarser: float) -> float:
    """Return the factor down to which a count of particles may be off that is scaled from another grid."""
    return 1.0 if coarser == 1.0 else 0.97


def _steps(foreseen: Trial, last: int, fps: int) -> Range:
    likely = foreseen.steps(last, fps)
    doublings = max(math.log2(foreseen.coarser), 0.0) if foreseen.coarser > 1.0 else 0.0
    unseen = 1.0 + CUT_SHORT * (1.0 - foreseen.covered)
    if foreseen.coarser == 1.0 and foreseen.covered >= 1.0:
        return Range(likely, 0.98 * likely, 1.02 * likely)
    wider = (1.0 + MORE_COARSE * doublings) * unseen
    return Range(likely, likely * STEPS[0] / wider, likely * STEPS[1] * wider)


def _seconds(steps: Range, a_step: float, drawing: float) -> Range:
    return Range(
        steps.likely * a_step + drawing,
        steps.low * a_step * TIME[0] + drawing,
        steps.high * a_step * TIME[1] + drawing,
    )


def _frame(sim: Simulation) -> Frame:
    poses = [(pose.position, pose.rotation) for _, pose in sim.solids()]
    columns = sim.columns()
    fields = [name for name in fields_of(sim.scene, columns) if name in columns]
    return frame_of(columns, poses, sim.time, fields)


def _saved(sim: Simulation) -> float:
    return _archive(sim.arrays())


def _waiting(frame: Frame, scene: Scene) -> float:
    """Return the bytes of frames that wait to be written: as copied, and as their file holds them."""
    edge = block_edge(scene)
    packed = _archive(stored(frame, edge)) if edge is not None else 0.0
    return DEPTH * (_archive(stored(frame, None)) + packed)


def _archive(arrays: object) -> float:
    """Return the bytes of an archive of these arrays."""
    assert isinstance(arrays, dict)
    return float(sum(np.asarray(values).nbytes + ARCHIVED for values in arrays.values()))


def _drawing(sim: Simulation, frame: Frame) -> float:
    """Return how long drawing a picture takes [s]."""
    from neve.run.painter import Painter

    painter = Painter(sim.scene, [solid for solid, _ in sim.solids()], sim.threads, radius=sim.radius)
    painter.draw(frame)  # makes ready what all pictures share
    begin = time.monotonic()
    painter.draw(frame)
    return time.monotonic() - begin


def _needs(scene: Scene, last: int, sizes: Sizes) -> tuple[Need, tuple[str, ...]]:
    """Return what all outputs take, and the kinds of those that do not know it."""
    total, unknown = Need(0.0), []
    for given in entries(scene):
        schedule = schedule_of(given, kinds()[given.kind].make(**given.options()), scene.run.fps)
        due = sum(schedule.due(frame) for frame in range(last + 1)) if isinstance(schedule, Regular) else 0
        need = given.need(sizes, due)
        if need is None:
            unknown.append(given.kind)
        else:
            total = Need(total.bytes + need.bytes, total.pictures + need.pictures)
    return total, tuple(dict.fromkeys(unknown))
