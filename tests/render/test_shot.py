"""The camera's view over time: keyframes, turntable, and what it follows."""

import itertools
import math

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from neve import _render
from neve.build import solids
from neve.render.shot import Shot, View, opening, robust_mean
from neve.scene.errors import SceneError
from neve.scene.reading.load import load, scene_from, to_toml
from neve.scene.schema.scene import Camera, CameraKeyframe, Collider, Scene, Source
from neve.scene.values.curves import monotone

KEYS = (
    CameraKeyframe(t=0.5, position=(0, -6, 2), target=(0, 0, 0), fov=40),
    CameraKeyframe(t=1.0, position=(1, -6, 2), target=(0, 0, 1)),
    CameraKeyframe(t=3.0, position=(4, -3, 2), target=(0, 0, 1), fov=20, up=(0.1, 0, 1)),
    CameraKeyframe(t=3.5, position=(4, -3, 5), fov=20),
)
KEYED = Camera(position=(0, -6, 2), target=(0, 0, 0.5), fov=35, keyframes=KEYS)


def table(t, camera=KEYED):
    """All numbers of the view at a time."""
    view = Shot(camera).at(t)
    return np.array([*view.position, *view.target, *view.up, view.fov])


def test_keyframes_are_met_and_the_camera_rests_outside():
    """Through each key, what it leaves out being the camera's own; at rest before the first and after the
    last."""
    for key in KEYS:
        own = [
            getattr(key if getattr(key, name) is not None else KEYED, name)
            for name in ("position", "target", "up")
        ]
        expected = [*np.ravel(own), key.fov or KEYED.fov]
        np.testing.assert_allclose(table(key.t), expected, atol=1e-12)
    assert Shot(KEYED).at(-1.0) == Shot(KEYED).at(0.5)
    assert Shot(KEYED).at(9.0) == Shot(KEYED).at(3.5)


def test_keyframes_are_smooth_and_never_overshoot():
    """Velocity is continuous, also where the camera starts and stops; each number stays between its keys."""
    times = np.linspace(0.3, 3.7, 3401)  # a key lies on every 500th
    values = np.array([table(t) for t in times])
    rate = np.diff(values, axis=0) / 1e-3
    assert np.abs(np.diff(rate, axis=0)).max() < 0.01 * np.abs(rate).max() * 3.5
    for a, b in itertools.pairwise(KEYS):
        within = values[(times >= a.t) & (times <= b.t)]
        ends = np.sort([table(a.t), table(b.t)], axis=0)
        assert (within >= ends[0] - 1e-12).all()
        assert (within <= ends[1] + 1e-12).all()


def test_between_inner_keys_it_is_the_standard_curve():
    """The same as SciPy's PCHIP wherever the ends, which rest here, have no part."""
    times, values = np.array([0.0, 0.4, 1.0, 2.5, 3.0, 4.0]), np.array([0.0, 1.0, 3.0, 3.5, 3.2, 0.0])
    curve = PchipInterpolator(times, values)
    for t in np.linspace(0.4, 3.0, 53):
        assert monotone(times, values[:, None], t)[0] == pytest.approx(float(curve(t)), abs=1e-12)


def test_equal_keys_are_constant():
    """Between two equal keys nothing moves, whatever is before and after."""
    values = np.array([[0.0], [2.0], [2.0], [5.0]])
    assert {float(monotone([0.0, 1.0, 2.0, 3.0], values, t)[0]) for t in np.linspace(1, 2, 21)} == {2.0}


def test_turntable_turns_about_the_target():
    """After a quarter turn a camera that looked along y looks along -x; distance and target stay."""
    camera = Camera(position=(1, -4, 3), target=(1, 1, 1), turntable=45)
    view = Shot(camera).at(2.0)
    np.testing.assert_allclose(view.position, (6, 1, 3), atol=1e-12)
    assert view.target == (1, 1, 1)
    np.testing.assert_allclose(Shot(camera).at(8.0).position, camera.position, atol=1e-12)
    assert Shot(camera).at(0.0) == View(camera.position, camera.target, camera.up, camera.fov)
    tilted = Camera(position=(0, -4, 0), target=(0, 0, 0), up=(0, 0, 2), turntable=-90)
    np.testing.assert_allclose(Shot(tilted).at(1.0).position, (-4, 0, 0), atol=1e-12)


