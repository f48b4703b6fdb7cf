"""Trace the paths of light through a frame: geometry, materials, lights and passes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.render.lighting import is_ground
from neve.render.melt_water import Puddle
from neve.render.path_tracing.daylight import emitters, sun_keys
from neve.render.path_tracing.engine import attribute, mitsuba, rgb, triangles, wetted
from neve.render.path_tracing.ground import ground
from neve.render.path_tracing.lens import Lens
from neve.render.path_tracing.looks import (
    REFERENCE,
    Kind,
    Medium,
    Quality,
    capped,
    film_on,
    similar,
    wet_color,
)
from neve.render.path_tracing.optics import cornette_shanks, slab_reflectance
from neve.render.path_tracing.snow import Flakes, SnowGeometry
from neve.render.path_tracing.solids import Materials, loaded, solid_shape
from neve.render.pools import COLOR

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.geometry.pose import Pose
    from neve.scene.schema.scene import Scene

Floats = NDArray[np.float32]

FREE_PATHS = 5.0
"""Mean free paths of light in a grid spacing of the snow, in the looks "medium" and "fast": sigma_t dx."""
MOST_EXTINCTION = 362.0
"""Extinction that these have at most [1/m]: 724 (1 - 0.5), the paper's made isotropic."""
BESIDE_VOLUME = np.float32(0.82)
"""Reflectance of a wet surface beside a volume over that beside a white one, which is brighter."""
LONGEST = 2048
"""Scatterings after which roulette ends paths even where no light is lost."""
ANGLES = 512
"""Values of a phase function that Mitsuba is given as a table, over the cosine."""
BLOCK = 32
"""Side of the blocks of pixels that threads draw [px]: by itself Mitsuba takes it from the number of threads,
and random numbers from the block."""
CLEAR = 0.6
"""Share of light that goes through the surface of water, of what is not mirrored: our choice."""
PARTS = 7919
"""Step of the seed from one exposure of a blurred frame to the next."""


@dataclass
class Layers:
    """Hold what the passes of a frame found, linear light, (height, width, 3) unless said.

    sun, sky: light of each; of a look with one pass all is in `sun` and sky is None. albedo and normal (h,
    w, 3) of what is seen, and the share of snow in it (h, w), None where there is a volume. depth (h, w):
    distance of what is seen first [m], 0 for the sky; flakes; drops (n, 3): places of water that flies [m]
    """

    sun: Floats
    sky: Floats | None = None
    albedo: Floats | None = None
    normal: Floats | None = None
    depth: Floats | None = None
    snow: Floats | None = None
    flakes: Flakes | None = field(default=None)
    drops: Floats | None = None


@dataclass(frozen=True)
class FirstHits:
    """Hold what rays meet first.

    albedo and normal (h, w, 3); depth (h, w) [m], 0 for the sky; snow (h, w): share of snow and flakes
    """

    albedo: Floats
    normal: Floats
    depth: Floats
    snow: Floats


