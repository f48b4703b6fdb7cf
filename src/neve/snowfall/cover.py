"""Let snow fall on surroundings, bit by bit, and slide: how deep it lies at each place."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.reproducible import norms
from neve.scene.errors import SceneWarning
from neve.scene.schema.snowfall import Snowfall
from neve.snowfall.drift import GRAVITY, MOST_STEPS, drifted
from neve.snowfall.layers import Layers, restacked
from neve.snowfall.surroundings import Surroundings

if TYPE_CHECKING:
    from neve._core import Columns, TriangleMesh

Array = NDArray[np.float64]

STEEPEST = math.tan(math.radians(75.0))
"""Slope beyond which places beside each other are not one surface."""
DETAIL = 0.05
"""Difference of exposure that splits a bucket."""
MOST_FLAKES = 4096
"""Of one bucket."""
MOST_PASSES = 2000
"""Over all snow that slides."""
LEAST_SLOPE = math.tan(math.radians(25.0))
"""Below it slopes hold any depth (Bernhardt and Schulz 2010)."""


@dataclass(frozen=True)
class Raster:
    """Hold the cells over which snow is counted: nx times ny squares from a corner `low` (2,) [m]."""

    low: tuple[float, float]
    cell: float
    nx: int
    ny: int

    @classmethod
    def over(cls, center: tuple[float, float], size: tuple[float, float], cell: float) -> Raster:
        """Return whole cells over a rectangle, as many as fit best [m]."""
        nx, ny = (max(1, round(side / cell)) for side in size)
        return cls((center[0] - 0.5 * nx * cell, center[1] - 0.5 * ny * cell), cell, nx, ny)

    @property
    def area(self) -> float:
        """Of all cells [m2]."""
        return self.nx * self.ny * self.cell**2


@dataclass(frozen=True)
class Books:
    """Say where the snow has gone [m3]: fell = lies + missed + slid + blown, to rounding.

    fell: onto the rectangle; lies: on all places; missed: what walls, the sides of things and the wind kept
    from every place (less what the wind brought, and the error of counting); slid: over the rim or into the
    void. over_edges: what slid over an edge and landed below, which lies. blown: what drifted out over the
    rim, less what drifted in. settled: whether all that lies is stable; calm: for how long wind that should
    have moved the snow was not counted any more [h].
    """

    fell: float
    lies: float
    missed: float
    slid: float
    over_edges: float
    flakes: int
    settled: bool
    blown: float = 0.0
    calm: float = 0.0


@dataclass(frozen=True, eq=False)
class Cover:
    """Hold the snow that lies.

    Attributes:
        raster: the cells
        columns: the places over them
        z: height of the surface at each place [m], (n,)
        depth: of the snow on it, upright [m], (n,)
        share: of the snowfall on level open ground that reached the place in the last part [1], (n,)
        layers: what the snow is, from the surface up; each part of a fall is one
        surroundings: what it lies on
        books: where the snow has gone
    """

    raster: Raster
    columns: Columns
    z: Array
    depth: Array
    share: Array
    layers: Layers
    surroundings: Surroundings
    books: Books

    @property
    def volume(self) -> float:
        """Of the snow that lies [m3]."""
        return float(self.depth.sum()) * self.raster.cell**2

    @property
    def mass(self) -> float:
        """Of the snow that lies [kg]."""
        return float(self.layers.mass.sum()) * self.raster.cell**2

    @property
    def density(self) -> float:
        """Of the snow that lies, on average [kg/m3]; 0 without any."""
        return self.mass / self.volume if self.volume > 0.0 else 0.0

    @property
    def x(self) -> Array:
        """Top of the snow at each place [m], (n, 3)."""
        i, j = np.divmod(self.columns.column(), self.raster.ny)
        x, y = (low + (k + 0.5) * self.raster.cell for low, k in zip(self.raster.low, (i, j), strict=True))
        return np.stack([x, y, self.z + self.depth], axis=1)


def let_fall(
    fall: Snowfall,
    surroundings: Surroundings,
    raster: Raster,
    told: Callable[[int, int], None] = lambda done, of: None,
    seen: Callable[[Array], None] = lambda depth: None,
) -> Cover:
    """Return the snow that lies on `surroundings` after `fall`. `told` hears how many parts of it are done.

    `seen` is shown the depth on each place (n,) [m] before the first part, after each, and after drifting.

    Equal arguments give equal bits on any number of threads. Warns with SceneWarning, see `warn_of`.

    Source: Fearing 2000 (launch sites, flutter, buckets by importance, stability in turn with accumulation).
    """
    columns = columns_over(raster, surroundings)
    z, room = columns.z(), columns.ceiling() - columns.z()
    depth, share, stack = np.zeros(len(z)), np.ones(len(z)), np.zeros((len(z), 0))
    seen(depth)
    solids = [surroundings.tree] if surroundings.tree is not None else []
    part, area = fall.open_depth / fall.steps, raster.cell**2
    fell = missed = slid = over = blown = calm = 0.0
    flakes, settled = 0, True
    tolerance = min(fall.tolerance * math.sqrt(fall.steps), 0.5)  # the parts' errors are independent
    for step in range(fall.steps):
        top = z + depth
        snow = snow_tree(columns, raster, top, depth) if step else None
        share, _, _, count = _core.snowfall.exposure(
            columns=columns,
            solids=[*solids, snow] if snow is not None else solids,
            top=top,
            slope=slope_of(columns, raster, top) if step else columns.slope(),
            flutter=fall.flutter,
            wind=(fall.wind[0] / fall.fall_speed, fall.wind[1] / fall.fall_speed),
            seed=fall.seed * 1000 + step,
            tolerance=tolerance,
            detail=max(DETAIL, 2.0 * tolerance),
            most=MOST_FLAKES,
        )
        new = np.minimum(part * share, np.maximum(room - depth, 0.0))
        depth = depth + new
        fell += part * raster.area
        missed += part * raster.area - float(new.sum()) * area
        flakes += count
        if fall.stability != "none":
            depth, sums = slid_down(columns, depth, fall)
            slid, over = slid + sums["lost"] * area, over + sums["over_edges"] * area
            settled = sums["settled"]
        stack = restacked(np.column_stack([stack, np.zeros(len(z))]), depth)
        seen(depth)
        told(step + 1, fall.steps)
    if fall.drift > 0.0 and any(fall.drift_wind or fall.wind):
        depth, more, blown, calm = blown_about(columns, raster, depth, fall)
        slid, over, settled = slid + more["lost"] * area, over + more["over_edges"] * area, more["settled"]
        stack = restacked(stack, depth)
        seen(depth)
    books = Books(fell, float(depth.sum()) * area, missed, slid, over, flakes, settled, blown, calm)
    warn_of(fall, books)
    layers = Layers.fresh(stack, fall.new_density, fall.temperature, ages(fall))
    return Cover(raster, columns, z, depth, share, layers, surroundings, books)


def warn_of(fall: Snowfall, books: Books) -> None:
    """Warn with SceneWarning of snow that still slides, and of wind that blew for less than was asked."""
    if not books.settled:
        warnings.warn("some snow still slides: it may lie steeper than its angle of repose", SceneWarning, 3)
    if books.calm > 0.0:
        told = f"the wind blew for {fall.drift - books.calm:.3g} of {fall.drift:g} h: use a larger cell"
        warnings.warn(told, SceneWarning, stacklevel=3)


def ages(fall: Snowfall) -> Array:
    """Return how long ago each part fell, on average, when all lies [s], (steps,); 0 without a rate."""
    lasted = 3600.0 * fall.duration if fall.rate is not None else 0.0
    return lasted * (fall.steps - 0.5 - np.arange(fall.steps)) / fall.steps


def columns_over(raster: Raster, surroundings: Surroundings) -> Columns:
    """Return the places where the surfaces lie under open space over each cell."""
    return _core.snowfall.Columns(
        raster.low,
        raster.cell,
        (raster.nx, raster.ny),
        surroundings.vertices,
        surroundings.faces,
        surroundings.part,
        list(surroundings.kinds),
    )


def blown_about(
    columns: Columns, raster: Raster, depth: Array, fall: Snowfall
) -> tuple[Array, dict[str, Any], float, float]:
    """Return the depth [m] once wind has moved the snow under the sky, sums of what slid [m], and blown [m3].

    What it piled up too steeply slides after each step. The last number is how long the wind should have
    blown on when the most steps were over [h].
    """
    column = columns.column()
    first = np.flatnonzero(np.diff(column, prepend=-1))  # the highest place of each column
    top = np.full((raster.nx, raster.ny), -np.inf)
    top.ravel()[column[first]] = columns.z()[first]
    wind = fall.drift_wind or fall.wind
    left, blown, sums = 3600.0 * fall.drift, 0.0, {"lost": 0.0, "over_edges": 0.0, "settled": True}
    for _ in range(MOST_STEPS):
        lies = np.zeros((raster.nx, raster.ny))
        lies.ravel()[column[first]] = depth[first]
        new, dt, came, went = drifted(top, lies, fall.new_density, raster.cell, wind, left)
        depth = depth.copy()
        depth[first] = new.ravel()[column[first]]
        blown += went - came
        left -= dt
        if fall.stability != "none":
            depth, more = slid_down(columns, depth, fall)
            sums = {**more, **{name: sums[name] + more[name] for name in ("lost", "over_edges")}}
        if left <= 0.0:
            break
    return depth, sums, blown, max(left, 0.0) / 3600.0


def slid_down(columns: Columns, depth: Array, fall: Snowfall) -> tuple[Array, dict[str, Any]]:
    """Return the depth (n,) [m] once all is stable as `fall` has it, and sums of depths that moved [m]."""
    return _core.snowfall.slide(
        columns=columns,
        depth=depth,
        repose=math.tan(math.radians(fall.angle_of_repose)),
        holding_depth=fall.stability == "snowslide",
        least_slope=LEAST_SLOPE,
        gravity=GRAVITY,
        passes=MOST_PASSES,
    )


def slope_of(columns: Columns, raster: Raster, top: Array) -> Array:
    """Return dz/dx and dz/dy of the tops (n,) [m] by differences of places that are one surface, (n, 2)."""
    near = columns.joined(top)
    out = np.zeros((len(top), 2))
    for axis in (0, 1):
        rise, run = np.zeros(len(top)), np.zeros(len(top))
        for k, sign in ((2 * axis, 1.0), (2 * axis + 1, -1.0)):
            is_there = near[:, k] >= 0
            rise[is_there] += sign * (top[near[is_there, k]] - top[is_there])
            run[is_there] += raster.cell
        out[:, axis] = rise / np.maximum(run, raster.cell)
    steep = norms(out)
    return out * np.minimum(1.0, STEEPEST / np.maximum(steep, STEEPEST))[:, None]


def snow_tree(columns: Columns, raster: Raster, top: Array, depth: Array) -> TriangleMesh | None:
    """Return the tops of the snow as a sheet of triangles that shelters what is below; None without snow."""
    near = columns.joined(top)
    a = np.arange(len(top), dtype=np.int32)
    b, d = near[:, 0], near[:, 2]
    c = np.where(b >= 0, near[b, 2], -1)
    whole = (b >= 0) & (c >= 0) & (d >= 0) & (near[d, 0] == c)
    whole &= np.maximum.reduce([depth[a], depth[b], depth[c], depth[d]]) > 0.0
    if not whole.any():
        return None
    quads = np.stack([a, b, c, d], axis=1)[whole]
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    i, j = np.divmod(columns.column(), raster.ny)
    vertices = np.stack(
        [raster.low[0] + (i + 0.5) * raster.cell, raster.low[1] + (j + 0.5) * raster.cell, top], axis=1
    )
    return _core.geometry.TriangleMesh(np.ascontiguousarray(vertices), np.ascontiguousarray(faces))
