"""The interface of whatever moves bodies: what a step with snow needs from it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol, Self

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from neve._core import BodyMotion
    from neve.colliders.solid import Solid
    from neve.geometry.pose import Pose
    from neve.rigid.hand import Hand

Array = NDArray[np.float64]


class LostBody(RuntimeError):
    """Raised when a body has no finite position or velocity; names the body and the time."""


class CoupledBodies(Protocol):
    """Solids that the snow moves: n of them, in one order everywhere.

    Velocities and impulses are those of the origin of the solid's own frame, in world axes: linear part
    first, then the angular one.
    """

    solids: tuple[Solid, ...]
    hand: Hand

    def controls(self) -> list[tuple[str, float, float, float]]:
        """Return name, least and greatest value, and the value now of each motor and actuator."""
        ...

    @property
    def motion(self) -> BodyMotion:
        """Where the solids are, and how they move in the next step."""
        ...

    @property
    def momentum(self) -> Array:
        """Sum of m v over the bodies [kg m/s], (3,)."""
        ...

    @property
    def kinetic(self) -> float:
        """Kinetic energy of the bodies [J]."""
        ...

    @property
    def potential(self) -> float:
        """Energy of the bodies in the field of gravity [J]."""
        ...

    def set_gravity(self, gravity: Array) -> None:
        """Let the bodies fall with `gravity` (3,) [m/s2] from now on."""
        ...

    def poses(self) -> list[Pose]:
        """Return where the solids are now and how they move."""
        ...

    def advance(self, dt: float, exchanged: Array, time: float) -> None:
        """Move on by dt [s] from `time` [s], with what the snow gave in this while, (n, 7).

        exchanged: impulse [N s], its moment about the origin of the frame [N m s], work [J].
        """
        ...

    def save(self) -> dict[str, Array]:
        """Return all that `restore` needs to go on with the same bits."""
        ...

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Put the solids back to where `save` found them."""
        ...

    def take_over(self, other: Self) -> None:
        """Put the solids to where those of `other` are, the same ones, maybe among other colliders."""
        ...
