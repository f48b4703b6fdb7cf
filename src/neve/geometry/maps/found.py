"""What a file of heights says, and the checks that all its readers share."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.scene.errors import SceneError
from neve.system.memory import lacking

Array = NDArray[np.float64]

MAX_SAMPLES = 2**27
"""Samples that a map may have."""
SAMPLE_BYTES = 40
"""Memory for each sample while a map is read [bytes]: the file's own, real numbers, and those scaled."""
NO_METRES = "does not say how many metres a pixel is"
"""Why a map has no size of its own, if nothing better is known."""
EARTH, FLATTENING = 6378137.0, 1.0 / 298.257223563
"""Equatorial radius [m] and flattening of the ellipsoid WGS 84 (NIMA TR8350.2, table 3.1 [M])."""


@dataclass(frozen=True)
class Place:
    """Say where the samples of a map lie in its coordinate system.

    Attributes:
        matrix: the middle of sample (i, j) of `Map.values` is at matrix @ (i, j, 1), (2, 3), x to the east
            and y to the north [m], or longitude and latitude [degrees]
        system: EPSG code of the system; 0 if the file states none
    """

    matrix: Array
    system: int = 0


@dataclass(frozen=True)
class Map:
    """Hold what a file says of the ground.

    Attributes:
        values: numbers of the file [x, y], x to the east and y to the north; NaN where they are missing
        full: the full range of whole numbers of 8 or 16 bits; None for longer and for real ones
        pixel: distance of neighbours along x and y [m]; None if the file does not say
        unit: of the numbers, as far as the file says [m]
        turn: from the east to the x axis of the map, anticlockwise [degrees]
        no_size: end of the sentence that says why there is no `pixel`
        doubts: ends of sentences about the file to warn of
        place: in a coordinate system; None if the file does not say
    """

    values: Array
    full: float | None
    pixel: tuple[float, float] | None = None
    unit: float = 1.0
    turn: float = 0.0
    no_size: str = NO_METRES
    doubts: tuple[str, ...] = ()
    place: Place | None = None


def full_range(bits: int) -> float | None:
    """Return the full range of whole numbers of 8 or 16 bits; longer ones count as real numbers."""
    return 2.0**bits - 1.0 if bits <= 16 else None


def require_size(count: int, what: str, key: str) -> None:
    """Refuse more samples than are allowed, or than there is memory for.

    Errors: SceneError, one sentence.
    """
    if count > MAX_SAMPLES:
        raise SceneError(f"{key} has {count:.3g} {what}, more than {MAX_SAMPLES:.3g}: use a smaller map")
    if found := lacking(SAMPLE_BYTES * count):
        raise SceneError(f"{key} {found}: use a smaller map")


def unreadable(key: str, error: Exception) -> SceneError:
    """Return the sentence about a file that its reader stumbles over."""
    if isinstance(error, OSError) and error.errno and error.strerror:
        return SceneError(f"{key} cannot be read: {error.strerror[:1].lower()}{error.strerror[1:]}")
    return SceneError(f"{key} cannot be read: it is damaged, or not the kind of file that its name says")


def degree(latitude: float) -> tuple[float, float]:
    """Return the length of a degree of longitude and of latitude [m] at `latitude` [degrees].

    N cos(phi) pi / 180 and M pi / 180, with N = a / w, M = a (1 - e^2) / w^3, w^2 = 1 - e^2 sin^2(phi)
    (radii of curvature of an ellipsoid; Snyder 1987, equations 4-18 to 4-20 [M]).
    """
    squared = FLATTENING * (2.0 - FLATTENING)
    phi = math.radians(latitude)
    w = math.sqrt(1.0 - squared * math.sin(phi) ** 2)
    return (
        math.radians(EARTH / w * math.cos(phi)),
        math.radians(EARTH * (1.0 - squared) / w**3),
    )


def in_degrees(latitude: float | None, step: tuple[float, float], shape: tuple[int, int]) -> str:
    """Say that the pixels of a map are degrees, and which size that makes at `latitude` [degrees].

    step: of a pixel along x and y [degrees]; shape: samples along x and y.
    """
    if latitude is None or not abs(latitude) < 90.0:
        return "measures its pixels in degrees"
    size = [length * d * (n - 1) for length, d, n in zip(degree(latitude), step, shape, strict=True)]
    return (
        f"measures its pixels in degrees: at its latitude of {latitude:.4g} degrees it is {size[0]:.6g} m "
        f"by {size[1]:.6g} m, so set size = [{size[0]:.6g}, {size[1]:.6g}]"
    )
