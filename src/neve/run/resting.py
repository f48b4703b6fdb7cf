"""The snow that a run has left: as a file, and as the scene of a next run, on which it can snow."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.build import material_table, placed_at_start
from neve.geometry.pose import Pose
from neve.heat.enthalpy import liquid, temperature
from neve.io.checkpoint import Checkpoint, read_checkpoint
from neve.io.errors import RunError
from neve.io.frames import read_frame
from neve.io.run_folder import RunFolder
from neve.reproducible import norms, product
from neve.scene.errors import SceneWarning
from neve.scene.reading.load import load
from neve.scene.schema.scene import Body, Overrides, Scene, Source
from neve.snowfall.resting import Resting
from neve.snowfall.scene import Placed

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

Arrays = Mapping[str, NDArray[Any]]

DIGITS = 9
"""Decimals of the places and turns of bodies [m, degrees]."""
MOVING = 0.1
"""Speed from which snow at the end of a run still moves [m/s]."""
MUCH = 0.05
"""Share of such snow that a warning tells [1]."""


@dataclass(frozen=True, eq=False)
class Left:
    """Hold what a run has left.

    Attributes:
        scene: of the run
        snows: particles of each of its snows that there are any of, with what that snow has of its own
        placed: the solids, and where they are at the end
    """

    scene: Scene
    snows: tuple[tuple[Resting, Overrides], ...]
    placed: Placed

    @property
    def volume(self) -> float:
        """Of the snow: V0 J_P of its particles [m3]."""
        return sum(rest.volume for rest, _ in self.snows)

    @property
    def mass(self) -> float:
        """Of the snow [kg]."""
        return sum(float(rest.m.sum()) for rest, _ in self.snows)

    def onward(self, files: list[Path], more: tuple[Source, ...]) -> Scene:
        """Return the scene of a next run: the snow of `files`, then `more`, and the bodies where they lie.

        files: of each of `snows`. Bodies in joints and robots begin where they began; emitters have ended.
        """
        lying = tuple(
            Source.of("lying", file=str(file), snow=own)
            for file, (_, own) in zip(files, self.snows, strict=True)
        )
        first = len(self.scene.colliders)
        before = placed_at_start(self.scene)
        bodies = tuple(
            _moved(body, before[first + i][1], self.placed[first + i][1])
            for i, body in enumerate(self.scene.bodies)
        )
        changed = {"sources": (*lying, *more), "bodies": bodies, "emitters": (), "sinks": ()}
        return self.scene.model_copy(update=changed)


def _moved(body: Body, before: Pose, now: Pose) -> Body:
    """Return a free body at rest where it is `now`; others as they are."""
    if body.joint != "free" or body.parent is not None:
        return body
    from scipy.spatial.transform import Rotation

    turn = product(now.rotation, before.rotation.T)
    whole: Rotation = Rotation.from_matrix(turn) * Rotation.from_rotvec(body.rotation, degrees=True)
    place = now.position + product(turn, np.array(body.place) - before.position)
    still = (0.0, 0.0, 0.0)
    return body.model_copy(
        update={
            body.place_key: tuple(round(value, DIGITS) for value in place.tolist()),
            "rotation": tuple(round(value, DIGITS) for value in whole.as_rotvec(degrees=True).tolist()),
            "velocity": still,
            "spin": still,
        }
    )


def left_by(run: RunFolder) -> Left:
    """Return what the run in a folder has left at its checkpoint. Errors: RunError, SceneError."""
    scene = load(run.scene)
    checkpoint = read_checkpoint(run.checkpoint)
    frame = read_frame(run.frames, checkpoint.frame)
    solids = [solid for solid, _ in placed_at_start(scene)]
    poses = [
        Pose.at_rest(position, rotation)
        for position, rotation in zip(frame.solid_position, frame.solid_rotation, strict=True)
    ]
    arrays = checkpoint.arrays
    snow_rows = np.asarray(arrays["material"])
    snows = []
    for row, snow in enumerate(material_table(scene)):
        bearer = next(source for source in scene.bearers if scene.snow_of(source) == snow)
        mine = np.flatnonzero(snow_rows == row)
        mine = mine[np.argsort(np.asarray(arrays["id"])[mine])]
        if len(mine) and not bearer.is_water:
            snows.append((_resting(scene, checkpoint, mine), bearer.snow))
    if not snows:
        raise RunError(f"{run.path} holds no snow, so there is none on which more can fall.")
    m, speed = np.asarray(arrays["m"], float), norms(np.asarray(arrays["v"], float))
    moving = float(m[speed > MOVING].sum() / m.sum())
    if moving > MUCH:
        sentence = (
            f"{run.path}: {moving:.1%} of the snow still moves, and is taken as it is: run it for longer"
        )
        warnings.warn(sentence, SceneWarning, stacklevel=2)
    return Left(scene, tuple(snows), list(zip(solids, poses, strict=True)))


def _resting(scene: Scene, checkpoint: Checkpoint, mine: NDArray[np.int64]) -> Resting:
    """Return the particles of these rows as they lie: without stress, their plastic state kept."""
    arrays = checkpoint.arrays

    def column(name: str) -> NDArray[np.float64]:
        return np.asarray(arrays[name], np.float64)[mine]

    x, m, count = column("x"), column("m"), len(mine)
    if "beyond" in arrays and np.asarray(arrays["beyond"]).shape[1:] == (3,):
        x = x + column("beyond")
    growth, celsius, water = np.ones(count), np.zeros(count), np.zeros(count)
    if "enthalpy" in arrays and (heat := column("enthalpy").reshape(count, -1)).size:
        celsius, water = np.minimum(temperature(heat[:, 0], m), 0.0), liquid(heat[:, 0], m)
    if "thermal" in arrays and (thermal := column("thermal")).shape[1:] == (3,):
        growth = np.maximum(thermal[:, 1], 1.0)
    return Resting(
        x=x,
        m=m,
        V0=column("V0"),
        J_P=column("J_P") if "J_P" in arrays else np.ones(count),
        stiffness=column("stiffness"),
        strength=column("strength"),
        growth=growth,
        temperature=celsius,
        liquid=water,
        spacing=scene.numerics.spacing,
    )
