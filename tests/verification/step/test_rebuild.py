"""A run whose scene changes while it goes on: other constants for the same snow, and more snow."""

import math
import warnings

import numpy as np
import pytest
from verification.scenes import ball, box, columns, march, scene, simulate

import neve
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Collider, Numerics, Scene, Source
from neve.simulation import Simulation

FLOOR = ({"shape": "plane", "point": (0, 0, -0.15)},)


def falling(**changes):
    """A box with a spin and a harder ball that fall on a floor."""
    table = {"snow": {}, "transfer": "apic"} | changes
    snow = table.pop("snow")
    sources = [box(velocity=(0, 0, -3), spin=(0, 3, 0)), ball((0.3, 0, 0), 0.1, snow={"xi": 5.0})]
    return scene(sources, FLOOR, (0, 0, -9.81), snow=snow, **table)


def moving(**changes):
    """The same after 20 steps."""
    return march(simulate(falling(**changes)), 20)


def test_a_change_to_the_same_scene_changes_no_bit():
    """20 + 20 steps with `change` between them end in the bits of 20 + 20 steps without."""
    plain, changed = moving(), moving()
    changed.change(falling())
    for a, b in zip(columns(march(plain, 20)).values(), columns(march(changed, 20)).values(), strict=True):
        np.testing.assert_array_equal(a, b)


def test_twice_the_modulus_is_twice_the_stress():
    """tau(F_E) of every law is E0 times a function of nu and F_E: after E0 -> 2 E0, tau is twice as large.

    Tolerance: both are computed from the same bits of F_E; 2 E0 is exact, so a few roundings remain.
    """
    sim = moving()
    sim.change(falling())
    sim.solver.model.core.refresh(sim.solver.model.native, sim.state)
    before = np.array(sim.state.tau)
    assert np.abs(before).max() > 1.0
    sim.change(falling(snow={"E0": 2.8e5}))
    sim.solver.model.core.refresh(sim.solver.model.native, sim.state)
    np.testing.assert_allclose(sim.state.tau, 2 * before, rtol=1e-13, atol=1e-13 * np.abs(before).max())


def test_a_changed_run_is_the_run_restored_in_the_new_scene():
    """Changed constants, gravity and friction act like in a run that is resumed with them, to the bit."""
    new_scene = falling(snow={"E0": 3e5, "xi": 8.0}).model_copy(update={"colliders": ()})
    sim = moving()
    arrays = sim.arrays() | {"exchanged": np.zeros((0, 7))}
    sim.change(new_scene)
    other = neve.Simulation.restore(new_scene, arrays, threads=1)
    for a, b in zip(columns(march(sim, 20)).values(), columns(march(other, 20)).values(), strict=True):
        np.testing.assert_array_equal(a, b)


def test_snow_follows_its_source_into_another_table():
    """Two snows that become one, and one of another order, still reach their particles."""
    sim = moving()
    sim.change(falling(snow={"xi": 5.0}))  # now both sources have the same snow
    assert len(sim.solver.model.snows) == 1
    assert set(np.unique(sim.state.material)) == {0}


@pytest.mark.parametrize("transfer", ["flip", "polypic", "pic"])
def test_the_transfer_can_change(transfer):
    """APIC goes on as another transfer with the modes that it has; momentum stays."""
    sim = moving()
    before = (np.array(sim.state.m)[:, None] * sim.state.v).sum(axis=0)
    sim.change(falling(transfer=transfer))
    after = (np.array(sim.state.m)[:, None] * sim.state.v).sum(axis=0)
    np.testing.assert_array_equal(before, after)
    march(sim, 2)
    assert np.isfinite(sim.state.x).all()


