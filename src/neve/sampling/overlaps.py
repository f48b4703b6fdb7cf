"""Find where sources fill the same space twice: tell it, or leave it out of the later one."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import product
from neve.sampling import Samples
from neve.sampling.draping import Lift
from neve.sampling.regions import Region
from neve.scene.errors import SceneError, SceneWarning

Mask = NDArray[np.bool_]

MOST_POINTS = 20_000
"""Particles of a source by which an overlap is measured; of more, every n-th one."""
LEAST, FEWEST = 1e-3, 4
"""Share of the smaller source, and particles, below which sources count as touching each other."""


@dataclass(frozen=True)
class Filled:
    """Hold a source with its particles.

    Attributes:
        name: in messages, such as "sources.0"
        space: what it fills
        samples: its particles
        rho0: density of its snow before factors [kg/m3]
        is_cut: whether it leaves out what sources before it fill
        lift: height of the ground that it lies on, by which its particles are lifted; None: it is level
    """

    name: str
    space: Region
    samples: Samples
    rho0: float
    is_cut: bool
    lift: Lift | None = None

    def holds(self, x: NDArray[np.float64]) -> Mask:
        """Return whether points `x` in the world [m] (n, 3) lie in it, (n,)."""
        if self.lift is None:
            return inside(self.space, x)
        found = np.all(np.abs(x - self.space.center)[:, :2] <= 0.5 * self.space.size[:2], axis=1)
        if found.any():
            level = x[found]
            level[:, 2] -= self.lift(level)
            found[found] = inside(self.space, level)
        return np.asarray(found)


def inside(space: Region, x: NDArray[np.float64]) -> Mask:
    """Return whether points `x` in the world [m] (n, 3) lie in `space`, (n,)."""
    local = product(x - space.center, space.rotation) - space.middle
    found = np.all(np.abs(local) <= 0.5 * space.size, axis=1)
    if found.any():
        found[found] = space.inside(local[found])
    return np.asarray(found)


def without_overlaps(sources: Sequence[Filled]) -> list[Samples]:
    """Return the particles of each source: of those that are cut, without what earlier sources fill.

    Warns with SceneWarning of two that fill the same space and are not cut: there the snow starts with the
    sum of their densities at F_E = I, J_P = 1, which no stress opposes. An overlap is measured by the
    particles of each that lie in the other; the smaller volume counts.

    Errors: SceneError for a source of which nothing is left.
    """
    low, high = (np.array(edges) for edges in zip(*(_bounds(s) for s in sources), strict=True))
    kept: list[Samples] = []
    for j, source in enumerate(sources):
        near = np.flatnonzero(np.all((low[:j] < high[j]) & (low[j] < high[:j]), axis=1))
        others = [sources[int(i)] for i in near]
        kept.append(_cut(source, others) if source.is_cut else source.samples)
        for other in others if not source.is_cut else ():
            for sentence in _told(other, source):
                warnings.warn(sentence, SceneWarning, stacklevel=2)
    return kept


def _bounds(source: Filled) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the least and largest coordinates in the world of the box around a source [m], (3,) each."""
    if source.lift is not None:
        return source.samples.x.min(axis=0), source.samples.x.max(axis=0)
    space = source.space
    middle = space.center + product(space.middle, space.rotation.T)
    reach = 0.5 * product(space.size, np.abs(space.rotation).T)
    return middle - reach, middle + reach


def _cut(source: Filled, before: Sequence[Filled]) -> Samples:
    free = np.ones(len(source.samples.x), dtype=bool)
    for other in before:
        free &= ~other.holds(source.samples.x)
    if not free.any():
        names = ", ".join(other.name for other in before)
        raise SceneError(
            f'{source.name} lies wholly in {names}, and {source.name}.overlap = "cut" leaves nothing'
        )
    return source.samples if free.all() else source.samples.only(free)


def _told(first: Filled, second: Filled) -> Iterator[str]:
    """Yield the sentence about two sources that fill the same space, if they do."""
    shared = [_shared(first, second), _shared(second, first)]
    volume = min(part[0] for part in shared)
    whole = min(float(source.samples.volume.sum()) for source in (first, second))
    if volume <= LEAST * whole or min(part[2] for part in shared) < FEWEST:
        return
    density = sum(mass / v for v, mass, _ in shared)
    yield (
        f"{second.name} overlaps {first.name} in {volume:.3g} m3, where snow starts with {density:.3g} kg/m3 "
        f"and no stress, {density * volume:.3g} kg in all: move one, or set {second.name}.overlap = "
        f'"cut", which leaves out of it what {first.name} fills'
    )


def _shared(source: Filled, other: Filled) -> tuple[float, float, int]:
    """Return the volume [m3], mass [kg] and count of the particles of `source` that lie in `other`."""
    step = -(-len(source.samples.x) // MOST_POINTS)
    s = source.samples
    within = other.holds(s.x[::step])
    volume = s.volume[::step][within]
    mass = source.rho0 * float((volume * s.density[::step][within]).sum())
    return step * float(volume.sum()), step * mass, int(np.count_nonzero(within))
