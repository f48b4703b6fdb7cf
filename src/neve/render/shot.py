"""The view of a scene's camera at any time: keyframes, turntable, and what it follows."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.pose import rotation_matrix
from neve.scene.errors import SceneError
from neve.scene.schema.camera import SNOW
from neve.scene.values.curves import keyed

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.scene.schema.camera import Camera

Array = NDArray[np.float64]
Triple = tuple[float, float, float]

REACH = 4.0
"""Way that a particle has moved, in grid spacings, from which it counts as snow that moves."""
LEAD = 0.2
"""Time [s] for which a particle's speed counts as way."""
REST = 1e-3
"""What snow counts that has never moved."""
FARTHEST = 1.5
"""Distance from the middle, in medians, beyond which snow counts less."""
MOST = 50_000
"""Particles that are looked at."""


@dataclass(frozen=True)
class View:
    """Hold what a camera sees at one moment: position and target [m], up, vertical angle fov [degrees]."""

    position: Triple
    target: Triple
    up: Triple
    fov: float


class Shot:
    """Answer where a scene's camera is at any time.

    A camera that follows something is shown the frames first (`see`), the first frame of the run before all
    others. The middle of the picture is then c(t) + offset, where c is the locally weighted straight line
    (Cleveland 1979) through the places c_k at the times t_k of the frames: the least sum of

        w_k |c_k - a - b (t_k - t)|^2,  w_k = (1 - ((t_k - t) / follow_time)^2)^2 where that is positive,

    and c(t) = a. It is exact for what moves evenly, and does not lag behind. Between frames c is straight.
    """

    def __init__(self, camera: Camera, solids: Sequence[Solid] = (), dx: float = 0.05) -> None:
        """Prepare. solids: in the order of their places in a frame; dx: of the snow's grid [m].

        Errors: SceneError if the camera follows a solid that is not there.
        """
        self.camera = camera
        self._dx = dx
        self._solid: int | None = None
        if camera.follow not in (None, SNOW):
            names = [solid.name for solid in solids]
            if camera.follow not in names:
                raise SceneError(
                    f'camera.follow = "{camera.follow}" is not there: use {", ".join([SNOW, *names])}'
                )
            self._solid = names.index(camera.follow)
        self._names, self._first = np.zeros(0, np.int64), np.zeros((0, 3))
        self._times: list[float] = []
        self._places: list[Array] = []

    @property
    def follows(self) -> bool:
        """Whether it must see the frames."""
        return self.camera.follow is not None

    def see(
        self,
        t: float,
        x: NDArray[Any],
        v: NDArray[Any],
        id: NDArray[Any],
        solids: Sequence[Any] | NDArray[Any],
    ) -> None:
        """Note where that which is followed is at time `t` [s]; nothing if the frame is known already.

        x (n, 3) [m], v (n, 3) [m/s], id (n,): particles of a frame; solids: places of the solids (s, 3) [m]
        """
        at = bisect_right(self._times, t)
        if not self.follows or (at and self._times[at - 1] == t):
            return
        if self._solid is not None:
            if self._solid >= len(solids):  # a frame of another scene
                return
            place = np.array(solids[self._solid], np.float64)
        elif len(x):
            place = self._middle(x, v, id)
        else:
            place = self._places[-1] if self._places else np.array(self.camera.target)
        self._times.insert(at, t)
        self._places.insert(at, place)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return what has been seen as arrays, for `recall`."""
        places = np.array(self._places).reshape(-1, 3)
        return {"names": self._names, "first": self._first, "times": np.array(self._times), "places": places}

    def recall(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Have seen what `state` holds."""
        self._names, self._first = state["names"], state["first"]
        self._times, self._places = state["times"].tolist(), [*state["places"]]

    def at(self, t: float, ahead: bool = True) -> View:
        """Return the view at time `t` [s]; ahead: whether frames after `t` count, too."""
        camera = self.camera
        position, target, up, fov = (self._keyed(name, t) for name in ("position", "target", "up", "fov"))
        if self._times:
            target = self._followed(t, ahead) + camera.offset
            if camera.dolly:
                way = target - (self._followed(self._times[0], ahead) + camera.offset)
                position = position + way - (way @ up) / (up @ up) * up  # as high as before, over any ground
        if camera.turntable:
            axis = up / np.linalg.norm(up)
            turn = rotation_matrix(math.radians(camera.turntable * max(t, 0.0)) * axis)
            position = target + turn @ (position - target)
        view = target - position
        if np.linalg.norm(view) < 1e-6:  # the camera stands in what it follows: it looks on as before
            view = np.array([0.0, 1e-6, 0.0])
            target = position + view
        if np.linalg.norm(np.cross(view, up)) <= 1e-6 * np.linalg.norm(view) * np.linalg.norm(up):
            up = np.eye(3)[int(np.argmin(np.abs(view)))]
        return View(_triple(position), _triple(target), _triple(up), float(fov[0]))

    def _keyed(self, name: str, t: float) -> Array:
        """Return a property of the camera at time `t`, as its keyframes have it."""
        return keyed(self.camera, name, t)

    def _followed(self, t: float, ahead: bool) -> Array:
        """Return the smooth place of what is followed; between two frames on a straight line."""
        k = bisect_right(self._times, t) - 1
        if k < 0:
            return self._smooth(0, ahead)
        if not ahead or k == len(self._times) - 1 or self._times[k] == t:
            return self._smooth(k, ahead)
        share = (t - self._times[k]) / (self._times[k + 1] - self._times[k])
        return (1.0 - share) * self._smooth(k, ahead) + share * self._smooth(k + 1, ahead)

    def _smooth(self, k: int, ahead: bool) -> Array:
        width = self.camera.follow_time
        first = bisect_right(self._times, self._times[k] - width)
        last = bisect_right(self._times, self._times[k] + width) if ahead else k + 1
        if width == 0.0 or last - min(first, k) < 2:
            return self._places[k]
        d = np.array(self._times[first:last]) - self._times[k]
        w = np.maximum(1.0 - (d / width) ** 2, 0.0) ** 2
        c = np.array(self._places[first:last])
        w /= w.sum()
        mean_d, mean_c = (w * d).sum(), (w[:, None] * c).sum(axis=0)
        spread = (w * (d - mean_d) ** 2).sum()
        if spread <= 1e-12 * width**2:
            return np.asarray(mean_c)
        slope = (w[:, None] * (d - mean_d)[:, None] * (c - mean_c)).sum(axis=0) / spread
        return np.asarray(mean_c - mean_d * slope)

    def _middle(self, x: NDArray[Any], v: NDArray[Any], id: NDArray[Any]) -> Array:
        """Return the middle of the snow that moves or has moved.

        A particle counts q^4 / (q^4 + (REACH dx)^4) + REST with q = |x - x_first| + LEAD |v|, and the middle
        is Huber's estimate: the mean, in which what lies farther from it than FARTHEST medians counts by the
        inverse of its distance.
        """
        chosen = np.flatnonzero(np.asarray(id) % max(1, -(-len(x) // MOST)) == 0)
        chosen = chosen if len(chosen) else np.arange(len(x))
        places, names = np.asarray(x[chosen], np.float64), np.asarray(id[chosen]).astype(np.int64)
        if not self._times:
            order = np.argsort(names)
            self._names, self._first = names[order], places[order]
        q = LEAD * np.linalg.norm(np.asarray(v[chosen], np.float64), axis=1)
        if len(self._names):
            row = np.searchsorted(self._names, names).clip(max=len(self._names) - 1)
            moved = np.linalg.norm(places - self._first[row], axis=1)
            q += np.where(self._names[row] == names, moved, 0.0)
        q = np.minimum(q / (REACH * self._dx), 1e6) ** 4
        return robust_mean(places, q / (q + 1.0) + REST)


def opening(camera: Camera) -> View:
    """Return the view of a camera at the start, as far as the scene alone tells it: nothing is followed."""
    return Shot(camera.model_copy(update={"follow": None, "dolly": False})).at(0.0)


def robust_mean(x: Array, w: Array) -> Array:
    """Return Huber's estimate of the middle of places (n, 3) with weights (n,), by reweighting 8 times."""
    middle = (w[:, None] * x).sum(axis=0) / w.sum()
    for _ in range(8):
        distance = np.linalg.norm(x - middle, axis=1)
        order = np.argsort(distance)
        total = np.cumsum(w[order])
        most = FARTHEST * distance[order[np.searchsorted(total, 0.5 * total[-1])]]
        if not most > 0.0:
            break
        share = w * np.minimum(1.0, most / np.maximum(distance, 1e-300))
        middle = (share[:, None] * x).sum(axis=0) / share.sum()
    return np.asarray(middle)


def _triple(a: Array) -> Triple:
    x, y, z = (float(c) for c in a)
    return x, y, z
