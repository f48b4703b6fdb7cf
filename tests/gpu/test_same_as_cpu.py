"""The kernels of the GPU do what the stages of the processor do: run by a stand-in, to rounding.

Some 20 steps. Sums are made in another order, which costs some eps of their largest term, and the SVD stops
when all lanes of a pack have converged, where a kernel looks at one matrix: 1e-12 in double leaves room for
both, and would show a weight, a term or a limit that is another. In float the same room is 1e-5.

With NEVE_TEST_GPU=1 they run on the GPU of this machine.
"""

import numpy as np
import pytest
from gpu.runs import FLOOR, LUMP, advanced, assert_same, by_id, scene
from meshes import ball, box, written

from neve.scene.values.choices import LAWS, TRANSFERS

EXACT, SINGLE = 1e-12, 1e-5


def compared(document, tolerance=EXACT):
    """Run a scene on both, and compare; the one of the processor."""
    cpu = advanced(document, "cpu")
    assert_same(cpu, advanced(document, "cuda"), tolerance)
    return cpu


@pytest.mark.parametrize("transfer", list(TRANSFERS))
def test_each_transfer(some_gpu, transfer):
    """A lump with spin that lands on a floor."""
    modes = {"polypic_modes": 27} if transfer == "polypic" else {}
    source = {**LUMP, "spin": [0, 20, 0]}
    sim = compared(scene(FLOOR, source=source, transfer=transfer, **modes))
    assert np.abs(sim.exchanged).max() > 1  # it has landed
    assert some_gpu is None or not some_gpu.overrun()


def test_polypic_with_eight_modes(some_gpu):
    """The multilinear modes: products of the weights' slopes, and four columns beyond C."""
    sim = compared(scene(FLOOR, source={**LUMP, "spin": [0, 20, 0]}, transfer="polypic", polypic_modes=8))
    assert sim.state.modes.shape[1] == 4
    assert np.abs(sim.state.modes).max() > 0


def test_a_mesh_that_is_turned_and_turns(some_gpu, tmp_path):
    """A box of triangles, askew: its samples are read in its own axes, which move."""
    mesh = {
        "shape": "mesh", "file": written(box(0.5, 0.4, 0.3), tmp_path / "box.stl"),
        "center": [0.05, 0, -0.15], "rotation": [20, -30, 50], "spin": [0, 30, 60], "mu_c": 0.2,
    }  # fmt: skip
    sim = compared(scene(mesh))
    assert np.abs(sim.exchanged[0, 3:6]).max() > 0.01


@pytest.mark.parametrize("law", list(LAWS))
def test_each_law(some_gpu, law):
    """Crushed in the landing: J_P changes where the law flows."""
    fast = {**LUMP, "size": [0.15, 0.15, 0.15], "velocity": [0, 0, -15], "snow": {"law": law}}
    compared(scene(FLOOR, source=fast))


def test_single_precision(some_gpu):
    """The default step, in the default precision."""
    compared(scene(FLOOR, precision="float32"), SINGLE)


def test_elastic_lump(some_gpu):
    """Without gravity, solids and flow: it vibrates, and keeps its momentum."""
    document = scene(source={**LUMP, "spin": [10, 0, 30], "snow": {"plasticity": "none"}})
    document["world"] = {"gravity": [0, 0, 0]}
    sim = compared(document)
    np.testing.assert_array_equal(by_id(sim, "J_P"), 1)


def test_cubic_spline_and_play(some_gpu):
    """64 nodes a particle; a surface that snow leaves by a hair, on nodes and particles."""
    sim = compared(scene({**FLOOR, "mode": "slip"}, spline="cubic"))
    assert np.abs(sim.state.modes).max() > 0


SHAPES = {
    "box": {"size": [1, 1, 0.2], "center": [0, 0, -0.1], "mode": "sticky", "surface_velocity": [2, -1, 3]},
    "sphere": {"radius": 0.5, "center": [0, 0, -0.5], "mu_c": 0.2, "spin": [0, 60, 0]},
    "cylinder": {"radius": 0.3, "height": 1.0, "center": [0, 0, -0.5], "mode": "slip", "mu_c": 0.0},
}


@pytest.mark.parametrize("shape", list(SHAPES))
def test_each_shape_of_collider(some_gpu, shape):
    """Each with another mode of contact; the ball turns, and the box is a belt."""
    sim = compared(scene({"shape": shape, **SHAPES[shape]}))
    assert np.abs(sim.exchanged).max() > 1


def test_samples_of_meshes_and_terrain(some_gpu, tmp_path):
    """A mesh and a terrain are read on the GPU: their samples are copied there."""
    mesh = {"shape": "mesh", "file": written(ball(0.3), tmp_path / "ball.stl"), "center": [0.1, 0, -0.29]}
    np.save(tmp_path / "ground.npy", 0.05 * np.random.default_rng(3).random((9, 9)))
    ground = {"shape": "terrain", "file": str(tmp_path / "ground.npy"), "size": [0.8, 0.8], "height": 0.04}
    sim = compared(scene(mesh, ground))
    assert (np.abs(sim.exchanged).max(axis=1) > 0).all()


def test_two_snows_that_vary(some_gpu):
    """Two materials in one block, and stiffness and strength that vary: each particle finds its own."""
    hard = {
        "shape": "sphere",
        "radius": 0.1,
        "center": [0, 0, 0.34],
        "snow": {"law": "drucker_prager", "rho0": 200},
    }
    document = scene(FLOOR, source={**LUMP, "variation": {"stiffness": 0.3, "strength": 0.3}})
    document["sources"].append(hard)
    sim = compared(document)
    assert len(np.unique(sim.state.material)) == 2


@pytest.mark.parametrize("transfer", list(TRANSFERS))
def test_sums(some_gpu, transfer):
    """Mass, momentum and energies of the log, of snow that has been crushed and turns."""
    modes = {"polypic_modes": 27} if transfer == "polypic" else {}
    document = scene(FLOOR, source={**LUMP, "spin": [0, 20, 0]}, transfer=transfer, **modes)
    cpu, gpu = (advanced(document, device).diagnostics() for device in ("cpu", "cuda"))
    for name in ("mass", "momentum", "kinetic", "affine", "elastic", "potential"):
        np.testing.assert_allclose(getattr(gpu, name), getattr(cpu, name), rtol=1e-9, atol=1e-9, err_msg=name)
    assert gpu.particles == cpu.particles


def test_volumes_from_the_grid(some_gpu):
    """numerics.initial_volume = "grid" measures the density on the nodes."""
    compared(scene(source=LUMP, initial_volume="grid"))


@pytest.mark.parametrize("dt", ["auto", 2e-4])
def test_gravity_that_follows_keyframes(some_gpu, dt):
    """A step of the same length under another gravity: the GPU hears of it."""
    keyed = scene(FLOOR, dt=dt)
    keyed["world"] = {"keyframes": [{"t": 0.0, "gravity": [0, 0, 0]}, {"t": 0.004, "gravity": [90, 0, 0]}]}
    sim = compared(keyed)
    still = advanced(scene(FLOOR, dt=dt), "cpu")
    assert by_id(sim, "v")[:, 0].mean() > by_id(still, "v")[:, 0].mean() + 0.05
