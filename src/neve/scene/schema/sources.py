"""Describe where snow is at the start, how it differs from place to place, and where it comes in and goes."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, ClassVar, Literal

from pydantic import model_validator

from neve.scene.schema.material import Overrides, Snow, most_strength, strength_rule
from neve.scene.schema.roles import OneOfItsShapes, Role
from neve.scene.values.fields import (
    CURVES,
    FRITSCH,
    ZERO,
    Distance,
    Factor,
    Length,
    Part,
    Rate3,
    Real,
    Whole,
    check_times,
    entry,
    norm,
    rounded_down,
    wrong,
)

LEAST_SPEED = 1e-3
"""Least speed at which snow leaves [m/s]."""


class Variation(Part):
    """Vary snow from place to place by factors exp(amplitude * noise), all of one field of noise."""

    pattern: Literal["fractal", "clods", "sheets"] = entry(
        "fractal",
        '"fractal": smooth stiff and soft spots, noise from -1 to 1; "clods": lumps of random size pressed '
        "together, 0 inside and down to -1 in the weak seams between them, along which snow then breaks; "
        '"sheets": the same of curved sheets of random extent.',
        "",
        "clods: cells of Worley 1996; the seams are ours; sheets: a recipe in public code of the first "
        "author of Stomakhin et al. 2013, changed",
    )
    stiffness: Real = entry(
        0.0,
        "Amplitude of Young's modulus: its factor lies between about exp(-amplitude) and exp(amplitude), "
        "with median 1 (clods and sheets: down to exp(-amplitude) in them). 0 is none.",
        "1",
        ge=0,
        le=4,
    )
    strength: Real = entry(
        0.0,
        "Amplitude of the yield thresholds (theta_c and theta_s, cohesion, p0), with median 1.",
        "1",
        ge=0,
        le=4,
    )
    density: Real = entry(
        0.0,
        "Amplitude of density; the mean factor is 1, so that the source keeps its mass.",
        "1",
        ge=0,
        le=2,
    )
    feature_size: Length = entry(
        0.2,
        "Size of the largest stiff and soft spots or of a clod, or mean distance between sheets on a line; a "
        "good value is 3 to 8 numerics.dx.",
        "m",
    )
    seam: Length = entry(
        0.04,
        "Width of the seams between clods or of the sheets; a good value is numerics.dx; used by these only.",
        "m",
    )
    octaves: Whole = entry(
        3, "Layers of noise, each half as large and half as strong as the one before.", "1", ge=1, le=8
    )
    seed: Whole = entry(0, "Seed of this noise, combined with numerics.seed.", "1", ge=0, lt=2**32)

    @property
    def acts(self) -> bool:
        """Whether anything varies."""
        return bool(self.stiffness or self.strength or self.density)


class Profile(Part):
    """Vary snow with depth or height: factors at given places, straight lines between, constant beyond."""

    by: Literal["depth", "height"] = entry(
        "depth",
        '"depth": distance below the source\'s own surface (of a layer: below its top); "height": height '
        "above the source's lowest point.",
        "",
    )
    at: tuple[Distance, ...] = entry((), "Depths or heights, each greater than the one before.", "m")
    stiffness: tuple[Factor, ...] = entry(
        (), "Factors on Young's modulus, one for each of `at`; left out, 1.", "1"
    )
    strength: tuple[Factor, ...] = entry(
        (),
        "Factors on the yield thresholds (theta_c and theta_s, cohesion, p0); left out, 1.",
        "1",
    )
    density: tuple[Factor, ...] = entry((), "Factors on density; left out, 1.", "1")

    @model_validator(mode="after")
    def _check(self) -> Profile:
        for a, b in pairwise(self.at):
            if b <= a:
                raise wrong("at", f"must increase, and {b:g} comes after {a:g}")
        for name in ("stiffness", "strength", "density"):
            values = getattr(self, name)
            if values and len(values) != len(self.at):
                raise wrong(name, f"must have as many entries as at, {len(self.at)}")
        return self


class Source(Role):
    """Snow at the start."""

    role = "source"

    velocity: Rate3 = entry((0.0, 0.0, 0.0), "Velocity at the start.", "m/s")
    spin: Rate3 = entry((0.0, 0.0, 0.0), "Angular velocity at the start, about the source's centre.", "rad/s")
    snow: Overrides = entry(Overrides(), "Snow properties of this source alone: any key of [snow].", "")
    phase: Literal["snow", "water"] = entry(
        "snow",
        'What it holds. "water": that of [water], on a regular lattice, with numerics.method = "sph".',
        "",
    )
    overlap: Literal["add", "cut"] = entry(
        "add",
        'Where sources before it in the list fill the same space. "add": both are there, with the sum of '
        'their densities, and a warning says how much; "cut": this one leaves out what those fill.',
        "",
    )
    structure: Literal["plain", "chunks"] | None = entry(
        None,
        'What the snow is built of before variation and profile change it. "plain": the same everywhere; '
        '"chunks": a snowball pressed by hand, which breaks into pieces of all sizes: an outline of lumps, '
        "denser, stiffer and stronger shells toward the surface, particles closer where snow is denser, weak "
        "sheets that divide it; all in proportion to the source. Left out, that of the snow's kind, or "
        "plain.",
        "",
        "a recipe in public code of the first author of Stomakhin et al. 2013, changed",
    )
    structure_seed: Whole = entry(
        0, "Seed of the structure, combined with numerics.seed.", "1", ge=0, lt=2**32
    )
    variation: Variation | None = entry(
        None, "Differences from place to place; left out, those of the snow's kind, or none.", ""
    )
    profile: Profile | None = entry(
        None, "Differences with depth or height; left out, those of the snow's kind, or none.", ""
    )

    @model_validator(mode="after")
    def _dry(self) -> Source:
        for name in ("snow", "structure", "variation", "profile"):
            if self.is_water and getattr(self, name) not in (None, Overrides()):
                raise wrong(name, 'is of snow: leave it out with phase = "water"')
        return self

    @property
    def is_water(self) -> bool:
        """Whether it holds water, not snow."""
        return self.phase == "water"

    @property
    def strongest(self) -> float:
        """Return the largest factor on the thresholds of plastic flow that this source may have [1]."""
        noise = self.variation
        amplitude = noise.strength if noise and noise.pattern == "fractal" else 0.0
        return math.exp(amplitude) * max(self.profile.strength if self.profile else (), default=1.0)


AnySource = Annotated[Source, OneOfItsShapes()]
"""A source of any shape."""


class _Timed(Role):
    """Hold when a part of a scene is at work."""

    start: Real = entry(0.0, "When it begins.", "s", ge=0, le=1e6)
    end: Real | None = entry(None, "When it ends; left out, never.", "s", gt=0, le=1e6)

    @model_validator(mode="after")
    def _check_times(self) -> _Timed:
        if self.end is not None and self.end <= self.start:
            raise wrong("end", f"must be later than start, greater than {self.start:g} [s]")
        return self


class EmitterKeyframe(Part):
    """Say how snow leaves an emitter at one moment; what is left out is the emitter's own."""

    t: Real = entry(0.0, "Time.", "s", ge=0, le=1e6)
    velocity: Rate3 | None = entry(None, "Velocity at `t`; not against the emitter's own.", "m/s")
    mass_rate: Real | None = entry(None, "Mass rate at `t`; needs one of the emitter.", "kg/s", ge=0, le=1e12)
    volume_rate: Real | None = entry(
        None, "Volume rate at `t`; needs one of the emitter.", "m3/s", ge=0, le=1e12
    )


