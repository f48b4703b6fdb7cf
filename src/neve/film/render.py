"""Render the frames of a run folder: a picture each, and a film of them."""

from __future__ import annotations

import hashlib
import json
import threading
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor
from dataclasses import astuple
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.build import solids as solids_of
from neve.film.pictures import exr_key, png_key, read_png, refuse_strangers, write_exr, write_png
from neve.film.sharing import jobs_for, needed
from neve.geometry.pose import Pose, rotation_matrix, rotation_vector
from neve.io.atomic import writing
from neve.io.errors import RunError
from neve.io.frames import Frame, chosen_frames, frame_numbers, frame_path, frame_rate, read_frame
from neve.io.npz import mark_of
from neve.io.run_folder import RunFolder
from neve.render.caption import captioned
from neve.render.path_tracing.develop import coded, has_denoiser
from neve.render.path_tracing.engine import mitsuba
from neve.render.path_tracing.picture import Choices, PathTracer
from neve.render.shot import Shot, View
from neve.system import disk, processes
from neve.system.cluster import elsewhere
from neve.system.processors import cores

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.scene.schema.scene import Scene

FOLDER = "render"
FILM = "render.mp4"
PART = "render_{:06d}-{:06d}.mp4"
"""Name of a film of some frames, by the first and the last: it takes the place of no film of all."""
FORMAT = 10
"""Changes when the same choices give another picture."""
CHANGEABLE = ("camera", "light")
"""Tables of the scene that may be changed once the snow has moved."""

Progress = Callable[[int, int, int], None]
"""Called after each picture: how many are there, how many are asked for, and how many are new."""


def render_run(
    path: Path | str,
    choices: Choices = Choices(),  # noqa: B008 (a constant)
    out: Path | str | None = None,
    frames: slice | None = None,
    changes: Sequence[str] = (),
    exr: bool = False,
    force: bool = False,
    threads: int = 0,
    jobs: int | None = None,
    progress: Progress = lambda done, of, new: None,
    scheduler: str | None = None,
) -> tuple[Path, int]:
    """Render frames of the run folder `path`; return what was made and how many pictures are new.

    A picture that is there already, of the same frame with the same choices, is kept unless `force`. With
    more than one frame a film is made of them at the end, "render.mp4" if they are all of the run's and else
    with their numbers in its name. Returns the film, or the picture of a single frame.

    out: folder of the pictures, by default "render" in the run folder
    frames: numbers from start to stop, without stop, by step; None for all
    changes: of camera and light, such as "camera.fov=30"
    exr: write the linear light of each frame as OpenEXR, too
    jobs: processes that draw frames at once, which share the `threads`; no more than these. None: as many as
    cores and free memory allow, see `jobs_for`
    scheduler: address of a Dask cluster that draws instead of this machine, a frame for each worker at a
    time; its workers see the run and `out` under the same paths

    Errors: ClusterError, RunError, SceneError, RenderError, FilmError, one sentence.
    """
    from neve.scene.reading.load import load

    run = _run_at(path if scheduler is None else Path(path).absolute())
    _require_changeable(changes)
    numbers = chosen_frames(run.frames, frames, "render")
    scene = load(run.path, changes)
    choices.check(scene.camera)
    mitsuba()  # whoever lacks it is told before anything is written
    target = Path(out) if out is not None else run.path / FOLDER
    if scheduler is not None:
        target = target.absolute()
    with writing(target):
        disk.make_folder(target)
    share = threads or cores()
    job = _Job(run, scene, choices, target, exr, threads)
    new = 0
    with RunFolder(target).lock():
        with writing(target):
            disk.sweep(target)
        job.refuse_strangers(numbers)
        jobs = min(job.side_by_side(numbers, force, share) if jobs is None else jobs, len(numbers), share)
        if jobs > 1 and scheduler is None:
            job.threads = share // jobs
        for done, made in enumerate(_pictures(job, numbers, force, jobs, changes, scheduler), 1):
            new += made
            progress(done, len(numbers), new)
        if len(numbers) == 1:
            return job.path(numbers[0]), new
        return job.film(numbers), new


def _run_at(path: Path | str) -> RunFolder:
    run = RunFolder(path)
    if not run.is_run():
        raise RunError(f"{run.path} holds no Neve run, so there is nothing to render.")
    return run


def _require_changeable(changes: Sequence[str]) -> None:
    for change in changes:
        if change.partition("=")[0].partition(".")[0].strip() not in CHANGEABLE:
            raise RunError(
                f"--set {change}: a run that is there can change its {' and '.join(CHANGEABLE)} alone."
            )


