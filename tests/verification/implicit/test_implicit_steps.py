"""Implicit steps: damping and order of the scheme, momentum, contact, and the same bits on any threads."""

import numpy as np
import pytest
from verification.scenes import ELASTIC, ball, box, columns, scene, simulate, wide

from neve.validate.elastic import bar
from neve.validate.grains.slide import slide
from neve.validate.scenes import box as block
from neve.validate.scenes import duct, elastic, moduli, plane, simulation

IMPLICIT = ("semi_implicit", "implicit")
DOWN = (0.0, 0.0, -9.81)


def last_bits(sim):
    """Bytes of positions, velocities, deformation."""
    return [columns(sim)[name].tobytes() for name in ("x", "v", "F_E", "J_P")]


@pytest.mark.parametrize(("beta", "system"), [(0.5, "projected"), (1.0, "projected"), (1.0, "raw")])
def test_a_bar_loses_what_the_scheme_says(beta, system):
    """An oscillation keeps the energy share A = 1 / (1 + beta (w dt)^2) in a step; so not all with beta 1/2.

    v' = A (v - dt w^2 x), x' = x + dt v': the displacements obey x'' = (1 + A - A (w dt)^2) x' - A x. Both
    numbers are fitted to a bar that vibrates with 40 steps in a period. w^2 on the grid is known to 0.4 %,
    and what `apic` damps is 4e-5 of an energy of which 1.2 or 2.4 % are lost in a step: 2 %.
    """
    numerics = {"integrator": "semi_implicit", "implicit_beta": beta, "implicit_tolerance": 1e-8}
    v = bar.vibrate(20, 1.0, courant=2.0, implicit_system=system, **numerics)
    u = v.amplitude
    trace, kept = np.linalg.lstsq(np.stack([u[1:-1], -u[:-2]], axis=1), u[2:], rcond=None)[0]
    turn = (v.omega * v.dt) ** 2
    share = 1 / (1 + beta * turn)
    assert 1 - kept == pytest.approx(1 - share, rel=0.02)
    assert 1 + share - trace == pytest.approx(share * turn, rel=0.02)


@pytest.mark.parametrize(
    "how",
    [{"integrator": word} for word in IMPLICIT] + [{"integrator": "semi_implicit", "implicit_beta": 0.5}],
)
def test_first_order_in_dt(how):
    """After a quarter of a period halving dt halves the difference to exact steps: 2 within a fifth.

    48, 96 and 192 steps in a period. With beta 1/2 too: what is lost in a step is half as much, and
    as many steps lose it.
    """

    def swing(courant):
        return bar.vibrate(10, 0.25, courant=courant, implicit_tolerance=1e-9, **how).amplitude[-1]

    at = [swing(courant) for courant in (0.8336, 0.4168, 0.2084)]
    assert (at[0] - at[1]) / (at[1] - at[2]) == pytest.approx(2.0, rel=0.2)


UNDAMPED = [
    {},
    {"transfer": "flip", "flip_alpha": 1.0},
    {"spline": "cubic", "transfer": "aflip", "aflip_damping": 0.0},
]


