"""`neve drive`: the car on game snow, its snow fitted to runs, and its ground snowed on."""

from __future__ import annotations

import click

from neve.cli.console import tell


@click.command()
@click.option(
    "--host", metavar="HOST", default="127.0.0.1", help="Address to listen on; this machine alone by default."
)
@click.option(
    "--port", type=click.IntRange(0, 65535), help="Port; by default the first free one from 8440 on."
)
@click.option("--open", "browse", is_flag=True, help="Open the page in this machine's browser.")
@click.option(
    "--fit",
    "runs",
    metavar="RUN",
    multiple=True,
    help="Fit the game's snow to the wheel of this run folder first, and play the run's snow beside the car; "
    "once for each run.",
)
@click.option("--wheel", metavar="NAME", help="With --fit: the body that is the wheel, as bodies.2.")
@click.option(
    "--snow",
    metavar="FOLDER",
    help="Begin on ground and snow of this folder of `neve snow`; FOLDER/ground.json then holds them.",
)
@click.option("--no-page", is_flag=True, help="With --fit or --snow: write the file, serve nothing.")
def drive(
    host: str,
    port: int | None,
    browse: bool,
    runs: tuple[str, ...],
    wheel: str | None,
    snow: str | None,
    no_page: bool,
) -> None:
    """Drive a car on game snow in the browser: fast, pretty and not physical."""
    from neve.drive import drive as serve
    from neve.drive import fit_runs, write_ground

    if not runs and wheel is not None:
        raise click.UsageError("--wheel needs --fit RUN.")
    if not runs and snow is None and no_page:
        raise click.UsageError("--no-page needs --fit RUN or --snow FOLDER.")
    recordings = [fit_runs(runs, wheel, tell)[1]] if runs else []
    ground = write_ground(snow) if snow is not None else None
    if not no_page:
        serve(host, port, browse, tell, recordings, ground)
    elif ground is not None:
        tell(f"{ground}: the ground for the page")