class Emitter(_Timed):
    """An emitter: snow leaves it through its section across `velocity`, at its middle."""

    role = "emitter"
    is_water: ClassVar[bool] = False

    velocity: Rate3 = entry((0.0, 0.0, -1.0), "Velocity with which snow leaves.", "m/s")
    mass_rate: Real | None = entry(
        None,
        "Mass that leaves in a second, at most what fills the section. Left out, with volume_rate, snow "
        "fills the section as it leaves.",
        "kg/s",
        gt=0,
        le=1e12,
    )
    volume_rate: Real | None = entry(
        None, "Volume of snow that leaves in a second, in place of mass_rate.", "m3/s", gt=0, le=1e12
    )
    spread: Real = entry(
        0.0,
        "Largest angle between `velocity` and that of a particle; directions within it are equally likely.",
        "degrees",
        ge=0,
        le=90,
    )
    snow: Overrides = entry(
        Overrides(), "Snow properties of this emitter alone: any key of [snow]. It has no structure.", ""
    )

    keyframes: tuple[EmitterKeyframe, ...] = entry(
        (), f"Velocities and rates at increasing times. {CURVES}", "", FRITSCH
    )

    @property
    def speed(self) -> float:
        """Speed with which snow leaves [m/s]."""
        return norm(self.velocity)

    @model_validator(mode="after")
    def _check_flow(self) -> Emitter:
        if self.velocity == ZERO or self.speed < LEAST_SPEED:
            raise wrong("velocity", f"must be at least {LEAST_SPEED:g} m/s: snow leaves along it")
        if self.mass_rate is not None and self.volume_rate is not None:
            raise wrong("volume_rate", "cannot be combined with mass_rate; leave one of them out")
        check_times(self.keyframes)
        for i, key in enumerate(self.keyframes):
            for name in ("mass_rate", "volume_rate"):
                if getattr(key, name) is not None and getattr(self, name) is None:
                    raise wrong(f"keyframes.{i}.{name}", f"needs {name} of the emitter itself")
            if key.velocity and sum(a * b for a, b in zip(key.velocity, self.velocity, strict=True)) < 0:
                raise wrong(f"keyframes.{i}.velocity", "must not point against velocity, across the section")
        return self


class Sink(_Timed):
    """A sink: snow that is inside is taken out of the run."""

    role = "sink"


AnyEmitter = Annotated[Emitter, OneOfItsShapes()]
"""An emitter of any shape."""
AnySink = Annotated[Sink, OneOfItsShapes()]
"""A sink of any shape."""


def too_strong(source: Source, snow: Snow) -> tuple[str, str] | None:
    """Return key and end of the sentence if a source multiplies the thresholds of its `snow` by too much."""
    most = most_strength(snow)
    if source.strongest <= most * (1 + 1e-9):
        return None
    profile = max(source.profile.strength if source.profile else (), default=1.0)
    if source.profile and profile > most * (1 + 1e-9):
        place = source.profile.at[source.profile.strength.index(profile)]
        return "profile.strength", (
            f"must hold no factor above {rounded_down(most)}, and has {profile:g} at the {source.profile.by} "
            f"{place:g} m, {strength_rule(snow)}"
        )
    amplitude = source.variation.strength if source.variation else 0.0
    times = f" times {profile:g}, the largest factor of profile.strength" if profile > 1.0 else ""
    return "variation.strength", (
        f"must be at most {rounded_down(math.log(most / profile))}: its largest factor is "
        f"exp({amplitude:g}){times}, and {rounded_down(most)} is "
        f"possible {strength_rule(snow)}"
    )