def frames(path, rng, count=400, fps=30, duration=2.0):
    """Frames of a bed at rest and of a ball whose middle is `path(t)`: time, x, v, id."""
    bed = rng.uniform((-3, -1, -0.2), (3, 1, 0), (4 * count, 3))
    ball = 0.15 * rng.standard_normal((count, 3))
    id = np.arange(5 * count)
    for k in range(round(duration * fps) + 1):
        t = k / fps
        v = (np.array(path(t + 1e-4)) - path(t)) / 1e-4
        x = np.concatenate([bed, ball + path(t)])
        yield t, x, np.concatenate([0 * bed, v + 0 * ball]), id


def flight(t):
    """A throw that ends on the ground at t = 1 s."""
    t = min(t, 1.0)
    return np.array([-3.0 + 6.0 * t, 0.0, 4.905 * t * (1.0 - t)])


@pytest.mark.parametrize("ahead", [True, False], ids=["rendered", "filmed"])
def test_it_keeps_a_moving_ball_in_the_middle(ahead):
    """A ball thrown over a bed stays in the middle third of the picture; without jitter: from frame to frame
    the view's velocity changes by no more than the ball's own blow, spread over follow_time."""
    camera = Camera(position=(0, -8, 1.5), follow="snow", fov=30)
    shot = Shot(camera, dx=0.05)
    targets = []
    seen = list(frames(flight, np.random.default_rng(1)))
    for frame in seen if ahead else ():
        shot.see(*frame, [])
    for frame in seen:
        shot.see(*frame, [])
        view = shot.at(frame[0], ahead)
        lens = _render.Camera(view.position, view.target, view.up, view.fov, 300, 180)
        column, row, _ = lens.project(tuple(flight(frame[0])))
        assert abs(column - 150) < 50, frame[0]
        assert abs(row - 90) < 30, frame[0]
        targets.append(view.target)
    jerk = np.linalg.norm(np.diff(targets, 2, axis=0), axis=1) * 30
    assert jerk.max() < (1.0 if ahead else 4.0)  # [m/s] a frame, of 6 m/s that stop within one


def test_what_moves_evenly_is_met_exactly():
    """The fitted line has no lag: of a solid at constant velocity the target is its place, in a film as well
    as afterwards; offset is added, and with dolly the camera keeps its distance."""
    camera = Camera(position=(0, -5, 1), follow="colliders.0", offset=(0, 0, 0.5), dolly=True)
    scene = Scene(
        sources=(Source.of("sphere"),), colliders=(Collider.of("box", velocity=(2, 0, 0)),), camera=camera
    )
    shot, none = Shot(camera, solids(scene)), np.zeros((0, 3))
    for k in range(40):
        t = 0.05 * k
        shot.see(t, none, none, np.zeros(0), [np.array([2 * t, 0.0, 0.25])])
        view = shot.at(t, ahead=False)
        np.testing.assert_allclose(view.target, (2 * t, 0, 0.75), atol=1e-9)
        np.testing.assert_allclose(view.position, (2 * t, -5, 1), atol=1e-9)
    np.testing.assert_allclose(shot.at(0.513).target, (1.026, 0, 0.75), atol=1e-9)


def test_a_dolly_stays_at_its_height():
    """A camera that travels along with what falls goes with it across `up` alone, and so never into the
    ground."""
    shot, none = Shot(Camera(position=(0, -5, 1), follow="snow", dolly=True)), np.zeros((1, 3))
    for t in (0.0, 0.1, 0.2):
        shot.see(t, np.array([[3 * t, t, 5.0 - 20.0 * t]]), none, np.zeros(1, int), [])
        np.testing.assert_allclose(shot.at(t, ahead=False).position, (3 * t, t - 5, 1), atol=1e-9)


def test_a_camera_that_has_been_told_what_was_seen_sees_the_same():
    """`recall` of `state` gives the same bits as having seen the frames; a frame counts once."""
    camera = Camera(position=(0, -8, 1.5), follow="snow")
    first, second = Shot(camera), Shot(camera)
    seen = list(frames(flight, np.random.default_rng(2), duration=0.4))
    for frame in seen[:6]:
        first.see(*frame, [])
    second.recall({name: np.array(a) for name, a in first.state().items()})
    for frame in seen:
        first.see(*frame, [])
        second.see(*frame, [])
    assert first.at(0.2) == second.at(0.2)
    assert len(first.state()["times"]) == len(seen)