def _pictures(
    job: _Job, numbers: Sequence[int], force: bool, jobs: int, changes: Sequence[str], scheduler: str | None
) -> Iterator[bool]:
    """Make the pictures of frames, on a cluster or in `jobs` processes; yield which are new."""
    items = [(number, force) for number in numbers]
    if scheduler is not None:
        yield from elsewhere(scheduler, _picture_elsewhere, items, (uuid.uuid4().hex, job.told(changes)))
        return
    if jobs == 1:
        yield from (job.picture(*item) for item in items)
        return
    try:
        yield from processes.results(_picture, items, jobs, _begin, job.told(changes))
    except BrokenExecutor as error:
        raise RunError(
            "a process of neve render has ended, maybe for lack of memory: use fewer --jobs."
        ) from error


def _picture_elsewhere(what: tuple[int, bool], common: tuple[str, tuple[Any, ...]]) -> bool:
    """Make a picture with the job of this process, which lasts from one to the next."""
    mark, told = common
    with _turn:
        if _mark != [mark]:
            _held.clear()
            _begin(*told)
            _mark[:] = [mark]
        return _picture(what)


_turn = threading.Lock()
_mark: list[str] = []
"""Stands for the job in `_held`, if a cluster has told it."""
_held: list[_Job] = []
"""The job of a process that was started for it."""


def _begin(run: RunFolder, changes: Sequence[str], *more: Any) -> None:
    from neve.scene.reading.load import load

    _held.append(_Job(run, load(run.path, changes), *more))


def _picture(what: tuple[int, bool]) -> bool:
    return _held[0].picture(*what)