class Tracer:
    """Trace frames of a scene with one light and look."""

    def __init__(self, scene: Scene, quality: Quality, look: str, kind: Kind, threads: int = 0) -> None:
        """Prepare what is the same in all frames. Errors: RenderError without Mitsuba."""
        self._mi = mitsuba(threads)
        self._scene, self._quality, self._look, self._kind = scene, quality, look, kind
        self._materials = Materials()
        self._kept: dict[str, Any] = {}
        light = scene.light
        self.light = light.model_copy(
            update={
                "sun_strength": light.sun_strength * kind.sun,
                "sky_strength": light.sky_strength * kind.sky,
            }
        )

    def trace(
        self,
        snow: SnowGeometry | Future[SnowGeometry],
        solids: Sequence[tuple[Solid, Pose]],
        lens: Lens,
        samples: int,
        part: int = 0,
        rays: int | None = None,
        middle: Lens | None = None,
        puddles: Mapping[int, Puddle] = MappingProxyType({}),
    ) -> Layers:
        """Return the light of a frame, seen through `lens`.

        snow: or what is still at work on it: it is asked for once the solids are made. samples: paths a
        pixel, of each pass. Of a picture of several exposures: part: number of this one; middle: what the
        frame itself is seen through, whose random numbers and endless ground all have. rays: of a pixel that
        look what it shows; None: as the quality has it. puddles: water on planes, by their number in
        `solids`.
        """
        middle = middle or lens
        seed = (middle.seed + PARTS * part) % 2**28
        parts: dict[str, Any] = {"type": "scene", **emitters(self.light)}
        for n, (solid, pose) in enumerate(solids):
            if solid.visible:
                parts[f"solid{n}"] = self._solid(solid, pose, n, middle, puddles.get(n))
        snow = snow.result() if isinstance(snow, Future) else snow
        parts |= self._snow(snow)
        parts["integrator"] = self._integrator()
        film = {
            "type": "hdrfilm",
            "width": lens.width,
            "height": lens.height,
            # No sample counts for two pixels, or their noise is alike and the denoiser keeps it.
            "rfilter": {"type": "tent", "radius": 0.5},
            "pixel_format": "rgb",
            "component_format": "float32",
        }
        parts["sensor"] = lens.sensor(self._mi, film, samples, seed)
        scene = self._mi.load_dict(parts)
        return replace(self._passes(scene, snow.flakes, seed, rays or self._quality.rays), drops=snow.drops)

    def _solid(self, solid: Solid, pose: Pose, n: int, lens: Lens, puddle: Puddle | None) -> Any:
        """Return the mesh of a solid; one that stays where it is is made once, the ground for each view, and
        in each frame where it is wet."""
        key = f"solid{n}"
        if puddle and is_ground(solid):
            return ground(lens, pose.position, pose.rotation, self._scene.numerics.dx, key, puddle)
        if key in self._kept and self._kept[f"{key} seen"] in (None, lens):
            return self._kept[key]
        self._kept[f"{key} seen"] = None
        if is_ground(solid) and solid.terrain is None:
            self._kept[f"{key} seen"] = lens
            shape = ground(lens, pose.position, pose.rotation, self._scene.numerics.dx, key)
        else:
            bsdf_key = f"bsdf {solid.finish} {solid.color}"
            if bsdf_key not in self._kept:
                self._kept[bsdf_key] = loaded(self._materials.of(solid))
            shape = solid_shape(solid, pose.position, pose.rotation, self._kept[bsdf_key], key)
        if solid.motion == "static":
            self._kept[key] = shape
        return shape

    @property
    def _is_volume(self) -> bool:
        return self._look in ("medium", "fast", "reference")

    def medium(self) -> Medium:
        """Return how the snow scatters light, where it is a volume."""
        most = min(FREE_PATHS / self._scene.numerics.dx, MOST_EXTINCTION) / self._kind.clarity
        if self._look == "reference":
            return replace(REFERENCE, phase=self._quality.phase)
        if self._look == "fast":
            return capped(similar(REFERENCE), most)
        return Medium(most, self._kind.albedo)

    def _snow(self, snow: SnowGeometry) -> dict[str, Any]:
        surface, flakes = snow.surface, snow.flakes
        out: dict[str, Any] = {}
        white: dict[str, Any] = {"type": "diffuse", "reflectance": rgb(self._kind.diffuse)}
        if self._kind.wet:
            white = {
                "type": "roughplastic",
                "diffuse_reflectance": rgb(self._kind.diffuse),
                "alpha": 0.18,
                "int_ior": 1.33,
            }
        if len(surface.faces):
            held: dict[str, Any] = {"bsdf": self._load("white", {"type": "twosided", "bsdf": white})}
            wet, colors = None, None
            if snow.wet is not None:
                wet, colors = film_on(snow.wet), wet_color(self._kind.diffuse, snow.wet)
                held = {"bsdf": self._load("slush", self._slush())}
                if self._is_volume:
                    colors *= BESIDE_VOLUME
            elif self._is_volume:
                held = {"bsdf": self._load("null", {"type": "null"})}
            if self._is_volume:
                held["interior"] = self._load("snow", medium_of(self.medium()))
            # Without normals of its own a surface as fine as this one is crisper, and its shadows end well.
            out["snow"] = triangles("snow", surface.vertices, surface.faces, held, colors=colors, wet=wet)
        if len(flakes.radii):
            vertices, faces = flakes.triangles()
            flake = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb(self._flake_color())}}
            out["flakes"] = triangles("flakes", vertices, faces, {"bsdf": self._load("flake", flake)})
        if (pool := snow.pool) is not None:
            held = {"bsdf": self._load("water", water())}
            out["pool"] = triangles("pool", pool.vertices, pool.faces, held, pool.normals)
        return out

    def _slush(self) -> dict[str, Any]:
        """Return the material of snow that is wet in places; on a volume, which is clear, water lies."""
        dry: dict[str, Any] = {"type": "diffuse", "reflectance": attribute("color")}
        if self._is_volume:
            dry = {"type": "null"}
        slush = wetted(dry, attribute("color"), 0.3)
        return slush if self._is_volume else {"type": "twosided", "bsdf": slush}

    def _flake_color(self) -> tuple[float, ...]:
        """Return the reflectance of flakes: with the paper's constants that of its thick snow."""
        if self._look not in ("fast", "reference"):
            return self._kind.diffuse
        snow = replace(REFERENCE, phase=self._quality.phase)
        return tuple(slab_reflectance(w, snow.mean_cosine) for w in snow.albedo)

    def _load(self, key: str, what: dict[str, Any]) -> Any:
        if key not in self._kept:
            self._kept[key] = self._mi.load_dict(what)
        return self._kept[key]

    def _integrator(self) -> dict[str, Any]:
        if self._is_volume:
            return paths_in(self.medium())
        return {"type": "path", "max_depth": self._quality.bounces, "rr_depth": 4, "block_size": BLOCK}

    def _passes(self, scene: Any, flakes: Flakes, seed: int, rays: int) -> Layers:
        if self._is_volume:
            light = self._render(scene, seed)
            return Layers(light, depth=self._first_hits(scene, 1, seed).depth, flakes=flakes)
        parameters = self._mi.traverse(scene)
        strength, weight = sun_keys(self.light)
        sky, sun = parameters["sky.scale"], parameters[strength]
        # One light is sampled at each hit: apart, with all samples for each, both are far less noisy.
        parameters["sky.scale"], parameters["sky.sampling_weight"] = 0.0, 0.0
        parameters.update()
        first = self._render(scene, 2 * seed)
        parameters["sky.scale"], parameters["sky.sampling_weight"] = sky, 1.0
        parameters[strength], parameters[weight] = 0.0 * sun, 0.0
        parameters.update()
        second = self._render(scene, 2 * seed + 1)
        seen = self._first_hits(scene, rays, seed)
        return Layers(first, second, seen.albedo, seen.normal, seen.depth, seen.snow, flakes)

    def _first_hits(self, scene: Any, rays: int, seed: int) -> FirstHits:
        """Return what `rays` rays through each pixel meet first, on average.

        They are rays of their own: Mitsuba's integrator "aov" takes each path of light that is nested in it
        twice.
        """
        aovs = "albedo:albedo,nn:sh_normal,dd:depth,ii:shape_index"
        what = {"type": "aov", "aovs": aovs, "block_size": BLOCK}
        integrator = self._load("first hits", what)
        own = [n for n, shape in enumerate(scene.shapes(), 1) if shape.id() in ("snow", "flakes")]
        found = []
        for k in range(rays):
            image = self._mi.render(scene, integrator=integrator, spp=1, seed=rays * seed + k)
            hits = finite(image)[..., -8:]
            hits[..., 7] = np.isin(np.rint(hits[..., 7]), own)  # a number of a shape has no average
            found.append(hits)
        total = np.asarray(np.mean(found, axis=0, dtype=np.float32))
        return FirstHits(total[..., :3], total[..., 3:6], total[..., 6], total[..., 7])

    def _render(self, scene: Any, seed: int) -> Floats:
        return finite(self._mi.render(scene, seed=seed))


