"""The material point method on one of several ranks."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve.mpm.solver import MpmSolver
from neve.mpm.state_checks import Densest, too_dense
from neve.mpm.step import Stages
from neve.ranks.domain import Domain
from neve.ranks.ownership import Keys
from neve.ranks.stages import RankStages
from neve.ranks.world import World
from neve.scene.schema.scene import Scene
from neve.solver import Arrays

if TYPE_CHECKING:
    from neve._core import State


class RankSolver(MpmSolver):
    """Step the particles that this rank owns; all ranks do so together.

    Between two frames `state` is that of the whole run on the leader, so that whoever looks at it or saves
    it finds what a run on one rank has; within a frame, and on the others, it is this rank's share.

    Attributes:
        domain: what this rank exchanges with the others
    """

    def __init__(
        self, scene: Scene, saved: Arrays, world: World, cuts: Keys, whole: State | None = None
    ) -> None:
        """Take over the share of this rank, `saved`. whole: the particles of all, on the leader alone."""
        super().__init__(scene, saved)
        self.domain = Domain(world, self.model.core.ranks, cuts)
        self._mine, self._whole = self.state, whole
        self._counted = 0
        if whole is not None:
            self.state = whole

    def _check_births(self, ids: NDArray[np.uint32]) -> None:
        """Let a rank own no particle; the leader has checked the whole."""

    def begin(self, steps: int, time: float) -> None:
        """Prepare for steps of this rank's particles. Errors: Blowup."""
        self.state = self._mine
        super().begin(steps, time)

    def gather(self) -> None:
        """Let the leader have all particles, as a run on one rank has them."""
        self._mine = self.state
        self.domain.gather(self._mine, self.grid, self._whole)
        found = self.domain.world.transport.total([np.array([self.domain.counted])])
        self._counted = int(found[0])
        if self._whole is not None:
            self.state = self._whole

    def take_exchanged(self) -> NDArray[np.float64]:
        """Return what snow and each solid exchanged since the last call, on the leader; zeros elsewhere.

        With bodies all ranks have it, since each moves them.
        """
        if not self.solids:
            return super().take_exchanged()
        return self.domain.exchanged(self.grid, len(self.solids), to_all=self.model.rigid is not None)

    def _new_stages(self) -> Stages:
        return RankStages(self.model, self.state, self.grid, self.timer, domain=self.domain)

    def _inspect(self) -> Densest:
        with self.domain.world.any_error():
            found = super()._inspect()
        return found

    def _warn_of_density(self, densest: Densest, time: float) -> bool:
        """Let the leader log what the rank with the densest snow says."""
        said = too_dense(self.scene, self.model, self.state, densest, time)
        each: list[tuple[float, str]] = self.domain.world.comm.allgather((densest.crowding, said))
        sentence = max(each, key=lambda found: found[0])[1]
        if sentence and self.domain.world.leads:
            logging.getLogger("neve").warning("%s", sentence)
        return bool(sentence)

    def _strongest(self, found: float) -> float:
        return float(self.domain.world.most([found])[0])

    @property
    def _blocks(self) -> int:
        return self._counted
