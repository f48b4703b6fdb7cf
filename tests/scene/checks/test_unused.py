"""Keys without effect are told, with what would make them count; at their defaults they are silent."""

from __future__ import annotations

import re
import tomllib
from typing import Any

import pytest

from neve.scene.checks.advice import advice
from neve.scene.checks.unused import unused
from neve.scene.reading.load import load, scene_from, to_toml
from neve.scene.reading.presets import presets

BOX = {"shape": "box"}


def box(**tables: Any) -> dict[str, Any]:
    """Return the tables of a scene of one box."""
    return {"sources": [BOX | tables]}


def numerics(**values: Any) -> dict[str, Any]:
    """Return the tables of a scene of one box with `values` in [numerics]."""
    return {"sources": [BOX], "numerics": values}


# A scene with a key without effect -> what is told -> two scenes that follow the advice.
IDLE: list[tuple[dict[str, Any], str, dict[str, Any], dict[str, Any]]] = [
    (
        numerics(polypic_modes=27),
        r'numerics\.polypic_modes = 27 has no effect with transfer = "apic": set numerics\.transfer = '
        r'"polypic", or leave polypic_modes at its default, 8',
        numerics(polypic_modes=27, transfer="polypic"),
        numerics(polypic_modes=8),
    ),
    (
        numerics(flip_damping=5.0),
        r'numerics\.flip_damping = 5\.0 .* "apic": set numerics\.transfer = "flip" or "asflip", or .* "off"',
        numerics(flip_damping=5.0, transfer="flip"),
        numerics(flip_damping="off"),
    ),
    (
        numerics(flip_alpha=0.5, transfer="pic"),
        r'numerics\.flip_alpha = 0\.5 .* "pic": set numerics\.transfer = "flip" or "asflip", or .* 0\.95',
        numerics(flip_alpha=0.5, transfer="asflip"),
        numerics(flip_alpha=0.95, transfer="pic"),
    ),
    (
        numerics(flip_alpha=0.5, flip_damping=3.0, transfer="flip"),
        r'flip_alpha = 0\.5 has no effect with flip_damping = 3, .*: set numerics\.flip_damping = "off", or',
        numerics(flip_alpha=0.5, flip_damping="off", transfer="flip"),
        numerics(flip_alpha=0.95, flip_damping=3.0, transfer="flip"),
    ),
    (
        numerics(method="particles", spline="cubic"),
        r'numerics\.spline = "cubic" has no effect with method = "particles": set numerics\.method = "mpm", '
        r'or leave spline at its default, "quadratic"',
        numerics(method="mpm", spline="cubic"),
        numerics(method="particles"),
    ),
    (
        numerics(method="sph", transfer="flip"),
        r'numerics\.transfer = "flip" .* method = "sph": set numerics\.method = "mpm", or .* "apic"',
        numerics(method="mpm", transfer="flip"),
        numerics(method="sph"),
    ),
    (
        numerics(method="sph", flip_alpha=0.5),
        r'numerics\.flip_alpha = 0\.5 .* method = "sph": set numerics\.method = "mpm", or .* 0\.95',
        numerics(method="mpm", transfer="flip", flip_alpha=0.5),
        numerics(method="sph"),
    ),
    (
        numerics(method="particles", initial_volume="grid"),
        r'numerics\.initial_volume = "grid" .* method = "particles": set numerics\.method = "mpm", or',
        numerics(method="mpm", initial_volume="grid"),
        numerics(method="particles"),
    ),
    (
        numerics(method="particles", strain_max=0.1),
        r'numerics\.strain_max = 0\.1 .* "particles": set numerics\.method = "mpm" or "sph", or .* 0\.25',
        numerics(method="sph", strain_max=0.1),
        numerics(method="particles", strain_max=0.25),
    ),
    *(
        (
            numerics(method="particles") | {"snow": {key: value}},
            rf'snow\.{key} = {value} .* "particles": set numerics\.method = "mpm" or "sph", or .* {usual}',
            numerics(method="sph") | {"snow": {key: value}},
            numerics(method="particles") | {"snow": {key: usual}},
        )
        for key, value, usual in (
            ("nu", 0.3, 0.2),
            ("xi", 4.0, 10.0),
            ("J_P_min", 0.7, 0.6),
            ("J_P_max", 5.0, 20.0),
        )
    ),
    (
        numerics(method="particles") | {"snow": {"kind": "wet", "xi": 4.0}},
        r"snow\.xi = 4\.0 has no effect .* or leave xi at its default, 0\.3",
        numerics(method="particles") | {"snow": {"kind": "wet", "xi": 0.3}},
        numerics(method="particles") | {"snow": {"kind": "wet"}},
    ),
    (
        numerics(method="sph") | {"snow": {"kind": "wet", "M": 0.5}},
        r'snow\.M = 0\.5 .* method = "sph": set numerics\.method = "mpm" or "particles", or .* 1\.0',
        numerics(method="particles") | {"snow": {"kind": "wet", "M": 0.5}},
        numerics(method="sph") | {"snow": {"kind": "wet"}},
    ),
    (
        numerics(method="sph") | {"snow": {"kind": "powder", "friction_angle": 30.0}},
        r'snow\.friction_angle = 30\.0 .* "sph": set numerics\.method = "mpm" or "particles", or .* 48\.0',
        numerics(method="particles") | {"snow": {"kind": "powder", "friction_angle": 30.0}},
        numerics(method="sph") | {"snow": {"kind": "powder"}},
    ),
    (
        numerics(method="particles") | box(snow={"xi": 4.0}),
        r'sources\.0\.snow\.xi = 4\.0 .* "particles": set numerics\.method = "mpm" or "sph", or leave xi out',
        numerics(method="sph") | box(snow={"xi": 4.0}),
        numerics(method="particles") | box(snow={"kind": "wet"}),
    ),
    (
        box(variation={"stiffness": 1.0, "seam": 0.2}),
        r'sources\.0\.variation\.seam = 0\.2 .* "fractal": set .*\.pattern = "clods" or "sheets", .* 0\.04',
        box(variation={"stiffness": 1.0, "seam": 0.2, "pattern": "clods"}),
        box(variation={"stiffness": 1.0, "seam": 0.04}),
    ),
    (
        box(variation={"feature_size": 0.3}),
        r"sources\.0\.variation has no amplitude, so its feature_size has no effect: set its",
        box(variation={"feature_size": 0.3, "density": 0.1}),
        box(),
    ),
    (
        box(variation={"pattern": "clods", "seam": 0.3, "seed": 2}),
        r"its pattern, seam and seed have no effect",
        box(variation={"pattern": "clods", "seam": 0.3, "seed": 2, "strength": 1.0}),
        box(variation={}),
    ),
    (
        box(profile={"at": [0.0, 0.1]}),
        r"sources\.0\.profile has no factors, so its at has no effect: set its stiffness, strength or",
        box(profile={"at": [0.0, 0.1], "strength": [2.0, 1.0]}),
        box(),
    ),
    (
        box(variation={"strength": 0.5}, snow={"plasticity": "none"}),
        r'sources\.0\.variation\.strength = 0\.5 .* plasticity = "none": set plasticity = "snow", or .* 0\.0',
        box(variation={"strength": 0.5}, snow={"plasticity": "snow"}),
        box(snow={"plasticity": "none"}),
    ),
    (
        box(profile={"at": [0.0, 0.1], "strength": [2.0, 1.0]}, snow={"kind": "powder"}),
        r"sources\.0\.profile\.strength = \[2\.0, 1\.0\] .* with cohesion = 0: set a cohesion, or .* \[\]",
        box(profile={"at": [0.0, 0.1], "strength": [2.0, 1.0]}, snow={"kind": "powder", "cohesion": 9.0}),
        box(snow={"kind": "powder"}),
    ),
    (
        {"sources": [BOX], "colliders": [{"shape": "plane", "mode": "sticky", "mu_c": 0.2}]},
        r'colliders\.0\.mu_c = 0\.2 .* "sticky": set colliders\.0\.mode = "separate" or "slip", or .* 0\.5',
        {"sources": [BOX], "colliders": [{"shape": "plane", "mode": "slip", "mu_c": 0.2}]},
        {"sources": [BOX], "colliders": [{"shape": "plane", "mode": "sticky", "mu_c": 0.5}]},
    ),
    (
        {"sources": [BOX], "colliders": [{"shape": "plane", "surface_velocity": [1.0, 0.0, 0.0], "mu_c": 0}]},
        r"colliders\.0\.surface_velocity = .* with mu_c = 0: set colliders\.0\.mu_c above 0, or mode",
        {"sources": [BOX], "colliders": [{"shape": "plane", "surface_velocity": [1.0, 0.0, 0.0]}]},
        {"sources": [BOX], "colliders": [{"shape": "plane", "mu_c": 0}]},
    ),
    (
        {"sources": [BOX], "bodies": [BOX | {"axis": [1.0, 0.0, 0.0]}]},
        r'bodies\.0\.axis = .* with joint = "free": set bodies\.0\.joint = "hinge" or "slide", or',
        {"sources": [BOX], "bodies": [BOX | {"axis": [1.0, 0.0, 0.0], "joint": "hinge"}]},
        {"sources": [BOX], "bodies": [BOX]},
    ),
    (
        {"sources": [BOX], "bodies": [BOX | {"friction": 0.9, "contacts": False}]},
        r"bodies\.0\.friction = 0\.9 .* with contacts = false: set bodies\.0\.contacts = true, or .* 0\.5",
        {"sources": [BOX], "bodies": [BOX | {"friction": 0.9}]},
        {"sources": [BOX], "bodies": [BOX | {"contacts": False}]},
    ),
]


