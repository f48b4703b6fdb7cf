"""The structs that kernels are given, field by field as in `core/cuda/grid/views.hpp`.

That both sides agree is checked: by `static_assert` when the kernels are compiled, and against the core.
"""

from __future__ import annotations

import ctypes
import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

MODE_COLUMNS = 72
"""Columns of velocity modes that there is room for."""
BLOCK_NODES = 64
"""Nodes of a block."""

_pointer, _word, _whole = ctypes.c_uint64, ctypes.c_uint32, ctypes.c_int32

VECTORS = {"x": 3, "v": 3, "C": 9, "F_E": 9, "tau": 6}
"""Columns of each field with several."""
NUMBERS = ("J_P", "m", "V0", "stiffness", "strength")
"""Fields of one column."""

EXTREMES = (
    "wave",
    "speed",
    "fastest",
    "rate2",
    "compression",
    "displacement2",
    "less_volume",
    "less_ice_room",
    "node_speed",
    "node_difference",
    "node_change",
    "less_mass",
)
"""What `Results.most` holds, in order."""

RESULTS = np.dtype(
    [("most", np.uint64, len(EXTREMES))]
    + [
        (name, np.uint32)
        for name in ("not_finite", "drifted", "full", "offender", "lost", "homes", "blocks", "waiting")
    ]
)
"""`Results`: what stages have found."""

SUM_PARTS = 4
"""Parts of a sum whose bits depend on no order: whole numbers of units of 2^0, 2^-32, 2^-64, 2^-96."""
SUMS = np.dtype(
    [
        ("number", np.uint64, 8 * SUM_PARTS),
        ("densest", np.uint64),
        ("doubtful", np.uint32),
        ("unused", np.uint32),
    ]
)
"""`Sums`: over all particles."""

HOME = np.dtype([("at", np.int32, 3), ("begin", np.uint32), ("count", np.uint32), ("nodes", np.int32, 8)])
"""`Home`: a block that owns particles."""
COORD_BYTES = 12
"""Size of `BlockCoord`."""
EXCHANGE_NUMBERS, RESPONSE_NUMBERS = 7, 42
"""Numbers of an `Exchange` and of a `BodyResponse`."""
ALL_COLOURS = 8
"""All homes may add to their nodes at once."""


class Particles(ctypes.Structure):
    """Where the columns are."""

    _fields_ = (
        *((name, _pointer * count) for name, count in VECTORS.items()),
        *((name, _pointer) for name in NUMBERS),
        ("modes", _pointer * MODE_COLUMNS),
        ("material", _pointer),
        ("id", _pointer),
    )


class Nodes(ctypes.Structure):
    """Where homes and blocks of nodes are."""

    _fields_ = tuple(
        (name, _pointer)
        for name in (
            "homes",
            "at",
            "node",
            "change",
            "lift",
            "next",
            "next_force",
            "bounds",
            "some",
            "ghosts",
        )
    )


class Table(ctypes.Structure):
    """A hash table of blocks."""

    _fields_ = (
        *((name, _pointer) for name in ("keys", "value", "list", "count")),
        ("capacity", _word),
        ("shift", _word),
    )


class Sorting(ctypes.Structure):
    """What sorting works with."""

    _fields_ = (
        ("homes", Table),
        ("blocks", Table),
        *((name, _pointer) for name in ("home_of", "place", "order", "key", "from_", "to")),
        ("span", _word),
        ("width", _word),
    )


class Bodies(ctypes.Structure):
    """What the snow and the bodies that it moves do to each other."""

    _fields_ = (
        *((name, _pointer) for name in ("waiting", "velocity", "response")),
        ("count", _word),
        ("unused", _word),
    )


class Domain(ctypes.Structure):
    """What this device has of a run on several."""

    _fields_ = (
        *((name, _pointer) for name in ("cuts", "counts", "begins")),
        *((name, _word) for name in ("axis", "number", "domains", "unused")),
    )


COPY, TAKE, ADD = range(3)
"""`Meeting`: what becomes of the nodes that several domains have."""


