"""Snow: what a law uses, what a kind brings, how a source's snow follows from the scene's."""

from __future__ import annotations

from itertools import product
from typing import Any, get_args

import pytest

from neve.sampling import fill
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from, to_toml
from neve.scene.schema.material import Overrides, Snow, problem, used
from neve.scene.schema.scene import Profile, Scene, Source, Variation
from neve.scene.schema.snow_kinds import SNOWS, Kind
from neve.scene.values.choices import LAWS
from neve.scene.values.fields import rounded_down, rounded_up

WORDS = ("kind", "law", "plasticity")
CHANGES: list[dict[str, Any]] = [
    {},
    {"E0": 9e5},
    {"kind": "powder"},
    {"law": "hencky"},
    {"plasticity": "none"},
]


def snow_of(scene: dict[str, Any], source: dict[str, Any]) -> Snow:
    """Return the snow of one box with the overrides `source` in a scene with the table `scene`."""
    built = scene_from({"snow": scene, "sources": [{"shape": "box", "snow": source}]})
    return built.snow_of(built.sources[0])


def test_kinds_are_the_words_and_are_complete() -> None:
    """Each word has a snow, and each snow a line, a source, a tag, and constants that its law uses."""
    assert set(get_args(Kind)) == set(SNOWS)
    assert next(iter(SNOWS)) == "reference"
    for name, kind in SNOWS.items():
        assert kind.about, name
        assert "\n" not in kind.about, name
        assert kind.source, name
        assert set(kind.constants) <= set(used(kind.law, "snow")), name
        assert all(isinstance(value, float) for value in kind.constants.values()), name
        assert kind.repose is None or (
            kind.repose.source and kind.repose.tag in ("quoted", "derived", "chosen")
        )
        Variation.model_validate(kind.variation)
        Profile.model_validate(kind.profile)


@pytest.mark.parametrize("name", SNOWS)
def test_kind_gives_its_constants(name: str) -> None:
    """All constants of a kind are in its Snow; a key that is written down overrides the kind's."""
    snow = Snow.model_validate({"kind": name})
    assert snow.law == SNOWS[name].law
    for key, value in SNOWS[name].constants.items():
        assert getattr(snow, key) == value
    assert Snow.model_validate({"kind": name, "rho0": 321.0}).rho0 == 321.0


def test_reference_is_the_table_of_the_paper() -> None:
    """Nothing given is `reference`, and the reference is that of Stomakhin et al. 2013, table 2."""
    snow = Snow()
    assert snow == Snow(kind="reference", law="stomakhin2013", plasticity="snow")
    table = {"rho0": 400.0, "E0": 1.4e5, "nu": 0.2, "xi": 10.0, "theta_c": 2.5e-2, "theta_s": 7.5e-3}
    assert {name: getattr(snow, name) for name in table} == table


def test_laws_have_defaults_of_their_own() -> None:
    """cam_clay and drucker_prager start from constants that suit them."""
    own = {"rho0": 250.0, "E0": 3e6, "nu": 0.3, "xi": 1.0, "M": 0.5, "beta": 0.0, "p0": 3e3}
    clay = Snow(law="cam_clay")
    assert {name: getattr(clay, name) for name in own} == own
    sand = Snow(law="drucker_prager")
    assert (sand.rho0, sand.E0, sand.nu, sand.friction_angle, sand.cohesion) == (400, 3.5e5, 0.3, 35, 0)
    assert Snow(law="hencky").E0 == Snow().E0


@pytest.mark.parametrize(("law", "plasticity"), list(product(LAWS, ("snow", "none"))))
def test_a_key_that_is_not_used_keeps_its_default(law: str, plasticity: str) -> None:
    """A key beyond those of the law may stand at its default alone; one that is used takes other values."""
    if plasticity == "none" and not LAWS[law].has_elastic_option:
        with pytest.raises(SceneError, match=rf'snow\.plasticity = "none" .* not used by law = "{law}"'):
            scene_from({"snow": {"law": law, "plasticity": "none"}, "sources": [{"shape": "box"}]})
        return
    base = {"law": law, "plasticity": plasticity}
    for name, field in Snow.model_fields.items():
        if name in WORDS:
            continue
        value = {"cohesion": 5.0, "beta": 0.1}.get(name, 0.9 * field.default)
        changed = base | {name: value}
        if name in used(law, plasticity):
            assert getattr(Snow.model_validate(changed), name) == value
        else:
            with pytest.raises(SceneError, match=rf"snow\.{name} = .* is not used with "):
                scene_from({"snow": changed, "sources": [{"shape": "box"}]})
            assert Snow.model_validate(base | {name: field.default}) == Snow.model_validate(base)


@pytest.mark.parametrize("name", SNOWS)
def test_complete_file_of_a_kind_loads_equal(name: str) -> None:
    """All of a kind spelled out, with the keys that its law does not use, is the same scene again."""
    import tomllib

    scene = scene_from({"snow": {"kind": name}, "sources": [{"shape": "box", "snow": {"rho0": 200.0}}]})
    text = to_toml(scene)
    again = scene_from(tomllib.loads(text))
    assert again == scene
    assert to_toml(again) == text


