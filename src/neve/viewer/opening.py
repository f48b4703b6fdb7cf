"""Open another scene or run while the pages watch: one that comes with Neve, or lies in a served folder."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from neve.io.errors import RunError
from neve.io.frames import frame_numbers
from neve.io.run_folder import RunFolder
from neve.scene.errors import SceneError
from neve.scene.reading.load import load
from neve.scene.reading.presets import presets
from neve.scene.schema.scene import Scene
from neve.spelling import hint, nearest
from neve.viewer.exports.exports import Exports
from neve.viewer.players.live import Live
from neve.viewer.players.player import Player
from neve.viewer.players.recorded import Recorded
from neve.viewer.players.recorder import Recorder
from neve.viewer.protocol.messages import LibraryEntry

MOST_LISTED = 200
"""Entries of the list."""

DEEP = 2
"""Folders below a served one in which runs are looked for: a session's recordings are runs, too."""


class Show(NamedTuple):
    """Hold what pages watch, and what makes their files."""

    player: Player
    exports: Exports


class Opener:
    """Know the scenes and runs that a page may open: names from a list, never a path."""

    def __init__(self, roots: Sequence[Path], folder: Path, threads: int | None) -> None:
        """roots: the served folders. folder: of the session, where live runs are kept."""
        self.folder, self._threads = folder, threads
        self._roots = [root for root in dict.fromkeys(path.resolve() for path in roots) if root.is_dir()]

    def entries(self) -> list[LibraryEntry]:
        """Return what lies in the served folders now."""
        return [{"name": name, "kind": "run" if path.is_dir() else "scene"} for name, path in self._found()]

    def show_of(self, name: str) -> Show:
        """Return what shows the scene or run `name`, not yet started.

        Errors: SceneError, RunError: there is none, or it cannot be shown.
        """
        path = self._path(name)
        if path is not None and path.is_dir():
            run = RunFolder(path)
            player: Player = Recorded(run)
            player.name = name
            return Show(player, Exports(run.path, player, None))
        live = self.live(name, self.scene_of(name))
        live.player.make_ready()
        return live

    def place_of(self, name: str) -> str:
        """Return what opens the scene or run `name`: its path, or its name if it comes with Neve.

        Errors: SceneError.
        """
        path = self._path(name)
        return name if path is None else str(path)

    def is_run(self, name: str) -> bool:
        """Return whether `name` is a run. Errors: SceneError if there is no such name."""
        path = self._path(name)
        return path is not None and path.is_dir()

    def scene_of(self, name: str) -> Scene:
        """Return the scene `name`. Errors: SceneError."""
        return load(self._path(name) or name)

    def live(self, name: str, scene: Scene) -> Show:
        """Return what computes a scene, not yet started."""
        recorder = Recorder(self.folder)
        player = Live(name, scene, self._threads, recorder)
        return Show(player, Exports(self.folder, player, recorder))

    def _path(self, name: str) -> Path | None:
        """Return where `name` lies; None if it comes with Neve. Errors: SceneError if it is neither."""
        if name in presets():
            return None
        found = dict(self._found())
        if name not in found:
            close = nearest(name, [*found, *presets()])
            raise SceneError(
                f'"{name[:80]}" is no scene that comes with Neve, nor in the served folder{hint(close)}'
            )
        return found[name]

    def _found(self) -> Iterator[tuple[str, Path]]:
        count = 0
        for root in self._roots:
            for path in _below(root, DEEP):
                if count == MOST_LISTED:
                    return
                if not path.resolve().is_relative_to(root):
                    continue  # a link that leads elsewhere
                count += 1
                yield (path.relative_to(root).as_posix(), path)


def _below(folder: Path, deep: int) -> Iterator[Path]:
    """Yield the scene files in a folder, and the runs in it and below, by name."""
    with contextlib.suppress(OSError):
        for path in sorted(folder.iterdir()):
            if path.name.startswith("."):
                continue
            if path.suffix == ".toml" and deep == DEEP and path.is_file():
                yield path
            elif path.is_dir():
                run = RunFolder(path)
                if run.is_run():
                    with contextlib.suppress(OSError, RunError):
                        if frame_numbers(run.frames):
                            yield path
                elif deep > 1:
                    yield from _below(path, deep - 1)
