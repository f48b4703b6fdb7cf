"""Meshes and terrain in the picture: where the same analytic body is, with the same light and shadow."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from neve import _render
from neve.colliders.solid import Solid
from neve.geometry.pose import Pose, rotation_matrix
from neve.render.preview import Preview
from neve.scene.schema.scene import Camera, Light, Numerics, Scene, Source

SIZE = (320, 180)
SMALL = (160, 90)
FINISHES = ("paint", "metal", "rubber", "wood", "stone")
CAMERA = Camera(position=(0.0, -6.0, 1.5), target=(0.0, 0.0, 0.5), fov=35)
LIGHT = Light(sun_azimuth=200, sun_elevation=35)
NONE = np.zeros((0, 3), np.float32)
RED = (0.8, 0.02, 0.02)


def at(solid, position=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0)):
    still = np.zeros(3)
    return solid, Pose(np.array(position, float), rotation_matrix(np.radians(rotation)), still, still)


GROUND = at(Solid(name="ground", shape="plane"))


def surface(mesh, flip=False):
    """What a solid holds of a mesh, as far as pictures are concerned; flip: turned inside out."""
    faces = np.asarray(mesh.faces, np.int32)
    return SimpleNamespace(vertices=np.asarray(mesh.vertices), faces=faces[:, ::-1] if flip else faces)


def mesh_solid(mesh, flip=False, color=RED, **more):
    return Solid(name="mesh", shape="mesh", mesh=surface(mesh, flip), color=color, **more)


def ground_of(heights, size=(8.0, 8.0), color=None):
    field = SimpleNamespace(heights=np.asarray(heights, np.float32), size=size)
    return at(Solid(name="terrain", shape="terrain", terrain=field, color=color))


def draw(bodies, x=NONE, threads=0, light=LIGHT, size=SIZE):
    numerics = Numerics(dx=0.1)
    stage = Scene(sources=(Source.of("sphere"),), camera=CAMERA, light=light, numerics=numerics)
    return Preview(stage, *size, threads=threads).draw(x, bodies)


def red(image):
    return image[..., 0] > 1.8 * image[..., 2]


BALL = trimesh.creation.icosphere(subdivisions=4, radius=0.5)
SMALL_BALL = trimesh.creation.icosphere(subdivisions=2, radius=0.5)
BOX = trimesh.creation.box((0.8, 0.6, 0.9))
PAIRS = {
    "ball": (Solid(name="b", shape="sphere", half=np.full(3, 0.5), color=RED), BALL),
    "box": (Solid(name="b", shape="box", half=np.array([0.4, 0.3, 0.45]), color=RED), BOX),
}
PLACE = ((0.1, 0.0, 0.7), (20.0, 10.0, 35.0))


@pytest.mark.parametrize("kind", PAIRS)
def test_a_mesh_is_drawn_as_the_analytic_body(kind):
    """A sphere of 5120 triangles lies within 0.1 % of the ball (a chord of 2 pi / 80 sags 1 - cos pi / 80),
    less than a tenth of a pixel; a box of 12 triangles is the box. So the outlines agree but for pixels that
    lie on them: one in a hundred. What is inside has the same light to 2 % of white on average: same normals
    and paint, and a convex body throws no shadow on itself."""
    analytic, mesh = PAIRS[kind]
    wanted, got = (draw([GROUND, at(solid, *PLACE)]) for solid in (analytic, mesh_solid(mesh)))
    both = red(wanted) & red(got)
    assert both.sum() > 1000
    assert (red(wanted) != red(got)).sum() <= 0.01 * both.sum()
    assert np.abs(wanted.astype(float) - got)[both].mean() < 5.0


@pytest.mark.parametrize("kind", PAIRS)
@pytest.mark.parametrize("azimuth", [120, 240])
def test_a_mesh_throws_the_shadow_of_the_analytic_body(kind, azimuth):
    """The ground beside body and mesh is dark in the same places. The soft edge is the nearest miss in both,
    found by steps or exactly: the line of one brightness within it moves by less than a pixel, and the
    shadow's rim has 6 % of its pixels."""
    analytic, mesh = PAIRS[kind]
    light = Light(sun_azimuth=azimuth, sun_elevation=35)
    empty = draw([GROUND], light=light).astype(float)
    wanted, got = (
        draw([GROUND, at(s, *PLACE)], light=light).astype(float) for s in (analytic, mesh_solid(mesh))
    )
    ground = ~(red(wanted) | red(got))
    ground[1:-1, 1:-1] &= ground[:-2, 1:-1] & ground[2:, 1:-1] & ground[1:-1, :-2] & ground[1:-1, 2:]
    dark = [(np.mean(empty - image, axis=2) > 25) & ground for image in (wanted, got)]
    assert dark[0].sum() > 300
    assert (dark[0] != dark[1]).sum() < 0.06 * dark[0].sum()


