"""Model: the constants of one run, and the solids in their place at an instant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from neve.backend import backend
from neve.build import PlacedSolids, snows_at
from neve.colliders.solid import Solid
from neve.cuda.errors import DeviceError
from neve.rigid.coupled_bodies import CoupledBodies
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Collider, Numerics, Scene, Snow, World
from neve.scene.values.choices import TRANSFERS
from neve.scene.values.curves import keyed
from neve.scene.values.elastic import p_wave_modulus

if TYPE_CHECKING:
    from neve._core import HeatModel, Precision, State


class Model(PlacedSolids):
    """Hold the material table, the solids, gravity and dx of one run, in the core's precision.

    `core` is the set of compiled stages (float32 or float64), `native` the core's own model; `gravity` (3,)
    [m/s2] the present one; `courant` the largest stable c dt / dx, of explicit steps; `sleeps` whether snow
    at rest is left out; `has_heat` whether particles have heat;
    `is_fine` whether positions are kept to more than float32.
    """

    def __init__(
        self,
        world: World,
        numerics: Numerics,
        snows: Sequence[Snow],
        colliders: Sequence[Collider],
        solids: Sequence[Solid],
        rigid: CoupledBodies | None = None,
        heat: HeatModel | None = None,
        is_fine: bool = False,
    ) -> None:
        self.core = _stages(numerics)
        self.gravity = np.array(world.gravity, dtype=np.float64)
        self.numerics = numerics
        self.snows = tuple(snows)
        native = self.core.Model(
            numerics.dx,
            numerics.spline,
            numerics.transfer,
            numerics.flip_alpha,
            self.gravity,
            numerics.polypic_modes,
            _damping(numerics, self.snows),
            numerics.sleep_speed if numerics.sleep else 0.0,
            numerics.sleep_after,
        )
        self.sleeps, self.has_heat, self.is_fine = numerics.sleep, heat is not None, is_fine
        if heat is not None:
            native.set_heat(heat)
        super().__init__(native, colliders, solids, rigid, numerics.dx)
        self.courant = self._courant(self.snows)
        for snow in self.snows:
            self.native.add_snow(snow.law, snow.plasticity, _constants(snow))
        self.limit_compression(1.0)

    def set_time(self, scene: Scene, time: float) -> None:
        """Give gravity and snows the values that the keyframes of `scene` have at `time` [s].

        What the transfer damps (`numerics.aflip_damping`) stays that of the snows at the start.
        """
        if scene.world.keyframes:
            self.gravity = keyed(scene.world, "gravity", time)
            self.set_gravity(self.gravity)
        if not scene.snow_keyframes:
            return
        snows = snows_at(scene, time)
        for row, snow in enumerate(snows):
            self.native.set_snow(row, snow.law, snow.plasticity, _constants(snow))
        self.courant = self._courant(snows)
        self.limit_compression(self._strongest)

    def _courant(self, snows: Sequence[Snow]) -> float:
        if self.numerics.is_implicit:
            return math.inf
        return stable_courant(self.native.stencil_stiffness, max(snow.nu for snow in snows))

    def particles(self, count: int) -> State:
        """Return `count` particles at rest, with the columns that this model needs."""
        return self.core.State(count, self.native.more_modes, self.sleeps, self.has_heat, self.is_fine)

    def limit_compression(self, strongest: float) -> None:
        """Set `max_compression`: how far a step may press snow, -dt tr grad v [1], before hardening stores
        more than its work, as the laws say. `strongest`: the largest factor on the thresholds of any
        particle [1].
        """
        self._strongest = strongest
        self.max_compression = self.native.max_compression(strongest)


def _stages(numerics: Numerics) -> Precision:
    """Return the compiled stages of the scene's device. Errors: SceneError if it cannot be used."""
    try:
        on_processor = numerics.sleep or numerics.is_implicit  # the only one that can; the scene is checked
        device = "cpu" if on_processor else numerics.device
        return backend(device).kernels(numerics.precision, numerics.deterministic, numerics.devices)
    except DeviceError as error:
        raise SceneError(str(error)) from None


def stable_courant(stiffness: float, nu: float) -> float:
    """Return how many cells a P wave may cross in a stable step, c dt / dx [1].

    (w dt)^2 <= 2 with the bound w^2 <= stiffness (1 + nu) / (1 - nu) c^2 / dx^2 on every frequency; derived
    in docs/theory.md. stiffness: of the transfer's weights (`neve._core.Model.stencil_stiffness`); nu:
    Poisson's ratio.
    """
    return math.sqrt(2.0 / stiffness * (1.0 - nu) / (1.0 + nu))


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
