"""A scene in motion over several ranks: what the leader has, and what the others do."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Self, cast

import numpy as np
from numpy.typing import NDArray

from neve.mpm.solver import MpmSolver
from neve.mpm.state import FIELDS
from neve.ranks import launch
from neve.ranks.domain import Tally, dealt
from neve.ranks.ownership import cuts_of, work_of
from neve.ranks.requirements import require_able
from neve.ranks.solver import RankSolver
from neve.ranks.world import World, end_when_asked, place, resumable, world
from neve.scene.schema.scene import Scene
from neve.simulation import Simulation
from neve.solver import Blowup
from neve.system.processors import cores

COLUMNS = tuple(field.name for field in FIELDS)


class RankSimulation(Simulation):
    """Simulate the snow of a scene over all ranks of this launch, with the bits of one rank.

    The leader makes one, as it makes a `Simulation`, and deals the particles out; the others `join`.
    """

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        require_able(scene, world().size)
        super().__init__(on_processors(scene), threads or usual_threads())
        self._share_out()

    @classmethod
    def restore(
        cls, scene: Scene, arrays: Mapping[str, NDArray[Any]], threads: int | None = None
    ) -> RankSimulation:
        """Go on from what `arrays()` returned, of a run over any number of ranks, on the leader."""
        require_able(scene, world().size)
        threads = threads or usual_threads()
        self = cast(RankSimulation, super().restore(on_processors(scene), arrays, threads))
        self._share_out()
        return self

    def _share_out(self) -> None:
        """Choose what each rank owns, and let the others join."""
        ours, whole = world(), cast(MpmSolver, self.solver)
        core = whole.model.core.ranks
        homes = core.homes_now(whole.model.native, whole.state)
        keys, counts = np.unique(homes, return_counts=True)
        cuts = cuts_of(core.curve(keys), work_of(counts.astype(np.uint32)), ours.size)
        owners = core.owners(homes, cuts)
        arrays = whole.save()
        scene = self.scene.model_dump(exclude_unset=True)
        ours.tell("join", place(), scene, self.threads, self.time, self.steps, cuts)
        for other in range(1, ours.size):
            ours.send_arrays(dealt(arrays, owners, other, COLUMNS), other)
        self._share(dealt(arrays, owners, ours.rank, COLUMNS), ours, cuts, whole)

    def _share(
        self, part: Mapping[str, NDArray[Any]], ours: World, cuts: NDArray[np.uint64], whole: MpmSolver | None
    ) -> None:
        with ours.or_abort():
            self._start(RankSolver(self.scene, part, ours, cuts, whole.state if whole else None))

    @classmethod
    def join(
        cls,
        ours: World,
        folder: str,
        scene: Mapping[str, Any],
        threads: int,
        time: float,
        steps: int,
        cuts: NDArray[np.uint64],
    ) -> Self:
        """Take this rank's share of the leader's simulation, whose values these are."""
        resumable(folder)
        self = cls.__new__(cls)
        self.scene = Scene.model_validate(scene)
        self.threads, self.time, self.steps = threads, time, steps
        self._use_threads()
        self._share(ours.receive_arrays(), ours, cuts, None)
        self.exchanged = np.zeros((len(self.solver.solids), 7))
        return self

    def advance(self, seconds: float, enough: Callable[[], bool] | None = None) -> None:
        """Simulate `seconds` [s] more on all ranks. Errors: Blowup, the same on all; as of `Simulation`."""
        if enough is not None:
            raise ValueError("a simulation over ranks ends no work in the middle: leave enough out")
        ours = world()
        if ours.leads:
            ours.tell("advance", seconds)
        with ours.or_abort():
            with ours.same_error():
                super().advance(seconds)
            cast(RankSolver, self.solver).gather()

    def tallies(self) -> list[Tally]:
        """Return how each rank takes part in the run, on the leader; an empty list on the others."""
        ours, solver = world(), cast(RankSolver, self.solver)
        if ours.leads:
            ours.tell("tally")
        mine = solver.domain.tally(solver.grid, self.stats.stage_seconds)
        return ours.comm.gather(mine) or []


def usual_threads() -> int:
    """Return how many threads a rank uses if nobody says: an equal share of the cores that it may use here.

    Where `mpirun` has bound each rank to cores of its own, `--threads` says how many these are.
    """
    return max(1, cores() // launch.local_size())


def on_processors(scene: Scene) -> Scene:
    """Return the scene with `numerics.device` "auto" as what ranks have: "cpu"."""
    if scene.numerics.device != "auto":
        return scene
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"device": "cpu"})})


@contextlib.contextmanager
def leading() -> Iterator[None]:
    """Lead the other ranks in the block: they follow until it ends, however it does.

    Errors: RanksError without MPI.
    """
    end_when_asked()
    ours = world()
    try:
        yield
    finally:
        ours.tell("end")


def follow() -> int:
    """Do what the leader says until it ends, and return the exit code; the leader alone says anything."""
    end_when_asked()
    ours = world()
    sim: RankSimulation | None = None
    with ours.or_abort():
        while True:
            word, values = ours.hear()
            if word == "end":
                return 0
            if word == "join":
                sim = RankSimulation.join(ours, *values)
            elif word == "tally" and sim is not None:
                sim.tallies()
            elif sim is not None:
                with contextlib.suppress(Blowup):  # the leader says it
                    sim.advance(*values)
