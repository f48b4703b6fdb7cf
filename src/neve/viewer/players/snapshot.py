"""Snapshot: the state of a run at one time, frozen, as the pages see it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.viewer.modes import Columns, measure
from neve.viewer.protocol.messages import Facts

if TYPE_CHECKING:
    from neve.geometry.pose import Pose
    from neve.simulation import Simulation

Array = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Hold the state of a run at one time. It is never written into, so threads share it without a lock.

    Attributes:
        x: positions [m], (n, 3); row p is the same particle in every snapshot of a run
        values: what each colour mode in use shows, (n,), by the name of the mode
        bodies: position [m] (3,) and rotation (3, 3) of each solid, in the model's order
        time: simulated time [s]; frame: number of the frame that was reached last
        facts: figures that the page shows
        scene: counts the scenes of this player; a page asks for the new one when it changes
    """

    x: Array
    values: Mapping[str, Array]
    bodies: tuple[tuple[NDArray[Any], NDArray[Any]], ...]
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
    state = sim.state
    order = by_birth(np.asarray(state.id))
    columns: Columns = {
        "x": lambda: state.x,
        "v": lambda: state.v,
        "J_P": lambda: state.J_P,
        "F_E": lambda: state.F_E,
        "tau": lambda: state.tau,
        "material": lambda: state.material,
        "density": lambda: state.m / (state.V0 * np.maximum(_volume_ratio(state), 1e-3)),
    }
    spacing = sim.scene.numerics.spacing
    values = {mode: order(measure(mode, columns, spacing)) for mode in modes} | dict(known)
    return Snapshot(
        x=order(state.x),
        values=values,
        bodies=tuple((pose.position.copy(), pose.rotation.copy()) for pose in _poses(sim)),
        time=sim.time,
        frame=frame,
        facts=facts,
        scene=scene,
    )


def _poses(sim: Simulation) -> list[Pose]:
    return [pose for _, pose in sim.solids()]


def _volume_ratio(state: Any) -> NDArray[Any]:
    """Return det(F_E) J_P: the volume of each particle over its volume at rest [1]."""
    F = state.F_E
    det = (
        F[:, 0, 0] * (F[:, 1, 1] * F[:, 2, 2] - F[:, 1, 2] * F[:, 2, 1])
        - F[:, 0, 1] * (F[:, 1, 0] * F[:, 2, 2] - F[:, 1, 2] * F[:, 2, 0])
        + F[:, 0, 2] * (F[:, 1, 0] * F[:, 2, 1] - F[:, 1, 1] * F[:, 2, 0])
    )
    return np.asarray(det * state.J_P)


def by_birth(id: NDArray[Any]) -> Callable[[NDArray[Any]], Array]:
    """Return a function that puts rows in the order of `id` and copies them as float32.

    ids without gaps, as any run has them, need no sort.
    """
    n = len(id)
    dense = n > 0 and int(id.max()) == n - 1
    order = None if dense else np.argsort(id, kind="stable")

    def ordered(rows: NDArray[Any]) -> Array:
        rows = np.asarray(rows)
        if order is not None:
            out = rows[order].astype(np.float32)
        else:
            out = np.empty(rows.shape, np.float32)
            out[id] = rows
        out.flags.writeable = False
        return out

    return ordered
