"""Sources that fill the same space: told with volume, mass and density, or cut."""

from __future__ import annotations

import re
import warnings
from typing import Any

import meshes
import numpy as np
import pytest

from neve.mpm.initial import build
from neve.sampling.overlaps import MOST_POINTS
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.load import scene_from

TOLD = re.compile(
    r"^sources\.1 overlaps sources\.0 in (\S+) m3, where snow starts with (\S+) kg/m3 and no stress, "
    r'(\S+) kg in all: move one, or set sources\.1\.overlap = "cut"'
)


def made(sources: list[dict[str, Any]], dx: float = 0.05, **numerics: Any) -> tuple[Any, list[str]]:
    """Return the particles of `sources` and what is warned of."""
    scene = scene_from({"sources": sources, "numerics": {"dx": dx, **numerics}})
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        _, state, _ = build(scene)
    assert all(one.category is SceneWarning for one in heard)
    return state, [str(one.message) for one in heard]


def box(center: Any, size: Any = (0.4, 0.4, 0.4), **more: Any) -> dict[str, Any]:
    return {"shape": "box", "size": list(size), "center": list(center), **more}


@pytest.mark.parametrize(
    ("sampling", "dx"), [("poisson", 0.05), ("jittered", 0.05), ("regular", 0.05), ("jittered", 0.02)]
)
def test_two_boxes_that_share_half(sampling: str, dx: float) -> None:
    """0.4 x 0.4 x 0.2 m3 twice at 400 kg/m3: 0.032 m3 with 800 kg/m3, 25.6 kg."""
    state, said = made([box([0, 0, 0.5]), box([0.2, 0, 0.5])], dx, sampling=sampling)
    assert len(state.x) > MOST_POINTS or dx == 0.05
    assert float(np.sum(state.m)) == pytest.approx(51.2, rel=1e-5)
    (sentence,) = said
    found = TOLD.match(sentence)
    assert found
    volume, density, mass = (float(number) for number in found.groups())
    assert volume == pytest.approx(0.032, rel=0.06)
    assert density == pytest.approx(800.0, rel=0.01)
    assert mass == pytest.approx(density * volume, rel=0.01)


def test_snow_of_two_densities() -> None:
    """100 and 300 kg/m3 make 400 kg/m3 together, turned as they may be; a ball in a box is told whole."""
    light, heavy = {"snow": {"rho0": 100.0}}, {"snow": {"rho0": 300.0}}
    ball = {"shape": "sphere", "radius": 0.15, "center": [0.05, 0.0, 0.5], **heavy}
    _, said = made([box([0, 0, 0.5], rotation=[30, 0, 20], **light), ball], 0.04)
    found = TOLD.match(said[0])
    assert found
    assert float(found[1]) == pytest.approx(4 / 3 * np.pi * 0.15**3, rel=0.05)
    assert float(found[2]) == pytest.approx(400.0, rel=0.01)


@pytest.mark.parametrize(
    "other",
    [
        box([0.4, 0, 0.5]),
        box([0, 0, 0.9], rotation=[0, 0, 45]),
        box([0.45, 0, 0.5]),
        {"shape": "sphere", "radius": 0.2, "center": [0.34, 0.34, 0.75]},
        {"shape": "cylinder", "radius": 0.2, "height": 0.3, "center": [0, 0, 0.85]},
    ],
)
def test_sources_that_touch_or_lie_apart_say_nothing(other: dict[str, Any]) -> None:
    """Faces that meet, and boxes of which only those around them overlap."""
    assert made([box([0, 0, 0.5]), other])[1] == []
    assert made([other, box([0, 0, 0.5])])[1] == []


def test_meshes_and_letters(tmp_path: Any) -> None:
    """A mesh inside a box, and letters through a plate: what one fills is what the other does."""
    cube = {"shape": "mesh", "file": meshes.written(meshes.box(0.2, 0.2, 0.2), tmp_path / "cube.ply")}
    found = TOLD.match(made([box([0, 0, 0.5]), {**cube, "center": [0.05, 0.0, 0.5]}], 0.04)[1][0])
    assert found
    assert float(found[1]) == pytest.approx(0.008, rel=0.05)
    word = {"shape": "text", "text": "I", "height": 0.4, "depth": 0.2, "center": [0, 0, 0.5]}
    alone, _ = made([word], 0.03)
    found = TOLD.match(made([box([0, 0.1, 0.5], [1, 0.2, 1]), word], 0.03)[1][0])
    assert found
    assert float(found[1]) == pytest.approx(0.5 * float(np.sum(alone.V0)), rel=0.1)


def test_a_source_that_is_cut_leaves_out_what_others_fill() -> None:
    """38.4 kg of space: the second box has half of its mass, and no particle in the first."""
    state, said = made([box([0, 0, 0.5]), box([0.2, 0, 0.5], overlap="cut")])
    assert said == []
    assert float(np.sum(state.m)) == pytest.approx(38.4, rel=0.02)
    first = made([box([0, 0, 0.5])])[0]
    assert np.array_equal(state.x[: len(first.x)], first.x)
    assert np.all(state.x[len(first.x) :, 0] > 0.2)
    once, _ = made([box([0, 0, 0.5], overlap="cut"), box([0.2, 0, 0.5])])
    assert float(np.sum(once.m)) == pytest.approx(51.2, rel=1e-5)  # those before it in the list alone


def test_a_source_that_is_cut_away_is_told() -> None:
    """Nothing left is an error, with the names."""
    small = box([0, 0, 0.5], [0.1, 0.1, 0.1], overlap="cut")
    with pytest.raises(
        SceneError, match=r'^sources\.1 lies wholly in sources\.0, and sources\.1\.overlap = "cut"'
    ):
        made([box([0, 0, 0.5]), small])


def test_many_overlaps_are_one_warning() -> None:
    """A row of ten boxes, each half in the one before: nine overlaps, one sentence with their number."""
    (said,) = made([box([0.2 * i, 0, 0.5]) for i in range(10)], 0.1)[1]
    assert "sources.1 overlaps sources.0" in said
    assert "(and likewise 8 others: sources.2, sources.3, sources.4 and so on)" in said
