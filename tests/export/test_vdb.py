"""VDB: read back by tinyvdb, and by OpenVDB itself where the system has it (Debian: python3-openvdb)."""

import itertools
import subprocess

import numpy as np
import pytest
from patience import PATIENCE

from neve.export.formats.vdb_tree import VdbGrid, leaves_of, write_vdb
from neve.export.run import Choices, export_run
from neve.io.checkpoint import read_checkpoint
from neve.scene.reading.load import load

SYSTEM = "/usr/bin/python3"
DUMP = """
import sys, numpy as np, pyopenvdb
grids, facts = pyopenvdb.readAll(sys.argv[1])
out = {"creator": facts["creator"]}
for g in grids:
    low, high = g.evalActiveVoxelBoundingBox()
    a = np.zeros([h - l + 1 for l, h in zip(low, high)] + ([3] if g.valueTypeName == "vec3s" else []), "f4")
    g.copyToArray(a, ijk=low)
    mask = np.zeros(a.shape[:3], "f4")
    for v in g.iterOnValues():
        (x, y, z), (X, Y, Z) = v.min, v.max
        mask[x - low[0] : X - low[0] + 1, y - low[1] : Y - low[1] + 1, z - low[2] : Z - low[2] + 1] = 1
    t = g.transform
    out.update({g.name: a, g.name + "_low": low, g.name + "_on": mask})
    out.update({g.name + "_first": t.indexToWorld((0, 0, 0)), g.name + "_size": t.voxelSize()[0]})
np.savez(sys.argv[2], **out)
"""


@pytest.fixture
def openvdb(tmp_path):
    """Read a file with OpenVDB into arrays, each over the box of its active voxels."""
    there = subprocess.run([SYSTEM, "-c", "import pyopenvdb"], capture_output=True, check=False)
    if there.returncode:
        pytest.skip("no OpenVDB: apt-get install python3-openvdb libopenvdb-tools")

    def read(path):
        subprocess.run([SYSTEM, "-c", DUMP, path, tmp_path / "read.npz"], check=True, timeout=PATIENCE)
        return dict(np.load(tmp_path / "read.npz"))

    return read


def spread(x, amount, cell, low, shape):
    """Amounts (n, k) over cells by quadratic B-splines: 3/4 - d^2 or (3/2 - abs(d))^2 / 2 along an axis."""
    total = np.zeros((*shape, amount.shape[1]))
    nearest = np.floor(x / cell).astype(int)
    for offset in itertools.product((-1, 0, 1), repeat=3):
        node = nearest + offset
        d = np.abs(x / cell - (node + 0.5))
        w = np.where(d < 0.5, 0.75 - d**2, 0.5 * (1.5 - d) ** 2).prod(axis=1)
        np.add.at(total, tuple((node - low).T), w[:, None] * amount)
    return total


@pytest.fixture
def wanted(run_path, frame):
    """Density and velocity of frame 4 over a box of cells, and its lowest cell."""
    content, arrays = frame(4), read_checkpoint(run_path / "checkpoint").arrays
    mass = arrays["m"][np.argsort(arrays["id"])].astype(np.float64)
    cell = load(run_path).numerics.spacing
    x = content.x.astype(np.float64)
    low = np.floor(x.min(axis=0) / cell).astype(int) - 1
    shape = np.floor(x.max(axis=0) / cell).astype(int) + 2 - low
    amount = np.column_stack([mass, mass[:, None] * content.v])
    grid = spread(x, amount, cell, low, shape) / cell**3
    return grid[..., 0], grid[..., 1:] / np.maximum(grid[..., :1], 1e-30), low, cell, mass.sum()


def test_density_is_that_of_the_particles(run_path, wanted):
    """Read by tinyvdb: sum m w / h^3 at each voxel, in the right place, and in all the mass of the snow."""
    tinyvdb = pytest.importorskip("tinyvdb", reason="pip install tinyvdb, of the extra test")
    folder, _ = export_run(run_path, Choices("vdb"))
    file = tinyvdb.open(str(folder / "snow_000004.vdb"))
    file.read_grids()
    assert [(file.grid_name(i), file.grid_type_name(i)) for i in range(2)] == [
        ("density", "Tree_float_5_4_3"),
        ("velocity", "Tree_vec3s_5_4_3"),
    ]
    density, _, low, cell, mass = wanted
    grid = file.grid(0)
    assert grid.transform["voxel_size"] == (cell,) * 3
    np.testing.assert_allclose(grid.transform["translation"], [cell / 2] * 3)
    found = grid.to_sparse()
    places = np.frombuffer(found["coords"], np.int32).reshape(-1, 3)
    values = np.frombuffer(found["values"], np.float32)
    assert len(values) == np.count_nonzero(density > 0)
    np.testing.assert_allclose(values, density[tuple((places - low).T)], rtol=1e-4, atol=1e-3)
    assert values.sum(dtype=np.float64) * cell**3 == pytest.approx(mass, rel=1e-5)


def test_openvdb_reads_density_and_velocity(run_path, wanted, openvdb):
    """Both grids have the same voxels; velocities are momentum over mass."""
    folder, _ = export_run(run_path, Choices("vdb"))
    read = openvdb(folder / "snow_000004.vdb")
    density, velocity, low, cell, _ = wanted
    box = tuple(
        slice(a, a + n) for a, n in zip(read["density_low"] - low, read["density"].shape, strict=True)
    )
    np.testing.assert_allclose(read["density"], density[box], rtol=1e-4, atol=1e-3)
    np.testing.assert_array_equal(read["density_on"] > 0, density[box] > 0)
    np.testing.assert_array_equal(read["velocity_on"], read["density_on"])
    heavy = density[box] > 1.0
    np.testing.assert_allclose(read["velocity"][heavy], velocity[box][heavy], rtol=1e-3, atol=1e-3)
    assert (read["density_size"], read["creator"].item()) == (cell, "Neve")
    told = subprocess.run(
        ["vdb_print", "-m", folder / "snow_000004.vdb"], capture_output=True, text=True, check=True
    )
    assert "fog volume" in told.stdout


