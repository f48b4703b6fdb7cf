"""Draw a frame of a scene: snow in the sun, its ground and its colliders. Needs no GPU and no display."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

import neve._render as _render

if TYPE_CHECKING:
    from neve._core import HeightField
    from neve.colliders.solid import Solid
    from neve.geometry.pose import Pose
    from neve.geometry.sdf import SolidMesh
    from neve.scene.schema.scene import Scene

# Paint of a collider without a colour of its own: grey-blue steel.
STEEL = (0.20, 0.23, 0.27)
# What a strength of one means: light on a surface that faces the sun, and on open level ground, in the
# units in which the film's curve shows 1 as bright sunlit snow.
SUN = 1.9
SKY = 0.5


class Preview:
    """Draw frames of one scene with its camera and light.

    Snow is lit by the sun, with soft shadows through the snow's own density, by the sky, as far as the snow
    leaves it open, and by light that has wandered through thin parts. Every particle is drawn as a few
    grains at fixed places around it. The same input gives the same bytes for any number of threads.
    """

    def __init__(self, scene: Scene, width: int = 1280, height: int = 720, threads: int = 0) -> None:
        """Prepare the camera and the light.

        scene: the scene; its numerics say how large a particle is. width, height: of the picture [px].
        threads: at most this many; 0 means as many as OpenMP takes by itself.
        """
        camera, light, numerics = scene.camera, scene.light, scene.numerics
        self.size = (width, height)
        self.threads = threads
        self.volume = numerics.dx**3 / numerics.particles_per_cell
        # Fine enough for shadows of clods, coarse enough that solid snow has no holes.
        self.cell_size = max(0.75 * numerics.dx, 1.5 * self.volume ** (1 / 3))
        elevation, azimuth = math.radians(light.sun_elevation), math.radians(light.sun_azimuth)
        sun = (
            math.cos(elevation) * math.cos(azimuth),
            math.cos(elevation) * math.sin(azimuth),
            math.sin(elevation),
        )
        self._meshes: dict[int, tuple[object, _render.Mesh]] = {}
        self._painter = _render.Painter(
            _render.Camera(camera.position, camera.target, camera.up, camera.fov, width, height),
            _render.Light(
                sun,
                _scaled(light.sun_color, SUN * light.sun_strength),
                _scaled(light.sky_color, SKY * light.sky_strength),
            ),
        )

    def draw(
        self,
        x: npt.NDArray[np.floating[Any]],
        bodies: Sequence[tuple[Solid, Pose]],
        J_P: npt.NDArray[np.floating[Any]] | None = None,
    ) -> npt.NDArray[np.uint8]:
        """Draw one frame.

        x: positions (n, 3) [m], of any float type and layout; particles that are not finite are left out.
        bodies: solids and where they are. J_P: plastic volume ratio (n,) [1]; loosened snow is drawn
        looser.
        Returns the picture (height, width, 3), sRGB.
        """
        places = np.ascontiguousarray(x, dtype=np.float32)
        ratio = np.ones(0, np.float32) if J_P is None else np.ascontiguousarray(J_P, dtype=np.float32)
        drawn = [self._body(solid, pose) for solid, pose in bodies if solid.visible]
        picture: npt.NDArray[np.uint8] = self._painter.draw(
            places, ratio, self.volume, self.cell_size, drawn, self.threads
        )
        return picture

    def _body(self, solid: Solid, pose: Pose) -> _render.Body:
        """Translate a solid and its pose for the renderer."""
        ground = solid.shape in ("plane", "terrain") and solid.color is None and solid.finish is None
        x, y, z = (float(a) for a in pose.position)
        a, b, c = (float(h) for h in solid.half)
        rotation = [float(r) for r in np.asarray(pose.rotation).ravel()]
        stuff = "ground" if ground else solid.finish or "paint"
        color = solid.color or STEEL
        mesh = self._mesh(solid) if solid.shape in ("mesh", "terrain") else None
        return _render.Body(
            "mesh" if mesh else solid.shape,
            (x, y, z),
            rotation,
            (a, b, c),
            color,
            stuff,
            mesh,
            rest=solid.moved_by == "rest",
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


def _scaled(color: tuple[float, float, float], factor: float) -> tuple[float, float, float]:
    return (color[0] * factor, color[1] * factor, color[2] * factor)
