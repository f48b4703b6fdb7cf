"""Draw frames by path tracing: the whole way from particles to light that is ready to be coded."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.backend import Cpu
from neve.render.falling import draw_falling
from neve.render.melt_water import Water, mean_at, melt_water
from neve.render.path_tracing.develop import develop
from neve.render.path_tracing.engine import RenderError
from neve.render.path_tracing.lens import Lens
from neve.render.path_tracing.looks import KINDS, QUALITIES, Quality
from neve.render.path_tracing.metaball_light import metaballs_before, together
from neve.render.path_tracing.shutter import Instant, Moment, Motion, exposures, mean, velocities
from neve.render.path_tracing.snow import (
    NOTHING,
    SnowGeometry,
    flake_share,
    grain_count,
    lumps,
    snow_geometry,
)
from neve.render.path_tracing.tracer import Layers, Tracer
from neve.render.pools import pool_of
from neve.surface.carry import Origin, carried
from neve.surface.mesh import SurfaceMesh
from neve.surface.metaballs import snow_balls

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.geometry.pose import Pose
    from neve.render.shot import View
    from neve.scene.schema.camera import Camera
    from neve.scene.schema.scene import Scene

Floats = NDArray[np.float32]

FLAKE_SIZE = {"diffuse": 0.45, "other": 0.38}
"""Mean radius of a flake in grain sizes."""


@dataclass(frozen=True)
class Choices:
    """Hold what a user chooses of a picture; None: as the quality has it.

    quality, look, kind and phase: words of QUALITIES, LOOKS, KINDS and PHASES. samples: paths for each pixel,
    of each pass. size: (width, height) [px]. aperture: radius of the lens [m], None: the camera's.
    denoise: whether noise is removed.
    """

    quality: str = "good"
    look: str | None = None
    kind: str = "fresh"
    samples: int | None = None
    size: tuple[int, int] | None = None
    aperture: float | None = None
    denoise: bool = True
    phase: str | None = None

    def check(self, camera: Camera) -> None:
        """Refuse what the look would not show of the scene's camera. Errors: RenderError."""
        look = self.all.look
        if look == "metaballs" and self.radius(camera):
            key, end = (
                ("camera.aperture", "use --aperture 0")
                if self.aperture is None
                else ("--aperture", "leave it out")
            )
            raise RenderError(f"{key}: the look metaballs is drawn through a pinhole; {end}.")
        if self.phase and look != "reference":
            raise RenderError(
                f"--phase {self.phase}: it is for the look reference, not {look}; leave it out."
            )
        if look in ("reference", "fast") and self.kind not in ("fresh", "blue_hour"):
            raise RenderError(
                f"--snow {self.kind}: the look {look} is made of the snow of Stomakhin et al. 2013; leave it"
                " out, or choose the look medium or diffuse."
            )

    @property
    def all(self) -> Quality:
        """The quality, with what was chosen besides."""
        found = QUALITIES[self.quality]
        return replace(
            found,
            look=self.look or found.look,
            samples=self.samples or found.samples,
            size=self.size or found.size,
            phase=self.phase or found.phase,
        )

    def radius(self, camera: Camera) -> float:
        """Return the radius of the lens [m]."""
        return camera.aperture if self.aperture is None else self.aperture

    def pixel(self, views: Iterable[View]) -> float:
        """Return the finest footprint of a pixel at the target of a view [m]."""
        return min(Lens(view, *self.all.size).pixel for view in views)

    def grains(self, spacing: float, views: Iterable[View], most: int) -> int:
        """Return how many grains a particle is drawn as, of at most `most` particles; spacing [m]."""
        quality = self.all
        return grain_count(spacing, self.pixel(views), most, quality.grains, quality.across)


class _First:
    """Hold what the first frame of a run tells of its particles."""

    def __init__(self, id: NDArray[Any], x: NDArray[Any], spacing: float) -> None:
        order = np.argsort(id)
        self._names, self._weights = id[order], lumps(x, spacing)[order]
        self.origin = Origin(id, x)

    def weights_of(self, id: NDArray[Any]) -> Floats:
        """Return the weights of particles (n,); those that came later weigh 1."""
        if not len(self._names):
            return np.ones(len(id), np.float32)
        at = np.searchsorted(self._names, id).clip(max=len(self._names) - 1)
        return np.where(self._names[at] == id, self._weights[at], np.float32(1.0))


