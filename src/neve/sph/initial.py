"""Fill the sources of a scene with smoothed particles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.backend import backend
from neve.build import (
    PlacedSolids,
    coupled,
    has_water,
    material_table,
    require_lasting_snows,
)
from neve.gridless.initial import fresh_snow, kernels_with, model_of
from neve.sampling import Samples
from neve.scene.schema.scene import Scene, Snow
from neve.scene.values.choices import DEFAULT_LAW
from neve.solver import Field, fill_columns
from neve.sph.boundary import Boundary
from neve.sph.constants import NUMERICAL_VISCOSITY, SUPPORT, law_constants

if TYPE_CHECKING:
    from neve._core import Model as CoreModel
    from neve._core import Precision, Sph

FIELDS = (
    Field("x", (3,), "m", "real", "position"),
    Field("v", (3,), "m/s", "real", "velocity"),
    Field("F_E", (3, 3), "1", "real", "elastic stretch, symmetric"),
    Field("m", (), "kg", "real", "mass"),
    Field("V0", (), "m3", "real", "volume at birth"),
    Field("rho_birth", (), "kg/m3", "real", "rest density at birth"),
    Field("J_P", (), "1", "real", "rest density at birth over that now"),
    Field("p_last", (), "Pa", "real", "pressure of the last step, from which the next solve starts"),
    Field("a_last", (3,), "m/s2", "real", "acceleration by shear of the last step, likewise"),
    Field("stiffness", (), "1", "real", "factor on E0"),
    Field("strength", (), "1", "real", "factor on the critical strains"),
    Field("material", (), "", "uint16", "row of the material table"),
    Field("source", (), "", "uint16", "number of the source"),
    Field("id", (), "", "uint32", "number in the order of birth"),
)
"""All that a particle owns."""


def kernels(scene: Scene) -> Precision:
    """Return the compiled stages for the scene's precision. Errors: SceneError for a device that has none."""
    return kernels_with(scene, "Sph")


def model(scene: Scene, precision: Precision) -> CoreModel:
    """Return the core's model of the scene without solids, its snows as `law_constants` has them."""
    native = model_of(scene, precision)
    for snow in material_table(scene):
        native.add_snow(DEFAULT_LAW, snow.plasticity, law_constants(snow))
    return native


def place_solids(scene: Scene) -> PlacedSolids:
    """Return the scene's snows and solids in the core, the bodies where they start. Errors: SceneError."""
    require_lasting_snows(scene)
    solids, rigid = coupled(scene)
    native = model(scene, kernels(scene))
    return PlacedSolids(native, scene.colliders, solids, rigid, scene.numerics.dx)


def boundary_of(scene: Scene, placed: PlacedSolids) -> Boundary:
    """Return the sampler of the surfaces of `placed`."""
    exact = backend("cpu").kernels("float64")
    return Boundary(model(scene, exact), placed.solids, scene.numerics.spacing)


def snow_of(scene: Scene, solids: PlacedSolids, indices: Sequence[int]) -> dict[str, NDArray[Any]]:
    """Return the particles of the sources of these indices as arrays of FIELDS, in the order of the sources.

    Errors: as `neve.mpm.initial.snow_of`.
    """

    def lying(s: Samples, snow: Snow) -> tuple[Samples, dict[str, NDArray[Any]]]:
        count = len(s.x)  # the density at birth comes from the first sums on
        none = np.zeros(count)
        first = {"rho_birth": none, "p_last": none, "a_last": np.zeros((count, 3))}
        return s, {"F_E": np.broadcast_to(np.eye(3), (count, 3, 3)), **first}

    return fresh_snow(scene, solids, indices, FIELDS, lying)


def from_arrays(scene: Scene, arrays: Mapping[str, NDArray[Any]]) -> Sph:
    """Make particles from the arrays of FIELDS. Errors: ValueError for an array of another shape or kind."""
    particles = kernels(scene).Sph(len(arrays["m"]), SUPPORT * scene.numerics.spacing)
    fill_columns(particles, FIELDS, arrays)
    set_water(scene, particles)
    return particles


def set_water(scene: Scene, particles: Sph) -> None:
    """Say which of the particles are water, and of which properties, if the scene has any."""
    if has_water(scene):
        row, water = material_table(scene).index(scene.water.material), scene.water
        numerical = NUMERICAL_VISCOSITY * water.density * scene.numerics.spacing
        particles.set_water(row, water.density, water.bulk_modulus, water.viscosity + numerical)
