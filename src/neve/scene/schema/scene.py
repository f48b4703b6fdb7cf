"""Describe a whole scene: what the user asked for, plain checked data in SI units, z up, no arrays."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from pydantic import model_validator

from neve.registry import DEVICES, FIRST, METHODS
from neve.scene.schema.bodies import AnyBody, Body, Control, Motor, Robot, Target
from neve.scene.schema.camera import Camera, CameraKeyframe, Light, unknown
from neve.scene.schema.colliders import AnyCollider, Collider, Keyframe
from neve.scene.schema.file_shapes import Layer
from neve.scene.schema.material import (
    Heat,
    Overrides,
    Snow,
    SnowKeyframe,
    problem,
)
from neve.scene.schema.outputs import OutputEntry, conflict
from neve.scene.schema.snow_kinds import SNOWS
from neve.scene.schema.sources import (
    AnyEmitter,
    AnySink,
    AnySource,
    Emitter,
    EmitterKeyframe,
    Profile,
    Sink,
    Source,
    Variation,
    too_strong,
)
from neve.scene.values.allowed import words
from neve.scene.values.choices import (
    DEFAULT_SPLINE,
    DEFAULT_TRANSFER,
    SPLINES,
    TRANSFERS,
    SplineWord,
    TransferWord,
    listed,
    meanings,
    sources,
    users,
)
from neve.scene.values.curves import monotone
from neve.scene.values.fields import (
    CURVES,
    FRITSCH,
    SHORTEST,
    Damping,
    Device,
    DeviceNumbers,
    Method,
    Modes,
    Part,
    Rate3,
    Real,
    Step,
    Switch,
    Whole,
    check_times,
    entry,
    wrong,
)

__all__ = [
    "Body", "Camera", "CameraKeyframe", "Collider", "Control", "Emitter", "EmitterKeyframe", "Heat",
    "Keyframe", "Light", "Motor", "Numerics", "Overrides", "Part", "Profile", "Robot", "Run", "Scene",
    "Sink", "Snow", "SnowKeyframe", "Source", "Target", "Variation", "World", "WorldKeyframe",
]  # fmt: skip


class WorldKeyframe(Part):
    """Say what surrounds the snow at one moment."""

    t: Real = entry(0.0, "Time.", "s", ge=0, le=1e6)
    gravity: Rate3 | None = entry(
        None, "Gravitational acceleration at `t`; left out, the world's own.", "m/s2"
    )


class World(Part):
    """Describe what surrounds the snow."""

    gravity: Rate3 = entry(
        (0.0, 0.0, -9.81), "Gravitational acceleration.", "m/s2", "standard gravity, rounded"
    )
    keyframes: tuple[WorldKeyframe, ...] = entry((), f"Gravity at increasing times. {CURVES}", "", FRITSCH)

    @model_validator(mode="after")
    def _check(self) -> World:
        check_times(self.keyframes)
        return self


class Numerics(Part):
    """Choose how the equations are solved."""

    method: Method = entry(METHODS.names()[0], f"How snow is simulated. {METHODS.meaning()}.", "")
    device: Device = entry(DEVICES.names()[0], f"Where the step is computed. {DEVICES.meaning()}.", "")
    devices: DeviceNumbers = entry(
        FIRST,
        "Numbers of the GPUs that share the run, as `neve info` lists them: each has a part of the snow.",
        "",
    )
    deterministic: Switch = entry(
        False,
        "Whether runs on GPUs repeat bit for bit, on one or several: all sums are made in a fixed order, "
        "which takes time. On the processor runs always repeat.",
        "",
    )
    dx: Real = entry(
        0.05, "Grid spacing; half of it means eight times as many particles.", "m", ge=SHORTEST, le=1000
    )
    spline: SplineWord = entry(
        DEFAULT_SPLINE,
        f"B-spline that weights the nodes around a particle. {meanings(SPLINES)}.",
        "",
        sources(SPLINES),
    )
    transfer: TransferWord = entry(
        DEFAULT_TRANSFER,
        f"How velocities are transferred between particles and grid. {meanings(TRANSFERS)}.",
        "",
        sources(TRANSFERS),
    )
    polypic_modes: Modes = entry(
        8,
        "Velocity modes per particle: 1 is its velocity alone, 4 are an affine velocity, 8 the multilinear "
        f"modes, 27 the modes up to degree 2 along each axis; used by {listed(users('polypic_modes'))}.",
        "1",
        "Fu et al. 2017 name the choices; 8: ours",
    )
    flip_alpha: Real = entry(
        0.95,
        f"Share of FLIP in the velocity update of one step; used by {listed(users('flip_alpha'))}.",
        "1",
        "Stomakhin et al. 2013 (as quoted in public codes)",
        ge=0,
        le=1,
    )
    flip_damping: Literal["off"] | Damping = entry(
        "off",
        "Decay rate of motion that the grid cannot resolve, in place of flip_alpha: alpha = "
        "exp(-flip_damping dt), so that the damping does not depend on the time step.",
        "1/s",
    )
    aflip_damping: Real = entry(
        0.5,
        "Decay rate of motion that the grid cannot resolve, times the time in which the fastest elastic wave "
        "of the snows before they harden crosses a cell: alpha = exp(-aflip_damping c dt / dx); used by "
        f"{listed(users('aflip_damping'))}.",
        "1",
        ge=0,
        le=1000,
    )
    dt: Literal["auto"] | Step = entry(
        "auto", 'Time step, or "auto" for the largest good one; shortened where it would be unstable.', "s"
    )
    cfl: Real = entry(
        0.4,
        "Fraction of a cell that a wave or a particle may cross in one automatic step; above 0.6 snow can "
        "gain energy.",
        "1",
        ge=1e-3,
        le=0.6,
    )
    strain_max: Real = entry(
        0.25,
        "Largest change of deformation, dt |grad v|, in one automatic step.",
        "1",
        ge=1e-3,
        le=1,
    )
    dt_max: Real = entry(1e-2, "Largest automatic time step.", "s", ge=SHORTEST, le=1)
    precision: Literal["float32", "float64"] = entry(
        "float32", "Floating-point format of particles and grid.", ""
    )
    particles_per_cell: Whole = entry(
        8,
        "Number of particles in a cell full of snow.",
        "1",
        "8 is two along each axis; our choice",
        ge=1,
        le=512,
    )
    sampling: Literal["jittered", "poisson", "regular"] = entry(
        "jittered",
        'How particles are placed: "jittered" moves each point of a lattice at random; "poisson" places '
        'them at random with a least distance between any two; "regular" leaves the lattice as it is, for '
        "comparison with exact solutions.",
        "",
        "poisson: Bridson 2007 names the goal; the algorithm is ours",
    )
    seed: Whole = entry(0, "Seed of all random numbers.", "1", ge=0, lt=2**32)
    initial_volume: Literal["sampled", "grid"] = entry(
        "sampled",
        'Volume of a particle: "sampled" divides the volume of the shape among its particles; "grid" '
        "measures the density on the grid in the first step, which comes out too low at the surface; steps "
        "are then a quarter to a third shorter.",
        "",
        "grid: Stomakhin et al. 2013, step 2 (as quoted in public codes); sampled: our choice, measured",
    )

    sleep: Switch = entry(
        False,
        "Whether snow at rest is left out of the step, block by block, until something moves it: cost then "
        "follows the snow that moves.",
        "",
    )
    sleep_speed: Real = entry(
        0.01,
        "Snow rests if its mean velocity over the time sleep_after is smaller; a neighbour that gets away "
        "twice as fast wakes it.",
        "m/s",
        gt=0,
        le=10,
    )
    sleep_after: Real = entry(0.2, "Time at rest after which snow sleeps.", "s", gt=0, le=10)

    @property
    def spacing(self) -> float:
        """Return the mean distance of particles in snow at rest [m]."""
        return float(self.dx / self.particles_per_cell ** (1.0 / 3.0))


class Run(Part):
    """Say how long to simulate and what to keep."""

    duration: Real = entry(3.0, "Simulated time.", "s", ge=SHORTEST, le=86400)
    fps: Whole = entry(30, "Frames per simulated second.", "1/s", ge=1, le=10000)
    film: Switch = entry(True, "Whether to make a film.", "")
    fragments: Switch = entry(False, "Whether to count the pieces of broken snow in each frame.", "")
    frames: Literal["plain", "compact"] = entry(
        "plain", "Frame files: in float32, or in fewer bits ([compact](run_folder.md#compact-frames)).", ""
    )
    fields: tuple[str, ...] = entry(
        (),
        "Further fields of the particles in each frame file, for exports: F_E, tau, density, C, m, V0, "
        "stiffness, strength, source (written unasked where there are several sources).",
        "",
    )


class Scene(Part):
    """Hold everything a user asked for.

    Errors: pydantic.ValidationError; `neve.scene.reading.load.load` turns it into one sentence.
    """

    about: str = entry("", "What happens, in one line.", "")
    world: World = entry(World(), "Surroundings.", "")
    numerics: Numerics = entry(Numerics(), "Grid, time step and particles.", "")
    snow: Snow = entry(Snow(), "Snow of all sources.", "")
    heat: Heat | None = entry(None, "Heat: warming, melting, freezing, sintering; left out, none.", "")
    snow_keyframes: tuple[SnowKeyframe, ...] = entry(
        (), f"Constants of [snow] at increasing times. {CURVES}", "", FRITSCH
    )
    sources: tuple[AnySource, ...] = entry((), "Where snow is at the start.", "")
    emitters: tuple[AnyEmitter, ...] = entry((), "Where snow comes in during the run.", "")
    sinks: tuple[AnySink, ...] = entry((), "Where snow is taken out during the run.", "")
    colliders: tuple[AnyCollider, ...] = entry((), "Solids that snow meets.", "")
    bodies: tuple[AnyBody, ...] = entry((), "Bodies: solids that snow and other forces move.", "")
    robots: tuple[Robot, ...] = entry((), "Robots and vehicles from files, which snow moves as well.", "")
    camera: Camera = entry(Camera(), "Camera of the film.", "")
    light: Light = entry(Light(), "Light of the film.", "")
    run: Run = entry(Run(), "Length of the run.", "")
    outputs: tuple[OutputEntry, ...] = entry((), "What a run writes, and how often.", "")

    @model_validator(mode="after")
    def _parents(self) -> Scene:
        for i, body in enumerate(self.bodies):
            if body.parent is not None and body.parent >= i:
                earlier = f"from 0 to {i - 1}" if i else "and the first body has none"
                raise wrong(f"bodies.{i}.parent", f"must be the number of an earlier body, {earlier}")
        return self

    @model_validator(mode="after")
    def _sleep(self) -> Scene:
        if self.numerics.sleep:
            for key, only in (("method", ("mpm", "particles")), ("device", ("cpu", "auto"))):
                if (word := getattr(self.numerics, key)) not in only:
                    raise wrong(
                        "numerics.sleep", f'cannot be true with numerics.{key} = "{word}": set {words(only)}'
                    )
        return self

    @model_validator(mode="after")
    def _files(self) -> Scene:
        if found := conflict(self.outputs, self.run.fps):
            raise wrong(f"outputs.{found[0]}", found[1])
        return self

    @model_validator(mode="after")
    def _keyed(self) -> Scene:
        check_times(self.snow_keyframes, "snow_keyframes")
        for i, key in enumerate(self.snow_keyframes):
            for name in key.constants():
                if name not in self.snow.constants():
                    raise wrong(f"snow_keyframes.{i}.{name}", f"is no constant of snow.law = {self.snow.law}")
            then = self.snow_at(key.t)
            for bearer in self.bearers:
                if found := problem(then.but(bearer.snow), key.constants()):
                    raise wrong(f"snow_keyframes.{i}.{found[0]}", found[1])
        return self

    @model_validator(mode="after")
    def _followed(self) -> Scene:
        solids = [
            f"{name}.{i}" for name in ("colliders", "bodies") for i, _ in enumerate(getattr(self, name))
        ]
        cameras: dict[str, Camera | None] = {"camera": self.camera}
        cameras |= {f"outputs.{i}.camera": getattr(o, "camera", None) for i, o in enumerate(self.outputs)}
        for key, camera in cameras.items():
            if camera is not None and (found := unknown(camera, solids, len(self.robots))):
                raise wrong(f"{key}.follow", found)
        return self

    @model_validator(mode="after")
    def _check(self) -> Scene:
        if not (self.sources or self.emitters):
            raise wrong(
                "sources", 'needs at least one entry: [[sources]] with shape = "box" or another shape'
            )
        for i, emitter in enumerate(self.emitters):
            if found := problem(self.snow_of(emitter), emitter.snow.given()):
                raise wrong(f"emitters.{i}.snow.{found[0]}", found[1])
        for i, source in enumerate(self.sources):
            lies = isinstance(source, Layer) and source.on == "terrain"
            if lies and not any(collider.endless for collider in self.colliders):
                raise wrong(f"sources.{i}.on", "needs ground: a collider that is a terrain or a plane")
            found = problem(self.snow_of(source), source.snow.given())
            if found:
                raise wrong(f"sources.{i}.snow.{found[0]}", found[1])
            found = too_strong(self.completed(source), self.snow_of(source))
            if found:
                key, sentence = found
                whose = (
                    ""
                    if getattr(source, key.partition(".")[0])
                    else f", with the {key.partition('.')[0]} of its kind"
                )
                raise wrong(f"sources.{i}.{key}", f"{sentence}{whose}")
        return self

    @property
    def caption(self) -> str:
        """Return what films and logs must say of the scene, so that nobody is misled; "" for nothing."""
        if self.heat is None or self.heat.heat_speed == 1.0:
            return ""
        return f"heat x {self.heat.heat_speed:g} real time"

    def snow_of(self, source: Source | Emitter) -> Snow:
        """Return the snow of `source`: the scene's snow with the overrides of the source (see `Snow.but`)."""
        return self.snow.but(source.snow)

    def snow_at(self, t: float) -> Snow:
        """Return the scene's snow with the constants that it has at time `t` [s]."""
        names = dict.fromkeys(name for key in self.snow_keyframes for name in key.constants())
        own = [getattr(self.snow, name) for name in names]
        table = [
            [key.constants().get(name, value) for name, value in zip(names, own, strict=True)]
            for key in self.snow_keyframes
        ]
        if not table:
            return self.snow
        now = monotone([key.t for key in self.snow_keyframes], np.array(table, np.float64), t)
        return self.snow.model_copy(update=dict(zip(names, (float(value) for value in now), strict=True)))

    @property
    def is_keyed(self) -> bool:
        """Whether gravity or the snow changes with time."""
        return bool(self.world.keyframes or self.snow_keyframes)

    @property
    def bearers(self) -> tuple[Source | Emitter, ...]:
        """All that snow comes from: the sources, then the emitters."""
        return (*self.sources, *self.emitters)

    @property
    def is_open(self) -> bool:
        """Whether snow comes or goes during the run."""
        return bool(self.emitters or self.sinks)

    def completed(self, source: Source) -> Source:
        """Return `source` with what its snow's kind has, structure, variation, profile, where it has none."""
        kind = SNOWS[self.snow_of(source).kind]
        found: dict[str, Any] = {}
        if source.structure is None and kind.structure:
            found["structure"] = kind.structure
        if source.variation is None and kind.variation:
            found["variation"] = Variation.model_validate(kind.variation)
        if source.profile is None and kind.profile:
            found["profile"] = Profile.model_validate(kind.profile)
        return source.model_copy(update=found) if found else source
