"""Settings of a robot's own file act in the scene as they do in the engine alone, or are named."""

import logging
import warnings

import mujoco
import numpy as np
import pytest

from neve.rigid.assembly import _compiled, _new_spec
from neve.rigid.robots import add_robot
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.schema.bodies import Robot

ROBOT = """<mujoco><compiler {}/>{}
<asset><mesh name="m" vertex="0 0 0 .1 0 0 0 .2 0 0 0 .3 .1 .1 .02"/></asset>
<worldbody><body name="a" pos="0 0 1" euler="10 20 30"><freejoint name="f"/>
  <geom name="g" type="box" size=".1 .2 .3" group="1"/><geom name="h" type="mesh" mesh="m" group="2"/>
  <inertial pos=".1 0 0" mass="3" fullinertia="1 1.1 1.5 .1 0 0"/>
  <body name="b" pos=".5 0 0" axisangle="0 0 1 40"><joint name="j" axis="0 1 0" range="-1 .5" limited="true"/>
    <geom name="p" type="capsule" size=".05 .2" mass="1e-3"/>
    <inertial pos="0 0 0" mass=".001" diaginertia="1e-9 1e-9 3e-9"/>
    <body name="c" pos=".5 0 0"><joint name="k" type="slide" axis="0 1 0" springref="3" stiffness="2"/>
      <geom name="q" size=".05"/></body></body></body></worldbody>
<actuator><motor name="mo" joint="k" ctrlrange="-1 1" gear="2" ctrllimited="true"/>
  <position name="po" joint="j" inheritrange="1" ctrllimited="true" kp="3"/></actuator></mujoco>"""
COMPILERS = (
    "",
    'settotalmass="14"',
    'settotalmass="14" inertiafromgeom="true"',
    'settotalmass="14" boundmass="0.5" boundinertia="0.01"',
    'boundmass="0.5"',
    'boundinertia="0.3"',
    'inertiafromgeom="true"',
    'angle="radian"',
    'eulerseq="ZYX"',
    'autolimits="false"',
    'fitaabb="true"',
    'fusestatic="true"',
    'alignfree="true"',
    'inertiagrouprange="0 1" inertiafromgeom="true"',
)
FIELDS = {
    "body": ("mass", "inertia", "ipos", "iquat"),
    "jnt": ("range", "limited", "stiffness", "qpos0"),
    "geom": ("size", "friction"),
    "actuator": ("ctrlrange", "ctrllimited", "gainprm", "biasprm", "gear", "lengthrange"),
}
NAMES = {"body": "abc", "jnt": "jk", "geom": "ghpq", "actuator": ("mo", "po")}


