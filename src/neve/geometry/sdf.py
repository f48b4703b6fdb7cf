"""Make the grid of signed distances that stands for a mesh, and keep it on disk for the next run."""

from __future__ import annotations

import hashlib
import math
import warnings
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.geometry import cache
from neve.geometry.mesh import read_mesh, warn_if_small
from neve.geometry.triangles import Triangles
from neve.reproducible import norms
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.schema.file_shapes import Mesh
from neve.system.memory import lacking

if TYPE_CHECKING:
    from neve._core import SdfGrid

Array = NDArray[np.float64]

FORMAT = 2
"""Version of what is kept in the cache; another one is never read."""
BAND_CELLS, BAND_SAMPLES = 1, 4
"""The distances are fine within so many cells of snow, and so many of their own spacings, of the surface."""
DEFAULT_BYTES = 256 * 2**20
"""Bytes that a grid may take whose `detail` is left out."""
MAX_BYTES = 4 * 2**30
"""Bytes that any grid may take: a mistyped detail must not fill the memory."""
BRICK_CELLS, BRICK_BYTES, NODE_BYTES = 8, 16 * 9**3, 16
RAYS = 2000
"""Faces through which the thickness of a solid is measured."""
THIN_SHARE = 0.05
"""Share of the surface that may lie on parts thinner than what the spacing resolves."""


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """Hold a solid of triangles in its own frame.

    Attributes:
        surface: the triangles, in metres
        thickness: of the solid around an open mesh; 0 for one that is filled [m]
        spacing: of the samples of the distance [m]
        band: how far from the surface they are fine [m]
        key: SHA-256 of all that the distances follow from
    """

    surface: Triangles
    thickness: float
    spacing: float
    band: float
    key: str

    @cached_property
    def sdf(self) -> SdfGrid:
        """Signed distance [m], negative inside, and unit normal at any point: made, or read from the cache
        folder, when it is first asked for."""
        return _grid(self.key, self.surface, self.spacing, self.band, self.thickness)

    @cached_property
    def reach(self) -> float:
        """Distance of the farthest point of the solid from its frame's origin [m]."""
        return float(norms(self.vertices).max()) + 0.5 * self.thickness

    @property
    def vertices(self) -> Array:
        """Corners of the triangles [m], (n, 3)."""
        return self.surface.vertices

    @property
    def faces(self) -> NDArray[np.int32]:
        """Rows of `vertices`, anticlockwise from outside, (m, 3)."""
        return self.surface.faces

    @property
    def usual_thickness(self) -> float:
        """Twice the volume over the area: the thickness of a plate, a third of a ball's diameter [m]."""
        return self.thickness or 2.0 * self.surface.tree.volume / self.surface.area


def solid_mesh(
    described: Mesh, dx: float, name: str, check: Callable[[Triangles], None] = lambda surface: None
) -> SolidMesh:
    """Return the solid in the file of `described`, as fine as a snow grid of spacing `dx` [m] asks for.

    `name`: used in messages. `check` may refuse the triangles. The distances to them, which take longest, are
    computed when they are first asked for. Warns with SceneWarning of small holes, of a solid smaller than
    two cells, and of a grid that had to be coarser than is usual.
    Errors: SceneError, one sentence; see `read_mesh`.
    """
    surface = read_mesh(described, name)
    check(surface)
    warn_if_small(surface, described, dx, name)
    spacing = _spacing(surface, described, dx, name)
    return of_triangles(surface, spacing, _band(spacing, dx), described.thickness)


def filled(surface: Triangles, dx: float) -> SolidMesh:
    """Return the solid inside a closed `surface`, as fine as a snow grid of spacing `dx` [m] asks for."""

    def needed(spacing: float) -> float:
        return grid_bytes(surface, spacing, _band(spacing, dx))

    spacing = _affordable(_preferred_spacing(thinnest(surface), dx), needed, DEFAULT_BYTES)
    return of_triangles(surface, spacing, _band(spacing, dx))


def of_triangles(surface: Triangles, spacing: float, band: float, thickness: float = 0.0) -> SolidMesh:
    """Return the solid inside `surface`, or around it if it has a `thickness` [m].

    spacing: of the samples of the distance [m]; band: how far from the surface they reach [m]. Equal
    arguments give the same solid as long as it is in use, and its grid from the cache folder later.
    """
    key = _key(surface, spacing, band, thickness)
    known = _in_use.get(key)
    if known is None:
        _in_use[key] = known = SolidMesh(surface, thickness, spacing, band, key)
    return known


_in_use: weakref.WeakValueDictionary[str, SolidMesh] = weakref.WeakValueDictionary()


def _grid(key: str, surface: Triangles, spacing: float, band: float, thickness: float) -> SdfGrid:
    geometry = _core.geometry
    kept = cache.recall(key)
    if kept is not None:
        try:
            return geometry.SdfGrid.from_arrays(kept)
        except (ValueError, KeyError, RuntimeError, TypeError):  # of another make: made again
            pass
    grid = geometry.SdfGrid.build(surface.tree, spacing, band, thickness)
    cache.keep(key, grid.arrays())
    return grid


