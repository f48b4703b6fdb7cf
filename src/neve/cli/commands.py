"""The command line: a function for each command, from `list` to `cite`.

Exit code 0 is success, 1 is a validation or campaign that fails, 2 is bad input or a run that could not go on
(one sentence on standard error), 130 is Ctrl-C, 143 SIGTERM, 129 SIGHUP, 141 a reader of the output that has
gone. Everything but click is imported inside the command that needs it, so that `neve --help` is instant.
"""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from neve.cli.age import age
from neve.cli.campaigns import fuzz
from neve.cli.compare import compare
from neve.cli.console import (
    Commands,
    others_reported,
    output_code,
    report,
    tell,
    thread_count,
    usage,
    user_error,
    whole_number,
)
from neve.cli.drive import drive
from neve.cli.estimate import announce, estimate, finer
from neve.cli.export import export
from neve.cli.film import film
from neve.cli.render import render
from neve.cli.snow import snow
from neve.cli.sweep import plot, sweep
from neve.ranks import launch
from neve.system import stopping, streams


@click.group(
    cls=Commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.option("--version", is_flag=True, help="Show the version and exit.")
@click.pass_context
def cli(ctx: click.Context, version: bool) -> None:
    """Neve, a snow laboratory: simulate snow and film it."""
    if version:
        from neve.io.version import version as installed

        click.echo(f"neve {installed()}")
        ctx.exit()
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


@cli.command("list")
@click.option("--snow", is_flag=True, help="List the named snows instead.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def list_scenes(snow: bool, as_json: bool) -> None:
    """List the scenes that come with Neve, or its named snows."""
    if snow:
        from neve.scene.reading.snow_tables import as_data, as_text

        click.echo(json.dumps(as_data(), indent=2) if as_json else as_text())
        return
    from neve.scene.reading.presets import preset_about, presets

    about = {name: preset_about(name) for name in presets()}
    if as_json:
        click.echo(json.dumps([{"name": name, "about": text} for name, text in about.items()], indent=2))
        return
    width = max((len(name) for name in about), default=0)
    for name, text in about.items():
        click.echo(f"{name:{width}}  {text}")


@cli.command()
@click.argument("scene")
@click.option("--out", metavar="DIR", help="Run folder; runs/NAME by default.")
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="Change a value: snow.xi=12.")
@click.option("--device", metavar="WORD", help="Where to compute: cpu, cuda or auto, as numerics.device.")
@click.option("--fine", is_flag=True, help="Choose numerics.dx for two million particles, and wait.")
@click.option("--frames", metavar="N", callback=whole_number, help="Stop after frame N.")
@click.option(
    "--threads", metavar="N", callback=thread_count, help="Number of threads; by default one per core."
)
@click.option("--resume", is_flag=True, help="Continue the run from its checkpoint.")
@click.option("--force", is_flag=True, help="Replace a run that is already in the folder.")
@click.option("--quiet", is_flag=True, help="Hide progress; warnings and errors are still shown.")
def run(
    scene: str,
    out: str | None,
    changes: tuple[str, ...],
    device: str | None,
    fine: bool,
    frames: int | None,
    threads: int | None,
    resume: bool,
    force: bool,
    quiet: bool,
) -> int:
    """Simulate SCENE and film it.

    SCENE is the name of a scene that comes with Neve (`neve list`), a TOML file, or a run folder: its scene
    is run again or, with --resume, continued. `mpirun -n 4 neve run SCENE` shares it out over four ranks.
    """
    if not launch.leads():
        return launch.follow()
    from neve.io.run_folder import RunFolder
    from neve.scene.reading.load import load

    with launch.leading():
        if fine and resume:
            raise click.UsageError(
                "--fine chooses the grid of a new run, and a run that is resumed keeps its own: leave --fine"
                " out"
            )
        folder = _run_folder(scene, out, resume)
        if not resume:  # a folder in use is reported before the scene is read; a resume reads the folder's
            RunFolder(folder).check(resume, force)
        if device is not None:
            changes = (*changes, f"numerics.device={device}")
        checked = load(scene, changes)
        if fine:
            checked = finer(checked, changes)
        from neve.run import run_scene
        from neve.scene.checks.advice import advice

        reported = advice(checked)
        for sentence in reported:
            report(f"warning: {sentence}.")
        if not (resume or quiet):
            announce(checked, frames, threads)
        with others_reported(reported):
            run_scene(checked, folder, threads, frames, resume, force, quiet, over_ranks=launch.size() > 1)
    return 0


def _run_folder(scene: str, out: str | None, resume: bool) -> Path:
    """Return the folder to run in: `out`, the run itself when it is resumed, or runs/NAME."""
    from neve.scene.reading.presets import presets

    place = Path(scene)
    is_folder = scene not in presets() and _is_folder(place)
    if resume and is_folder:
        if out is not None and Path(out).resolve() != place.resolve():
            raise click.UsageError(f"--resume continues in {scene} itself: leave out --out {out}")
        return place
    if out is not None:
        return Path(out)
    if scene in presets():
        return Path("runs") / scene
    whole = Path(os.path.realpath(place))
    return Path("runs") / (whole.name if is_folder else whole.stem)


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:  # reading the scene will say what is wrong
        return False


@cli.command()
@click.argument("scene", metavar="SCENE|RUN")
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="Change a value: snow.xi=12.")
@click.option("--out", metavar="DIR", help="Folder for what pages save; the run's own, or runs/NAME-live.")
@click.option(
    "--host", metavar="HOST", default="127.0.0.1", help="Address to listen on; this machine alone by default."
)
@click.option(
    "--port", type=click.IntRange(0, 65535), help="Port; by default the first free one from 8420 on."
)
@click.option(
    "--threads",
    metavar="N",
    callback=thread_count,
    help="Threads; all by default, one less if others compute.",
)
@click.option("--open", "browse", is_flag=True, help="Open the page in this machine's browser.")
@click.option("--replay", metavar="FILE", help="Start no server; write a page that plays RUN by itself.")
def view(
    scene: str,
    changes: tuple[str, ...],
    out: str | None,
    host: str,
    port: int | None,
    threads: int | None,
    browse: bool,
    replay: str | None,
) -> None:
    """Simulate SCENE live in the browser, or play back RUN there.

    The link of a page, with #scene=NAME, opens the scene or run of that name.

    For a remote machine: ssh -L 8420:127.0.0.1:8420 MACHINE, and open the printed address locally.
    """
    from neve.viewer import view as show
    from neve.viewer import write_replay

    if replay is not None:
        write_replay(scene, replay)
    else:
        show(scene, changes, out, host, port, threads, browse, tell)


