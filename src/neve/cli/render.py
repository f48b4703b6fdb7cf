"""The command `neve render`."""

from __future__ import annotations

import contextlib
import sys
import time

import click

from neve.cli.console import tell, thread_count, whole_number
from neve.cli.export import frame_slice
from neve.system.streams import Steady

MOST = 16384
"""Pixels along a side of a picture."""


def pixels(ctx: click.Context, param: click.Parameter, value: str | None) -> tuple[int, int] | None:
    """Read WIDTHxHEIGHT."""
    if value is None:
        return None
    words = value.split("x")
    if len(words) != 2 or not all(w.isascii() and w.isdigit() and 0 < len(w) < 6 for w in words):
        raise click.BadParameter(f"{value} is not of the form 1280x720", ctx, param)
    width, height = (int(word) for word in words)
    if not (16 <= width <= MOST and 16 <= height <= MOST):
        raise click.BadParameter(f"{value}: each side has 16 to {MOST} pixels", ctx, param)
    return width, height


def aperture(ctx: click.Context, param: click.Parameter, value: float | None) -> float | None:
    """Check the radius of a lens."""
    if value is not None and not 0.0 <= value <= 100.0:
        raise click.BadParameter(f"{value} is not a radius from 0 to 100 m", ctx, param)
    return value


class Told:
    """Say after each picture, or what else `each` is, how far a command is, and how long it will take."""

    def __init__(self, quiet: bool, name: str = "render", each: str = "picture") -> None:
        self._quiet, self._name, self._each, self._begin = quiet, name, each, time.monotonic()
        self._stream = Steady(sys.stderr)

    def __call__(self, done: int, of: int, new: int) -> None:
        """Show that `done` of so many are there, `new` of them made just now."""
        if self._quiet:
            return
        from neve.run.progress import duration

        passed = time.monotonic() - self._begin
        left = f", {duration(passed / new * (of - done))} left" if new and done < of else ""
        with contextlib.suppress(OSError):
            self._stream.write(f"{self._name}: {self._each} {done} of {of}{left}\n")
            self._stream.flush()


@click.command()
@click.argument("run", metavar="RUN")
@click.option("--out", metavar="FOLDER", help="Folder for the pictures; RUN/render by default.")
@click.option("--frame", metavar="N", type=click.IntRange(min=0), help="Render this frame alone.")
@click.option(
    "--frames",
    metavar="A:B[:STEP]",
    callback=frame_slice,
    help="Frames from A up to, without, B; all by default.",
)
@click.option(
    "--quality",
    type=click.Choice(["draft", "good", "final"]),
    default="good",
    help="How finely, and how long; good by default.",
)
@click.option(
    "--look",
    type=click.Choice(["diffuse", "medium", "fast", "reference", "metaballs"]),
    help="How light meets snow; by default as the quality has it: diffuse, and medium for final.",
)
@click.option(
    "--snow",
    "kind",
    type=click.Choice(["fresh", "packed", "wet", "blue_hour"]),
    default="fresh",
    help="Kind of snow to the eye; fresh by default.",
)
@click.option(
    "--phase",
    type=click.Choice(["henyey_greenstein", "cornette_shanks"]),
    help="How snow of the look reference turns light; henyey_greenstein by default.",
)
@click.option("--size", metavar="WxH", callback=pixels, help="Size of the pictures, such as 1280x720.")
@click.option("--spp", metavar="N", callback=whole_number, help="Paths of light for each pixel.")
@click.option(
    "--aperture",
    type=float,
    metavar="R",
    callback=aperture,
    help="Radius of the lens [m]; the camera's by default.",
)
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="Change camera or light.")
@click.option("--denoise/--no-denoise", default=None, help="Remove noise; by default where OIDN is there.")
@click.option("--exr", is_flag=True, help="Write linear light as OpenEXR beside each PNG.")
@click.option("--threads", metavar="N", callback=thread_count, help="Number of threads; all by default.")
@click.option(
    "--jobs", metavar="N", callback=whole_number, help="Frames drawn at once; by default as many as fit."
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="Dask cluster that draws instead, such as tcp://host:8786."
)
@click.option("--force", is_flag=True, help="Render again what is there already.")
@click.option("--quiet", is_flag=True, help="Hide progress.")
def render(
    run: str,
    out: str | None,
    frame: int | None,
    frames: slice | None,
    quality: str,
    look: str | None,
    kind: str,
    phase: str | None,
    size: tuple[int, int] | None,
    spp: int | None,
    aperture: float | None,
    changes: tuple[str, ...],
    denoise: bool | None,
    exr: bool,
    threads: int | None,
    jobs: int | None,
    scheduler: str | None,
    force: bool,
    quiet: bool,
) -> None:
    """Film the run folder RUN by path tracing (Mitsuba 3).

    Pictures go to RUN/render, and a film of them. The same command goes on where it was stopped.
    """
    from neve.film.render import render_run
    from neve.render.path_tracing.develop import has_denoiser
    from neve.render.path_tracing.picture import Choices

    if frame is not None and frames is not None:
        raise click.UsageError("--frame renders one picture and --frames several: choose one of the two")
    if scheduler is not None and jobs is not None:
        raise click.UsageError("--jobs is of this machine and --scheduler of others: choose one of the two")
    if denoise and not has_denoiser():
        raise click.UsageError("--denoise needs a package: pip install mitsuba-oidn")
    chosen = slice(frame, frame + 1) if frame is not None else frames
    cleans = has_denoiser() if denoise is None else denoise
    choices = Choices(quality, look, kind, spp, size, aperture, cleans, phase)
    made, new = render_run(
        run, choices, out, chosen, changes, exr, force, threads or 0, jobs, Told(quiet), scheduler
    )
    tell(f"{made}: {new} new pictures")
