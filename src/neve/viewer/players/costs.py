"""What a live run spends its time on, as the corner of the page says it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from neve.viewer.players.snapshot import present
from neve.viewer.protocol.messages import Facts

if TYPE_CHECKING:
    from neve.simulation import Simulation

KEPT = 0.9
"""Share of what was spent that still counts after the next piece of work."""


class Costs:
    """Add up the seconds of each stage, lately."""

    def __init__(self) -> None:
        self._spent: dict[str, float] = {}

    def add(self, sim: Simulation, simulated: float, seconds: float) -> None:
        """Count a piece of work: simulated [s], in so many seconds."""
        new = {**sim.stats.stage_seconds, "all": seconds, "simulated": simulated}
        for name, spent in new.items():
            self._spent[name] = KEPT * self._spent.get(name, 0.0) + spent

    def facts(self, sim: Simulation) -> Facts:
        """Return the figures of the run now."""
        spent = self._spent
        total = max(spent.get("all", 0.0), 1e-9)
        return {
            "particles": sim.count,
            "steps": sim.steps,
            "dt": sim.stats.dt_mean,
            "bound": sim.stats.bound,
            "rejected": sim.stats.rejected,
            "pace": spent.get("simulated", 0.0) / total,
            "keyed": present(sim.scene, sim.time),
            "stages": {name: spent[name] / total for name in spent if name not in ("all", "simulated")},
        }
