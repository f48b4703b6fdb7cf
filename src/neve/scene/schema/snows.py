"""Name the snows that `snow.kind` knows: constants, where they come from, and how sure one may be of them.

A kind gives defaults: keys of [snow] that are written down override it. Constants that stand nowhere here are
those of the law. Each kind has a tag:

    quoted   read in public code or documents that quote the paper; the paper itself was not at hand
    derived  values of ours that follow a tendency that a paper states
    chosen   our choice, by eye and by small runs
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

Kind = Literal[
    "reference", "powder", "fresh", "packed", "wet", "slush", "icy", "crust", "muddy",
    "cold_dense", "warm_shear", "sliding_slab", "warm_plug", "vallee_de_la_sionne",
]  # fmt: skip
"""The word that picks a snow."""

Tag = Literal["quoted", "derived", "chosen"]

RECIPE = "tendencies of Stomakhin et al. 2013 (as quoted in public codes); density: our choice"
TRIED = "our choice, by throwing a ball of 0.5 m diameter to the ground at 6 m/s with cells of 0.04 m"
LI = "Li et al. 2021, table 1 (as quoted in a public code)"
NOTHING: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True)
class NamedSnow:
    """Hold one snow of the zoo.

    Attributes:
        about: what it is, in one line
        law: its constitutive law
        constants: keys of [snow] -> values [SI]
        source: where the constants come from
        tag: how sure they are
        variation, profile: tables of a source, for sources that have none of their own
    """

    about: str
    source: str
    tag: Tag
    law: str = "stomakhin2013"
    constants: Mapping[str, float] = field(default_factory=lambda: NOTHING)
    variation: Mapping[str, Any] = field(default_factory=lambda: NOTHING)
    profile: Mapping[str, Any] = field(default_factory=lambda: NOTHING)


def _li(about: str, M: float, beta: float, xi: float, p0: float, rho0: float = 250.0) -> NamedSnow:
    """Make a row of the table of Li et al. 2021: all have E0 = 3 MPa and nu = 0.3."""
    constants = {"rho0": rho0, "E0": 3e6, "nu": 0.3, "xi": xi, "M": M, "beta": beta, "p0": p0}
    return NamedSnow(about, LI, "quoted", "cam_clay", constants)


SNOWS: Mapping[str, NamedSnow] = {
    "reference": NamedSnow(
        "the table of the paper, which says of it that it is dense and breaks into chunks",
        "Stomakhin et al. 2013, table 2 (as quoted in public codes)",
        "quoted",
    ),
    "powder": NamedSnow(
        "dry and loose: no cohesion; its heaps rest near 30 degrees or below, not at 48",
        "our choice; friction: fluffy snow rests at 48 to 53 degrees (Soviet observations, archived)",
        "chosen",
        "drucker_prager",
        {"rho0": 100.0, "E0": 1e5, "nu": 0.2, "friction_angle": 48.0, "cohesion": 0.0},
    ),
    "fresh": NamedSnow(
        "a day old: light, crushed at a touch, crumbles softly",
        TRIED,
        "chosen",
        "cam_clay",
        {"rho0": 150.0, "E0": 2e5, "nu": 0.2, "xi": 0.1, "M": 1.2, "beta": 0.4, "p0": 1.2e3},
    ),
    "packed": NamedSnow(
        "pressed by hand: a snowball that bursts into lumps and crumbs",
        TRIED,
        "chosen",
        constants={"rho0": 400.0, "E0": 3.5e5, "theta_s": 5.5e-3, "J_P_min": 0.8},
        variation={"stiffness": 1.2, "strength": 0.4, "feature_size": 0.2},
    ),
    "wet": NamedSnow(
        "heavy and sticky: dents, sticks and stays in one piece",
        TRIED,
        "chosen",
        "cam_clay",
        {"rho0": 480.0, "E0": 6e5, "nu": 0.25, "xi": 0.3, "M": 1.0, "beta": 0.8, "p0": 1e4},
    ),
    "slush": NamedSnow(
        "soaked with water: splashes and flows",
        "our choice; M is that of 15 degrees of repose, from memory and not checked",
        "chosen",
        "cam_clay",
        {"rho0": 700.0, "E0": 2e5, "nu": 0.35, "xi": 0.3, "M": 0.57, "beta": 0.2, "p0": 1e3},
    ),
    "icy": NamedSnow(
        "frozen grains: hard, rebounds, loses pieces where it is weak",
        RECIPE,
        "derived",
        constants={
            "rho0": 500.0,
            "E0": 5e5,
            "xi": 20.0,
            "theta_c": 1.5e-2,
            "theta_s": 4.5e-3,
            "J_P_min": 0.85,
        },
        variation={"stiffness": 1.0, "strength": 0.5, "feature_size": 0.2},
    ),
    "crust": NamedSnow(
        "a frozen shell five centimetres thick around a soft core",
        "the paper's advice of a shell stiffer than the core; the numbers are our choice",
        "chosen",
        constants={"rho0": 300.0, "E0": 1e5, "theta_c": 2e-2, "theta_s": 5e-3, "J_P_min": 0.8},
        variation={"stiffness": 0.4, "strength": 0.3, "feature_size": 0.2},
        profile={
            "at": [0.0, 0.05, 0.08],
            "stiffness": [5.0, 5.0, 1.0],
            "strength": [1.8, 1.8, 1.0],
            "density": [1.5, 1.5, 1.0],
        },
    ),
    "muddy": NamedSnow(
        "dirty and soft: smears and stays where it falls",
        TRIED,
        "chosen",
        "cam_clay",
        {"rho0": 700.0, "E0": 4e5, "nu": 0.3, "xi": 0.1, "M": 0.6, "beta": 1.0, "p0": 4e3},
    ),
    "cold_dense": _li("avalanche regime I, cold dense: flows like sand", 0.5, 0.0, 1.0, 3e3),
    "warm_shear": _li("avalanche regime II, warm shear: granules that shear and stick", 1.5, 0.3, 1.0, 30e3),
    "sliding_slab": _li("avalanche regime III, sliding slab: blocks that stay whole", 1.5, 0.5, 1.0, 42e3),
    "warm_plug": _li("avalanche regime IV, warm plug: a sticky mass that moves as one", 0.5, 1.0, 0.1, 12e3),
    "vallee_de_la_sionne": _li(
        "the avalanche of 7 February 2003 in the Vallee de la Sionne", 0.7, 0.2, 0.002, 3e3, 200.0
    ),
}
"""Kind -> snow, in the order in which they are listed."""
