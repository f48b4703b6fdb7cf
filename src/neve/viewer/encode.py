"""Encode a snapshot as a state for the pages."""

from __future__ import annotations

from math import log as log_of

import numpy as np

from neve.viewer.modes import MODES, WETNESS, Colors, Scale
from neve.viewer.players.snapshot import Snapshot
from neve.viewer.protocol.messages import StateHead, vector
from neve.viewer.protocol.state import framed, pack


def encode(snapshot: Snapshot, colors: Colors, scale: Scale, version: int) -> bytes:
    """Return the message that shows `snapshot`, the state number `version`, in `colors`.

    In the mode "snow" the value of a particle is its liquid share, 0 if nothing melts.
    """
    mode = colors.mode
    values = snapshot.values.get(WETNESS if mode == "snow" else mode)
    limits, log = (0.0, 1.0), False
    if values is not None and mode != "snow":
        limits, log = scale.of(colors, values)
    if values is not None and log:
        packed = pack(
            snapshot.x, np.log(np.maximum(values, 0.5 * limits[0])), (log_of(limits[0]), log_of(limits[1]))
        )
    else:
        packed = pack(snapshot.x, values, limits)
    head: StateHead = {
        "kind": "state",
        "version": version,
        "n": len(snapshot.x),
        "low": vector(packed.low),
        "step": vector(packed.step),
        "mode": mode if values is not None or mode == "snow" else "snow",
        "limits": limits,
        "log": log,
        "classes": MODES[mode].names is not None,
        "time": snapshot.time,
        "frame": snapshot.frame,
        "scene": snapshot.scene,
        "poses": [[*map(float, p), *map(float, np.ravel(R))] for p, R in snapshot.poses],
        "facts": snapshot.facts,
    }
    return framed(head, packed.q.astype("<u2", copy=False).tobytes())
