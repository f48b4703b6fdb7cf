"""Give snow the inner structure of a snowball that was pressed by hand, whatever its shape.

`structure = "chunks"`: an outline of lumps, shells that are denser, stiffer and stronger toward the surface,
particles that are closer where snow is denser, and weak sheets that divide it into pieces of planned sizes.
All lengths are shares of the source's own size, so that it breaks alike at any size. d is the depth below
the surface, D the largest depth.

Source: the recipe for snowballs of the first author of Stomakhin et al. 2013, in public code: balls alone,
with the radius in place of the depth, ten steps in place of the slopes, and noise of each particle, which
is left out here since it would differ with dx. What else differs is said where it stands.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import exp
from neve.sampling.noise import across
from neve.sampling.pressed.pieces import divide, locate, scattered
from neve.sampling.regions import Region

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

DEPTHS = 20_000
"""Random points among which the largest depth is looked for: in a ball they find it within 3 %."""
SMOOTH_RIM = 0.09
"""Depth that only lumps fill, in D."""
LUMP_DEPTHS = (0.1, 0.5)
"""Depths of the middles of lumps, in D; a lump's radius is at least 0.1 D, and reaches the surface at
most."""
LUMPS = 200.0
"""Lumps in a volume of D^3 between LUMP_DEPTHS: 500 in a ball, as there."""
MOST_LUMPS = 20_000
PACKED = 0.25
"""Compaction of the outermost shell over the core, as there: its density is exp(PACKED) = 1.28 times that;
rho0 is the mean."""
STIFFER = 0.7
"""Logarithm of the factor on stiffness of the outermost shell: 2. There it is 10 PACKED = 2.5, a factor of
12, which would make steps 2.5 times as short."""
STRONGER = 0.15
"""Logarithm of the factor on the thresholds of the outermost shell: 1.16. There thresholds are strains, the
same everywhere, and stresses grow as stiffness does. With 0.3 two balls that meet may stick together."""
LARGE, SMALL, LARGER = 4, 12, 2.5
"""Pieces that sheets divide a ball into: 4 of 11 % of its volume and 12 of 4.5 %, a 2.5th of that. Other
shapes have as many in the volume of a ball of radius D. Sheets take up a third of the volume, and crumbs
come of themselves. There 500 sheets lie anywhere, so that some seeds have no pieces of a middle size."""
BALL, MOST_BALLS = 4.0 / 3.0 * np.pi, 250
"""Volume of a ball of radius D, in D^3; snow of more than 250 such balls has larger pieces."""
WIDE = 0.12
"""Width of the sheets, in D."""
WEAK_STRENGTH, WEAK_STIFFNESS = 5.0, 0.7
"""Logarithms of the factors 1/150 on the thresholds and 1/2 on the stiffness in the middle of a sheet.
There it is the stiffness alone, 1/2 for each sheet."""


class Structure(NamedTuple):
    """Hold what a structure makes of particles.

    kept: whether the outline holds a particle (n,). stiffness, strength, density: factors [1] (n,).
    crowd: how many particles there are in a volume, against where they are closest [1] (n,)
    """

    kept: Mask
    stiffness: Array
    strength: Array
    density: Array
    crowd: Array


def chunks(space: Region, local: Array, seed: int) -> Structure:
    """Return the structure of particles at `local` [m] (n, 3), from the middle of the region's box."""
    depth, deepest = space.depth(local), _deepest(space)
    rind = np.maximum(1.0 - depth / deepest, 0.0)
    gap, _ = locate(local, divide(space, planned(space.volume / deepest**3), seed))
    noise = across(gap, WIDE * deepest)
    kept = (depth >= SMOOTH_RIM * deepest) | _in_lumps(space, local, deepest, seed)
    if not kept.any():  # too thin for a lump
        kept = np.ones_like(kept)
    density = exp(PACKED * rind)
    return Structure(
        kept=kept,
        stiffness=exp(STIFFER * rind + WEAK_STIFFNESS * noise),
        strength=exp(STRONGER * rind + WEAK_STRENGTH * noise),
        density=density / density[kept].mean(),
        crowd=exp(PACKED * (rind - 1.0)),
    )


def _deepest(space: Region) -> float:
    """Return D, the largest depth of points that are the same whatever dx and the seed [m]."""
    depths = space.depth(scattered(space, DEPTHS, np.random.default_rng(0)))
    return max(float(depths.max(initial=0.0)), 1e-3 * float(space.size.min()))


def planned(volume: float) -> Array:
    """Return the shares of pieces [1] (k,), which add up to 1, in a `volume` given in D^3."""
    balls = max(round(min(volume / BALL, MOST_BALLS)), 1)
    shares = np.array([LARGER] * (LARGE * balls) + [1.0] * (SMALL * balls))
    return np.asarray(shares / shares.sum())


def _in_lumps(space: Region, local: Array, deepest: float, seed: int) -> Mask:
    """Return whether particles lie in one of the lumps: balls of random size and depth."""
    from scipy.spatial import cKDTree

    rng = np.random.default_rng([seed % 2**64, 0x10B5])
    low, high = LUMP_DEPTHS[0] * deepest, LUMP_DEPTHS[1] * deepest
    tried = int(min(LUMPS * float(np.prod(space.size / deepest)), MOST_LUMPS))
    middles = (rng.random((tried, 3)) - 0.5) * space.size
    share = rng.random(tried)
    middles, share = (part[space.inside(middles)] for part in (middles, share))
    depth = space.depth(middles)
    chosen = (depth >= low) & (depth <= high)
    middles, depth, share = middles[chosen], depth[chosen], share[chosen]
    radii = low + (depth - low) * share
    tree, within = cKDTree(local), np.zeros(len(local), dtype=np.bool_)
    for middle, radius in zip(middles, radii, strict=True):
        within[tree.query_ball_point(middle, radius)] = True
    return within
