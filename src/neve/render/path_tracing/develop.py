"""From light to a picture: denoise, let light spread in the snow, add glints, expose and code."""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import neve._render as _render
from neve.render.drops import draw_drops
from neve.render.path_tracing.daylight import LUMINANCE, exposure
from neve.render.path_tracing.snow import unit

if TYPE_CHECKING:
    from neve.render.path_tracing.lens import Lens
    from neve.render.path_tracing.looks import Kind
    from neve.render.path_tracing.tracer import Layers
    from neve.scene.schema.scene import Light

Floats = NDArray[np.float32]

SPREAD = 0.5
"""Radius to which light spreads in snow, in grid spacings of the snow."""
COLORS = (0.75, 0.90, 1.15)
"""Factors of that radius for red, green and blue: blue goes furthest in ice."""
SHARE = 0.75
"""Share of the light that spreads."""
GRAIN = {"diffuse": 0.35, "other": 0.22}
"""Share of what the denoiser took that is put back, where there is snow: grain in place of plaster."""
TAPS = 28
GLINTS = 6e-4
"""Share of flakes that glint: one in some thousand pixels."""
SURFACE = 0.9
"""Exposure of a white surface over that of a volume, which sends less of a low sun straight back."""
KNEE, ROOM = 0.55, 0.41
"""Light up to which pictures are linear, and what the shoulder adds to it at most."""
SPARK = 1.5
"""Light of a pass beyond which it is taken for a spark of noise and cut off, in units of white."""
SHADE = 0.25
"""Light of a pixel below which it lies in shadow, where nothing glints."""


def has_denoiser() -> bool:
    """Say whether Open Image Denoise is installed (`pip install mitsuba-oidn`)."""
    return importlib.util.find_spec("mitsuba_oidn") is not None


def denoised(
    image: Floats, white: float = 1.0, albedo: Floats | None = None, normal: Floats | None = None
) -> Floats:
    """Return an image (h, w, 3) without noise, by Open Image Denoise.

    white: light that is shown as 1. Without it the denoiser would take its measure of what is bright from
    the whole image, and snow that comes into the picture would change all of it.
    """
    import mitsuba_oidn

    more = {} if albedo is None or normal is None else {"albedo": _whole(albedo), "normal": _whole(normal)}
    found = mitsuba_oidn.denoise(_whole(image), hdr=True, input_scale=1.0 / white, **more)
    return np.asarray(found, np.float32)


def develop(
    layers: Layers,
    lens: Lens,
    light: Light,
    daylight: Light,
    kind: Kind,
    dx: float,
    clean: bool,
    spacing: float = 0.0,
) -> Floats:
    """Return exposed linear light (h, w, 3), 1 is white.

    light: of the picture; daylight: what it is exposed for; dx: of the snow's grid [m]; clean: denoise;
    spacing of the particles [m], for the size of drops.
    """
    scale, balance = exposure(daylight)
    if layers.sky is not None:
        scale *= SURFACE
    white = 1.0 / (scale * float(balance.min()))
    if layers.snow is None or layers.depth is None or layers.sky is None:
        total = _clamped(layers.sun, white)
        seen = total
        if clean:
            smooth = denoised(total, white)
            seen = smooth + GRAIN["other"] * (total - smooth)
    else:
        seen = np.zeros_like(layers.sun)
        wide = SPREAD * dx * kind.clarity * lens.focal
        radius = np.asarray(wide / np.maximum(layers.depth, 1e-3 * lens.distance), np.float32)
        for part in (layers.sun, layers.sky):
            whole = _clamped(part, white)
            smooth = denoised(whole, white, layers.albedo, layers.normal) if clean else whole
            spread_out = spread(smooth, layers.snow, layers.depth, radius, SPREAD * dx)
            seen += spread_out + GRAIN["diffuse"] * layers.snow[..., None] * (whole - smooth)
    out = np.maximum(seen, 0.0) * (scale * balance).astype(np.float32)
    if layers.flakes is not None and kind.sparkle:
        _glint(out, layers, lens, light, kind.sparkle)
    if layers.drops is not None:
        draw_drops(out, layers.drops, spacing, layers.depth, lens, light, scale * balance)
    return np.asarray(out, np.float32)


