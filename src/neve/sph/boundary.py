"""Surfaces of solids as particles, near the snow (Akinci et al. 2012)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve.build import add_solid
from neve.colliders.solid import Solid
from neve.geometry.pose import Pose
from neve.reproducible import product
from neve.scene.errors import SceneError

if TYPE_CHECKING:
    from neve._core import Model as CoreModel

Array = NDArray[np.float64]

EDGE = 6
"""Edge of a block of the lattice, in distances of particles: the reach of snow (2), of the volumes of
boundary particles (2), how far these are moved from their lattice (1/2), and what snow may move before the
blocks are looked for anew (1)."""
PLAY = 1.0
"""That distance, in distances of particles."""
TURNS = 3
"""Steps of projection to a surface."""
HALVINGS = 10
"""Of an edge of the lattice, to find where it meets a wall."""
REACH = 2**19
"""Spacings from the middle of a solid to its surface near snow, at most; cells are numbered twice as far."""


class Boundary:
    """Sample the surfaces of solids with particles where snow is near.

    A lattice in the frame of each solid has one particle for each of its points that lies within half a
    spacing of the surface `depth` below the solid's own, moved onto that surface. So particles are as many on
    an area as on that of a lattice, however it is turned; where they are closer, their volumes are smaller.
    The same blocks of the lattice give the same particles, whenever they are sampled.

    The signed distance of a terrain is measured from the heights below and above, so that beside a step it
    says nothing of the wall. There each edge of the lattice that passes from well outside to well inside has
    a particle, `depth` behind the wall.

    native: a model of its own in double precision, to which the solids are added, each in its own frame;
    spacing: distance of the snow's particles [m].
    """

    def __init__(self, native: CoreModel, solids: Sequence[Solid], spacing: float) -> None:
        self._native = native
        self._spacing = spacing
        self._edge = EDGE * spacing
        self._names = [solid.name for solid in solids]
        self._has_steps = [solid.terrain is not None for solid in solids]
        self._depths = [min(0.5 * spacing, 0.25 * _thickness(solid)) for solid in solids]
        for i, solid in enumerate(solids):
            add_solid(native, solid)
            native.place_solid(i, np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))
        self._known: list[dict[tuple[int, int, int], tuple[Array, Array]]] = [{} for _ in solids]

    def near(self, x: Array, poses: Sequence[Pose]) -> tuple[Array, Array, NDArray[np.int32]]:
        """Return the particles near snow at x (n, 3) [m]: points (k, 3) [m] and outward normals (k, 3) in the
        frames of their solids, and which solid each is of, (k,).

        In the order of the solids, their blocks, and the points of a block. poses: of the solids.

        Errors: SceneError for a surface that is more than REACH spacings from the middle of its solid.
        """
        points, normals, owners = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros(0, dtype=np.int32)]
        for i, pose in enumerate(poses):
            for block in self._blocks(i, x, pose):
                at, normal = self._known[i][block]
                points.append(at)
                normals.append(normal)
                owners.append(np.full(len(at), i, dtype=np.int32))
        return np.concatenate(points), np.concatenate(normals), np.concatenate(owners)

    def _blocks(self, i: int, x: Array, pose: Pose) -> list[tuple[int, int, int]]:
        """Return the blocks around snow at x in the lattice of solid i, in order; sample those not known."""
        local = product(x - pose.position, np.asarray(pose.rotation))
        there = np.unique(np.floor(local / self._edge).astype(np.int64), axis=0)
        steps = np.stack(np.meshgrid(*[(-1, 0, 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        around = np.unique((there[:, None, :] + steps).reshape(-1, 3), axis=0)
        phi, _ = self._native.surface(i, np.ascontiguousarray((around + 0.5) * self._edge))
        close = np.abs(phi) <= 1.1 * self._edge  # half of a block's diagonal is 0.87 of its edge
        if self._has_steps[i]:
            close |= self._parted(i, around)
        blocks = [(int(a), int(b), int(c)) for a, b, c in around[close]]
        fresh = [block for block in blocks if block not in self._known[i]]
        if fresh:
            self._sample(i, fresh)
        return blocks

    def _require_near(self, i: int, at: Array) -> None:
        """Refuse points of solid i that are too far from its middle to be numbered. Errors: SceneError."""
        far, most = float(np.abs(at).max(initial=0.0)), REACH * self._spacing
        if far > most:
            raise SceneError(
                f"{self._names[i]} meets snow {far:.3g} m from its own middle; with this numerics.dx and "
                f"numerics.method = 'sph' that may be {most:.3g} m: put its middle nearer to the snow"
            )

    def _sample(self, i: int, blocks: list[tuple[int, int, int]]) -> None:
        """Find the particles of `blocks` of the lattice of solid i."""
        x, owner = self._lattice(blocks, EDGE)
        depth = self._depths[i]
        phi, _ = self._native.surface(i, x)
        level = phi + depth
        keep = (level > -0.5 * self._spacing) & (level <= 0.5 * self._spacing)
        x, owner = np.ascontiguousarray(x[keep]), owner[keep]
        normal = np.zeros((0, 3))
        for _ in range(TURNS):
            phi, normal = self._native.surface(i, x)
            x = x - (phi + depth)[:, None] * normal
        if self._has_steps[i]:
            parts = zip((x, normal, owner), self._on_steps(i, blocks), strict=True)
            x, normal, owner = (np.concatenate(part) for part in parts)
        self._require_near(i, x)
        for k, block in enumerate(blocks):
            self._known[i][block] = (x[owner == k], normal[owner == k])

    def _lattice(self, blocks: Sequence[tuple[int, int, int]], count: int) -> tuple[Array, NDArray[np.int64]]:
        """Return `count` points a side from the first of each block on (n, 3), and the block of each (n,)."""
        step = (np.arange(count) + 0.5) * self._spacing
        cells = np.stack(np.meshgrid(step, step, step, indexing="ij"), axis=-1).reshape(-1, 3)
        corners = np.array(blocks, dtype=np.float64) * self._edge
        x = (corners[:, None, :] + cells).reshape(-1, 3)
        return x, np.repeat(np.arange(len(blocks)), len(cells))

    def _parted(self, i: int, blocks: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Tell of which blocks, and one spacing around them, some corners are inside solid i and some not."""
        corners = np.stack(np.meshgrid(*[(0.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        wide = corners * (self._edge + 2.0 * self._spacing) - self._spacing
        x = (blocks[:, None, :] * self._edge + wide).reshape(-1, 3)
        inside = (self._native.surface(i, np.ascontiguousarray(x))[0] < 0.0).reshape(len(blocks), -1)
        parted: NDArray[np.bool_] = inside.min(axis=1) != inside.max(axis=1)
        return parted

    def _on_steps(
        self, i: int, blocks: Sequence[tuple[int, int, int]]
    ) -> tuple[Array, Array, NDArray[np.int64]]:
        """Return the particles behind steps of solid i: points (k, 3), normals (k, 3), and blocks (k,).

        On each edge of the lattice, from a point of a block to the next along an axis, whose ends are on both
        sides and neither within half a spacing of where other particles are: none is, beside a wall.
        """
        x, owner = self._lattice(blocks, EDGE + 1)
        level = (self._native.surface(i, x)[0] + self._depths[i]).reshape((len(blocks), *(EDGE + 1,) * 3))
        at, found = x.reshape((*level.shape, 3)), []
        for axis in range(3):
            ends = [[slice(None), *[slice(0, EDGE)] * 3] for _ in range(2)]
            ends[1][1 + axis] = slice(1, EDGE + 1)
            one, other = (level[tuple(end)] for end in ends)
            apart = np.minimum(np.abs(one), np.abs(other)) > 0.5 * self._spacing
            crosses = ((one > 0.0) != (other > 0.0)) & apart
            sides = [at[tuple(end)][crosses] for end in ends]
            outer = np.where((one > 0.0)[crosses][:, None], *sides)
            inner = np.where((one > 0.0)[crosses][:, None], *sides[::-1])
            found.append((*self._behind(i, outer, inner), np.nonzero(crosses)[0]))
        x, normal, owner = (np.concatenate(part) for part in zip(*found, strict=True))
        return x, normal, owner

    def _behind(self, i: int, outer: Array, inner: Array) -> tuple[Array, Array]:
        """Return points (k, 3) `depth` inside where the edges from `outer` to `inner` meet solid i, and the
        outward directions (k, 3).
        """
        out = (outer - inner) / self._spacing
        for _ in range(HALVINGS):
            middle = 0.5 * (outer + inner)
            inside = (self._native.surface(i, np.ascontiguousarray(middle))[0] < 0.0)[:, None]
            outer, inner = np.where(inside, outer, middle), np.where(inside, middle, inner)
        return inner - self._depths[i] * out, out


def _thickness(solid: Solid) -> float:
    """Return about how far opposite sides of a solid are apart [m]."""
    if solid.mesh:
        return float(solid.mesh.usual_thickness)
    return np.inf if solid.endless else 2.0 * float(np.min(solid.half[solid.half > 0], initial=np.inf))
