"""What the kernels found, as the stages of the processor report it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from neve.cuda.layout import EXTREMES, RATES, decoded

NOBODY = 0xFFFFFFFF
"""No particle's birth number."""


class DeviceReport(NamedTuple):
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


class DeviceGridReport(NamedTuple):
    """What grid_update found; see `neve._core.GridReport`."""

    speed: float
    max_velocity_difference: float
    max_velocity_change: float
    finite: bool


def extremes(results: dict[str, Any]) -> dict[str, float]:
    """Return the maxima that kernels have found, by name."""
    return dict(zip(EXTREMES, decoded(results["most"]).tolist(), strict=True))


def report_of(results: dict[str, Any], stepped: bool) -> DeviceReport:
    """Return what was found in the particles; stepped: in a step, not in the state as it was."""
    most = extremes(results)
    return DeviceReport(
        wave=most["wave"],
        speed=most["speed"],
        fastest=most["fastest"],
        strain_rate=math.sqrt(most["rate2"]),
        compression_rate=most["compression"],
        max_displacement=math.sqrt(most["displacement2"]),
        min_volume_ratio=-most["less_volume"] if most["wave"] or stepped else 1.0,
        ice_room=-most["less_ice_room"] if most["less_ice_room"] else math.inf,
        finite=not results["not_finite"],
        drifted=bool(results["drifted"]),
        offending_id=int(results["offender"]) ^ NOBODY if stepped else NOBODY,
    )


def grid_report_of(results: dict[str, Any]) -> DeviceGridReport:
    """Return what was found in the nodes."""
    most = extremes(results)
    return DeviceGridReport(
        math.sqrt(most["node_speed"]),
        math.sqrt(most["node_difference"]),
        math.sqrt(3.0) * most["node_change"],
        not results["not_finite"],
    )


def last_report(control: Any) -> DeviceReport:
    """Return what was found in the particles by the last step that the GPU took by itself."""
    return DeviceReport(
        **{name: float(control[name]) for name in (*RATES, "max_displacement", "min_volume_ratio")},
        finite=not control["broken"],
        drifted=bool(control["drifted"]),
        offending_id=NOBODY,
    )