@pytest.mark.parametrize("how", UNDAMPED)
@pytest.mark.parametrize("integrator", IMPLICIT)
def test_second_order_in_dt_by_the_midpoint_rule(integrator, how):
    """After a quarter of a period halving dt quarters the difference to exact steps: 4 within a fifth.

    12, 24 and 48 steps in a period.
    """

    def swing(courant):
        numerics = {"implicit_rule": "midpoint", "implicit_tolerance": 1e-10, "integrator": integrator}
        return bar.vibrate(10, 0.25, courant=courant, **numerics | how).amplitude[-1]

    at = [swing(courant) for courant in (3.3334, 1.6667, 0.8336)]
    assert (at[0] - at[1]) / (at[1] - at[2]) == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_a_bar_keeps_its_energy_by_the_midpoint_rule(integrator):
    """With twenty steps in a period two thousandths at most are lost in one; ends of steps lose four fifths.

    A = 1 / (1 + (w dt)^2) a step at the end, and nothing in the middle but what `apic` damps; it begins with
    the velocity cos(w dt / 2).
    """

    def left(rule):
        v = bar.vibrate(
            20, 1.0, courant=4.0, integrator=integrator, implicit_rule=rule, implicit_tolerance=1e-9
        )
        return float(v.amplitude[-1] ** 2 + v.speed[-1] ** 2) / np.cos(0.5 * v.omega * v.dt) ** 2

    assert left("midpoint") == pytest.approx(1.0, abs=2e-3)
    assert left("end") < 0.2


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_snow_lands_by_the_midpoint_rule(integrator):
    """A ball falls by t^2 g / 2 to rounding; on the ground its momentum is that of weight and impulses.

    To the tolerance of a solve, 1e-3 of the forces in each step.
    """
    ground = [{"shape": "plane", "mu_c": 0.3, "point": [0, 0, 0], "normal": [0, 0, 1]}]
    numerics = {"integrator": integrator, "implicit_rule": "midpoint", "dt": 1e-3, "implicit_strain": 1.0}
    sim = simulate(scene([ball(center=(0, 0, 0.25))], ground, DOWN, **numerics))
    start = columns(sim)["x"][:, 2]
    sim.advance(0.05)
    fallen = columns(sim)["x"][:, 2] - start
    np.testing.assert_allclose(fallen, -0.5 * 9.81 * 0.05**2, atol=1e-12)
    sim.advance(0.1)
    before, momentum = np.array(sim.exchanged[0, :3]), np.array(sim.diagnostics().momentum)
    sim.advance(0.03)
    gained = np.array(sim.diagnostics().momentum) - momentum
    weight = float(np.sum(sim.state.m)) * np.array(DOWN)
    given = -(sim.exchanged[0, :3] - before) + 0.03 * weight
    np.testing.assert_allclose(gained, given, atol=5e-3 * 0.03 * np.linalg.norm(weight))


@pytest.mark.parametrize("integrator", IMPLICIT)
@pytest.mark.parametrize("how", [{}, {"transfer": "flip"}, {"spline": "cubic", "transfer": "aflip"}])
def test_pieces_in_the_air_keep_their_momentum(integrator, how):
    """Two balls, one of them light, fall: each has m (v + t g) to 1e-12 though forces are solved to 1e-2.

    A third lies on the ground, whose preconditioner is not the mass alone: that is no concern of theirs.
    """
    balls = [
        ball(center=(0, 0, 1)),
        ball(center=(1, 0, 1), radius=0.1, velocity=(1.0, 0, 0)),
        ball(center=(0, 1, 0.1), radius=0.1),
    ]
    ground = [{"shape": "plane", "mu_c": 0.3, "point": [0, 0, 0], "normal": [0, 0, 1]}]
    numerics = {"integrator": integrator, "implicit_tolerance": 1e-2, "dt": 2e-3, "sampling": "jittered"}
    sim = simulate(scene(balls, ground, DOWN, snow=ELASTIC, **numerics | how))
    x, y = columns(sim)["x"][:, :2].T
    sim.state.F_E[:] *= 1.001  # they are strained, so that there is something to solve
    sim.advance(0.02)
    assert sim.exchanged[0, 2] < 0
    now = columns(sim)
    for piece, before in (((x < 0.5) & (y < 0.5), (0, 0, 0)), (x > 0.5, (1.0, 0, 0))):
        mean = (now["m"][piece, None] * now["v"][piece]).sum(0) / now["m"][piece].sum()
        np.testing.assert_allclose(mean, np.add(before, 0.02 * np.array(DOWN)), atol=1e-12)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), DOWN])
