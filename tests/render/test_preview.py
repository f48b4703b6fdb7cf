"""Pictures: what is drawn where, and the same bytes whenever the same thing is drawn."""

import numpy as np
import pytest

from neve import _render
from neve.build import solids
from neve.colliders.motion import pose
from neve.render.preview import Preview
from neve.scene.schema.scene import Camera, Collider, Light, Numerics, Scene, Source

SIZE = (320, 180)
CAMERA = Camera(position=(0.0, -6.0, 1.5), target=(0.0, 0.0, 0.5), fov=35)
GROUND = Collider.of("plane")
DX = 0.1
NONE = np.zeros((0, 3), np.float32)


def scene(*colliders, camera=CAMERA, light=None, dx=DX):
    light = light or Light(sun_azimuth=200)
    numerics = Numerics(dx=dx)
    return Scene(
        sources=(Source.of("sphere"),), colliders=colliders, camera=camera, light=light, numerics=numerics
    )


def placed(scene, t=0.0):
    """The solids of a scene where they are at time t."""
    return [(s, pose(c, t)) for s, c in zip(solids(scene), scene.colliders, strict=True)]


def draw(scene, x, t=0.0, threads=0, **keywords):
    bodies = placed(scene, t)
    return Preview(scene, *SIZE, threads=threads).draw(x, bodies, **keywords)


def ball(center, radius, spacing=DX / 2):
    axis = np.arange(-radius, radius, spacing) + spacing / 2
    x = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    return (x[np.linalg.norm(x, axis=1) < radius] + center).astype(np.float32)


def pixel(point, camera=CAMERA):
    """Row and column of the pixel that shows a point."""
    lens = _render.Camera(camera.position, camera.target, camera.up, camera.fov, *SIZE)
    column, row, _ = lens.project(tuple(float(a) for a in point))
    return int(row), int(column)


def patch(image, point):
    """Mean colour of the 5x5 pixels around a point."""
    row, column = pixel(point)
    return image[row - 2 : row + 3, column - 2 : column + 3].mean(axis=(0, 1))


@pytest.mark.parametrize(
    ("point", "shown"),
    [
        ((0, 0, 0), (100, 50, 10)),
        ((1, 0, 0), (105, 50, 10)),
        ((0, 0, 2), (100, 40, 10)),
        ((2, 10, -4), (105, 60, 20)),
    ],
)
def test_camera_projects_known_points(point, shown):
    """A camera ten metres in front, 90 degrees high on 100 pixels: focal length 50, so column = 100 + 50
    x / depth and row = 50 - 50 z / depth."""
    camera = _render.Camera((0, -10, 0), (0, 0, 0), (0, 0, 1), 90, 200, 100)
    assert camera.project(point) == pytest.approx(shown, abs=1e-4)


def test_a_ball_of_snow_is_where_the_camera_puts_it():
    """Bright pixels are those within the ball's projected radius: focal * r / sqrt(d^2 - r^2) around its
    centre."""
    center, radius = np.array([0.6, 0.0, 0.8]), 0.4
    stage = scene(GROUND)
    bright = np.abs(draw(stage, ball(center, radius)).astype(int) - draw(stage, NONE)).sum(axis=2) > 20
    row, column = pixel(center)
    distance = np.linalg.norm(center - CAMERA.position)
    wide = 90 / np.tan(np.radians(17.5)) * radius / np.sqrt(distance**2 - radius**2)
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    away = np.hypot(rows - row, columns - column)
    assert bright[away < wide - 2].mean() > 0.97
    upper = (away > wide + 3) & (rows < row)  # the shadow lies below
    assert not bright[upper].any()


def test_snow_is_bright_and_keeps_its_texture():
    """Sunlit snow is far brighter than the ground, hardly any pixel is clipped, and neighbours differ."""
    image = draw(scene(GROUND), ball((0, 0, 0.8), 0.5)).astype(float)
    row, column = pixel((-0.1, -0.4, 1.0))
    lit = image[row - 8 : row + 8, column - 8 : column + 8]
    assert lit.mean() > 185
    assert lit.mean() > 1.5 * image[-30:].mean()
    assert (lit == 255).mean() < 0.01
    assert lit.std() > 3


def test_shade_is_blue_and_sun_is_warm():
    """Sunlit snow has more red than blue relative to snow in the shade."""
    stage = scene(GROUND, light=Light(sun_azimuth=180, sun_elevation=20))
    image = draw(stage, ball((0, 0, 0.8), 0.6))
    sunny, shady = patch(image, (-0.5, -0.2, 0.9)), patch(image, (0.5, -0.2, 0.9))
    assert sunny.mean() > 1.2 * shady.mean()
    assert sunny[0] / sunny[2] > 1.05 * shady[0] / shady[2]


