"""What snow is made of to light, and how well a picture is drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Kind:
    """Hold the look of a kind of snow.

    albedo: of one scattering in its volume, red, green and blue. diffuse: reflectance of its surface.
    clarity: mean free path of light over that of fresh snow. flakes, flake_size: how many there are, and how
    large, over fresh snow. wet: whether a film of water lies on it. sparkle: strength of glints. sun, sky:
    factors of both lights.
    """

    albedo: Triple = (0.985, 0.990, 0.995)
    diffuse: Triple = (0.950, 0.965, 0.985)
    clarity: float = 1.0
    flakes: float = 1.0
    flake_size: float = 1.0
    wet: bool = False
    sparkle: float = 1.0
    sun: float = 1.0
    sky: float = 1.0


KINDS = {
    "fresh": Kind(),
    "packed": Kind(
        albedo=(0.975, 0.984, 0.993),
        diffuse=(0.90, 0.925, 0.955),
        clarity=1.4,
        flakes=0.35,
        flake_size=0.8,
        sparkle=0.5,
    ),
    "wet": Kind(
        albedo=(0.955, 0.972, 0.984),
        diffuse=(0.66, 0.72, 0.765),
        clarity=2.2,
        flakes=0.25,
        flake_size=0.9,
        wet=True,
        sparkle=0.3,
    ),
    "blue_hour": Kind(sun=0.10, sky=1.35, sparkle=0.0),
}
"""Kinds of snow by their word: blue_hour is fresh snow when the sun has almost set."""


SLUSH, WATER = (0.80, 0.84, 0.87), (0.56, 0.64, 0.69)
"""Reflectance of snow a third of which is water, and of water between grains: our choice."""


def wet_color(dry: Triple, wet: NDArray[Any]) -> NDArray[np.float32]:
    """Return the reflectance (n, 3) of snow of liquid shares `wet` (n,), from `dry` over slush to water."""
    at = [0.0, 1.0 / 3.0, 1.0]
    colors = [np.interp(wet, at, values) for values in zip(dry, SLUSH, WATER, strict=True)]
    return np.stack(colors, axis=1).astype(np.float32)


def film_on(wet: NDArray[Any]) -> NDArray[np.float32]:
    """Return the share (n,) of a surface with the liquid shares `wet` (n,) on which a film of water lies."""
    return np.asarray(np.clip(2.0 * np.asarray(wet), 0.0, 1.0), np.float32)


PHASES = ("henyey_greenstein", "cornette_shanks")
"""How a single scattering turns light: Henyey and Greenstein 1941, or Cornette and Shanks 1992, which for g =
0 is Rayleigh's and for g = 0.5 goes more forward."""


@dataclass(frozen=True)
class Medium:
    """Hold how a volume of snow scatters light.

    extinction sigma_t [1/m]; albedo omega: scattered share of what is lost; phase: a word of PHASES; g: its
    parameter, the mean cosine of the angle of a scattering of Henyey and Greenstein
    """

    extinction: float
    albedo: Triple
    g: float = 0.0
    phase: str = "henyey_greenstein"

    @property
    def mean_cosine(self) -> float:
        """The mean cosine of the angle of a scattering."""
        g = self.g
        return g if self.phase == "henyey_greenstein" else 0.6 * g * (4.0 + g * g) / (2.0 + g * g)


REFERENCE = Medium(724.0, (0.9, 0.95, 1.0), 0.5)
"""Stomakhin et al. 2013 [M]."""


def similar(medium: Medium) -> Medium:
    """Return an isotropic medium in which light spreads alike: sigma_s' = (1 - g) sigma_s, same sigma_a.

    omega' = (1 - g) omega / (1 - g omega); one extinction must do for all colours: the mean of
    sigma_t (1 - g omega). Source: similarity relation (van de Hulst 1980; Wyman et al. 1989).
    """
    left = [1.0 - medium.g * w for w in medium.albedo]
    r, g, b = ((1.0 - medium.g) * w / share for w, share in zip(medium.albedo, left, strict=True))
    return Medium(medium.extinction * sum(left) / 3.0, (r, g, b))


def capped(medium: Medium, most: float) -> Medium:
    """Return the medium with an extinction of at most `most` [1/m]; what is thick stays thick."""
    return replace(medium, extinction=min(medium.extinction, most))


LOOKS = ("diffuse", "medium", "fast", "reference", "metaballs")
"""How light meets snow. diffuse: a white surface, with light that spreads in the picture; medium: a volume of
snow, as fine as its grains; fast and reference: such a volume with the constants of Stomakhin et al. 2013,
made isotropic or as published; metaballs: balls of density, lit as in Nishita et al. 1997."""


@dataclass(frozen=True)
class Quality:
    """Hold what a picture may cost.

    look: unless another is chosen. samples: paths for each pixel, of each pass. bounces: of light at
    surfaces. grains, flakes: how many may be drawn. across: size of a grain [px]. size: of the picture [px].
    rays: of each pixel that look what it shows. phase: a word of PHASES, for the look "reference"
    """

    look: str
    samples: int
    bounces: int
    grains: int
    flakes: int
    across: float
    size: tuple[int, int]
    rays: int = 4
    phase: str = "henyey_greenstein"


QUALITIES = {
    "draft": Quality("diffuse", 6, 5, 1_600_000, 150_000, 1.3, (640, 360), 2),
    "good": Quality("diffuse", 12, 10, 8_000_000, 1_000_000, 1.1, (1280, 720)),
    "final": Quality("medium", 20, 12, 8_000_000, 1_000_000, 1.1, (1280, 720)),
}
"""How well pictures are drawn, by their word."""
