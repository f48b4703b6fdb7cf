"""The command `neve fuzz`: run a campaign and tell its outcomes as they come."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from neve.fuzz.outcome import VERDICTS, Outcome
from neve.fuzz.record import Record
from neve.fuzz.registry import Campaign, named
from neve.fuzz.workers import outcomes, scratch

MOST_REFUSED = 0.5
"""Share of trials above which a campaign tests little, and so does not hold."""

FEWEST = 20
"""Trials from which on that share says something."""


def run(
    campaign: Campaign,
    seeds: range = range(1),
    count: int | None = None,
    only: int | None = None,
    jobs: int = 1,
    limit: float | None = None,
    as_json: bool = False,
    out: str | None = None,
) -> bool:
    """Run the trials 0 to `count` - 1 of each seed, or `only` one of each; return whether all held.

    jobs: processes at once. limit: seconds [s] for a trial. out: a file of JSON lines; what it holds already
    is not run again. With `as_json` outcomes are printed as JSON lines.

    Errors: RunError for `out`; KeyboardInterrupt, after a summary, for Ctrl-C.
    """
    numbers = range(count or campaign.count) if only is None else range(only, only + 1)
    record = None if out is None else Record(Path(out), campaign.name)
    done = {} if record is None else record.done
    seen = [outcome for (seed, number), outcome in done.items() if seed in seeds and number in numbers]
    left = ((seed, number) for seed in seeds for number in numbers if (seed, number) not in done)
    total = len(seeds) * len(numbers)
    told = sys.stderr if as_json else sys.stdout
    try:
        for outcome in _run(campaign, left, min(jobs, total), limit or campaign.limit):
            seen.append(outcome)
            if record is not None:
                record.add(outcome)
            print(outcome.as_json() if as_json else outcome.as_text(), flush=True)
    except KeyboardInterrupt:
        print(summary(campaign, seen), file=told, flush=True)
        again = "" if record is None else ", and the same command goes on"
        raise KeyboardInterrupt(
            f"stopped: {len(seen):,} of {total:,} {campaign.things} are done{again}"
        ) from None
    finally:
        if record is not None:
            record.close()
    print(summary(campaign, seen), file=told, flush=True)
    return holds(seen)


def _run(campaign: Campaign, trials: Iterator[tuple[int, int]], jobs: int, limit: float) -> Iterator[Outcome]:
    with scratch() as folder:
        yield from outcomes(campaign.trial, trials, jobs, limit, folder)


def holds(seen: Sequence[Outcome]) -> bool:
    """Return whether nothing failed, and no more was refused than a share of MOST_REFUSED."""
    verdicts = Counter(outcome.verdict for outcome in seen)
    return not verdicts["failed"] and not _tests_little(seen)


def _tests_little(seen: Sequence[Outcome]) -> bool:
    refused = sum(outcome.verdict == "refused" for outcome in seen)
    return len(seen) >= FEWEST and refused > MOST_REFUSED * len(seen)


def summary(campaign: Campaign, seen: Sequence[Outcome]) -> str:
    """Count the verdicts, say what the campaign says of its numbers, and how to run again what failed."""
    verdicts = Counter(outcome.verdict for outcome in seen)
    counts = ", ".join(f"{verdicts[verdict]:,} {verdict}" for verdict in VERDICTS)
    busy = sum(outcome.seconds for outcome in seen)
    lines = [f"{len(seen):,} {campaign.things}: {counts}; {busy:,.0f} s of work"]
    if campaign.summary is not None and seen:
        lines.append(named(campaign.summary)(seen))
    if _tests_little(seen):
        lines.append("most were refused, so this campaign tests little else")
    lines += [
        f"failed: neve fuzz {campaign.name} --seed {outcome.seed} --only {outcome.number}"
        f"  ({outcome.sentence})"
        for outcome in sorted(seen, key=lambda outcome: (outcome.seed, outcome.number))
        if outcome.verdict == "failed"
    ]
    return "\n".join(lines)
