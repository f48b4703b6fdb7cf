"""Robots from MJCF and URDF files: they load, stand, drive and hold, and bad files are one sentence."""

import numpy as np
import pytest
from verification.loose import G, bodies_of, run

from neve.scene.errors import SceneError

CAR = """
<mujoco model="car">
  <option timestep="0.01" gravity="0 0 -1" integrator="RK4"/>
  <default>
    <default class="wheel"><geom type="cylinder" size=".1 .03" rgba=".1 .2 .3 1" friction="1.2"/></default>
  </default>
  <worldbody>
    <body name="chassis" pos="0 0 0.15">
      <freejoint/>
      <geom name="hull" type="box" size=".3 .12 .04" density="300"/>
      <geom type="sphere" size=".04" pos="-.2 0 -.11" friction="0.01"/>
      <geom type="box" size=".5 .5 .5" contype="0" conaffinity="0" mass="0"/>
      <body name="left" pos=".1 .2 -.05" quat="1 1 0 0"><joint name="axle_left" axis="0 0 -1"/>
        <geom class="wheel" name="wheel_left"/></body>
      <body name="right" pos=".1 -.2 -.05" quat="1 1 0 0"><joint name="axle_right" axis="0 0 -1"/>
        <geom class="wheel" name="wheel_right"/></body>
    </body>
  </worldbody>
  <actuator>
    <velocity name="drive_left" joint="axle_left" kv="2" ctrlrange="-20 20"/>
    <velocity joint="axle_right" kv="2" ctrlrange="-20 20"/>
  </actuator>
  <keyframe><key name="high" qpos="0 0 1.15 1 0 0 0 0.5 0" ctrl="3 4"/></keyframe>
</mujoco>
"""

LINK = """<link name="{}"><inertial><origin xyz="0 0 {}"/><mass value="{}"/>
  <inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz="0 0 {}"/><geometry>{}</geometry></collision></link>"""
ARM = f"""<robot name="arm">
{LINK.format("base", 0, 1.0, 0, '<box size="0.2 0.2 0.1"/>')}
{LINK.format("upper", 0.25, 2.0, 0.25, '<cylinder radius="0.05" length="0.4"/>')}
{LINK.format("hand", 0.0, 0.5, 0, '<sphere radius="0.05"/>')}
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/>
  <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="40" velocity="1"/></joint>
<joint name="wrist" type="continuous"><parent link="upper"/><child link="hand"/><origin xyz="0 0 0.55"/>
  <axis xyz="1 0 0"/></joint>
</robot>"""


@pytest.fixture
def car(tmp_path):
    """The path of a car on two driven wheels and a sphere that slides."""
    (tmp_path / "car.xml").write_text(CAR)
    return str(tmp_path / "car.xml")


@pytest.fixture
def arm(tmp_path):
    """The path of an arm that stands on a fixed base."""
    (tmp_path / "arm.urdf").write_text(ARM)
    return str(tmp_path / "arm.urdf")


def test_what_collides_becomes_a_solid(car):
    """Each geom that collides is a solid with its name, or its body's, and the file's sizes and colours."""
    robot = {"file": car, "position": [1, 2, 3], "rotation": [0, 0, 90], "mode": "slip", "mu_c": 0.2}
    rigid = bodies_of([{"shape": "box", "center": [9, 9, 9]}], robots=[robot])
    assert [s.name for s in rigid.solids] == [
        "bodies.0", "robots.0.hull", "robots.0.chassis", "robots.0.wheel_left", "robots.0.wheel_right",
    ]  # fmt: skip
    hull, wheel = rigid.solids[1], rigid.solids[3]
    assert (hull.shape, list(hull.half), hull.mode, hull.mu_c) == ("box", [0.3, 0.12, 0.04], "slip", 0.2)
    assert (wheel.shape, list(wheel.half), wheel.motion) == ("cylinder", [0.1, 0.1, 0.03], "dynamic")
    assert wheel.color == pytest.approx((0.1, 0.2, 0.3))
    poses = rigid.poses()
    assert poses[1].position == pytest.approx([1, 2, 3.15])
    assert poses[3].position == pytest.approx([0.8, 2.1, 3.1])  # (.1, .2) turned by a quarter
    assert np.abs(poses[3].rotation[:, 2]) == pytest.approx([1, 0, 0], abs=1e-12)  # the axle


