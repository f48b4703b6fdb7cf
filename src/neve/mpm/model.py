"""Model: the constants of one run, and the solids in their place at an instant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.backend import Cpu, backend
from neve.colliders.motion import pose
from neve.colliders.solid import Solid
from neve.cuda.errors import DeviceError
from neve.geometry.pose import Pose
from neve.rigid.coupled_bodies import CoupledBodies
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Collider, Numerics, Snow, World
from neve.scene.values.choices import TRANSFERS
from neve.scene.values.elastic import p_wave_modulus

if TYPE_CHECKING:
    from neve._core import Model as CoreModel
    from neve._core import Precision


class Model:
    """Hold the material table, the solids, gravity and dx of one run, in the core's precision.

    `core` is the set of compiled stages (float32 or float64), `native` the core's own model; `courant` the
    largest stable c dt / dx.
    """

    def __init__(
        self,
        world: World,
        numerics: Numerics,
        snows: Sequence[Snow],
        colliders: Sequence[Collider],
        solids: Sequence[Solid],
        rigid: CoupledBodies | None = None,
    ) -> None:
        self.core = _stages(numerics, any(solid.motion == "dynamic" for solid in solids))
        self.numerics = numerics
        self.snows = tuple(snows)
        self.colliders = tuple(colliders)
        self.solids = tuple(solids)
        self.rigid = rigid
        self.solid_speed = 0.0
        self.native = self.core.Model(
            numerics.dx,
            numerics.spline,
            numerics.transfer,
            numerics.flip_alpha,
            np.array(world.gravity, dtype=np.float64),
            numerics.polypic_modes,
            _damping(numerics, self.snows),
        )
        self.courant = stable_courant(self.native.stencil_stiffness, max(snow.nu for snow in self.snows))
        for snow in self.snows:
            self.native.add_snow(snow.law, snow.plasticity, _constants(snow))
        for solid in self.solids:
            _add(self.native, solid)
        for i, solid in enumerate(self.solids):
            if solid.motion == "dynamic":
                self.native.make_dynamic(i)
        self._reach = np.array([solid.reach for solid in self.solids])
        self._centres = np.zeros((len(self.solids), 3))
        self.limit_compression(1.0)
        for i, collider in enumerate(self.colliders):
            self._place(i, pose(collider, 0.0))
        self.place_solids(0.0)

    def distance(self, i: int, x: NDArray[np.float64]) -> NDArray[Any]:
        """Return the signed distance of points x (n, 3) [m] from the surface of solid i, (n,) [m]."""
        phi, _ = self.native.surface(i, np.ascontiguousarray(x))
        return phi

    def near(self, low: NDArray[np.float64], high: NDArray[np.float64]) -> list[int]:
        """Return which solids may reach into the box from `low` to `high` [m] (3,), and some near."""
        gap = np.maximum(np.maximum(low - self._centres, self._centres - high), 0.0)
        return np.flatnonzero(np.sum(gap * gap, axis=1) <= (self._reach + self.numerics.dx) ** 2).tolist()

    def poses(self, time: float) -> list[Pose]:
        """Return the pose of each solid at `time` [s]."""
        scripted = [pose(collider, time) for collider in self.colliders]
        return scripted + (self.rigid.poses() if self.rigid else [])

    def place_solids(self, time: float) -> None:
        """Put what moves where its script has it at `time` [s], and every rigid body where it is.

        Sets `solid_speed`, a bound on the speed of their surfaces [m/s].
        """
        self.solid_speed = 0.0
        for i, collider in enumerate(self.colliders):
            if self.solids[i].motion != "static":
                self._place(i, pose(collider, time))
        if self.rigid:
            for i, p in enumerate(self.rigid.poses(), len(self.colliders)):
                self._place(i, p)
            self.native.set_body_dynamics(self.rigid.mobility(), self.rigid.free_acceleration())

    def _place(self, i: int, p: Pose) -> None:
        self._centres[i] = p.position
        self.native.place_solid(i, p.position, np.ascontiguousarray(p.rotation), p.velocity, p.omega)
        self.solid_speed = max(self.solid_speed, _fastest(self.solids[i], p))

    def limit_compression(self, strongest: float) -> None:
        """Set `max_compression`: how far a step may press snow, -dt tr grad v [1], before hardening stores
        more than its work, as the laws say. `strongest`: the largest factor on the thresholds of any
        particle [1].
        """
        self.max_compression = self.native.max_compression(strongest)

    @property
    def solids_move(self) -> bool:
        """Whether any solid changes its place in time."""
        return any(solid.motion != "static" for solid in self.solids)


def _stages(numerics: Numerics, bodies: bool) -> Precision:
    """Return the compiled stages of the scene's device.

    bodies: whether the snow moves some of the solids. Errors: SceneError if the device cannot do it.
    """
    on = backend(numerics.device)
    if bodies and not on.moves_bodies:
        if numerics.device != "auto":
            raise SceneError(
                f'numerics.device = "{numerics.device}" moves no bodies and robots yet: use "cpu"'
            )
        on = Cpu()
    try:
        return on.kernels(numerics.precision)
    except DeviceError as error:
        raise SceneError(str(error)) from None


def stable_courant(stiffness: float, nu: float) -> float:
    """Return how many cells a P wave may cross in a stable step, c dt / dx [1].

    (w dt)^2 <= 2 with the bound w^2 <= stiffness (1 + nu) / (1 - nu) c^2 / dx^2 on every frequency; derived
    in docs/theory.md. stiffness: of the transfer's weights (`neve._core.Model.stencil_stiffness`); nu:
    Poisson's ratio.
    """
    return math.sqrt(2.0 / stiffness * (1.0 - nu) / (1.0 + nu))


def _fastest(solid: Solid, now: Pose) -> float:
    """Return a bound on the speed of the solid's surface [m/s]; of an endless one, the speed of its point."""
    speed = math.hypot(*now.velocity)
    if solid.endless:
        return speed
    return speed + math.hypot(*now.omega) * solid.reach


def _add(native: CoreModel, solid: Solid) -> None:
    """Tell the core of `solid`."""
    if solid.mesh:
        native.add_mesh_solid(solid.mesh.sdf, solid.mode, solid.mu_c, solid.mesh.usual_thickness)
    elif solid.terrain:
        native.add_terrain_solid(solid.terrain, solid.mode, solid.mu_c)
    else:
        native.add_solid(solid.shape, solid.half, solid.mode, solid.mu_c)


def _constants(snow: Snow) -> dict[str, float]:
    """Return every number of `snow` by its name."""
    return {name: value for name, value in snow.model_dump().items() if isinstance(value, float)}


def _damping(numerics: Numerics, snows: Sequence[Snow]) -> float | None:
    """Return the rate at which what the grid cannot resolve decays [1/s], or None if `flip_alpha` says it.

    Where the transfer reads `aflip_damping`, r = aflip_damping c / dx with the fastest pressure wave of the
    snows before they harden, c = max sqrt((lam + 2 mu) / rho0).
    """
    if "aflip_damping" in TRANSFERS[numerics.transfer].options:
        c = max((math.sqrt(p_wave_modulus(snow.E0, snow.nu) / snow.rho0) for snow in snows), default=0.0)
        return numerics.aflip_damping * c / numerics.dx
    return None if numerics.flip_damping == "off" else float(numerics.flip_damping)
