"""What a wheel did to the snow of a run: load and sinkage moment by moment, and the rut that it left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.drive.columns import Columns, Patch, columns_of, floor_of, patch_about
from neve.drive.wheel import Wheel, wheel_of
from neve.io.errors import RunError
from neve.io.frames import Frame, frame_numbers, read_frame
from neve.io.run_folder import RunFolder
from neve.io.table import read_table
from neve.reproducible import norms, product
from neve.run.outputs.solids import COLUMNS, FILE
from neve.scene.reading.load import load
from neve.scene.schema.scene import Scene

Array = NDArray[np.float64]

FEWEST = 4
"""Moments of load and sinkage that a fit needs: twice as many as it has numbers."""
ROLLED = 3.0
"""Way that a wheel must roll, in radii, before there is a rut behind it."""
BEHIND = 1.2
"""Distance behind the axle from which on the rut is as the wheel left it, in radii."""
MIDDLE = 0.35
"""Half the width of the floor of a rut, in widths of the wheel."""


class Rut(NamedTuple):
    """Hold the rut of a wheel: means along it.

    across: from the middle of the track (m,) [m]. height: of the snow there above the ground (m,) [m].
    depth_ratio: h'/h on its floor, mass_ratio: W'/W on its floor [1].
    """

    across: Array
    height: Array
    depth_ratio: float
    mass_ratio: float

    @property
    def compaction(self) -> float:
        """Return the share of what was pressed that was compacted: 1 - ln(W'/W) / ln(h'/h) [1]."""
        if not 0.0 < self.depth_ratio < 1.0:
            return 1.0
        share = 1.0 - np.log(max(self.mass_ratio, 1e-9)) / np.log(self.depth_ratio)
        return float(np.clip(share, 0.05, 1.0))

    @property
    def density_ratio(self) -> float:
        """Return how much denser its floor is than the snow was [1]."""
        return self.mass_ratio / self.depth_ratio


@dataclass(frozen=True)
class Track:
    """Hold what a wheel did.

    wheel. density: of the snow at the start [kg/m3]. Of k moments in which the wheel presses snow that it
    has not pressed before, load: of the snow on the wheel, upward [N]; sinkage: below the surface of fresh
    snow [m]; depth: of that snow [m]. rut.
    """

    wheel: Wheel
    density: float
    load: Array
    sinkage: Array
    depth: Array
    rut: Rut


class Moment(NamedTuple):
    """Hold a frame in axes along the track, to its right, and up; angle the wheel has rolled [rad]."""

    time: float
    x: Array
    axle: Array
    spin: float


class Passage:
    """Read a run with a wheel: frames in the axes of its track, and the forces on the wheel.

    The track runs from where the axle is in the first frame to where it is in the last one.

    Errors: RunError, SceneError: no run, no wheel, too few frames, a wheel that does not roll.
    """

    def __init__(self, folder: str, name: str | None = None) -> None:
        run = RunFolder(folder)
        if not run.is_run():
            raise RunError(f"{folder} holds no Neve run, so there is nothing to fit to.")
        self.folder = run.path
        self.scene: Scene = load(run.scene)
        self._frames = run.frames
        self.wheel = wheel_of(self.scene, name)
        self.numbers = frame_numbers(run.frames)
        if len(self.numbers) < FEWEST + 1:
            raise RunError(
                f"{folder} holds {len(self.numbers)} frames, and a fit needs at least {FEWEST + 1}."
            )
        ends = [self._axle(read_frame(run.frames, number)) for number in (self.numbers[0], self.numbers[-1])]
        way = ends[1][:2] - ends[0][:2]
        self.way = float(norms(way[None])[0])
        if self.way < ROLLED * self.wheel.radius:
            raise RunError(
                f"{self.wheel.name} of {folder} rolls {self.way:.2f} m, and a rut behind it needs at least "
                f"{ROLLED:g} radii, {ROLLED * self.wheel.radius:.2f} m."
            )
        along = way / self.way
        self._axes = np.array([[*along, 0.0], [along[1], -along[0], 0.0], [0.0, 0.0, 1.0]])
        self._origin = np.array([*ends[0][:2], 0.0])
        self._forces = self._read_forces(run)

    @property
    def spacing(self) -> float:
        """Return the spacing of particles in snow at rest [m]."""
        return self.scene.numerics.spacing

    def moment(self, number: int) -> Moment:
        """Return the frame `number`. Errors: RunError."""
        frame = read_frame(self._frames, number)
        axle = product(self._axes, self._axle(frame) - self._origin)
        # The wheel turns about its axle; of two frames it is the angle between, as rolling goes.
        turned = product(frame.solid_rotation[self.wheel.row].astype(float), self._spoke())
        seen = product(self._axes, turned)
        spin = float(np.arctan2(seen[0], seen[2]))
        return Moment(frame.time, self._local(frame.x.astype(float)), axle, spin)

    def force(self, number: int) -> float:
        """Return the mean upward force of the snow on the wheel since the frame before [N]."""
        return self._forces.get(number, np.nan)

    def _spoke(self) -> Array:
        """Return a direction in the wheel's own frame across its axle."""
        about = np.eye(3)[int(np.argmin(np.abs(self.wheel.axle)))]
        spoke = about - float(product(about[None], self.wheel.axle)[0]) * self.wheel.axle
        return np.asarray(spoke / norms(spoke[None])[0])

    def _axle(self, frame: Frame) -> Array:
        turn = frame.solid_rotation[self.wheel.row].astype(float)
        return np.asarray(frame.solid_position[self.wheel.row] + product(turn, self.wheel.middle))

    def _local(self, x: Array) -> Array:
        return product(x - self._origin, self._axes.T)

    def _read_forces(self, run: RunFolder) -> dict[int, float]:
        rows = read_table(run.path / FILE, COLUMNS)
        return {
            int(row["frame"]): float(row["force_z"])
            for row in rows
            if row["solid"] == self.wheel.name and row["force_z"]
        }


