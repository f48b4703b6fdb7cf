"""Kernels, model and fresh snow of methods without a grid."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.backend import backend
from neve.build import PlacedSolids, material_table, samples_of
from neve.cuda.errors import DeviceError
from neve.sampling import Samples
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene, Snow
from neve.solver import Field

if TYPE_CHECKING:
    from neve._core import Model as CoreModel
    from neve._core import Precision


def kernels_with(scene: Scene, state: str) -> Precision:
    """Return the compiled stages for the scene's precision, which have the class `state`.

    Errors: SceneError for a device that has none.
    """
    numerics = scene.numerics
    try:
        found = backend("cpu" if numerics.device == "auto" else numerics.device).kernels(numerics.precision)
    except DeviceError:  # nor has what is not there
        found = None
    if found is None or not hasattr(found, state) or hasattr(found, "device"):  # of a GPU
        raise SceneError(
            f'numerics.device = "{numerics.device}" has no numerics.method = "{numerics.method}": use "cpu"'
        )
    return found


def model_of(scene: Scene, core: Precision) -> CoreModel:
    """Return the core's model of the scene: gravity, and neither snows nor solids yet."""
    gravity = np.array(scene.world.gravity, dtype=np.float64)
    return core.Model(scene.numerics.dx, scene.numerics.spline, "pic", 0.0, gravity)


def fresh_snow(
    scene: Scene,
    solids: PlacedSolids,
    indices: Sequence[int],
    fields: Sequence[Field],
    more: Callable[[Samples, Snow], tuple[Samples, Mapping[str, NDArray[Any]]]],
) -> dict[str, NDArray[Any]]:
    """Return the particles of the sources of these indices as arrays of `fields`, in their order.

    more: returns the samples of one source, of this snow, as its particles are to lie, and what only the
    method's own fields hold. Errors: as `neve.mpm.initial.snow_of`.
    """
    rows_of = {snow: row for row, snow in enumerate(material_table(scene))}
    numbers = {"real": scene.numerics.precision}
    parts = [{f.name: np.zeros((0, *map(int, f.shape)), numbers.get(f.dtype, f.dtype)) for f in fields}]
    for i, samples in zip(indices, samples_of(scene, solids, indices), strict=True):
        snow = scene.snow_of(scene.sources[i])
        s, own = more(samples, snow)
        count = len(s.x)
        columns = {
            "x": s.x,
            "v": s.v,
            "m": snow.rho0 * s.density * s.volume,
            "V0": s.volume,
            "J_P": np.ones(count) if s.J_P is None else s.J_P,
            "stiffness": s.stiffness,
            "strength": s.strength if s.growth is None else s.strength * s.growth,
            "material": np.full(count, rows_of[snow]),
            "source": np.full(count, i),
            "id": np.zeros(count),
            **own,
        }
        parts.append({f.name: columns[f.name].astype(numbers.get(f.dtype, f.dtype)) for f in fields})
    found = {field.name: np.concatenate([part[field.name] for part in parts]) for field in fields}
    return found | {"id": np.arange(len(found["x"]), dtype=np.uint32)}
