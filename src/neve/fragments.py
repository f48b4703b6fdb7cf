"""Find the pieces that snow has broken into: connected components of particles that still hold together.

Friends of friends: two particles are linked if both are bonded (J_P at most `torn`) and no more than `link`
particle spacings apart; a fragment is a set of particles that links connect, directly or through others.
Sets of fewer than `least` particles, and particles that are torn open, are powder.

Source: friends-of-friends grouping is Huchra and Geller 1982 (of galaxies); the bond and the limits are ours.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.system.arguments import real, shown

Array = NDArray[np.float64]

LINK = 1.5
"""Link length in particle spacings, spacing = dx / particles_per_cell^(1/3): with 8 a cell, 0.75 dx."""

TORN = 1.25
"""J_P above which a particle is torn open: its snow takes up a quarter more room than it was born with."""

LEAST = 8
"""Least number of particles of a fragment: with 8 a cell, one cell of snow; no grid resolves less."""


CLASSES = 10
"""Classes of half a decade of mass that `size_classes` tells; the last one holds all that is lighter."""

MOST = 200
"""Fragments of a frame with a row of their own in the table of a run."""

COLUMNS = (
    "frame",  # number of the frame; 0 is the initial state
    "time",  # simulated time [s]
    "kind",  # fragment; rest: all fragments after the largest 200 together; powder
    "rank",  # 1 for the heaviest fragment of the frame; empty for rest and powder
    "particles",
    "mass",  # [kg]; the rows of a frame add up to the mass of the snow
    "volume",  # sum of V0 J_P [m3]
    "size",  # diameter of the uniform ball with the same radius of gyration [m]; empty for rest and powder
    "x",  # centre of mass [m]
    "y",
    "z",
    "velocity_x",  # of the centre of mass [m/s]
    "velocity_y",
    "velocity_z",
)
"""Columns of `fragments.csv`."""


POSITIVE = "a positive, finite number"


class Limits(NamedTuple):
    """What counts as a fragment: see `find`."""

    link: float = LINK
    torn: float = TORN
    least: int = LEAST


@dataclass(frozen=True)
class Fragments:
    """Hold the fragments of one instant, the heaviest first; row 0 of each table is the powder.

    label (n,): row in the tables of each particle, 0 for powder. Tables of k fragments and the powder:
    particles (k+1,) [1], mass (k+1,) [kg], volume (k+1,) [m3] (sum of V0 J_P: without the elastic strain of
    some percent), size (k+1,) [m] (diameter 2 sqrt(5/3) R_g of the uniform ball with the same radius of
    gyration R_g), centre of mass (k+1, 3) [m], its velocity (k+1, 3) [m/s]. Without any powder its centre,
    velocity and size are NaN.
    """

    label: NDArray[np.int64]
    particles: NDArray[np.int64]
    mass: Array
    volume: Array
    size: Array
    centre: Array
    velocity: Array

    @property
    def count(self) -> int:
        """Number of fragments."""
        return len(self.mass) - 1


def find(
    x: NDArray[Any],
    v: NDArray[Any],
    J_P: NDArray[Any],
    m: NDArray[Any],
    V0: NDArray[Any],
    spacing: float,
    limits: Limits = Limits(),  # noqa: B008 (a constant)
) -> Fragments:
    """Find the fragments of particles.

    Args:
        x: positions [m], (n, 3); a particle that is not finite is powder. v: velocities [m/s], (n, 3)
        J_P: plastic volume change [1], (n,). m: masses [kg], (n,). V0: rest volumes [m3], (n,)
        spacing: distance of particles in snow at rest [m], dx / particles_per_cell^(1/3)
        limits: link length [spacings], a gap wider than which separates; `torn`, the J_P above which a
            particle holds nothing; `least`, the number of particles below which a component is powder

    The order of the particles changes nothing but rounding and the order of fragments of equal mass.
    """
    _check(limits, spacing)
    x = np.asarray(x, np.float64)
    bonded = np.flatnonzero((np.asarray(J_P) <= limits.torn) & np.isfinite(x).all(axis=1))
    component = _components(x[bonded], limits.link * spacing)
    sizes = np.bincount(component)
    whole = sizes >= limits.least
    row = np.zeros(len(sizes), np.int64)
    row[whole] = 1 + np.arange(np.count_nonzero(whole))
    label = np.zeros(len(x), np.int64)
    label[bonded] = row[component]
    return _measure(label, 1 + int(whole.sum()), x, v, J_P, m, V0)


def _check(limits: Limits, spacing: float) -> None:
    """Refuse limits that are no positive, finite numbers. Errors: ValueError, TypeError."""
    for name, value in (*limits._asdict().items(), ("spacing", spacing)):
        if real(value, name, POSITIVE) <= 0:
            raise ValueError(f"{name} = {shown(value)} is not {POSITIVE}")


def rows(f: Fragments, frame: int, time: float) -> Iterator[dict[str, object]]:
    """Yield the rows of `fragments.csv` for one frame: the largest fragments, the rest if any, the powder."""
    for i in range(1, min(f.count, MOST) + 1):
        yield _row(f, frame, time, "fragment", i)
    if f.count > MOST:
        yield _row(_together(f), frame, time, "rest", 0)
    yield _row(f, frame, time, "powder", 0)


SUMMARY = ("fragments", "decades", "largest", "five", "powder")
"""Names of the numbers in `summary`."""


def summary(f: Fragments) -> dict[str, float]:
    """Return numbers that summarize the fragments.

    `fragments` [1]; `decades` of mass from the lightest to the heaviest, log10 [1]; and as shares of the
    whole mass [1] `largest`, `five` (the five largest together) and `powder`.
    """
    whole = float(f.mass.sum()) or 1.0
    return {
        "fragments": f.count,
        "decades": float(np.log10(f.mass[1] / f.mass[-1])) if f.count else 0.0,
        "largest": float(f.mass[1:2].sum()) / whole,
        "five": float(f.mass[1:6].sum()) / whole,
        "powder": float(f.mass[0]) / whole,
    }


def size_classes(f: Fragments) -> Array:
    """Return the shares of the whole mass [1] in fragments of ten classes of half a decade each (10,).

    Class k holds the fragments with 10^-((k+1)/2) to 10^-(k/2) of the whole mass.
    """
    share = f.mass[1:] / (float(f.mass.sum()) or 1.0)
    number = np.clip(np.floor(-2.0 * np.log10(share)), 0, CLASSES - 1).astype(np.int64)
    return np.asarray(np.bincount(number, share, CLASSES), np.float64)


def _row(f: Fragments, frame: int, time: float, kind: str, i: int) -> dict[str, object]:
    values: list[object] = [frame, time, kind, i or None, int(f.particles[i])]
    values += [float(f.mass[i]), float(f.volume[i]), float(f.size[i]) if i else None]
    values += [float(component) for component in (*f.centre[i], *f.velocity[i])]
    return dict(zip(COLUMNS, values, strict=True))


def _together(f: Fragments) -> Fragments:
    """Return tables of one row: all fragments after the largest `MOST` as one."""
    mass = f.mass[MOST + 1 :]

    def mean(values: Array) -> Array:
        return np.asarray(np.sum(mass[:, None] * values[MOST + 1 :], axis=0) / mass.sum())[None]

    def total(values: NDArray[Any]) -> NDArray[Any]:
        return np.asarray(values[MOST + 1 :].sum())[None]

    return Fragments(
        label=f.label[:0],
        particles=total(f.particles),
        mass=total(f.mass),
        volume=total(f.volume),
        size=np.full(1, np.nan),
        centre=mean(f.centre),
        velocity=mean(f.velocity),
    )


def _components(x: Array, reach: float) -> NDArray[np.int64]:
    """Return for each point the number of its component, points within `reach` [m] being linked."""
    if not len(x):
        return np.zeros(0, np.int64)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(x).query_pairs(reach, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), np.bool_), (pairs[:, 0], pairs[:, 1])), shape=(len(x), len(x)))
    component = connected_components(links, directed=False)[1]
    return np.asarray(component, np.int64)


def _measure(
    label: NDArray[np.int64],
    rows: int,
    x: Array,
    v: NDArray[Any],
    J_P: NDArray[Any],
    m: NDArray[Any],
    V0: NDArray[Any],
) -> Fragments:
    """Add up the particles of each row in double precision; order the fragments by mass, after the powder."""
    m = np.asarray(m, np.float64)
    mass = np.bincount(label, m, rows)
    order = np.concatenate([[0], 1 + np.argsort(-mass[1:], kind="stable")])
    rank = np.empty(rows, np.int64)
    rank[order] = np.arange(rows)
    label = rank[label]
    mass = mass[order]

    def mean(values: Array) -> Array:
        sums = [np.bincount(label, m * values[:, k], rows) for k in range(3)]
        return np.asarray(np.stack(sums, axis=1) / mass[:, None])

    with np.errstate(invalid="ignore"):  # 0/0 where there is no powder
        centre = mean(x)
        velocity = mean(np.asarray(v, np.float64))
        square = np.bincount(label, m * np.sum((x - centre[label]) ** 2, axis=1), rows) / mass
    room = np.asarray(V0, np.float64) * np.asarray(J_P, np.float64)
    return Fragments(
        label=label,
        particles=np.bincount(label, minlength=rows),
        mass=mass,
        volume=np.asarray(np.bincount(label, room, rows), np.float64),
        size=2.0 * np.sqrt(5.0 / 3.0 * square),
        centre=centre,
        velocity=velocity,
    )
