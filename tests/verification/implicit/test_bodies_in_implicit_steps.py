"""Bodies in implicit steps: momentum is kept, weights are borne, and light ones stay calm."""

import numpy as np
import pytest
from verification.free_bodies import FreeBodies, ball, block, simulate_with
from verification.scenes import angular_momentum, box, scene

from neve.validate.scenes import box as snow_box
from neve.validate.scenes import duct, elastic, moduli, plane, simulation

IMPLICIT = ("semi_implicit", "implicit")
G = 9.81
DOWN = (0.0, 0.0, -G)
DX = 0.05


def hit(body, gravity=(0.0, 0.0, 0.0), colliders=(), **numerics):
    """A block of snow of 0.4 m x 0.4 m x 0.3 m whose top is at z = 0, and a body."""
    description = scene(
        [box(center=(0, 0, -0.15), size=(0.4, 0.4, 0.3))],
        colliders,
        gravity,
        initial_volume="sampled",
        **{"dt": 1e-3, **numerics},
    )
    return simulate_with(description, FreeBodies(body, gravity=gravity))


def momentum(sim):
    """Of snow and body [kg m/s]."""
    s = sim.state
    return (np.asarray(s.m, float)[:, None] * np.asarray(s.v, float)).sum(0) + sim.solver.model.rigid.momentum


@pytest.mark.parametrize("integrator", IMPLICIT)
@pytest.mark.parametrize("mode", ["separate", "slip", "sticky"])
@pytest.mark.parametrize("density", [20.0, 8000.0])
def test_momentum_is_kept_whatever_the_tolerance(density, mode, integrator):
    """A body hits snow in the air: together p_0 + t m g to rounding, though forces are solved to 1e-2.

    A step adds an error of some eps of the momenta at hand; twenty steps of float64: 1e-13 of them.
    """
    body = block((0.2, 0.3, 0.2), density, mode, x=(0.03, -0.02, 0.13), v=(1.0, 0.3, -4.0), w=(2.0, 1.0, 3.0))
    sim = hit(body, DOWN, integrator=integrator, implicit_tolerance=1e-2)
    before, mass = momentum(sim), float(np.sum(sim.state.m)) + body.mass
    flux = float(np.abs(before).sum()) + mass * G * 0.02
    sim.advance(0.02)
    assert np.abs(sim.exchanged[0, :3]).sum() > 0.02 * np.abs(before).sum()  # they did meet
    np.testing.assert_allclose(momentum(sim), before + 0.02 * mass * np.array(DOWN), atol=1e-13 * flux)
    assert np.linalg.norm(body.v) < 6.0


@pytest.mark.parametrize("integrator", IMPLICIT)
@pytest.mark.parametrize("mode", ["separate", "sticky"])
def test_angular_momentum_is_kept_as_dt_shrinks(mode, integrator):
    """A turning body hits snow in free flight: half of dt leaves half of what both lose, by 1.5 at least.

    Impulses act on body and node at one point. Stress turns nothing where nodes are at the end of a step;
    where they were it turns by dt |f x v|, of first order. About the origin; a
    thousandth at most of what they give each other.
    """

    def whole(sim, body):
        own = body.I @ body.w + np.cross(body.x, body.mass * body.v)
        return np.asarray(angular_momentum(sim)) + own, own

    def lost(dt):
        body = block(
            (0.2, 0.3, 0.2), 400.0, mode, x=(0.03, -0.02, 0.13), v=(1.0, 0.3, -4.0), w=(2.0, 1.0, 3.0)
        )
        how = {"integrator": integrator, "dt": dt, "implicit_tolerance": 1e-8, "implicit_strain": 1.0}
        sim = hit(body, snow={"plasticity": "none"}, **how)
        before, own = whole(sim, body)
        sim.advance(0.012)
        after, then = whole(sim, body)
        assert np.linalg.norm(then - own) > 0.2
        return np.linalg.norm(after - before) / np.linalg.norm(then - own)

    far, near = lost(4e-4), lost(2e-4)
    assert far / near > 1.5
    assert near < 1e-3


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_a_piston_presses_a_stiff_column(integrator):
    """A slab on a slide settles by (m g / A) H / M_c, the column by its own rho g H^2 / 2 M_c, in 10 ms.

    Each is a hundred times as long as a wave takes through a cell, and the spring k under the slab so stiff
    that dt^2 k is a hundred times its mass: what felt the push a step late would be thrown. Tolerances as of
    a column alone: 2 %, and h / H because the ground holds its row of nodes; the slab holds one, too.
    """
    height, cells, E0, mass = 0.4, 8, 1e8, 0.5
    h = height / cells
    sim = simulation(
        [snow_box((0, 0, 0), (h, h, height))],
        [*duct(h, h), plane((0, 0, 0), (0, 0, 1))],
        bodies=[
            {
                "shape": "box",
                "size": [4 * h, 4 * h, 2 * h],
                "center": [0.5 * h, 0.5 * h, height + h],
                "mass": mass,
                "joint": "slide",
                "axis": [0, 0, 1],
                "contacts": False,
                "mode": "slip",
                "mu_c": 0.0,
            }
        ],
        snow=elastic(E0=E0),
        gravity=DOWN,
        dx=h,
        integrator=integrator,
    )
    assert 0.01**2 * moduli(E0, 0.2)[2] * h * h / height > 100 * mass
    sim.advance(0.1)
    before = np.array(sim.exchanged[-1])
    sim.advance(0.05)
    pose = sim.solver.model.rigid.poses()[0]
    sunk = height + h - pose.position[2]
    answer = (mass * G / h**2 * height + 400 * G * height**2 / 2) / moduli(E0, 0.2)[2]
    assert sim.steps < 30
    assert sunk == pytest.approx(answer, rel=0.02 + 2 / cells)
    assert (np.array(sim.exchanged[-1]) - before)[2] / 0.05 == pytest.approx(mass * G, rel=5e-3)


