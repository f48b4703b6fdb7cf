"""The film of a fall: frames of snow that grows, as a run folder to be filmed, rendered and viewed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neve.backend import backend
from neve.build import PlacedSolids, coupled, placed_at_start, samples_of
from neve.gridless.initial import model_of
from neve.io.assets import assets_of, keep_assets, portable
from neve.io.atomic import write_text
from neve.io.frames import BLOCK_CELLS, make_frame, write_frame
from neve.io.run_folder import RunFolder
from neve.io.version import version
from neve.run.film import film_run
from neve.run.outputs.film import FILE as FILM
from neve.run.outputs.picture import FILE as PICTURE
from neve.scene.schema.scene import Scene
from neve.scene.schema.snowfall import Snowfall
from neve.snowfall.cover import Cover
from neve.snowfall.growth import Growth
from neve.snowfall.scene import is_moving

FALLING, SHUTTER = 60.0, 0.5
"""Flakes in a cubic metre of air [1/m3] and the camera's shutter [1], where the scene does not say."""
REST = 0.1
"""Share of the film at its end in which the snow lies as it will."""


@dataclass(frozen=True, eq=False)
class Fallen:
    """Hold a snowfall of a scene: its cover, and the depths (k + 1, n) [m] before and after each part.

    index: of the source that it is
    """

    scene: Scene
    index: int
    fall: Snowfall
    cover: Cover
    depths: NDArray[np.float64]


def film_fall(
    fallen: Fallen,
    folder: Path,
    frames: int,
    threads: int | None = None,
    progress: Callable[[int, int, int], None] = lambda done, of, new: None,
) -> Path:
    """Write the fall as a run of so many `frames` into `folder`, with its preview film; return the film.

    The hours of the fall pass in the time of the film, while flakes in the air fall as fast as they do. A run
    that lies there is replaced. Snow of other sources is in each frame. What moves at the start is not shown.
    Errors: RunError, FilmError, SceneError for a source that cannot be used.
    """
    scene = filmed(fallen.scene, fallen.fall, frames)
    run = RunFolder(folder)
    assets = assets_of(scene)
    toml = portable(scene, assets)
    poses = [(pose.position, pose.rotation) for _, pose in placed_at_start(scene)]
    growth = Growth.of(fallen.cover, fallen.depths, scene.numerics.spacing, scene.numerics.seed)
    there, source = snow_there(fallen)
    names = len(growth.x) + np.arange(len(there))
    with run.lock():
        run.open(version(), force=run.is_run(), files=(FILM, PICTURE))
        keep_assets(run.path, assets)
        write_text(run.scene, toml)
        for frame in range(frames):
            rows = growth.at(frame / max((1.0 - REST) * (frames - 1), 1.0))
            x = np.concatenate([growth.x[rows], there])
            id = np.concatenate([rows, names])
            own = {"source": np.concatenate([np.full(len(rows), fallen.index), source]).astype(np.uint16)}
            more = own if len(scene.bearers) > 1 else {}
            content = make_frame(x, np.zeros_like(x), None, id, None, poses, frame / scene.run.fps, more)
            write_frame(run.frames, frame, content, BLOCK_CELLS * scene.numerics.dx)
    return film_run(folder, threads=threads, progress=progress)


def snow_there(fallen: Fallen) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the particles of the scene's other sources that are at rest [m] (n, 3), and whose they are (n,).

    They lie as a run begins with them. Errors: SceneError for a source that cannot be used.
    """
    scene, sources = fallen.scene, fallen.scene.sources
    others = [
        i
        for i, source in enumerate(sources)
        if i != fallen.index and not any((*source.velocity, *source.spin))
    ]
    if not others:
        return np.zeros((0, 3)), np.zeros(0, np.int64)
    native = model_of(scene, backend("cpu").kernels(scene.numerics.precision))
    placed = PlacedSolids(native, scene.colliders, *coupled(scene), scene.numerics.dx)
    found = [samples.x for samples in samples_of(scene, placed, others)]
    return np.concatenate(found), np.repeat(others, [len(x) for x in found])


def filmed(scene: Scene, fall: Snowfall, frames: int) -> Scene:
    """Return the scene of the film: flakes in the air, no bodies that move, and as long as its frames."""
    light, camera = scene.light, scene.camera
    if "falling" not in light.model_fields_set:
        light = light.model_copy(update={"falling": FALLING})
    if "flake_velocity" not in light.model_fields_set:
        light = light.model_copy(update={"flake_velocity": (*fall.wind, -fall.fall_speed)})
    if "shutter" not in camera.model_fields_set:
        camera = camera.model_copy(update={"shutter": SHUTTER})
    moving = {solid.name for solid, pose in placed_at_start(scene) if is_moving(pose)}
    bodies = tuple(
        body.model_copy(update={"visible": False}) if f"bodies.{i}" in moving else body
        for i, body in enumerate(scene.bodies)
    )
    run = scene.run.model_copy(update={"duration": frames / scene.run.fps})
    return scene.model_copy(update={"light": light, "camera": camera, "bodies": bodies, "run": run})
