"""The option --fine: the grid with which a scene has two million particles."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import click

from neve.cli.console import report

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene


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
