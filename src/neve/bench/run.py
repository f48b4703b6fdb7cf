"""Measure the speed of the step on this machine: blocks of snow that land on the ground, stage by stage.

Every block falls onto the ground at 5 m/s, so that contact, plastic flow and hardening are at work. A case is
measured in batches; the median batch is reported, with the smallest and the largest in brackets.
"""

from __future__ import annotations

import contextlib
import json
import platform
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from neve import _core
from neve.bench.bodies import Share, measure_bodies, measure_many
from neve.bench.choices import Costs, measure_choices
from neve.bench.compare import compared, read_earlier
from neve.bench.competitor import Shared, measure_competitor
from neve.bench.heat import HeatCost, measure_heat
from neve.bench.loose import Scattered, measure_loose
from neve.bench.sleep import Sleepers, measure_sleep
from neve.bench.smoothed import Cost, measure_smoothed
from neve.bench.snowfall import Fallen, Still, measure_snowfall, measure_still
from neve.bench.spread import Spread
from neve.bench.walk import Walk, measure_walk
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Camera, Collider, Numerics, Scene, Source
from neve.scene.values.choices import SPLINES, TRANSFERS
from neve.simulation import Simulation
from neve.spelling import hint, nearest

DX = 0.02
"""Grid spacing of all cases [m]."""
DT = 1e-4
"""Time step of all cases [s]: with snow hardened to the full (J_P = 0.6) a wave crosses 0.7 cells in it."""
SPEED = 5.0
"""Speed at which the blocks land [m/s]."""


@dataclass(frozen=True)
class Block:
    """Name a block of snow: its size in cells of 8 particles, and how it is measured."""

    cells: tuple[int, int, int]
    steps: int  # of a batch
    batches: int
    warm: int  # steps before the first batch


@dataclass
class Speed:
    """Hold what was measured of one block."""

    case: str
    particles: int
    threads: int
    precision: str
    spline: str
    transfer: str
    steps: int  # of a batch
    batches: int
    step_ms: Spread  # wall time of a step, all in
    stage_ms: dict[str, Spread]  # of a step; "other" is what lies between the stages
    rate: Spread  # particle-steps a second
    frame_ms: Spread  # wall time of a batch
    bytes_core: float  # per particle, as the core allocates it for particles and grid
    bytes_resident: float | None  # per particle, growth of the process; None where it would drown in the rest
    blocks: int
    flowing: float  # share of particles that have flowed plastically


BLOCKS = {
    "20k": Block((25, 10, 10), 40, 15, 100),
    "200k": Block((40, 25, 25), 40, 7, 100),
    "1m": Block((50, 50, 50), 20, 7, 60),
    "5m": Block((125, 100, 50), 10, 5, 20),
}
FRAME = Block((25, 10, 10), 40, 25, 120)
"""The headline of the program that Neve descends from: 20,000 particles, 40 substeps a frame."""

CONTACTS = Block((25, 25, 20), 20, 7, 100)
"""A hundred thousand particles in contact (numerics.method = "particles")."""


def landing_block(cells: tuple[int, int, int], **numerics: Any) -> Scene:
    """Return the scene of a block of `cells` cells, standing on the ground and moving down into it."""
    size = (cells[0] * DX, cells[1] * DX, cells[2] * DX)
    return Scene(
        numerics=Numerics(**{"dx": DX, "dt": DT, "initial_volume": "sampled", **numerics}),
        sources=(Source.of("box", center=(0.0, 0.0, size[2] / 2), size=size, velocity=(0.0, 0.0, -SPEED)),),
        colliders=(Collider.of("plane"),),
        camera=Camera(position=(2 * size[0], -4 * size[0], 2 * size[0]), target=(0.0, 0.0, size[2] / 2)),
    )


