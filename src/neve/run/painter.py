"""Draw frames as they lie in a run folder, for films and pictures."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve.geometry.pose import Pose
from neve.io.frames import Frame
from neve.render.caption import captioned
from neve.render.shot import Shot, View

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.render.preview import Preview
    from neve.scene.schema.scene import Scene

SIZE = (1280, 720)
"""Width and height of a run's films and pictures [pixels]."""


class Painter:
    """Draw frames with the camera and the light of a scene.

    solids: colliders and bodies, in the order of the poses in a frame. threads: None or 0 for all.
    size: width and height [pixels], SIZE by default. radius: of a particle [m], by default as the scene says

    It draws what a frame file holds, so that a film drawn afterwards is the same film. A camera that follows
    something knows the frames up to the one that is drawn, as in a run that goes on; those before it must
    have been drawn, or seen by `shot`.
    """

    def __init__(
        self,
        scene: Scene,
        solids: Sequence[Solid],
        threads: int | None = None,
        size: tuple[int, int] | None = None,
        radius: float | None = None,
    ) -> None:
        self.size = size or SIZE
        self._scene = scene
        self._solids = solids
        self._threads = threads or 0
        self._radius = radius
        self.shot = self.fresh_shot()

    def fresh_shot(self) -> Shot:
        """Return the camera anew, which has seen no frame."""
        return Shot(self._scene.camera, self._solids, self._scene.numerics.dx)

    @functools.cached_property
    def _preview(self) -> Preview:
        from neve.render.preview import Preview

        return Preview(self._scene, *self.size, threads=self._threads, radius=self._radius)

    def draw(self, content: Frame) -> NDArray[np.uint8]:
        """Return the image of a frame, (height, width, 3)."""
        self.look(content)
        view = self.shot.at(content.time, ahead=False)
        poses = content.solid_position, content.solid_rotation
        return self.draw_arrays(content.x, content.J_P, *poses, view, content.more.get("phase"), content.time)

    def look(self, content: Frame) -> None:
        """Let the camera see a frame that is not drawn."""
        self.shot.see(content.time, content.x, content.v, content.id, content.solid_position)

    def look_back(self, frames: Iterable[int], read: Callable[[int], Frame]) -> None:
        """Let a camera that follows something see `frames`, in order, which `read` returns."""
        if self.shot.follows:
            for frame in frames:
                self.look(read(frame))

    def draw_arrays(
        self,
        x: NDArray[np.float32],
        J_P: NDArray[np.float32] | None,
        positions: Iterable[NDArray[np.floating]],
        rotations: Iterable[NDArray[np.floating]],
        view: View | None = None,
        water: NDArray[np.float32] | None = None,
        time: float = 0.0,
    ) -> NDArray[np.uint8]:
        """Return the image (height, width, 3) of particles at `x` [m], (n, 3), with J_P (n,), if it is known.

        positions, rotations: of each solid, (3,) [m] and (3, 3); those of further solids are left out.
        view: of the camera; without it that of the scene's at the start. water: share of each particle that
        is liquid (n,), if it is known. time: of the frame [s]. What the scene must say of itself is written
        into the picture.
        """
        places = zip(self._solids, positions, rotations, strict=False)
        solids = [(solid, Pose.at_rest(position, rotation)) for solid, position, rotation in places]
        image = self._preview.draw(x, solids, J_P=J_P, view=view, water=water, time=time)
        return captioned(image, self._scene.caption)