@pytest.mark.parametrize("kind", PAIRS)
def test_inside_out_and_torn_meshes_are_drawn(kind):
    """Turned inside out a mesh is the same picture; without a few triangles on its far side it has the same
    outline and no hole."""
    mesh = PAIRS[kind][1]
    whole = draw([GROUND, at(mesh_solid(mesh), *PLACE)])
    flipped = draw([GROUND, at(mesh_solid(mesh, flip=True), *PLACE)])
    assert np.abs(whole.astype(int) - flipped).max() <= 2
    torn = mesh.copy()
    back = torn.triangles_center @ rotation_matrix(np.radians(PLACE[1]))[1] > 0.2
    torn.update_faces(~back)
    assert 0 < back.sum() < len(back)
    assert np.array_equal(red(draw([GROUND, at(mesh_solid(torn), *PLACE)])), red(whole))


def test_a_mesh_shades_itself():
    """Two boxes in one mesh, one towards the sun: where its shadow falls on the other, that is darker."""
    light = Light(sun_azimuth=270, sun_elevation=30)
    far = trimesh.creation.box((1.6, 0.2, 1.6)).apply_translation((0, 1.0, 0.8))
    near = trimesh.creation.box((0.4, 0.2, 0.4)).apply_translation((0, -0.6, 1.4))
    alone, both = (
        draw([GROUND, at(mesh_solid(m))], light=light).astype(float)
        for m in (far, trimesh.util.concatenate([far, near]))
    )
    # The ray up to the near box's middle: 1.5 m nearer is 1.5 tan 30 = 0.87 m higher.
    changed = (alone - both)[..., 0]
    lens = _render.Camera(CAMERA.position, CAMERA.target, CAMERA.up, CAMERA.fov, *SIZE)
    column, row, _ = lens.project((0.0, 0.9, 1.4 - 1.5 * np.tan(np.radians(30))))
    spot = changed[int(row) - 3 : int(row) + 4, int(column) - 3 : int(column) + 4]
    assert spot.min() > 40
    beside = changed[int(row) - 3 : int(row) + 4, int(column) + 22 : int(column) + 26]
    assert np.abs(beside).max() < 12


def test_level_terrain_is_the_plane():
    """Heights of zero are drawn as the ground's plane, up to the horizon: the same soil, the same light."""
    plane, terrain = draw([GROUND]).astype(float), draw([ground_of(np.zeros((9, 9)))]).astype(float)
    assert np.abs(plane - terrain).mean() < 1.0


def test_a_hill_hides_what_is_behind_and_shades_the_ground():
    """A ridge as high as the ball hides it, and the ground on the side away from the sun is darker."""
    x = np.linspace(-4, 4, 81)
    ridge = np.tile(1.6 * np.exp(-(((x + 1.0) / 0.5) ** 2)), (81, 1))
    ball = at(PAIRS["ball"][0], (0.0, 1.0, 0.5))
    flat, hidden = (draw([ground_of(h), ball]) for h in (np.zeros((81, 81)), ridge))
    assert red(flat).sum() > 500
    assert red(hidden).sum() < 0.1 * red(flat).sum()
    light = Light(sun_azimuth=90, sun_elevation=25)  # behind the ridge: its shadow falls towards the camera
    shade, open_air = (draw([ground_of(h)], light=light).astype(float) for h in (ridge, np.zeros((81, 81))))
    near = (slice(130, 150), slice(140, 180))
    assert shade[near].mean() < 0.75 * open_air[near].mean()