@cli.command()
@click.argument("run", metavar="RUN")
@click.option("--out", metavar="FILE", help="Table to write; by default RUN/fragments.csv.")
@click.option("--link", type=float, metavar="L", help="Link length in particle spacings.")
@click.option("--torn", type=float, metavar="J", help="J_P above which snow counts as torn.")
@click.option(
    "--least", metavar="N", callback=whole_number, help="Smaller pieces than N particles are powder."
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def fragments(
    run: str, out: str | None, link: float | None, torn: float | None, least: int | None, as_json: bool
) -> None:
    """Count the pieces of broken snow in every frame of the run folder RUN.

    Prints a summary of the last frame and writes all frames to fragments.csv.
    """
    from neve.fragments import Limits, summary
    from neve.run.outputs.fragments import count_run

    given = {
        name: value for name, value in (("link", link), ("torn", torn), ("least", least)) if value is not None
    }
    for name, value in given.items():
        if not 0 < value < math.inf:
            raise click.UsageError(f"--{name}: {value} is not a finite number greater than 0")
    limits = Limits(**given) if given else None  # type: ignore[arg-type]
    found = count_run(run, limits, None if out is None else Path(out))
    last = summary(found)
    if as_json:
        click.echo(json.dumps(last, indent=2))
        return
    click.echo(
        f"the last frame has {found.count} fragments over {last['decades']:.1f} decades of mass; the largest"
        f" holds {last['largest']:.1%} of the snow, the five largest {last['five']:.1%}, powder"
        f" {last['powder']:.1%}"
    )


@cli.command()
@click.argument("cases", metavar="[CASE]...", nargs=-1)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option(
    "--compare",
    "earlier",
    metavar="FILE",
    help="Print ratios to the latest speeds of the same cases in FILE: JSON of this command, or CSV of"
    " benchmarks/results.",
)
def bench(cases: tuple[str, ...], as_json: bool, earlier: str | None) -> None:
    """Measure the speed of the step on this machine."""
    from neve.bench.run import run as measure

    if as_json and earlier:
        raise click.UsageError("--compare prints text: leave out --json.")
    measure(list(cases), as_json, earlier)


@cli.command()
@click.argument("cases", metavar="[CASE]...", nargs=-1)
@click.option("--out", metavar="FILE", help="Report to write; by default validation.html.")
@click.option(
    "--json", "as_json", is_flag=True, help="Print JSON; then the report is written only with --out."
)
@click.option(
    "--threads",
    metavar="N",
    callback=thread_count,
    help="Number of cases to run at once; by default one per processor.",
)
def validate(cases: tuple[str, ...], out: str | None, as_json: bool, threads: int | None) -> int:
    """Run experiments with known answers and write a report. Exit code 1 if any fails."""
    from neve.validate.run import validate as run_cases

    return 0 if run_cases(cases, out, as_json, threads or os.cpu_count() or 1) else 1


for command in (compare, drive, estimate, film, render, export, fuzz, snow, age, sweep, plot):
    cli.add_command(command)


@cli.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def info(as_json: bool) -> None:
    """Show the version, the build of the core, the GPUs and the folder of the cache."""
    import platform

    import neve
    from neve import _core
    from neve.cuda import devices
    from neve.geometry import cache
    from neve.io.version import version
    from neve.isa import advice, carried, processor

    built, levels, builds = _core.build_info(), processor(), list(carried(neve.__path__))
    facts: dict[str, Any] = {
        "version": version(),
        **built,
        "isa_carried": builds,
        "isa_of_processor": levels,
        "isa_advice": advice(built["isa"], builds, levels),
        "python": platform.python_version(),
        "platform": platform.platform(),
        **devices.facts(),
        "cache": None if cache.folder() is None else str(cache.folder()),
        "cache_bytes": cache.size(),
    }
    if as_json:
        click.echo(json.dumps(facts, indent=2))
        return
    facts |= devices.in_text(facts)
    facts["cache"] = facts["cache"] or "off"
    facts["isa_carried"] = ", ".join(facts["isa_carried"]) or "one build alone"
    facts["isa_of_processor"] = ", ".join(facts["isa_of_processor"]) or "not x86-64"
    facts["isa_advice"] = facts["isa_advice"] or "none: the build uses all that the processor has"
    facts["cache_size"] = f"{facts.pop('cache_bytes') / 2**20:.1f} MB"
    for name, value in facts.items():
        click.echo(f"{name}: {value}")


@cli.command()
@click.argument("scene")
def cite(scene: str) -> None:
    """Print BibTeX entries for the methods that SCENE uses."""
    from neve.cli.cite import bibtex
    from neve.scene.reading.load import load

    click.echo(bibtex(load(scene)), nl=False)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit with its code."""
    streams.make_whole()
    with stopping.Ready():
        code = output_code(_code_of(arguments))
    sys.exit(code)


def _code_of(arguments: Sequence[str] | None) -> int:
    try:
        code = cli.main(args=arguments, prog_name="neve", standalone_mode=False)
    except (click.Abort, KeyboardInterrupt) as stop:
        cause = stop.__cause__ if isinstance(stop, click.Abort) else stop
        report(str(cause) if cause is not None and str(cause) else "stopped")
        return stopping.code()
    except click.ClickException as error:
        report(usage(error))
        return 2
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except (ImportError, MemoryError, OSError, RuntimeError, ValueError) as error:
        sentence = user_error(error)
        if sentence is None:
            raise
        report(sentence)
        return 2
    return code if isinstance(code, int) else 0
