"""Warnings: legal scenes that may not show what is meant, with a better value that is taken silently."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
import pytest

import neve
from neve.scene.checks.advice import advice, fastest
from neve.scene.errors import SceneWarning
from neve.scene.reading.load import load, scene_from
from neve.scene.reading.presets import presets

BALL = {"shape": "sphere", "radius": 0.2}
CLODS = {"pattern": "clods", "strength": 1.0, "feature_size": 0.2}
PLATE = {"shape": "box", "size": [1.0, 1.0, 0.05]}

# Tables -> what the sentence says, and the tables with the better value that it names.
DOUBTFUL: list[tuple[dict[str, Any], str, dict[str, Any]]] = [
    (
        {"sources": [BALL], "numerics": {"dx": 0.2}},
        r"sources\.0\.radius makes this snow 0\.4 m thick, only 2 cells .*dx = 0\.133 or smaller",
        {"numerics": {"dx": 0.133}},
    ),
    (
        {"sources": [{"shape": "box", "size": [1, 0.1, 1]}]},
        r"sources\.0\.size makes .* 0\.1 m .*dx = 0\.0333 or smaller",
        {"numerics": {"dx": 0.0333}},
    ),
    (
        {"sources": [{"shape": "cylinder", "radius": 0.5, "height": 0.1}]},
        r"sources\.0\.height makes .*dx = 0\.0333 or",
        {"numerics": {"dx": 0.0333}},
    ),
    (
        {"sources": [BALL, {"shape": "layer", "depth": 0.12}]},
        r"sources\.1\.depth makes .* 2\.4 cells .*dx = 0\.04 or",
        {"numerics": {"dx": 0.04}},
    ),
    (
        {"sources": [{"shape": "text", "depth": 0.1}]},
        r"sources\.0\.depth makes",
        {"sources": [{"shape": "text", "depth": 0.15}]},
    ),
    (
        {"sources": [BALL | {"variation": {"strength": 0.2, "feature_size": 0.09}}]},
        r"sources\.0\.variation\.feature_size = 0\.09 .* at least 0\.1, or numerics\.dx = 0\.045 or",
        {"sources": [BALL | {"variation": {"strength": 0.2, "feature_size": 0.1}}]},
    ),
    (
        {"sources": [BALL | {"variation": CLODS | {"seam": 0.03}}]},
        r"sources\.0\.variation\.seam = 0\.03 is below a cell .* at least 0\.05, or numerics\.dx = 0\.03 or",
        {"sources": [BALL | {"variation": CLODS | {"seam": 0.05}}]},
    ),
    (
        {"sources": [BALL | {"variation": CLODS | {"seam": 0.03}}]},
        r"sources\.0\.variation\.seam = 0\.03",
        {"numerics": {"dx": 0.03}},
    ),
    (
        {"sources": [BALL], "snow": {"kind": "crust"}, "numerics": {"dx": 0.12}},
        r"sources\.0\.variation\.feature_size = 0\.2",
        {"numerics": {"dx": 0.1}},
    ),
    (
        {"sources": [BALL], "numerics": {"dt": 3e-3}},
        r"numerics\.dt = 0\.003 exceeds 0\.00253 s, .* of sources\.0: use 0\.00101 or .auto.",
        {"numerics": {"dt": 1.01e-3}},
    ),
    (
        {"sources": [BALL], "colliders": [{"shape": "plane"}, PLATE]},
        r"colliders\.1\.size makes this collider 0\.05 m thin, only 1 cells .* at least 0\.1 m .*dx = 0\.025",
        {"numerics": {"dx": 0.025}},
    ),
    (
        {"sources": [BALL], "colliders": [{"shape": "cylinder", "radius": 0.5, "height": 0.01}]},
        r"colliders\.0\.height makes",
        {"colliders": [{"shape": "cylinder", "radius": 0.5, "height": 0.1}]},
    ),
    (
        {"sources": [BALL], "bodies": [{"shape": "sphere", "radius": 0.04}]},
        r"bodies\.0\.radius makes this body 0\.08 m thin, only 1\.6 cells",
        {"bodies": [{"shape": "sphere", "radius": 0.05}]},
    ),
]


@pytest.mark.parametrize(("tables", "told", "better"), DOUBTFUL)
def test_doubtful_scene_is_one_sentence(tables: dict[str, Any], told: str, better: dict[str, Any]) -> None:
    """One sentence for one doubt, no full stop inside; the better value that it names is taken silently."""
    [sentence] = advice(scene_from(tables))
    assert re.search(told, sentence)
    assert not re.search(r"\n|[.!] [A-Z]|\.$", sentence)
    assert advice(scene_from(tables | better)) == []


@pytest.mark.parametrize("name", presets())
def test_presets_are_beyond_doubt(name: str) -> None:
    """No scene that comes with Neve warns."""
    assert advice(load(name)) == []


def test_limits_are_legal() -> None:
    """Exactly three cells of snow, two of a body or a feature, one of a seam and no noise are silent."""
    edge: dict[str, Any] = {
        "numerics": {"dx": 0.1},
        "sources": [
            {"shape": "box", "size": [0.3, 1, 1], "variation": {"density": 0.1, "feature_size": 0.2}},
            {"shape": "box", "variation": {}},
            {
                "shape": "box",
                "variation": {"pattern": "clods", "strength": 1.0, "seam": 0.1, "feature_size": 0.2},
            },
        ],
        "colliders": [PLATE | {"size": [1, 1, 0.2]}],
    }
    assert advice(scene_from(edge)) == []


@pytest.mark.parametrize(
    ("source", "factor"),
    [
        ({}, 1.0),
        ({"variation": {"stiffness": 1.0}}, np.exp(0.5)),
        ({"variation": {"stiffness": 0.4, "density": 0.4}}, 1.0),
        ({"profile": {"at": [0, 1], "stiffness": [4, 1], "density": [1, 0.5]}}, 2.0),
    ],
)
def test_fastest_is_the_wave_and_the_particle(source: dict[str, Any], factor: float) -> None:
    """c = sqrt(M_c / rho0) = 19.72 m/s at the defaults, times sqrt(stiffness / density); |v| adds.

    |v| = 5 m/s of velocity and 2 rad/s at the ball's surface, 0.2 m away.
    """
    ball = BALL | {"velocity": [3, 0, 4], "spin": [0, 0, 2]} | source
    scene = scene_from({"sources": [ball]})
    assert fastest(scene, scene.sources[0]) == pytest.approx(19.720 * factor + 5.4, rel=1e-4)


def test_simulation_warns() -> None:
    """A Simulation in Python warns through `warnings`, once for each doubt; without doubt it is silent."""
    plate = PLATE | {"center": [0, 0, -1]}
    scene = scene_from({"sources": [BALL], "numerics": {"dx": 0.2}, "colliders": [plate]})
    with pytest.warns(SceneWarning) as told:
        neve.Simulation(scene, threads=1)
    assert [str(warning.message) for warning in told] == advice(scene)
    assert len(told) == 2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        neve.Simulation(scene_from({"sources": [BALL]}), threads=1)
