"""The record of an export, `export.json`: its presence makes a folder an export, and it lists the files."""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path
from typing import Any

from neve.io.errors import RunError, cannot_read
from neve.system import disk

NAME = "export.json"
LAYOUT = 1


def read_record(folder: Path) -> dict[str, Any] | None:
    """Return the record in `folder`; None if there is none. Errors: RunError.

    It has `options` (by name), `files` (names), and `frames`: by number, time [s] and mark of the frame file.
    """
    path = folder / NAME
    try:
        found = json.loads(disk.read_bytes(path))
        if found["layout"] != LAYOUT:
            raise RunError(f"{path} is of another version of Neve: choose another --out.")
        names = [name for name in found["files"] if os.path.basename(name) != name or name in ("", "..")]
        entries = [(int(k), float(t), int(mark)) for k, (t, mark) in found["frames"].items()]
        if names or not isinstance(found["options"], dict) or any(k < 0 for k, _, _ in entries):
            raise ValueError(found)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise cannot_read(path, error) from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise RunError(f"{path} is damaged: remove it, or choose another --out.") from error
    return dict(found)


def clear(folder: Path) -> None:
    """Remove the files of an export, and the folder if it is empty then; what is no export stays.

    Errors: OSError.
    """
    with contextlib.suppress(RunError):
        found = read_record(folder)
        if found is not None:
            disk.remove_files(folder, [*found["files"], NAME])
            disk.remove_if_empty(folder)