def measured(passage: Passage) -> Track:
    """Return what the wheel did to the snow. Errors: RunError: it pressed the snow in too few frames."""
    first = passage.moment(passage.numbers[0])
    patch = patch_about(first.x, passage.scene.numerics.dx)
    floor = floor_of(first.x, patch, passage.spacing)
    fresh = columns_of(first.x, patch, floor, passage.spacing)
    wheel = passage.wheel
    rows: list[tuple[float, float, float, float]] = []
    before = _sinkage(first, patch, floor, fresh, wheel)
    for number in passage.numbers[1:]:
        now = passage.moment(number)
        here = _sinkage(now, patch, floor, fresh, wheel)
        sinkage, depth = (0.5 * (a + b) for a, b in zip(before, here, strict=True))
        rows.append((passage.force(number), float(now.axle[0]), sinkage, depth))
        before = here
    load, place, sunk, deep = np.array(rows).T
    keep = _presses_anew(load, place, sunk, deep, wheel.radius, passage.spacing)
    if keep.sum() < FEWEST:
        raise RunError(
            f"{wheel.name} of {passage.folder} presses fresh snow in {keep.sum()} frames, and a fit needs at "
            f"least {FEWEST}."
        )
    last = columns_of(now.x, patch, floor, passage.spacing)
    rut = _rut(patch, floor, fresh, last, (float(first.axle[0]), float(now.axle[0])), wheel)
    return Track(wheel, passage.scene.snow.rho0, load[keep], sunk[keep], deep[keep], rut)


def _sinkage(moment: Moment, patch: Patch, floor: Array, fresh: Columns, wheel: Wheel) -> tuple[float, float]:
    """Return how far the wheel is below the surface of the fresh snow there, and how deep that is [m]."""
    along, across = patch.middles
    near = np.abs(along - moment.axle[0]) <= patch.cell
    wide = np.abs(across - moment.axle[1]) <= 0.5 * wheel.width
    under = np.ix_(near, wide)
    tops, floors = fresh.top[under], floor[under]
    there = np.isfinite(tops)
    if not there.any():
        return np.nan, np.nan
    top, ground = float(tops[there].mean()), float(floors[there].mean())
    return top - (float(moment.axle[2]) - wheel.radius), top - ground


def _presses_anew(
    load: Array, place: Array, sinkage: Array, depth: Array, radius: float, spacing: float
) -> NDArray[np.bool_]:
    """Return the moments in which the wheel presses snow that it has not pressed as deep before."""
    good = np.isfinite(load) & np.isfinite(sinkage) & (load > 0.0) & (sinkage > 0.0)
    good &= sinkage < depth - spacing  # else the ground below carries it
    for k in np.flatnonzero(good):
        earlier = sinkage[:k][(np.abs(place[:k] - place[k]) < 0.3 * radius) & np.isfinite(sinkage[:k])]
        good[k] = not len(earlier) or sinkage[k] > float(earlier.max()) - 0.25 * spacing
    return good


def _rut(
    patch: Patch, floor: Array, fresh: Columns, last: Columns, ends: tuple[float, float], wheel: Wheel
) -> Rut:
    """Return the rut between the place where the wheel began and that where it is. Errors: RunError."""
    along, across = patch.middles
    rows = (along > ends[0]) & (along < ends[1] - BEHIND * wheel.radius)
    before, after = fresh.top - floor, np.nan_to_num(last.top - floor)
    bed = np.abs(across) < MIDDLE * wheel.width
    known = np.isfinite(before[rows][:, bed])
    if not known.any():
        raise RunError(f"{wheel.name} left no rut in the snow of the run behind it.")
    height = np.where(np.isfinite(before), after, np.nan)[rows]
    counted = np.isfinite(height).any(axis=0)
    mean = np.array([np.nanmean(column) for column in height.T[counted]])
    depth_ratio = after[rows][:, bed][known].sum() / before[rows][:, bed][known].sum()
    mass_ratio = last.mass[rows][:, bed][known].sum() / fresh.mass[rows][:, bed][known].sum()
    return Rut(across[counted], mean, float(depth_ratio), float(mass_ratio))
