"""Draw random scenes: every method, law, transfer and spline, parameters over their legal ranges, situations
that hurt. What is drawn is legal.

Lengths are drawn in cells, speeds in wave speeds and times in steps, so that every scene costs about the
same, whatever its dx, stiffness and density.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from neve.fuzz.scenes.situations import CELLS, SITUATIONS
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Scene
from neve.scene.values.choices import LAWS, SPLINES, TRANSFERS
from neve.scene.values.elastic import p_wave_modulus
from neve.scene.values.fields import SHORTEST

if TYPE_CHECKING:
    from neve._core import Law

Random = np.random.Generator

MOST_STRENGTH = 1.0
"""Largest log-amplitude of the noise on strength."""

MOST_HARDENING = 4.0
"""Largest exponent of hardening: waves at most exp(2) = 7 times as fast; beyond, scenes only take longer."""

_ROOM = 0.99 * math.exp(-MOST_STRENGTH)  # below the limits of thresholds, so that noise keeps to them

LONGEST_FIXED = 3.0
"""Longest fixed step, as a multiple of the first automatic one."""

TILES = 4
"""Seeds of scenes with Poisson-disk samples: each means half a second to make its tile."""

STEPS, SMOOTHED_STEPS = 150, 500
"""About so many steps of its first dt a scene lasts; the second of smoothed particles, whose are longer."""


PARTICLES = 0.25
"""Share of the scenes that are run as particles in contact."""

SMOOTHED = 0.15
"""Share of the scenes that are run as smoothed particles."""

SMOOTHED_PER_CELL = 8
"""Most smoothed particles per cell: their steps cost hundreds of times as much as those of other methods."""

WET = 0.35
"""Share of the scenes of smoothed particles with water."""

WARM, OPEN = 0.25, 0.3
"""Shares of the scenes of the material point method with heat, and of particles with emitters and a sink."""

MOST_SPREAD = 30.0
"""How far heat spreads between two passes, squared, over the spacing squared: more takes as many rounds."""

ON_ITS_OWN = 1
"""Tells the random numbers of what other methods have from those of a scene."""


def draw(seed: int, number: int, method: str | None = None) -> tuple[Scene, str]:
    """Return scene `number` of the campaign `seed`, and the name of its situation.

    The situations take turns; everything else is random. Equal arguments give the equal scene. method: draws
    for one numerics.method alone; what the scene is besides does not depend on it, but for "sph", whose cells
    hold few particles.
    """
    rng = np.random.default_rng([seed, number])
    names = sorted(SITUATIONS)
    name = names[number % len(names)]
    dx = _log(rng, *CELLS.get(name, (1e-4, 100.0)))
    snow = _snow(rng)
    c = _wave_speed(snow)
    fast = min(_log(rng, 0.01, 5.0) * c, 5e3)  # [m/s]
    numerics = _numerics(rng, dx)
    method = method or _drawn_method(seed, number)
    if method == "sph":
        numerics["particles_per_cell"] = min(numerics["particles_per_cell"], SMOOTHED_PER_CELL)
    spacing = dx * numerics["particles_per_cell"] ** (-1 / 3)
    lists = SITUATIONS[name](rng, dx, fast, spacing)
    sources = lists["sources"]
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
    step = numerics["cfl"] * dx / (c + fast)
    fixed = step * _log(rng, 0.1, LONGEST_FIXED)
    if rng.random() < 0.1 and fixed >= SHORTEST:
        numerics["dt"] = min(fixed, 1.0)
    duration = (SMOOTHED_STEPS if method == "sph" else STEPS) * step
    pull = rng.standard_normal(3) * _log(rng, 1e-3, 1.0) * dx / duration**2  # about a cell or so of fall
    tables: dict[str, Any] = {
        "about": f"fuzz {seed}/{number}: {name}",
        "world": {"gravity": [float(np.clip(a, -1e4, 1e4)) for a in pull]},
        "numerics": numerics,
        "snow": snow,
        **lists,
        "run": {"duration": float(np.clip(duration, SHORTEST, 86400)), "film": False},
    }
    _run_by(method, seed, number, tables, fast)
    return scene_from(tables, where=f"fuzz scene {seed}/{number}"), name


def _drawn_method(seed: int, number: int) -> str:
    drawn = np.random.default_rng([seed, number, ON_ITS_OWN]).random()
    if drawn < PARTICLES:
        return "particles"
    return "sph" if drawn < PARTICLES + SMOOTHED else "mpm"


def _run_by(method: str, seed: int, number: int, tables: dict[str, Any], fast: float) -> None:
    """Let a scene be run by `method`, with what only some methods have."""
    own = np.random.default_rng([seed, number, ON_ITS_OWN])
    own.random()  # which drew the method
    if method == "sph":
        _keep_numerics(tables, method, "strain_max")
        more = np.random.default_rng([seed, number, ON_ITS_OWN, 0])
        if more.random() < WET:
            _let_run(more, tables)
    elif method == "particles":
        _as_particles(own, tables, fast)
        more = np.random.default_rng([seed, number, ON_ITS_OWN, 0])
        if more.random() < OPEN:
            tables |= _coming_and_going(more, tables["numerics"]["dx"], fast, tables["run"]["duration"])
    elif own.random() < WARM:
        tables["heat"] = _heat(own, tables)


def _keep_numerics(tables: dict[str, Any], method: str, *more: str) -> None:
    """Let a scene be run by a method without a grid: keep what it knows of `numerics`, and `more` keys."""
    kept = ("dx", "precision", "particles_per_cell", "sampling", "cfl", "dt", "dt_max", "seed", *more)
    numerics = tables["numerics"]
    tables["numerics"] = {"method": method} | {key: numerics[key] for key in kept if key in numerics}


def _let_run(rng: Random, tables: dict[str, Any]) -> None:
    """Let one of the sources be water."""
    source = tables["sources"][int(rng.integers(len(tables["sources"])))]
    for key in ("snow", "variation", "profile"):
        source.pop(key, None)
    source["phase"] = "water"
    tables["water"] = {
        "density": _log(rng, 300.0, 3e3),
        "bulk_modulus": _log(rng, 1e5, 1e10),
        "viscosity": float(rng.choice([0.0, _log(rng, 1e-3, 1e2)])),
    }


def _as_particles(rng: Random, tables: dict[str, Any], fast: float) -> None:
    """Let a scene be run as particles in contact, half of the scenes with heat, a quarter with sleep.

    fast: speed of what moves [m/s].
    """
    _keep_numerics(tables, "particles")
    if rng.random() < 0.5:
        tables["heat"] = _heat(rng, tables)
    if rng.random() < 0.25:
        tables["numerics"] |= {
            "sleep": True,
            "sleep_speed": min(_log(rng, 1e-3, 0.3) * fast, 1.0),
            "sleep_after": min(float(rng.uniform(0.02, 0.3)) * tables["run"]["duration"], 10.0),
        }


def _heat(rng: Random, tables: dict[str, Any]) -> dict[str, Any]:
    """Draw heat that goes no faster than takes some hundred rounds a pass."""
    numerics = tables["numerics"]
    conductivity = _log(rng, 1e-3, 1e3)
    spacing = numerics["dx"] * numerics["particles_per_cell"] ** (-1 / 3)
    capacity = 2100.0 * tables["snow"]["rho0"] * spacing**2  # over conductivity and time, of a particle
    most = MOST_SPREAD * capacity / max(conductivity, 1.0) / 0.01
    return {
        "snow_temperature": float(rng.choice([0.0, rng.uniform(-40, 0)])),
        "air_temperature": float(rng.uniform(-40, 40)),
        "air_exchange": float(rng.choice([0.0, _log(rng, 1.0, 1e3)])),
        "sun": float(rng.choice([0.0, _log(rng, 10.0, 1e4)])),
        "albedo": float(rng.uniform(0, 1)),
        "conductivity": "density" if rng.random() < 0.5 else conductivity,
        "heat_speed": max(min(_log(rng, 1e-3, 1e6), most), 1e-3),
        "sintering": bool(rng.random() < 0.5),
    }


def _coming_and_going(rng: Random, dx: float, fast: float, duration: float) -> dict[str, Any]:
    """Draw one or two emitters, wherever they are, the sources included, and a sink."""
    emitters = []
    for _ in range(int(rng.integers(1, 3))):
        direction = rng.standard_normal(3)
        speed = float(np.clip(_log(rng, 0.01, 1.0) * fast, 1e-3, 5e3))
        emitter = {
            "shape": "box",
            "size": [float(a) for a in rng.uniform(1.5, 3.0, 3) * dx],
            "center": [float(a) for a in rng.uniform(-3, 3, 3) * dx + np.array([0, 0, 4.0]) * dx],
            "velocity": [float(a) for a in direction / np.linalg.norm(direction) * speed],
            "spread": float(rng.choice([0.0, rng.uniform(1, 60)])),
            "start": float(rng.uniform(0, 0.3)) * duration,
        }
        if rng.random() < 0.5:
            emitter["volume_rate"] = float(_log(rng, 0.01, 0.5)) * speed * dx * dx
        emitters.append(emitter)
    sink = {
        "shape": str(rng.choice(["box", "sphere"])),
        "center": [float(a) for a in rng.uniform(-3, 3, 3) * dx],
        "start": float(rng.uniform(0, 0.5)) * duration,
    }
    size = float(rng.uniform(1, 4)) * dx
    sink |= {"radius": 0.5 * size} if sink["shape"] == "sphere" else {"size": [size] * 3}
    return {"emitters": emitters, "sinks": [sink]}


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
    if table["sampling"] == "poisson":
        table["seed"] %= TILES
    if "polypic_modes" in transfer.options:
        table["polypic_modes"] = int(rng.choice([1, 4, 8, 27]))
    if "aflip_damping" in transfer.options:
        table["aflip_damping"] = float(rng.choice([0.0, 0.5, _log(rng, 1e-2, 1e3)]))
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
