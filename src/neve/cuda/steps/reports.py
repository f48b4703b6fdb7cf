"""What the kernels found, as the stages of the processor report it."""

from __future__ import annotations

import math
from typing import Any

from neve.cuda.layout import EXTREMES, RATES, decoded
from neve.domains.reports import NodeReport, ParticleReport

NOBODY = 0xFFFFFFFF
"""No particle's birth number."""


def extremes(results: dict[str, Any]) -> dict[str, float]:
    """Return the maxima that kernels have found, by name."""
    return dict(zip(EXTREMES, decoded(results["most"]).tolist(), strict=True))


def report_of(results: dict[str, Any], stepped: bool) -> ParticleReport:
    """Return what was found in the particles; stepped: in a step, not in the state as it was."""
    most = extremes(results)
    return ParticleReport(
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


def grid_report_of(results: dict[str, Any]) -> NodeReport:
    """Return what was found in the nodes."""
    most = extremes(results)
    return NodeReport(
        math.sqrt(most["node_speed"]),
        math.sqrt(most["node_difference"]),
        math.sqrt(3.0) * most["node_change"],
        not results["not_finite"],
    )


def last_report(control: Any) -> ParticleReport:
    """Return what was found in the particles by the last step that the GPU took by itself."""
    return ParticleReport(
        **{name: float(control[name]) for name in (*RATES, "max_displacement", "min_volume_ratio")},
        finite=not control["broken"],
        drifted=bool(control["drifted"]),
        offending_id=NOBODY,
    )
