"""The bytes of a state: a head in JSON, then eight bytes for each particle.

    bytes 0-3    length of the head [bytes], little endian, with blanks so that the rest begins at 8 k
    head         JSON in UTF-8: messages.StateHead
    n x 8 bytes  x, y, z and the value, each 16 bit, little endian: position = low + step q

A position is off by at most half a step, 1/131070 of the snow's extent along each axis: 0.04 mm for snow of
5 m. The value runs from 0, the lowest of the legend, to 65535; of names it is the name itself, and of snow
in its own look its liquid share. A particle without finite numbers is put at q = (65535, 65535, 65535) and
is not drawn.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST = 65535
"""Greatest number of 16 bits."""

PARTICLE_BYTES = 8
"""Bytes of a particle: three positions and a value."""


def pack(x: NDArray[np.float32], value: NDArray[np.float32] | None, limits: tuple[float, float]) -> Packed:
    """Quantise positions [m] (n, 3) and values (n,), which run over `limits`."""
    n = len(x)
    out = np.zeros((n, 4), np.uint16)
    low, step = np.zeros(3), np.ones(3)
    lost = ~np.isfinite(x).all(axis=1) if n and not np.isfinite(x.sum()) else None
    for axis in range(3):
        column = np.ascontiguousarray(x[:, axis])
        first, last = _ends(column)
        low[axis], step[axis] = first, max(last - first, 1e-6) / MOST
        column -= np.float32(first)
        column *= np.float32(1.0 / step[axis])
        column += np.float32(0.5)
        if lost is not None:
            np.nan_to_num(column, copy=False, nan=0.0)
        np.clip(column, 0, MOST, out=column)
        out[:, axis] = column
    if lost is not None:
        out[lost, :3] = MOST
    if value is not None:
        scaled = (value - np.float32(limits[0])) * np.float32(MOST / (limits[1] - limits[0]))
        scaled += np.float32(0.5)
        np.nan_to_num(scaled, copy=False, nan=0.0)
        np.clip(scaled, 0, MOST, out=scaled)
        out[:, 3] = scaled
    return Packed(out, low, step)


class Packed:
    """Hold quantised particles: q (n, 4) and what it takes to undo it."""

    def __init__(self, q: NDArray[np.uint16], low: NDArray[Any], step: NDArray[Any]) -> None:
        self.q, self.low, self.step = q, low, step

    def positions(self) -> NDArray[np.float64]:
        """Return the positions [m] that a page sees, (n, 3)."""
        return np.asarray(self.low + self.step * self.q[:, :3])


def framed(head: Mapping[str, Any], body: bytes = b"") -> bytes:
    """Return the bytes of a message."""
    text = json.dumps(finite(head), separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-(len(text) + 4) % 8)
    return b"".join((len(text).to_bytes(4, "little"), text, body))


def unframed(message: bytes) -> tuple[dict[str, Any], bytes]:
    """Return head and body of a message."""
    end = 4 + int.from_bytes(message[:4], "little")
    return json.loads(message[4:end]), message[end:]


def finite(value: Any) -> Any:
    """Replace numbers that JSON has no word for by null."""
    if isinstance(value, float):
        return value if np.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(item) for item in value]
    return value


def _ends(column: NDArray[np.float32]) -> tuple[float, float]:
    """Return the least and the greatest finite number, (0, 0) if there is none."""
    if not len(column):
        return 0.0, 0.0
    first, last = float(column.min()), float(column.max())
    if np.isfinite(first) and np.isfinite(last):
        return first, last
    good = column[np.isfinite(column)]
    return (float(good.min()), float(good.max())) if len(good) else (0.0, 0.0)
