"""Light and draw particles: the compiled part of `neve.render`.

Lengths in metres, z up. Colours are linear red, green, blue; 1 is bright sunlit snow. Arrays are read in C
order and copied: later changes do not show.
"""

import numpy as np
from numpy.typing import NDArray

Triple = tuple[float, float, float]

def surface_materials() -> tuple[str, ...]:
    """Return the words of what surfaces are made of."""

class Camera:
    """A pinhole camera. fov: vertical [degrees]; width, height [px], 1 to 16384."""

    def __init__(
        self, position: Triple, target: Triple, up: Triple, fov: float, width: int, height: int
    ) -> None:
        """Stand at position and look at target [m]. Errors: ValueError for another width or height."""
    def project(self, point: Triple) -> Triple:
        """Return column, row [px] and depth [m]; the middle of pixel (row 0, column 0) is (0.5, 0.5)."""

class Light:
    """Sun and sky. sun: direction towards it; colours: light on what faces the sun, on open level ground."""

    def __init__(self, sun: Triple, sun_color: Triple, sky_color: Triple) -> None:
        """Make a light; the length of `sun` does not count."""

class Mesh:
    """Triangles, ready to be drawn: closed or not, turned out or in.

    vertices (n, 3) [m]; faces (m, 3), rows of vertices.
    Errors: ValueError for a vertex that is not finite or not there, or no area at all.
    """

    def __init__(self, vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> None:
        """Copy the triangles and prepare them."""
    @staticmethod
    def terrain(heights: NDArray[np.float32], size: tuple[float, float]) -> Mesh:
        """Make the ground of heights (nx, ny) [m] over a rectangle (x, y) [m], and on to the horizon.

        Errors: ValueError for fewer than 2 heights a side, no size, or a height that is not finite.
        """

class Solid:
    """A collider or a body, drawn.

    shape: a word of `neve._core.geometry.shapes()`; position (x, y, z) [m]; rotation: local to world, nine
    numbers row by row; half: half extents along the shape's own axes [m]; mesh: the triangles of a mesh or
    terrain, for these shapes only; surface_material: a word of `surface_materials()`; is_static: it has the
    same place in every frame, which saves time.
    Errors: ValueError for an unknown word, a mesh that is missing or too many, or a rotation
    of other than nine numbers.
    """

    def __init__(
        self,
        shape: str,
        position: Triple,
        rotation: list[float],
        half: Triple,
        color: Triple,
        surface_material: str = "paint",
        mesh: Mesh | None = None,
        is_static: bool = False,
    ) -> None:
        """Place a solid; the mesh is shared, not copied."""

class Density:
    """Volume fraction of snow on a pyramid of sparse grids, each level twice as coarse as the one before.

    x (n, 3) [m]; volume: of one particle [m3]; cell_size: of level 0 [m].
    Levels are 0 to 5; ValueError for another one.
    """

    def __init__(self, x: NDArray[np.float32], volume: float, cell_size: float) -> None:
        """Spread the particles over the cells; those that are not finite are left out."""
    def total(self, level: int = 0) -> float:
        """Return the volume of the snow on a level [m3]."""

    def blocks(self, level: int = 0) -> int:
        """Return the number of blocks of 4x4x4 cells on a level."""

    def sample(self, x: NDArray[np.float32], level: int = 0) -> NDArray[np.float32]:
        """Return the volume fraction (n,) at the points (n, 3) [1]."""

    def sun(self, x: NDArray[np.float32], sun: Triple) -> NDArray[np.float32]:
        """Return the share (n,) of the sun that reaches the points (n, 3) through the snow [1]."""

    def sky(self, x: NDArray[np.float32], normal: Triple) -> NDArray[np.float32]:
        """Return the share (n,) of the open sky's light on a surface at the points (n, 3) [1]."""

    def buried(self, x: NDArray[np.float32], eye: Triple) -> NDArray[np.float32]:
        """Return (n,): 1 where snow hides the points (n, 3) from the `eye` [m], else 0."""

    def deep(self, x: NDArray[np.float32], eye: Triple) -> NDArray[np.float32]:
        """Return (n,): 1 where the block around a point says that it is buried; elsewhere it may be, 0."""

class Puddle:
    """Melt water that lies on a plane."""

    def __init__(
        self, solid: int, origin: tuple[float, float], cell: float, wet: NDArray[np.float32]
    ) -> None:
        """Keep a copy of `wet` (nu, nv), 0 dry to 1, at the middles of square cells.

        solid: number of the plane among those that are drawn; origin: corner of the first cell in the plane's
        own axes [m]; cell: their side [m].
        Errors: ValueError for a number below 0 or a side that is not above 0.
        """

class Painter:
    """Draw frames with the same camera and light. A frame depends on its own input only."""

    def __init__(self, camera: Camera, light: Light, leaf: int = 4) -> None:
        """Keep copies of camera and light. Threads of Python may share a painter: they draw in turn.

        leaf: solids that a leaf of the tree over them holds at most; pictures do not depend on it.
        """

    def draw(
        self,
        x: NDArray[np.float32],
        J_P: NDArray[np.float32],
        volume: float,
        cell_size: float,
        solids: list[Solid],
        threads: int,
        water: NDArray[np.float32],
        puddles: list[Puddle],
        falling: NDArray[np.float32],
    ) -> NDArray[np.uint8]:
        """Draw particles and solids; return the picture (height, width, 3), sRGB, the top row first.

        x (n, 3) [m], those that are not finite are left out; J_P (n,) or (0,) [1]; volume: of one particle
        [m3]; cell_size: of the density that light passes through [m]; threads: 0 leaves the choice to OpenMP;
        water: how wet each particle is, 1 a drop (n,), or (0,) [1]; puddles: water that lies on planes;
        falling: flakes in the air (m, 10), as of `veil`.
        Errors: ValueError for sizes that do not fit or are not above zero, or more than 1.6e7 solids.
        """

def veil(
    light: NDArray[np.float32], depth: NDArray[np.float32], streaks: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return the light (h, w, 3) of a picture over which flakes are drawn, in the order of their rows.

    depth (h, w): distance of what is seen [m], 0 for the sky; streaks (m, 10): columns at which a flake
    begins and ends, rows [px], radius [px], share of what is behind that it hides, distance [m], its light.
    Errors: ValueError for another shape.
    """

def spread(
    light: NDArray[np.float32],
    snow: NDArray[np.float32],
    depth: NDArray[np.float32],
    radius: NDArray[np.float32],
    taps: NDArray[np.float32],
    share: float,
    thick: float,
) -> NDArray[np.float32]:
    """Return the light (h, w, 3) of a picture after it has spread in its snow, over pixels of like depth.

    snow (h, w): share of each pixel; depth (h, w) [m]; radius (h, w) [px]: what `taps` (2, 3, n) is in units
    of, places right of a pixel and below it for red, green and blue; share: of light that spreads; thick [m].
    Errors: ValueError for other sizes.
    """
