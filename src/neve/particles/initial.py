"""Fill the sources of a scene with particles in contact."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.build import (
    PlacedSolids,
    coupled,
    material_table,
    require_lasting_snows,
)
from neve.flow.flow import Newborn
from neve.gridless.initial import fresh_snow, kernels_with, model_of
from neve.heat.clock import heat_model
from neve.heat.enthalpy import enthalpy_at
from neve.particles.constants import (
    BOND_GAP,
    DAMPING,
    HARDENING,
    ICE,
    PACKING,
    SWINGING,
    TANGENTIAL,
    contact_constants,
    radius_at_birth,
)
from neve.sampling import Samples
from neve.scene.schema.scene import Scene, Snow
from neve.solver import Field, fill_columns

if TYPE_CHECKING:
    from neve._core import Particles, Precision

FIELDS = (
    Field("x", (3,), "m", "real", "position"),
    Field("v", (3,), "m/s", "real", "velocity"),
    Field("m", (), "kg", "real", "mass"),
    Field("V0", (), "m3", "real", "volume of snow at birth"),
    Field("radius", (), "m", "real", "radius"),
    Field("J_P", (), "1", "real", "volume over that at birth"),
    Field("stiffness", (), "1", "real", "factor on E0"),
    Field("strength", (), "1", "real", "factor on the thresholds of bonds and compaction"),
    Field("liquid", (), "1", "real", "share of water that size and strength follow"),
    Field("rest", (4,), "s, m, N", "real", "time near a place and it; in sleep infinite, and the force"),
    Field("enthalpy", (), "J", "float64", "heat; zero for ice at the melting point"),
    Field("material", (), "", "uint16", "row of the material table"),
    Field("source", (), "", "uint16", "number of the source"),
    Field("id", (), "", "uint32", "number in the order of birth"),
)
"""All that a particle owns, beside its contacts (see `neve._core.Particles.contacts`)."""

ROUNDS, ROUNDS_BETWEEN_LISTS = 60, 6
"""How often overlaps of fresh snow are moved apart, and how often with the same lists of neighbours."""


def kernels(scene: Scene) -> Precision:
    """Return the compiled stages for the scene's precision. Errors: SceneError for a device that has none."""
    return kernels_with(scene, "Particles")


def place_solids(scene: Scene) -> PlacedSolids:
    """Return the scene's solids in the core, the bodies where they start. Errors: SceneError."""
    require_lasting_snows(scene)
    solids, rigid = coupled(scene)
    native = model_of(scene, kernels(scene))
    return PlacedSolids(native, scene.colliders, solids, rigid, scene.numerics.dx)


def snow_of(scene: Scene, solids: PlacedSolids, indices: Sequence[int]) -> dict[str, NDArray[Any]]:
    """Return the particles of the sources of these indices as arrays of FIELDS, in the order of the sources.

    Each source is packed on its own: the particles that `neve.sampling` places are moved apart until they
    hardly overlap. Errors: as `neve.mpm.initial.snow_of`.
    """

    def lying(samples: Samples, snow: Snow) -> tuple[Samples, dict[str, NDArray[Any]]]:
        radius = np.array([radius_at_birth(volume) for volume in samples.volume])
        s = packed(scene, samples, radius, solids)
        m = (snow.rho0 * s.density * s.volume).astype(scene.numerics.precision)
        return s, {
            "radius": radius,
            "liquid": np.zeros(len(s.x)),
            "rest": np.zeros((len(s.x), 4)),
            "enthalpy": enthalpy_at(scene, m, s),
        }

    return fresh_snow(scene, solids, indices, FIELDS, lying)


def packed(scene: Scene, samples: Samples, radius: NDArray[np.float64], solids: PlacedSolids) -> Samples:
    """Return `samples` with their positions moved apart, so that spheres of `radius` [m] (n,) hardly overlap.

    They are moved out of the solids too: what touches one at birth touches it without a force.
    """
    core = kernels(scene)
    count = len(samples.x)
    fresh = core.Particles(count)
    middle = samples.x.mean(axis=0)
    fresh.x[...] = samples.x - middle
    fresh.radius[...] = radius
    near = 2.0 * float(np.max(fresh.radius))
    around = solids.near(samples.x.min(axis=0) - near, samples.x.max(axis=0) + near)
    for done in range(ROUNDS):
        if done % ROUNDS_BETWEEN_LISTS == 0:
            fresh.prepare(1.2 * near, 0.0)
        fresh.relax()
        for i in around:
            phi, normal = solids.native.surface(i, np.asarray(fresh.x, dtype=np.float64) + middle)
            fresh.x[...] += np.maximum(np.asarray(fresh.radius) - phi, 0.0)[:, None] * normal
    x = np.empty((count, 3))
    x[np.asarray(fresh.id)] = fresh.x
    return replace(samples, x=x + middle)


def from_arrays(scene: Scene, arrays: Mapping[str, NDArray[Any]]) -> Particles:
    """Make particles from the arrays of FIELDS. Errors: ValueError for an array of another shape or kind."""
    particles = kernels(scene).Particles(len(arrays["m"]))
    fill_columns(particles, FIELDS, arrays)
    return particles


class BirthBounds(NamedTuple):
    """Hold bounds of what emitters add, 0 without any.

    Largest k / m of a particle [1/s2], and radius [m].
    """

    stiffest: float = 0.0
    radius: float = 0.0


def birth_bounds(scene: Scene, newborn: Sequence[Newborn]) -> BirthBounds:
    """Return the bounds of the snow that leaves the scene's emitters."""
    table = material_table(scene)
    found = []
    for snow in newborn:
        constants, radius = (
            contact_constants(table[snow.material]),
            radius_at_birth(snow.volume / snow.particles),
        )
        found.append(BirthBounds(constants.modulus * radius * snow.particles / snow.mass, radius))
    return BirthBounds(*(max(column) for column in zip(*found, strict=True))) if found else BirthBounds()


def set_constants(scene: Scene, particles: Particles, born: BirthBounds) -> None:
    """Give the core the constants of the scene's snows, of all contacts, and of heat.

    The damper of a contact is its stiffness times one time for all, so that no contact of a particle has more
    than the damping ratio DAMPING: c = 2 DAMPING k min_p sqrt(m_p / (2 k_p)), with what emitters may add.
    """
    table = np.array([contact_constants(snow) for snow in material_table(scene)], dtype=np.float64)
    particles.set_materials(table, PACKING)
    stiffest = max(particles.stiffest, born.stiffest)
    damping = 2.0 * DAMPING * math.sqrt(0.5 / stiffest) if stiffest > 0.0 else 0.0
    particles.set_law(damping, TANGENTIAL, ICE, HARDENING)
    numerics = scene.numerics
    way = numerics.sleep_speed * numerics.sleep_after if numerics.sleep else 0.0
    particles.set_sleep(way, numerics.sleep_after, SWINGING * numerics.sleep_speed)
    if heat := heat_model(scene):
        particles.set_heat(heat)


def reach(scene: Scene, particles: Particles, born: BirthBounds, fresh: bool = False) -> float:
    """Return the distance within which two particles may begin to act on each other [m].

    They touch; what is bonded, or coheres, is listed at any distance. Snow that is `fresh`, or leaves an
    emitter, is bonded across BOND_GAP, and heat passes across it. One percent more is for rounding. Without
    snow: any length.
    """
    gap = BOND_GAP if fresh or scene.emitters or scene.heat is not None else 0.0
    radius = max(particles.largest_radius, born.radius)
    return 2.0 * radius * (1.01 + gap) if radius > 0.0 else scene.numerics.spacing
