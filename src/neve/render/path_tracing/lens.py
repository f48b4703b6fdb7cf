"""The camera of a picture: where rays go, and where points appear."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.render.path_tracing.daylight import FAR

if TYPE_CHECKING:
    from neve.render.shot import View
    from neve.scene.schema.camera import Camera

Array = NDArray[np.float64]
STILL = 2e-5
"""Way by which a camera moves at most while it stands still, in distances to its target."""


@dataclass(frozen=True)
class Lens:
    """Hold the view of a camera and the size of its picture [px]; aperture: radius of the lens [m].

    An aperture of 0 is that of a pinhole. focus: distance of what is sharp [m], None for the target's.
    """

    camera: View | Camera
    width: int
    height: int
    aperture: float = 0.0
    focus: float | None = None

    @property
    def eye(self) -> Array:
        """Where it stands [m], (3,)."""
        return np.asarray(self.camera.position, np.float64)

    @property
    def axes(self) -> tuple[Array, Array, Array]:
        """Unit vectors right, up and forward of the picture."""
        forward = np.asarray(self.camera.target, np.float64) - self.eye
        self_distance = np.linalg.norm(forward)
        forward = forward / self_distance
        right = np.cross(forward, np.asarray(self.camera.up, np.float64))
        right /= np.linalg.norm(right)
        return right, np.cross(right, forward), forward

    @property
    def focal(self) -> float:
        """Focal length [px]: a pixel at distance d is d / focal wide."""
        return 0.5 * self.height / math.tan(math.radians(0.5 * self.camera.fov))

    @property
    def distance(self) -> float:
        """From the camera to its target [m]."""
        return float(np.linalg.norm(np.asarray(self.camera.target) - self.eye))

    @property
    def pixel(self) -> float:
        """Footprint of a pixel at the target [m]."""
        return self.distance / self.focal

    @property
    def seed(self) -> int:
        """The seed of the paths of light: the same in every frame while the camera stands still.

        What stands still is then lit by the same paths in all frames, and its noise does not boil; noise on
        snow that moves by a pixel is another one in each frame anyhow. Where the camera moves, noise that
        stays in its place in the picture would look like dirt on the lens. A camera that moves by less than
        some hundredth of a pixel stands still.
        """
        camera, step = self.camera, STILL * max(self.distance, 1e-9)
        place = np.rint(np.divide([*camera.position, *camera.target], step)).tolist()
        place += [*np.round(camera.up, 4).tolist(), round(camera.fov, 3)]
        return zlib.crc32(repr(place).encode()) & 0xFFFFFF

    def project(self, x: NDArray[Any]) -> tuple[Array, Array, Array]:
        """Return column, row [px] and depth [m] of points (n, 3); pixel 0, 0 has its middle at 1/2, 1/2."""
        right, up, forward = self.axes
        d = np.asarray(x, np.float64) - self.eye
        depth = d @ forward
        scale = self.focal / np.where(depth > 1e-9, depth, np.inf)
        return 0.5 * self.width + (d @ right) * scale, 0.5 * self.height - (d @ up) * scale, depth

    def sensor(self, mi: Any, film: dict[str, Any], samples: int, seed: int) -> dict[str, Any]:
        """Return the sensor of Mitsuba."""
        transform = mi.ScalarTransform4f().look_at(
            [*map(float, self.camera.position)],
            [*map(float, self.camera.target)],
            [*map(float, self.camera.up)],
        )
        out = {
            "type": "thinlens" if self.aperture else "perspective",
            "fov": float(self.camera.fov),
            "fov_axis": "y",
            "near_clip": 1e-3 * self.distance,
            "far_clip": FAR,
            "to_world": transform,
            "film": film,
            "sampler": sampler(samples, seed),
        }
        if self.aperture:
            out |= {"aperture_radius": self.aperture, "focus_distance": self.focus or self.distance}
        return out


def sampler(samples: int, seed: int) -> dict[str, Any]:
    """Return the random numbers of `samples` paths a pixel.

    They are spread evenly (Kensler 2013: correlated multi-jittered) where the number fits on the grid that
    Mitsuba lays out, of floor(sqrt(n)) rows.
    """
    even = samples % math.isqrt(samples) == 0
    return {"type": "multijitter" if even else "independent", "sample_count": samples, "seed": seed}