def _key(surface: Triangles, spacing: float, band: float, thickness: float) -> str:
    """Return the SHA-256 of all that the grid follows from."""
    if surface not in _digests:
        _digests[surface] = _fed(
            hashlib.sha256(f"neve sdf {FORMAT}".encode()), surface.vertices, surface.faces
        )
    whole = _fed(_digests[surface].copy(), np.array([spacing, band, thickness]))
    return str(whole.hexdigest())


_digests: weakref.WeakKeyDictionary[Triangles, Any] = weakref.WeakKeyDictionary()


def _fed(digest: Any, *arrays: NDArray[Any]) -> Any:
    for values in arrays:
        digest.update(f"{values.dtype}{values.shape}".encode())
        digest.update(np.ascontiguousarray(values).data)
    return digest


def grid_bytes(surface: Triangles, spacing: float, band: float, thickness: float = 0.0) -> float:
    """Return about how many bytes the grid of distances takes.

    A sheet of area A and thickness t touches A (t + w) / b^3 cubes of edge b laid at random, with w = 1.5 b
    the mean width of a cube over all directions (Cauchy's formula). A face that is longer than b but not
    wide is a line of length l to the cubes and touches l (t + w)^2 / b^3; each face of a spike is counted.
    """
    edge = BRICK_CELLS * spacing
    wide = 2 * band + thickness + 1.5 * edge
    longest, across = surface.spans
    lines = float(longest[(longest > edge) & (across < edge)].sum())
    bricks = (surface.area * wide + lines * wide**2) / edge**3
    size = surface.high - surface.low + 2 * band + thickness
    return bricks * BRICK_BYTES + float(np.prod(size / edge + 2)) * NODE_BYTES


def _spacing(surface: Triangles, described: Mesh, dx: float, name: str) -> float:
    """Return the spacing of the samples [m]: `detail`, or half a cell, less for thin parts, if affordable."""

    def needed(spacing: float) -> float:
        return grid_bytes(surface, spacing, _band(spacing, dx), described.thickness)

    if described.detail is not None:
        if needed(described.detail) > MAX_BYTES:
            least = _affordable(described.detail, needed, MAX_BYTES)
            raise SceneError(
                f"{name}.detail = {described.detail:g} would take {needed(described.detail) / 2**30:.2g} GB: "
                f"use at least {least:.2g}"
            )
        _require_memory(needed(described.detail), f"{name}.detail = {described.detail:g}")
        return described.detail
    preferred = _preferred_spacing(described.thickness or thinnest(surface), dx)
    spacing = _affordable(preferred, needed, DEFAULT_BYTES)
    if spacing > preferred:
        warnings.warn(
            f"{name}.detail is {spacing:.2g} m, because {preferred:.2g} m would take "
            f"{needed(preferred) / 2**20:.0f} MB for this mesh: set it yourself, or scale the mesh down",
            SceneWarning,
            stacklevel=2,
        )
    _require_memory(needed(spacing), f"{name}.file")
    return spacing


def _require_memory(size: float, what: str) -> None:
    if found := lacking(size):
        raise SceneError(f"{what} {found}: set a larger detail, or scale the mesh down")


def _band(spacing: float, dx: float) -> float:
    """Return how far from the surface distances are fine [m]; beyond, they are eight times as far apart."""
    return max(BAND_CELLS * dx, BAND_SAMPLES * spacing)


def _preferred_spacing(thin: float, dx: float) -> float:
    """Return half a cell of `dx` [m], or half of what the solid is `thin`, at least an eighth of a cell."""
    return min(0.5 * dx, max(0.5 * thin, 0.125 * dx))


def _affordable(spacing: float, needed: Callable[[float], float], most: float) -> float:
    """Return the least spacing [m], `spacing` times a power of 1.1, that needs at most `most` bytes."""
    while needed(spacing) > most:
        spacing *= 1.1
    return spacing


def thinnest(surface: Triangles) -> float:
    """Return a length [m] below which at most about THIN_SHARE of the closed surface's area is thick.

    From points on the surface rays go inward; the thickness is their way to the next face.
    """
    if surface not in _thin:
        _thin[surface] = _thinnest(surface)
    return _thin[surface]


_thin: weakref.WeakKeyDictionary[Triangles, float] = weakref.WeakKeyDictionary()


def _thinnest(surface: Triangles) -> float:
    area = norms(surface.area_vectors)
    rng = np.random.default_rng(0)
    chosen = rng.choice(len(area), RAYS, p=area / area.sum())
    u, v = rng.random((2, RAYS, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = (surface.vertices[surface.faces[chosen, k]] for k in range(3))
    inward = -surface.area_vectors[chosen] / area[chosen, None]
    start = 1e-5 * float((surface.high - surface.low).max())
    origins = a + u * (b - a) + v * (c - a) + start * inward
    t, _ = surface.tree.ray(np.ascontiguousarray(origins), np.ascontiguousarray(inward))
    t = np.where(np.isfinite(t) & (t >= 0), t + start, math.inf)
    return float(np.quantile(t, THIN_SHARE, method="lower"))
