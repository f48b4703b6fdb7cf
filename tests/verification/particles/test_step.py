"""The step of particles: its oracle, momentum, bits, solids, compaction, and what is refused."""

import re

import numpy as np
import pytest
from reference import particles as reference
from verification.particles.common import columns, energy, particles

import neve
from neve.particles.constants import ICE
from neve.particles.solver import CONTACTS
from neve.scene.errors import SceneError
from neve.solver import Blowup

SOFT = {"law": "drucker_prager", "cohesion": 500.0, "E0": 1e5, "friction_angle": 30.0}


def oracle_of(sim):
    """Copy particles and what is remembered of their pairs into the reference, by birth number."""
    state, n = sim.state, sim.count
    ids = np.asarray(state.id)
    order = np.argsort(ids)
    begin, row, memory = (np.asarray(a) for a in state.contacts())
    hold, rest, spring = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n, 3))
    for p in range(n):
        for e in range(begin[p], begin[p + 1]):
            i, j = ids[p], ids[row[e]]
            hold[i, j] = memory[e, 0]
            if memory[e, 0] > 0:
                rest[i, j] = memory[e, 1]
            else:
                spring[i, j] = memory[e, 1:]
    k = np.asarray(state.k)[order]
    m = np.asarray(state.m)[order]
    table = [neve.particles.constants.contact_constants(sim.scene.snow)]
    return reference.Cluster(
        np.asarray(state.x)[order], np.asarray(state.v)[order], m, np.asarray(state.radius)[order], k,
        table[0].friction * (1 - np.asarray(state.liquid)[order]), np.asarray(state.bond)[order],
        hold > 0, rest, np.abs(hold), hold < 0, spring,
        2 * 0.1 * np.sqrt(np.min(m / (2 * k))), 0.5, float(state.last_dt), np.asarray(state.liquid)[order],
        np.asarray(state.V0)[order], np.asarray(state.J_P)[order],
        table[0].yield_pressure, table[0].bond_strain,
    )  # fmt: skip


def test_oracle_of_compaction():
    """Two lumps of soft snow that press each other: 30 steps are those of the reference, to rounding.

    Their bonds grow as strong as the particles that have been compacted.
    """
    lumps = [
        {"shape": "sphere", "center": (s * 0.09, 0.01 * s, 0), "radius": 0.08, "velocity": (-5 * s, 0, 0)}
        for s in (-1, 1)
    ]
    sim = particles(lumps, snow={"E0": 1e5, "theta_c": 0.005, "theta_s": 0.05}, dt=2e-4)
    sim.advance(6e-3)
    sim.solver.begin(0, 0.0)
    cluster = oracle_of(sim)
    before, J = cluster.hold.copy(), cluster.J.copy()
    assert np.min(J) < 0.95
    for _ in range(30):
        sim.advance(2e-4)
        reference.step(cluster, 2e-4, np.zeros(3))
    got, now = columns(sim), oracle_of(sim)
    assert np.mean(cluster.J < J - 0.01) > 0.2
    assert np.mean((cluster.hold > 1.005 * before)[cluster.bonded]) > 0.2
    np.testing.assert_allclose(got["J_P"], cluster.J, rtol=1e-8)
    np.testing.assert_allclose(got["radius"], cluster.radius, rtol=1e-8)
    np.testing.assert_allclose(got["x"], cluster.x, rtol=0, atol=1e-10)
    np.testing.assert_array_equal(now.bonded, cluster.bonded)
    np.testing.assert_allclose(now.bond, cluster.bond, rtol=1e-8)
    held = cluster.bonded | cluster.touching
    np.testing.assert_allclose(now.hold[held], cluster.hold[held], rtol=1e-8, atol=1e-300)