def test_options_of_the_file_do_not_count(car):
    """The scene's gravity moves a robot, not the file's."""
    rigid = bodies_of([], robots=[{"file": car, "position": [0, 0, 5]}])
    pose = run(rigid, 1e-3, 100)[0]
    assert pose.velocity == pytest.approx([0, 0, -G * 0.1], abs=1e-9)


def test_car_drives(car):
    """Two wheels of 0.1 m at 10 rad/s roll a car along x at 1 m/s, with the grip that its file gives them.

    It is on its way after 0.5 s; wheels lag by the drag of the sliding sphere: below 1 % of the speed.
    """
    controls = [
        {"actuator": "drive_left", "value": 0.0}, {"actuator": "drive_left", "t": 0.5, "value": 10.0},
        {"actuator": "axle_right", "value": 0.0}, {"actuator": "axle_right", "t": 0.5, "value": 10.0},
    ]  # fmt: skip
    rigid = bodies_of([], [{"shape": "plane"}], robots=[{"file": car, "controls": controls}])
    pose = run(rigid, 1e-3, 1500)[0]
    assert pose.velocity == pytest.approx([1.0, 0, 0], abs=0.02)
    assert pose.position[2] == pytest.approx(0.15, abs=1e-3)
    assert pose.position[0] == pytest.approx(0.25 + 1.0, abs=0.03)


def test_start_from_a_keyframe(car):
    """A keyframe of the file sets joints and controls, seen from where the scene puts the robot."""
    robot = {"file": car, "position": [1, 0, 0], "rotation": [0, 0, 90], "start": "high"}
    rigid = bodies_of([], gravity=[0, 0, 0], robots=[robot])
    pose = rigid.poses()[0]
    assert pose.position == pytest.approx([1, 0, 1.15])
    assert pose.rotation[:, 0] == pytest.approx([0, 1, 0], abs=1e-12)
    _, _, left, right = run(rigid, 1e-3, 300)
    hull = rigid.poses()[0]
    axle = left.rotation[:, 2]
    assert [-(w.omega - hull.omega) @ axle for w in (left, right)] == pytest.approx([3, 4], rel=0.01)


def test_arm_holds_and_turns(arm):
    """A joint of a URDF file that is controlled goes to its place, an endless one to its speed; weight bends
    the arm by what the place's spring gives: m g l sin / gain, gain = I (4.74 / 0.05 s)^2."""
    controls = [{"actuator": "shoulder", "value": 0.5}, {"actuator": "wrist", "value": 4.0}]
    rigid = bodies_of([], robots=[{"file": arm, "controls": controls}])
    assert [s.name for s in rigid.solids] == ["robots.0.base", "robots.0.upper", "robots.0.hand"]
    base, upper, hand = run(rigid, 1e-3, 500)
    assert base.velocity == pytest.approx([0, 0, 0], abs=0)
    angle = np.arctan2(upper.rotation[0, 2], upper.rotation[2, 2])
    inertia = 0.1 + 2.0 * 0.25**2 + 0.1 + 0.5 * 0.55**2
    bend = (2.0 * 0.25 + 0.5 * 0.55) * G * np.sin(0.5) / (inertia * (4.74 / 0.05) ** 2)
    assert angle - 0.5 == pytest.approx(bend, rel=0.1)
    assert upper.rotation.T @ hand.omega == pytest.approx([4.0, 0, 0], abs=0.05)


def test_free_base(arm):
    """`free` lets an arm fall that the file holds fixed."""
    rigid = bodies_of([], robots=[{"file": arm, "position": [0, 0, 9], "free": True}])
    base, *_ = run(rigid, 1e-3, 100)
    assert base.velocity[2] == pytest.approx(-G * 0.1, rel=1e-6)