@pytest.mark.parametrize("integrator", IMPLICIT)
def test_stiff_snow_that_nothing_loads_flies_on(integrator, gravity, precision):
    """A ball of 1e8 Pa turns in the air: its stress is rounding, which no solution can be smaller than.

    No step is refused for it, and the centre of mass moves by t v + t^2 g / 2, to g t dt / 2 of steps of
    first order and rounding of places and speeds, 1e-5 m.
    """
    source = [ball(center=(0, 0, 0.3), velocity=(10, 0, 3), spin=(0, 0, 5))]
    how = {"integrator": integrator, "precision": precision}
    sim = simulate(scene(source, gravity=gravity, snow={"E0": 1e8}, **how))
    start, m = wide(sim), np.asarray(columns(sim)["m"], float)
    sim.advance(0.01)
    assert sim.stats.rejected == 0
    moved = np.average(wide(sim)["x"] - start["x"], axis=0, weights=m)
    answer = 0.01 * np.average(start["v"], axis=0, weights=m) + 0.5 * 0.01**2 * np.array(gravity)
    np.testing.assert_allclose(moved, answer, atol=1e-5 + 0.5 * 9.81 * 0.01**2 / sim.steps)


def settled_on_the_grid(cells):
    """Return how far the topmost particle of a column has sunk at rest on its grid, over rho g H^2 / 2 M_c.

    One dimension, two particles in a cell, forces and strains by g = 4 w (x_i - x_p) / h^2, rows of nodes in
    the ground held: K u = b with K = sum_p V g g^T and b = sum_p V w, in units of h and of the load.
    """
    K, b = np.zeros((cells + 3, cells + 3)), np.zeros(cells + 3)  # nodes -1 to cells + 1
    for z in (np.arange(2 * cells) + 0.5) / 2:
        first = int(np.floor(z - 0.5))
        d = z - first
        w = np.array([0.5 * (1.5 - d) ** 2, 0.75 - (d - 1) ** 2, 0.5 * (d - 0.5) ** 2])
        g, at = 4 * w * (np.arange(3) - d), slice(first + 1, first + 4)
        K[at, at] += 0.5 * np.outer(g, g)
        b[at] += 0.5 * w
    u = np.linalg.solve(K[2:, 2:], b[2:])
    return float(w @ u[-3:]) / (0.5 * cells**2)


@pytest.mark.parametrize("E0", [1e8, 1e9])
@pytest.mark.parametrize(
    "how",
    [{"integrator": word} for word in IMPLICIT] + [{"integrator": "semi_implicit", "implicit_system": "raw"}],
)
def test_a_stiff_column_comes_to_rest_at_once(how, E0):
    """It settles by rho g H^2 / 2 M_c in ten steps, each a hundred waves through a cell long and more.

    Times 1.041 on a grid of eight cells, since a wall on a row of nodes is a little soft: that halves with
    the cells. Forces are solved to 1e-3; settlements are then within 1 %, and the ground bears the weight.
    """
    height, cells = 0.4, 8
    assert settled_on_the_grid(cells) - 1 == pytest.approx(2 * (settled_on_the_grid(2 * cells) - 1), rel=0.05)
    h = height / cells
    sim = simulation(
        [block((0, 0, 0), (h, h, height))],
        [*duct(h, h), plane((0, 0, 0), (0, 0, 1), "separate", mu_c=0.3)],
        snow=elastic(E0=E0),
        gravity=DOWN,
        dx=h,
        **how,
    )
    top = np.asarray(sim.state.x)[:, 2].max()
    sim.advance(0.05)
    before = np.array(sim.exchanged[-1])
    sim.advance(0.05)
    sunk = top - np.asarray(sim.state.x)[:, 2].max()
    assert sim.steps < 20
    answer = 400 * 9.81 * height**2 / 2 / moduli(E0, 0.2)[2]
    assert sunk == pytest.approx(settled_on_the_grid(cells) * answer, rel=0.01)
    force = (np.array(sim.exchanged[-1]) - before)[2] / 0.05
    assert force == pytest.approx(-400 * 9.81 * height * h * h, rel=5e-3)


