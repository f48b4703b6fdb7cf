"""Snapshot: the state of a run at one time, frozen, as the pages see it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.io.frames import rows_by_id
from neve.scene.values.curves import keyed
from neve.solver import Quantised
from neve.viewer.modes import measure
from neve.viewer.protocol.messages import Facts

if TYPE_CHECKING:
    from neve.geometry.pose import Pose
    from neve.scene.schema.scene import Scene
    from neve.simulation import Simulation

Array = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Hold the state of a run at one time. It is never written into, so threads share it without a lock.

    Attributes:
        x: positions [m], (n, 3); row p is the same particle in every snapshot of a run
        values: what each colour mode in use shows, (n,), by the name of the mode
        poses: position [m] (3,) and rotation (3, 3) of each solid, in the model's order
        time: simulated time [s]; frame: number of the frame that was reached last
        facts: figures that the page shows
        scene: counts the scenes of this player; a page asks for the new one when it changes
    """

    x: Array
    values: Mapping[str, Array]
    poses: tuple[tuple[NDArray[Any], NDArray[Any]], ...]
    time: float
    frame: int
    facts: Facts = field(default_factory=Facts)
    scene: int = 0


def of_simulation(
    sim: Simulation,
    modes: set[str],
    known: Mapping[str, Array],
    frame: int,
    facts: Facts,
    scene: int,
) -> Snapshot:
    """Copy what the pages need from a running simulation: positions and the colours that someone looks at.

    known: colours that need not be found anew, rows in the order of birth.
    """
    x, values = _from_device(sim, modes) or _from_columns(sim, modes)
    return Snapshot(
        x=x,
        values=values | dict(known),
        poses=tuple((pose.position.copy(), pose.rotation.copy()) for pose in _poses(sim)),
        time=sim.time,
        frame=frame,
        facts=facts,
        scene=scene,
    )


def _from_columns(sim: Simulation, modes: set[str]) -> tuple[Array, dict[str, Array]]:
    """Return positions and the values of colours, rows in the order of birth."""
    columns = sim.columns()
    order = by_birth(np.asarray(columns["id"]()))
    return order(columns["x"]()), {mode: order(measure(mode, columns, 2 * sim.radius)) for mode in modes}


def _from_device(sim: Simulation, modes: set[str]) -> tuple[Array, dict[str, Array]] | None:
    """Return the same, to within half a step of 16 bits, from a device that has it so; else None."""
    values: dict[str, Array] = {}
    x = None
    for mode in sorted(modes) or [""]:
        found = sim.solver.quantised(mode)
        if found is None:
            return None
        order = by_birth(found.id)
        x = order(_positions(found))
        if mode:
            values[mode] = order(found.low[3] + found.step[3] * found.q[:, 3])
    return (x, values) if x is not None else None


def _positions(found: Quantised) -> NDArray[Any]:
    """Return positions [m], (n, 3): not a number where a particle has none."""
    x = found.low[:3] + found.step[:3] * found.q[:, :3]
    lost = np.flatnonzero((found.q[:, :3] == np.iinfo(np.uint16).max).all(axis=1))
    x[lost] = np.nan
    return x


def present(scene: Scene, time: float) -> dict[str, list[float]]:
    """Return the values now, at `time` [s], of what keyframes change: by key, one number or a vector."""
    found: dict[str, list[float]] = {}
    if scene.world.keyframes:
        found["world.gravity"] = keyed(scene.world, "gravity", time).tolist()
    now = scene.snow_at(time)
    for name in dict.fromkeys(name for key in scene.snow_keyframes for name in key.constants()):
        found[f"snow.{name}"] = [float(getattr(now, name))]
    for i, emitter in enumerate(scene.emitters):
        for name in ("velocity", "mass_rate", "volume_rate"):
            if any(getattr(key, name) is not None for key in emitter.keyframes):
                found[f"emitters.{i}.{name}"] = keyed(emitter, name, time).tolist()
    return found


def _poses(sim: Simulation) -> list[Pose]:
    return [pose for _, pose in sim.solids()]


def by_birth(id: NDArray[Any]) -> Callable[[NDArray[Any]], Array]:
    """Return a function that puts rows in the order of `id` and copies them as float32."""
    order = rows_by_id(id)

    def ordered(rows: NDArray[Any]) -> Array:
        out = np.asarray(rows).take(order, axis=0).astype(np.float32, copy=False)
        out.flags.writeable = False
        return out

    return ordered
