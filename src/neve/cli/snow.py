"""The command `neve snow`."""

from __future__ import annotations

from typing import Any

import click

from neve.cli.console import others_reported, tell, thread_count
from neve.cli.render import Told


def _pair(ctx: click.Context, param: click.Parameter, value: str | None) -> tuple[float, float] | None:
    """Read X,Y."""
    if value is None:
        return None
    try:
        x, y = (float(word) for word in value.split(","))
    except ValueError:
        raise click.BadParameter(f"{value} is not of the form 3,-1.5", ctx, param) from None
    return x, y


@click.command()
@click.argument("scene", metavar="SCENE|MESH|RUN")
@click.option("--out", metavar="FOLDER", help="Folder to write; snow/NAME by default.")
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="Change a value of the scene.")
@click.option("--depth", type=float, metavar="M", help="Depth of new snow on level open ground [m].")
@click.option("--rate", type=float, metavar="R", help="How fast it snows, in place of a depth [mm water/h].")
@click.option("--duration", type=float, metavar="H", help="How long it snows, with a rate [h].")
@click.option(
    "--temperature", type=float, metavar="T", help="Of the air, for the density of the snow [deg C]."
)
@click.option(
    "--density", type=float, metavar="RHO", help="Of the new snow, in place of a temperature [kg/m3]."
)
@click.option("--wind", metavar="X,Y", callback=_pair, help="Velocity of the wind [m/s].")
@click.option("--drift", type=float, metavar="H", help="How long the wind then moves what lies [h].")
@click.option("--drift-wind", metavar="X,Y", callback=_pair, help="In another wind [m/s].")
@click.option("--flutter", type=float, metavar="M", help="How far flakes swing aside over 1 m of fall [m].")
@click.option("--repose", type=float, metavar="DEG", help="Angle of repose [degrees].")
@click.option(
    "--stability",
    type=click.Choice(["repose", "snowslide", "none"]),
    help="Which snow slides; repose by default.",
)
@click.option("--steps", type=int, metavar="N", help="Parts in which it falls.")
@click.option("--cell", type=float, metavar="M", help="Spacing of the places at which snow is counted [m].")
@click.option(
    "--center", metavar="X,Y", callback=_pair, help="Middle of the rectangle on which it snows [m]."
)
@click.option("--size", metavar="X,Y", callback=_pair, help="Its extent [m]; by default around all there is.")
@click.option("--ground", type=float, metavar="Z", help="Put level ground at this height below a mesh [m].")
@click.option(
    "--tolerance", type=float, metavar="E", help="Standard error of the share that reaches a place."
)
@click.option("--seed", type=int, metavar="N", help="Seed of the flakes.")
@click.option(
    "--film",
    type=click.IntRange(2, 100_000),
    metavar="N",
    help="Film how the snow of a scene grows, in N frames: FOLDER/fall is a run with preview.mp4.",
)
@click.option("--threads", metavar="N", callback=thread_count, help="Number of threads; all by default.")
@click.option("--quiet", is_flag=True, help="Hide progress.")
def snow(
    scene: str,
    out: str | None,
    changes: tuple[str, ...],
    film: int | None,
    threads: int | None,
    quiet: bool,
    **given: Any,
) -> None:
    """Let it snow on SCENE, a MESH (OBJ, PLY, STL, GLB or GLTF) or what a RUN has left; write what lies.

    Writes the snow as a closed mesh (snow.ply), how deep it lies at each place (depth.csv), its layers, which
    scenes and `neve age` read (cover.npz), and where all of it has gone (books.json). Of a scene, its last
    source of the shape snowfall says how it snows; options change that. Of a run folder, snow and bodies lie
    where they are at its end; also written are its snow (rest.npz), and the scene of a next run, with both
    snows (scene.toml).
    """
    from neve.run.snowfall import snow_on

    chosen = {name: value for name, value in given.items() if value is not None}
    ground = chosen.pop("ground", None)
    told = Told(quiet, "snow", "part")
    with others_reported():
        cover, folder = snow_on(
            scene, out, changes, chosen, ground, threads, lambda done, of: told(done, of, done),
            film, Told(quiet, "film"),
        )  # fmt: skip
    books = cover.books
    lost = f"{books.missed:.4g} m3 missed every place and {books.slid:.4g} m3 slid away"
    tell(f"{folder}: {books.lies:.4g} m3 of snow lie, of {books.fell:.4g} m3 that fell; {lost}")