def measure(name: str, block: Block, **numerics: Any) -> Speed:
    """Run a block and time its batches."""
    scene = landing_block(block.cells, **numerics)
    before = resident()
    sim = Simulation(scene)
    sim.advance(block.warm * DT)
    wall: list[float] = []
    stages: dict[str, list[float]] = {stage: [] for stage in (*sim.solver.stages, "other")}
    for _ in range(block.batches):
        begun, steps = perf_counter(), sim.steps
        sim.advance(block.steps * DT)
        wall.append(perf_counter() - begun)
        if sim.steps - steps != block.steps:
            raise AssertionError(f"{name}: a batch took {sim.steps - steps} steps, not {block.steps}")
        for stage, seconds in sim.stats.stage_seconds.items():
            stages[stage].append(seconds)
        stages["other"].append(wall[-1] - sum(sim.stats.stage_seconds.values()))
    after, n, numbers = resident(), sim.state.count, scene.numerics
    return Speed(
        name,
        n,
        _core.threads(),
        numbers.precision,
        numbers.spline,
        numbers.transfer,
        block.steps,
        block.batches,
        step_ms=Spread.of([1e3 * t / block.steps for t in wall]),
        stage_ms={
            stage: Spread.of([1e3 * t / block.steps for t in times]) for stage, times in stages.items()
        },
        rate=Spread.of([n * block.steps / t for t in wall]),
        frame_ms=Spread.of([1e3 * t for t in wall]),
        bytes_core=sim.bytes / n,
        bytes_resident=None if before is None or after is None or n < 100_000 else (after - before) / n,
        blocks=getattr(sim.diagnostics(), "blocks", 0),
        flowing=float((sim.state.J_P != 1).mean()),
    )


