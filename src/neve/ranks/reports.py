"""What all ranks have found, in the place of what one of them has."""

from __future__ import annotations

from typing import TYPE_CHECKING

from neve.domains.reports import NodeReport, ParticleReport
from neve.ranks.world import World

if TYPE_CHECKING:
    from neve._core import GridReport, Report


def report_of_all(world: World, mine: Report) -> ParticleReport:
    """Return the extremes over the particles of all ranks."""
    most = (mine.wave, mine.speed, mine.fastest, mine.strain_rate, mine.compression_rate)
    least = -mine.min_volume_ratio, -mine.ice_room, -float(mine.offending_id)
    found = world.most([*most, mine.max_displacement, *least, not mine.finite, mine.drifted]).tolist()
    wave, speed, fastest, strain, compression, way, volume, ice, offender, broken, drifted = found
    return ParticleReport(
        wave, speed, fastest, strain, compression, way, -volume, -ice,
        finite=not broken, drifted=bool(drifted), offending_id=int(-offender),
    )  # fmt: skip


def grid_report_of_all(world: World, mine: GridReport) -> NodeReport:
    """Return the extremes over the nodes of all ranks."""
    most = mine.speed, mine.max_velocity_difference, mine.max_velocity_change
    speed, difference, change, broken = world.most([*most, not mine.finite]).tolist()
    return NodeReport(speed, difference, change, not broken)
