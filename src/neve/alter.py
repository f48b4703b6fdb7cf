"""Alter a run while it goes on: another model for the same snow, or more snow for the same model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.build import make_model, material_table, snow_of
from neve.geometry.pose import rotation_vector
from neve.model import Model
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene, Source
from neve.state import from_arrays, to_arrays

if TYPE_CHECKING:
    from neve._core import State

FIXED = ("dx", "precision", "particles_per_cell", "sampling", "seed", "initial_volume")
"""Keys of [numerics] that say how a state was made, or how its arrays look."""
START = ("center", "rotation", "velocity", "spin")
"""Keys of a rigid body that say where it begins."""
SOLIDS = ("colliders", "bodies", "robots")
"""Lists of a scene that hold solids."""


def altered(scene: Scene, wish: Scene, model: Model, state: State) -> tuple[Model, State]:
    """Return the model of `wish` and the state with which its run goes on from a run of `scene`.

    The particles keep their place, motion, mass, deformation and hardening; each follows the snow that its
    source has in `wish`. Where the transfer has other modes of the velocity, the new ones are zero. Rigid
    bodies keep place and motion, but those whose start `wish` changes begin there; where bodies or robots
    come, go or change, robots and bodies at joints begin anew.

    Errors: SceneError if a key differs that a run cannot change: one of FIXED, the number of sources, or
    the snow of one of several sources that shared theirs.
    """
    for key in FIXED:
        if getattr(wish.numerics, key) != getattr(scene.numerics, key):
            raise SceneError(f"numerics.{key} cannot change while a run goes on; start it anew")
    if len(wish.sources) != len(scene.sources):
        raise SceneError("sources cannot come or go while a run goes on; start it anew, or add snow")
    rows = _rows(scene, wish)
    fresh = _model(scene, wish, model)
    modes = fresh.native.more_modes
    if state.modes.shape[1] != modes:
        arrays = to_arrays(state)
        fitted = np.zeros((len(arrays["m"]), modes, 3), arrays["modes"].dtype)
        kept = min(modes, arrays["modes"].shape[1])
        fitted[:, :kept] = arrays["modes"][:, :kept]
        state = from_arrays(fresh.core, arrays | {"modes": fitted})
    if not np.array_equal(rows, np.arange(len(rows))):
        state.material[...] = rows[state.material]
    return fresh, state


def extended(
    scene: Scene, source: Source, model: Model, state: State, time: float
) -> tuple[Scene, Model, State]:
    """Return the scene with one more source, its model, and the state with the snow of that source.

    The new particles come after the others, and are named (id) on from them; they lie where they would if the
    scene had begun with them. What would lie inside a solid as it stands at `time` [s] is left out, and a
    SceneWarning says so.

    Errors: SceneError if the source is too small or too large, or wholly inside a solid;
    pydantic.ValidationError if its snow is not allowed.
    """
    wish = Scene.model_validate(
        {**{name: getattr(scene, name) for name in Scene.model_fields}, "sources": (*scene.sources, source)}
    )
    more = _model(scene, wish, model)
    more.place_solids(time)
    fresh = to_arrays(snow_of(wish, more, [len(scene.sources)]))
    there = to_arrays(state)
    first = int(there["id"].max()) + 1 if len(there["id"]) else 0
    fresh["id"] = np.arange(first, first + len(fresh["m"]), dtype=there["id"].dtype)
    both = {name: np.concatenate([there[name], fresh[name]]) for name in there}
    return wish, more, from_arrays(more.core, both)


def _model(scene: Scene, wish: Scene, model: Model) -> Model:
    """Return the model of `wish`, with the rigid bodies of `model` where they are."""
    same = all(getattr(wish, name) == getattr(scene, name) for name in SOLIDS[1:])
    if model.rigid is None or same:
        fresh = make_model(wish)
        if fresh.rigid is not None and model.rigid is not None:
            fresh.rigid.take_over(model.rigid)
        return fresh
    poses = dict(zip((solid.name for solid in model.rigid.solids), model.rigid.poses(), strict=True))
    bodies = list(wish.bodies)
    for i, (old, new) in enumerate(zip(scene.bodies, wish.bodies, strict=False)):
        pose = poses.get(f"bodies.{i}")
        if pose is None or new.joint != "free" or any(getattr(old, k) != getattr(new, k) for k in START):
            continue
        bodies[i] = new.model_copy(
            update={
                "center": tuple(map(float, pose.position)),
                "rotation": tuple(map(float, np.degrees(rotation_vector(pose.rotation)))),
                "velocity": tuple(map(float, pose.velocity)),
                "spin": tuple(map(float, pose.omega)),
            }
        )
    return make_model(wish.model_copy(update={"bodies": tuple(bodies)}))


def _rows(scene: Scene, wish: Scene) -> NDArray[Any]:
    """Return for each row of the material table of `scene` the row in that of `wish`."""
    before, after = material_table(scene), material_table(wish)
    rows = np.full(len(before), -1, dtype=np.int64)
    for i, (old, new) in enumerate(zip(scene.sources, wish.sources, strict=True)):
        row, to = before.index(scene.snow_of(old)), after.index(wish.snow_of(new))
        if rows[row] not in (-1, to):
            raise SceneError(f"sources.{i}.snow cannot part from that of another source while a run goes on")
        rows[row] = to
    return rows.astype(np.uint16)
