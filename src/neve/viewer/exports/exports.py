"""Exports: pictures, films, replays and scenes that a page asks for, written into the session's folder."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from neve.io.atomic import write_bytes, write_png, write_text, writing
from neve.io.errors import RunError
from neve.io.frames import frame_numbers, frame_rate, read_frame
from neve.io.run_folder import RunFolder
from neve.render.film import Film, FilmError
from neve.run.painter import Painter
from neve.scene.errors import SceneError
from neve.scene.reading.short_toml import short_toml
from neve.scene.schema.scene import Camera, Scene
from neve.system import disk
from neve.viewer.exports.replay import replay_page
from neve.viewer.players.player import Player
from neve.viewer.players.recorded import Recorded
from neve.viewer.players.recorder import Recorder, free_name
from neve.viewer.protocol import commands
from neve.viewer.protocol.messages import Message

PREFIX = "/files/"


class Exports:
    """Make files one after the other in a thread of its own, and say so to the pages.

    Names are chosen here and only in `folder`; of what lies there, only what was made in this session is
    handed out.
    """

    def __init__(self, folder: Path, player: Player, recorder: Recorder | None) -> None:
        self.on_message: Callable[[Message], None] = lambda message: None
        self._folder, self._player, self._recorder = folder, player, recorder
        self._made: dict[str, Path] = {}
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="neve-export")
        self._waiting = 0
        self._closed = False

    def start(self, command: commands.Command) -> None:
        """Queue an export, unless four are queued already."""
        if self._waiting >= 4:
            self._refuse("four exports are queued: wait for one")
            return
        self._waiting += 1
        self._worker.submit(self._make, command)

    def file(self, path: str) -> Path | None:
        """Return the file at the address `path`, None for anything that was not made here."""
        return self._made.get(path.removeprefix(PREFIX)) if path.startswith(PREFIX) else None

    def close(self) -> None:
        """Finish: a film that is being made ends with the frame that is being drawn."""
        self._closed = True
        self._worker.shutdown(wait=True, cancel_futures=True)

    def _make(self, command: commands.Command) -> None:
        try:
            with writing(self._folder):
                disk.make_folder(self._folder)
            match command:
                case commands.Picture():
                    path = self._picture(command.camera)
                case commands.Film():
                    path = self._film(command.camera)
                case commands.Replay():
                    path = self._replay()
                case _:
                    path = self._save(getattr(command, "camera", None))
            self._made[path.name] = path
            self.on_message(
                {
                    "kind": "file",
                    "name": path.name,
                    "url": f"{PREFIX}{path.name}",
                    "place": str(path),
                    "bytes": path.stat().st_size,
                }
            )
        except (RunError, FilmError, SceneError) as error:
            self._refuse(str(error))
        except Exception as error:
            logging.getLogger("neve").exception("an export failed")
            self._refuse(f"the export failed: {error}")
        finally:
            self._waiting -= 1

    def _refuse(self, sentence: str) -> None:
        self.on_message({"kind": "refused", "sentence": sentence, "path": ""})

    def _progress(self, what: str, done: int, of: int) -> None:
        self.on_message({"kind": "progress", "what": what, "done": done, "of": of})

    def _picture(self, camera: commands.PageCamera) -> Path:
        snapshot, solids = self._player.latest, self._player.solids()
        if snapshot is None:
            raise SceneError("there is nothing to see yet")
        scene, size = seen_from(self._player.scene, camera), (camera.width, camera.height)
        painter = Painter(scene, solids, size=size, radius=self._player.radius())
        positions, rotations = [p for p, _ in snapshot.poses], [R for _, R in snapshot.poses]
        values = snapshot.values
        image = painter.draw_arrays(
            snapshot.x,
            values.get("J_P"),
            positions,
            rotations,
            water=values.get("phase"),
            time=snapshot.time,
        )
        path = free_name(self._folder, "picture", ".png")
        write_png(path, image)
        return path

    def _run(self) -> RunFolder:
        """Return the run whose frames are exported: the recorded one, or the last recording."""
        if isinstance(self._player, Recorded):
            return self._player.run
        if self._recorder is None or self._recorder.last is None or not self._recorder.frames:
            raise SceneError("nothing is recorded yet: press record, and play")
        return self._recorder.last

    def _film(self, camera: commands.PageCamera) -> Path:
        run = self._run()
        from neve.build import solids as solids_of
        from neve.scene.reading.load import load

        scene = seen_from(load(run.path), camera)
        path = free_name(self._folder, "film", ".mp4")
        painter = Painter(scene, solids_of(scene), size=(camera.width, camera.height))
        numbers = frame_numbers(run.frames)
        film = Film(path, frame_rate(numbers, scene.run.fps), painter.size)
        for i, number in enumerate(numbers):
            if self._closed:
                break
            film.add(painter.draw(read_frame(run.frames, number)))
            if i % 5 == 0:
                self._progress("film", i, len(numbers))
        film.close()
        return path

    def _replay(self) -> Path:
        run = self._run()
        path = free_name(self._folder, "replay", ".html")
        write_bytes(path, replay_page(run, lambda done, of: self._progress("replay", done, of)))
        return path

    def _save(self, camera: commands.PageCamera | None) -> Path:
        scene = self._player.scene
        path = free_name(self._folder, "scene", ".toml")
        write_text(path, short_toml(seen_from(scene, camera) if camera else scene))
        return path


def seen_from(scene: Scene, camera: commands.PageCamera) -> Scene:
    """Return the scene with a page's camera. Errors: SceneError if it looks nowhere."""
    try:
        seen = Camera(position=camera.position, target=camera.target, up=camera.up, fov=camera.fov)
    except ValueError as error:
        raise SceneError("the camera looks nowhere: its target is where it stands") from error
    return scene.model_copy(update={"camera": seen})
