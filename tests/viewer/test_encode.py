"""Bytes on the wire: what goes in comes out, within half a step."""

import json

import numpy as np
import pytest
from viewer.conftest import SMALL

from neve.scene.reading.load import scene_from
from neve.simulation import Simulation
from neve.viewer.encode import encode
from neve.viewer.modes import MODES, Colors, Scale, measure, rounded
from neve.viewer.players.snapshot import Snapshot, by_birth
from neve.viewer.protocol.state import MOST, framed, pack, unframed

BLOCK = {"shape": "box", "center": [0.0, 0.0, 0.21], "size": [0.4, 0.4, 0.4], "velocity": [1.0, 0.5, -2.0]}


def cloud(n=1000, size=(4.0, 2.0, 0.5)):
    rng = np.random.default_rng(1)
    return (rng.random((n, 3)) * size - [1.0, 5.0, 0.1]).astype(np.float32)


def test_positions_are_off_by_half_a_step_at_most():
    """|x - (low + step q)| <= step / 2 and some ulp of float32 at 5 m; step = extent / 65535."""
    x = cloud()
    packed = pack(x, None, (0.0, 1.0))
    extent = x.max(axis=0) - x.min(axis=0)
    np.testing.assert_allclose(packed.step, extent / MOST, rtol=1e-5)
    off = np.abs(packed.positions() - x)
    assert (off <= 0.5 * packed.step * (1 + 1e-3) + 4 * 2.0**-22).all()
    assert off.max() < 4e-5


@pytest.mark.parametrize("x", [np.zeros((0, 3)), np.ones((1, 3)), np.full((3, 3), np.nan)])
def test_degenerate_clouds_are_packed(x):
    """No particle, one particle, and none with numbers."""
    packed = pack(x.astype(np.float32), None, (0.0, 1.0))
    assert packed.q.shape == (len(x), 4)
    if len(x) == 1:
        np.testing.assert_allclose(packed.positions(), x, atol=1e-6)


def test_lost_particles_are_told_from_the_others():
    """A particle without numbers is put at 65535 three times, and does not disturb the rest."""
    x = cloud()
    x[7] = np.nan
    x[9, 1] = np.inf
    packed = pack(x, None, (0.0, 1.0))
    assert (packed.q[[7, 9], :3] == MOST).all()
    good = np.isfinite(x).all(axis=1)
    assert np.abs(packed.positions()[good] - x[good]).max() < 4e-5


def test_values_run_over_the_legend():
    """The ends of the legend are 0 and 65535, what lies beyond is cut, NaN is 0."""
    value = np.array([-1.0, 0.0, 1.0, 2.0, 9.0, np.nan], np.float32)
    packed = pack(np.zeros((6, 3), np.float32), value, (0.0, 2.0))
    assert packed.q[:, 3].tolist() == [0, 0, 32768, 65535, 65535, 0]


def test_names_keep_their_numbers():
    """Materials and fragments are names: value 65520 stays 65520."""
    value = np.array([0.0, 1.0, 65520.0], np.float32)
    assert pack(np.zeros((3, 3), np.float32), value, MODES["fragment"].limits).q[:, 3].tolist() == [
        0,
        1,
        65520,
    ]


def test_message_has_head_and_aligned_body():
    """The body begins at a multiple of eight bytes, whatever the head; numbers JSON cannot write are null."""
    for name in ("a", "ab", "abc", "é"):
        message = framed({"name": name, "x": float("nan"), "y": [float("inf"), 1.5]}, b"12345678")
        head, body = unframed(message)
        assert head == {"name": name, "x": None, "y": [None, 1.5]}
        assert body == b"12345678"
        assert (len(message) - 8) % 8 == 0


def test_snapshot_becomes_a_state():
    """A page finds n x 8 bytes, the legend, the poses and the number of the state."""
    x = cloud(10)
    poses = ((np.array([1.0, 2.0, 3.0]), np.eye(3)),)
    snapshot = Snapshot(x, {"speed": np.arange(10, dtype=np.float32)}, poses, 0.5, 15, {"steps": 3}, 2)
    head, body = unframed(encode(snapshot, Colors("speed"), Scale(), 7))
    q = np.frombuffer(body, "<u2").reshape(10, 4)
    assert head["n"] == 10
    assert head["version"] == 7
    assert head["mode"] == "speed"
    assert head["limits"] == [0.0, 10.0]
    assert head["poses"] == [[1, 2, 3, 1, 0, 0, 0, 1, 0, 0, 0, 1]]
    assert np.abs(np.array(head["low"]) + np.array(head["step"]) * q[:, :3] - x).max() < 4e-5
    assert json.dumps(head)


def test_a_mode_that_the_snapshot_lacks_is_snow():
    """Between the choice of a mode and the next moment there are no values: the snow is shown plain."""
    head, _ = unframed(encode(Snapshot(cloud(5), {}, (), 0.0, 0), Colors("stress"), Scale(), 0))
    assert head["mode"] == "snow"


def test_rows_come_in_the_order_of_birth():
    """ids without gaps and with gaps give rows in the order of id."""
    rows = np.arange(10, dtype=np.float64)
    shuffled = np.random.default_rng(0).permutation(10)
    assert by_birth(shuffled.astype(np.uint32))(rows[shuffled]).tolist() == rows.tolist()
    gaps = (shuffled * 3 + 1).astype(np.uint32)
    assert by_birth(gaps)(rows[shuffled]).tolist() == rows.tolist()


