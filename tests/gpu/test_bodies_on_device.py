"""Bodies that the snow moves: their velocities are found with those of the snow, as on the processor."""

import numpy as np
import pytest
from gpu.runs import FLOOR, advanced, assert_same, scene
from meshes import ball, written

BLOCK = {"shape": "box", "size": [0.3, 0.3, 0.2], "center": [0, 0, 0.11]}
SPHERE = {"shape": "sphere", "radius": 0.1, "center": [0.02, 0.01, 0.33], "velocity": [1, 0, -6], "mu_c": 0.3}


def compared(*bodies, **numerics):
    """Run bodies that fall into snow on a belt on both devices, and compare; the one of the processor."""
    belt = {**FLOOR, "surface_velocity": [0.5, 0, 0]}
    document = {**scene(belt, source=BLOCK, **numerics), "bodies": list(bodies)}
    cpu, gpu = (advanced(document, device, calls=5) for device in ("cpu", "cuda"))
    assert_same(cpu, gpu, 1e-11)
    rigid, other = cpu.solver.model.rigid, gpu.solver.model.rigid
    assert np.abs(cpu.exchanged[1:]).max() > 1e-3  # they have met
    scale = np.abs(rigid.momentum).max()
    np.testing.assert_allclose(other.momentum, rigid.momentum, rtol=0, atol=1e-11 * scale)
    for a, b in zip(rigid.poses(), other.poses(), strict=True):
        np.testing.assert_allclose(b.position, a.position, rtol=0, atol=1e-12)
        np.testing.assert_allclose(b.omega, a.omega, rtol=0, atol=1e-9 * np.abs(a.omega).max())
    return cpu


@pytest.mark.parametrize("density", [20, 900])
@pytest.mark.parametrize("mode", ["separate", "sticky"])
def test_a_body(some_gpu, density, mode):
    """Lighter and heavier than the snow that it meets; it turns, and Newton's method takes several steps."""
    compared({**SPHERE, "density": density, "mode": mode})
    assert some_gpu is None or not some_gpu.overrun()


def test_a_body_with_play(some_gpu):
    """A surface that snow leaves by a hair: what the nodes keep of it waits for the body as well."""
    sim = compared({**SPHERE, "density": 300, "mode": "slip"})
    assert np.abs(sim.state.modes).max() > 0


def test_a_transfer_that_keeps_changes(some_gpu):
    """What bodies do to the nodes is a change of their velocities too."""
    compared({**SPHERE, "density": 300}, transfer="aflip")


def test_more_bodies_than_are_summed_together(some_gpu, tmp_path):
    """Four bodies near one block, one of them a mesh: each gets its own impulse."""
    small = {**SPHERE, "radius": 0.05, "density": 500}
    mesh = {
        "shape": "mesh", "file": written(ball(0.05), tmp_path / "ball.stl"),
        "center": [0.07, 0.07, 0.28], "velocity": [0, 0, -6], "density": 500,
    }  # fmt: skip
    corners = [(-0.07, -0.07), (-0.07, 0.07), (0.07, -0.07)]
    sim = compared(*({**small, "center": [x, y, 0.28]} for x, y in corners), mesh)
    assert (np.abs(sim.exchanged[1:, 2]) > 0).all()


def test_a_body_that_meets_no_snow(some_gpu):
    """It falls as if there were none."""
    document = {**scene(FLOOR, source=BLOCK), "bodies": [{**SPHERE, "center": [0, 0, 3], "density": 500}]}
    cpu, gpu = (advanced(document, device) for device in ("cpu", "cuda"))
    assert_same(cpu, gpu, 1e-12)
    np.testing.assert_array_equal(gpu.solver.model.rigid.momentum, cpu.solver.model.rigid.momentum)
