"""What passes found, in the shape of the core's own reports, where it comes from several domains or a GPU."""

from __future__ import annotations

from typing import NamedTuple


class ParticleReport(NamedTuple):
    """What g2p or refresh found; see `neve._core.Report`."""

    wave: float
    speed: float
    fastest: float
    strain_rate: float
    compression_rate: float
    max_displacement: float
    min_volume_ratio: float
    ice_room: float
    finite: bool
    drifted: bool
    offending_id: int


class NodeReport(NamedTuple):
    """What grid_update found; see `neve._core.GridReport`."""

    speed: float
    max_velocity_difference: float
    max_velocity_change: float
    finite: bool
