"""A robot from a file on snow of particles in contact: it stands, drives off, and resumes with its bits."""

import numpy as np
import pytest
from verification.particles.common import particles

import neve

CAR = """
<mujoco model="car">
  <worldbody>
    <body name="hull" pos="0 0 0.33">
      <freejoint/>
      <geom type="box" size=".16 .08 .03" density="200"/>
      <geom type="sphere" size=".03" pos="-.12 0 -.06" friction="0.01"/>
      <body name="left" pos=".08 .12 -.02" quat="1 1 0 0"><joint name="left" axis="0 0 -1"/>
        <geom type="cylinder" size=".08 .03"/></body>
      <body name="right" pos=".08 -.12 -.02" quat="1 1 0 0"><joint name="right" axis="0 0 -1"/>
        <geom type="cylinder" size=".08 .03"/></body>
    </body>
  </worldbody>
  <actuator>
    <velocity joint="left" kv="2" ctrlrange="-20 20"/>
    <velocity joint="right" kv="2" ctrlrange="-20 20"/>
  </actuator>
  <keyframe><key name="go" ctrl="6 6"/></keyframe>
</mujoco>
"""


@pytest.fixture
def drive(tmp_path):
    """Make a car with two driven wheels on a bed of snow."""
    (tmp_path / "car.xml").write_text(CAR)

    def make(threads=1):
        return particles(
            [{"shape": "box", "center": (0.1, 0, 0.1), "size": (0.8, 0.5, 0.2)}],
            [{"shape": "plane", "mu_c": 0.8}],
            gravity=(0, 0, -9.81), snow={"E0": 2e5}, threads=threads, dx=0.08, precision="float32",
            more={"robots": [{"file": str(tmp_path / "car.xml"), "start": "go", "mu_c": 0.8}]},
        )  # fmt: skip

    return make


def total(sim):
    now = sim.diagnostics()
    return np.add(now.momentum, now.bodies_momentum), now


def test_robot_drives_on_particles(drive):
    """It is carried and drives off; along the ground all have the momentum that the ground gave."""
    sim = drive()
    start, _ = total(sim)
    sim.advance(0.5)
    end, now = total(sim)
    hull = next(pose for solid, pose in sim.solids() if solid.name == "robots.0.hull")
    assert hull.position[0] > 0.03
    assert hull.position[2] > 0.2
    given = -sim.exchanged[0, :2]
    np.testing.assert_allclose((end - start)[:2], given, rtol=0, atol=1e-4 * now.mass)
    assert np.abs(given).max() > 1e-3 * now.mass


def test_robot_resumes_with_its_bits(drive):
    """A run that goes on from what was saved, on two threads, is the run itself."""
    sim = drive()
    sim.advance(0.1)
    other = neve.Simulation.restore(sim.scene, sim.arrays(), threads=2)
    for each in (sim, other):
        each.advance(0.1)
    mine, saved = sim.arrays(), other.arrays()
    for name, value in mine.items():
        np.testing.assert_array_equal(value, saved[name], err_msg=name)
