"""Find keys that are set but have no effect, because another key selects something that does not use them.

In `[snow]` such keys are errors: the law decides which constants it uses. Elsewhere they are allowed, so that
the transfer of a complete scene file can be changed; but the user should know.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pydantic import BaseModel

from neve.registry import METHODS
from neve.scene.reading.validation_errors import shown
from neve.scene.schema.material import problem
from neve.scene.schema.roles import Surface
from neve.scene.schema.scene import Camera, Numerics, Scene, Snow
from neve.scene.schema.sources import Emitter, Profile, Source, Variation
from neve.scene.values.allowed import words
from neve.scene.values.choices import LAWS, TRANSFERS, listed, users

FACTORS = ("stiffness", "strength", "density")
"""What a variation or a profile may change."""


def unused(scene: Scene) -> Iterator[str]:
    """Yield a sentence for each key that is set but has no effect, with what would use it."""
    yield from _of_method(scene)
    if "transfer" not in METHODS.get(scene.numerics.method).unread:
        yield from _of_transfer(scene.numerics)
    if scene.numerics.device == "cpu":
        why = 'device = "cpu"'
        yield from _without_effect(scene.numerics, "numerics", "devices", why, 'numerics.device = "cuda"')
    if not scene.numerics.sleep:
        for key in ("sleep_speed", "sleep_after"):
            yield from _without_effect(
                scene.numerics, "numerics", key, "sleep = false", "numerics.sleep = true"
            )
    yield from _of_integrator(scene.numerics)
    for i, source in enumerate(scene.sources):
        if source.variation:
            yield from _of_variation(source.variation, f"sources.{i}.variation")
        if source.profile:
            yield from _of_profile(source.profile, f"sources.{i}.profile")
        yield from _of_strength(scene, source, f"sources.{i}")
    yield from _of_camera(scene.camera)
    solids: dict[str, Sequence[Surface]] = {
        "colliders": scene.colliders,
        "bodies": scene.bodies,
        "robots": scene.robots,
    }
    for kind, surfaces in solids.items():
        for i, surface in enumerate(surfaces):
            if surface.mode == "sticky":
                modes = f'{kind}.{i}.mode = "separate" or "slip"'
                yield from _without_effect(surface, f"{kind}.{i}", "mu_c", 'mode = "sticky"', modes)
    for i, collider in enumerate(scene.colliders):
        if collider.mode != "sticky" and collider.mu_c == 0.0:
            rubs = f'colliders.{i}.mu_c above 0, or mode = "sticky"'
            yield from _without_effect(collider, f"colliders.{i}", "surface_velocity", "mu_c = 0", rubs)
    for i, body in enumerate(scene.bodies):
        name = f"bodies.{i}"
        if body.joint == "free":
            joints = f'{name}.joint = "hinge" or "slide"'
            yield from _without_effect(body, name, "axis", 'joint = "free"', joints)
        if not body.contacts:
            yield from _without_effect(body, name, "friction", "contacts = false", f"{name}.contacts = true")


def _of_method(scene: Scene) -> Iterator[str]:
    """Yield the sentences about what the method of the scene does not read."""
    method = scene.numerics.method
    solver, why = METHODS.get(method), f'method = "{method}"'
    for key in solver.unread:
        yield from _without_effect(scene.numerics, "numerics", key, why, _readers(key))
    snow = scene.snow
    usual = Snow.model_validate({"kind": snow.kind, "law": snow.law, "plasticity": snow.plasticity})
    for key in solver.unread_of(snow):
        if _may_be(snow, key, getattr(usual, key)):
            yield from _without_effect(snow, "snow", key, why, _readers(key, snow), usual)
    for i, source in enumerate(scene.sources):
        yield from _of_own_snow(scene, source, f"sources.{i}.snow")
    for i, emitter in enumerate(scene.emitters):
        yield from _of_own_snow(scene, emitter, f"emitters.{i}.snow")


def _of_own_snow(scene: Scene, bearer: Source | Emitter, name: str) -> Iterator[str]:
    """Yield the sentences about the constants of a source's own snow that the method does not read."""
    if bearer.is_water:
        return
    method, snow, given = scene.numerics.method, scene.snow_of(bearer), bearer.snow.given()
    for key in METHODS.get(method).unread_of(snow):
        usual = getattr(scene.snow, key)
        if key in given and given[key] != usual and _may_be(snow, key, usual):
            yield (
                f'{name}.{key} = {shown(given[key])} has no effect with method = "{method}": '
                f"set {_readers(key, snow)}, or leave {key} out"
            )


def _may_be(snow: Snow, key: str, value: float) -> bool:
    """Say whether `key` of `snow` may have `value`: a small xi allows what a larger one forbids."""
    return problem(snow.model_copy(update={key: value}), {}) is None


