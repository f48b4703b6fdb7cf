"""One run on several GPUs: the same snow as on one, whatever the borders cut, and none of it is lost.

With NEVE_TEST_GPU=1 all domains are on the one GPU of this machine.
"""

import numpy as np
import pytest
from gpu.runs import FLOOR, LUMP, ROOM, WIDE, advanced, assert_same, by_id, parts, scene, several
from gpu.test_threads import BODY, bits

import neve
from neve.cuda.several.stages import SeveralStages
from neve.scene.reading.load import scene_from

BALL = {"shape": "sphere", "radius": 0.2, "center": [0.2, 0, 0]}
CHOICES = {
    "apic": {},
    "aflip": {"transfer": "aflip"},
    "play": {"spline": "cubic"},
    "all modes": {"transfer": "polypic", "polypic_modes": 27},
    "volumes from the grid": {"initial_volume": "grid"},
}


def flying(document, seconds, calls=1, look=None):
    """A simulation after `seconds`, `calls` times looked at on the way."""
    sim = neve.Simulation(scene_from({**document, "numerics": {**document["numerics"], "device": "cuda"}}))
    for _ in range(calls):
        sim.advance(seconds / calls)
        if look:
            look(sim)
    return sim


@pytest.mark.parametrize("devices", [(0, 1), (0, 1, 2), (0, 0)])
@pytest.mark.parametrize("choice", list(CHOICES))
def test_as_on_one(some_gpus, choice, devices):
    """A wide lump that lands on a floor and a ball, cut in two or three: the same within rounding."""
    mode = "slip" if choice == "play" else "separate"
    document = scene({**FLOOR, "mode": mode}, BALL, source={**WIDE, "spin": [0, 20, 0]}, **CHOICES[choice])
    one, other = advanced(document, "cuda"), advanced(several(document, devices), "cuda")
    assert isinstance(other.solver.model.core, SeveralStages)
    assert min(parts(other)) > 0
    assert_same(one, other, 1e-11)
    assert np.abs(other.exchanged[1]).max() > 0
    assert other.solver.grid.blocks == one.solver.grid.blocks
    assert some_gpus is None or not some_gpus.overrun()


@pytest.mark.parametrize(
    "choice", [{"precision": "float32"}, {"spline": "cubic", "transfer": "polypic", "polypic_modes": 8}]
)
@pytest.mark.parametrize("devices", [(0, 1), (2, 0, 1)])
def test_same_bits_as_on_one(some_gpus, choice, devices):
    """numerics.deterministic: particles, bodies, what solids exchange and sums have the bits of one GPU."""
    mode = "slip" if "spline" in choice else "separate"
    document = scene({**FLOOR, "mode": mode}, BALL, source=WIDE, deterministic=True, **choice)
    document["bodies"] = [BODY]
    one, other = advanced(document, "cuda"), advanced(several(document, devices), "cuda")
    rows = [np.argsort(sim.state.id) for sim in (one, other)]
    first, second = bits(one), bits(other)
    for name, array in first.items():
        if len(array) == one.count:
            np.testing.assert_array_equal(second[name][rows[1]], array[rows[0]], err_msg=name)
        else:
            np.testing.assert_array_equal(second[name], array, err_msg=name)
    assert np.abs(other.exchanged[2]).max() > 0  # the body was met


def test_bodies(some_gpus):
    """A body that lands on the border gets the impulses of the snow of both domains, as on one."""
    document = {**scene(FLOOR, source=WIDE), "bodies": [BODY]}
    one, other = (advanced(d, "cuda", calls=5) for d in (document, several(document, (0, 1))))
    assert_same(one, other, 1e-11)
    a, b = one.solver.model.rigid.momentum, other.solver.model.rigid.momentum
    assert np.abs(other.exchanged[1]).max() > 1e-3
    np.testing.assert_allclose(b, a, rtol=0, atol=1e-11 * np.abs(a).max())


def test_momentum_across_a_border(some_gpus):
    """Snow in the air that turns and vibrates, cut in three, keeps its momentum."""
    document = scene(source={**WIDE, "spin": [10, 0, 30], "snow": {"plasticity": "none"}})
    document["world"] = {"gravity": [0, 0, 0]}
    sim = neve.Simulation(
        scene_from(several({**document, "numerics": {**document["numerics"], "device": "cuda"}}, (0, 1, 2)))
    )
    before = np.array(sim.diagnostics().momentum)
    sim.advance(0.02)
    assert sim.steps > 10
    np.testing.assert_allclose(
        sim.diagnostics().momentum, before, rtol=0, atol=ROOM * 1e-12 * np.abs(before).max()
    )


