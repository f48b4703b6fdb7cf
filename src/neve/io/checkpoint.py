"""The checkpoint of a run: all that an exact resume needs, in one file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from neve.io.atomic import replacing
from neve.io.errors import RunError, cannot_read
from neve.io.inventory import Inventory
from neve.io.npz import read_npz, write_npz
from neve.system import disk

FORMAT = 5
"""Version of the checkpoint's layout; a resume needs the same one."""

_PREFIX = "state."
_ANEW = "start over with --force"


class Arrays(dict[str, Any]):
    """Arrays of a checkpoint by name; asking for one that is not there raises a RunError."""

    def __init__(self, path: Path, values: Mapping[str, Any]) -> None:
        super().__init__(values)
        self._path = path

    def __missing__(self, name: str) -> Any:
        raise _lacks(self._path, name)


@dataclass(frozen=True)
class Checkpoint:
    """The state of a run at the end of a frame."""

    frame: int  # number of the last frame that is complete on disk
    scene: str  # the scene as TOML, as the state was computed with it
    neve: str  # version and build of Neve that wrote the file
    arrays: dict[str, Any]  # what Simulation.restore takes: arrays, and scalars as Python numbers
    inventory: Inventory | None = None  # what the run has written by then; None: the file does not say


def write_checkpoint(
    path: Path,
    frame: int,
    scene: str,
    neve: str,
    arrays: Mapping[str, Any],
    inventory: Inventory | None = None,
) -> None:
    """Write the state as of the end of `frame` and the `inventory`; the file is replaced as a whole.

    Errors: RunError if the disk refuses.
    """
    head: dict[str, Any] = {"checkpoint_format": FORMAT, "frame": frame, "scene": scene, "neve": neve}
    if inventory is not None:
        head |= inventory.arrays()
    with replacing(path) as file:
        write_npz(file, head | {_PREFIX + name: value for name, value in arrays.items()})
    disk.sync_folder(path.parent)


def read_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint back, every array with its bits.

    Errors: RunError if the file is missing, damaged, or of another format version; and later, when an array
    is asked for that the file lacks: what a state consists of is known to who restores it.
    """
    try:
        raw = read_npz(path)
        version = int(raw["checkpoint_format"])
    except FileNotFoundError as error:
        raise RunError(f"{path} does not exist, so there is nothing to resume; {_ANEW}.") from error
    except OSError as error:
        raise cannot_read(path, error) from error
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise RunError(f"{path} is damaged (cut short or altered) and cannot be resumed; {_ANEW}.") from error
    if version != FORMAT:
        older = "an older" if version < FORMAT else "a newer"
        raise RunError(
            f"{path} was written by {older} version of Neve (checkpoint format {version}; this one reads"
            f" {FORMAT}): use that version or {_ANEW}."
        )
    try:
        arrays = {name.removeprefix(_PREFIX): raw[name] for name in raw if name.startswith(_PREFIX)}
        frame = int(raw["frame"])
        if frame < 0:
            raise ValueError(frame)
        return Checkpoint(
            frame=frame,
            scene=str(raw["scene"]),
            neve=str(raw["neve"]),
            inventory=Inventory.of_arrays(raw),
            arrays=Arrays(
                path, {name: value.item() if value.ndim == 0 else value for name, value in arrays.items()}
            ),
        )
    except (KeyError, ValueError, TypeError, OverflowError) as error:
        raise _lacks(path, str(error.args[0]) if isinstance(error, KeyError) else "a number") from error


def _lacks(path: Path, what: str) -> RunError:
    return RunError(f"{path} lacks parts of its state ({what}) and cannot be resumed; {_ANEW}.")