def test_source_follows_the_scene() -> None:
    """What a source leaves out is the scene's; unused keys of another plasticity fall back to defaults."""
    ours = snow_of({"kind": "icy", "E0": 3e5}, {"theta_c": 0.012})
    assert (ours.kind, ours.xi, ours.E0, ours.theta_c, ours.rho0) == ("icy", 20.0, 3e5, 0.012, 500.0)
    elastic = snow_of({"theta_c": 0.02, "E0": 3e5}, {"plasticity": "none"})
    assert elastic == Snow(plasticity="none", E0=3e5)
    assert snow_of({"theta_c": 0.02, "E0": 3e5}, {"law": "hencky"}) == Snow(
        law="hencky", theta_c=0.02, E0=3e5
    )


def test_source_with_a_kind_or_another_law_starts_anew() -> None:
    """A kind, or a law with other constants, brings its own defaults, whatever stands in [snow]."""
    scene = {"E0": 9e5, "rho0": 123.0, "theta_c": 0.03}
    assert snow_of(scene, {"kind": "wet", "xi": 9.0}) == Snow(kind="wet", xi=9.0)
    assert snow_of(scene, {"law": "cam_clay", "M": 1.2}) == Snow(law="cam_clay", M=1.2)
    assert snow_of({"kind": "slush"}, {"law": "stomakhin2013"}) == Snow()
    assert snow_of({"kind": "slush"}, {"M": 0.7}) == Snow(kind="slush", M=0.7)


@pytest.mark.parametrize("changes", CHANGES)
@pytest.mark.parametrize("name", SNOWS)
def test_snow_of_a_source_is_as_if_written_down(name: str, changes: dict[str, Any]) -> None:
    """`but` skips validation; what it makes passes it unchanged."""
    snow = Snow.model_validate({"kind": name})
    if "plasticity" in changes and not LAWS[snow.law].has_elastic_option:
        assert problem(snow.but(Overrides.model_validate(changes)), changes) is not None
        return
    made = snow.but(Overrides.model_validate(changes))
    assert problem(made, changes) is None
    assert Snow.model_validate(made.model_dump()) == made
    assert hash(Snow.model_validate(made.model_dump())) == hash(made)


def test_hardening_may_not_create_energy() -> None:
    """Crushing by d eps along all axes at stretch 1 - theta: the work is paid for as long as xi theta < 2/3.

    tau_k = (2 mu + 3 lam) theta on three axes: the work is 3 (2 mu + 3 lam) theta d eps. The energy is
    (3 mu + 9/2 lam) theta^2 and grows by the factor xi 3 d eps: 3/2 xi theta of the work. The rule keeps a
    quarter of that in hand; it is met at the limit and refused beyond.
    """
    assert Snow(xi=20.0, theta_c=0.025).xi == 20.0
    assert Snow(xi=0.0, theta_c=0.9, theta_s=1.0).theta_c == 0.9
    for bad in ({"xi": 20.1}, {"theta_s": 0.051}, {"theta_c": 0.02, "theta_s": 0.03, "xi": 17.0}):
        with pytest.raises(SceneError, match=r"must be at most [\d.]+ with .* create energy"):
            scene_from({"snow": bad, "sources": [{"shape": "box"}]})
    assert Snow(plasticity="none").xi == 10.0


@pytest.mark.parametrize("value", [0.0171, 5.0, 17.857142, 999.99, 1.0, 0.1, 123456.0, 833.333])
def test_better_values_are_rounded_to_the_safe_side(value: float) -> None:
    """Three digits, never beyond the limit, never more than one in the last digit away."""
    told = float(rounded_down(value))
    assert 0.99 * value < told <= value * (1 + 1e-12)
    assert value * (1 - 1e-12) <= float(rounded_up(value)) < 1.01 * value
    assert len(rounded_down(value).replace(".", "").strip("0")) <= 3 or "e" in rounded_down(value)


def test_scene_default_is_a_scene_of_one_box() -> None:
    """A scene built in Python takes snow as an object, too."""
    scene = Scene(sources=(Source.of("box", snow=Overrides(xi=5.0)),), snow=Snow(kind="wet"))
    assert scene.snow_of(scene.sources[0]) == Snow(kind="wet", xi=5.0)


def test_kind_brings_its_variation_and_profile() -> None:
    """Crust has a shell: a source without a profile takes it; one that has its own, if empty, keeps it."""
    scene = scene_from(
        {
            "snow": {"kind": "crust"},
            "sources": [
                {"shape": "layer"},
                {"shape": "layer", "profile": {}, "variation": {"density": 0.1}},
                {"shape": "layer", "snow": {"kind": "powder"}},
            ],
        }
    )
    first, second, third = (scene.completed(source) for source in scene.sources)
    assert first.profile == Profile.model_validate(SNOWS["crust"].profile)
    assert first.variation == Variation.model_validate(SNOWS["crust"].variation)
    assert (second.profile, second.variation) == (Profile(), Variation(density=0.1))
    assert (third.profile, third.variation) == (None, None)
    hard = fill(scene.completed(Source.of("layer", depth=0.3)), scene.numerics, 0)
    top = hard.x[:, 2] > 0.26
    assert hard.stiffness[top].mean() > 3.0 * hard.stiffness[~top].mean()
