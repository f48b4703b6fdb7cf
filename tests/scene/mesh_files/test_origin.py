"""Meshes far from the origin of their file, as map coordinates have it, and what `origin` makes of them."""

import warnings

import numpy as np
import pytest
from meshes import CORNERS, SIDES

from neve.colliders.solid import solid_of
from neve.geometry.mesh import read_mesh
from neve.sampling import fill
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Collider, Numerics, Source

UTM = np.array([500_123.25, 5_000_456.5, 1_000.0])


@pytest.fixture
def far(tmp_path):
    """The file of a box of 1 x 2 x 0.5 m in map coordinates, its lower corner at UTM, and a loose corner."""
    rows = [f"v {x:.3f} {y:.3f} {z:.3f}" for x, y, z in (CORNERS - CORNERS.min(axis=0) + UTM).tolist()]
    faces = ["f " + " ".join(str(i + 1) for i in side) for side in SIDES]
    (tmp_path / "far.obj").write_text("\n".join([*rows, "v 0 0 0", *faces]))
    return str(tmp_path / "far.obj")


@pytest.mark.parametrize(
    ("origin", "low"),
    [
        (tuple(UTM.tolist()), (0, 0, 0)),
        ("center", (-0.5, -1.0, -0.25)),
        ("bottom", (-0.5, -1.0, 0.0)),
        ((UTM[0], UTM[1], 0.0), (0, 0, 1000.0)),
    ],
)
def test_a_point_of_the_file_becomes_the_origin(origin, low, far):
    """The box lies where its file says, as seen from that point: exact, since double precision is kept."""
    surface = read_mesh(Collider.of("mesh", file=far, origin=origin), "colliders.0")
    assert surface.low == pytest.approx(low, abs=1e-9)
    assert surface.high - surface.low == pytest.approx([1.0, 2.0, 0.5], abs=1e-9)
    assert surface.volume == pytest.approx(1.0, rel=1e-9)


def test_origin_comes_before_unit_scale_and_axes(far):
    """`origin` is in the file's own numbers: with y up, the middle of the lower side is that of least y."""
    surface = read_mesh(
        Collider.of("mesh", file=far, origin="bottom", unit="cm", scale=10.0, up="y"), "colliders.0"
    )
    assert surface.low == pytest.approx([-0.05, -0.025, 0.0], abs=1e-10)
    assert surface.high == pytest.approx([0.05, 0.025, 0.2], abs=1e-10)


def test_snow_and_solids_of_map_coordinates(far):
    """Snow fills the box at its `center`, 400 kg/m3 times 1 m3; a collider is met where it is, to 1e-6 m."""
    source = Source.of("mesh", file=far, origin="bottom", center=(2.0, 0.0, 0.0))
    made = fill(source, Numerics(dx=0.25), 0)
    assert made.volume.sum() == pytest.approx(1.0, rel=1e-9)
    assert (made.x.min(axis=0) > [1.5, -1.0, 0.0]).all()
    assert (made.x.max(axis=0) < [2.5, 1.0, 0.5]).all()
    solid = solid_of(Collider.of("mesh", file=far, origin="bottom"), "colliders.0", 0.1)
    phi, _ = solid.mesh.sdf.sample(np.array([[0.0, 0.0, 0.6], [0.6, 0.0, 0.25], [0.0, 0.0, 0.45]]))
    assert phi == pytest.approx([0.1, 0.1, -0.05], abs=1e-6)


def test_too_far_is_refused_with_the_way_out(far):
    """Without `origin` the box is 5 000 km away: the sentence names the key."""
    with pytest.raises(
        SceneError, match=r"beyond 1e6 m \(to 5e\+06 m\).*set colliders\.0\.origin = \"center\""
    ):
        read_mesh(Collider.of("mesh", file=far), "colliders.0")


def test_far_in_cells_is_warned_of(far):
    """100 km away is no error, but single precision is: 0.008 m there, for cells of 0.1 m."""
    with pytest.warns(SceneWarning, match=r"lies 1e\+05 m from its origin.*set colliders\.0\.origin"):
        solid_of(
            Collider.of("mesh", file=far, origin=tuple((UTM - [1e5, 0, 0]).tolist())), "colliders.0", 0.1
        )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solid_of(
            Collider.of("mesh", file=far, origin=tuple((UTM - [10.0, 0, 0]).tolist())), "colliders.0", 0.1
        )


@pytest.mark.parametrize("value", ["middle", [1, 2], [1, 2, "a"], [1e13, 0, 0], 3])
def test_what_is_no_origin_is_told(value, far):
    """The sentence says what is allowed."""
    part = {"shape": "mesh", "file": far, "origin": value}
    with pytest.raises(
        SceneError, match=r'colliders\.0\.origin.*"center" or "bottom" or a list of three numbers'
    ):
        scene_from({"sources": [{"shape": "box"}], "colliders": [part]})
