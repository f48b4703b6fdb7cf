"""The commands of `neve fuzz`: one for each campaign, all with the same options."""

from __future__ import annotations

import os
from typing import Any

import click

from neve.cli.console import Commands, thread_count, whole_number
from neve.fuzz.registry import CAMPAIGNS, Campaign


class Campaigns(Commands):
    """Take the first campaign where none is named."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the first campaign before options that are not of the group."""
        if not args or (args[0].startswith("-") and args[0] not in ("-h", "--help")):
            args = [next(iter(CAMPAIGNS)), *args]
        return super().parse_args(ctx, args)


@click.group(cls=Campaigns)
def fuzz() -> None:
    """Try to break Neve with what is drawn from seeds; `neve fuzz` alone draws scenes.

    Exit code 1 if something failed. What was drawn and refused in one sentence is counted apart.
    """


def seed_range(ctx: click.Context, param: click.Parameter, value: str | None) -> range | None:
    """Read A:B, the seeds from A up to but not with B."""
    if value is None:
        return None
    words = value.split(":")
    if not (len(words) == 2 and all(w.isascii() and w.isdigit() and len(w) < 19 for w in words)):
        raise click.BadParameter(f"{value} is not of the form A:B, such as 0:50", ctx, param)
    seeds = range(int(words[0]), int(words[1]))
    if not seeds:
        raise click.BadParameter(f"{value} holds no seed: B must be more than A", ctx, param)
    return seeds


def seconds(ctx: click.Context, param: click.Parameter, value: float | None) -> float | None:
    """Check a time [s]."""
    if value is not None and not 0 < value <= 86400:
        raise click.BadParameter(f"{value} is not a time from 0 to 86400 s", ctx, param)
    return value


def _options(campaign: Campaign) -> list[Any]:
    """Return the options of the command of a campaign, as decorators."""
    things = campaign.things
    options = [
        click.option("--seed", type=click.IntRange(0, 10**18), metavar="S", help="Seed; 0 by default."),
        click.option("--seeds", metavar="A:B", callback=seed_range, help="Seeds from A up to, without, B."),
        click.option(
            "--count",
            metavar="N",
            callback=whole_number,
            help=f"How many {things} of each seed; {campaign.count:,} by default.",
        ),
        click.option(
            "--only",
            type=click.IntRange(0, 10**18),
            metavar="N",
            help=f"Of each seed, only number N of the {things}.",
        ),
        click.option(
            "--jobs", metavar="N", callback=thread_count, help="Processes at once; one per core by default."
        ),
        click.option(
            "--limit",
            type=float,
            metavar="S",
            callback=seconds,
            help=f"Seconds for each; {campaign.limit:g} by default.",
        ),
        click.option("--json", "as_json", is_flag=True, help="Print a line of JSON for each."),
        click.option("--out", metavar="FILE", help="Write them to FILE too; if it is there, go on with it."),
    ]
    if campaign.methods:
        words = click.Choice(list(campaign.methods))
        options.append(click.option("--method", type=words, help="Draw for this numerics.method alone."))
    return options


def _command(campaign: Campaign) -> click.Command:
    """Make the command of a campaign."""

    def run(
        seed: int | None,
        seeds: range | None,
        count: int | None,
        only: int | None,
        jobs: int | None,
        limit: float | None,
        as_json: bool,
        out: str | None,
        method: str | None = None,
    ) -> None:
        if seed is not None and seeds is not None:
            raise click.UsageError("--seed and --seeds: give one of the two")
        if count is not None and only is not None:
            raise click.UsageError("--count and --only: give one of the two")
        from neve.fuzz.run import run as attack

        chosen = seeds or range(seed or 0, (seed or 0) + 1)
        drawn = campaign if method is None else campaign.by(method)
        if not attack(drawn, chosen, count, only, jobs or os.cpu_count() or 1, limit, as_json, out):
            raise SystemExit(1)

    decorated = run
    for option in reversed(_options(campaign)):
        decorated = option(decorated)
    return click.command(campaign.name, help=campaign.about)(decorated)


for _campaign in CAMPAIGNS.values():
    fuzz.add_command(_command(_campaign))
