"""Which rank owns a block: the curve through all blocks, and where it is cut."""

import numpy as np
import pytest

from neve import _core
from neve.domains.halo import keys_of
from neve.ranks import launch
from neve.ranks.ownership import cuts_of
from neve.ranks.requirements import require_able
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene

RANKS = _core.f32.ranks


def test_curve_takes_bits_in_turn():
    """Place 3 k + (2, 1, 0) of the number is bit k of x, y, z, each moved by 2^20 (Morton 1966)."""
    rng = np.random.default_rng(1)
    blocks = rng.integers(-(2**20), 2**20, (200, 3)).astype(np.int32)
    expected = []
    for at in blocks.astype(object) + 2**20:
        bits = [(int(at[axis]) >> k & 1) << (3 * k + 2 - axis) for k in range(21) for axis in range(3)]
        expected.append(sum(bits))
    found = RANKS.curve(keys_of(blocks).astype(np.uint64))
    assert found.tolist() == expected


@pytest.mark.parametrize("ranks", [1, 2, 3, 7, 64])
def test_shares_differ_by_a_block(ranks):
    """Each cut is at the block that begins nearest to its share: no rank has more than a block too much."""
    rng = np.random.default_rng(2)
    curve = rng.choice(10**6, 500, replace=False).astype(np.uint64)
    work = rng.uniform(1.0, 10.0, 500)
    cuts = cuts_of(curve, work, ranks)
    assert cuts.shape == (ranks - 1,)
    assert np.all(np.diff(cuts.astype(np.int64)) >= 0)
    owners = np.searchsorted(cuts, curve, side="right")
    shares = np.bincount(owners, work, minlength=ranks)
    assert np.abs(shares - work.sum() / ranks).max() <= 10.0


def test_more_ranks_than_blocks():
    """Some own nothing, each block has one owner, and no block at all is nobody's trouble."""
    cuts = cuts_of(np.array([5, 9], np.uint64), np.ones(2), 5)
    assert len({*np.searchsorted(cuts, [5, 9], side="right").tolist()}) == 2
    assert cuts_of(np.zeros(0, np.uint64), np.zeros(0), 3).tolist() == [2**64 - 1] * 2


def test_owners_follow_the_curve():
    """The core finds the owner that the cuts say."""
    blocks = np.stack(np.meshgrid(*[np.arange(-3, 4, dtype=np.int32)] * 3), -1).reshape(-1, 3)
    keys = keys_of(blocks).astype(np.uint64)
    curve = RANKS.curve(keys)
    cuts = cuts_of(curve, np.ones(len(curve)), 4)
    assert RANKS.owners(keys, cuts).tolist() == np.searchsorted(cuts, curve, side="right").tolist()


def test_launch_is_read_from_the_environment():
    """Open MPI and MPICH name size and rank; a process by itself is one rank and leads."""
    assert (launch.size({}), launch.rank({}), launch.leads({})) == (1, 0, True)
    open_mpi = {"OMPI_COMM_WORLD_SIZE": "4", "OMPI_COMM_WORLD_RANK": "3", "OMPI_COMM_WORLD_LOCAL_SIZE": "2"}
    assert (launch.size(open_mpi), launch.rank(open_mpi), launch.local_size(open_mpi)) == (4, 3, 2)
    assert not launch.leads(open_mpi)
    mpich = {"PMI_SIZE": "2", "PMI_RANK": "0"}
    assert (launch.size(mpich), launch.local_size(mpich), launch.leads(mpich)) == (2, 2, True)


@pytest.mark.parametrize(
    ("part", "sentence"),
    [
        ({"numerics": {"method": "particles"}}, 'numerics.method = "particles"'),
        ({"numerics": {"integrator": "implicit"}}, 'numerics.integrator = "implicit"'),
        ({"numerics": {"sleep": True}}, "numerics.sleep = true"),
        ({"heat": {}}, "heat"),
        ({"sinks": [{"shape": "box", "center": [0, 0, -3], "size": [1, 1, 1]}]}, "sinks"),
    ],
)
def test_what_ranks_refuse(part, sentence):
    """One sentence: which key, that ranks cannot do it, what to do."""
    source = {"shape": "sphere"}
    with pytest.raises(SceneError, match="a run over 4 ranks cannot do that") as refused:
        require_able(Scene.model_validate({"sources": [source], **part}), 4)
    assert str(refused.value).startswith(sentence)
    require_able(Scene.model_validate({"sources": [source]}), 4)
