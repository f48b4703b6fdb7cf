"""How snow has turned and stretched since the first frame: the grains of a particle are carried along."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve import _core, _surface
from neve.surface.volume import points

Floats = NDArray[np.float32]

NEIGHBOURS = 12
"""Particles of the first frame around one that tell how its snow has moved."""


@dataclass(frozen=True)
class Carry:
    """Hold how the snow of each particle has moved, one matrix (1, 3, 3) for all or (n, 3, 3).

    turn: rotation R of F = R S. offset: R S, its stretches kept between 0.65 and 1.5, so that the grains of
    torn snow are no needles and those of crushed snow no plates; it moves the place of a grain beside its
    particle
    """

    turn: Floats
    offset: Floats


STILL = Carry(np.eye(3, dtype=np.float32)[None], np.eye(3, dtype=np.float32)[None])
"""Snow that has neither turned nor stretched."""


def carried(F: NDArray[Any]) -> Carry:
    """Return how snow of the deformation gradients F (n, 3, 3) carries its grains; 0.65 to 1.5 in stretch."""
    return Carry(*_surface.carried(np.ascontiguousarray(F, np.float32)))


class Origin:
    """Remember where particles were in the first frame, and which were their neighbours."""

    def __init__(self, id: NDArray[Any], x: NDArray[Any]) -> None:
        """Find the neighbours. id (n,); x (n, 3) [m]: positions in the first frame."""
        from scipy.spatial import cKDTree

        order = np.argsort(id)
        self._names, self._x = np.asarray(id)[order], points(x)[order]
        count = min(NEIGHBOURS + 1, len(order))
        if count < 2:
            self._near = np.zeros((len(order), 0), np.int32)
            return
        _, near = cKDTree(self._x).query(self._x, k=count, workers=_core.threads())
        self._near = np.ascontiguousarray(near[:, 1:], np.int32)

    def gradients(self, id: NDArray[Any], x: NDArray[Any]) -> Floats:
        """Return the deformation gradients F (m, 3, 3) since the first frame of particles at x (m, 3) [m].

        F is the least-squares fit to its neighbours there, min sum_j w_j |x_j - x_p - F (X_j - X_p)|^2: the
        one where snow deforms alike around a particle, rotation, elastic and plastic deformation together.
        w_j falls from 1 to 0 as a neighbour parts to 1.75 to 3 times its first distance. F is 1 for a
        particle that has lost all neighbours, or came later.

        Source: the moment matrix of meshless methods (e.g. Mueller et al. 2004).
        """
        out = np.tile(np.eye(3, dtype=np.float32), (len(id), 1, 1))
        if not len(self._names) or not self._near.shape[1]:
            return out
        row = np.searchsorted(self._names, id).clip(max=len(self._names) - 1)
        known = self._names[row] == id
        now = np.full((len(self._names), 3), np.nan, np.float32)
        now[row[known]] = points(x)[known]
        out[known] = _surface.gradients(self._x, now, self._near)[row[known]]
        return out