@pytest.mark.parametrize(("tables", "told", "used", "plain"), IDLE)
def test_a_key_without_effect_is_told(
    tables: dict[str, Any], told: str, used: dict[str, Any], plain: dict[str, Any]
) -> None:
    """One sentence, and both ways out that it names lead to silence."""
    [sentence] = advice(scene_from(tables))
    assert re.search(told, sentence)
    assert not re.search(r"\n|[.!] [A-Z]|\.$", sentence)
    assert advice(scene_from(used)) == []
    assert advice(scene_from(plain)) == []


@pytest.mark.parametrize("name", presets())
def test_complete_files_are_silent(name: str) -> None:
    """A complete scene.toml spells every key out; that is no reason to warn, nor is another transfer."""
    complete = tomllib.loads(to_toml(load(name)))
    assert list(unused(scene_from(complete))) == []
    complete["numerics"]["method"] = "mpm"
    for transfer in ("pic", "flip", "apic", "polypic", "asflip"):
        assert list(unused(scene_from(complete, [f"numerics.transfer={transfer}"]))) == []


def test_xi_that_allows_a_threshold_is_silent() -> None:
    """Contacts have no xi, but theta_c = 0.1 is allowed with xi = 4, not with 10: it is to stay."""
    tables = numerics(method="particles") | {"snow": {"xi": 4.0, "theta_c": 0.1}}
    assert advice(scene_from(tables)) == []
    tables["snow"]["theta_c"] = 0.05
    [sentence] = advice(scene_from(tables))
    assert sentence.startswith("snow.xi = 4.0 has no effect")


def test_another_transfer_for_a_complete_file() -> None:
    """What was set for the file's transfer is told when `--set` takes another, and the scene still loads."""
    complete = tomllib.loads(to_toml(scene_from(numerics(transfer="flip", flip_alpha=0.99))))
    assert list(unused(scene_from(complete))) == []
    [sentence] = unused(scene_from(complete, ["numerics.transfer=apic"]))
    assert sentence.startswith('numerics.flip_alpha = 0.99 has no effect with transfer = "apic"')
