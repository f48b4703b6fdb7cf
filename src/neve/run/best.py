"""Find the moment of a run that a picture shows best: when moving snow has spread most before the camera."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from neve.io.frames import Frame
    from neve.render.shot import Shot, View

COLUMNS, ROWS = 96, 54
"""Cells of the picture that are told apart."""
CANDIDATES = 60
"""Frames that are looked at, at most, evenly over the run."""
SAMPLED = 50_000
"""Particles that are looked at in each, about."""
MOVING = 0.1
"""Speed from which snow moves, as a share of the largest that 5 % of the snow exceeds in any frame."""


def best_frame(numbers: Sequence[int], read: Callable[[int], Frame], shot: Shot) -> int | None:
    """Return the frame with the largest S = |cells(M, t)| - |cells(M, 0)|; None if no S is above 0.

    M is the snow that moves at t, faster than MOVING of the run's own speeds, and cells(M, t) those cells of
    the picture that hold some of it at t, seen by the camera at t: how much more of the picture moving snow
    covers than the same snow did in the first frame. A ball in flight has S = 0 about, one that bursts has
    more, and so has a bow wave; what came to rest does not count.

    numbers: of the frames of the run, in order. shot: of the camera, which has seen none of them
    """
    chosen = {numbers[k] for k in np.linspace(0, len(numbers) - 1, min(CANDIDATES, len(numbers))).astype(int)}
    seen: list[tuple[int, NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]] = []
    start: NDArray[np.float32] | None = None
    every = 1
    for number in numbers:
        if number not in chosen and not shot.follows:
            continue
        content = read(number)
        shot.see(content.time, content.x, content.v, content.id, content.solid_position)
        if number not in chosen or not len(content.x):
            continue
        if start is None:
            every = max(1, len(content.x) // SAMPLED)
            start = content.x[::every]
        x, v = (values[::every][: len(start)] for values in (content.x, content.v))
        view = shot.at(content.time, ahead=False)
        speed = np.sqrt(np.einsum("ij,ij->i", v, v))
        seen.append((number, cells(x, view), cells(start[: len(x)], view), speed))
    if not seen:
        return None
    fast = MOVING * max(float(np.quantile(speed, 0.95)) for *_, speed in seen)
    scores = [_spread(now, speed > fast) - _spread(then, speed > fast) for _, now, then, speed in seen]
    best = int(np.argmax(scores))
    return seen[best][0] if fast > 0 and scores[best] > 0 else None


def cells(x: NDArray[np.floating], view: View) -> NDArray[np.int64]:
    """Return the cell of the picture that each point `x` [m] (n, 3) is seen in, -1 outside of it, (n,)."""
    position, target, up = (np.array(v, dtype=np.float64) for v in (view.position, view.target, view.up))
    ahead = (target - position) / np.linalg.norm(target - position)
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right)
    tall = np.tan(np.radians(view.fov) / 2)
    away = x - position
    depth = away @ ahead
    with np.errstate(divide="ignore", invalid="ignore"):
        across = away @ right / (depth * tall * COLUMNS / ROWS)
        along = away @ np.cross(right, ahead) / (depth * tall)
    inside = (depth > 0) & (np.abs(across) < 1) & (np.abs(along) < 1)
    column, row = (
        np.where(inside, np.floor((v + 1) / 2 * n), 0).astype(np.int64)
        for v, n in ((across, COLUMNS), (along, ROWS))
    )
    return np.where(inside, np.minimum(row, ROWS - 1) * COLUMNS + np.minimum(column, COLUMNS - 1), -1)


def _spread(where: NDArray[np.int64], moving: NDArray[np.bool_]) -> int:
    """Return how many cells of the picture hold moving snow."""
    return len(np.unique(where[moving & (where >= 0)]))