def water() -> dict[str, Any]:
    """Return the material of water that stands together: it mirrors, and what is below it is seen darkly.

    Where a path goes through the surface it bends; the rest ends in deep water, as no path finds the sun
    through a surface that bends it.
    """
    deep = {"type": "principled", "base_color": rgb(COLOR), "roughness": 0.05, "eta": 1.33}
    return {
        "type": "blendbsdf",
        "weight": CLEAR,
        "deep": {"type": "twosided", "bsdf": deep},
        "clear": {"type": "dielectric", "int_ior": 1.33},
    }


def paths_in(medium: Medium) -> dict[str, Any]:
    """Return the integrator of a volume.

    No path is cut off, and roulette begins where half of the light is lost, w^n = 1/2 with w the largest
    albedo. Each of its rounds ends at least 1 path in 20: before that it would leave the light of white snow
    to a few bright sparks.
    """
    lost = max(1.0 - max(medium.albedo), 1e-9)
    roulette = min(LONGEST, math.ceil(math.log(2.0) / lost))
    return {"type": "volpath", "max_depth": -1, "rr_depth": roulette, "block_size": BLOCK}


def finite(image: Any) -> Floats:
    """Return an image of Mitsuba as numbers, 0 where it has none."""
    return np.nan_to_num(np.array(image, np.float32), nan=0.0, posinf=0.0, neginf=0.0)


def medium_of(medium: Medium) -> dict[str, Any]:
    """Return a medium as Mitsuba reads it."""
    return {
        "type": "homogeneous",
        "sigma_t": float(medium.extinction),
        "albedo": rgb(medium.albedo),
        "phase": phase_of(medium),
    }


def phase_of(medium: Medium) -> dict[str, Any]:
    """Return the phase function of a medium as Mitsuba reads it."""
    if medium.phase == "cornette_shanks":
        values = cornette_shanks(np.linspace(-1.0, 1.0, ANGLES), medium.g)
        return {"type": "tabphase", "values": ",".join(f"{value:.7g}" for value in values)}
    return {"type": "hg", "g": medium.g} if medium.g else {"type": "isotropic"}