def scattered(seed):
    """Leaves far apart on both sides of 0, in many nodes, each voxel active or not by chance."""
    rng = np.random.default_rng(seed)
    far = rng.integers(-700, 700, (40, 3)) * 8
    near = np.stack(np.meshgrid(*[np.arange(-3, 4) * 8] * 3), axis=-1).reshape(-1, 3)
    leaves = np.unique(np.concatenate([far, near]), axis=0)
    rng.shuffle(leaves)
    active = rng.random((len(leaves), 8, 8, 8)) < rng.random((len(leaves), 1, 1, 1))
    active[0] = True
    return leaves, active, rng


@pytest.mark.parametrize("seed", [1, 2, None])
def test_any_tree_is_read_as_it_was_written(tmp_path, seed, openvdb):
    """Several roots and nodes, full, sparse and empty leaves, numbers and vectors, inactive values are 0.

    Without a seed: no leaves at all.
    """
    leaves, active, rng = scattered(seed or 1)
    if seed is None:
        leaves, active = leaves[:0], active[:0]
    first = np.array([0.5, -2.0, 3.25])
    numbers = rng.normal(size=active.shape).astype(np.float32)
    arrows = rng.normal(size=(*active.shape, 3)).astype(np.float32)
    grids = [
        VdbGrid("a", leaves, active, numbers, 0.25, first, {}),
        VdbGrid("b", leaves, active, arrows, 2.0, first, {}),
    ]
    with open(tmp_path / "a.vdb", "wb") as file:
        write_vdb(file, grids, {"creator": "x"})
    script = (
        "import sys, numpy as np, pyopenvdb\n"
        "leaves = np.load(sys.argv[2])\n"
        "grids, _ = pyopenvdb.readAll(sys.argv[1])\n"
        "out = {}\n"
        "for g in grids:\n"
        "    width = [3] if g.valueTypeName == 'vec3s' else []\n"
        "    got = np.zeros([len(leaves), 8, 8, 8] + width, 'f4')\n"
        "    for row, leaf in enumerate(leaves):\n"
        "        g.copyToArray(got[row], ijk=[int(c) for c in leaf])\n"
        "    out[g.name] = got\n"
        "    out[g.name + '_count'] = g.activeVoxelCount()\n"
        "    out[g.name + '_at'] = g.transform.indexToWorld((4, 8, -12))\n"
        "np.savez(sys.argv[3], **out)\n"
    )
    np.save(tmp_path / "leaves.npy", leaves)
    command = [SYSTEM, "-c", script, tmp_path / "a.vdb", tmp_path / "leaves.npy", tmp_path / "out.npz"]
    subprocess.run(command, check=True, timeout=PATIENCE)
    read = np.load(tmp_path / "out.npz")
    assert np.array_equal(read["a"], np.where(active, numbers, 0))
    assert np.array_equal(read["b"], np.where(active[..., None], arrows, 0))
    assert read["a_count"] == read["b_count"] == active.sum()
    np.testing.assert_allclose(read["a_at"], first + 0.25 * np.array([4, 8, -12]))
    np.testing.assert_allclose(read["b_at"], first + 2.0 * np.array([4, 8, -12]))


def test_blocks_are_gathered_into_leaves():
    """Cell (i, j, k) of block b is voxel 4 b + (i, j, k), also below 0; missing blocks are 0."""
    rng = np.random.default_rng(4)
    blocks = np.unique(rng.integers(-3, 4, (60, 3)), axis=0)
    values = rng.random((len(blocks), 4, 4, 4))
    leaves, (gathered,) = leaves_of(blocks, [values])
    assert gathered.sum() == pytest.approx(values.sum())
    at = {tuple(leaf): row for row, leaf in enumerate(leaves)}
    for block, mine in zip(blocks, values, strict=True):
        voxel = 4 * block + [3, 0, 2]
        leaf = voxel // 8 * 8
        assert gathered[at[tuple(leaf)], *(voxel - leaf)] == mine[3, 0, 2]


def test_the_same_frame_has_the_same_bytes(run_path, tmp_path):
    """No time, no random name."""
    first, _ = export_run(run_path, Choices("vdb"), tmp_path / "a", slice(2, 3))
    second, _ = export_run(run_path, Choices("vdb"), tmp_path / "b", slice(2, 3))
    assert (first / "snow_000002.vdb").read_bytes() == (second / "snow_000002.vdb").read_bytes()


def test_metres_do_not_change_the_density(run_path, tmp_path, openvdb):
    """In centimetres with y up the voxels are 100 times as long, the kilograms of a cubic metre the same."""
    metres = openvdb(export_run(run_path, Choices("vdb"), tmp_path / "a", slice(2, 3))[0] / "snow_000002.vdb")
    turned = Choices("vdb", up="y", scale=100.0)
    other = openvdb(export_run(run_path, turned, tmp_path / "b", slice(2, 3))[0] / "snow_000002.vdb")
    # y up: (x, y, z) -> (x, z, -y); cells are symmetric about 0, so their centres fall on centres
    np.testing.assert_allclose(
        other["density"], metres["density"].transpose(0, 2, 1)[:, :, ::-1], rtol=1e-3, atol=1e-2
    )
    assert other["density_size"] == pytest.approx(100 * metres["density_size"], rel=1e-6)
