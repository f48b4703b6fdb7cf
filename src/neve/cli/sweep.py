"""The commands `neve sweep` and `neve plot`."""

from __future__ import annotations

from pathlib import Path

import click

from neve.cli.console import report, tell, thread_count, whole_number
from neve.cli.render import Told


@click.command()
@click.argument("scene", required=False)
@click.option(
    "--vary",
    "varied",
    metavar="KEY=VALUES",
    multiple=True,
    help="Values of a key, such as snow.xi=5,10 or snow.E0=1e5..1e6:4:log (four of a range).",
)
@click.option(
    "--design",
    type=click.Choice(["grid", "together", "latin"]),
    default="grid",
    help="How values are combined: all with all, first with first, or as a Latin hypercube; grid by default.",
)
@click.option("--samples", metavar="N", callback=whole_number, help="Runs of a Latin hypercube.")
@click.option("--seed", type=click.IntRange(min=0), default=0, help="Of a Latin hypercube; 0 by default.")
@click.option("--plan", metavar="FILE", help="Read all this from a TOML file instead; see docs/sweeps.md.")
@click.option(
    "--output",
    "outputs",
    metavar="NAME=COLUMN@WHEN",
    multiple=True,
    help="Column of the table, such as peak=kinetic@max; all of the log at the end by default.",
)
@click.option(
    "--function",
    "functions",
    metavar="FILE.py:NAME",
    multiple=True,
    help="Function of a run folder that returns a number, or numbers by name.",
)
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="Change a value in all runs.")
@click.option("--frames", metavar="N", callback=whole_number, help="Stop each run after frame N.")
@click.option("--out", metavar="DIR", help="Folder of the sweep; sweeps/NAME by default.")
@click.option(
    "--workers", metavar="N", callback=whole_number, help="Processes; one per processor by default."
)
@click.option("--threads", metavar="N", callback=thread_count, help="Threads of each run.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask cluster to use, such as tcp://host:8786.")
@click.option("--force", is_flag=True, help="Begin all runs anew; else runs that are there are kept.")
@click.option("--quiet", is_flag=True, help="Hide progress.")
def sweep(
    scene: str | None,
    varied: tuple[str, ...],
    design: str,
    samples: int | None,
    seed: int,
    plan: str | None,
    outputs: tuple[str, ...],
    functions: tuple[str, ...],
    changes: tuple[str, ...],
    frames: int | None,
    out: str | None,
    workers: int | None,
    threads: int | None,
    scheduler: str | None,
    force: bool,
    quiet: bool,
) -> int:
    """Run SCENE with many values, and write one table of what came out.

    Each run is a run folder in sweeps/NAME; sweep.csv there has a row for each. The same command goes on
    where it was stopped, also with more values. Exit code 1 if a run failed; its row says why.
    """
    from neve.sweep.design import read_vary
    from neve.sweep.measures import read_function, read_measure
    from neve.sweep.plan import points_of, read_plan
    from neve.sweep.run import Sweep
    from neve.sweep.run import sweep as carry_out
    from neve.sweep.table import CSV, FAILED

    if (plan is None) == (scene is None):
        raise click.UsageError("name either a SCENE, with --vary, or a file with --plan")
    if plan is not None:
        if varied or outputs or functions or changes or samples or frames:
            raise click.UsageError("--plan says all that the runs are: leave the other options out")
        what = read_plan(Path(plan))
    else:
        assert scene is not None
        points = points_of([read_vary(text) for text in varied], design, samples, seed)
        measures, own = [read_measure(text) for text in outputs], [read_function(text) for text in functions]
        what = Sweep(scene, points, changes, measures, own, frames)
    if not what.points:
        raise click.UsageError("nothing varies: name a key and its values by --vary, such as snow.xi=5,10")
    folder = Path(out) if out is not None else Path("sweeps") / Path(plan or what.scene).stem
    rows = carry_out(what, folder, workers, threads, scheduler, force, Told(quiet, "sweep", "run"))
    failed = [row for row in rows if row.status == FAILED]
    for row in failed:
        report(
            f"{row.run} ({', '.join(f'{key}={value}' for key, value in row.point.items())}): {row.sentence}"
        )
    tell(f"{folder / CSV}: {len(rows)} runs" + (f", {len(failed)} failed" if failed else ""))
    return 1 if failed else 0


@click.command()
@click.argument("table", metavar="SWEEP")
@click.option("--x", metavar="KEY", help="Input along the axis; the first that varies by default.")
@click.option("--y", metavar="OUTPUT", multiple=True, help="Output to draw; the first six by default.")
@click.option("--by", metavar="KEY", help="Input with a line for each value; the second by default.")
@click.option("--out", metavar="FILE", help="PNG, SVG or PDF; SWEEP/sweep.png by default.")
def plot(table: str, x: str | None, y: tuple[str, ...], by: str | None, out: str | None) -> None:
    """Draw the outputs of the folder SWEEP, or of its table, over what varies."""
    from neve.sweep.plot import plot as draw

    tell(f"{draw(Path(table), None if out is None else Path(out), x, y, by)}")