def test_raw_systems_are_those_of_the_projected_where_nothing_is_negative():
    """Snow on sticky ground that was pulled evenly by a thousandth: one step to 1e-6 of its largest way.

    Conjugate residuals without the diagonal, conjugate gradients with it, both to 1e-7 of the forces. Pressed
    snow has negative eigenvalues, which only raw systems keep.
    """
    ground = [{"shape": "plane", "mode": "sticky", "point": [0, 0, 0], "normal": [0, 0, 1]}]

    def way(system, stretch):
        numerics = {"implicit_system": system, "implicit_tolerance": 1e-7, "implicit_strain": 1.0}
        how = {"integrator": "semi_implicit", "dt": 2e-3, "sampling": "jittered"} | numerics
        sim = simulate(scene([box(center=(0, 0, 0.1))], ground, snow=ELASTIC, **how))
        sim.state.F_E[:] *= stretch
        start = columns(sim)["x"]
        sim.advance(2e-3)
        assert sim.diagnostics().solve_residual < 1e-7
        return columns(sim)["x"] - start

    pulled, same = way("raw", 1.001), way("projected", 1.001)
    np.testing.assert_allclose(pulled, same, atol=1e-6 * np.abs(same).max(), rtol=0)
    pressed, other = way("raw", 0.99), way("projected", 0.99)
    assert np.abs(pressed - other).max() > 1e-3 * np.abs(other).max()


@pytest.mark.parametrize(("degrees", "mu_c"), [(30, 0.3), (20, 0.5)])
def test_a_block_slides_or_sticks(degrees, mu_c):
    """It slides with g (sin - mu cos) within 1 %, or rests, as in explicit steps (known answer 19)."""
    theta = np.radians(degrees)
    answer = max(9.81 * (np.sin(theta) - mu_c * np.cos(theta)), 0.0)
    s = slide(degrees, mu_c, dx=0.1, seconds=0.1, frames=10, integrator="semi_implicit")
    assert s.acceleration(mu_c if answer else 0.0) == pytest.approx(answer, abs=0.01 * 9.81)


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_short_steps_are_explicit_ones(integrator):
    """An elastic block falls on sticky ground: with dt halved the difference to explicit steps halves.

    By 1.5 at the least from dt = 2e-4 to 1e-4 s, since contacts begin and end with whole steps.
    """
    ground = [{"shape": "plane", "mode": "sticky", "point": [0, 0, 0], "normal": [0, 0, 1]}]

    def falls(word, dt):
        source = [box(center=(0, 0, 0.1), velocity=(0.3, 0, -1))]
        how = {"integrator": word, "dt": dt, "implicit_strain": 1.0, "implicit_tolerance": 1e-8}
        sim = simulate(scene(source, ground, DOWN, snow=ELASTIC, **how))
        sim.advance(0.02)
        return columns(sim)["x"]

    far, near = (np.abs(falls(integrator, dt) - falls("explicit", dt)).mean() for dt in (2e-4, 1e-4))
    assert far / near > 1.5


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("integrator", IMPLICIT)
def test_the_same_bits_on_any_number_of_threads_and_after_a_resume(integrator, precision):
    """Snow that falls on the ground, on one thread, on three, and in two pieces."""
    from neve.simulation import Simulation

    ground = [{"shape": "plane", "mu_c": 0.3, "point": [0, 0, 0], "normal": [0, 0, 1]}]
    source = [ball(center=(0, 0, 0.15), velocity=(0, 0, -2))]
    how = {"integrator": integrator, "precision": precision, "dt": 1e-3, "implicit_strain": 1.0}
    described = scene(source, ground, DOWN, **how)
    one, three, first = simulate(described), simulate(described, threads=3), simulate(described)
    for sim in (one, three):
        sim.advance(0.005)
        sim.advance(0.005)
    first.advance(0.005)
    second = Simulation.restore(described, first.arrays(), 1)
    second.advance(0.005)
    assert last_bits(one) == last_bits(three) == last_bits(second)


def test_what_cannot_be_solved_is_tried_again_shorter():
    """One iteration is too few for a long step, and enough for one of a hundredth."""
    numerics = {
        "integrator": "semi_implicit",
        "dt": 5e-3,
        "implicit_iterations": 2,
        "implicit_tolerance": 1e-6,
    }
    sim = simulate(scene([box(spin=(0, 0, 1.0))], gravity=DOWN, snow=ELASTIC | {"E0": 1e6}, **numerics))
    sim.state.F_E[:] *= 1.001
    sim.advance(5e-3)
    assert sim.steps > 1
    assert sim.stats.rejected > 0