@pytest.mark.parametrize(("integrator", "precision"), [("semi_implicit", "float32"), ("implicit", "float64")])
@pytest.mark.parametrize("density", [20.0, 400.0, 4000.0])
def test_a_body_lies_calmly_on_stiff_snow(density, integrator, precision):
    """From a twentieth to ten times the density of the snow: borne, and no faster than 1 mm/s.

    Steps of 10 ms on snow of 1e7 Pa, through whose cells a wave takes 0.3 ms: what falls in a step gets
    0.1 m/s.
    """
    body = block((0.2, 0.2, 0.1), density, x=(0.01, 0.005, 0.05 + 1e-3))
    ground = [{"shape": "plane", "point": (0, 0, -0.3)}]
    how = {"dt": "auto", "integrator": integrator, "precision": precision, "snow": elastic(E0=1e7)}
    sim = hit(body, DOWN, ground, **how)
    sim.advance(0.2)
    before, fastest = np.array(sim.exchanged[1, :3]), 0.0
    for _ in range(10):
        sim.advance(0.01)
        fastest = max(fastest, float(np.abs(body.v).max()))
    force = (sim.exchanged[1, :3] - before) / 0.1
    assert force == pytest.approx([0, 0, body.mass * G], abs=0.02 * body.mass * G)
    assert fastest < 1e-3
    assert 0.04 < body.x[2] < 0.052


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_short_steps_are_explicit_ones(integrator):
    """A ball that snow turns: with dt halved its velocity differs from that of explicit steps by half.

    By 1.5 at the least, since contacts begin and end with whole steps.
    """

    def sinks(word, dt):
        body = ball(0.1, 2000.0, x=(0.01, 0.02, 0.105), v=(0.2, 0.0, -1.0))
        how = {"integrator": word, "dt": dt, "implicit_strain": 1.0, "implicit_tolerance": 1e-8}
        sim = hit(body, DOWN, snow={"plasticity": "none"}, **how)
        sim.advance(0.012)
        return np.array([*body.v, *body.w])

    far, near = (np.abs(sinks(integrator, dt) - sinks("explicit", dt)).max() for dt in (4e-4, 2e-4))
    assert far / near > 1.5


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_a_body_in_the_air_falls_freely(integrator):
    """Beside snow that rests: z_0 - g t^2 / 2 to the engine's own error, g t h / 2 with steps h of 0.5 ms."""
    fallen = {"shape": "sphere", "radius": 0.05, "center": [0.5, 0, 0.6], "density": 300}
    sim = simulation(
        [snow_box((0, 0, 0), (0.2, 0.2, 0.2))],
        [plane((0, 0, 0), (0, 0, 1))],
        bodies=[fallen],
        gravity=DOWN,
        dx=DX,
        integrator=integrator,
    )
    sim.advance(0.2)
    z = sim.solver.model.rigid.poses()[0].position[2]
    assert z == pytest.approx(0.6 - 0.5 * G * 0.04, abs=0.55 * G * 0.2 * 0.5e-3)


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_the_same_bits_on_any_number_of_threads_and_after_a_resume(integrator):
    """A hinged gate and a free box that snow hits, on one thread, on three, and in two pieces."""
    from neve.scene.reading.load import scene_from
    from neve.simulation import Simulation

    described = scene_from(
        {
            "numerics": {"dx": 0.1, "integrator": integrator, "implicit_strain": 1.0},
            "sources": [
                {"shape": "box", "size": [0.3, 0.6, 0.3], "center": [0.1, 0, 0.15], "velocity": [-3, 0, 0]}
            ],
            "colliders": [{"shape": "plane"}],
            "bodies": [
                {
                    "shape": "box",
                    "size": [0.1, 0.6, 0.5],
                    "center": [-0.15, 0, 0.3],
                    "density": 500,
                    "joint": "hinge",
                    "axis": [0, 1, 0],
                    "anchor": [-0.15, 0, 0.55],
                },
                {"shape": "box", "size": [0.2] * 3, "center": [0.1, 0, 0.42], "density": 100},
            ],
        }
    )
    one, three, first = (Simulation(described, threads=n) for n in (1, 3, 1))
    for sim in (one, three):
        sim.advance(0.02)
        sim.advance(0.02)
    first.advance(0.02)
    second = Simulation.restore(described, first.arrays(), 1)
    second.advance(0.02)

    def bodies(sim):
        return np.concatenate([p.velocity for p in sim.solver.model.rigid.poses()])

    rests = [bodies(sim) for sim in (one, three, second)]
    assert np.abs(rests[0]).max() > 0.05
    for sim, rest in zip((three, second), rests[1:], strict=True):
        assert rest.tobytes() == rests[0].tobytes()
        assert np.asarray(sim.state.x).tobytes() == np.asarray(one.state.x).tobytes()
