"""Thin and fast solids let nothing through: a plate of a third of a cell, at 10 m/s, in snow."""

import meshes
import numpy as np
import pytest
from reference import contact
from verification.scenes import box, columns, scene, simulate
from verification.stages import Lab

from neve import _core
from neve.geometry.pose import rotation_matrix
from neve.scene.reading.load import scene_from

DX = 0.05
THIN = 0.3 * DX
TILT = (0.0, 25.0, 40.0)  # degrees
AXES = rotation_matrix(np.radians(TILT))


def plate(**more):
    """A plate wider than the snow, tilted against the grid, that moves 10 m/s along its normal."""
    return {"shape": "box", "center": (0.0, 0.0, 0.0), "size": (THIN, 3.0, 3.0), "rotation": TILT} | more


def across(sim):
    """The particles' signed distances from the plate's middle [m], by id."""
    pose = sim.solids()[0][1]
    return (columns(sim)["x"] - pose.position) @ pose.rotation[:, 0]


@pytest.mark.parametrize("mode", ["separate", "slip", "sticky"])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_plate_in_the_middle_of_snow(mode, precision):
    """Of 4,000 particles on both sides of the plate not one changes side, in 0.6 m of its way.

    The plate cuts a block of snow in two and goes 10 m/s along its normal, 40 of its thicknesses: the half in
    front is swept along, the half behind stays back. A particle may be in the plate by the rounding of x.
    """
    away = 10.0 * AXES[:, 0]
    sim = simulate(
        scene(
            [box(size=(0.5, 0.4, 0.4))],
            [plate(velocity=tuple(away), mode=mode)],
            precision=precision,
            dt="auto",
        )
    )
    start = across(sim)
    assert min((start > 0).sum(), (start < 0).sum()) > 1500
    for _ in range(3):
        sim.advance(0.02)
        now = across(sim)
        assert (np.sign(now) == np.sign(start)).all()
        assert np.abs(now).min() > 0.5 * THIN - 1e-3 * DX
    front, speed = start > 0, columns(sim)["v"] @ AXES[:, 0]
    assert 9.0 < speed[front].mean() < 12.0
    assert now[~front].mean() < -0.3  # the plate has left the other half behind


@pytest.mark.parametrize("kind", ["mesh collider", "box body", "mesh body"])
def test_plates_of_triangles_and_of_the_engine(kind, tmp_path):
    """The same of a plate of triangles, and of plates of 30 kg that the snow slows down and turns as they go.

    A mesh's distance comes from a grid: the particle may be in the plate by what that rounds off, far less
    than half of the plate's thickness, so that the sign still tells the side.
    """
    shape = {"shape": "box", "size": (THIN, 1.2, 1.2)}
    if "mesh" in kind:
        shape = {"shape": "mesh", "file": meshes.written(meshes.box(THIN, 1.2, 1.2), tmp_path / "plate.ply")}
    one = shape | {"center": (0, 0, 0), "rotation": TILT, "velocity": tuple(10.0 * AXES[:, 0]), "mu_c": 0.3}
    lists = {"bodies": [one | {"mass": 30.0}]} if "body" in kind else {"colliders": [one]}
    sim = simulate(
        scene_from(
            {
                "world": {"gravity": (0, 0, 0)},
                "numerics": {"dx": DX},
                "sources": [box(size=(0.5, 0.3, 0.3))],
                **lists,
            }
        )
    )
    start = across(sim)
    assert min((start > 0).sum(), (start < 0).sum()) > 800
    for _ in range(3):
        sim.advance(0.01)
        assert (np.sign(across(sim)) == np.sign(start)).all()
    assert across(sim)[start < 0].mean() < -0.2  # it started at -0.12: the plate has left it behind


def test_blade_that_turns():
    """A thin blade that spins 20 rad/s inside snow carries no particle through itself.

    Its tips, 0.3 m out, move 6 m/s. Looked at 60 times: a particle whose distance along the blade stays
    within its length must not change side between two looks, in which the blade turns by less than 3 degrees.
    """
    blade = {"shape": "box", "size": (0.6, THIN, 2.0), "center": (0, 0, 0), "spin": (0, 0, 20.0), "mu_c": 0.2}
    sim = simulate(scene([box(size=(0.8, 0.8, 0.2))], [blade], precision="float32", dt="auto"))

    def local():
        pose = sim.solids()[0][1]
        return ((columns(sim)["x"] - pose.position) @ pose.rotation)[:, :2]

    before = local()
    for _ in range(60):
        sim.advance(0.0025)
        now = local()
        beside = (np.abs(before[:, 0]) < 0.28) & (np.abs(now[:, 0]) < 0.28)
        near = np.abs(now[:, 1]) < 0.1
        crossed = beside & near & (np.sign(before[:, 1]) != np.sign(now[:, 1]))
        assert not crossed.any()
        before = now
    assert sim.exchanged[0, 6] > 0  # it does work


@pytest.mark.parametrize(("speed", "gap"), [(10.0, 0.02), (3.0, 0.031), (200.0, 0.049)])
@pytest.mark.parametrize("core", [_core.f32, _core.f64])
def test_where_a_particle_is_met(core, speed, gap):
    """A lone particle that a thin wall overtakes within a step goes along with it for the rest of the step.

    The wall goes a cell; the particle is at rest, `gap` in front of its face, and the grid knows nothing of
    the wall. Met after gap / speed it moves with the wall, so it ends on its face, to within the skin of 1e-4
    cells and the rounding of its place (8 eps |x|). The impulse on the wall is minus what the particle got.
    """
    precision = "float32" if core is _core.f32 else "float64"
    lab = Lab(core, precision, "quadratic", "apic", dx=DX, x=[[gap, 0.3, 0.4]], v=[[0, 0, 0]],
              F_E=[np.eye(3)], J_P=[1.0], m=[0.05], V0=[1e-4])  # fmt: skip
    dt = DX / speed
    lab.p2g(dt)
    lab.grid_update(dt)
    at = np.array([-0.5 * THIN, 0.1, 0.2])
    velocity = np.array([speed, 0, 0])
    lab.add_body(contact.Body("box", "separate", 0.3, (THIN, 1, 1), at, np.eye(3), velocity))
    lab.g2p(dt)
    eps = np.finfo(lab.dtype).eps
    np.testing.assert_allclose(lab.state.x, [[DX, 0.3, 0.4]], rtol=0, atol=1e-4 * DX + 8 * eps)
    np.testing.assert_allclose(lab.state.v, [velocity], rtol=4 * eps)
    impulse = lab.grid.take_exchanged(1)[0, :3]
    np.testing.assert_allclose(impulse, -0.05 * velocity, rtol=8 * eps)
