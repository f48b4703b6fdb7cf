"""Make snow differ from place to place: factors from noise, depth and height."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import exp, product
from neve.sampling.noise import clods, fractal
from neve.sampling.regions import Region
from neve.sampling.sheets import sheets
from neve.scene.schema.scene import Source
from neve.scene.schema.sources import Variation

Array = NDArray[np.float64]


def factors(source: Source, space: Region, local: Array, seed: int, index: int) -> dict[str, Array]:
    """Return factors [1] (n,) of particles at `local` [m] (n, 3), in the own axes of source number `index`.

    There is one on `stiffness` (Young's modulus), one on `strength` (theta_c and theta_s, cohesion, p0) and
    one on `density`. The noise n is one field, fixed to the source; a factor is exp(amplitude n). Fractal
    noise lies in [-1, 1] with median 0, so that of stiffness and strength is 1; clods and sheets have n = 0
    beside their seams and down to -1 in them. Density is divided by its mean, so that noise leaves the
    source its mass. The factors of the profile are multiplied onto that as they stand.
    """
    made = {name: np.ones(len(local)) for name in ("stiffness", "strength", "density")}
    noise = source.variation
    amplitudes = {name: getattr(noise, name) for name in made} if noise else {}
    if noise and any(amplitudes.values()):
        field = _field(noise, space, local, mixed_seed(seed, index, noise.seed))
        made |= {name: exp(a * field) for name, a in amplitudes.items() if a}
        made["density"] /= made["density"].mean()
    profile = source.profile
    if profile and profile.at:
        if profile.by == "depth":
            coordinate = space.depth(local)
        else:
            coordinate = space.center[2] + product(local + space.middle, space.rotation[2]) - space.lowest
        for name in made:
            if values := getattr(profile, name):
                made[name] = made[name] * np.interp(coordinate, profile.at, values)
    return made


def mixed_seed(*seeds: int) -> int:
    """Return one number made of whole numbers that are not negative."""
    return int(np.random.SeedSequence(list(seeds)).generate_state(1, np.uint64)[0])


def _field(noise: Variation, space: Region, local: Array, seed: int) -> Array:
    if noise.pattern == "clods":
        return clods(local, space.size, noise.feature_size, noise.seam, noise.octaves, seed)
    if noise.pattern == "sheets":
        return sheets(local, space.size, noise.feature_size, noise.seam, noise.octaves, seed)
    return fractal(local, noise.feature_size, noise.octaves, seed)
