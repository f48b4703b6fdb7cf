"""Volume, centre and moments of bodies: closed forms, and closed meshes against them."""

import numpy as np
import pytest

from neve.colliders.solid import Solid
from neve.geometry.pose import rotation_matrix
from neve.geometry.triangles import tidied
from neve.rigid.inertia import mass_properties, of_inside, of_mesh, of_sheet
from neve.scene.errors import SceneError

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
SIDES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip
"""A cube as twelve triangles that look outward."""


@pytest.mark.parametrize(
    ("shape", "half", "inside", "volume"),
    [
        ("box", [0.3, 0.5, 0.2], lambda q: np.ones(len(q), bool), 8 * 0.3 * 0.5 * 0.2),
        ("sphere", [0.4, 0.4, 0.4], lambda q: (q**2).sum(1) < 1, 4 / 3 * np.pi * 0.4**3),
        ("cylinder", [0.3, 0.3, 0.7], lambda q: (q[:, :2] ** 2).sum(1) < 1, 2 * np.pi * 0.3**2 * 0.7),
    ],
)
def test_closed_forms(shape, half, inside, volume):
    """Volume and moments agree with a sum over 10^6 cells: a share of 6 / 100 of cells is cut by a surface,
    half of each wrongly counted at random places, far less than 1 %."""
    axis = (np.arange(100) + 0.5) / 50 - 1
    q = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    x = q[inside(q)] * half
    dV = np.prod(half) / 50**3
    second = dV * x.T @ x
    bulk = mass_properties(Solid("bodies.0", shape, np.array(half)))
    assert bulk.volume == pytest.approx(volume, rel=1e-12)
    assert dV * len(x) == pytest.approx(volume, rel=1e-2)
    assert bulk.inertia == pytest.approx(np.trace(second) * np.eye(3) - second, rel=1e-2, abs=1e-4 * volume)


def test_mesh_of_a_box_weighs_like_the_box():
    """A turned and shifted box of triangles has the box's volume, centre and moments, to rounding.

    1e3 m away positions carry errors of 1e3 eps, a share of 1e-13 / 0.2 of the size: 1e-11 is enough.
    """
    half, R, shift = (
        np.array([0.3, 0.5, 0.2]),
        rotation_matrix(np.array([0.3, -1.0, 0.4])),
        np.array([1e3, -5.0, 2.0]),
    )
    found = of_mesh(CORNERS * half @ R.T + shift, SIDES)
    box = mass_properties(Solid("bodies.0", "box", half))
    assert found.volume == pytest.approx(box.volume, rel=1e-11)
    assert found.center == pytest.approx(shift, abs=1e-11)
    assert found.inertia == pytest.approx(R @ box.inertia @ R.T, abs=1e-11 * np.trace(box.inertia))
    moments, axes = found.principal()
    assert np.sort(moments) == pytest.approx(np.sort(np.diag(box.inertia)), rel=1e-9)
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_mesh_inside_out_weighs_the_same():
    """Whichever way its triangles look, a closed mesh has the same mass and moments."""
    out, inward = of_mesh(CORNERS, SIDES), of_mesh(CORNERS, SIDES[:, ::-1])
    assert inward.volume == out.volume == pytest.approx(8.0)
    assert inward.inertia == pytest.approx(out.inertia)
    assert np.linalg.eigvalsh(inward.inertia).min() > 0


def test_sheet_weighs_like_a_plate():
    """A square of two triangles and a thickness has volume, centre and moments of the plate, to rounding."""
    corners = np.array([[0, 0, 1], [0.6, 0, 1], [0.6, 0.4, 1], [0, 0.4, 1]], dtype=float)
    found = of_sheet(corners, np.array([[0, 1, 2], [0, 2, 3]]), 0.1)
    plate = mass_properties(Solid("bodies.0", "box", np.array([0.3, 0.2, 0.05])))
    assert found.volume == pytest.approx(plate.volume, rel=1e-13)
    assert found.center == pytest.approx([0.3, 0.2, 1.0], rel=1e-13)
    assert found.inertia == pytest.approx(plate.inertia, abs=1e-16)


@pytest.mark.parametrize("turned", [False, True], ids=["overlap", "inside out"])
def test_parts_weigh_once_each(turned):
    """Of two cubes of edge 2, one half in the other, space counts once; one that is inside out beside the
    other has its mass too. The divergence theorem finds 16, or 0.

    64 cells span 3, or 5: each face may be off by half a cell along x, two of them 5 / 64 of an edge of 2, or
    4 %; of the mean of x^2, which is mostly that of the shift, a little more: 5 %.
    """
    shift = np.array([3.0, 0.0, 0.0] if turned else [1.0, 0.0, 0.0])
    other = SIDES[:, ::-1] if turned else SIDES
    surface = tidied(np.concatenate([CORNERS, CORNERS + shift]), np.concatenate([SIDES, other + 8]))
    found = of_inside(surface, "bodies.0")
    volume = 16.0 if turned else 12.0
    assert found.volume == pytest.approx(volume, rel=0.04)
    assert found.center == pytest.approx(shift / 2, abs=0.04)
    assert found.inertia[0, 0] == pytest.approx(volume * 2 / 3, rel=0.04)
    length2 = 1 / 3 + 9 / 4 if turned else 9 / 12  # mean of x^2 about the middle
    assert found.inertia[2, 2] == pytest.approx(volume * (1 / 3 + length2), rel=0.05)


def test_mesh_without_inside_is_told():
    """A cube with a second one, turned inside out, just within it bounds nothing: one sentence says so."""
    surface = tidied(
        np.concatenate([CORNERS, CORNERS * (1 - 1e-9)]), np.concatenate([SIDES, SIDES[:, ::-1] + 8])
    )
    with pytest.raises(SceneError, match=r"bodies\.0 has no volume to weigh"):
        of_inside(surface, "bodies.0")
