"""The campaigns of `neve fuzz`: one entry each, from which the command line makes a command."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any


@dataclass(frozen=True)
class Campaign:
    """Describe a campaign: trials that are drawn from a seed and a number.

    name: its word on the command line. about: what it attacks and what must hold. things: what its trials
    are, in the plural. trial: "module:function"; the function takes (seed, number) and returns an
    `neve.fuzz.outcome.Outcome`; it runs in a process of its own, and whatever it raises is a failure.
    count: trials for each seed by default. limit: seconds [s] after which a trial is stuck, by default.
    summary: "module:function"; the function takes the list of outcomes and returns a sentence about them.
    methods: trials as `trial` that are drawn for one numerics.method alone, by its word.
    """

    name: str
    about: str
    things: str
    trial: str
    count: int
    limit: float
    summary: str | None = None
    methods: Mapping[str, str] = field(default_factory=dict)

    def by(self, method: str) -> Campaign:
        """Return the campaign whose trials are drawn for one method; its name says so."""
        return replace(self, name=f"{self.name} --method {method}", trial=self.methods[method])


CAMPAIGNS = {
    campaign.name: campaign
    for campaign in (
        Campaign(
            name="scenes",
            about="Random scenes of any method and law, with parameters over their ranges, that collide, are"
            " pressed and stirred: no crash, no NaN, nothing lost, mass exact, no energy from nowhere.",
            things="scenes",
            trial="neve.fuzz.scenes.trial:endure",
            count=200,
            limit=600.0,
            summary="neve.fuzz.scenes.trial:summary",
            methods={
                "mpm": "neve.fuzz.scenes.trial:endure_mpm",
                "particles": "neve.fuzz.scenes.trial:endure_particles",
                "sph": "neve.fuzz.scenes.trial:endure_sph",
            },
        ),
        Campaign(
            name="files",
            about="Scenes, meshes, height maps, fonts, robots, checkpoints and frames with damaged bytes,"
            " numbers and words: each is read, or refused in one sentence; no traceback, no crash, no hang.",
            things="files",
            trial="neve.fuzz.files.trial:read_damaged",
            count=1000,
            limit=90.0,
            summary="neve.fuzz.files.trial:summary",
        ),
        Campaign(
            name="kills",
            about="Runs that are killed at random moments, whose folders are hurt, and that are resumed: the"
            " bytes of a run in one go, or one sentence; nothing outside the folder touched.",
            things="runs",
            trial="neve.fuzz.kills.trial:kill_and_resume",
            count=100,
            limit=600.0,
            summary="neve.fuzz.kills.trial:summary",
        ),
    )
}
"""Campaigns by their names; `neve fuzz` alone is the first."""


def named(place: str) -> Callable[..., Any]:
    """Return the function of "module:function"."""
    module, _, name = place.partition(":")
    function: Callable[..., Any] = getattr(import_module(module), name)
    return function