@pytest.mark.parametrize("wet", [False, True])
def test_oracle(wet):
    """Two lumps that collide, break and rub: 40 steps are those of the reference, to rounding.

    wet: a third of the particles is water, a third is slush.
    """
    lumps = [
        {"shape": "sphere", "center": (-0.09, 0, 0), "radius": 0.08, "velocity": (4, 0, 0.5)},
        {"shape": "sphere", "center": (0.09, 0.01, 0.03), "radius": 0.08, "velocity": (-4, 0, 0)},
    ]
    sim = particles(lumps, snow=SOFT, gravity=(0, 0, -9.81), dt=2e-4)
    sim.advance(4e-3)
    if wet:
        sim.state.liquid[...] = (np.asarray(sim.state.id) % 3) / 2
    sim.solver.begin(0, 0.0)
    cluster = oracle_of(sim)
    assert cluster.touching.any()
    assert cluster.bonded.any()
    before = cluster.bonded.sum()
    for _ in range(40):
        sim.advance(2e-4)
        reference.step(cluster, 2e-4, np.array([0, 0, -9.81]))
    got = columns(sim)
    assert cluster.bonded.sum() < before
    np.testing.assert_allclose(got["x"], cluster.x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(got["v"], cluster.v, rtol=0, atol=1e-9)
    d = sim.diagnostics()
    assert d.bonds == cluster.bonded.sum() / 2
    assert d.contacts == cluster.touching.sum() / 2


def test_what_landed_is_expected_to_stay():
    """The drift that lists of neighbours allow for is that of the snow now: not that of its fall."""
    sim = particles(
        [{"shape": "box", "center": (0, 0, 0.13), "size": (0.2, 0.2, 0.2), "velocity": (0, 0, -4)}],
        [{"shape": "plane", "mode": "sticky"}], gravity=(0, 0, -9.81), snow={"E0": 1e5},
    )  # fmt: skip
    sim.advance(1e-3)
    np.testing.assert_allclose(sim.state.drift, (0, 0, -4), atol=0.05)
    sim.advance(0.3)
    sim.advance(1e-3)
    assert np.linalg.norm(sim.state.drift) < 0.5


def test_momentum():
    """Forces of pairs are opposite to the bit: momentum stays within the rounding of its sums."""
    lumps = [
        {"shape": "sphere", "center": (-0.16, 0, 0), "radius": 0.14, "velocity": (5, 0, 1)},
        {
            "shape": "sphere",
            "center": (0.16, 0.02, 0),
            "radius": 0.14,
            "velocity": (-5, 0, 0),
            "spin": (0, 9, 0),
        },
    ]
    sim = particles(lumps)
    start = sim.diagnostics()
    sim.advance(0.05)
    end = sim.diagnostics()
    assert end.bonds < start.bonds
    scale = start.mass * 5
    np.testing.assert_allclose(end.momentum, start.momentum, rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(end.mass, start.mass, rtol=sim.count * 2.3e-16)  # sums in another order


def test_spin_of_a_bonded_lump():
    """Bonds pull along their own line: a lump that spins keeps its angular momentum and its bonds."""
    sim = particles(
        [{"shape": "sphere", "radius": 0.12, "spin": (0.4, -0.2, 0.8)}], snow={"plasticity": "none"}
    )
    spin = lambda p: np.sum(np.cross(p["x"], p["m"][:, None] * p["v"]), axis=0)  # noqa: E731
    start, bonds = spin(columns(sim)), sim.diagnostics().bonds
    sim.advance(0.3)
    np.testing.assert_allclose(spin(columns(sim)), start, rtol=0, atol=1e-11 * np.linalg.norm(start))
    assert sim.diagnostics().bonds == bonds


def test_free_flight_is_at_rest():
    """Snow is born without stress: it flies without breaking, and its elastic energy stays zero."""
    sim = particles([{"shape": "sphere", "radius": 0.15, "velocity": (7, -3, 2)}])
    bonds = sim.diagnostics().bonds
    sim.advance(0.1)
    d = sim.diagnostics()
    assert d.bonds == bonds > 3 * sim.count
    assert d.elastic < 1e-15 * d.kinetic
    assert np.all(np.asarray(sim.state.J_P) == 1.0)


def busy(precision, threads=1):
    return particles(
        [
            {"shape": "box", "center": (-0.2, 0, 0.2), "size": (0.25, 0.25, 0.25), "velocity": (5, 0, -3)},
            {
                "shape": "sphere", "center": (0.15, 0.03, 0.2), "radius": 0.15, "velocity": (-5, 0, -3),
                "snow": SOFT,
            },
        ],
        [
            {"shape": "plane", "normal": (0.1, 0, 1), "mu_c": 0.3},
            {"shape": "box", "center": (0, 0.1, 0.05), "size": (0.1, 0.1, 0.2), "spin": (0, 0, 9)},
        ],
        gravity=(0, 0, -9.81),
        precision=precision,
        threads=threads,
    )  # fmt: skip


def same(a, b):
    one, two = a.arrays(), b.arrays()
    assert one.keys() == two.keys()
    for name, value in one.items():
        np.testing.assert_array_equal(value, two[name], err_msg=name)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_same_bits(precision):
    """Any number of threads, and a run that went on from what was saved, give the same bits."""
    sims = [busy(precision, threads) for threads in (1, 2, 3)]
    for sim in sims:
        sim.advance(0.02)
        sim.advance(0.02)
    same(sims[0], sims[1])
    same(sims[0], sims[2])
    assert sims[0].diagnostics() == sims[1].diagnostics()
    resumed = busy(precision)
    resumed.advance(0.02)
    resumed = neve.Simulation.restore(resumed.scene, resumed.arrays(), threads=1)
    resumed.diagnostics()  # looks, and changes nothing
    resumed.advance(0.02)
    same(sims[0], resumed)


def test_energy_never_grows():
    """Of lumps that fall, break and heap up, energy less the work of the colliders only falls, step by step.

    What is allowed is the swing of explicit steps: symplectic Euler keeps the energy of a linear vibration to
    w dt / 2 of what vibrates, elastic and kinetic, here far below the 0.5 % of the start that may come back.
    """
    sim = busy("float64")
    start = lowest = energy(sim)
    for _ in range(120):
        sim.advance(5e-3)
        now = energy(sim)
        assert now <= lowest + 5e-3 * abs(start)
        lowest = min(lowest, now)
    assert lowest < 0.5 * start


@pytest.mark.parametrize("order", [1, -1])
def test_energy_between_solids(order):
    """A floor that holds what a paddle moves on adds no energy, whichever of the two acts first.

    The floor stops a particle that the paddle then moves on. Counted as a force on a particle at rest, the
    floor's impulse would do no work, though it is what moves the particle against the bonds.
    """
    dx = 0.02
    floor = {"shape": "plane", "mode": "sticky"}
    paddle = {
        "shape": "box", "center": (0, 0, 1.5 * dx), "size": (6 * dx, 1.5 * dx, 2.5 * dx),
        "spin": (0, 0, 4.5), "mu_c": 0.5,
    }  # fmt: skip
    sim = particles(
        [{"shape": "box", "size": (7 * dx, 7 * dx, 2.5 * dx), "center": (0, 0, 1.3 * dx)}],
        [floor, paddle][::order],
        snow={"law": "drucker_prager", "rho0": 6.3, "E0": 2900.0, "cohesion": 94.0, "friction_angle": 54.0},
        dx=dx, particles_per_cell=1,
    )  # fmt: skip
    lowest, moved = energy(sim), 0.0
    for _ in range(100):
        sim.advance(2e-3)
        d = sim.diagnostics()
        moved = max(moved, d.kinetic + d.elastic)
        assert energy(sim) <= lowest + 5e-3 * moved
        lowest = min(lowest, energy(sim))
    assert moved > 1e-5


@pytest.mark.parametrize(("angle", "mu", "slides"), [(30.0, 0.3, True), (20.0, 0.6, False)])
def test_block_on_a_slope(angle, mu, slides):
    """An elastic block slides with g (sin a - mu cos a), or stays where mu > tan a."""
    a = np.radians(angle)
    n = (np.sin(a), 0, np.cos(a))
    along = np.array([np.cos(a), 0, -np.sin(a)])
    sim = particles(
        [
            {
                "shape": "box", "center": tuple(0.1 * np.array(n)), "size": (0.2, 0.2, 0.15),
                "rotation": (0, angle, 0),
            }
        ],
        [{"shape": "plane", "normal": n, "mu_c": mu}],
        gravity=(0, 0, -9.81), snow={"plasticity": "none"},
    )  # fmt: skip
    sim.advance(0.4)
    speed = lambda: float(np.asarray(sim.state.v).mean(axis=0) @ along)  # noqa: E731
    early = speed()
    sim.advance(0.2)
    gained = (speed() - early) / 0.2
    exact = 9.81 * (np.sin(a) - mu * np.cos(a)) if slides else 0.0
    assert gained == pytest.approx(exact, abs=0.02 * 9.81)
    force = sim.exchanged[0, :3] / 0.6
    weight = 9.81 * sim.diagnostics().mass
    assert force @ np.array(n) == pytest.approx(-weight * np.cos(a), rel=0.1)


def test_compaction():
    """A block between plates is compacted, never beyond ice; radius, volume and density go together."""
    snow = {"theta_c": 0.01, "E0": 1e5}
    plates = [
        {"shape": "plane"},
        {"shape": "box", "center": (0, 0, 0.27), "size": (0.6, 0.6, 0.1), "velocity": (0, 0, -1.0)},
    ]
    for s, u in ((-1, 0), (1, 0), (-1, 1), (1, 1)):
        side = np.array([s * u, s * (1 - u), 0])
        plates.append({"shape": "plane", "point": tuple(0.1 * side), "normal": tuple(-1.0 * side)})
    sim = particles([{"shape": "box", "center": (0, 0, 0.1), "size": (0.2, 0.2, 0.2)}], plates, snow=snow)
    born = columns(sim)
    sim.advance(0.12)
    now = columns(sim)
    J = now["J_P"]
    np.testing.assert_allclose(J, (now["radius"] / born["radius"]) ** 3, rtol=1e-9)
    assert np.mean(J) < 0.75
    density = now["m"] / (now["V0"] * J)
    assert density.max() <= ICE * (1 + 1e-6)
    np.testing.assert_array_equal(now["m"], born["m"])


def test_layer_at_rest_is_not_compacted():
    """Snow whose own weight is below its yield pressure keeps its volume, and comes to rest."""
    sim = particles(
        [{"shape": "box", "center": (0, 0, 0.1), "size": (0.3, 0.3, 0.2)}], [{"shape": "plane"}],
        gravity=(0, 0, -9.81), snow={"E0": 5e5},
    )  # fmt: skip
    bonds = sim.diagnostics().bonds
    sim.advance(0.5)
    assert np.all(np.asarray(sim.state.J_P) == 1.0)
    d = sim.diagnostics()
    assert np.sqrt(2 * d.kinetic / d.mass) < 0.02
    assert d.bonds > 0.98 * bonds


def test_snow_is_added_and_changed():
    """A run takes more snow, which is bonded in itself, and goes on in a changed scene with the same snow."""
    sim = busy("float64")
    sim.advance(0.01)
    bonds, count = sim.diagnostics().bonds, sim.count
    source = {"shape": "box", "center": (1, 1, 1), "size": (0.1, 0.1, 0.1)}
    from neve.scene.schema.scene import Scene

    more = Scene.model_validate({"sources": [source]}).sources[0]
    sim.add(more)
    assert sim.count > count
    assert sim.diagnostics().bonds > bonds
    assert np.array_equal(np.sort(np.asarray(sim.state.id)), np.arange(sim.count))
    before = columns(sim)
    sim.change(sim.scene.model_copy(update={"colliders": sim.scene.colliders[:1]}))
    for name, value in columns(sim).items():
        np.testing.assert_array_equal(value, before[name], err_msg=name)
    sim.advance(0.01)
    assert len(sim.exchanged) == 1


def test_first_step_knows_no_earlier_one():
    """Fresh snow has turned no spring of friction yet, whatever the memory held before."""
    for _ in range(20):
        sim = particles([{"shape": "sphere", "radius": 0.1}], precision="float32")
        assert sim.arrays()["last_dt"] == 0
        junk = [np.full(n, np.nan, np.float32) for n in range(10, 2000, 50)]
        del junk


def test_what_is_refused():
    """A particle that is lost, and contacts of other particles: one sentence each."""
    sim = particles([{"shape": "sphere", "radius": 0.1}])
    sim.state.x[3] = np.nan
    with pytest.raises(Blowup, match="is lost"):
        sim.advance(0.01)
    sim = particles([{"shape": "sphere", "radius": 0.1}])
    arrays = dict(sim.arrays())
    arrays[CONTACTS[1]] = arrays[CONTACTS[1]] + sim.count
    with pytest.raises(ValueError, match="contacts"):
        neve.Simulation.restore(sim.scene, arrays)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_gpu_is_refused_in_one_sentence(precision):
    """This method has no stages on a GPU, and says so one there or not; "auto" takes the processor."""
    ball = [{"shape": "sphere", "radius": 0.1}]
    with pytest.raises(SceneError) as error:
        particles(ball, device="cuda", precision=precision)
    told = 'numerics.device = "cuda" has no numerics.method = "particles": use "cpu".'
    assert str(error.value) == told
    assert particles(ball, device="auto", precision=precision).count > 0


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (
            {"snow_keyframes": [{"t": 1.0, "E0": 1e5}]},
            'snow_keyframes: numerics.method = "particles" changes',
        ),
    ],
)
def test_what_only_the_grid_can_is_refused(more, told):
    """Snow that changes in time: one sentence that names the key and the method."""
    with pytest.raises(SceneError, match=re.escape(told)) as error:
        particles([{"shape": "sphere", "radius": 0.1}], more=more)
    assert "\n" not in str(error.value)
    assert str(error.value).endswith('use "mpm".')
