"""Draw a frame of a scene: snow in the sun, its ground and its solids. Needs no GPU and no display."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

import neve._render as _render
from neve.render.falling import glow, streaks
from neve.render.lighting import (
    STEEL,
    density_cell,
    is_ground,
    particle_volume,
    sky_color,
    sun_color,
    sun_direction,
)
from neve.render.melt_water import Puddle, melt_water
from neve.render.path_tracing.lens import Lens
from neve.render.pools import as_solid, pool_of
from neve.render.shot import View, opening

if TYPE_CHECKING:
    from neve._core import HeightField
    from neve.colliders.solid import Solid
    from neve.geometry.pose import Pose
    from neve.geometry.sdf import SolidMesh
    from neve.scene.schema.scene import Scene


class Preview:
    """Draw frames of one scene with its camera and light.

    Snow is lit by the sun, with soft shadows through the snow's own density, by the sky, as far as the snow
    leaves it open, and by light that has wandered through thin parts. Every particle is drawn as a few
    grains at fixed places around it. The same input gives the same bytes for any number of threads.
    """

    def __init__(
        self,
        scene: Scene,
        width: int = 1280,
        height: int = 720,
        threads: int = 0,
        radius: float | None = None,
    ) -> None:
        """Prepare the camera and the light.

        scene: the scene; its numerics say how large a particle is, unless `radius` [m] does.
        width, height: of the picture [px].
        threads: at most this many; 0 means as many as OpenMP takes by itself.
        """
        light, numerics = scene.light, scene.numerics
        self.size = (width, height)
        self.threads = threads
        self.volume = particle_volume(numerics, radius)
        self.spacing = math.cbrt(self.volume)
        self.cell_size = density_cell(numerics, radius)
        self._meshes: dict[int, tuple[object, _render.Mesh]] = {}
        self._light = _render.Light(sun_direction(light), sun_color(light), sky_color(light))
        self._weather, self._open_for = light, scene.camera.shutter / scene.run.fps
        self._start = opening(scene.camera)
        self._view: View | None = None

    def draw(
        self,
        x: npt.NDArray[np.floating[Any]],
        solids: Sequence[tuple[Solid, Pose]],
        J_P: npt.NDArray[np.floating[Any]] | None = None,
        view: View | None = None,
        water: npt.NDArray[np.floating[Any]] | None = None,
        time: float = 0.0,
    ) -> npt.NDArray[np.uint8]:
        """Draw one frame.

        x: positions (n, 3) [m], of any float type and layout; particles that are not finite are left out.
        solids: colliders and bodies, and where they are. J_P: plastic volume ratio (n,) [1]; loosened snow
        is drawn looser. view: of the camera; without it that of the scene's at the start. water: share of
        each particle that is liquid (n,) [1]; wet snow is drawn darker, water that flies clear, and where it
        stands together as one surface. time: of the frame [s], for flakes that fall.
        Returns the picture (height, width, 3), sRGB.
        """
        painter = self._seen_from(view or self._start)
        places = np.ascontiguousarray(x, dtype=np.float32)
        ratio = np.ones(0, np.float32) if J_P is None else np.ascontiguousarray(J_P, dtype=np.float32)
        wet = np.zeros(0, np.float32)
        shown = [(solid, pose) for solid, pose in solids if solid.visible]
        puddles: list[_render.Puddle] = []
        pools: list[_render.Solid] = []
        melt = None if water is None else melt_water(shown, places, water, J_P, self.spacing)
        if melt is not None and water is not None:
            in_pool, pool = pool_of(places, water, self.spacing)
            own = ~melt.soaks
            kept = ~in_pool[melt.rows[own]]
            rows = melt.rows[own][kept]
            wet = melt.wetness(places, self.spacing)[kept]
            places, ratio = np.ascontiguousarray(places[rows]), ratio[rows] if len(ratio) else ratio
            puddles = [self._puddle(k, puddle) for k, puddle in melt.puddles.items()]
            pools = [as_solid(pool)] if pool else []
        drawn = [self._drawn(solid, pose) for solid, pose in shown] + pools
        picture: npt.NDArray[np.uint8] = painter.draw(
            places, ratio, self.volume, self.cell_size, drawn, self.threads, wet, puddles,
            self._falling(view or self._start, time),
        )  # fmt: skip
        return picture

    def _falling(self, view: View, time: float) -> npt.NDArray[np.float32]:
        """Return the flakes in the air, as long as the shutter is open."""
        light, lens = self._weather, Lens(view, *self.size)
        color = glow(sun_color(light), sky_color(light))
        return streaks(light, (lens, lens), time, self._open_for, color)

    def _puddle(self, number: int, puddle: Puddle) -> _render.Puddle:
        """Translate a puddle on solid `number` for the renderer."""
        u, v = (float(a) for a in puddle.origin)
        return _render.Puddle(number, (u, v), puddle.cell, puddle.wet)

    def _seen_from(self, view: View) -> _render.Painter:
        """Return who draws from `view`; he keeps what is the same in all frames, until the view changes."""
        if self._view != view:
            camera = _render.Camera(view.position, view.target, view.up, view.fov, *self.size)
            self._view, self._painter = view, _render.Painter(camera, self._light)
        return self._painter

    def _drawn(self, solid: Solid, pose: Pose) -> _render.Solid:
        """Translate a solid and its pose for the renderer."""
        x, y, z = (float(a) for a in pose.position)
        a, b, c = (float(h) for h in solid.half)
        return _render.Solid(
            solid.shape,
            (x, y, z),
            [float(r) for r in np.asarray(pose.rotation).ravel()],
            (a, b, c),
            solid.color or STEEL,
            "ground" if is_ground(solid) else solid.finish or "paint",
            self._mesh(solid) if solid.mesh or solid.terrain else None,
            is_static=solid.motion == "static",
        )

    def _mesh(self, solid: Solid) -> _render.Mesh:
        """Return the triangles of a mesh or terrain, made ready once for all frames and bodies of it."""
        what: HeightField | SolidMesh | None = solid.mesh or solid.terrain
        if id(what) not in self._meshes:
            if solid.mesh is not None:
                vertices = np.ascontiguousarray(solid.mesh.vertices, np.float64)
                mesh = _render.Mesh(vertices, np.ascontiguousarray(solid.mesh.faces, np.int32))
            elif solid.terrain is not None:
                across, along = (float(side) for side in solid.terrain.size)
                heights = np.ascontiguousarray(solid.terrain.heights, np.float32)
                mesh = _render.Mesh.terrain(heights, (across, along))
            else:
                raise ValueError(f"{solid.name} is a {solid.shape} without its surface")
            self._meshes[id(what)] = what, mesh
        return self._meshes[id(what)][1]
