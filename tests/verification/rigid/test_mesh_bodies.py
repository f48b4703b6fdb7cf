"""Bodies and robots of meshes, and bodies on terrain: frames, inertia, convex hulls, files."""

import numpy as np
import pytest
import trimesh
from meshes import box, joined, sheet, written
from verification.loose import G, bodies_of, exchange, run

from neve.geometry.pose import rotation_matrix
from neve.io.assets import companions
from neve.scene.errors import SceneError

SIZE = np.array([0.2, 0.3, 0.4])
FAR = np.array([0.5, 0.0, 0.1])
"""Where the middle of the box is, seen from the file's origin [m]."""


@pytest.fixture(autouse=True)
def no_cache(tmp_path, monkeypatch):
    """Keep the grids of these meshes out of the user's cache."""
    monkeypatch.setenv("NEVE_CACHE", str(tmp_path / "cache"))


def brick(folder):
    """A box of triangles that lies off the origin of its file, as a table of `[[bodies]]`."""
    mesh = box(*SIZE)
    mesh.apply_translation(FAR)
    return {"shape": "mesh", "file": written(mesh, folder / "brick.ply"), "center": [1.0, 2.0, 3.0],
            "rotation": [0, 0, 90], "density": 500.0}  # fmt: skip


def test_frame_is_the_origin_of_the_file(tmp_path):
    """Places and velocities are those of the file's origin, about which mass and moments are the box's.

    v of the origin is that of the centre of mass less omega x arm; an impulse there moves and turns the body
    as it does the box: omega = I^-1 (-arm x P), dv = P / m - omega x arm.
    """
    rigid = bodies_of([{**brick(tmp_path), "velocity": [1, 0, 0], "spin": [0, 0, 2]}], gravity=[0, 0, 0])
    (pose,) = rigid.poses()
    assert pose.position == pytest.approx([1, 2, 3])
    assert pose.velocity == pytest.approx([1, 0, 0], abs=1e-12)
    arm = rotation_matrix(np.array([0, 0, np.pi / 2])) @ FAR
    mass = 500.0 * SIZE.prod()
    assert rigid.mass == pytest.approx([mass], rel=1e-6)
    p = mass * (np.array([1, 0, 0]) + np.cross([0, 0, 2], arm))
    assert rigid.momentum == pytest.approx(p, abs=1e-6 * mass)  # the file holds single precision
    a, b, c = SIZE
    I = mass / 12 * np.diag([c**2 + a**2, b**2 + c**2, a**2 + b**2])  # noqa: E741 (turned by a quarter)
    P = np.array([0.3, -0.2, 0.5])
    omega = np.linalg.solve(I, np.cross(-arm, P))
    expected = np.concatenate([P / mass + np.cross(omega, -arm), omega])
    assert rigid.motion.mobility @ [*P, 0, 0, 0] == pytest.approx(expected, abs=1e-5)


def test_push_at_the_origin_of_the_file(tmp_path):
    """An impulse at the file's origin adds itself to the momentum and its moment to the angular momentum."""
    rigid = bodies_of([brick(tmp_path)], gravity=[0, 0, 0])
    P, L = np.array([0.3, -0.2, 0.5]), np.array([0.01, 0.02, -0.03])
    rigid.advance(1e-6, exchange([*P, *L]), 0.0)
    assert rigid.momentum == pytest.approx(P, rel=1e-12)
    assert rigid.angular_momentum == pytest.approx(L + np.cross([1, 2, 3], P), rel=1e-5)


def test_mesh_rests_like_the_box(tmp_path):
    """A mesh of a box lies on a plane as the box does, within the hull's single precision."""
    table = {**brick(tmp_path), "center": [0, 0, 0.1], "rotation": [0, 0, 0]}  # 0.1 + 0.1 - 0.4 / 2 = 0
    (pose,) = run(bodies_of([table], [{"shape": "plane"}]), 1e-3, 200)
    assert pose.position[2] == pytest.approx(0.1, abs=1e-5)
    assert np.abs(pose.velocity).max() < 1e-5


def test_bodies_touch_the_convex_hull(tmp_path):
    """Over the gap of a U of three boxes a ball rests on the hull's lid, though the gap is wide enough."""
    left, right, floor = box(0.2, 1.0, 1.0), box(0.2, 1.0, 1.0), box(1.2, 1.0, 0.2)
    left.apply_translation([-0.5, 0, 0.5])
    right.apply_translation([0.5, 0, 0.5])
    floor.apply_translation([0, 0, 0.1])
    U = {"shape": "mesh", "file": written(joined(left, right, floor), tmp_path / "u.ply")}
    ball = {"shape": "sphere", "radius": 0.2, "center": [0, 0, 1.3]}
    (pose,) = run(bodies_of([ball], [U]), 1e-3, 500)
    assert pose.position == pytest.approx([0, 0, 1.2], abs=1e-4)
    with pytest.raises(
        SceneError, match=r"bodies\.0 and colliders\.0 are .* convex hull of a mesh: move one"
    ):
        bodies_of([{**ball, "center": [0, 0, 0.6]}], [U])


