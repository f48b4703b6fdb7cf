"""Find what is legal in a scene but probably not intended: too few cells, a long step, unused keys."""

from __future__ import annotations

import math
from collections.abc import Iterator

from neve.scene.checks.joined import joined
from neve.scene.checks.unused import unused
from neve.scene.schema.scene import Body, Collider, Scene, Snow, Source
from neve.scene.values.elastic import p_wave_modulus
from neve.scene.values.fields import norm, rounded_down, rounded_up

SOURCE_CELLS = 3
"""Least number of cells across a source; a thinner one is all surface."""
COLLIDER_CELLS = 2
"""Least number of cells across a solid; on a thinner one snow on both sides shares nodes."""
FEATURE_CELLS = 2
"""Least number of cells across a feature of noise; the grid smooths a smaller one away."""
SEAM_CELLS = 1
"""Least number of cells across a seam; a narrower one tears wider than it is weak."""


def advice(scene: Scene) -> list[str]:
    """Return a sentence for each doubtful value of `scene`, with a better value; nothing if all is well.

    Sentences that are alike are joined (see `neve.scene.checks.joined`).
    """
    found = []
    for i, source in enumerate(scene.sources):
        name, whole = f"sources.{i}", scene.completed(source)
        found += [
            *_thin_source(scene, source, name),
            *_fine_noise(scene, whole, name),
            *_thin_seam(scene, whole, name),
        ]
    found += _long_step(scene)
    if scene.numerics.method == "mpm":  # which has nodes that both sides share
        for i, collider in enumerate(scene.colliders):
            found += _thin_solid(scene, collider, f"colliders.{i}")
        for i, body in enumerate(scene.bodies):
            found += _thin_solid(scene, body, f"bodies.{i}")
    return joined([*found, *unused(scene)])


def fastest(scene: Scene, source: Source) -> float:
    """Return the largest c + |v| in `source` at the start [m/s].

    c = sqrt((lam + 2 mu) / rho0), times the largest sqrt(stiffness / density) of its factors; |v| is at most
    |velocity| + |spin| times the distance of the farthest point from the centre.
    """
    snow, whole = scene.snow_of(source), scene.completed(source)
    factor = 1.0
    if noise := whole.variation:
        factor *= math.exp(abs(noise.stiffness - noise.density))  # one field, so that both are large together
    if (profile := whole.profile) and profile.at:
        ones = (1.0,) * len(profile.at)
        pairs = zip(profile.stiffness or ones, profile.density or ones, strict=True)
        factor *= max(stiffness / density for stiffness, density in pairs)
    speed = norm(source.velocity) + norm(source.spin) * source.reach()
    return math.sqrt(factor) * _wave(snow) + speed


def _wave(snow: Snow) -> float:
    """Return the speed of pressure waves in `snow` at birth [m/s]."""
    return math.sqrt(p_wave_modulus(snow.E0, snow.nu) / snow.rho0)


def _thinner(part: Source | Collider | Body, least: float) -> tuple[str, float] | None:
    """Return the key and the length [m] that make `part` thinner than `least` [m], if one does."""
    thinnest = part.thinnest()
    return thinnest if thinnest is not None and thinnest[1] < least * (1 - 1e-9) else None


def _thin_source(scene: Scene, source: Source, name: str) -> Iterator[str]:
    dx = scene.numerics.dx
    if (found := _thinner(source, SOURCE_CELLS * dx)) is not None:
        key, length = found
        yield (
            f"{name}.{key} makes this snow {length:g} m thick, only {length / dx:.2g} cells of numerics.dx = "
            f"{dx:g}: use numerics.dx = {rounded_down(length / SOURCE_CELLS)} or smaller"
        )


def _fine_noise(scene: Scene, source: Source, name: str) -> Iterator[str]:
    dx, noise = scene.numerics.dx, source.variation
    if not noise or not noise.acts:
        return
    if noise.feature_size < FEATURE_CELLS * dx * (1 - 1e-9):
        yield (
            f"{name}.variation.feature_size = {noise.feature_size:g} is less than two cells of numerics.dx = "
            f"{dx:g}, too fine to matter: use at least {rounded_up(FEATURE_CELLS * dx)}, or numerics.dx = "
            f"{rounded_down(noise.feature_size / FEATURE_CELLS)} or smaller"
        )


def _thin_seam(scene: Scene, source: Source, name: str) -> Iterator[str]:
    dx, noise = scene.numerics.dx, source.variation
    if not noise or noise.pattern == "fractal" or not noise.acts:
        return
    if noise.seam < SEAM_CELLS * dx * (1 - 1e-9):
        yield (
            f"{name}.variation.seam = {noise.seam:g} is below a cell of numerics.dx = {dx:g}, so the "
            f"grid decides where snow parts: use at least {rounded_up(SEAM_CELLS * dx)}, or numerics.dx = "
            f"{rounded_down(noise.seam / SEAM_CELLS)} or smaller"
        )


def _long_step(scene: Scene) -> Iterator[str]:
    """Compare a fixed dt with dx / (c + |v|) of the source or emitter where that is least."""
    numerics = scene.numerics
    if numerics.dt == "auto" or numerics.is_implicit:
        return
    speeds = {f"sources.{i}": fastest(scene, source) for i, source in enumerate(scene.sources)}
    for i, emitter in enumerate(scene.emitters):
        speeds[f"emitters.{i}"] = _wave(scene.snow_of(emitter)) + emitter.speed
    name, speed = max(speeds.items(), key=lambda pair: pair[1])
    limit = numerics.dx / speed
    if numerics.dt > limit:
        yield (
            f"numerics.dt = {numerics.dt:g} exceeds {rounded_down(limit)} s, in which a wave crosses a cell "
            f'of {name}: use {rounded_down(numerics.cfl * limit)} or "auto"'
        )


def _thin_solid(scene: Scene, solid: Collider | Body, name: str) -> Iterator[str]:
    dx = scene.numerics.dx
    if (found := _thinner(solid, COLLIDER_CELLS * dx)) is not None:
        key, length = found
        yield (
            f"{name}.{key} makes this {solid.role} {length:g} m thin, only {length / dx:.2g} cells of "
            f"numerics.dx = {dx:g}: nothing passes through it, but snow on one side drags on snow on the "
            f"other; make it at least {rounded_up(COLLIDER_CELLS * dx)} m thick, or use numerics.dx = "
            f"{rounded_down(length / COLLIDER_CELLS)} or smaller"
        )
