"""Describe a whole scene: what the user asked for, plain checked data in SI units, z up, no arrays."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from pydantic import model_validator

from neve.learned.shipped import untrained
from neve.scene.schema.bodies import AnyBody, Body, Control, Motor, Robot, Target
from neve.scene.schema.camera import Camera, CameraKeyframe, Light, unknown
from neve.scene.schema.colliders import AnyCollider, Collider, Keyframe
from neve.scene.schema.file_shapes import Layer
from neve.scene.schema.material import Heat, Overrides, Snow, SnowKeyframe, Water, problem
from neve.scene.schema.numerics import Numerics
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
from neve.scene.values.choices import TRANSFERS, users
from neve.scene.values.curves import monotone
from neve.scene.values.fields import (
    CURVES,
    FRITSCH,
    SHORTEST,
    Part,
    Rate3,
    Real,
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
    water: Water = entry(Water(), 'Water of the sources of phase = "water".', "")
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

    @model_validator(mode="before")
    @classmethod
    def _fallen(cls, values: Any) -> Any:
        if isinstance(values, dict) and "snowfall" in values:
            raise wrong("snowfall", 'is a source: write [[sources]] with shape = "snowfall"')
        return values

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
    def _integrator(self) -> Scene:
        if self.numerics.is_implicit:
            word = self.numerics.integrator
            able = [name for name, found in TRANSFERS.items() if not found.separate_position_velocity]
            for key, only in (("method", ("mpm",)), ("device", ("cpu", "auto")), ("transfer", able)):
                if (other := getattr(self.numerics, key)) not in only:
                    raise wrong(
                        "numerics.integrator",
                        f'cannot be "{word}" with numerics.{key} = "{other}": set {words(only)}',
                    )
            if self.numerics.sleep:
                raise wrong(
                    "numerics.integrator",
                    f'cannot be "{word}" with numerics.sleep = true: set "explicit", or sleep = false',
                )
            if self.heat:
                raise wrong(
                    "numerics.integrator", f'cannot be "{word}" with heat: set "explicit", or leave heat out'
                )
            if self.numerics.implicit_rule == "midpoint":
                self._midpoint()
        return self

    def _midpoint(self) -> None:
        beta = self.numerics.implicit_beta
        if self.numerics.integrator == "semi_implicit" and beta != 1:  # each step would add energy
            raise wrong(
                "numerics.implicit_rule",
                f'cannot be "midpoint" with numerics.implicit_beta = {beta}: set implicit_beta = 1',
            )
        for name in ("bodies", "robots"):
            if getattr(self, name):
                raise wrong(
                    "numerics.implicit_rule",
                    f'cannot be "midpoint" with {name}: set "end", or leave {name} out',
                )
        with_modes = users("polypic_modes")
        if (word := self.numerics.transfer) in with_modes:
            able = [name for name, found in TRANSFERS.items() if not found.separate_position_velocity]
            others = words([name for name in able if name not in with_modes])
            raise wrong(
                "numerics.implicit_rule",
                f'cannot be "midpoint" with numerics.transfer = "{word}": set transfer to {others}',
            )

    @model_validator(mode="after")
    def _learned(self) -> Scene:
        if self.numerics.integrator != "implicit" or self.numerics.implicit_plasticity != "learned":
            return self
        times = sorted({0.0, *(key.t for key in self.snow_keyframes)})
        for snow in (self.snow_at(t).but(bearer.snow) for t in times for bearer in self.bearers):
            if found := untrained(snow.law, snow.plasticity, snow.constants()):
                key, allowed = found
                value = getattr(snow, key)
                shown = f'"{value}"' if isinstance(value, str) else f"{value:g}"
                raise wrong(
                    "numerics.implicit_plasticity",
                    f'cannot be "learned" with {key} = {shown}, which no network was trained for: {allowed}, '
                    'or set implicit_plasticity = "return_map"',
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
            if source.is_water:
                continue
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
        """Return the snow of `source`, the scene's with its overrides (see `Snow.but`); of water its row."""
        return self.water.material if source.is_water else self.snow.but(source.snow)

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