@pytest.mark.parametrize("azimuth", [135, 225])
def test_shadow_on_the_ground_lies_opposite_the_sun(azimuth):
    """A ball at height z darkens the ground at distance z / tan(elevation), away from the sun."""
    stage = scene(GROUND, light=Light(sun_azimuth=azimuth, sun_elevation=45))
    empty, image = (draw(stage, x).astype(float) for x in (NONE, ball((0, 0, 1.0), 0.3)))
    turn = np.radians(azimuth)
    shadow = -np.array([np.cos(turn), np.sin(turn), 0])
    assert patch(image, shadow).mean() < 0.7 * patch(empty, shadow).mean()
    other = np.array([-shadow[0], shadow[1], 0])
    assert patch(image, other).mean() > 0.9 * patch(empty, other).mean()


def test_a_box_shades_snow():
    """Snow behind a box, seen from the sun, is darker than without the box."""
    x = ball((0, 0, 0.5), 0.5)
    light = Light(sun_azimuth=180, sun_elevation=20)
    wall = Collider.of("box", center=(-2.0, 0.0, 1.0), size=(0.1, 3.0, 2.0), visible=True)
    open_air, shaded = (draw(scene(*bodies, light=light), x) for bodies in ([GROUND], [GROUND, wall]))
    spot = (-0.2, -0.45, 0.6)
    assert patch(shaded, spot).mean() < 0.85 * patch(open_air, spot).mean()


RED = (0.8, 0.02, 0.02)
BODIES = [
    Collider.of("box", center=(0.0, 0.0, 0.5), size=(0.8, 0.8, 0.8), rotation=(0, 0, 30), color=RED),
    Collider.of("sphere", center=(0.0, 0.0, 0.5), radius=0.4, color=RED),
    Collider.of("cylinder", center=(0.0, 0.0, 0.5), radius=0.4, height=0.8, color=RED),
    Collider.of("plane", point=(0.0, 0.0, 0.0), normal=(0, -1, 0), color=RED),
]


@pytest.mark.parametrize("body", BODIES, ids=lambda body: body.shape)
def test_what_is_nearer_hides_what_is_behind(body):
    """A red body shows red; snow before it hides it, snow behind it is hidden."""
    stage, center = scene(GROUND, body), (0.0, 0.0, 0.5)
    alone, before, behind = (
        patch(draw(stage, x), center) for x in (NONE, ball((0, -1.5, 0.7), 0.3), ball((0, 1.5, 0.5), 0.3))
    )
    assert alone[0] > 2 * alone[2]
    assert behind[0] > 2 * behind[2]
    assert before[0] < 1.2 * before[2]


def test_a_body_that_is_not_visible_is_not_drawn():
    hidden = Collider.of("box", center=(0.0, 0.0, 0.5), color=RED, visible=False)
    assert np.array_equal(draw(scene(GROUND, hidden), NONE), draw(scene(GROUND), NONE))


def test_a_body_is_drawn_where_its_pose_is():
    """A box that moves at 1 m/s is 0.8 m farther at t = 0.8 s, although the ground's pixels are kept."""
    stage = scene(
        GROUND,
        Collider.of("box", center=(-0.8, 0.0, 0.3), size=(0.4, 0.4, 0.6), velocity=(1, 0, 0), color=RED),
    )
    preview = Preview(stage, *SIZE)
    first, second = (preview.draw(NONE, placed(stage, t)) for t in (0.0, 0.8))
    here, there = (-0.8, -0.2, 0.3), (0.0, -0.2, 0.3)
    red = [
        [a[0] > 1.8 * a[2] for a in (patch(image, here), patch(image, there))] for image in (first, second)
    ]
    assert red == [[True, False], [False, True]]
    assert np.array_equal(second, draw(stage, NONE, t=0.8))


def test_no_particles_and_only_bad_ones_draw_the_ground():
    """An empty set and a set of NaN and infinity give the same picture: ground below a bluer, brighter
    sky."""
    bad = np.full((40, 3), np.nan)
    bad[20:] = np.inf
    stage = scene(GROUND, camera=Camera(position=(0, -6, 1), target=(0, 0, 1)))
    image = draw(stage, NONE)
    assert np.array_equal(draw(stage, bad), image)
    sky, ground = image[:60].mean(axis=(0, 1)), image[-60:].mean(axis=(0, 1))
    assert sky.mean() > ground.mean()
    assert sky[2] / sky[0] > 1.1 * ground[2] / ground[0]


def test_bad_particles_do_not_disturb_the_good():
    """NaN at the end of the array changes no byte."""
    x = ball((0, 0, 0.6), 0.3)
    with_bad = np.concatenate([x, np.full((7, 3), np.nan, np.float32)])
    stage = scene(GROUND)
    # The number of grains follows the number of particles: 7 more of 900 leave it as it is.
    assert np.array_equal(draw(stage, with_bad), draw(stage, x))