def test_a_slope_at_the_edge_of_a_terrain_ends_there():
    """Beyond an edge the edge's height goes on, level across it, however steep the last cell is: ground far
    from a ridge beside the edge looks as if there were no ridge, within one of rounding."""
    level, ridge = np.zeros((41, 41)), np.zeros((41, 41))
    ridge[14:27, 39] = 0.3
    sun_from_behind = Light(sun_azimuth=90, sun_elevation=35)
    size = (4.0, 4.0)
    before, after = (
        draw([ground_of(h, size, color=RED)], light=sun_from_behind).astype(int) for h in (level, ridge)
    )
    lens = _render.Camera(CAMERA.position, CAMERA.target, CAMERA.up, CAMERA.fov, *SIZE)
    column, row, _ = (int(a) for a in lens.project((0.0, 6.0, 0.0)))
    assert np.abs(before - after)[row - 2 : row + 3, column - 5 : column + 6].max() <= 1


def crowd():
    random = np.random.default_rng(3)
    return random.uniform((-1, -1, 0), (1, 1, 0.4), (4000, 3))


@pytest.mark.parametrize("threads", [2, 5])
def test_same_bytes_for_any_number_of_threads(threads):
    x = np.linspace(-4, 4, 41)
    bodies = [
        ground_of(0.2 * np.sin(x)[:, None] * np.cos(x)),
        at(mesh_solid(SMALL_BALL, motion="dynamic"), *PLACE),
        at(mesh_solid(BOX)),
    ]
    many, one = (draw(bodies, crowd(), n, size=SMALL) for n in (threads, 1))
    assert np.array_equal(many, one)


@pytest.mark.parametrize("motion", ["static", "scripted"])
def test_a_picture_does_not_depend_on_the_one_before(motion):
    """A ball passes before a box of triangles: what is kept from earlier frames does not show, and that of
    bodies at rest is dropped when they are found elsewhere after all."""
    stage = Scene(sources=(Source.of("sphere"),), camera=CAMERA, light=LIGHT, numerics=Numerics(dx=0.1))
    box, ball = mesh_solid(BOX), mesh_solid(SMALL_BALL, color=(0.1, 0.1, 0.6), motion=motion)
    preview = Preview(stage, *SMALL)
    for x, fall in ((-1.0, 0.3), (0.2, 0.2), (0.2, 0.1), (0.3, 0.0)):
        last = preview.draw(
            crowd() + np.array((0, 0, fall)), [GROUND, at(box, *PLACE), at(ball, (x, -1.5, 0.6))]
        )
    alone = Preview(stage, *SMALL).draw(crowd(), [GROUND, at(box, *PLACE), at(ball, (0.3, -1.5, 0.6))])
    assert np.array_equal(last, alone)


def test_finishes_differ():
    """Each finish of one colour is another surface; one that is not heard would give the same bytes. Left out
    it is paint; and a plane with a finish is no frozen ground."""
    balls = [draw([GROUND, at(replace(PAIRS["ball"][0], finish=f), *PLACE)], size=SMALL) for f in FINISHES]
    for i, one in enumerate(balls):
        for other in balls[:i]:
            assert np.abs(one.astype(int) - other).max() > 10
    assert np.array_equal(draw([GROUND, at(PAIRS["ball"][0], *PLACE)], size=SMALL), balls[0])
    floor = at(replace(GROUND[0], finish="stone"))
    assert np.abs(draw([floor], size=SMALL).astype(int) - draw([GROUND], size=SMALL)).max() > 10


def test_camera_inside_and_triangles_behind_it():
    """A large box around the camera: triangles that pass the eye's plane are cut, and its wall, in the shade
    and in the haze, is redder than blue everywhere, where without it there is blue sky and grey ground."""
    room = draw([at(mesh_solid(trimesh.creation.box((20.0, 20.0, 20.0))))]).astype(int)
    assert (room[..., 0] > room[..., 2] + 10).all()
