"""What the viewer gets of a run on a GPU: 16 bits a number, found there, instead of whole columns."""

import numpy as np
import pytest
from gpu.runs import FLOOR, LUMP, WIDE, advanced, scene, several

from neve.cuda.layout import SHADES
from neve.viewer.modes import MODES, measure
from neve.viewer.players.snapshot import of_simulation

FALLEN = scene(FLOOR, source={**WIDE, "velocity": [0, 0, -9]}, precision="float32")
TWO = {**FALLEN, "sources": [*FALLEN["sources"], {**LUMP, "center": [0, 0, 0.6], "snow": {"rho0": 200}}]}


def shown(sim, mode):
    """The snapshot of one colour mode."""
    return of_simulation(sim, {mode} if mode else set(), {}, 0, {}, 0)


@pytest.mark.parametrize("devices", [(0,), (0, 1, 2)])
@pytest.mark.parametrize("mode", SHADES)
def test_as_from_the_columns(some_gpus, devices, mode):
    """Positions and values are within half a step of those that the columns have, in the order of birth."""
    sim = advanced(several(TWO, devices), "cuda")
    order = np.argsort(np.asarray(sim.state.id))
    x = np.asarray(sim.state.x)[order]
    found = shown(sim, mode)
    half = 0.51 * np.ptp(x, axis=0).max() / 65534
    np.testing.assert_allclose(found.x, x, rtol=0, atol=half)
    if not mode:
        assert found.values == {}
        return
    values = measure(mode, sim.columns(), 2 * sim.radius)[order]
    assert np.ptp(values) > 0
    atol = 0.51 * np.ptp(values) / 65534 + 1e-5 * np.abs(values).max()
    np.testing.assert_allclose(found.values[mode], values, rtol=0, atol=atol)
    assert not found.x.flags.writeable


def test_every_fast_mode_of_the_method(some_gpu):
    """No colour of a material point run but fragments, which are looked for among all, needs a copy."""
    sim = advanced(FALLEN, "cuda")
    has = {name for name, mode in MODES.items() if set(mode.needs) <= set(sim.columns()) and not mode.slow}
    assert has - {"snow"} == set(SHADES) - {""}
    assert sim.solver.quantised("fragment") is None
    assert advanced(FALLEN, "cpu").solver.quantised("speed") is None


def test_eight_bytes_a_particle(gpu, monkeypatch):
    """Besides the numbers of the particles, which are copied once after each sort."""
    sim = advanced(FALLEN, "cuda")
    shown(sim, "stress")
    copied = []
    plain = type(gpu).download
    monkeypatch.setattr(
        type(gpu), "download", lambda self, to, at, size: copied.append(size) or plain(self, to, at, size)
    )
    shown(sim, "stress")
    assert sum(copied) <= 8 * sim.count + 256


def test_a_particle_without_numbers(gpu):
    """Is not drawn, and spoils neither the ends of the others nor their colours."""
    sim = advanced(FALLEN, "cuda")
    sim.state.x[7] = [np.nan, 0.0, 0.0]
    sim.state.v[9] = [0.0, np.inf, 0.0]
    lost, fast = int(sim.state.id[7]), int(sim.state.id[9])
    found = shown(sim, "speed")
    assert np.flatnonzero(np.isnan(found.x).any(axis=1)).tolist() == [lost]
    others = np.arange(sim.count) != fast
    v = np.linalg.norm(np.asarray(sim.state.v), axis=1)
    assert found.values["speed"][others].max() == pytest.approx(v[np.isfinite(v)].max(), rel=1e-5)


@pytest.mark.parametrize("count", [0, 1])
def test_few_particles(gpu, count):
    """None, and one: there is no extent to divide."""
    sim = advanced(FALLEN, "cuda")
    core, model = sim.solver.model.core, sim.solver.model.native
    state = core.State(count, model.more_modes)
    state.x[:] = [1.0, 2.0, 3.0]
    found = core.quantised(model, state, "speed")
    np.testing.assert_allclose(
        found.low[:3] + found.step[:3] * found.q[:, :3], np.full((count, 3), [1.0, 2.0, 3.0]), atol=1e-5
    )
