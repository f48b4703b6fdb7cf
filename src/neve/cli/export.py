"""The command `neve export`."""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING, Literal

import click

from neve.cli.console import tell
from neve.export.registry import FORMATS
from neve.spelling import hint, nearest

if TYPE_CHECKING:
    from neve.run.progress import Progress


def frame_slice(ctx: click.Context, param: click.Parameter, value: str | None) -> slice | None:
    """Read A:B or A:B:STEP: frames from A up to but not with B; either may be left out. N is one frame."""
    if value is None:
        return None
    words = value.split(":")
    if len(words) > 3 or any(
        word and not (word.isascii() and word.isdigit() and len(word) < 10) for word in words
    ):
        raise click.BadParameter(f"{value} is not of the form A:B or A:B:STEP, such as 0:50", ctx, param)
    if len(words) == 1:
        if not value:
            raise click.BadParameter("give a frame, or frames as A:B", ctx, param)
        return slice(int(value), int(value) + 1)
    start, stop, step = (int(word) if word else None for word in [*words, ""][:3])
    if step == 0:
        raise click.BadParameter(f"{value} has a step of 0: use 1 or more", ctx, param)
    return slice(start, stop, step)


def format_word(ctx: click.Context, param: click.Parameter, value: str) -> str:
    """Check the word of a format."""
    if value not in FORMATS.names():
        known = f"the formats are {', '.join(FORMATS.names())}"
        raise click.BadParameter(
            f"there is no format {value}{hint(nearest(value, FORMATS.names()), known)}", ctx, param
        )
    return value


def factor(ctx: click.Context, param: click.Parameter, value: float) -> float:
    """Check a factor on lengths."""
    if not (math.isfinite(value) and 1e-6 <= value <= 1e6):
        raise click.BadParameter(f"{value} is not a number from 1e-6 to 1e6", ctx, param)
    return value


class Shown:
    """Show how far an export is; it may be called once its `stack` has been entered."""

    def __init__(self, stack: contextlib.ExitStack, name: str, quiet: bool) -> None:
        self._stack, self._name, self._quiet = stack, name, quiet
        self._progress: Progress | None = None

    def __call__(self, done: int, of: int, particles: int) -> None:
        """Show that `done` of so many frames are there, the last with so many particles."""
        if self._progress is None:
            from neve.run.progress import follow

            self._progress = self._stack.enter_context(follow(self._name, 0, of, self._quiet))
        self._progress.update(done, particles, 0)


@click.command(
    help="Write the frames of the run folder RUN as files that other tools open. The same command goes on"
    " where it was stopped.\n\n\b\n"
    + "\n".join(f"{word:4} {what}" for word, what in FORMATS.meanings.items())
)
@click.argument("run", metavar="RUN")
@click.option(
    "--to",
    metavar="FORMAT",
    required=True,
    callback=format_word,
    help="Format; see docs/into_other_tools.md.",
)
@click.option("--out", metavar="FOLDER", help="Folder for the files; RUN/FORMAT by default.")
@click.option(
    "--frames",
    metavar="A:B[:STEP]",
    callback=frame_slice,
    help="Frames from A up to, without, B; all by default.",
)
@click.option("--fields", metavar="NAME,...", help="Fields of the particles; those of the frames by default.")
@click.option("--up", type=click.Choice(["y", "z"]), help="Axis that points up; what is usual by default.")
@click.option(
    "--scale", type=float, default=1.0, metavar="S", callback=factor, help="Units in a metre; 1 by default."
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="Dask cluster that writes instead, such as tcp://host:8786."
)
@click.option("--force", is_flag=True, help="Begin anew; else frames that are there already are kept.")
@click.option("--quiet", is_flag=True, help="Hide progress.")
def export(
    run: str,
    to: str,
    out: str | None,
    frames: slice | None,
    fields: str | None,
    up: Literal["y", "z"] | None,
    scale: float,
    scheduler: str | None,
    force: bool,
    quiet: bool,
) -> None:
    """Write the frames of a run folder as files that other tools open."""
    from neve.export.run import Choices, export_run

    asked = None if fields is None else tuple(name for name in fields.split(",") if name)
    choices = Choices(to, asked, up, scale)
    with contextlib.ExitStack() as stack:
        shown = Shown(stack, to, quiet)
        target, new = export_run(run, choices, out, frames, force, shown, scheduler)
    tell(f"{target}: {new} new frames")