def test_added_snow_brings_its_mass_and_momentum():
    """A ball of radius r adds rho0 4/3 pi r^3 and that times v; the others keep every bit.

    Tolerance: sums of a few thousand float64 terms; the volume of the samples adds up to that of the ball.
    """
    sim = moving()
    before = columns(sim)
    thrown = Source.of(
        "sphere",
        center=(0.0, 0.0, 0.6),
        radius=0.12,
        velocity=(1.0, 2.0, -3.0),
        snow={"rho0": 300.0, "xi": 7.0},
    )
    sim.add(thrown)
    after = columns(sim)
    n = len(before["m"])
    for name, value in before.items():
        np.testing.assert_array_equal(after[name][:n], value, err_msg=name)
    mass = 300.0 * 4.0 / 3.0 * math.pi * 0.12**3
    assert after["m"][n:].sum() == pytest.approx(mass, rel=1e-12)
    momentum = (after["m"][n:, None] * after["v"][n:]).sum(axis=0)
    np.testing.assert_allclose(momentum, mass * np.array([1.0, 2.0, -3.0]), rtol=1e-12)
    assert len(np.unique(after["id"])) == len(after["id"])
    assert sim.solver.model.snows[after["material"][-1]].xi == 7.0
    assert sim.scene.sources[-1] == thrown
    march(sim, 5)
    fell = columns(sim)
    assert np.isfinite(fell["x"]).all()
    # Nothing has met the ball yet: it falls freely, v = v0 + g t.
    down = (fell["m"][n:] * fell["v"][n:, 2]).sum() / mass
    assert down == pytest.approx(-3.0 - 9.81 * 5e-4, rel=1e-9)


def test_a_run_with_added_snow_can_be_resumed():
    """`arrays` of a run with added snow, restored in its scene, goes on with the same bits."""
    sim = moving()
    sim.add(Source.of("sphere", center=(0.0, 0.0, 0.6), radius=0.1))
    other = neve.Simulation.restore(sim.scene, sim.arrays(), threads=1)
    for a, b in zip(columns(march(sim, 5)).values(), columns(march(other, 5)).values(), strict=True):
        np.testing.assert_array_equal(a, b)


def test_what_cannot_change_is_told_in_one_sentence():
    """dx, a source more, and snow that would have to be told apart are refused; the run stays as it was."""
    sim = moving()
    model = sim.solver.model
    with pytest.raises(SceneError, match=r"numerics\.dx cannot change"):
        sim.change(falling(dx=0.04))
    with pytest.raises(SceneError, match="come or go"):
        sim.change(sim.scene.model_copy(update={"sources": sim.scene.sources[:1]}))
    twins = scene([box(), ball((0.5, 0, 0))])
    apart = scene([box(), ball((0.5, 0, 0), snow={"xi": 3.0})])
    two = simulate(twins)
    with pytest.raises(SceneError, match=r"sources\.1\.snow cannot part"):
        two.change(apart)
    assert sim.solver.model is model


def with_bodies(**changes):
    """Snow above a floor, beside a box that is thrown and one that turns on a hinge."""
    edges = (0.2, 0.2, 0.2)
    table = {
        "sources": [ball((0, 0, 1.0), 0.1)],
        "colliders": [{"shape": "plane"}],
        "bodies": [
            {"shape": "box", "center": (1, 0, 1), "size": edges, "velocity": (1, 0, 0), "spin": (0, 0, 3)},
            {"shape": "box", "center": (-1, 0, 1), "size": edges, "joint": "hinge", "spin": (0, 0, 2)},
        ],
        "world": {"gravity": (0.0, 0.0, -9.81)},
        "numerics": {"dx": 0.05, "dt": 1e-4, "precision": "float64"},
    }  # fmt: skip
    return Scene.model_validate(table | changes)


def where(sim):
    """Place, rotation and motion of all bodies, one row each."""
    return np.array(
        [
            np.concatenate([p.position, p.rotation.ravel(), p.velocity, p.omega])
            for p in sim.solver.model.rigid.poses()
        ]
    )


def test_bodies_stay_where_they_are():
    """A change of the snow leaves the engine's state as it is, to the bit; so does added snow."""
    sim = march(simulate(with_bodies()), 50)
    before = where(sim)
    sim.change(with_bodies(snow={"E0": 2e5}))
    np.testing.assert_array_equal(where(sim), before)
    sim.add(Source.of("sphere", center=(0.0, 0.6, 1.0), radius=0.1))
    np.testing.assert_array_equal(where(sim), before)
    other = march(simulate(with_bodies()), 50)
    np.testing.assert_allclose(where(march(sim, 20)), where(march(other, 20)), rtol=0, atol=1e-12)


