"""Small scenes with exact answers, made through the same door as a scene file."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.scene.errors import SceneWarning
from neve.scene.reading.load import scene_from
from neve.scene.values.choices import TRANSFERS
from neve.scene.values.elastic import lame
from neve.simulation import Simulation

Array = NDArray[np.float64]
Table = Mapping[str, Any]

ZERO = (0.0, 0.0, 0.0)
SYMMETRIC = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])
"""Places of xx yy zz xy xz yz in a symmetric matrix."""


def simulation(
    sources: Sequence[Table],
    colliders: Sequence[Table] = (),
    *,
    bodies: Sequence[Table] = (),
    snow: Table | None = None,
    gravity: tuple[float, float, float] = ZERO,
    **numerics: Any,
) -> Simulation:
    """Return the simulation of tables as they stand in a scene file.

    Particles stand on the lattice and numbers are float64 unless `numerics` says otherwise.
    """
    tables = {
        "world": {"gravity": list(gravity)},
        "numerics": {"precision": "float64", "sampling": "regular", **numerics},
        "snow": dict(snow or {}),
        "sources": [dict(source) for source in sources],
        "colliders": [dict(collider) for collider in colliders],
        "bodies": [dict(body) for body in bodies],
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)  # one cell thick on purpose: the walls make it a plane
        return Simulation(scene_from(tables, where="validation"), threads=1)


def elastic(**constants: Any) -> dict[str, Any]:
    """Return snow that never yields."""
    return {"plasticity": "none", **constants}


def transfers() -> dict[str, dict[str, Any]]:
    """Return the numerics of every transfer that Neve has, none of which adds damping of its own."""
    undamped = {"flip_alpha": 1.0, "aflip_damping": 0.0}
    return {
        name: {"transfer": name, **{key: undamped[key] for key in TRANSFERS[name].options if key in undamped}}
        for name in sorted(TRANSFERS)
    }


def box(low: Sequence[float], high: Sequence[float], **more: Any) -> dict[str, Any]:
    """Return the snow of a box between two corners [m]."""
    a, b = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return {"shape": "box", "center": (0.5 * (a + b)).tolist(), "size": (b - a).tolist(), **more}


def plane(
    point: Sequence[float], normal: Sequence[float] | Array, mode: str = "slip", **more: Any
) -> dict[str, Any]:
    """Return a plane through `point` [m]; without friction unless `more` says otherwise."""
    return {
        "shape": "plane",
        "point": [float(a) for a in point],
        "normal": [float(a) for a in normal],
        "mode": mode,
        "mu_c": 0.0,
        **more,
    }


def duct(x: float, y: float) -> list[dict[str, Any]]:
    """Return four smooth walls that confine snow to 0 < x < `x`, 0 < y < `y` [m]: uniaxial strain along z.

    On a grid whose rows of nodes lie in the walls, all nodes that such snow reaches are held across, so
    that a row of cells is exactly a one-dimensional problem.
    """
    return [
        plane((0, 0, 0), (1, 0, 0)),
        plane((x, 0, 0), (-1, 0, 0)),
        plane((0, 0, 0), (0, 1, 0)),
        plane((0, y, 0), (0, -1, 0)),
    ]


def slab(y: float) -> list[dict[str, Any]]:
    """Return two smooth walls that confine snow to 0 < y < `y` [m]: plane strain in x and z."""
    return [plane((0, 0, 0), (0, 1, 0)), plane((0, y, 0), (0, -1, 0))]


def column(sim: Simulation, name: str) -> Array:
    """Return one of the particles' columns in the order of their birth, in double precision."""
    order = np.argsort(np.asarray(sim.state.id))
    return np.asarray(getattr(sim.state, name), dtype=np.float64)[order]


def slow(sim: Simulation, kept: float) -> None:
    """Leave only the share `kept` of all velocities, and of what a particle knows of those around it."""
    for name in ("v", "C"):
        if name in (field.name for field in sim.solver.fields):
            getattr(sim.state, name)[...] *= kept


def stress(sim: Simulation) -> Array:
    """Return the Kirchhoff stress tau of the particles [Pa], (n, 3, 3), in the order of their birth."""
    return np.asarray(column(sim, "tau")[:, SYMMETRIC])


def moduli(E0: float, nu: float) -> tuple[float, float, float]:
    """Return mu, lam and the modulus of uniaxial strain M_c = lam + 2 mu [Pa]."""
    mu, lam = lame(E0, nu)
    return mu, lam, lam + 2 * mu
