"""What a run will take: `neve estimate`, the line with which `neve run` says so, and the grid of --fine."""

from __future__ import annotations

import json
import os
import re
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from neve.cli.console import report, thread_count, whole_number

if TYPE_CHECKING:
    from neve.run.estimate import Estimate, Range
    from neve.scene.schema.scene import Scene

LONG = 60.0
"""Wall time from which `neve run` says what it will take [s]."""


@click.command()
@click.argument("scene")
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="Change a value: snow.xi=12.")
@click.option("--device", metavar="WORD", help="Where to compute, as with neve run.")
@click.option("--fine", is_flag=True, help="As with neve run: two million particles.")
@click.option("--frames", metavar="N", callback=whole_number, help="Up to frame N.")
@click.option(
    "--threads", metavar="N", callback=thread_count, help="Number of threads; by default one per core."
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def estimate(
    scene: str,
    changes: tuple[str, ...],
    device: str | None,
    fine: bool,
    frames: int | None,
    threads: int | None,
    as_json: bool,
) -> None:
    """Say what a run of SCENE takes: particles, steps, time, memory and disk.

    A short trial, of some ten seconds, measures this machine and runs through a coarse likeness of the scene.
    """
    from neve.run.estimate import estimate as foresee
    from neve.scene.reading.load import load

    if device is not None:
        changes = (*changes, f"numerics.device={device}")
    checked = load(scene, changes)
    if fine:
        checked = finer(checked, changes)
    found = foresee(checked, frames, threads)
    if as_json:
        click.echo(json.dumps(as_data(found), indent=2))
        return
    click.echo("\n".join(as_text(found, checked)))


def as_data(found: Estimate) -> dict[str, object]:
    """Return an estimate as JSON has it: whole numbers of particles, steps and bytes."""
    data = asdict(found)
    for name in ("particles", "steps"):
        data[name] = {key: round(value) for key, value in getattr(found, name)._asdict().items()}
    data["seconds"] = found.seconds._asdict()
    for name in ("memory", "device_memory", "disk", "frame_bytes"):
        data[f"{name.removesuffix('_bytes')}_bytes"] = round(data.pop(name))
    return data


def as_text(found: Estimate, scene: Scene) -> list[str]:
    """Return the lines that `neve estimate` prints."""
    from neve.run.progress import duration
    from neve.system.disk import free
    from neve.system.memory import free as free_memory
    from neve.system.memory import in_words

    left, memory_left = free(Path.cwd()), free_memory()
    threads = found.threads or os.cpu_count() or 1
    machine = found.device or f"{threads} thread{'s' if threads > 1 else ''} of this machine"
    beside = f", besides {', '.join(found.not_counted)}" if found.not_counted else ""
    tried = (
        "a coarse likeness ran to the end"
        if found.tried >= 1.0
        else f"a coarse likeness ran through {found.tried:.0%} of it, the rest is extrapolated"
    )
    return [
        f"particles  {_range(found.particles)}, with numerics.dx = {scene.numerics.dx:g}",
        f"frames     {found.frames}, and frame 0",
        f"steps      {_range(found.steps)}: the time step follows the snow, and {tried}",
        f"time       about {duration(found.seconds.likely)}, {duration(found.seconds.low)} to "
        f"{duration(found.seconds.high)} on {machine}{beside}",
        f"memory     {in_words(found.memory)}" + _of(memory_left, found.memory, in_words),
        *(
            [
                f"of the GPU {in_words(found.device_memory)}"
                + _of(found.device_free, found.device_memory, in_words)
            ]
            if found.device
            else []
        ),
        f"disk       {in_words(found.disk)}, {in_words(found.frame_bytes)} a frame{beside}"
        + _of(left, found.disk, in_words),
    ]


def announce(scene: Scene, frames: int | None, threads: int | None) -> None:
    """Say in one line what a run takes that will take over a minute; nothing about others."""
    from neve.run.estimate import guess
    from neve.run.progress import duration
    from neve.system.memory import in_words

    found = guess(scene, frames, threads)
    if found is None or found.seconds.likely < LONG:
        return
    report(
        f"this takes about {duration(found.seconds.likely)} ({duration(found.seconds.low)} to "
        f"{duration(found.seconds.high)}) and {in_words(found.disk)} of disk, "
        f"{in_words(found.frame_bytes)} a frame; neve estimate says more"
    )


def _of(left: int | None, needed: float, in_words: object) -> str:
    assert callable(in_words)
    if left is None:
        return ""
    return f"; {in_words(left)} are free" + (", which is not enough" if needed > left else "")


def _range(value: Range) -> str:
    """Write a number and how sure it is."""
    likely, low, high = (_round(v) for v in value)
    return f"{likely:,}" if low == likely == high else f"about {likely:,}, from {low:,} to {high:,}"


def _round(value: float) -> int:
    """Return a number with three digits, below a million all of them where they are exact."""
    digits = max(len(str(round(value))) - 3, 0)
    return round(value) if value == round(value) and value < 1e6 else int(round(value, -digits))


def finer(scene: Scene, changes: tuple[str, ...]) -> Scene:
    """Return the scene with two million particles, and say with which grid."""
    from neve.sampling.fineness import finer as chosen
    from neve.sampling.fineness import particles_of

    for key, _, value in (change.partition("=") for change in changes):
        if key.strip() == "numerics.dx" or (key.strip() == "numerics" and re.search(r"\bdx\b", value)):
            raise click.UsageError(
                "--fine chooses numerics.dx: leave out one of --fine and --set numerics.dx"
            )
    if scene.numerics.dt != "auto":
        raise click.UsageError(
            f"--fine makes numerics.dx smaller, and numerics.dt = {scene.numerics.dt:g} s would stay: leave "
            'out one of both, or add --set numerics.dt="auto"'
        )
    fine = chosen(scene)
    report(
        f"--fine: numerics.dx = {fine.numerics.dx:g}, about {particles_of(fine) / 1e6:.1f} million particles"
    )
    return fine
