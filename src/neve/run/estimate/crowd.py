"""How many particles a run will have whose snow comes and goes, from a coarse likeness of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from neve.run.estimate.trial import Trial, likeness
from neve.sampling.fineness import emitted_by, placed_in

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene


class Crowd(NamedTuple):
    """Numbers of particles in a run: the most at any time, and the mean over its steps."""

    most: float
    mean: float


def crowd(scene: Scene, foreseen: Trial, end: float) -> Crowd:
    """Return how many particles a run of `scene` has until `end` [s].

    What the likeness had is scaled by what both scenes place and emit. What emitters add after the end of
    the likeness counts as if no sink took it.
    """
    scale = placed_in(scene) / placed_in(likeness(scene, foreseen.coarser)) if foreseen.coarser > 1.0 else 1.0
    seen = float(foreseen.times[-1])
    most, mean = scale * float(foreseen.counts.max()), scale * float(foreseen.counts.mean())
    late = emitted_by(scene, end) - emitted_by(scene, min(seen, end))
    last = scale * float(foreseen.counts[-1])
    share = min(seen / end, 1.0)
    return Crowd(max(most, last + late), share * mean + (1.0 - share) * (last + 0.5 * late))