def test_sheet_is_a_plate(tmp_path):
    """An open sheet with a thickness weighs area x thickness x density, and lies on both its sides."""
    table = {"shape": "mesh", "file": written(sheet(0.5), tmp_path / "s.ply"), "thickness": 0.04,
             "density": 800.0, "center": [0, 0, 0.02]}  # fmt: skip
    rigid = bodies_of([table], [{"shape": "plane"}])
    assert rigid.mass == pytest.approx([800.0 * 0.25 * 0.04])
    (pose,) = run(rigid, 1e-3, 200)
    assert pose.position[2] == pytest.approx(0.02, abs=1e-5)


def test_bodies_on_terrain(tmp_path):
    """On a slope from a height map a ball without friction slides at g sin, a rough box stays.

    The plane z = 0.2 x + 0.1 y is exact for the bilinear map; a = g |grad h| / sqrt(1 + |grad h|^2).
    """
    x, y = np.linspace(-2, 2, 81)[:, None], np.linspace(-1, 1, 41)[None]
    np.save(tmp_path / "slope.npy", (0.5 + 0.2 * x + 0.1 * y).astype(np.float32))
    ground = {"shape": "terrain", "file": str(tmp_path / "slope.npy"), "size": [4.0, 2.0]}
    normal = np.array([-0.2, -0.1, 1.0]) / np.sqrt(1.05)
    ball = {"shape": "sphere", "radius": 0.1, "friction": 0.0,
            "center": list(np.array([1.0, 0.5, 0.75]) + 0.1 * normal)}  # fmt: skip
    tilt = np.degrees(np.arctan(np.sqrt(0.05))) * np.array([0.1, -0.2, 0.0]) / np.sqrt(0.05)
    block = {"shape": "box", "size": [0.2] * 3, "friction": 1.0, "rotation": list(tilt),
             "center": list(np.array([-1.0, 0.0, 0.3]) + 0.1 * normal)}  # fmt: skip
    slides, stays = run(bodies_of([ball, block], [ground]), 2.5e-4, 1200)
    assert np.linalg.norm(slides.velocity) == pytest.approx(G * np.sqrt(0.05 / 1.05) * 0.3, rel=0.01)
    assert (slides.position - [0, 0, 0.5]) @ normal == pytest.approx(0.1, abs=1e-4)
    assert stays.position == pytest.approx(block["center"], abs=2e-3)


ROUND = """<mujoco><asset><mesh name="wedge" file="parts/wedge.stl"/></asset><worldbody><body name="b">
  <freejoint/><geom type="capsule" size=".1 .2" pos="0 0 1"/><geom type="ellipsoid" size=".1 .2 .3"/>
  <geom name="wedge" type="mesh" mesh="wedge" pos="0 1 0" quat="1 0 0 1"/></body></worldbody></mujoco>"""


def robot(folder):
    """A robot of a capsule, an ellipsoid and a mesh that lies in a folder beside its file."""
    (folder / "parts").mkdir()
    corners, sides = 0.3 * np.eye(4)[:, 1:], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    written(trimesh.Trimesh(corners, sides), folder / "parts" / "wedge.stl")
    (folder / "round.xml").write_text(ROUND)
    return folder / "round.xml"


def test_round_and_meshed_parts_of_a_robot(tmp_path):
    """Capsule, ellipsoid and mesh are solids of triangles: volumes within 1 %, the mesh where it belongs.

    Inscribed polygons of 48 corners enclose at least 1 - (2 pi / 48)^2 / 6 of a circle; in both directions
    together 0.6 % less than the round body.
    """
    rigid = bodies_of([], robots=[{"file": str(robot(tmp_path)), "position": [0, 0, 5]}])
    capsule, ellipsoid, wedge = rigid.solids
    assert [s.name for s in rigid.solids] == ["robots.0.b", "robots.0.b1", "robots.0.wedge"]
    volume = np.pi * 0.1**2 * 0.4 + 4 / 3 * np.pi * 0.1**3
    assert capsule.mesh.surface.volume == pytest.approx(volume, rel=0.01)
    assert ellipsoid.mesh.surface.volume == pytest.approx(4 / 3 * np.pi * 0.006, rel=0.01)
    assert capsule.mesh.surface.open_edges == ellipsoid.mesh.surface.open_edges == 0
    corners = wedge.mesh.vertices @ rigid.poses()[2].rotation.T + rigid.poses()[2].position
    expected = np.array([[0, 1, 5], [0, 1.3, 5], [-0.3, 1, 5], [0, 1, 5.3]])
    for corner in expected:
        assert np.linalg.norm(corners - corner, axis=1).min() < 1e-6
    phi, _ = wedge.mesh.sdf.sample(np.zeros((1, 3)))  # the frame is at the centre of mass
    assert phi[0] < -0.02


def test_files_that_a_robot_names(tmp_path):
    """What MJCF and URDF files name goes with them into a run: meshes, included files, package paths."""
    path = robot(tmp_path)
    assert companions(path) == [tmp_path / "parts" / "wedge.stl"]
    link = (
        '<robot name="r"><link name="a"><collision><geometry><mesh filename="package://r/parts/wedge.stl"/>'
    )
    (tmp_path / "urdf").mkdir()
    (tmp_path / "urdf" / "r.urdf").write_text(f"{link}</geometry></collision></link></robot>")
    assert companions(tmp_path / "urdf" / "r.urdf") == [tmp_path / "parts" / "wedge.stl"]
    rigid = bodies_of([], robots=[{"file": str(tmp_path / "urdf" / "r.urdf")}])
    assert [s.name for s in rigid.solids] == ["robots.0.a"]