def both(text, folder):
    """The engine's model of the file alone, that of a scene with it, and what is warned of."""
    path = folder / "robot.xml"
    path.write_text(text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        alone = mujoco.MjSpec.from_file(str(path)).compile()
    spec = _new_spec((0.0, 0.0, -9.81))
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        add_robot(spec, Robot(file=str(path)), "robots.0")
        scene = _compiled(spec)
    heard = [one for one in heard if not issubclass(one.category, ResourceWarning)]  # of earlier tests
    assert all(one.category is SceneWarning for one in heard)
    return alone, scene, [str(one.message) for one in heard]


@pytest.mark.parametrize("compiler", COMPILERS)
def test_settings_of_the_compiler_act(compiler, tmp_path):
    """Masses, inertia, joints, geoms and actuators are those that the engine makes of the file alone."""
    bigger = compiler if "inertiafromgeom" in compiler else f'{compiler} balanceinertia="true"'
    alone, scene, said = both(ROBOT.format(bigger, ""), tmp_path)
    for kind, fields in FIELDS.items():
        accessor = {"jnt": "joint"}.get(kind, kind)
        for name in NAMES[kind]:
            one, other = (getattr(m, accessor)(n) for m, n in ((alone, name), (scene, f"robots.0.{name}")))
            for field in fields:
                assert getattr(other, field) == pytest.approx(getattr(one, field), rel=1e-9, abs=1e-12), field
    if "settotalmass" in compiler:
        assert float(scene.body_mass.sum()) == pytest.approx(14.0)
    assert said == []


def test_the_reach_of_a_muscle_is_that_of_its_file(tmp_path):
    """`lengthrange` of the compiler: the range of a muscle is found at the limits of its joint."""
    text = """<mujoco><compiler><lengthrange uselimit="true" accel="7"/></compiler><worldbody><body>
      <joint name="j" axis="0 1 0" range="-30 40" limited="true"/><geom size=".1"/></body></worldbody>
      <actuator><muscle name="m" joint="j"/></actuator></mujoco>"""
    alone, scene, _ = both(text, tmp_path)
    assert np.ptp(alone.actuator_lengthrange) > 0
    assert scene.actuator_lengthrange == pytest.approx(alone.actuator_lengthrange)


@pytest.mark.parametrize(
    ("option", "named"),
    [
        ('gravity="0 0 -1.62"', "gravity = 0 0 -1.62"),
        ('wind="3 0 0" density="1.2"', "wind = 3 0 0, density = 1.2"),
        ('viscosity="2e-5"', "viscosity = 2e-05"),
        ('actuatorgroupdisable="1 3"', "actuatorgroupdisable = 1 3"),
    ],
)
def test_options_of_physics_are_named(option, named, tmp_path):
    """Another world than the scene's is told in one sentence; how the engine computes is not."""
    _, scene, said = both(
        ROBOT.format('balanceinertia="true"', f'<option {option} timestep="0.01"/>'), tmp_path
    )
    assert len(said) == 1
    assert f"sets {named} in its options, which do not count" in said[0]
    assert scene.opt.gravity == pytest.approx([0, 0, -9.81])
    flag = ROBOT.format(
        'balanceinertia="true"', '<option><flag contact="disable" gravity="disable"/></option>'
    )
    assert 'sets flag contact = "disable", flag gravity = "disable" in' in both(flag, tmp_path)[2][0]
    plain = '<option timestep="0.01" integrator="RK4" cone="elliptic" gravity="0 0 -9.81"/>'
    assert both(ROBOT.format('balanceinertia="true"', plain), tmp_path)[2] == []


def test_what_does_not_matter_is_not_told(tmp_path, caplog):
    """Half a cheetah as in a well-known benchmark: 14 kg, and not a word of sizes, cameras or old words."""
    text = """<mujoco model="c"><compiler angle="radian" inertiafromgeom="true" settotalmass="14"/>
      <size nstack="300000" nuser_geom="1"/><visual><map znear="0.1"/></visual>
      <option gravity="0 0 -9.81" timestep="0.01"/><worldbody><body name="torso" pos="0 0 .7">
      <joint axis="1 0 0" type="slide"/><geom fromto="-.5 0 0 .5 0 0" size="0.046" type="capsule"/>
      <body name="thigh" pos="-.5 0 0"><joint axis="0 1 0" range="-.52 1.05"/><geom size=".05"/></body></body>
      </worldbody></mujoco>"""
    _, scene, said = both(text, tmp_path)
    assert float(scene.body_mass.sum()) == pytest.approx(14.0)
    assert (said, caplog.records) == ([], [])


LINK = """<robot name="r"><link name="base"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
<link name="forearm"><inertial><mass value="{mass}"/>
<inertia ixx="{ixx}" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="{child}"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="40" velocity="1"/></joint></robot>"""


@pytest.mark.parametrize(
    ("keys", "name"),
    [
        ({"mass": "-1"}, 'larger than 1e-15 ."forearm"'),
        ({"mass": "0"}, "forearm"),
        ({"ixx": "9"}, "forearm"),
        ({"child": "hand"}, 'the joint "elbow" names "hand", which is no link'),
    ],
)
def test_errors_name_the_link(keys, name, tmp_path, caplog):
    """A mass below 0, an inertia that no body has, a link that is missing: the link is in the sentence."""
    path = tmp_path / "robot.urdf"
    path.write_text(LINK.format(**{"mass": "1", "ixx": "0.1", "child": "forearm"} | keys))
    with caplog.at_level(logging.WARNING), warnings.catch_warnings():
        warnings.simplefilter("error")  # no word of Python's own
        with pytest.raises(SceneError, match=name):
            add_robot(_new_spec((0, 0, 0)), Robot(file=str(path)), "robots.0")


def test_a_mesh_that_is_missing_is_named_with_its_link(tmp_path):
    """The file alone does not say where in the robot to look."""
    text = LINK.format(mass="1", ixx="0.1", child="forearm")
    path = tmp_path / "robot.urdf"
    path.write_text(text.replace('<sphere radius="0.05"/>', '<mesh filename="package://r/no.stl"/>'))
    with pytest.raises(SceneError, match=r'names a mesh ".*no\.stl" of the link "forearm" that is neither'):
        add_robot(_new_spec((0, 0, 0)), Robot(file=str(path)), "robots.0")


def test_a_robot_that_is_lost_in_its_first_step_is_named(tmp_path):
    """A wheel of 1e11 m makes positions that are no numbers: the sentence names it."""
    path = tmp_path / "robot.xml"
    path.write_text(
        """<mujoco><worldbody><body name="chassis" pos="0 0 0.25"><freejoint/><geom name="hull" size="0.25"/>
        <body name="ball" pos="-0.18 0 -0.1"><joint type="ball"/>
        <geom name="caster" size="99999999999"/></body></body></worldbody></mujoco>"""
    )
    with pytest.raises(SceneError, match=r"^robots\.0\.file = .*caster is 1e\+11 m large"):
        add_robot(_new_spec((0, 0, 0)), Robot(file=str(path)), "robots.0")