def test_a_lone_flake_is_seen():
    """One particle before the sky lightens the pixels around its place and no others."""
    stage = scene(camera=Camera(position=(0, -6, 1), target=(0, 0, 1)))
    flake = np.array([[0.5, 0.0, 1.4]], np.float32)
    change = np.abs(draw(stage, flake).astype(int) - draw(stage, NONE)).sum(axis=2)
    row, column = pixel(flake[0], stage.camera)
    assert change[row - 3 : row + 4, column - 3 : column + 4].max() > 40
    change[row - 12 : row + 13, column - 12 : column + 13] = 0
    assert change.max() == 0


def test_a_flake_smaller_than_a_pixel_fades():
    """A flake a tenth as wide changes the picture, but by far less than a tenth."""
    camera = Camera(position=(0, -6, 1), target=(0, 0, 1))
    flake = np.array([[0.5, 0.0, 1.4]], np.float32)
    sums = []
    for dx in (0.05, 0.005):
        stage = scene(camera=camera, dx=dx)
        sums.append(np.abs(draw(stage, flake).astype(int) - draw(stage, NONE)).sum())
    assert 0 < sums[1] < 0.1 * sums[0]


def crowd():
    """A ball, loose flakes around it, some far away, some behind the camera."""
    random = np.random.default_rng(7)
    return np.concatenate(
        [ball((0, 0, 0.6), 0.5), random.normal((0, 0, 1), 0.8, (400, 3)), random.uniform(-1e4, 1e4, (50, 3))]
    )


@pytest.mark.parametrize("threads", [2, 3, 8])
def test_same_bytes_for_any_number_of_threads(threads):
    stage, x = scene(GROUND, *BODIES[:1]), crowd()
    assert np.array_equal(draw(stage, x, threads=threads), draw(stage, x, threads=1))


def test_a_picture_does_not_depend_on_the_one_before():
    """What a preview keeps between frames does not show."""
    stage, x = scene(GROUND, BODIES[0].model_copy(update={"velocity": (0.5, 0.2, 0.0)})), crowd()
    preview = Preview(stage, *SIZE)
    for t in (0.0, 1.0, 1.0, 0.4):
        last = preview.draw(x + t, placed(stage, t))
    assert np.array_equal(last, draw(stage, x + 0.4, t=0.4))


def test_a_film_of_all_that_moves_is_drawn_as_each_picture_alone():
    """Of a frame only what it changes is drawn anew. Snow and a box come, go and rest, drops fall, a
    solid that rests is taken away and comes back: whatever the frames before left, a picture is that of a
    preview that has drawn none."""
    moving = BODIES[0].model_copy(update={"center": (-0.6, -0.5, 0.6), "velocity": (0.5, 0.2, 0.0)})
    resting = BODIES[1].model_copy(update={"center": (-1.0, 0.3, 0.5)})
    stage, less = scene(GROUND, moving, resting), scene(GROUND, moving)
    snow = ball((0, 0, 0.6), 0.4)
    few = np.concatenate([snow, snow[:50] + np.float32([0.9, 0.3, 0.2])])
    water = np.zeros(len(few), np.float32)
    water[-50:] = 1.0
    far, none = snow + np.float32([0.6, 0.5, 0.4]), np.zeros((0, 3), np.float32)
    frames = [(stage, x, t, {}) for x, t in ((snow, 0.0), (snow, 0.0), (far, 0.0), (far, 0.5), (snow, 0.5))]
    frames += [(stage, few, 0.5, {"water": water}), (stage, few, 0.5, {}), (stage, none, 0.5, {})]
    frames += [(less, snow, 0.5, {}), (less, snow, 2.0, {}), (stage, far, 2.0, {}), (stage, none, 40.0, {})]
    preview = Preview(stage, *SIZE, threads=2)
    for k, (of, x, t, more) in enumerate(frames):
        image = preview.draw(x, placed(of, t), **more)
        assert np.array_equal(image, draw(of, x, t=t, **more)), f"frame {k}"


def test_any_layout_and_float_type():
    """float64, columns in memory and every second row of a larger array give the same picture."""
    stage, x = scene(GROUND), ball((0, 0, 0.6), 0.4)
    wide = np.zeros((2 * len(x), 5), np.float32)
    wide[::2, 1:4] = x
    wanted = draw(stage, x)
    for same in (x.astype(np.float64), np.asfortranarray(x), wide[::2, 1:4]):
        assert np.array_equal(draw(stage, same), wanted)


def test_loosened_snow_is_drawn_looser():
    """J_P above one spreads the grains: the picture changes; J_P of one does not change it."""
    stage, x = scene(GROUND), ball((0, 0, 0.6), 0.4)
    assert np.array_equal(draw(stage, x, J_P=np.ones(len(x))), draw(stage, x))
    assert not np.array_equal(draw(stage, x, J_P=np.full(len(x), 1.5)), draw(stage, x))
    with pytest.raises(ValueError, match="J_P has one number per particle"):
        draw(stage, x, J_P=np.ones(3))
