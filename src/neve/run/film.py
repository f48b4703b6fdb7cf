"""Draw the film and the picture of a run that is there anew, with another camera or light."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from neve.build import solids as solids_of
from neve.io.atomic import writing
from neve.io.errors import RunError
from neve.io.frames import Frame, chosen_frames, frame_numbers, frame_rate, read_frame
from neve.io.run_folder import RunFolder, parts_of
from neve.run.best import best_frame
from neve.run.outputs.film import FILE as FILM
from neve.run.outputs.picture import FILE as PICTURE
from neve.run.outputs.picture import draw_still
from neve.run.painter import Painter
from neve.system import disk

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene

CHANGEABLE = ("camera", "light")
"""Tables of the scene that may be changed once the snow has moved."""


def film_run(
    path: Path | str,
    changes: Sequence[str] = (),
    out: Path | str | None = None,
    frames: slice | None = None,
    size: tuple[int, int] | None = None,
    threads: int | None = None,
    progress: Callable[[int, int, int], None] = lambda done, of, new: None,
) -> Path:
    """Draw the film of the run folder `path` from its frames; return the file.

    changes: of camera and light, such as "camera.fov=30". The scene of the run stays as it was run.
    out: of the film; by default preview.mp4 of the run, beside which preview.png is drawn anew as well
    frames: numbers from start to stop, without stop, by step; None for all. size: of the pictures [px]
    progress: called after each picture: how many are there, of how many, and how many are new

    Errors: RunError, SceneError, FilmError, one sentence.
    """
    from neve.scene.reading.load import load

    run = RunFolder(path)
    if not run.is_run():
        raise RunError(f"{run.path} holds no Neve run, so there is nothing to film.")
    for change in changes:
        if change.partition("=")[0].partition(".")[0].strip() not in CHANGEABLE:
            raise RunError(
                f"--set {change}: a run that is there can change its {' and '.join(CHANGEABLE)} alone."
            )
    if out is not None and Path(out).suffix != ".mp4":
        raise RunError(f"--out {out}: a film ends in .mp4.")
    numbers = chosen_frames(run.frames, frames, "draw")
    scene = load(run.path, changes)
    place = run.path / FILM if out is None else Path(out)
    with run.lock():
        if out is None:
            run.own(FILM, PICTURE)
        drawing = _Drawing(run, scene, threads, size)
        drawing.film(place, numbers, progress)
        if out is None:
            drawing.still(run.path / PICTURE, numbers)
    return place


class _Drawing:
    """Draw the frames of a run with a scene that has another camera."""

    def __init__(
        self, run: RunFolder, scene: Scene, threads: int | None, size: tuple[int, int] | None
    ) -> None:
        self._run, self._scene = run, scene
        self._solids = solids_of(scene)
        self._threads, self._size = threads, size

    def _painter(self) -> Painter:
        return Painter(self._scene, self._solids, self._threads, self._size)

    def film(self, place: Path, numbers: Sequence[int], progress: Callable[[int, int, int], None]) -> None:
        """Draw the film, which takes the place of another one only when it is whole."""
        from neve.render.film import Film

        painter, new = self._painter(), place.with_name(f".{place.stem}.new.mp4")
        painter.look_back([k for k in frame_numbers(self._run.frames) if k < numbers[0]], self._read)
        try:
            film = Film(new, frame_rate(numbers, self._scene.run.fps), painter.size)
            for done, number in enumerate(numbers, 1):
                film.add(painter.draw(self._read(number)), index=done - 1)
                progress(done, len(numbers), done)
            film.close()
        except BaseException:
            disk.remove_tree(parts_of(new))
            raise
        with writing(place):
            disk.move(new, place)

    def still(self, place: Path, numbers: Sequence[int]) -> None:
        """Draw the picture of the best moment before this camera."""
        painter = self._painter()
        best = best_frame(numbers, self._read, painter.shot)
        frame = numbers[len(numbers) // 2] if best is None else best
        draw_still(place, self._painter(), numbers, frame, self._read)

    def _read(self, number: int) -> Frame:
        content = read_frame(self._run.frames, number)
        if len(content.solid_position) != len(self._solids):
            raise RunError(
                f"frame {number} of {self._run.path} has {len(content.solid_position)} solids, and the scene"
                f" of the run {len(self._solids)}: it is a frame of another run."
            )
        return content