class Halo(ctypes.Structure):
    """Blocks of nodes that several domains have."""

    _fields_ = (("blocks", _pointer), ("values", _pointer), ("count", _word), ("meeting", _whole))


SHADES = ("", "speed", "J_P", "density", "stress", "material")
"""`Shade`: what a colour may show of the particles."""


class Picture(ctypes.Structure):
    """What a viewer sees."""

    _fields_ = (
        ("words", _pointer),
        ("low", ctypes.c_double * 4),
        ("per_step", ctypes.c_double * 4),
        ("shade", _whole),
        ("unused", _whole),
    )


HALTS = ("none", "finished", "trial", "drifted", "broken", "unusual")
"""Why no further step is taken without the host."""
MOST_STEPS = 64
"""So many steps are taken without the host."""

LIMITS = ("dx", "cfl", "courant", "strain_max", "dt_max", "dt", "max_compression", "solid_speed")
RATES = ("wave", "speed", "fastest", "strain_rate", "compression_rate", "ice_room")
_DOUBLES = ("max_displacement", "min_volume_ratio", "flip_alpha", "flip_damping", "remaining", "dt")
_INTS = ("taken", "halt", "drifted", "broken", "under_way", "bound")


@functools.cache
def control_of(precision: str) -> np.dtype[Any]:
    """Return the struct `Control` of "float32" or "float64"."""
    record = np.dtype([("dt", np.float64), ("bound", np.int32), ("unused", np.int32)])
    return np.dtype(
        [(f"limits_{name}", np.float64) for name in LIMITS]
        + [(name, np.float64) for name in (*RATES, *_DOUBLES)]
        + [("record", record, MOST_STEPS)]
        + [(name, np.int32) for name in _INTS]
        + [("values", precision, 4)]
    )


@functools.cache
def step_of(precision: str) -> type[Any]:
    """Return the struct `Step` of "float32" or "float64"."""
    real = ctypes.c_float if precision == "float32" else ctypes.c_double

    class Step(ctypes.Structure):
        """What every kernel is given."""

        _fields_ = (
            ("particles", Particles),
            ("nodes", Nodes),
            ("sorting", Sorting),
            *((name, _pointer) for name in ("snows", "solids", "exchanged", "results", "sums")),
            ("bodies", Bodies),
            ("domain", Domain),
            ("halo", Halo),
            ("picture", Picture),
            ("control", _pointer),
            ("accepted", _pointer),
            *((f"{name}_count", _word) for name in ("particle", "home", "block", "solid", "snow")),
            ("commit", _whole),
            ("colour", _word),
            ("lightest", real),
            ("constants", real * 10),
        )

    return Step


def bounds_bytes(precision: str) -> int:
    """Return the size of `Bounds`."""
    return 32 if precision == "float32" else 64


def sum_bytes(deterministic: bool) -> int:
    """Return the size of a `Sum`."""
    return 8 * (SUM_PARTS if deterministic else 1)


def summed(raw: NDArray[np.uint64], deterministic: bool) -> NDArray[np.float64]:
    """Return the numbers of n `Sum`s, given as words, (n,)."""
    if not deterministic:
        return raw.view(np.float64)
    whole = [0] * (len(raw) // SUM_PARTS)
    for k in range(SUM_PARTS):
        units = raw[k::SUM_PARTS].view(np.int64).tolist()
        whole = [(a << 32) + unit for a, unit in zip(whole, units, strict=True)]
    scale = 1 << 32 * (SUM_PARTS - 1)
    return np.array([a / scale for a in whole])  # of two whole numbers: rounded once


def decoded(ordered: NDArray[np.uint64]) -> NDArray[np.float64]:
    """Return the numbers behind those that `ordered()` of the kernels made, (n,); 0 where none has come."""
    sign = np.uint64(1 << 63)
    bits = np.where(ordered & sign, ordered ^ sign, ~ordered)
    return np.where(ordered == 0, 0.0, bits.view(np.float64))
