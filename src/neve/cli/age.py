"""The command `neve age`."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import click

from neve.cli.console import others_reported, tell, thread_count
from neve.cli.render import Told

F = TypeVar("F", bound=Callable[..., Any])


def _number(low: float, high: float) -> Any:
    """Return what reads a finite number in a range."""

    def read(ctx: click.Context, param: click.Parameter, value: float | None) -> float | None:
        if value is not None and not (math.isfinite(value) and low <= value <= high):
            raise click.BadParameter(f"{value:g} is not a number from {low:g} to {high:g}", ctx, param)
        return value

    return read


def _weather(name: str, low: float, high: float, meaning: str) -> Callable[[F], F]:
    """Return an option that is a number from `low` to `high`."""
    return click.option(name, type=float, callback=_number(low, high), help=meaning)


@click.command()
@click.argument("snow", metavar="FOLDER|SCENE")
@click.option("--out", metavar="FOLDER", help="Folder to write; aged/NAME by default.")
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="Change a value of the scene.")
@click.option("--days", type=float, default=1.0, callback=_number(0.0, 365.0), help="How long; 1 by default.")
@_weather("--air", -60.0, 40.0, "Mean temperature of the air; -5 by default [deg C].")
@_weather("--swing", 0.0, 40.0, "How much warmer it is at 14 h; 0 by default [K].")
@_weather("--sun", 0.0, 1400.0, "Power of the sun at noon, shining from 6 to 18 h; 0 by default [W/m2].")
@_weather("--albedo", 0.0, 1.0, "Share of it that snow throws back; 0.8 by default.")
@_weather("--exchange", 0.0, 1000.0, "Of heat with the air; 15 by default [W/(m2 K)].")
@_weather("--ground", -60.0, 0.0, "Temperature of the ground; left out, it insulates [deg C].")
@click.option("--threads", metavar="N", callback=thread_count, help="Number of threads; all by default.")
@click.option("--quiet", is_flag=True, help="Hide progress.")
def age(
    snow: str,
    out: str | None,
    changes: tuple[str, ...],
    days: float,
    threads: int | None,
    quiet: bool,
    **given: float | None,
) -> None:
    """Let days pass over snow: in a FOLDER that `neve snow` or `neve age` wrote, or of SCENE.

    It settles, warms and cools, melts, freezes again, and sinters. Writes what it has become as `neve snow`
    does, with the balance of mass and heat in books.json, and the layers on average (layers.csv). Days begin
    at midnight. Of a scene, it is the last snow that falls, lies, or is a level layer.
    """
    from neve.ageing.days import Weather
    from neve.run.age import age as let_age

    weather = Weather(**{name: value for name, value in given.items() if value is not None})
    told = Told(quiet, "age", "day")
    with others_reported():
        cover, balance, folder = let_age(
            snow, days, weather, out, changes, threads, lambda done, of: told(done, of, done)
        )
    ran_off = f"{balance.mass_ran_off:.4g} kg ran off"
    tell(f"{folder}: {cover.volume:.4g} m3 of snow of {cover.density:.4g} kg/m3 lie on average; {ran_off}")
