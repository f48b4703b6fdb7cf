"""Situations that hurt: lumps collide, hit a floor, are pressed, stirred, hit by bodies; thin layers; specks.

Each is a function of a random generator, the cell dx [m], a speed [m/s] and the distance between particles
[m]; it returns the lists of a scene. Every source holds a particle outside the colliders.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Random = np.random.Generator
Tables = dict[str, list[dict[str, Any]]]

Situation = Callable[[Random, float, float, float], Tables]


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


def _impact(rng: Random, dx: float, fast: float, spacing: float) -> Tables:
    return {"sources": [_lump(rng, dx, (0, 0, 3.2), (0.3 * fast, 0.0, -fast))], "colliders": [_floor(rng)]}


def _collision(rng: Random, dx: float, fast: float, spacing: float) -> Tables:
    left = _lump(rng, dx, (-3.0, 0, 0), (0.5 * fast, 0.0, 0.0))
    return {"sources": [left, _lump(rng, dx, (3.0, 0.8, 0.3), (-0.5 * fast, 0.0, 0.1 * fast))]}


def _thin_layer(rng: Random, dx: float, fast: float, spacing: float) -> Tables:
    thin = {"shape": "layer", "size": [6 * dx, 6 * dx], "depth": 0.1 * dx, "base": 0.05 * dx}
    ball = _lump(rng, dx, (0, 0, 4.0), (0.0, 0.0, -fast))
    flat = _floor(rng) | {"normal": [0.0, 0.0, 1.0]}  # tilted, it could hold the whole layer
    return {"sources": [thin, ball], "colliders": [flat]}


def _loners(rng: Random, dx: float, fast: float, spacing: float) -> Tables:
    """Specks of a few particles, of one at least, that fly at a floor, at each other and alone."""
    floor = _floor(rng)
    up = np.array(floor["normal"]) / np.linalg.norm(floor["normal"])
    specks = []
    for _ in range(6):
        radius = max(rng.uniform(0.7, 1.2), 0.95 * spacing / dx)
        at = rng.uniform(-3, 3, 3) + np.array([0, 0, 3.5])
        at += up * max(radius * rng.uniform(0.5, 1.5) - at @ up, 0.0)
        to = -at * fast / np.linalg.norm(at)
        specks.append(
            {
                "shape": "sphere",
                "radius": float(radius * dx),
                "center": [float(a * dx) for a in at],
                "velocity": [float(a) for a in to],
            }
        )
    return {"sources": specks, "colliders": [floor]}


def _coincident(rng: Random, dx: float, fast: float, spacing: float) -> Tables:
    """Two lumps in the same place, with particles on top of each other, that fly apart and into a floor."""
    lump = _lump(rng, dx, (0, 0, 3.0), (0.2 * fast, 0.0, -0.5 * fast))
    other = lump | {"velocity": [-0.2 * fast, 0.0, -0.5 * fast]}
    return {"sources": [lump, other], "colliders": [_floor(rng)]}


def _press(rng: Random, dx: float, fast: float, spacing: float) -> Tables:
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
    return {"sources": [_lump(rng, dx, (0, 0, 0), (0.0, 0.0, 0.0))], "colliders": plates}


def _stir(rng: Random, dx: float, fast: float, spacing: float) -> Tables:
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
    return {"sources": [heap], "colliders": [_floor(rng) | {"normal": [0.0, 0.0, 1.0]}, paddle]}


def _bodies(rng: Random, dx: float, fast: float, spacing: float) -> Tables:
    """One to three bodies, light or heavy, that fall into a heap, fly past it or turn on a hinge."""
    bodies = []
    for place in range(int(rng.integers(1, 4))):
        half = float(rng.uniform(0.5, 1.2) * dx)
        body: dict[str, Any] = {"shape": "box", "size": [2 * half, 2 * half, 2 * half]}
        if rng.random() < 0.5:
            body = {"shape": "sphere", "radius": half}
        body |= {
            "center": [float((place - 1) * 2.7 * dx), 0.0, float(4.5 * dx)],
            "density": _log(rng, 1.0, 1e4),
            "mode": str(rng.choice(["separate", "slip", "sticky"])),
            "mu_c": float(rng.uniform(0, 2)),
        }
        turn = float(min(fast / dx, 9e3))
        if rng.random() < 0.3:
            anchor = [body["center"][0], 2 * dx, 4.5 * dx]
            body |= {
                "joint": "hinge",
                "axis": [1.0, 0.0, 0.0],
                "anchor": anchor,
                "spin": [0.3 * turn, 0.0, 0.0],
            }
        else:
            body |= {"velocity": [0.0, 0.0, -fast], "spin": [0.0, 0.3 * turn, 0.0]}
        bodies.append(body)
    heap = {"shape": "box", "size": [7 * dx, 4 * dx, 2.5 * dx], "center": [0.0, 0.0, 1.3 * dx]}
    return {"sources": [heap], "colliders": [_floor(rng) | {"normal": [0.0, 0.0, 1.0]}], "bodies": bodies}


def _log(rng: Random, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


CELLS = {"bodies": (1e-2, 1.0)}
"""Range of cells [m] of situations that cannot have any: the engine of rigid bodies takes no less inertia,
and its own steps are many in the long steps of large cells."""

SITUATIONS: dict[str, Situation] = {
    "impact": _impact,
    "collision": _collision,
    "thin_layer": _thin_layer,
    "loners": _loners,
    "coincident": _coincident,
    "bodies": _bodies,
    "press": _press,
    "stir": _stir,
}
