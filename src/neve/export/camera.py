"""The scene's camera as files have it: where it stands at any time, its lens and its film."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve.export.axes import Axes
from neve.render.shot import Shot

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.io.frames import Frame
    from neve.scene.schema.camera import Camera

NAME = "camera"
WIDTH = 0.036
"""Width of the film [m], of a full-frame camera: with the angle of view it says the focal length."""
ASPECT = 16.0 / 9.0
"""Width of pictures over their height."""
NEAR, FAR = 1e-3, 1e3
"""What is nearer and farther is not drawn, in distances from the camera to its target."""


@dataclass(frozen=True)
class CameraPose:
    """Hold a camera at one moment, in the axes and the unit of length of the file.

    matrix (4, 4): from its own axes to the world's, points being columns; it looks along its -z, its y is up
    in the picture, as in USD, glTF and Alembic. fov: vertical angle of view [rad]. distance: to the target.
    focus: distance of what is sharp
    """

    matrix: NDArray[np.float64]
    fov: float
    distance: float
    focus: float

    @property
    def clipping(self) -> tuple[float, float]:
        """Distances from which and up to which is drawn."""
        return NEAR * self.distance, FAR * self.distance


class FilmCamera:
    """Tell where the camera of a scene is at any time, once it has seen the frames if it follows something.

    aperture: radius of its lens, in the unit of the file; shutter: share of a frame that it is open
    """

    def __init__(self, camera: Camera, solids: Sequence[Solid], dx: float, axes: Axes) -> None:
        """Prepare. dx: of the snow's grid [m].

        Errors: SceneError if the camera follows a solid that is not there.
        """
        self._shot, self._axes = Shot(camera, solids, dx), axes
        self._focus, self.shutter = camera.focus, camera.shutter
        self.aperture = axes.scale * camera.aperture
        self.height = axes.scale * WIDTH / ASPECT
        self.width = axes.scale * WIDTH

    @property
    def follows(self) -> bool:
        """Whether it must see the frames."""
        return self._shot.follows

    def see(self, content: Frame) -> None:
        """Note where that which is followed is in a frame."""
        self._shot.see(content.time, content.x, content.v, content.id, content.solid_position)

    def at(self, time: float) -> CameraPose:
        """Return the camera at a time [s]."""
        view = self._shot.at(time)
        back = np.subtract(view.position, view.target)
        distance = float(np.linalg.norm(back))
        back = back / distance
        right = np.cross(view.up, back)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(back, right), back], axis=1)
        focus = distance if self._focus is None else self._focus
        scale = self._axes.scale
        matrix = self._axes.pose(np.asarray(view.position), axes)
        return CameraPose(matrix, math.radians(view.fov), scale * distance, scale * focus)

    def focal_length(self, pose: CameraPose) -> float:
        """Return the focal length with which the film has the angle of view: h / (2 tan(fov / 2)).

        In the unit of the file.
        """
        return 0.5 * self.height / math.tan(0.5 * pose.fov)

    def f_number(self, pose: CameraPose) -> float:
        """Return the focal length over the diameter of the lens; 0 for a pinhole, where all is sharp."""
        return self.focal_length(pose) / (2.0 * self.aperture) if self.aperture else 0.0