def test_few_that_fly_far_do_not_draw_the_view_away():
    """Of a cluster and 5 % of it a hundred times as far away, the middle stays within 0.15 of its width."""
    rng = np.random.default_rng(3)
    cluster = rng.standard_normal((1900, 3))
    far = np.concatenate([cluster, np.full((100, 3), 100.0)])
    assert np.linalg.norm(robust_mean(far, np.ones(2000)) - cluster.mean(axis=0)) < 0.15
    one = robust_mean(np.ones((3, 3)), np.ones(3))
    assert one.tolist() == [1.0, 1.0, 1.0]


def test_a_camera_within_what_it_follows_still_looks_somewhere():
    """Where the camera stands in its target, or looks along `up`, the view is finite."""
    shot = Shot(Camera(position=(0, 0, 0), follow="snow"))
    for t, z in ((0.0, 0.0), (1.0, 3.0)):
        shot.see(t, np.array([[0.0, 0.0, z]]), np.zeros((1, 3)), np.zeros(1, int), [])
        view = shot.at(t)
        lens = _render.Camera(view.position, view.target, view.up, view.fov, 30, 18)
        assert all(math.isfinite(a) for a in lens.project(tuple(np.array(view.target) + 0.1)))


BASE = {"sources": [{"shape": "sphere"}], "colliders": [{"shape": "plane"}]}


@pytest.mark.parametrize(
    ("camera", "key", "said"),
    [
        ({"keyframes": [{"t": 1}, {"t": 1}]}, "keyframes.1.t = 1 ", "must be later than the keyframe before"),
        ({"keyframes": [{"target": [4, -6, 2]}]}, "keyframes.0.target", "must differ from camera.position"),
        (
            {"keyframes": [{"position": [0, 0, 0.5]}]},
            "keyframes.0.position",
            "must differ from camera.target",
        ),
        ({"keyframes": [{"up": [0, 0, 0]}]}, "keyframes.0.up", "must not be zero or point along the view"),
        ({"keyframes": [{"position": [0, 0, 9]}]}, "keyframes.0.position", "is no view: up must not be zero"),
        ({"keyframes": [{"fov": 0}]}, "keyframes.0.fov = 0 ", "greater than 1 and less than 170"),
        ({"keyframes": [{"time": 0}]}, "keyframes.0.time", "t, position, target, fov"),
        ({"turntable": 9, "keyframes": [{"t": 1}]}, "turntable = 9 ", "cannot be combined with keyframes"),
        ({"target": [4, -6, 2]}, "target", "must differ from camera.position"),
        ({"follow": "bodies.0"}, "follow = ", 'must name what is there: "snow", "colliders.0"'),
        ({"follow": ""}, "follow = ", 'must be "snow" or the name of a solid'),
        (
            {"follow": "snow", "keyframes": [{"target": [0, 0, 1]}]},
            "keyframes.0.target",
            "cannot be combined with camera.follow",
        ),
        ({"dolly": True}, "dolly = true ", 'needs camera.follow = "snow"'),
        ({"offset": [0, 0, 1]}, "offset", 'needs camera.follow = "snow"'),
        ({"follow": "snow", "follow_time": -1}, "follow_time = -1 ", "use a number from 0"),
    ],
)
def test_wrong_cameras_are_one_sentence(camera, key, said):
    """Key, value and what is allowed; of a film of its own as well."""
    for where, document in (
        ("camera", {"camera": camera}),
        ("outputs.0.camera", {"outputs": [{"kind": "film", "camera": camera}]}),
    ):
        with pytest.raises(SceneError) as error:
            scene_from({**BASE, **document})
        assert f"scene: {where}.{key}" in str(error.value)
        assert said in str(error.value)


def test_a_part_that_no_robot_has_is_one_sentence():
    """What only the file of a robot names is checked when the camera is needed."""
    with pytest.raises(SceneError, match=r'camera.follow = "robots.0.wing" is not there: use snow, col'):
        Shot(Camera(follow="robots.0.wing"), solids(scene_from(BASE)))


def test_moving_cameras_are_read_from_files_and_options(tmp_path):
    """A scene with all of it comes back from its TOML; keyframes can be set on the command line."""
    file = tmp_path / "scene.toml"
    file.write_text(to_toml(scene_from({**BASE, "camera": {"follow": "snow", "dolly": True}})))
    assert load(file).camera.dolly
    changed = load(file, ["camera={keyframes=[{t=0,fov=30},{t=1,position=[0,-3,1],fov=20}]}"])
    assert opening(changed.camera).fov == 30
    file.write_text(to_toml(changed))
    assert load(file) == changed
    assert load(file, ["camera.keyframes.1.fov=25"]).camera.keyframes[1].fov == 25
