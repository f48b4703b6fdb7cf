"""Turn a scene into what every solver needs of it: solids with their bodies, and the material table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.colliders.motion import path_of, pose
from neve.colliders.solid import Solid, solid_of
from neve.geometry.pose import Pose
from neve.reproducible import product
from neve.sampling import Samples, filled
from neve.sampling.carving import carved
from neve.sampling.draping import draped, height_over
from neve.sampling.overlaps import Filled, without_overlaps
from neve.sampling.room import expected, require_room_for_all
from neve.scene.checks.joined import joined_warnings
from neve.scene.errors import SceneError
from neve.scene.schema.file_shapes import Layer
from neve.scene.schema.scene import Collider, Scene, Snow, Source
from neve.scene.schema.snowfall import Lying, Snowfall
from neve.snowfall.cover import Cover
from neve.snowfall.filling import filled_cover
from neve.snowfall.resting import filled_resting
from neve.snowfall.scene import Falls

if TYPE_CHECKING:
    from neve._core import Model as CoreModel
    from neve.rigid.coupled_bodies import CoupledBodies

WAKING = (
    "world",
    "numerics",
    "snow",
    "snow_keyframes",
    "water",
    "sources",
    "emitters",
    "sinks",
    "colliders",
    "bodies",
    "robots",
)
"""Parts of a scene whose change wakes snow that sleeps."""


def wakes_all(scene: Scene, new_scene: Scene) -> bool:
    """Return whether snow that sleeps in `scene` wakes where a run goes on with `new_scene`."""
    return any(getattr(scene, part) != getattr(new_scene, part) for part in WAKING)


def coupled(scene: Scene) -> tuple[tuple[Solid, ...], CoupledBodies | None]:
    """Return all that snow can meet, and who moves the rigid bodies among it, if there are any.

    The colliders come first, then the rigid bodies, in the order of the scene.

    Errors: SceneError for a mesh or a height map that cannot be used.
    """
    with joined_warnings():
        dx = scene.numerics.dx
        around = tuple(solid_of(c, f"colliders.{i}", dx) for i, c in enumerate(scene.colliders))
        if not (scene.bodies or scene.robots):
            return around, None
        from neve.rigid.bodies import RigidBodies

        rigid = RigidBodies(scene, around)
    return (*around, *rigid.solids), rigid


def solids(scene: Scene) -> tuple[Solid, ...]:
    """Return all that snow can meet: the colliders, then the bodies, in the order of the scene."""
    return coupled(scene)[0]


def placed_at_start(scene: Scene) -> list[tuple[Solid, Pose]]:
    """Return all that snow can meet, and where it is when the run begins. Errors: SceneError."""
    found, rigid = coupled(scene)
    poses = [pose(collider, 0.0) for collider in scene.colliders] + (rigid.poses() if rigid else [])
    return list(zip(found, poses, strict=True))


def require_lasting_snows(scene: Scene) -> None:
    """Refuse a scene whose snows change in time, for a method that knows none such. Errors: SceneError."""
    method = scene.numerics.method
    if scene.snow_keyframes:
        raise SceneError(f'snow_keyframes: numerics.method = "{method}" changes no snow in time; use "mpm"')


def material_table(scene: Scene) -> list[Snow]:
    """Return the different snows of the scene, in the order of their first source or emitter."""
    return list(dict.fromkeys(scene.snow_of(source) for source in scene.bearers))


def has_water(scene: Scene) -> bool:
    """Return whether a source of the scene holds water."""
    return any(source.is_water for source in scene.sources)


def with_one_more(scene: Scene, source: Source) -> Scene:
    """Return `scene` with `source` after its other sources. Errors: pydantic.ValidationError."""
    values = {name: getattr(scene, name) for name in Scene.model_fields}
    return Scene.model_validate({**values, "sources": (*scene.sources, source)})


def require_same_sources(scene: Scene, new_scene: Scene) -> None:
    """Refuse a new scene for a run of `scene` with other sources or fewer emitters. Errors: SceneError."""
    if len(new_scene.sources) != len(scene.sources):
        raise SceneError("sources cannot come or go while a run goes on; start it anew, or add snow")
    if len(new_scene.emitters) < len(scene.emitters):
        raise SceneError("emitters cannot go while a run goes on; set their end, or start it anew")


def snows_at(scene: Scene, t: float) -> list[Snow]:
    """Return the rows of the material table with the constants that they have at time `t` [s]."""
    bearers = {scene.snow_of(bearer): bearer for bearer in reversed(scene.bearers)}
    now = scene.snow_at(t)
    return [now.but(bearers[snow].snow) for snow in material_table(scene)]


class PlacedSolids:
    """Hold the solids of one run, and put them in their place in the core.

    native: the core's model, which gets the solids; colliders: of the scene; solids: these and the bodies
    that `rigid` moves; dx: length on which the solver resolves snow [m]. `solid_speed` is a bound on the
    speed of the solids' surfaces now [m/s].
    """

    def __init__(
        self,
        native: CoreModel,
        colliders: Sequence[Collider],
        solids: Sequence[Solid],
        rigid: CoupledBodies | None,
        dx: float,
    ) -> None:
        self.native = native
        self.colliders = tuple(colliders)
        self.solids = tuple(solids)
        self.rigid = rigid
        self.dx = dx
        self.solid_speed = 0.0
        for solid in self.solids:
            add_solid(native, solid)
        for i, solid in enumerate(self.solids):
            if solid.motion == "dynamic":
                native.make_dynamic(i)
        self._reach = np.array([solid.reach for solid in self.solids])
        self._centres = np.zeros((len(self.solids), 3))
        self._belts = [math.hypot(*collider.surface_velocity) for collider in self.colliders]
        moving = [i for i in range(len(self.colliders)) if self.solids[i].motion != "static"]
        self._belted = [i for i in moving if self._belts[i]]
        self._paths = [
            (i, path_of(self.colliders[i]), self.solids[i].reach) for i in moving if not self._belts[i]
        ]
        for i, collider in enumerate(self.colliders):
            self._place_collider(i, collider, 0.0)
        self.place_solids(0.0)

    def distance(self, i: int, x: NDArray[np.float64]) -> NDArray[Any]:
        """Return the signed distance of points x (n, 3) [m] from the surface of solid i, (n,) [m]."""
        phi, _ = self.native.surface(i, np.ascontiguousarray(x))
        return phi

    def near(self, low: NDArray[np.float64], high: NDArray[np.float64]) -> list[int]:
        """Return which solids may reach into the box from `low` to `high` [m] (3,), and some near."""
        for i, path, _ in self._paths:
            self._centres[i] = path.at(self._time)[0]
        if self.rigid:
            self._centres[len(self.colliders) :] = self.rigid.motion.centres
        gap = np.maximum(np.maximum(low - self._centres, self._centres - high), 0.0)
        return np.flatnonzero(np.sum(gap * gap, axis=1) <= (self._reach + self.dx) ** 2).tolist()

    def free(self, samples: Samples, name: str) -> Samples:
        """Return `samples` of the source `name` without those inside a solid."""
        near = self.near(samples.x.min(axis=0), samples.x.max(axis=0))
        solids = [self.solids[i] for i in near]
        return carved(samples, solids, lambda k, x: self.distance(near[k], x), self.dx, name)

    def poses(self, time: float) -> list[Pose]:
        """Return the pose of each solid at `time` [s]."""
        scripted = [pose(collider, time) for collider in self.colliders]
        return scripted + (self.rigid.poses() if self.rigid else [])

    def set_gravity(self, gravity: NDArray[np.float64]) -> None:
        """Let snow and bodies fall with `gravity` (3,) [m/s2] from now on."""
        self.native.set_gravity(gravity)
        if self.rigid:
            self.rigid.set_gravity(gravity)

    def place_solids(self, time: float) -> None:
        """Put what moves where its script has it at `time` [s], and every rigid body where it is."""
        self._time = time
        self.solid_speed = max(self._belts, default=0.0)
        for i, path, reach in self._paths:
            self.solid_speed = max(self.solid_speed, self.native.follow(i, path, time, reach))
        for i in self._belted:
            self._place_collider(i, self.colliders[i], time)
        if self.rigid:
            fastest = self.native.move_bodies(self.rigid.motion, self._reach[len(self.colliders) :])
            self.solid_speed = max(self.solid_speed, fastest)

    def _place_collider(self, i: int, collider: Collider, time: float) -> None:
        p = pose(collider, time)
        if self._belts[i]:
            self.native.set_belt(i, product(p.rotation, np.array(collider.surface_velocity)))
        self._place(i, p, self._belts[i])

    def _place(self, i: int, p: Pose, belt: float = 0.0) -> None:
        self._centres[i] = p.position
        self.native.place_solid(i, p.position, np.ascontiguousarray(p.rotation), p.velocity, p.omega)
        self.solid_speed = max(self.solid_speed, _fastest(self.solids[i], p) + belt)

    def totals_of_bodies(self) -> dict[str, Any]:
        """Return bodies_momentum (3,) [kg m/s], bodies_kinetic, bodies_potential [J]; zero without bodies."""
        rigid = self.rigid
        if rigid is None:
            return {"bodies_momentum": (0.0, 0.0, 0.0), "bodies_kinetic": 0.0, "bodies_potential": 0.0}
        px, py, pz = map(float, rigid.momentum)
        return {
            "bodies_momentum": (px, py, pz),
            "bodies_kinetic": rigid.kinetic,
            "bodies_potential": rigid.potential,
        }

    @property
    def solids_move(self) -> bool:
        """Whether any solid changes its place in time."""
        return any(solid.motion != "static" for solid in self.solids)


def samples_of(scene: Scene, placed: PlacedSolids, indices: Sequence[int]) -> list[Samples]:
    """Return the snow of the sources of these indices: cut where it overlaps, without what is inside a solid.

    Errors: SceneError for a source that cannot be used, or that starts wholly inside solids, and for more
    particles than there is memory for.
    """
    sources = [scene.sources[i] for i in indices]
    if not sources:
        return []
    if len(sources) > 1:
        require_room_for_all(sum(expected(s, scene.numerics) for s in sources), scene.numerics)
    with joined_warnings():
        falls = Falls(scene, list(zip(placed.solids, placed.poses(0.0), strict=True)))
        parts = [_filled(scene, s, placed, falls, i) for i, s in zip(indices, sources, strict=True)]
        samples = [
            placed.free(s, f"sources.{i}") for i, s in zip(indices, without_overlaps(parts), strict=True)
        ]
    require_room_for_all(sum(len(s.x) for s in samples), scene.numerics, held=True)
    return samples


def _filled(scene: Scene, source: Source, placed: PlacedSolids, falls: Falls, index: int) -> Filled:
    """Fill a source, on the ground if it lies there."""
    name = f"sources.{index}"
    if isinstance(source, (Snowfall, Lying)):
        lies, snow = falls.snow(index), scene.snow_of(source)
        whole = scene.completed(source).model_copy(update={"structure": source.structure})
        if isinstance(lies, Cover):
            samples, space = filled_cover(whole, snow, lies, scene.numerics, index)
        else:
            samples, space = filled_resting(source, snow, lies, scene.numerics, index)
        return Filled(name, space, samples, snow.rho0, source.overlap == "cut")
    numerics = scene.numerics
    if source.is_water:  # which is at rest only as a lattice
        numerics = numerics.model_copy(update={"sampling": "regular"})
    samples, space = filled(scene.completed(source), numerics, index, scene.colliders)
    lift = None
    if isinstance(source, Layer) and source.on == "terrain":
        native = placed.native
        grounds = [partial(native.surface, i) for i, solid in enumerate(placed.solids) if solid.endless]
        lift = height_over(grounds, name)
        samples = draped(samples, lift)
    return Filled(name, space, samples, scene.snow_of(source).rho0, source.overlap == "cut", lift)


def _fastest(solid: Solid, now: Pose) -> float:
    """Return a bound on the speed of the solid's surface [m/s]; of an endless one, the speed of its point."""
    speed = math.hypot(*now.velocity)
    if solid.endless:
        return speed
    return speed + math.hypot(*now.omega) * solid.reach


def add_solid(native: CoreModel, solid: Solid) -> None:
    """Add `solid` to a model of the core, after those that are there."""
    if solid.mesh:
        native.add_mesh_solid(solid.mesh.sdf, solid.mode, solid.mu_c, solid.mesh.usual_thickness)
    elif solid.terrain:
        native.add_terrain_solid(solid.terrain, solid.mode, solid.mu_c)
    else:
        native.add_solid(solid.shape, solid.half, solid.mode, solid.mu_c)
