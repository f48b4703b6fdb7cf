"""Rebuild a run while it goes on: another model for the same snow, or more snow for the same model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.build import material_table, require_same_sources, wakes_all, with_one_more
from neve.flow.births import Births
from neve.mpm.initial import make_model, snow_of
from neve.mpm.model import Model
from neve.mpm.state import BEYOND_NUMBERS, REST_NUMBERS, fit_modes, fit_numbers, from_arrays, to_arrays
from neve.rigid.going_on import going_on
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene, Source
from neve.solver import joined

if TYPE_CHECKING:
    from neve._core import State


def with_scene(scene: Scene, new_scene: Scene, model: Model, state: State) -> tuple[Model, State]:
    """Return the model of `new_scene` and the state with which its run goes on from a run of `scene`.

    The particles keep their place, motion, mass, deformation and hardening; each follows the snow that its
    source has in `new_scene`. Where the transfer has other modes of the velocity, the new ones are zero.
    Snow that sleeps wakes, unless nothing has changed but what is shown.
    Rigid bodies go on as `neve.rigid.going_on.going_on` says.

    Errors: SceneError if a run cannot change so: the number of sources, emitters that go, or
    the snow of one of several sources or emitters that shared theirs.
    """
    require_same_sources(scene, new_scene)
    rows = _rows(scene, new_scene)
    fresh = going_on(scene, new_scene, model, make_model)
    old, new = (
        (type(m.core), m.is_fine, m.native.more_modes, m.native.has_play, m.sleeps) for m in (model, fresh)
    )
    if old != new:
        arrays = to_arrays(state)
        state = from_arrays(
            fresh.core,
            arrays,
            beyond=fit_numbers(arrays["beyond"], BEYOND_NUMBERS, fresh.is_fine, arrays["x"]),
            modes=fit_modes(arrays["modes"], model.native.more_modes - model.native.has_play, fresh.native),
            rest=fit_numbers(arrays["rest"], REST_NUMBERS, fresh.sleeps, arrays["x"]),
        )
    if wakes_all(scene, new_scene):
        state.rest[...] = 0.0
    if not np.array_equal(rows, np.arange(len(rows))):
        state.material[...] = rows[state.material]
    return fresh, state


def with_source(
    scene: Scene, source: Source, model: Model, state: State, births: Births, time: float
) -> tuple[Scene, Model, State, Births]:
    """Return the scene with one more source, its model, the state with the snow of that source, its births.

    The new particles come after the others, and are named (id) on from them; they lie where they would if the
    scene had begun with them. What would lie inside a solid as it stands at `time` [s] is left out, and a
    SceneWarning says so.

    Errors: SceneError if the source is too small or too large, or wholly inside a solid;
    pydantic.ValidationError if its snow is not allowed.
    """
    new_scene = with_one_more(scene, source)
    more = going_on(scene, new_scene, model, make_model)
    more.place_solids(time)
    fresh = to_arrays(snow_of(new_scene, more, [len(scene.sources)])[0])
    old = to_arrays(state)
    old["beyond"] = fit_numbers(old["beyond"], BEYOND_NUMBERS, more.is_fine, old["x"])
    both = joined(old, fresh, births.count)
    both["rest"][...] = 0.0
    births = births.copy()
    births.add(len(scene.sources), len(fresh["id"]))
    return new_scene, more, from_arrays(more.core, both), births


def _rows(scene: Scene, new_scene: Scene) -> NDArray[Any]:
    """Return for each row of the material table of `scene` the row in that of `new_scene`."""
    before, after = material_table(scene), material_table(new_scene)
    rows = np.full(len(before), -1, dtype=np.int64)
    pairs = [
        (f"{name}.{i}", old, new)
        for name in ("sources", "emitters")
        for i, (old, new) in enumerate(zip(getattr(scene, name), getattr(new_scene, name), strict=False))
    ]
    for name, old, new in pairs:
        row, to = before.index(scene.snow_of(old)), after.index(new_scene.snow_of(new))
        if rows[row] not in (-1, to):
            raise SceneError(f"{name}.snow cannot part from that of another source while a run goes on")
        rows[row] = to
    return rows.astype(np.uint16)
