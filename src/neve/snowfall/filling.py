"""Particles of lying snow, as a source of a simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from neve.sampling import Samples
from neve.sampling.factors import factors
from neve.sampling.regions import Region
from neve.sampling.room import require_room_for_all
from neve.scene.errors import SceneError
from neve.scene.schema.material import most_strength
from neve.scene.schema.scene import Numerics, Snow, Source
from neve.snowfall.cover import Cover

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

JITTER = 0.8
"""Width of the random places of particles, in their distances."""


def region_of(cover: Cover) -> Region:
    """Return the space that the snow fills, in the axes of the world."""
    is_there = cover.depth > 0.0
    z, tops = cover.z[is_there], (cover.z + cover.depth)[is_there]
    cell = cover.raster.cell
    low = np.array([*cover.raster.low, z.min()])
    high = np.array([low[0] + cover.raster.nx * cell, low[1] + cover.raster.ny * cell, tops.max()])
    middle = 0.5 * (low + high)

    def depth(x: Array) -> Array:
        return depth_below_top(cover, x + middle)

    return Region(
        center=middle,
        rotation=np.eye(3),
        size=high - low,
        volume=cover.volume,
        inside=lambda x: depth(x) >= 0.0,
        depth=lambda x: np.maximum(depth(x), 0.0),
        lowest=float(low[2]),
    )


def depth_below_top(cover: Cover, x: Array) -> Array:
    """Return how far below the top of the snow points (n, 3) [m] lie [m] (n,); below 0 outside of it."""
    raster = cover.raster
    i, j = (np.floor((x[:, k] - raster.low[k]) / raster.cell).astype(np.int64) for k in (0, 1))
    is_over = (i >= 0) & (j >= 0) & (i < raster.nx) & (j < raster.ny)
    column = np.where(is_over, i * raster.ny + j, 0)
    first = np.searchsorted(cover.columns.column(), np.arange(raster.nx * raster.ny + 1))
    at, end = first[column].copy(), first[column + 1]
    found = np.full(len(x), -np.inf)
    while (left := np.flatnonzero(is_over & (at < end))).size:
        site = at[left]
        below = cover.z[site] + cover.depth[site] - x[left, 2]
        is_in = (below >= 0.0) & (x[left, 2] >= cover.z[site])
        found[left[is_in]] = below[is_in]
        at[left] += 1
    return found


def filled_cover(
    source: Source, snow: Snow, cover: Cover, numerics: Numerics, index: int
) -> tuple[Samples, Region]:
    """Return the particles of the snow that lies, scene's source number `index`, and the space that it fills.

    They stand in columns as wide as their distance, evenly from the surface up; where the snow is thinner
    than that, some places have one and others none, so that the mass is the same on average. Each has the
    same share of the volume of its column; the sums are the volume and the mass that lie. Each has the
    density, temperature, water and strength of its layer: the constants of the snow are those of the layer as
    it fell, and what has become denser is stiffer and stronger. Equal arguments give equal bits.

    Errors: SceneError for snow that lies nowhere, too much of it, or a structure, which it has none of.
    """
    name = f"sources.{index}"
    if source.structure == "chunks":
        raise SceneError(f'{name}.structure cannot be "chunks" with shape = "{source.shape}": leave it out')
    if not cover.volume > 0.0:
        raise SceneError(
            f"{name} leaves no snow anywhere: let it fall on what is there, with center and size"
        )
    require_room_for_all(cover.volume / numerics.spacing**3, numerics)
    rng = np.random.default_rng([numerics.seed, index])
    parts = max(1, round(cover.raster.cell / numerics.spacing))
    width = cover.raster.cell / parts
    rows = np.repeat(np.flatnonzero(cover.depth > 0.0), parts * parts)
    wanted = cover.depth[rows] / width
    count = np.floor(wanted + rng.random(len(rows))).astype(np.int64)
    if not count.any():
        raise SceneError(
            f"{name} is too little snow for a single particle with numerics.dx = {numerics.dx:g}; "
            "use a smaller dx, or more snow"
        )
    column = np.repeat(np.arange(len(rows)), count)
    level = np.arange(len(column)) - np.repeat(np.cumsum(count) - count, count)
    sub = column % (parts * parts)
    jitter = JITTER * (rng.random((len(column), 3)) - 0.5)
    site = rows[column]
    offset = (np.stack(np.divmod(sub, parts), axis=1) + 0.5 + jitter[:, :2]) * width - 0.5 * cover.raster.cell
    thick = np.maximum(cover.depth[site], width) / count[column]
    x = cover.x[site]
    x[:, :2] += offset
    x[:, 2] = (
        cover.z[site]
        + np.sum(offset * cover.columns.slope()[site], axis=1)
        + (level + 0.5 + jitter[:, 2]) * thick
    )
    volume = thick * width**2
    volume *= cover.volume / volume.sum()
    height = np.clip((level + 0.5 + jitter[:, 2]) / count[column], 0.0, 1.0) * cover.depth[site]
    state = at_layers(cover, site, cover.layers.at(site, height), volume)
    space = region_of(cover)
    made = factors(source, space, x - space.center, numerics.seed, index)
    v = np.broadcast_to(np.array(source.velocity), x.shape).copy()
    return changed(Samples(x=x, v=v, volume=volume, **made), state, snow), space


def changed(samples: Samples, state: dict[str, Array], snow: Snow) -> Samples:
    """Return particles whose factors are multiplied by those of their layers, within what the law bears."""
    most = most_strength(snow)
    strength = np.minimum(samples.strength * state["strength"], most)
    return replace(
        samples,
        density=samples.density * (state["density"] / snow.rho0),
        stiffness=samples.stiffness * state["stiffness"],
        strength=strength,
        growth=np.maximum(np.minimum(state["growth"], most / strength), 1.0),
        temperature=state["temperature"],
        liquid=state["liquid"],
    )


def at_layers(cover: Cover, site: Rows, layer: Rows, volume: Array) -> dict[str, Array]:
    """Return what particles in these layers of these places are, by name (n,); their mass is the snow's."""
    layers = cover.layers
    found = {
        "density": layers.density,
        "temperature": layers.temperature,
        "liquid": layers.liquid,
        "growth": layers.growth,
        "stiffness": layers.stiffness(),
        "strength": layers.strength(),
    }
    state = {name: values[site, layer] for name, values in found.items()}
    state["density"] = state["density"] * (cover.mass / np.sum(state["density"] * volume))
    return state
