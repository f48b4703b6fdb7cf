"""Replay: one HTML file that plays a run by itself, in any browser of today, without a network.

Positions are rounded to a grid of a sixth of the particles' distance, at most 65535 steps along each axis.
Of the frames only some are kept, the *keys*: so many that straight lines between them pass every particle
within a tolerance, but for one particle in a hundred. What is written of a key is how far it is from where
the two keys before it would have led at a steady pace, modulo 65536, folded to small numbers (0, -1, 1, -2
become 0, 1, 2, 3), low bytes of all particles first, then high bytes, and deflated. The page undoes it.
"""

from __future__ import annotations

import base64
import json
import posixpath
import re
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neve.build import solids
from neve.io.errors import RunError
from neve.io.frames import Frame, frame_numbers, frame_rate, read_frame
from neve.io.run_folder import RunFolder
from neve.scene.reading.load import load
from neve.viewer.describe import drawn
from neve.viewer.modes import described
from neve.viewer.protocol.messages import ReplayHead, Vector, vector
from neve.viewer.protocol.state import finite

PAGE = Path(__file__).parents[1] / "page"
MAIN = "replay.js"
NAME = "neve:"
"""Before the path of a module in a replay: a name that the import map looks up."""
IMPORT = re.compile(r'^(import\b[^;]*?from )"(\.{1,2}/[^"]+)";', re.MULTILINE)
MOST = 120_000
"""Particles in a frame of a replay; of more, every k-th is taken and drawn larger."""
BORN = 4
"""Places for particles in a replay, over MOST: more may come and go in a run than a frame has."""
TURNOVER = 0.01
"""Share of the particles that may come or go between two keys, with the least tolerance."""
FINENESS = 6
"""Steps of the grid in a particle's distance."""
TOLERANCE = 0.35 * FINENESS
"""Steps of the grid by which lines between keys may pass a particle, at first."""
LIMIT = 18_000_000
"""Bytes of a replay that are aimed at: a file that can be sent by mail."""
HIDDEN = 65535
"""Position, three times, of a particle that is not born yet, or gone."""

Places = NDArray[np.uint16]


def replay_of(folder: str) -> bytes:
    """Return the replay of the run in `folder`. Errors: RunError if it holds no frames."""
    run = RunFolder(folder)
    if not frame_numbers(run.frames):
        raise RunError(f"{folder} holds no frames to play: run it first, neve run.")
    return replay_page(run)