class _Job:
    """Render frames of one run with one set of choices."""

    def __init__(
        self,
        run: RunFolder,
        scene: Scene,
        choices: Choices,
        target: Path,
        exr: bool,
        threads: int,
        views: Mapping[int, View] = MappingProxyType({}),
        seen: Mapping[str, NDArray[Any]] | None = None,
    ) -> None:
        self._run, self._scene, self._choices, self._target = run, scene, choices, target
        self._exr, self.threads = exr, threads
        self._solids: tuple[Solid, ...] = solids_of(scene)
        self._shot = Shot(scene.camera, self._solids, scene.numerics.dx)
        self._views = dict(views)
        if seen is not None:
            self._shot.recall(seen)
        self._tracer: PathTracer | None = None

    def told(self, changes: Sequence[str]) -> tuple[Any, ...]:
        """Return what makes an equal job in another process, see `_begin`; changes: of its scene."""
        views = self.views  # it lets the camera see the frames
        more = (self._choices, self._target, self._exr, self.threads, views, self._shot.state())
        return self._run, [*changes], *more

    def path(self, number: int) -> Path:
        return self._target / f"{number:06d}.png"

    def refuse_strangers(self, numbers: Sequence[int]) -> None:
        """Refuse to write over files of another maker. Errors: RunError."""
        for number in numbers:
            refuse_strangers(self.path(number))
            if self._exr:
                refuse_strangers(self.path(number).with_suffix(".exr"))

    def side_by_side(self, numbers: Sequence[int], force: bool, share: int) -> int:
        """Return how many frames to draw at once on so many cores, of those that are not there yet."""
        left = len(numbers) if force else sum(not self._there(n, self._key(n)) for n in numbers)
        if left < 2 or share < 2:
            return 1
        quality, (_, most) = self._choices.all, self._first_and_most()
        grains = most * self._choices.grains(self._scene.numerics.spacing, self.views.values(), most)
        pixels = quality.size[0] * quality.size[1]
        return jobs_for(left, share, left * pixels * quality.samples, needed(grains, pixels))

    def _there(self, number: int, key: str) -> bool:
        """Say whether the picture of a frame is there, made from what `key` stands for."""
        path = self.path(number)
        return png_key(path) == key and (not self._exr or exr_key(path.with_suffix(".exr")) == key)

    def picture(self, number: int, force: bool) -> bool:
        """Make the picture of a frame; return whether it is new."""
        path, key = self.path(number), self._key(number)
        linear = path.with_suffix(".exr")
        if exr_key(linear) not in (None, key):  # it would pass for the light of the new picture
            with writing(linear):
                disk.remove(linear)
        if not force and self._there(number, key):
            return False
        light = self._light(read_frame(self._run.frames, number), number)
        if self._exr:
            write_exr(linear, light, key)
        write_png(path, captioned(coded(light), self._scene.caption), key)
        return True

    def film(self, numbers: Sequence[int]) -> Path:
        """Join the pictures to a film that plays as fast as the snow moved."""
        from neve.render.film import Film

        whole = [*numbers] == frame_numbers(self._run.frames)
        path = self._target / (FILM if whole else PART.format(numbers[0], numbers[-1]))
        film = Film(path, frame_rate(numbers, self._scene.run.fps), self._choices.all.size)
        for number in numbers:
            film.add(read_png(self.path(number)))
        film.close()
        return path

    @property
    def views(self) -> dict[int, View]:
        """The view of the camera in each frame of the run, by its number."""
        if not self._views:
            numbers = frame_numbers(self._run.frames)
            times = {number: number / self._scene.run.fps for number in numbers}
            for number in numbers if self._shot.follows else ():
                content = read_frame(self._run.frames, number)
                self._shot.see(times[number], content.x, content.v, content.id, content.solid_position)
            self._views = {number: self._shot.at(time) for number, time in times.items()}
        return self._views

    def _light(self, content: Frame, number: int) -> NDArray[np.float32]:
        if self._tracer is None:
            first, most = self._first_and_most()
            self._tracer = PathTracer(
                self._scene, self._choices, first.id, first.x, most, [*self.views.values()], self.threads
            )
        if len(content.solid_position) != len(self._solids):
            raise RunError(
                f"{frame_path(self._run.frames, number)} has {len(content.solid_position)} solids, and the"
                f" scene of the run {len(self._solids)}: it is a frame of another run."
            )
        moving = self._moving(content, number)
        F_E, water = content.more.get("F_E"), content.more.get("phase")
        return self._tracer.draw(
            content.x, content.v, content.id, moving, self._open_for, F_E, water, content.J_P, content.time
        )

    def _first_and_most(self) -> tuple[Frame, int]:
        """Return the first frame of the run, and the most particles that a frame has."""
        numbers = frame_numbers(self._run.frames)
        first, last = (read_frame(self._run.frames, n) for n in (numbers[0], numbers[-1]))
        return first, max(len(first.x), len(last.x))  # a source that flows has its most at the end

    @property
    def _open_for(self) -> float:
        """How long the shutter is open [s]."""
        return self._scene.camera.shutter / self._scene.run.fps

    def _beside(self, number: int) -> list[int]:
        """Return the numbers of the frames before and after a frame, of those that are there."""
        numbers = frame_numbers(self._run.frames)
        k = numbers.index(number)
        return [numbers[j] for j in (k - 1, k + 1) if 0 <= j < len(numbers)]

    def _moving(
        self, content: Frame, number: int
    ) -> Callable[[float], tuple[list[tuple[Solid, Pose]], View]]:
        """Return what tells of a time after the frame [s] where the solids are, and the view.

        A solid moves evenly to its place in the frame before or after, whichever the time is nearer to.
        """
        beside = (
            [(n, read_frame(self._run.frames, n)) for n in self._beside(number)] if self._open_for else []
        )
        fps = self._scene.run.fps

        def placed(dt: float) -> tuple[list[tuple[Solid, Pose]], View]:
            position: NDArray[Any] = content.solid_position
            rotation: NDArray[Any] = content.solid_rotation
            for n, other in beside:
                share = dt * fps / (n - number)
                if share > 0.0 and other.solid_position.shape == position.shape:
                    position, rotation = between(content, other, share)
            poses = zip(self._solids, position, rotation, strict=True)
            view = self._shot.at(number / fps + dt) if dt else self.views[number]
            return [(solid, Pose.at_rest(x, R)) for solid, x, R in poses], view

        return placed

    def _key(self, number: int) -> str:
        """Return a word for all that the picture of a frame depends on."""
        scene, quality = self._scene, self._choices.all
        parts: dict[str, Any] = {
            "format": FORMAT,
            "frame": mark_of(frame_path(self._run.frames, number)),
            "number": number,
            "view": astuple(self.views[number]),
            "pixel": self._choices.pixel(self.views.values()),
            "blur": self._blur(number),
            "light": scene.light.model_dump(mode="json"),
            "choices": [*vars(quality).values(), self._choices.kind, self._choices.radius(scene.camera)],
            "focus": scene.camera.focus,
            "denoise": self._choices.denoise and has_denoiser(),
        }
        if scene.caption:
            parts["caption"] = scene.caption
        return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:32]

    def _blur(self, number: int) -> list[Any] | None:
        """Return what else a picture depends on that is blurred."""
        if not self._open_for:
            return None
        time, half = number / self._scene.run.fps, 0.5 * self._open_for
        marks = [mark_of(frame_path(self._run.frames, n)) for n in self._beside(number)]
        return [self._open_for, marks, *(astuple(self._shot.at(time + dt)) for dt in (-half, half))]


def between(here: Frame, there: Frame, share: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places (s, 3) [m] and rotations (s, 3, 3) of the solids on the way from a frame to another."""
    position = (1.0 - share) * here.solid_position + share * there.solid_position
    pairs = zip(here.solid_rotation.astype(np.float64), there.solid_rotation.astype(np.float64), strict=True)
    turned = [rotation_matrix(share * rotation_vector(R1 @ R0.T)) @ R0 for R0, R1 in pairs]
    return np.asarray(position, np.float64), np.array(turned).reshape(-1, 3, 3)
