"""A recording of a wheel in the snow of a run, small enough for a page: `drive.json` of the run folder."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.drive.columns import columns_of, floor_of, patch_about
from neve.drive.fit import Fit
from neve.drive.packing import STEP, packed, steps
from neve.drive.track import Passage, Track
from neve.io.atomic import write_text

Array = NDArray[np.float64]

FILE = "drive.json"
FORMAT = 1
MOST_LOOSE = 4000
"""Particles that lie or fly above the connected snow in a frame, at most; of more every k-th is kept."""


def write_recording(passage: Passage, track: Track, fit: Fit) -> Path:
    """Write the recording of a run with the fitted snow into its folder, and return the file.

    Errors: RunError.
    """
    content = recording_of(passage, track, fit)
    path = passage.folder / FILE
    write_text(path, json.dumps(content, separators=(",", ":"), allow_nan=False) + "\n")
    return path


def recording_of(passage: Passage, track: Track, fit: Fit) -> dict[str, Any]:
    """Return what the file holds; places are along the track, to its right, and up from the least ground [m].

    `depth`, `mass` (frames, nx, ny): depth and mass of the snow of each cell [STEP m], each frame as the
    difference to the one before; `ground` (nx, ny) [STEP m]; `loose`: particles above the snow, along, across
    and up [STEP m], `counts` of each frame. Numbers have 16 bits, the lesser byte first, deflated, in base64.
    """
    first = passage.moment(passage.numbers[0])
    patch = patch_about(first.x, passage.scene.numerics.dx)
    floor = floor_of(first.x, patch, passage.spacing)
    base = float(np.nanmin(floor))
    depths, masses, loose, times, path = [], [], [], [], []
    corner = np.array([patch.along, patch.across, base])
    turns = []
    for number in passage.numbers:
        now = passage.moment(number)
        snow = columns_of(now.x, patch, floor, passage.spacing)
        depths.append(steps(np.nan_to_num(snow.top - floor)))
        masses.append(steps(snow.mass))
        loose.append(steps(_thinned(now.x[snow.loose]) - corner))
        times.append(now.time)
        turns.append(now.spin)
        path.append((now.axle - [0.0, 0.0, base]).tolist())
    return {
        "format": FORMAT,
        "name": passage.folder.resolve().name,
        "snow": {
            "strain": fit.snow.strain, "pressure": fit.snow.pressure, "compaction": fit.snow.compaction,
            "density": track.density, "depth": float(track.depth.mean()),
        },
        "residual": fit.residual,
        "points": np.column_stack([track.load, track.sinkage, fit.predicted[0]]).round(6).tolist(),
        "wheel": {
            "radius": track.wheel.radius, "width": track.wheel.width, "load": float(track.load.mean()),
        },
        "times": times,
        "path": np.array(path).round(5).tolist(),
        "spin": np.unwrap(np.array(turns)).round(5).tolist(),
        "patch": {
            "nx": patch.nx, "ny": patch.ny, "cell": patch.cell, "along": patch.along, "across": patch.across,
        },
        "step": STEP,
        "ground": packed(steps(np.nan_to_num(floor - base))),
        "depth": packed(_differences(depths)),
        "mass": packed(_differences(masses)),
        "force": [_known(passage.force(number)) for number in passage.numbers],
        "counts": [len(places) for places in loose],
        "loose": packed(np.concatenate(loose)),
    }  # fmt: skip


def _known(force: float) -> float | None:
    return None if np.isnan(force) else round(force, 1)


def _thinned(x: Array) -> Array:
    return x[:: max(1, -(-len(x) // MOST_LOOSE))]


def _differences(frames: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    """Return the first frame, and of each other one what it has more than the one before."""
    return np.stack([frames[0], *(b - a for a, b in pairwise(frames))])