def test_a_body_can_be_moved_and_a_collider_can_come():
    """The moved body begins where it is told, a free one stays; tolerance: a rotation vector's rounding."""
    sim = march(simulate(with_bodies()), 50)
    before = where(sim)
    scene = with_bodies()
    sim.change(
        scene.model_copy(
            update={"colliders": (*scene.colliders, Collider.of("sphere", center=(5.0, 0.0, 0.0)))}
        )
    )
    np.testing.assert_allclose(where(sim), before, atol=1e-12)  # the one on a hinge too
    moved = scene.bodies[0].model_copy(update={"center": (2.0, 0.0, 1.0), "velocity": (0.0, 0.0, 0.0)})
    sim.change(sim.scene.model_copy(update={"bodies": (moved, scene.bodies[1])}))
    np.testing.assert_allclose(where(sim)[0][:3], (2.0, 0.0, 1.0), atol=1e-12)
    np.testing.assert_allclose(where(sim)[0][12:15], 0.0, atol=1e-12)


@pytest.mark.parametrize(
    "motion", [{"velocity": (0.0, 0.5, 0.0)}, {"keyframes": ({"t": 0.0}, {"t": 1.0, "position": (5, 1, 0)})}]
)
def test_a_collider_can_begin_to_move_among_bodies(motion):
    """The engine then holds one more solid that a script moves; the bodies go on from where they are."""
    far = {"shape": "sphere", "center": (5.0, 0.0, 0.0)}
    floor = {"shape": "plane"}
    sim = march(simulate(with_bodies(colliders=[floor, far])), 50)
    before = where(sim)
    sim.change(with_bodies(colliders=[floor, far | motion]))
    np.testing.assert_array_equal(where(sim), before)
    same = march(simulate(with_bodies(colliders=[floor, far])), 50)
    np.testing.assert_allclose(where(march(sim, 20)), where(march(same, 20)), rtol=0, atol=1e-12)


def test_added_snow_keeps_out_of_solids():
    """Half of a ball that reaches into the floor is left out; a ball wholly inside is refused."""
    sim = simulate(with_bodies())
    n = len(sim.state.m)
    sim.add(Source.of("sphere", center=(0.0, 0.8, 0.0), radius=0.2))
    x = columns(sim)["x"][n:]
    assert x[:, 2].min() >= -1e-3 * sim.scene.numerics.dx
    half = 2.0 / 3.0 * math.pi * 0.2**3
    assert columns(sim)["V0"][n:].sum() == pytest.approx(
        half, rel=0.05
    )  # some 2,000 particles: 2 % at random
    with pytest.raises(SceneError, match="wholly inside"):
        sim.add(Source.of("sphere", center=(0.0, 0.8, -0.5), radius=0.1))


@pytest.mark.parametrize("below", [0.0, 5e-4, 2e-3])
def test_snow_is_inside_a_solid_by_one_rule(below):
    """A box whose lowest layer of particles is `below` cells under the floor has the same particles whether
    the scene begins with it or it is added: 512 within rounding of the surface; a layer less, and a warning,
    deeper."""
    dx = 0.1
    block = Source.of("box", center=(0.0, 0.0, 0.2 - (0.25 + below) * dx), size=(0.4, 0.4, 0.4))
    numerics = Numerics(dx=dx, sampling="regular", precision="float64")
    other = Source.of("sphere", center=(3.0, 0.0, 0.5), radius=0.2)
    floor = Collider.of("plane")
    with warnings.catch_warnings(record=True) as at_start:
        warnings.simplefilter("always")
        begun = Simulation(Scene(numerics=numerics, sources=(other, block), colliders=(floor,)))
    added = Simulation(Scene(numerics=numerics, sources=(other,), colliders=(floor,)))
    with warnings.catch_warnings(record=True) as later:
        warnings.simplefilter("always")
        added.add(block)
    np.testing.assert_array_equal(np.asarray(added.state.x), np.asarray(begun.state.x))
    told = [[str(w.message) for w in found if "left out" in str(w.message)] for found in (at_start, later)]
    assert told[0] == told[1]
    assert len(told[0]) == (below > 1e-3)
    assert len(added.state.m) - np.count_nonzero(added.state.x[:, 0] > 2.0) == (448 if below > 1e-3 else 512)
