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
    gridless_model,
    material_table,
    require_closed,
    samples_of,
)
from neve.cuda.errors import DeviceError
from neve.sampling import Samples
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene
from neve.scene.values.choices import DEFAULT_LAW
from neve.solver import Field, fill_columns
from neve.sph.boundary import Boundary
from neve.sph.constants import SUPPORT, law_constants

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
    Field("stiffness", (), "1", "real", "factor on E0"),
    Field("strength", (), "1", "real", "factor on the critical strains"),
    Field("material", (), "", "uint16", "row of the material table"),
    Field("source", (), "", "uint16", "number of the source"),
    Field("id", (), "", "uint32", "number in the order of birth"),
)
"""All that a particle owns."""


def kernels(scene: Scene) -> Precision:
    """Return the compiled stages for the scene's precision. Errors: SceneError for a device that has none."""
    numerics = scene.numerics
    try:
        found = backend("cpu" if numerics.device == "auto" else numerics.device).kernels(numerics.precision)
    except DeviceError:  # nor has what is not there
        found = None
    if found is None or not hasattr(found, "Sph") or hasattr(found, "device"):  # of a GPU
        raise SceneError(f'numerics.device = "{numerics.device}" has no numerics.method = "sph": use "cpu"')
    return found


def model(scene: Scene, precision: Precision) -> CoreModel:
    """Return the core's model of the scene without solids, its snows as `law_constants` has them."""
    native = gridless_model(scene, precision)
    for snow in material_table(scene):
        native.add_snow(DEFAULT_LAW, snow.plasticity, law_constants(snow))
    return native


def place_solids(scene: Scene) -> PlacedSolids:
    """Return the scene's snows and solids in the core, the bodies where they start. Errors: SceneError."""
    require_closed(scene)
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
    rows_of = {snow: row for row, snow in enumerate(material_table(scene))}
    parts = []
    for i, samples in zip(indices, samples_of(scene, solids, indices), strict=True):
        snow = scene.snow_of(scene.sources[i])
        parts.append(_columns(scene, samples, rows_of[snow], i, snow.rho0))
    columns = {field.name: np.concatenate([part[field.name] for part in parts]) for field in FIELDS[:-1]}
    return columns | {"id": np.arange(len(columns["x"]), dtype=np.uint32)}


def _columns(scene: Scene, s: Samples, row: int, source: int, rho0: float) -> dict[str, NDArray[Any]]:
    real = np.dtype(scene.numerics.precision)
    count = len(s.x)
    reals = {
        "x": s.x,
        "v": s.v,
        "F_E": np.broadcast_to(np.eye(3), (count, 3, 3)),
        "m": rho0 * s.density * s.volume,
        "V0": s.volume,
        "rho_birth": np.zeros(count),  # from the first sums on
        "J_P": np.ones(count),
        "stiffness": s.stiffness,
        "strength": s.strength,
    }
    columns: dict[str, NDArray[Any]] = {
        name: np.asarray(values, dtype=real) for name, values in reals.items()
    }
    return columns | {
        "material": np.full(count, row, dtype=np.uint16),
        "source": np.full(count, source, dtype=np.uint16),
    }


def from_arrays(scene: Scene, arrays: Mapping[str, NDArray[Any]]) -> Sph:
    """Make particles from the arrays of FIELDS. Errors: ValueError for an array of another shape or kind."""
    particles = kernels(scene).Sph(len(arrays["m"]), SUPPORT * scene.numerics.spacing)
    fill_columns(particles, FIELDS, arrays)
    return particles