def _readers(key: str, snow: Snow | None = None) -> str:
    """Return which methods read `key` of [numerics], or of `snow`, as what to set."""
    solvers = {name: METHODS.get(name) for name in METHODS.names()}
    return "numerics.method = " + words(
        [name for name, s in solvers.items() if key not in (s.unread_of(snow) if snow else s.unread)]
    )


IMPLICIT_KEYS = {
    "implicit_beta": ("semi_implicit",),
    "implicit_rule": ("semi_implicit", "implicit"),
    "implicit_system": ("semi_implicit",),
    "implicit_tolerance": ("semi_implicit", "implicit"),
    "implicit_iterations": ("semi_implicit", "implicit"),
    "implicit_strain": ("semi_implicit", "implicit"),
    "implicit_plasticity": ("implicit",),
    "strain_max": ("explicit",),
}
"""Keys of [numerics] that some integrators alone use."""


def _of_integrator(numerics: Numerics) -> Iterator[str]:
    for key, users_of_key in IMPLICIT_KEYS.items():
        if numerics.integrator not in users_of_key:
            why = f'integrator = "{numerics.integrator}"'
            counts = f"numerics.integrator = {words(users_of_key)}"
            yield from _without_effect(numerics, "numerics", key, why, counts)


def _of_camera(camera: Camera) -> Iterator[str]:
    if camera.follow is not None and camera.target != Camera().target:
        yield (
            f'camera.target has no effect with follow = "{camera.follow}", which takes its place: leave one '
            "of them out, or shift the view by camera.offset"
        )


def _of_transfer(numerics: Numerics) -> Iterator[str]:
    why = f'transfer = "{numerics.transfer}"'
    read = TRANSFERS[numerics.transfer].options
    for key in dict.fromkeys(option for transfer in TRANSFERS.values() for option in transfer.options):
        if key not in read:
            takers = f"numerics.transfer = {words(users(key))}"
            yield from _without_effect(numerics, "numerics", key, why, takers)
    if "flip_damping" in read and numerics.flip_damping != "off":
        why = f"flip_damping = {numerics.flip_damping:g}, which takes its place"
        yield from _without_effect(numerics, "numerics", "flip_alpha", why, 'numerics.flip_damping = "off"')


def _of_variation(noise: Variation, name: str) -> Iterator[str]:
    if not any(getattr(noise, key) for key in FACTORS):
        yield from _idle(noise, name, "amplitude")
    elif noise.pattern == "fractal":
        why = f'pattern = "{noise.pattern}"'
        seamed = f'{name}.pattern = "clods" or "sheets"'
        yield from _without_effect(noise, name, "seam", why, seamed)


def _of_profile(profile: Profile, name: str) -> Iterator[str]:
    if not any(getattr(profile, key) for key in FACTORS):
        yield from _idle(profile, name, "factors")


def _of_strength(scene: Scene, source: Source, name: str) -> Iterator[str]:
    """Yield the sentences about factors on thresholds that the snow of `source` does not have."""
    snow = scene.snow_of(source)
    if snow.plasticity == "none":
        why, what_counts = 'plasticity = "none"', 'plasticity = "snow"'
    else:
        thresholds = [c.name for c in LAWS[snow.law].constants if c.is_threshold]
        if any(getattr(snow, key) for key in thresholds):
            return
        why = listed(f"{key} = 0" for key in thresholds)
        what_counts = f"a {listed(thresholds, 'or')}"
    for part in ("variation", "profile"):
        if table := getattr(source, part):
            yield from _without_effect(table, f"{name}.{part}", "strength", why, what_counts)


def _idle(part: Variation | Profile, name: str, what: str) -> Iterator[str]:
    """Yield the sentence about a table that changes nothing, unless it is empty: an empty one is meant to."""
    changed = [key for key, field in type(part).model_fields.items() if getattr(part, key) != field.default]
    if changed:
        keys = " and ".join(", ".join(changed).rsplit(", ", 1))
        have = "has" if len(changed) == 1 else "have"
        yield (
            f"{name} has no {what}, so its {keys} {have} no effect: set its stiffness, strength or "
            "density, or leave it out"
        )


def _without_effect(
    part: BaseModel, name: str, key: str, why: str, what_counts: str, whose: BaseModel | None = None
) -> Iterator[str]:
    """Yield the sentence about `key` of the table `name`, unless it stands at its default, or `whose`."""
    value, default = getattr(part, key), type(part).model_fields[key].default
    if whose is not None:
        default = getattr(whose, key)
    if value != default:
        given, usual = (shown(list(v) if isinstance(v, tuple) else v) for v in (value, default))
        yield (
            f"{name}.{key} = {given} has no effect with {why}: set {what_counts}, or leave {key} at its "
            f"default, {usual}"
        )
