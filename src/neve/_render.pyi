"""Light and draw particles: the compiled part of `neve.render`."""

import numpy as np
from numpy.typing import NDArray

Triple = tuple[float, float, float]

class Camera:
    """A pinhole camera. fov: vertical [degrees]; width, height [px]."""

    def __init__(
        self, position: Triple, target: Triple, up: Triple, fov: float, width: int, height: int
    ) -> None: ...
    def project(self, point: Triple) -> Triple:
        """Return column, row [px] and depth [m]."""

class Light:
    """Sun and sky. sun: direction towards it; colours: light on what faces the sun, on open ground."""

    def __init__(self, sun: Triple, sun_color: Triple, sky_color: Triple) -> None: ...

class Mesh:
    """Triangles, ready to be drawn: closed or not, turned out or in."""

    def __init__(self, vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> None: ...
    @staticmethod
    def terrain(heights: NDArray[np.float32], size: tuple[float, float]) -> Mesh:
        """Make the ground of heights (nx, ny) [m] over a rectangle, and on to the horizon."""

class Body:
    """A collider, drawn.

    rotation: nine numbers, row by row; half: its half extents [m]; mesh: for the shape "mesh".
    stuff: ground, paint, metal, rubber, wood or stone. rest: it is there in every frame, which saves time.
    """

    def __init__(
        self,
        shape: str,
        position: Triple,
        rotation: list[float],
        half: Triple,
        color: Triple,
        stuff: str = "paint",
        mesh: Mesh | None = None,
        rest: bool = False,
    ) -> None: ...

class Density:
    """Volume fraction of snow on a pyramid of sparse grids. volume: of one particle [m3]; cell_size [m]."""

    def __init__(self, x: NDArray[np.float32], volume: float, cell_size: float) -> None: ...
    def total(self, level: int = 0) -> float:
        """Volume of the snow on a level [m3]."""

    def blocks(self, level: int = 0) -> int:
        """Blocks of 4x4x4 cells on a level."""

    def sample(self, x: NDArray[np.float32], level: int = 0) -> NDArray[np.float32]:
        """Volume fraction at the points [1]."""

    def sun(self, x: NDArray[np.float32], sun: Triple) -> NDArray[np.float32]:
        """Share of the sun that reaches the points through the snow [1]."""

    def sky(self, x: NDArray[np.float32], normal: Triple) -> NDArray[np.float32]:
        """Share of the open sky's light on a surface at the points [1]."""

class Painter:
    """Draw one frame after the other with the same camera and light."""

    def __init__(self, camera: Camera, light: Light) -> None: ...
    def draw(
        self,
        x: NDArray[np.float32],
        J_P: NDArray[np.float32],
        volume: float,
        cell_size: float,
        bodies: list[Body],
        threads: int = 0,
    ) -> NDArray[np.uint8]:
        """Draw particles and bodies; return height x width x 3 bytes."""