def test_robots_do_not_mix(car):
    """Two of the same file are two, with their own names and controls."""
    robots = [
        {"file": car},
        {"file": car, "position": [2, 0, 0], "controls": [{"actuator": "drive_left", "value": 5.0}]},
    ]
    rigid = bodies_of([], robots=robots, gravity=[0, 0, 0])
    poses = run(rigid, 1e-3, 200)
    assert [s.name for s in rigid.solids][4:] == [
        s.name.replace("robots.0", "robots.1") for s in rigid.solids[:4]
    ]
    assert np.abs(poses[2].omega).max() < 1e-9
    assert np.abs(poses[6].omega).max() > 1.0


def test_goes_on_with_the_same_bits(car):
    """A driven car goes on from a saved state with the bits of a run in one go."""
    robot = {"file": car, "controls": [{"actuator": "drive_left", "value": 8.0}]}
    whole, first, second = (bodies_of([], [{"shape": "plane"}], robots=[robot]) for _ in range(3))
    run(whole, 7e-4, 150)
    run(first, 7e-4, 70)
    second.restore(first.save())
    assert np.array_equal(second.motion.acceleration, first.motion.acceleration)
    run(second, 7e-4, 80, done=70)
    assert np.array_equal(whole.save()["engine"], second.save()["engine"])


def told(robot):
    """The sentence of the error that a robot ends in."""
    with pytest.raises(SceneError) as error:
        bodies_of([], robots=[robot])
    assert "\n" not in str(error.value)
    return str(error.value)


BAD = {
    "hello": "cannot be read as a robot:",
    "": "cannot be read as a robot: ",
    "<mujoco><wrldbody/></mujoco>": "schema violation: unrecognized element (line 1)",
    "<robot name='x'></robot>": "has no geometry that collides",
    "<mujoco><worldbody><body><freejoint/></body></worldbody></mujoco>": "has no geometry that collides",
    "<mujoco><worldbody><body><joint/><geom size='1' mass='0'/></body></worldbody></mujoco>": "mass and",
    "<mujoco><worldbody><body><geom type='box'/></body></worldbody></mujoco>": "size 0 must be positive",
    "<mujoco><asset><mesh name='m' file='none.stl'/></asset><worldbody><geom type='mesh' mesh='m'/>"
    "</worldbody></mujoco>": "none.stl",
    "<robot name='x'><link name='a'><collision><geometry><mesh filename='package://p/m.stl'/></geometry>"
    "</collision></link></robot>": 'names a mesh "package://p/m.stl" of the link "a" that is neither beside',
}


@pytest.mark.parametrize("text", BAD, ids=range(len(BAD)))
def test_bad_files_are_told_in_one_sentence(text, tmp_path):
    """A file that is no robot is named with its key and what is wrong in it."""
    path = tmp_path / "bad.xml"
    path.write_text(text)
    sentence = told({"file": str(path)})
    assert sentence.startswith('robots.0.file = "')
    assert BAD[text] in sentence


def test_bad_controls_are_told_in_one_sentence(car, arm):
    """An actuator, a value, an order in time or a keyframe that the robot does not know."""
    assert (
        '"drive" is not an actuator (did you mean "drive_left"?): this robot has drive_left, axle_right'
        in told({"file": car, "controls": [{"actuator": "drive"}]})
    )
    assert 'robots.0.controls.0.value = 30 is not allowed: "drive_left" takes -20 to 20' in told(
        {"file": car, "controls": [{"actuator": "drive_left", "value": 30.0}]}
    )
    assert '"shoulder" takes -1 to 1' in told(
        {"file": arm, "controls": [{"actuator": "shoulder", "value": 2.0}]}
    )
    twice = [{"actuator": "drive_left", "t": 1.0}, {"actuator": "drive_left", "t": 1.0}]
    assert 'must be later than the one before it for "drive_left", greater than 1 [s]' in told(
        {"file": car, "controls": twice}
    )
    assert 'robots.0.start = "low" is not a keyframe of the robot: its file has high' in told(
        {"file": car, "start": "low"}
    )
    assert 'robots.0.free = true is not allowed: the base "chassis" has a joint' in told(
        {"file": car, "free": True}
    )