def test_legend_holds_still():
    """Ends are round, grow with the values, and shrink only when the values have become much smaller."""
    scale = Scale()
    ends = [
        scale.limits("speed", np.linspace(0, top, 100, dtype=np.float32))[1] for top in (4.1, 4.5, 3.0, 0.5)
    ]
    assert ends == [5.0, 5.0, 5.0, rounded(1.05 * 0.98 * 0.5)]
    assert [rounded(v) for v in (1.0, 1.2, 2.9, 8.0, 0.07)] == [1.0, 1.5, 3.0, 10.0, 0.07]


def test_snow_at_rest_has_a_legend_too():
    """All values zero, or none finite: the legend still has two ends."""
    for value in (0.0, np.nan):
        low, high = Scale().limits("speed", np.full(9, value, np.float32))
        assert low < high


def test_stress_is_von_mises_of_the_cauchy_stress():
    """Simple shear tau_xy = 7 with F = 2 I: sqrt(3) 7 / 8; pressure alone gives 0."""
    tau = np.zeros((2, 6))  # xx yy zz xy xz yz
    tau[0, 3] = 7.0
    tau[1, :3] = -5.0
    columns = {"tau": lambda: tau, "F_E": lambda: np.tile(2 * np.eye(3), (2, 1, 1))}
    value = measure("stress", columns, 0.1)
    np.testing.assert_allclose(value, [np.sqrt(3) * 7 / 8, 0.0], rtol=1e-6)


def test_stress_reads_the_state_as_the_core_writes_it():
    """After some steps of a falling block: sqrt(3/2 s:s) / J_E with tau of the law itself, (n, 3, 3)."""
    sim = Simulation(scene_from(SMALL | {"sources": [BLOCK]}), threads=1)
    sim.advance(0.05)
    state = sim.state
    F = np.asarray(state.F_E, np.float64)
    tau = np.zeros((len(F), 3, 3))
    for column, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]):
        tau[:, i, j] = tau[:, j, i] = np.asarray(state.tau)[:, column]
    # An isotropic law's stress has the principal axes of F F^T: the two commute.
    b = F @ F.transpose(0, 2, 1) - np.eye(3)
    assert np.abs(tau).max() > 0
    np.testing.assert_allclose(tau @ b, b @ tau, atol=1e-4 * np.abs(tau).max() * np.abs(b).max())
    s = tau - np.trace(tau, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    expected = np.sqrt(1.5 * (s * s).sum(axis=(1, 2))) / np.linalg.det(F)
    columns = {"tau": lambda: state.tau, "F_E": lambda: state.F_E}
    np.testing.assert_allclose(
        measure("stress", columns, 0.1), expected, rtol=1e-4, atol=1e-6 * expected.max()
    )


def test_fragments_get_names_that_last():
    """Two balls apart are two names; each keeps its name when the other has fallen to powder."""
    rng = np.random.default_rng(2)
    x = rng.random((400, 3)) * 0.3
    x[200:, 0] += 2.0
    J_P = np.ones(400)
    one = measure("fragment", {"x": lambda: x, "J_P": lambda: J_P}, 0.1)
    assert len(set(one[:200])) == 1
    assert len(set(one[200:])) == 1
    assert one[0] != one[399]
    J_P = np.where(np.arange(400) < 200, 2.0, 1.0)
    other = measure("fragment", {"x": lambda: x, "J_P": lambda: J_P}, 0.1)
    assert set(other[:200]) == {0.0}
    assert other[399] == one[399]


@pytest.mark.parametrize("share", [None, np.array([0.0, 0.25, 1.0], np.float32)])
def test_snow_is_sent_as_wet_as_it_is(share):
    """In the mode "snow" a particle's value is its liquid share, of 65535; without heat it is 0."""
    poses = ((np.zeros(3), np.eye(3)),)
    shown = Snapshot(cloud(3), {} if share is None else {"phase": share}, poses, 0.0, 0)
    head, body = unframed(encode(shown, Colors("snow"), Scale(), 1))
    values = np.frombuffer(body, "<u2").reshape(-1, 4)[:, 3].tolist()
    assert head["mode"] == "snow"
    assert values == ([0, 0, 0] if share is None else [0, 16384, 65535])


def test_colours_by_hand_and_by_powers():
    """The value of 16 bits is the logarithm's share of the way; names and negative ends have none."""
    values = np.array([0.01, 1.0, 10.0, 100.0, 1e9], np.float32)
    snapshot = Snapshot(cloud(5), {"speed": values, "material": values}, (), 0.0, 0)
    head, body = unframed(encode(snapshot, Colors("speed", (1.0, 100.0), True), Scale(), 0))
    q = np.frombuffer(body, "<u2").reshape(-1, 4)[:, 3]
    assert (head["limits"], head["log"]) == ([1.0, 100.0], True)
    np.testing.assert_allclose(q, [0, 0, 32767.5, 65535, 65535], atol=1)
    assert not unframed(encode(snapshot, Colors("speed", (-2.0, -1.0), True), Scale(), 0))[0]["log"]
    assert not unframed(encode(snapshot, Colors("material", None, True), Scale(), 0))[0]["log"]
    assert unframed(encode(snapshot, Colors("speed", (0.0, 100.0), True), Scale(), 0))[0]["limits"] == [
        0.01,
        100.0,
    ]