def test_a_block_at_rest_across_a_border(some_gpus):
    """Without forces nothing moves, at the border or elsewhere, to the bit."""
    document = scene(source={**WIDE, "velocity": [0, 0, 0]})
    document["world"] = {"gravity": [0, 0, 0]}
    sim = flying(several(document, (0, 1)), 0.01)
    np.testing.assert_array_equal(np.asarray(sim.state.v), 0)


def test_a_block_that_lies_across_a_border(some_gpus):
    """Snow that rests on the ground carries itself: the ground gets its weight, as on one GPU."""
    block = {**WIDE, "center": [0, 0, 0.1], "velocity": [0, 0, 0]}
    one, other = (
        flying(d, 0.05) for d in (scene(FLOOR, source=block), several(scene(FLOOR, source=block), (0, 1)))
    )
    assert_same(one, other, 1e-9)
    assert other.exchanged[0, 2] < -0.3 * 9.81 * 0.05 * other.diagnostics().mass


TWO = {
    "numerics": {"dx": 0.05, "precision": "float64"},
    "world": {"gravity": [0, 0, 0]},
    "sources": [
        {"shape": "sphere", "radius": 0.12, "center": [-0.5, 0, 0], "velocity": [20, 0, 0]},
        {"shape": "sphere", "radius": 0.12, "center": [0.5, 0, 0]},
    ],
}


def test_a_ball_that_flies_into_the_other_domain(some_gpus):
    """All its particles go along, and their masses, and nothing changes as it crosses."""
    seen = []
    sim = flying(several(TWO, (0, 1)), 0.032, calls=16, look=lambda sim: seen.append(parts(sim)))
    one = flying(TWO, 0.032, calls=16)
    there = int((sim.columns()["source"]() == 0).sum())  # particles of the ball that flies
    assert (seen[0][0], seen[-1][0]) == (there, 0)
    assert any(0 < left < there for left, _ in seen)  # it has been cut by the border
    assert {sum(each) for each in seen} == {one.count}
    np.testing.assert_array_equal(by_id(sim, "m"), by_id(one, "m"))
    np.testing.assert_array_equal(np.sort(np.asarray(sim.state.id)), np.arange(one.count))
    assert_same(one, sim, 1e-10)


def test_an_emptied_domain(some_gpus):
    """A domain that all snow has left goes on with nothing, and snow may come back to it."""
    alone = {**TWO, "sources": [{**TWO["sources"][0], "center": [-0.1, 0, 0]}]}
    sim = flying(several(alone, (0, 1)), 0.02, calls=10)
    assert parts(sim) == [0, sim.count]
    sim.state.v[:] = [-20.0, 0.0, 0.0]
    for _ in range(20):
        sim.advance(2e-3)
    assert parts(sim)[0] == sim.count
    np.testing.assert_allclose(by_id(sim, "v")[:, 0], -20.0, rtol=1e-9)
    assert some_gpus is None or not some_gpus.overrun()


def test_more_domains_than_blocks(some_gpus):
    """Snow within one block, on three GPUs: two of them have nothing to do."""
    small = {"shape": "sphere", "radius": 0.06, "center": [0.16, 0.16, 0.16], "velocity": [0, 1, -2]}
    one, other = (advanced(d, "cuda") for d in (scene(source=small), several(scene(source=small), (0, 1, 2))))
    assert sorted(parts(other)) == [0, 0, other.count]
    assert_same(one, other, 1e-12)


def test_what_is_written_counts(some_gpus):
    """Positions and velocities set between two advances, across the border: rows find their domain."""
    one, other = advanced(scene(), "cuda", calls=1), advanced(several(scene(), (0, 1)), "cuda", calls=1)
    for sim in (one, other):
        turned = np.array(sim.state.x) * [-1, 1, 1]
        sim.state.x[:] = turned
        sim.state.v[:] = np.array([0.0, 1.0, 2.0])
        sim.advance(1e-3)
    assert_same(one, other, 1e-11)


def test_snow_that_is_added(some_gpus):
    """And another scene for the same snow, while the run goes on."""
    runs = [advanced(scene(FLOOR), "cuda", calls=1), advanced(several(scene(FLOOR), (0, 1)), "cuda", calls=1)]
    for sim in runs:
        sim.add(scene_from(scene(source={**LUMP, "center": [0.3, 0, 0.4]})).sources[0])
        sim.advance(1e-3)
        sim.change(sim.scene.model_copy(update={"colliders": ()}))
        sim.advance(1e-3)
    assert_same(*runs, 1e-11)
