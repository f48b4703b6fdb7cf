"""Snow that leaves an emitter: an endless column of particles that is pushed through its section.

The column is a lattice in the axes of the section, as a source's (`neve.sampling.points`): a layer of
particles lies across the flow, the next one behind it, and each is moved at random by the same share of a
spacing. A particle has a phase: how many layers must have come out before it does. So what comes out follows
from the way of the flow, not from the time step: nothing is left out and nothing comes twice, however long
the steps are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.geometry.pose import cross
from neve.reproducible import product
from neve.sampling.emitters.section import Section, section_of
from neve.sampling.points import JITTER
from neve.sampling.room import require_room_in_section
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene
from neve.scene.schema.sources import Emitter
from neve.scene.values.curves import keyed
from neve.scene.values.fields import rounded_down

Array = NDArray[np.float64]

MARK = 0x5EED
"""Tells the random numbers of emitters from those of sources."""
DARTS = 8
"""Points that are drawn for a direction: all of them miss the circle once in 200,000 times."""


class Comers(NamedTuple):
    """Particles that come out: places in the section [m] (n, 3), points of the unit disc that say how their
    directions are spread (n, 2), and phases [layers] (n,)."""

    place: Array
    aim: Array
    phase: Array


@dataclass(frozen=True)
class Stream:
    """Hold the column of an emitter.

    Attributes:
        emitter: the part of the scene. index: its number. seed: of the run
        section: through which it comes. area: of the section [m2]
        middles: of the lattice's cells in the section, in the world [m] (n, 3)
        edges: of a cell along the axes of the section [m] (2, 3)
        spacing: of particles in snow at rest [m]
        volume: of snow in a layer [m3]. mass: of snow in a layer [kg]
        thinness: times that layers come farther apart than in snow at rest, with the emitter's own rate [1]
        jittered: whether particles are moved from the middles of their cells
    """

    emitter: Emitter
    index: int
    seed: int
    section: Section
    area: float
    middles: Array
    edges: Array
    spacing: float
    volume: float
    mass: float
    thinness: float
    jittered: bool

    @property
    def rate(self) -> float:
        """Layers that come out in a second while the emitter is at work, without keyframes [1/s]."""
        return self.emitter.speed / (self.spacing * self.thinness)

    def velocity(self, t: float) -> Array:
        """Return the velocity with which snow leaves at time `t` [m/s] (3,)."""
        return keyed(self.emitter, "velocity", t)

    def rate_at(self, t: float) -> float:
        """Return how many layers come out in a second at time `t` [1/s], at work."""
        if not self.emitter.keyframes:
            return self.rate
        fills = float(np.sum(self.velocity(t) * self.section.normal)) / self.spacing
        for name, layer in (("mass_rate", self.mass), ("volume_rate", self.volume)):
            if getattr(self.emitter, name) is not None:
                return min(float(keyed(self.emitter, name, t)[0]) / layer, fills)
        return fills

    def layers(self, begin: float, end: float) -> float:
        """Return how many layers come out between two times [s], by Simpson's rule in parts of 0.02 s.

        It is exact where nothing changes, and where a rate alone does, but at the times of keyframes.
        """
        first, last = active(self.emitter, begin, end)
        if last <= first:
            return 0.0
        if not self.emitter.keyframes:
            return self.rate * (last - first)
        parts = min(max(1, math.ceil((last - first) / 0.02)), 100_000)
        h = (last - first) / parts
        edges = [self.rate_at(first + k * h) for k in range(parts + 1)]
        middles = [self.rate_at(first + (k + 0.5) * h) for k in range(parts)]
        return h / 6.0 * (sum(edges[:-1]) + sum(edges[1:]) + 4.0 * sum(middles))

    def expected(self, begin: float, end: float) -> float:
        """Return about how many particles come out between two times [s]."""
        return len(self.middles) * self.layers(begin, end)

    def comers(self, before: float, after: float) -> Comers:
        """Return the particles of phases above `before` and up to `after` [layers], by rising phase."""
        layers = [self._layer(k) for k in range(math.floor(before), math.floor(after) + 1)]
        place, aim, phase = (np.concatenate(parts) for parts in zip(*layers, strict=True))
        order = np.argsort(phase, kind="stable")
        chosen = order[(before < phase[order]) & (phase[order] <= after)]
        return Comers(place[chosen], aim[chosen], phase[chosen])

    def _layer(self, k: int) -> Comers:
        """Return the particles of layer `k`, whose phases lie between k and k + 1."""
        rng = np.random.default_rng([self.seed, MARK, self.index, k])
        count = len(self.middles)
        shift = rng.random((count, 3)) - 0.5 if self.jittered else np.zeros((count, 3))
        place = self.middles + JITTER * product(shift[:, :2], self.edges)
        place = np.where(self.section.holds(place)[:, None], place, self.middles)
        width = 1.0 - (1.0 - JITTER) / self.thinness
        aim = _disc(rng.random((count, DARTS, 2))) if self.emitter.spread else np.zeros((count, 2))
        return Comers(place, aim, k + 0.5 + width * shift[:, 2])


def stream(scene: Scene, index: int) -> Stream:
    """Return the column of the scene's emitter number `index`.

    Errors: SceneError if its section is too small for a particle or too large for the memory, its rate is
    more than fills it, its mesh has no inside, or its font lacks a letter.
    """
    emitter, numerics, name = scene.emitters[index], scene.numerics, f"emitters.{index}"
    section = section_of(emitter, numerics, name)
    cells = np.maximum(1, np.rint(2.0 * section.half / numerics.spacing))
    require_room_in_section(cells, numerics, name)
    count = cells.astype(np.int64)
    middles = section.grid(count)
    middles = middles[section.holds(middles)]
    if not len(middles):
        raise SceneError(
            f"{name} has a section too small for a single particle with numerics.dx = {numerics.dx:g}; "
            "use a smaller dx or a larger emitter"
        )
    area, rho0 = section.area, scene.snow_of(emitter).rho0
    return Stream(
        emitter,
        index,
        numerics.seed,
        section,
        area,
        middles,
        section.axes * (2.0 * section.half / count)[:, None],
        numerics.spacing,
        area * numerics.spacing,
        rho0 * area * numerics.spacing,
        _thinness(emitter, area, rho0, name),
        numerics.sampling != "regular",
    )


def active(emitter: Emitter, begin: float, end: float) -> tuple[float, float]:
    """Return from when to when an emitter is at work between two times [s]; never, if that is no time."""
    return max(begin, emitter.start), end if emitter.end is None else min(end, emitter.end)


def directed(velocity: Array, spread: float, aim: Array) -> Array:
    """Return velocities (n, 3) [m/s] that are spread about `velocity` (3,) by at most `spread` [degrees].

    aim: points of the unit disc (n, 2). All directions in the cone are equally likely if all points of the
    disc are: with s = |aim|^2 the cosine of the angle is 1 - s (1 - cos(spread)), which is uniform.
    """
    speed = math.hypot(*velocity)
    if spread == 0.0 or speed == 0.0:
        return np.asarray(np.broadcast_to(velocity, (len(aim), 3)))
    normal = velocity / speed
    other = np.zeros(3)
    other[int(np.argmin(np.abs(normal)))] = 1.0
    a = cross(normal, other)
    a = a / math.hypot(*a)
    s = np.sum(aim * aim, axis=1)
    cosine = 1.0 - s * (1.0 - math.cos(math.radians(spread)))
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    across = product(aim, np.stack([a, cross(normal, a)])) / np.maximum(np.sqrt(s), 1e-12)[:, None]
    return np.asarray(speed * (cosine[:, None] * normal + sine[:, None] * across))


def _disc(darts: Array) -> Array:
    """Return the first of each row of points of the unit square (n, k, 2) in the disc around it, (n, 2)."""
    points = 2.0 * darts - 1.0
    hits = np.sum(points * points, axis=2) <= 1.0
    first = points[np.arange(len(points)), np.argmax(hits, axis=1)]
    return np.where(hits.any(axis=1)[:, None], first, 0.0)


def _thinness(emitter: Emitter, area: float, rho0: float, name: str) -> float:
    """Return how many times more than the rate of `emitter` fills its section [1]. Errors: SceneError."""
    key = "mass_rate" if emitter.mass_rate is not None else "volume_rate"
    rate = getattr(emitter, key)
    if rate is None:
        return 1.0
    full = area * emitter.speed * (rho0 if key == "mass_rate" else 1.0)
    if rate > full * (1 + 1e-9):
        raise SceneError(
            f"{name}.{key} = {rate:g} must be at most {rounded_down(full)}, which fills its section of "
            f"{area:.3g} m2 at {emitter.speed:g} m/s"
        )
    for i, frame in enumerate(emitter.keyframes):
        now = float(keyed(emitter, key, frame.t)[0])
        velocity = keyed(emitter, "velocity", frame.t)
        fills = full * float(np.sum(velocity * np.array(emitter.velocity))) / emitter.speed**2
        if now > fills * (1 + 1e-9):
            raise SceneError(
                f"{name}.keyframes.{i}: {key} = {now:g} must be at most {rounded_down(fills)}, which fills "
                "its section at this velocity"
            )
    return max(1.0, full / float(rate))