def replay_page(run: RunFolder, progress: Callable[[int, int], None] = lambda done, of: None) -> bytes:
    """Return the page that plays the frames of `run`. Errors: RunError, SceneError."""
    scene = load(run.path)
    numbers = frame_numbers(run.frames)
    frames = [_thin(read_frame(run.frames, number)) for number in numbers]
    born = 1 + max(int(frame.id.max(initial=0)) for frame in frames)
    skip = max(1, -(-max(len(frame.x) for frame in frames) // MOST), -(-born // (BORN * MOST)))
    kept = -(-born // skip)
    spacing = scene.numerics.spacing * skip ** (1.0 / 3.0)
    low, step = grid_of(frames, spacing)
    places = np.full((len(frames), 3, kept), HIDDEN, np.uint16)
    for k, frame in enumerate(frames):
        some = frame.id % skip == 0
        places[k][:, frame.id[some] // skip] = _rounded(frame.x[some], low, step)
        progress(k, 2 * len(frames))
    keys, packed = _small_enough(places, lambda done: progress(len(frames) + done, 2 * len(frames)))
    modes = described(["snow", "speed"], scene)
    head: ReplayHead = {
        **drawn(run.path.resolve().name, scene, solids(scene), modes, scene.numerics.spacing / 2),
        "fps": float(frame_rate(numbers, scene.run.fps)),
        "spacing": spacing,
        "n": kept, "low": low, "step": (step, step, step), "keys": keys, "frames": len(frames),
        "times": [round(float(frame.time), 6) for frame in frames],
        "poses": [_poses(frame) for frame in frames],
    }  # fmt: skip
    return assemble(head, packed)


def grid_of(frames: list[Frame], spacing: float) -> tuple[Vector, float]:
    """Return corner and step [m] of the grid: a share of `spacing`, coarser if the snow flies far."""
    good = [frame.x[np.isfinite(frame.x).all(axis=1)] for frame in frames]
    if not any(len(x) for x in good):
        return (0.0, 0.0, 0.0), spacing / FINENESS
    low = np.min([x.min(axis=0) for x in good if len(x)], axis=0)
    high = np.max([x.max(axis=0) for x in good if len(x)], axis=0)
    step = max(spacing / FINENESS, float((high - low).max()) / (HIDDEN - 2))
    return vector(low), step


def choose_keys(places: Places, tolerance: float) -> list[int]:
    """Return the frames to keep, the first and the last among them.

    From each key the next is as far as it can be while straight lines pass all frames between within
    `tolerance` steps, but for one particle in a hundred (of a sample).
    """
    some = places[:, :, :: max(1, places.shape[2] // 4000)].astype(np.float32)
    last = len(places) - 1
    keys = [0]
    while keys[-1] < last:
        here, far = keys[-1], 1
        while here + 2 * far <= last and far < 64 and _fits(some, here, here + 2 * far, tolerance):
            far *= 2
        below, above = far, min(2 * far, last - here)  # below fits (or is the next frame)
        while above - below > 1:
            middle = (above + below) // 2
            if _fits(some, here, here + middle, tolerance):
                below = middle
            else:
                above = middle
        if above <= last - here and above > below and _fits(some, here, here + above, tolerance):
            below = above
        keys.append(here + below)
    return keys


def _fits(some: NDArray[np.float32], a: int, b: int, tolerance: float) -> bool:
    share = (np.arange(a + 1, b) - a)[:, None, None] / np.float32(b - a)
    if not len(share):
        return True
    hidden = (some == HIDDEN).all(axis=1)  # (frames, particles)
    stays = ~hidden[a : b + 1].any(axis=0)
    moves = ~hidden[a : b + 1].all(axis=0) & ~stays
    if moves.sum() > TURNOVER * tolerance / TOLERANCE * max(1, (~hidden[b]).sum()):
        return False
    if not stays.any():
        return True
    off = np.abs(some[a] + share * (some[b] - some[a]) - some[a + 1 : b]).max(axis=1)
    return bool(np.quantile(off[:, stays], 0.99) <= tolerance)


def pack(places: Places, keys: list[int]) -> bytes:
    """Deflate the keys: see the top of this file."""
    deflate = zlib.compressobj(6, zlib.DEFLATED, -15, 9)
    out = []
    for k in range(len(keys)):
        away = places[keys[k]] - predicted(places, keys, k)
        folded = fold(away.view(np.int16))
        out.append(deflate.compress((folded & 255).astype(np.uint8).tobytes()))
        out.append(deflate.compress((folded >> 8).astype(np.uint8).tobytes()))
    out.append(deflate.flush())
    return b"".join(out)


def predicted(places: Places, keys: list[int], k: int) -> Places:
    """Return where key k would be after the two before it, modulo 65536."""
    if k == 0:
        return np.zeros_like(places[0])
    before: Places = places[keys[k - 1]]
    if k == 1:
        return before
    way = (before - places[keys[k - 2]]).view(np.int16).astype(np.int32)
    now, then = keys[k] - keys[k - 1], keys[k - 1] - keys[k - 2]
    # Whole numbers alone, so that the page finds the same.
    ahead: Places = (before.astype(np.int32) + (2 * way * now + then) // (2 * then)).astype(np.uint16)
    return ahead


def fold(away: NDArray[np.int16]) -> NDArray[np.uint16]:
    """Turn 0, -1, 1, -2, ... into 0, 1, 2, 3, ..."""
    wide = away.astype(np.int32)
    return np.asarray(((wide << 1) ^ (wide >> 31)).astype(np.uint16))


def assemble(head: ReplayHead, packed: bytes) -> bytes:
    """Put page, modules, head and data into one file.

    A module of a page that lies on a disk may not be loaded from another file, so each comes as a data: URL,
    and an import map says which name is which.
    """
    text = json.dumps(finite(head), separators=(",", ":")).replace("<", "\\u003c")
    page = (PAGE / "replay.html").read_text(encoding="utf-8")
    parts = {
        "/*STYLE*/": (PAGE / "style.css").read_text(encoding="utf-8"),
        "/*MODULES*/": json.dumps({"imports": modules(MAIN)}),
        "/*MAIN*/": NAME + MAIN,
        "/*HEAD*/": text,
    }
    for mark, content in parts.items():
        page = page.replace(mark, content)
    before, after = page.split("/*DATA*/")
    return before.encode() + base64.b64encode(packed) + after.encode()


def modules(main: str) -> dict[str, str]:
    """Return the module `main` of the page and all that it imports: its name in a replay -> a data: URL."""
    found: dict[str, str] = {}
    waiting = [main]
    while waiting:
        path = waiting.pop()
        if NAME + path in found:
            continue

        def renamed(match: re.Match[str], folder: str = posixpath.dirname(path)) -> str:
            waiting.append(posixpath.normpath(posixpath.join(folder, match[2])))
            return f'{match[1]}"{NAME}{waiting[-1]}";'

        code = IMPORT.sub(renamed, (PAGE / path).read_text(encoding="utf-8"))
        found[NAME + path] = f"data:text/javascript;base64,{base64.b64encode(code.encode()).decode()}"
    return found


def _small_enough(places: Places, progress: Callable[[int], None]) -> tuple[list[int], bytes]:
    """Choose keys with a tolerance that grows until the data are small enough."""
    tolerance = TOLERANCE
    for attempt in range(6):
        keys = choose_keys(places, tolerance)
        packed = pack(places, keys)
        progress(len(places) * (attempt + 1) // 6)
        if len(packed) * 4 / 3 <= LIMIT:
            break
        tolerance *= 1.8
    return keys, packed


def _thin(frame: Frame) -> Frame:
    """Drop what a replay does not show, to hold more frames in memory."""
    none = np.zeros(0, np.float32)
    return frame._replace(v=none, J_P=none, material=none, more={})


def _rounded(x: NDArray[np.float32], low: Vector, step: float) -> Places:
    q = np.rint((x.T - np.array(low, np.float32)[:, None]) / np.float32(step))
    lost = ~np.isfinite(q).all(axis=0)
    q[:, lost] = HIDDEN
    rounded: Places = np.clip(q, 0, HIDDEN).astype(np.uint16)
    return rounded


def _poses(frame: Frame) -> list[list[float]]:
    return [
        [round(float(a), 5) for a in (*p, *np.ravel(r))]
        for p, r in zip(frame.solid_position, frame.solid_rotation, strict=True)
    ]
