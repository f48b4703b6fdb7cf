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
    for transfer in ("pic", "flip", "apic", "polypic", "asflip"):
        assert list(unused(scene_from(complete, [f"numerics.transfer={transfer}"]))) == []


def test_another_transfer_for_a_complete_file() -> None:
    """What was set for the file's transfer is told when `--set` takes another, and the scene still loads."""
    complete = tomllib.loads(to_toml(scene_from(numerics(transfer="flip", flip_alpha=0.99))))
    assert list(unused(scene_from(complete))) == []
    [sentence] = unused(scene_from(complete, ["numerics.transfer=apic"]))
    assert sentence.startswith('numerics.flip_alpha = 0.99 has no effect with transfer = "apic"')
