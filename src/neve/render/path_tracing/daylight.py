"""Sun and sky as lights of Mitsuba, and the exposure that suits them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.render.lighting import sky_color, sun_color, sun_direction
from neve.render.path_tracing.engine import mitsuba, rgb

if TYPE_CHECKING:
    from neve.scene.schema.scene import Light

Array = NDArray[np.float64]
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
ROUGH = 0.85
HEIGHT = 128
"""Rows of the picture of the sky [px]."""
LEAST_SUN = 1e-3
"""Angle across the sun [degrees], below which its light is parallel: too small for single precision."""
SUN_DISTANCE = 1.5e5
"""Where the sun stands [m]: beyond what cameras see, FAR."""
FAR = 1e5
"""How far cameras see [m]."""
EARTH = np.array([0.12, 0.11, 0.10])
"""Reflectance of the land beyond the scene."""


def sky_toward(light: Light, directions: NDArray[Any]) -> Array:
    """Return the radiance of the sky (n, 3) in unit directions (n, 3); below the horizon, of the land there.

    The shape is the preview's: from a pale horizon to a deep zenith, brighter around the sun. It is scaled so
    that open level ground that reflects all sends back `sky_color`: the integral of L cos over the upper half
    is pi times it.
    """
    color = np.asarray(sky_color(light))
    around, weight = _hemisphere()
    mean = (_shape(light, around) * weight[:, None]).sum(axis=0) / math.pi
    level = np.where(mean > 0, color / np.maximum(mean, 1e-12), 0.0)
    land = (np.asarray(sun_color(light)) * max(sun_direction(light)[2], 0.0) + color) * EARTH
    up = directions[:, 2:3]
    return np.asarray(np.where(up > 0.0, _shape(light, directions) * level, land))


def _shape(light: Light, directions: NDArray[Any]) -> Array:
    color = np.asarray(sky_color(light))
    zenith = color * [0.30, 0.50, 0.82]
    horizon = color * [1.55, 1.58, 1.50]
    up = np.maximum(directions[:, 2:3], 0.0)
    glow = np.clip(0.5 + 0.5 * (directions @ np.asarray(sun_direction(light))), 0.0, 1.0)[:, None] ** 6
    return np.asarray(horizon + (zenith - horizon) * (1.0 - np.exp(-6.5 * up)) + color * (0.5 * glow))


def _hemisphere() -> tuple[Array, Array]:
    """Return directions (n, 3) of the upper half and their share of the integral of cos (n,), pi in all."""
    up = np.sqrt((np.arange(32) + 0.5) / 32)
    turn = 2 * math.pi * (np.arange(64) + 0.5) / 64
    z, a = (part.ravel() for part in np.meshgrid(up, turn, indexing="ij"))
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(a), flat * np.sin(a), z], axis=1), np.full(len(z), math.pi / len(z))


def emitters(light: Light) -> dict[str, Any]:
    """Return the lights "sun" and "sky" of a scene."""
    mi = mitsuba()
    width = 2 * HEIGHT
    # Mitsuba's picture of the surroundings has its top along +y and its middle along +z: turned here to z up.
    v, u = np.meshgrid((np.arange(HEIGHT) + 0.5) / HEIGHT, (np.arange(width) + 0.5) / width, indexing="ij")
    polar, turn = np.pi * v.ravel(), 2 * np.pi * u.ravel()
    own = np.stack([np.sin(turn) * np.sin(polar), np.cos(polar), -np.cos(turn) * np.sin(polar)], axis=1)
    world = np.stack([own[:, 0], -own[:, 2], own[:, 1]], axis=1)
    image = sky_toward(light, world).reshape(HEIGHT, width, 3).astype(np.float32)
    to_world = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    return {"sun": _sun(light), "sky": {"type": "envmap", "bitmap": mi.Bitmap(image), "to_world": to_world}}


def _sun(light: Light) -> dict[str, Any]:
    """Return the sun: a disk far away, which no camera sees, or parallel light if it has no size.

    The disk of half angle a has the radiance E / (pi sin^2 a), so that what faces it gets E = pi sun_color.
    """
    mi, E = mitsuba(), np.pi * np.asarray(sun_color(light))
    toward = np.asarray(sun_direction(light))
    if light.sun_size < LEAST_SUN:
        return {"type": "directional", "direction": (-toward).tolist(), "irradiance": rgb(E)}
    half = math.radians(0.5 * light.sun_size)
    radius = SUN_DISTANCE * math.tan(half)
    look = mi.ScalarTransform4f().look_at(
        (SUN_DISTANCE * toward).tolist(), [0.0, 0.0, 0.0], np.eye(3)[int(np.argmin(np.abs(toward)))].tolist()
    )
    return {
        "type": "disk",
        "to_world": look @ mi.ScalarTransform4f().scale([radius, radius, 1.0]),
        "emitter": {"type": "area", "radiance": rgb(E / (np.pi * math.sin(half) ** 2))},
    }


def sun_keys(light: Light) -> tuple[str, str]:
    """Return the names of the sun's strength and of its weight among Mitsuba's parameters of a scene."""
    if light.sun_size < LEAST_SUN:
        return "sun.irradiance.value", "sun.sampling_weight"
    return "sun.emitter.radiance.value", "sun.emitter.sampling_weight"


def exposure(light: Light) -> tuple[float, Array]:
    """Return what light is multiplied by, one number and the white balance (3,): the same in every frame.

    Snow that the sun meets at 40 degrees is to be 0.85, and its colour half of the way to neutral. Its grains
    shade each other, so that it sends back `ROUGH` of what a smooth white surface does.
    """
    white = ROUGH * (
        math.cos(math.radians(40.0)) * np.asarray(sun_color(light)) + np.asarray(sky_color(light))
    )
    bright = float(white @ LUMINANCE)
    balance = np.sqrt(bright / np.maximum(white, 1e-9))
    return 0.85 / max(bright, 1e-9), np.asarray(balance / (balance @ LUMINANCE))