def spread(light: Floats, snow: Floats, depth: Floats, radius: Floats, thick: float) -> Floats:
    """Return the light of a picture after it has spread within the snow: a blur of each colour's own radius.

    Weights are Gaussian in the picture and in depth, so that light stays on one piece of snow.
    snow (h, w): share of each pixel that is snow; radius (h, w) [px]; thick [m]
    """
    if not np.any(snow > 0.0):
        return light
    step = np.arange(TAPS, dtype=np.float32)
    turn, far = np.float32(2.399963) * step, np.sqrt(-2.0 * np.log1p(-(step + 0.5) / TAPS))
    around = np.stack([far * np.cos(turn), far * np.sin(turn)])
    taps = around[:, None, :] * np.array(COLORS, np.float32)[:, None]
    where = _whole(snow), _whole(depth), _whole(radius)
    return _render.spread(_whole(light), *where, _whole(taps), SHARE, 3.0 * thick)


def coded(light: Floats) -> NDArray[np.uint8]:
    """Return light (h, w, 3), 1 is white, as sRGB: linear up to KNEE, then a shoulder that never ends."""
    bright = light @ LUMINANCE.astype(np.float32)
    bent = np.where(bright > KNEE, KNEE + ROOM * (1.0 - np.exp(-(bright - KNEE) / ROOM)), bright)
    shown = light * (bent / np.maximum(bright, 1e-6))[..., None]
    # What is beyond one colour's reach goes over to the others, or a low sun paints snow yellow.
    over = np.maximum(shown.max(axis=2) - 1.0, 0.0)[..., None]
    shown = np.clip(shown + 0.5 * over, 0.0, 1.0)
    low = 12.92 * shown
    high = 1.055 * np.power(np.maximum(shown, 1e-8), 1 / 2.4) - 0.055
    return np.asarray(255.0 * np.where(shown <= 0.0031308, low, high) + 0.5, np.uint8)


def _clamped(image: Floats, white: float) -> Floats:
    """Return the image without the brightest sparks, at most SPARK white: the same in every frame.

    white: light that is shown as 1.
    """
    peak = np.maximum(image.max(axis=2, keepdims=True), 1e-12)
    return np.asarray(image * np.minimum(SPARK * white / peak, 1.0), np.float32)


def _glint(out: Floats, layers: Layers, lens: Lens, light: Light, strength: float) -> None:
    """Brighten the pixels of flakes that mirror the sun: the same ones in every frame, after the denoiser.

    A flake glints if its random facet is within some degrees of halfway between sun and eye; where snow lies
    in shadow the light of its pixel is low, and so is the glint.
    """
    from neve.render.lighting import sun_direction

    flakes = layers.flakes
    assert flakes is not None
    chosen = np.flatnonzero(unit(flakes.names, 11) < 60.0 * GLINTS)
    names, centres = flakes.names[chosen], flakes.centres[chosen]
    z = 2.0 * unit(names, 12) - 1.0
    turn, flat = 2.0 * np.pi * unit(names, 13), np.sqrt(np.maximum(1.0 - z * z, 0.0))
    facet = np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)
    turns = flakes.turns[chosen] if len(flakes.turns) > 1 else flakes.turns
    facet = (turns @ facet[:, :, None])[:, :, 0]
    toward = lens.eye - centres
    half = toward / np.linalg.norm(toward, axis=1, keepdims=True) + np.asarray(sun_direction(light))
    half /= np.maximum(np.linalg.norm(half, axis=1, keepdims=True), 1e-9)
    mirrored = np.abs((facet * half).sum(axis=1))
    bright = np.clip((mirrored - 0.97) / 0.03, 0.0, 1.0) ** 2
    column, row, depth = lens.project(centres)
    seen = (
        (bright > 0) & (depth > 0) & (column >= 0) & (row >= 0) & (column < lens.width) & (row < lens.height)
    )
    r, q = row[seen].astype(np.int64), column[seen].astype(np.int64)
    if layers.depth is not None:
        front = np.abs(layers.depth[r, q] - np.linalg.norm(toward[seen], axis=1)) < 0.01 * depth[seen]
        r, q, bright = r[front], q[front], bright[seen][front]
    else:
        bright = bright[seen]
    lit = out[r, q] @ LUMINANCE.astype(np.float32)
    r, q, bright, lit = (values[lit > SHADE] for values in (r, q, bright, lit))
    shine = SHADE + np.minimum(lit - SHADE, 1.0) * (1.0 + 1.6 * strength * bright)
    np.maximum.at(out, (r, q), shine[:, None])


def _whole(image: NDArray[Any]) -> Floats:
    return np.ascontiguousarray(image, np.float32)
