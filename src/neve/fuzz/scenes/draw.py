"""Draw random scenes: every law, transfer and spline, parameters over their legal ranges, situations that
hurt.

Lengths are drawn in cells, speeds in wave speeds and times in steps, so that every scene costs about the
same, whatever its dx, stiffness and density.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Scene
from neve.scene.values.choices import LAWS, SPLINES, TRANSFERS
from neve.scene.values.elastic import p_wave_modulus

if TYPE_CHECKING:
    from neve._core import Law

Random = np.random.Generator

MOST_STRENGTH = 1.0
"""Largest log-amplitude of the noise on strength."""

MOST_HARDENING = 4.0
"""Largest exponent of hardening: waves at most exp(2) = 7 times as fast; beyond, scenes only take longer."""

_ROOM = 0.99 * math.exp(-MOST_STRENGTH)  # below the limits of thresholds, so that noise keeps to them

STEPS = 150
"""About so many steps of its first dt a scene lasts."""


def draw(seed: int, number: int) -> tuple[Scene, str]:
    """Return scene `number` of the campaign `seed`, and the name of its situation.

    The situations take turns; everything else is random. Equal arguments give the equal scene.
    """
    rng = np.random.default_rng([seed, number])
    names = sorted(SITUATIONS)
    name = names[number % len(names)]
    dx = _log(rng, 1e-4, 100.0)
    snow = _snow(rng)
    c = _wave_speed(snow)
    fast = min(_log(rng, 0.01, 5.0) * c, 5e3)  # [m/s]
    sources, colliders = SITUATIONS[name](rng, dx, fast)
    if rng.random() < 0.3:  # a second snow beside the first, of any law
        sources[-1]["snow"] = other = _snow(rng)
        c = max(c, _wave_speed(other))
    variation: dict[str, Any] = {
        "stiffness": float(rng.uniform(0, 2)),
        "strength": float(rng.uniform(0, MOST_STRENGTH)),
        "density": float(rng.uniform(0, 1)),
        "feature_size": float(rng.uniform(1, 4) * dx),
        "pattern": str(rng.choice(["fractal", "clods"])),
        "seed": int(rng.integers(1000)),
    }
    if variation["pattern"] == "clods":
        variation["seam"] = float(rng.uniform(0.1, 0.5)) * variation["feature_size"]
    if rng.random() < 0.4:
        sources[0]["variation"] = variation
    if rng.random() < 0.2:
        sources[0]["profile"] = {
            "by": str(rng.choice(["depth", "height"])),
            "at": [0.0, dx, 2 * dx],
            "stiffness": [_log(rng, 0.1, 10), 1.0, _log(rng, 0.1, 10)],
            "density": [_log(rng, 0.3, 3), 1.0, 1.0],
        }
        c *= math.sqrt(30)
    numerics = _numerics(rng, dx)
    step = numerics["cfl"] * dx / (c + fast)
    if rng.random() < 0.1:
        numerics["dt"] = float(np.clip(step * rng.uniform(0.1, 1), 1e-12, 1))
    duration = STEPS * step
    pull = rng.standard_normal(3) * _log(rng, 1e-3, 1.0) * dx / duration**2  # about a cell or so of fall
    tables = {
        "about": f"fuzz {seed}/{number}: {name}",
        "world": {"gravity": [float(np.clip(a, -1e4, 1e4)) for a in pull]},
        "numerics": numerics,
        "snow": snow,
        "sources": sources,
        "colliders": colliders,
        "run": {"duration": float(np.clip(duration, 1e-9, 86400)), "film": False},
    }
    return scene_from(tables, where=f"fuzz scene {seed}/{number}"), name


def _numerics(rng: Random, dx: float) -> dict[str, Any]:
    transfer = TRANSFERS[str(rng.choice(list(TRANSFERS)))]
    table: dict[str, Any] = {
        "dx": dx,
        "spline": str(rng.choice(list(SPLINES))),
        "transfer": transfer.name,
        "precision": str(rng.choice(["float32", "float64"])),
        "particles_per_cell": int(rng.choice([1, 4, 8, 27, 64])),
        "sampling": str(rng.choice(["jittered", "poisson", "regular"])),
        "cfl": float(rng.uniform(0.1, 0.6)),
        "dt_max": 1.0,
        "strain_max": float(rng.uniform(0.05, 1.0)),
        "seed": int(rng.integers(1000)),
        "initial_volume": str(rng.choice(["sampled", "grid"])),
    }
    if "polypic_modes" in transfer.options:
        table["polypic_modes"] = int(rng.choice([1, 4, 8, 27]))
    if "flip_alpha" in transfer.options:
        table["flip_alpha"] = float(rng.choice([0.0, 0.5, 0.95, 0.99, 1.0]))
        if rng.random() < 0.3:
            table["flip_damping"] = _log(rng, 1e-2, 1e6)
    return table


def _snow(rng: Random) -> dict[str, Any]:
    """Draw a law, and its constants from the whole of their ranges."""
    law = LAWS[str(rng.choice(list(LAWS)))]
    numbers = _constants(rng, law)
    while law.hardening_exponent(numbers) > MOST_HARDENING:
        numbers = _constants(rng, law)
    if law.has_elastic_option and rng.random() < 0.25:
        elastic = [c.name for c in law.constants if not c.is_plastic]
        return {"law": law.name, "plasticity": "none"} | {name: numbers[name] for name in elastic}
    return {"law": law.name, "plasticity": "snow"} | numbers


def _constants(rng: Random, law: Law) -> dict[str, float]:
    """Draw the constants of `law`: thresholds within its limit, and one in five zero if it may be."""
    numbers = {c.name: _drawn(rng, *c.drawn) for c in law.constants}
    thresholds = [c for c in law.constants if c.is_threshold]
    for c in thresholds:
        if c.low == 0 and not c.open_low and rng.random() < 0.2:
            numbers[c.name] = 0.0
    most = law.most_strength(numbers)
    if math.isfinite(most):
        factor = most * _log(rng, 1e-3, _ROOM)
        for c in thresholds:
            numbers[c.name] = min(numbers[c.name] * factor, 0.99 * c.high)
    return numbers


def _drawn(rng: Random, low: float, high: float) -> float:
    """Draw a number, on a logarithmic scale where the range spans a factor of 100."""
    return _log(rng, low, high) if 0 < 100 * low <= high else float(rng.uniform(low, high))


def _wave_speed(snow: dict[str, Any]) -> float:
    E0, nu = snow["E0"], snow["nu"]
    return math.sqrt(p_wave_modulus(E0, nu) / snow["rho0"])


def _log(rng: Random, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


Situation = Callable[[Random, float, float], tuple[list[dict[str, Any]], list[dict[str, Any]]]]


def _lump(
    rng: Random, dx: float, at: tuple[float, float, float], velocity: tuple[float, float, float]
) -> dict[str, Any]:
    size = rng.uniform(1.5, 5.0, 3) * dx
    body: dict[str, Any] = {"shape": "box", "size": [float(a) for a in size]}
    if rng.random() < 0.5:
        body = {"shape": "sphere", "radius": float(0.5 * size[0])}
    spin = rng.standard_normal(3) * np.linalg.norm(velocity) / (5 * dx)
    return body | {
        "center": [float(a * dx) for a in at],
        "velocity": list(velocity),
        "spin": [float(np.clip(a, -1e4, 1e4)) for a in spin],
    }


def _floor(rng: Random) -> dict[str, Any]:
    mode = str(rng.choice(["separate", "slip", "sticky"]))
    tilt = 0.3 * rng.standard_normal(2)
    return {
        "shape": "plane",
        "point": [0.0, 0.0, 0.0],
        "normal": [float(tilt[0]), float(tilt[1]), 1.0],
        "mode": mode,
        "mu_c": float(rng.uniform(0, 2)),
    }


def _impact(rng: Random, dx: float, fast: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    return [_lump(rng, dx, (0, 0, 3.2), (0.3 * fast, 0.0, -fast))], [_floor(rng)]


def _collision(rng: Random, dx: float, fast: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    left = _lump(rng, dx, (-3.0, 0, 0), (0.5 * fast, 0.0, 0.0))
    return [left, _lump(rng, dx, (3.0, 0.8, 0.3), (-0.5 * fast, 0.0, 0.1 * fast))], []


def _thin_layer(rng: Random, dx: float, fast: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    thin = {"shape": "layer", "size": [6 * dx, 6 * dx], "depth": 0.1 * dx, "base": 0.05 * dx}
    ball = _lump(rng, dx, (0, 0, 4.0), (0.0, 0.0, -fast))
    return [thin, ball], [_floor(rng) | {"normal": [0.0, 0.0, 1.0]}]  # tilted, it could hold the whole layer


def _loners(rng: Random, dx: float, fast: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Specks of a few particles that fly at a floor, at each other and alone."""
    specks = []
    for _ in range(6):
        at = rng.uniform(-3, 3, 3) + np.array([0, 0, 3.5])
        to = -at * fast / np.linalg.norm(at)
        specks.append(
            {
                "shape": "sphere",
                "radius": float(rng.uniform(0.7, 1.2) * dx),
                "center": [float(a * dx) for a in at],
                "velocity": [float(a) for a in to],
            }
        )
    return specks, [_floor(rng)]


