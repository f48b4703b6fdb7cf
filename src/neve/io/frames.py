"""The frames of a run: `frames/NNNNNN.npz`, one file for each moment shown in the film."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.io.atomic import replacing
from neve.io.compact.frame import packed, unpacked
from neve.io.compact.places import DEFLATED
from neve.io.errors import RunError, cannot_read
from neve.io.npz import read_npz, write_npz

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene

_NAME = re.compile(r"(\d{6,})\.npz")


_OPTIONAL = ("J_P", "material")
"""Arrays that a frame has only if the solver has these columns."""


HEAT = ("temperature", "phase")
"""Fields that a frame has unasked where the solver has these columns."""


class Frame(NamedTuple):
    """What a frame file holds; particles in the order of their id, a row is the same one in every frame."""

    x: NDArray[np.float32]  # positions [m], (n, 3)
    v: NDArray[np.float32]  # velocities [m/s], (n, 3)
    J_P: NDArray[np.float32] | None  # plastic volume ratio [1], (n,); None: the solver has none
    id: NDArray[Any]  # name of the particle for the whole run, (n,)
    material: NDArray[Any] | None  # index of the particle's snow source's material, (n,); None as well
    solid_position: NDArray[np.float32]  # position of each collider and body [m], (s, 3)
    solid_rotation: NDArray[np.float32]  # rotation matrix of each collider and body, (s, 3, 3)
    time: float  # [s]
    more: Mapping[str, NDArray[Any]] = MappingProxyType(
        {}
    )  # what `run.fields` names, a row for each particle


@dataclass(frozen=True)
class Life:
    """Hold what particles keep for life: `id` (n,) and other columns (n,), by name."""

    id: NDArray[Any]
    columns: Mapping[str, NDArray[Any]]

    def of(self, name: str, id: NDArray[Any]) -> NDArray[Any]:
        """Return the column `name` of the particles `id`. Errors: RunError."""
        order = np.argsort(self.id)
        place = np.searchsorted(self.id, id, sorter=order).clip(max=len(order) - 1)
        mine = order[place] if len(order) else order
        if not np.array_equal(self.id[mine], id):
            raise RunError("a frame and the checkpoint have other particles: they are of different runs.")
        return np.asarray(self.columns[name][mine])


def frame_path(folder: Path, frame: int) -> Path:
    """Return the path of frame number `frame` in the folder `frames` of a run."""
    return folder / f"{frame:06d}.npz"


def frame_numbers(folder: Path) -> list[int]:
    """Return the numbers of the frames that lie in `folder`, in order."""
    if not folder.is_dir():
        return []
    return sorted(int(match[1]) for path in folder.iterdir() if (match := _NAME.fullmatch(path.name)))


def chosen_frames(folder: Path, frames: slice | None, purpose: str) -> list[int]:
    """Return the numbers of the frames in `folder` that a slice of numbers takes; None takes all.

    purpose: what they are for, as in "nothing to export"

    Errors: RunError if there are none.
    """
    have = frame_numbers(folder)
    if not have:
        raise RunError(f"{folder} holds no frames, so there is nothing to {purpose}.")
    if frames is None:
        return have
    wanted = range(*frames.indices(have[-1] + 1))
    chosen = [number for number in have if number in wanted]
    if not chosen:
        raise RunError(f"{folder} holds the frames {have[0]} to {have[-1]}, and none of those asked for.")
    return chosen


def frame_rate(numbers: Sequence[int], fps: int) -> Fraction:
    """Return how many of the frames `numbers` a simulated second has on average, of `fps` in all [1/s]."""
    if len(numbers) < 2:
        return Fraction(fps)
    return Fraction(fps * (len(numbers) - 1), numbers[-1] - numbers[0])


def make_frame(
    x: NDArray[Any],
    v: NDArray[Any],
    J_P: NDArray[Any] | None,
    id: NDArray[Any],
    material: NDArray[Any] | None,
    solids: Iterable[tuple[NDArray[Any], NDArray[Any]]],
    time: float,
    more: Mapping[str, NDArray[Any]] = MappingProxyType({}),
) -> Frame:
    """Copy a moment as a frame: particles sorted by id, float32; `solids` are (position, rotation).

    more: further fields of the particles, by name, (n, ...)
    """
    order = rows_by_id(id)
    poses = list(solids)
    return Frame(
        x=x.take(order, axis=0).astype(np.float32, copy=False),
        v=v.take(order, axis=0).astype(np.float32, copy=False),
        J_P=None if J_P is None else J_P.take(order, axis=0).astype(np.float32, copy=False),
        id=id[order],
        material=None if material is None else material[order],
        solid_position=np.array([position for position, _ in poses], np.float32).reshape(-1, 3),
        solid_rotation=np.array([rotation for _, rotation in poses], np.float32).reshape(-1, 3, 3),
        time=time,
        more={name: _short(values).take(order, axis=0) for name, values in more.items()},
    )


def rows_by_id(id: NDArray[Any]) -> NDArray[Any]:
    """Return the rows in the order of their `id`, (n,), which are whole numbers from 0 on, no two alike.

    Where they leave few gaps, as in any run, they need no sort.
    """
    top = int(id.max(initial=0)) + 1
    if top > 2 * len(id):
        return np.argsort(id)
    row = np.full(top, len(id), np.intp)
    row[id] = np.arange(len(id))
    return row if top == len(id) else row[row < len(id)]


def _short(values: NDArray[Any]) -> NDArray[Any]:
    """Return numbers as float32, whole numbers as they are."""
    return values.astype(np.float32, copy=False) if values.dtype.kind == "f" else values


FOR_LIFE = ("m", "V0")
"""Fields that a particle keeps for life, which stand in the checkpoint."""
EXACT = (*FOR_LIFE, "solid_position", "solid_rotation", "time")
"""Arrays that a compact frame has as a plain one."""
BLOCK_CELLS = 4
"""Cells along the edge of a block."""


def fields_of(scene: Scene, columns: Iterable[str]) -> tuple[str, ...]:
    """Return the further fields of a frame.

    These are those of `run.fields`, the source where there are several, emitters among them, and where there
    are sinks what a particle keeps for life: no checkpoint has it of a particle that is gone; and heat.
    """
    known = {*columns}
    unasked = ["source"] if len(scene.bearers) > 1 else []
    unasked += [*(FOR_LIFE if scene.sinks else ()), *HEAT]
    return tuple(dict.fromkeys([*scene.run.fields, *(name for name in unasked if name in known)]))


def frame_of(
    columns: Mapping[str, Callable[[], Any]],
    solids: Iterable[tuple[NDArray[Any], NDArray[Any]]],
    time: float,
    fields: Iterable[str] = (),
) -> Frame:
    """Copy a moment of any solver as a frame, from what it lets draw (see `neve.solver.Solver.columns`).

    It has J_P and material only where the solver has them. fields: further columns
    """
    x, id = np.asarray(columns["x"]()), np.asarray(columns["id"]())
    J_P, material = (columns[name]() if name in columns else None for name in _OPTIONAL)
    more = {name: np.asarray(columns[name]()) for name in fields if name not in Frame._fields}
    return make_frame(x, columns["v"](), J_P, id, material, solids, time, more)


def arrays_of(content: Frame) -> dict[str, Any]:
    """Return the arrays of a frame as its file holds them, by name."""
    own = {name: a for name, a in content._asdict().items() if a is not None and name != "more"}
    return {**own, **content.more}


def block_edge(scene: Scene) -> float | None:
    """Return the edge [m] of the blocks of a scene's compact frames; None: its frames are plain."""
    return BLOCK_CELLS * scene.numerics.dx if scene.run.frames == "compact" else None


