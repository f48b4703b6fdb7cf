"""The command `neve compare`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from neve.cli.console import tell, thread_count, whole_number

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene


@click.command()
@click.argument("scene")
@click.option("--methods", metavar="A,B", help="Methods to compare; all that there are by default.")
@click.option("--out", metavar="DIR", help="Folder of the comparison; comparisons/NAME by default.")
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="Change a value: snow.xi=12.")
@click.option("--frames", metavar="N", callback=whole_number, help="Stop after frame N.")
@click.option("--threads", metavar="N", callback=thread_count, help="Number of threads; all by default.")
@click.option("--force", is_flag=True, help="Replace runs that are already in the folder.")
@click.option("--quiet", is_flag=True, help="Hide progress.")
def compare(
    scene: str,
    methods: str | None,
    out: str | None,
    changes: tuple[str, ...],
    frames: int | None,
    threads: int | None,
    force: bool,
    quiet: bool,
) -> None:
    """Simulate SCENE by several methods on the same clock, and show them side by side.

    Writes a run folder for each method, a film of all, a table and a page, docs/methods.md says of what.
    """
    from neve.compare.page import PAGE
    from neve.compare.run import chosen_methods, table
    from neve.compare.run import compare as run
    from neve.scene.reading.load import load

    chosen = chosen_methods(methods)
    folder = Path(out) if out is not None else Path("comparisons") / Path(scene).stem

    def scene_by(method: str) -> Scene:
        return load(scene, [*changes, f'numerics.method="{method}"', "run.film=false"])

    found = run(scene_by, chosen, folder, frames, threads, force, quiet)
    click.echo(table(found), nl=False)
    for part in found:
        if part.refused:
            tell(f"{part.method}: {part.refused}")
    tell(f"{folder / PAGE}")