def _coincident(rng: Random, dx: float, fast: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Two lumps in the same place, with particles on top of each other, that fly apart and into a floor."""
    lump = _lump(rng, dx, (0, 0, 3.0), (0.2 * fast, 0.0, -0.5 * fast))
    return [lump, lump | {"velocity": [-0.2 * fast, 0.0, -0.5 * fast]}], [_floor(rng)]


def _press(rng: Random, dx: float, fast: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Two plates that close on a lump until less than a cell is left between them."""
    gap, way = 4.0, 3.4
    time = way * dx / fast
    plates = [
        {
            "shape": "box",
            "size": [12 * dx, 12 * dx, 2 * dx],
            "mode": str(rng.choice(["separate", "slip", "sticky"])),
            "mu_c": float(rng.uniform(0, 2)),
            "keyframes": [
                {"t": 0.0, "position": [0.0, 0.0, side * (gap / 2 + 1) * dx]},
                {"t": time, "position": [0.0, 0.0, side * ((gap - way) / 2 + 1) * dx]},
            ],
        }
        for side in (-1, 1)
    ]
    return [_lump(rng, dx, (0, 0, 0), (0.0, 0.0, 0.0))], plates


def _stir(rng: Random, dx: float, fast: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """A paddle that turns in a heap of snow, its tips at the speed `fast`."""
    half = 3.0
    paddle = {
        "shape": "box",
        "center": [0.0, 0.0, 1.5 * dx],
        "size": [2 * half * dx, 1.5 * dx, 2.5 * dx],
        "spin": [0.0, 0.0, float(min(fast / (half * dx), 9e3))],
        "mode": str(rng.choice(["separate", "slip", "sticky"])),
    }
    heap = {"shape": "box", "size": [7 * dx, 7 * dx, 2.5 * dx], "center": [0.0, 0.0, 1.3 * dx]}
    return [heap], [_floor(rng) | {"normal": [0.0, 0.0, 1.0]}, paddle]


SITUATIONS: dict[str, Situation] = {
    "impact": _impact,
    "collision": _collision,
    "thin_layer": _thin_layer,
    "loners": _loners,
    "coincident": _coincident,
    "press": _press,
    "stir": _stir,
}