class PathTracer:
    """Draw frames of one run.

    What a particle is drawn as depends on its id, on its place in the first frame and on how the snow around
    it has moved since, how finely on the scene and the most particles that a frame has: nothing changes from
    one frame to the next but what moves.
    """

    def __init__(
        self,
        scene: Scene,
        choices: Choices,
        first_id: NDArray[Any],
        first_x: NDArray[Any],
        most: int,
        views: Sequence[View],
        threads: int = 0,
    ) -> None:
        """Prepare. first_id (n,), first_x (n, 3) [m]: particles of the first frame; most: that a frame has.

        views: of the camera in all frames; grains are as fine as the nearest asks for.
        Errors: RenderError without Mitsuba.
        """
        self.quality = choices.all
        self._scene, self._choices, self._kind = scene, choices, KINDS[choices.kind]
        spacing = scene.numerics.spacing
        self.count = choices.grains(spacing, views, most)
        self._flakes = flake_share(int(self.quality.flakes * self._kind.flakes), self.count * most)
        # A thread of its own makes the snow, while this one makes the solids and loads Mitsuba.
        self._own = ThreadPoolExecutor(1, initializer=_use_threads, initargs=(threads,))
        self._first = self._own.submit(_First, first_id, first_x, spacing)
        self._tracer = Tracer(scene, self.quality, self.quality.look, self._kind, threads)

    def _lens(self, view: View) -> Lens:
        camera = self._scene.camera
        return Lens(view, *self.quality.size, self._choices.radius(camera), camera.focus)

    def draw(
        self,
        x: NDArray[Any],
        v: NDArray[Any],
        id: NDArray[Any],
        at: Callable[[float], tuple[Sequence[tuple[Solid, Pose]], View]],
        open_for: float,
        F_E: NDArray[Any] | None = None,
        water: NDArray[Any] | None = None,
        J_P: NDArray[Any] | None = None,
        time: float = 0.0,
    ) -> Floats:
        """Return exposed linear light (height, width, 3), 1 is white.

        x (n, 3) [m]; v (n, 3) [m/s]; id (n,); at: tells of a time after the frame [s] where the solids are
        and the view of the camera; open_for: how long the shutter is open [s]; F_E (n, 3, 3): deformation
        gradients that carry the grains; None: those that neighbours tell. water (n,): liquid shares, None: no
        particle is wet; J_P (n,): volumes over those at birth, which water has less of than snow. time:
        of the frame [s], for flakes that fall.
        """

        def seen(dt: float) -> Moment:
            solids, view = at(dt)
            return solids, self._lens(view)

        times = exposures(x, v, seen, open_for, self.quality.samples) if open_for else [0.0]
        wet, pool = None, None
        if water is not None:
            wet, rows, pool = self._water(x, v, water, J_P, at(0.0)[0])
            x, v, id = x[rows], v[rows], id[rows]
            F_E = None if F_E is None else F_E[rows]
        if len(times) == 1:
            layers = self._layers(x, id, seen(0.0), F_E, wet, pool)
        else:
            layers = self._blurred(x, v, id, seen, open_for, times, F_E, wet, pool)
        out = develop(
            layers,
            seen(0.0)[1],
            self._tracer.light,
            self._scene.light,
            self._kind,
            self._scene.numerics.dx,
            self._choices.denoise,
            spacing=self._scene.numerics.spacing,
        )
        if self._scene.light.falling > 0.0:
            half = 0.5 * open_for
            lenses = seen(-half)[1], seen(half)[1]
            out = draw_falling(out, self._scene.light, lenses, time, open_for, layers.depth)
        return out

    def _water(
        self,
        x: NDArray[Any],
        v: NDArray[Any],
        water: NDArray[Any],
        J_P: NDArray[Any] | None,
        solids: Sequence[tuple[Solid, Pose]],
    ) -> tuple[Water | None, NDArray[np.int64], SurfaceMesh | None]:
        """Return what melting has made of a frame, the rows of what is drawn as snow or drops, and the pool.

        What stands in a pool, or lies on the ground, is drawn with these.
        """
        spacing = self._scene.numerics.spacing
        inside, pool = pool_of(x, water, spacing)
        if pool is not None:
            pool = replace(pool, velocity=velocities(pool.vertices, x[inside], v[inside], spacing))
        rows = np.flatnonzero(~inside)
        wet = melt_water(solids, x[rows], water[rows], None if J_P is None else J_P[rows], spacing)
        return wet, rows if wet is None else rows[wet.rows], pool

    def _layers(
        self,
        x: NDArray[Any],
        id: NDArray[Any],
        moment: Moment,
        F_E: NDArray[Any] | None = None,
        wet: Water | None = None,
        pool: SurfaceMesh | None = None,
    ) -> Layers:
        """Return what is seen at one moment."""
        samples = self.quality.samples
        if self.quality.look != "metaballs":
            snow = self._own.submit(self.geometry, x, id, F_E, wet, pool)
            return self._tracer.trace(snow, *moment, samples, puddles=wet.puddles if wet else {})
        return self._metaballs(x, moment, samples, pool=pool)

    def _blurred(
        self,
        x: NDArray[Any],
        v: NDArray[Any],
        id: NDArray[Any],
        seen: Instant,
        open_for: float,
        times: Sequence[float],
        F_E: NDArray[Any] | None,
        wet: Water | None = None,
        pool: SurfaceMesh | None = None,
    ) -> Layers:
        """Return the mean of what is seen at several times, with as many paths together as a still has."""
        samples = max(1, round(self.quality.samples / len(times)))
        if self.quality.look == "metaballs":
            return mean(
                self._metaballs(x + np.float32(dt) * v, seen(dt), samples, k, pool)
                for k, dt in enumerate(times)
            )
        motion = Motion(self.geometry(x, id, F_E, wet, pool), x, v, self._scene.numerics.spacing)
        puddles = wet.puddles if wet else {}
        rays, middle = max(1, round(self.quality.rays / len(times))), seen(0.0)[1]
        layers = mean(
            self._tracer.trace(motion.after(dt), *seen(dt), samples, k, rays, middle, puddles)
            for k, dt in enumerate(times)
        )
        half = 0.5 * open_for
        return replace(layers, flakes=motion.sharp(seen(-half)[1], seen(half)[1], open_for))

    def _metaballs(
        self, x: NDArray[Any], moment: Moment, samples: int, part: int = 0, pool: SurfaceMesh | None = None
    ) -> Layers:
        behind = self._tracer.trace(replace(NOTHING, pool=pool), *moment, samples, part)
        spacing = self._scene.numerics.spacing
        balls = snow_balls(together(x, spacing), spacing)
        return metaballs_before(behind, balls, self._tracer.medium(), self._tracer.light, moment[1])

    def geometry(
        self,
        x: NDArray[Any],
        id: NDArray[Any],
        F_E: NDArray[Any] | None = None,
        wet: Water | None = None,
        pool: SurfaceMesh | None = None,
    ) -> SnowGeometry:
        """Return the snow of a frame, and a pool of water, as they are drawn."""
        first, spacing = self._first.result(), self._scene.numerics.spacing
        F = first.origin.gradients(id, x) if F_E is None else F_E
        size = FLAKE_SIZE["diffuse" if self.quality.look == "diffuse" else "other"] * self._kind.flake_size
        weights = first.weights_of(id)
        if wet is None:
            snow = snow_geometry(x, id, weights, spacing, self.count, self._flakes, size, carried(F))
            return replace(snow, pool=pool)
        own = ~(wet.flies | wet.soaks)
        snow = snow_geometry(
            x[own],
            id[own],
            (weights * wet.volume)[own],
            spacing,
            self.count,
            self._flakes,
            size,
            carried(F[own]),
            wet.share[own],
        )
        near = ~wet.flies  # water among snow is no body of its own: it wets what is around
        film = mean_at(snow.surface.vertices, x[near], wet.share[near], spacing)
        return replace(snow, wet=film, drops=np.asarray(x[wet.flies], np.float32), pool=pool)


def _use_threads(count: int) -> None:
    if count:
        Cpu().use_threads(count)
