"""The command `neve film`."""

from __future__ import annotations

import click

from neve.cli.console import tell, thread_count
from neve.cli.export import frame_slice
from neve.cli.render import Told, pixels


@click.command()
@click.argument("run", metavar="RUN")
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="Change camera or light.")
@click.option("--out", metavar="FILE", help="The film; RUN/preview.mp4 by default.")
@click.option(
    "--frames",
    metavar="A:B[:STEP]",
    callback=frame_slice,
    help="Frames from A up to, without, B; all by default.",
)
@click.option("--size", metavar="WxH", callback=pixels, help="Size of the pictures; 1280x720 by default.")
@click.option("--threads", metavar="N", callback=thread_count, help="Number of threads; all by default.")
@click.option("--quiet", is_flag=True, help="Hide progress.")
def film(
    run: str,
    changes: tuple[str, ...],
    out: str | None,
    frames: slice | None,
    size: tuple[int, int] | None,
    threads: int | None,
    quiet: bool,
) -> None:
    """Draw the preview film of the run folder RUN anew, with another camera or light.

    It is drawn from the frames, without simulating anything. Without --out it replaces RUN/preview.mp4, and
    RUN/preview.png is drawn with it; the scene of the run stays as it was run.
    """
    from neve.run.film import film_run

    tell(f"{film_run(run, changes, out, frames, size, threads, Told(quiet, 'film'))}")
