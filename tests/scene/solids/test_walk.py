"""What the preset `walk` promises: boots roll and do not slide, stay above the ground, and leave prints."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scripts import ROOT, script

from neve.colliders.motion import pose
from neve.scene import Scene
from neve.scene.reading.load import load
from neve.simulation import Simulation

BOOT, SHIN = 1, 2
"""Colliders of the right leg; the left ones are two further on."""
DEPTH, SINK = 0.11, 0.065
PRINTS = [(-0.7, -0.075), (-0.25, 0.075), (0.2, -0.075), (0.65, 0.075)]
"""Where the middle of each sole is, right and left in turn [m]."""
LANDINGS = [0.1, 0.65, 1.2, 1.75]
"""When each heel touches the snow [s]."""


@pytest.fixture(scope="module")
def sole() -> NDArray[np.float64]:
    """The corners of the boot, (n, 3)."""
    mesh = trimesh.load(ROOT / "src/neve/assets/meshes/boot.ply", process=False)
    return np.asarray(mesh.vertices, np.float64)


@pytest.fixture(scope="module")
def walk() -> Scene:
    """The preset."""
    return load("walk")


def corners(walk: Scene, sole: NDArray[np.float64], number: int, t: float) -> NDArray[np.float64]:
    """The corners of a boot at a time, in the world."""
    at = pose(walk.colliders[number], t)
    return np.asarray(sole @ at.rotation.T + at.position)


def test_the_preset_is_what_the_tool_writes() -> None:
    """Keyframes of boots and shins are those of `tools/walk.py`."""
    with script("tools", "walk") as tool:
        text = tool.PRESET.read_text(encoding="utf-8")
        assert text.partition(tool.MARK)[2] == tool.colliders()
        assert (tool.SURFACE, tool.SINK) == (DEPTH, SINK)


@pytest.mark.parametrize("step", range(4))
def test_a_step_rolls_from_heel_to_toe(walk: Scene, sole: NDArray[np.float64], step: int) -> None:
    """The heel touches first, the sole lies flat at its depth, the toe leaves last; what carries rests.

    Rests: the edge that the boot rolls about moves along by less than 1.5 mm while the sole turns; between
    keyframes 16 degrees apart the chord of a radius of 0.28 m leaves the arc by 0.28 (1 - cos 8) of 2.7 mm.
    """
    number, t, (x, y) = BOOT + 2 * (step % 2), LANDINGS[step], PRINTS[step]
    landing = corners(walk, sole, number, t)
    assert landing[landing[:, 2].argmin(), 0] < x - 0.1
    flat = corners(walk, sole, number, t + 0.3)
    assert flat[:, 2].min() == pytest.approx(DEPTH - SINK, abs=2e-3)
    assert np.abs(flat.mean(0) - (x, y, 0.0))[:2] == pytest.approx(0.0, abs=0.03)
    leaving = corners(walk, sole, number, t + 0.64)
    assert leaving[leaving[:, 2].argmin(), 0] > x + 0.1
    for edge, times in ((-0.14, (0.0, 0.05, 0.1, 0.15, 0.3)), (0.135, (0.3, 0.5, 0.55, 0.6, 0.64))):
        local = np.array([[edge, 0.0, 0.0]])
        places = [corners(walk, local, number, t + dt)[0, 0] for dt in times]
        assert np.ptp(places) < 1.5e-3


def test_no_boot_is_in_the_ground(walk: Scene, sole: NDArray[np.float64]) -> None:
    """In no frame a boot is deeper than a step presses it, and the toe turns in by 8 mm at most; where no
    snow is, it is on the ground around, which is level with the snow."""
    for number in (BOOT, BOOT + 2):
        for t in np.arange(0.0, walk.run.duration, 0.02):
            low = corners(walk, sole, number, t)
            assert low[:, 2].min() > DEPTH - SINK - 0.008
            outside = np.abs(low[:, 0]) > 1.05
            assert not outside.any() or low[outside, 2].min() > DEPTH - 0.008


def test_shins_stay_in_their_boots(walk: Scene) -> None:
    """The lower end of a shin keeps within 2 cm of the middle of the boot's opening, in every frame."""
    colliders = walk.colliders
    for number in (BOOT, BOOT + 2):
        for t in np.arange(0.0, walk.run.duration, 0.02):
            boot, shin = pose(colliders[number], t), pose(colliders[number + 1], t)
            end = shin.position - shin.rotation @ (0.0, 0.0, 0.39)
            opening = boot.position + boot.rotation @ (-0.078, 0.0, 0.25)
            assert np.linalg.norm(end - opening) < 0.02


def test_the_first_step_carries_a_person_and_leaves_a_print() -> None:
    """With a coarse grid the snow bears 300 to 1,000 N under a resting sole: the boots go where they are told
    to, and this is what a person weighs. The print is deeper than half of what the boot sank in, and
    10 cm beside it nothing has moved by a third of a cell.
    """
    around = ["sources.0.size=[0.8, 0.72]", f"sources.0.center=[{PRINTS[0][0]}, 0]"]
    scene = load("walk", ["numerics.dx=0.03", "sources.0.variation.strength=0", *around])
    sim = Simulation(scene)
    boot = [solid.name for solid, _ in sim.solids()].index(f"colliders.{BOOT}")
    before = np.asarray(sim.state.x[np.argsort(sim.state.id)], np.float64)
    sim.advance(0.4)
    impulse = sim.exchanged[boot, 2]
    sim.advance(0.1)
    assert 300.0 < (sim.exchanged[boot, 2] - impulse) / 0.1 < 1000.0
    sim.advance(0.14)
    after = np.asarray(sim.state.x[np.argsort(sim.state.id)], np.float64)
    x, y = PRINTS[0]
    under = (np.abs(after[:, 0] - x) < 0.08) & (np.abs(after[:, 1] - y) < 0.02)
    assert after[under, 2].max() < DEPTH - 0.5 * SINK
    beside = (np.abs(before[:, 1] - y) > 0.05 + 0.1) & (np.abs(before[:, 0] - x) < 0.2)
    assert np.count_nonzero(beside) > 500
    assert np.linalg.norm(after[beside] - before[beside], axis=1).max() < scene.numerics.dx / 3
