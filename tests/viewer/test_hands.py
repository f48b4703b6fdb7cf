"""Bodies on joints are pulled by springs, and motors held at values, through the engine."""

import numpy as np
import pytest
from viewer.conftest import SMALL, converse

from neve.rigid.hand import RATE, Spring
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from, to_toml
from neve.simulation import Simulation
from neve.viewer.protocol.commands import Drive
from neve.viewer.show import prepare
from neve.viewer.tools.hands import controls_of, drive

ANCHOR = np.array([3.0, 0.0, 1.6])
PENDULUM = {
    "shape": "box", "center": [3.0, 0.0, 1.3], "size": [0.1, 0.1, 0.6], "density": 500.0,
    "joint": "hinge", "axis": [0.0, 1.0, 0.0], "anchor": ANCHOR.tolist(),
}  # fmt: skip
WHEEL = {
    "shape": "cylinder", "center": [3.0, 2.0, 1.0], "radius": 0.2, "height": 0.1, "density": 500.0,
    "joint": "hinge", "axis": [0.0, 0.0, 1.0], "anchor": [3.0, 2.0, 1.0],
    "motor": {"kind": "velocity", "target": 2.0},
}  # fmt: skip
SCENE = SMALL | {"bodies": [PENDULUM, WHEEL]}


def simulated():
    return Simulation(scene_from(SCENE), threads=1)


def test_a_pendulum_hangs_where_spring_and_weight_balance():
    """At rest the moments of k (target - p), k = M RATE^2, and of the weight add up to nothing.

    It settles as exp(-RATE t / 2), 6e-6 of the way after 2 s.
    """
    sim = simulated()
    rigid = sim.solver.placed.rigid
    grip, target = np.array([0.0, 0.0, -0.3]), np.array([3.8, 0.0, 1.4])
    rigid.hand.springs["bodies.0"] = Spring(grip, target)
    sim.advance(2.0)
    pose, mass = rigid.poses()[0], rigid.mass[0]
    p = pose.position + pose.rotation @ grip
    pull = np.cross(p - ANCHOR, mass * RATE**2 * (target - p))
    weight = np.cross(pose.position - ANCHOR, mass * np.array([0.0, 0.0, -9.81]))
    assert abs(weight[1]) > 1.0  # it hangs far from straight down
    assert pull[1] == pytest.approx(-weight[1], rel=1e-3)
    assert np.linalg.norm(pose.omega) < 1e-3
    rigid.hand.springs.clear()
    sim.advance(0.2)
    assert np.linalg.norm(rigid.poses()[0].omega) > 0.5  # let go it swings back


def test_a_motor_is_held_within_its_range_and_given_back():
    """Held, its control is the value within the range; given back, the scene's; the wheel follows."""
    sim = simulated()
    rigid = sim.solver.placed.rigid
    assert [(c["name"], c["low"], c["high"], c["value"]) for c in controls_of(sim)] == [
        ("bodies.1", -4.0, 4.0, 2.0)
    ]
    for value, spin in ((-3.0, -3.0), (99.0, 4.0), (None, 2.0)):
        drive(Drive(do="drive", name="bodies.1", value=value), sim)
        sim.advance(1.0)
        assert rigid.poses()[1].omega[2] == pytest.approx(spin, rel=0.05)
    with pytest.raises(SceneError, match=r"is no control; there are bodies\.1"):
        drive(Drive(do="drive", name="bodies.0", value=1.0), sim)


def test_a_page_pulls_and_what_it_cannot_pull_is_told(tmp_path):
    """A spring of a page acts while it plays and ends when let go; a collider is no body."""
    path = tmp_path / "bodies.toml"
    path.write_text(to_toml(scene_from(SCENE)), encoding="utf-8")
    server = prepare(str(path), out=str(tmp_path / "out"), threads=1)

    async def talk(page, port):
        pull = {"do": "pull", "grip": [0, 0, -0.3], "target": [3.8, 0, 1.4]}
        solids = page.message("scene")["solids"]
        assert [solid["name"] for solid in solids if solid["pulled"]] == ["bodies.0", "bodies.1"]
        assert [control["name"] for control in page.message("scene")["controls"]] == ["bodies.1"]
        await page.send(name="colliders.1", **pull)
        await page.until(lambda p: "only bodies" in (p.message("refused") or {}).get("sentence", ""))
        await page.send(name="bodies.0", **pull)
        await page.send(do="frame")
        await page.until(lambda p: p.head["frame"] == 1)
        hand = server.player._sim.solver.placed.rigid.hand
        assert list(hand.springs) == ["bodies.0"]
        row = page.head["poses"][len(solids) - 2]
        assert row[0] > 3.002  # pulled towards x = 3.8
        await page.send(name="bodies.0", **pull, done=True)
        await page.send(do="drive", name="bodies.1", value=-1.0)
        await page.send(do="frame")
        await page.until(lambda p: p.head["frame"] == 2)
        assert not hand.springs
        assert hand.controls == {"bodies.1": -1.0}

    converse(server, talk)
