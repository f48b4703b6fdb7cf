"""Recorder: keep the frames of a live run as a run folder, from which films and replays are made."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from neve.io.assets import assets_of, keep_assets, portable
from neve.io.atomic import write_text, writing
from neve.io.card import FORMAT, Card, write_card
from neve.io.errors import RunError
from neve.io.frames import block_edge, fields_of, frame_of, write_frame
from neve.io.run_folder import RunFolder
from neve.io.version import version
from neve.scene.errors import SceneError
from neve.system import disk

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene
    from neve.simulation import Simulation


class Recorder:
    """Write `recording-1`, `recording-2`, ... into the folder of the session, each a run of its own.

    Such a run holds scene.toml and frames, so that `neve view` plays it again; thrown balls are in the frames
    alone. The folder is made when the first thing is kept.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.on = False
        self.last: RunFolder | None = None
        """The last recording, finished or not."""
        self.frames = 0
        """Frames in it."""

    def switch(self, on: bool, sim: Simulation, scene: Scene) -> None:
        """Begin a recording with the present state, or end it. Errors: SceneError if the disk refuses."""
        if on == self.on:
            return
        self.on = on
        if not on:
            return
        try:
            run = RunFolder(free_name(self.folder, "recording", ""))
            with writing(run.path):
                disk.make_folder(run.frames)
            assets = assets_of(scene)
            keep_assets(run.path, assets)
            write_text(run.scene, portable(scene, assets))
            write_card(run.card, Card(FORMAT, version()))
        except RunError as error:
            self.on = False
            raise SceneError(str(error)) from error
        self.last, self.frames = run, 0
        self.keep(sim)

    def keep(self, sim: Simulation) -> None:
        """Write the present state as the next frame. Errors: SceneError if the disk refuses; then it ends."""
        if self.last is None:
            return
        poses = [(pose.position, pose.rotation) for _, pose in sim.solids()]
        content = frame_of(sim.columns(), poses, sim.time, fields_of(sim.scene, sim.columns()))
        try:
            write_frame(self.last.frames, self.frames, content, block_edge(sim.scene))
        except RunError as error:
            self.on = False
            raise SceneError(str(error)) from error
        self.frames += 1


def free_name(folder: Path, stem: str, suffix: str) -> Path:
    """Return the first of stem-1, stem-2, ... that is not in `folder` yet."""
    number = 1
    while (path := folder / f"{stem}-{number}{suffix}").exists():
        number += 1
    return path