def stored(content: Frame, edge: float | None) -> dict[str, NDArray[Any]]:
    """Return the arrays of a frame as its file holds them: compact, with blocks of `edge` [m], or plain.

    A frame that is not finite, or too far away, is plain in any case.
    """
    plain = {name: np.asarray(values) for name, values in arrays_of(content).items()}
    return (packed(plain, edge, EXACT) if edge is not None else None) or plain


def frame_of_stored(arrays: Mapping[str, NDArray[Any]]) -> Frame:
    """Return the frame whose file holds these arrays. Errors: ValueError, KeyError, TypeError for others."""
    return _frame(unpacked(arrays))


def write_frame(folder: Path, frame: int, content: Frame, edge: float | None = None) -> int:
    """Write one frame as a file that `np.load` opens; return its mark (see `neve.io.npz.mark_of`).

    edge: as of `stored`. Errors: RunError if the disk refuses.
    """
    return write_stored(folder, frame, stored(content, edge))


def write_stored(folder: Path, frame: int, arrays: Mapping[str, Any]) -> int:
    """Write a frame of which these are the arrays, and return the same. Errors: RunError."""
    with replacing(frame_path(folder, frame)) as file:
        return write_npz(file, arrays, DEFLATED)


def read_frame(folder: Path, frame: int) -> Frame:
    """Read one frame back.

    Errors: RunError if the file is missing, damaged, or no frame.
    """
    path = frame_path(folder, frame)
    try:
        arrays = read_npz(path)
        if "body_position" in arrays:
            raise RunError(f"{path} was written by an older Neve; run its scene.toml again to read it.")
        return frame_of_stored(arrays)
    except OSError as error:
        raise cannot_read(path, error) from error
    except (ValueError, KeyError, TypeError) as error:
        raise RunError(f"{path} is damaged or is no frame of a Neve run.") from error


def _frame(arrays: Mapping[str, NDArray[Any]]) -> Frame:
    """Return the frame of these arrays. Errors: ValueError, KeyError or TypeError if they are none."""
    n, s = len(arrays["x"]), len(arrays["solid_position"])
    shapes: dict[str, tuple[int, ...]] = {"x": (n, 3), "v": (n, 3), "J_P": (n,), "id": (n,), "material": (n,)}
    shapes |= {"solid_position": (s, 3), "solid_rotation": (s, 3, 3), "time": ()}
    for name, shape in shapes.items():
        if name in _OPTIONAL and name not in arrays:
            continue
        kinds = "iu" if name in ("id", "material") else "f"
        if arrays[name].shape != shape or arrays[name].dtype.kind not in kinds:
            raise ValueError(f"{name} is no such array")
        if kinds == "f" and not np.isfinite(arrays[name]).all():
            raise ValueError(f"{name} is not finite")
    x, v, position, rotation = (
        arrays[name].astype(np.float32, copy=False) for name in ("x", "v", "solid_position", "solid_rotation")
    )
    J_P = arrays["J_P"].astype(np.float32, copy=False) if "J_P" in arrays else None
    more = {
        name: values
        for name, values in arrays.items()
        if name not in shapes and values.shape[:1] == (n,) and values.dtype.kind in "iuf"
    }
    if not all(np.isfinite(values).all() for values in more.values() if values.dtype.kind == "f"):
        raise ValueError("a field is not finite")
    time = float(arrays["time"])
    return Frame(x, v, J_P, arrays["id"], arrays.get("material"), position, rotation, time, more)