def resident() -> int | None:
    """Return the resident memory of this process [bytes], or None where the system does not say."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        import resource

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
        return pages * resource.getpagesize()
    return None


def matrix() -> Iterator[Speed]:
    """Measure every spline and precision on the block of 200,000 particles, with the first transfer of each
    way through the grid: force and momentum in one array, or apart, or apart and gathered for C too.
    """
    ways = ((name, (t.has_change, t.has_affine_change)) for name, t in TRANSFERS.items())
    transfers = {way: name for name, way in reversed([*ways])}
    for precision in ("float32", "float64"):
        for spline in SPLINES:
            for _, transfer in sorted(transfers.items()):
                name = f"matrix {precision} {spline} {transfer}"
                yield measure(name, BLOCKS["200k"], precision=precision, spline=spline, transfer=transfer)


@dataclass
class Once:
    """Hold the time of something that is not a step."""

    case: str
    particles: int
    threads: int
    seconds: Spread


def sampling() -> Iterator[Once]:
    """Time the filling of a box with snow."""
    from neve.sampling import fill

    for method, cells in (("jittered", (50, 50, 50)), ("poisson", (25, 25, 25))):
        scene = landing_block(cells, sampling=method)
        count, times = 0, []
        for _ in range(3):
            begun = perf_counter()
            count = len(fill(scene.sources[0], scene.numerics, 0).x)
            times.append(perf_counter() - begun)
        yield Once(f"sampling {method}", count, 1, Spread.of(times))


def preview() -> Iterator[Once]:
    """Time the drawing of one frame of the film."""
    from neve.render.preview import Preview

    for name in ("20k", "200k", "1m"):
        scene = landing_block(BLOCKS[name].cells)
        sim = Simulation(scene)
        sim.advance(10 * DT)
        painter, bodies, times = Preview(scene), sim.solids(), []
        for _ in range(4):
            begun = perf_counter()
            painter.draw(sim.state.x, bodies, J_P=sim.state.J_P)
            times.append(perf_counter() - begun)
        yield Once(f"preview {name}", sim.state.count, _core.threads(), Spread.of(times[1:]))


def mpm_ns(batches: int = 5) -> float:
    """Return the processor time of a step of material points over the particles, all in [ns], the median."""
    block = BLOCKS["20k"]
    sim = Simulation(landing_block(block.cells))
    sim.advance(block.warm * DT)
    spent = []
    for _ in range(batches):
        begun = process_time()
        sim.advance(block.steps * DT)
        spent.append(1e9 * (process_time() - begun) / (block.steps * sim.count))
    return Spread.of(spent).median


def shared() -> Iterator[Shared]:
    """Measure blocks beside a program that computes, in turn with batches alone."""
    for name in ("20k", "200k"):
        block = BLOCKS[name]
        sim = Simulation(landing_block(block.cells))
        sim.advance(block.warm * DT)
        yield measure_competitor(sim, DT, block.steps)


Result = (
    Speed | Once | Share | Sleepers | Scattered | Costs | Shared | Walk | Cost | HeatCost | Fallen | Still
)

CASES: dict[str, Callable[[], Iterator[Result]]] = {
    **{name: lambda name=name: iter([measure(name, BLOCKS[name])]) for name in BLOCKS},  # type: ignore[misc]
    "20k_frame": lambda: iter([measure("20k_frame", FRAME)]),
    "matrix": matrix,
    "sampling": sampling,
    "preview": preview,
    "bodies": lambda: iter([measure_bodies()]),
    "many_bodies": lambda: iter([measure_many()]),
    "contacts": lambda: iter([measure("contacts", CONTACTS, method="particles")]),
    "sleep": lambda: iter([measure_sleep()]),
    "competitor": shared,
    "loose": lambda: iter([measure_loose()]),
    "choices": lambda: iter([measure_choices(partial(landing_block, BLOCKS["20k"].cells), DT)]),
    "smoothed": measure_smoothed,
    "heat": measure_heat,
    "snowfall": lambda: iter([measure_snowfall()]),
    "snowed_still": lambda: iter([measure_still()]),
    "walk": lambda: iter([measure_walk(mpm_ns)]),
}
USUAL = ("20k", "20k_frame", "200k", "1m")


def run(cases: Sequence[str], as_json: bool = False, earlier: str | None = None) -> None:
    """Measure the named cases (some usual ones if none is named) and print them as they come.

    earlier: a file of speeds to print ratios to.

    Errors: SceneError for a name that is no case; RunError for a file that holds no speeds.
    """
    then = read_earlier(earlier) if earlier else None
    for name in cases:
        if name not in CASES:
            meant = hint(nearest(name, CASES), f"the cases are {', '.join(CASES)}")
            raise SceneError(f"there is no benchmark {name}{meant}")
    machine = {
        "cpu": cpu(),
        "threads": _core.threads(),
        "python": platform.python_version(),
        **_core.build_info(),
    }
    results: list[Result] = []
    if not as_json:
        print(", ".join(f"{key} {value}" for key, value in machine.items()))
    for name in cases or USUAL:
        for result in CASES[name]():
            if isinstance(result, Speed) and results:  # the process reuses what an earlier case gave back
                result.bytes_resident = None
            results.append(result)
            if not as_json:
                print("\n" + text_of(result), flush=True)
                if then is not None and isinstance(result, Speed):
                    print("\n".join(compared(result, then)), flush=True)
    if as_json:
        json.dump({"machine": machine, "results": [asdict(r) for r in results]}, sys.stdout, indent=2)
        print()


def text_of(result: Result) -> str:
    """Return a result as lines of text."""
    if not isinstance(result, Speed | Once):
        return result.text()
    if isinstance(result, Once):
        s, n = result.seconds, result.particles
        return f"{result.case}: {n:,} particles in {s.median:.3f} s ({s.least:.3f}-{s.largest:.3f})"
    lines = [
        f"{result.case}: {result.particles:,} particles, {result.precision} {result.spline} "
        f"{result.transfer}, {result.threads} threads, "
        f"median of {result.batches} batches of {result.steps} steps"
    ]
    whole = result.step_ms.median
    for stage, spread in (*result.stage_ms.items(), ("step", result.step_ms)):
        share = 100 * spread.median / whole
        lines.append(
            f"  {stage:6}{spread.median:9.3f} ms {share:5.1f} %  ({spread.least:.3f}-{spread.largest:.3f})"
        )
    rate, frame = result.rate, result.frame_ms
    lines.append(
        f"  {rate.median / 1e6:.2f} M particle-steps/s ({rate.least / 1e6:.2f}-{rate.largest / 1e6:.2f}); "
        f"{1e3 / frame.median:.1f} frames/s of {result.steps} steps"
    )
    process = "" if result.bytes_resident is None else f", {result.bytes_resident:.0f} in resident memory"
    lines.append(
        f"  {result.bytes_core:.0f} bytes/particle allocated by the core{process}; {result.blocks:,} blocks; "
        f"{100 * result.flowing:.0f} % of the snow has flowed"
    )
    return "\n".join(lines)


def cpu() -> str:
    """Return the name of the processor, as far as the system reports it."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
