"""Keep what Neve writes and deletes inside the folder that the user has named."""

from __future__ import annotations

from pathlib import Path

from neve.io.errors import RunError
from neve.system import disk


def refuse_link(root: Path, path: Path, but_last: bool = False) -> None:
    """Refuse a `path` that leads out of the folder `root` by a symbolic link.

    root: the folder that the user has named; it may be a link itself
    but_last: allow `path` itself to be one, as a file that is written takes the place of the link

    Errors: RunError.
    """
    link = disk.linked(root, path.parent if but_last else path)
    if link is not None:
        raise RunError(
            f"{link} is a symbolic link, and a run is written inside its own folder alone: put the folder"
            " itself in its place; a link may stand for the whole run folder."
        )
