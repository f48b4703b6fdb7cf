"""The state of lying snow: layers, and what particles get of them."""

import numpy as np
import pytest
from verification.snowfall.surfaces import ground
from verification.snowfall.test_cover import fallen

import neve
from neve.heat.enthalpy import C_ICE, LATENT
from neve.mpm.initial import build
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.snowfall.files import arrays_of, cover_of, read_lying
from neve.snowfall.layers import Layers, restacked

PLANE = {"colliders": [{"shape": "plane"}]}


def stored(cover, path):
    """A file of the cover."""
    np.savez(path, **arrays_of(cover))
    return str(path)


def test_each_part_of_a_fall_is_a_layer():
    """On open ground four parts are four layers of a quarter each, the lowest the oldest."""
    cover = fallen([ground()], depth=None, rate=2.0, duration=8.0)
    assert cover.layers.thickness == pytest.approx(np.broadcast_to(cover.depth[:, None] / 4, (1600, 4)))
    assert np.array_equal(cover.layers.age[0], 3600.0 * np.array([7.0, 5.0, 3.0, 1.0]))
    assert cover.mass == pytest.approx(2.0 * 8.0 * 16.0)


def test_layers_hold_what_lies_where_snow_slides():
    """Where snow slid away and where it landed, the layers are as thick as the snow is deep."""
    cover = fallen()
    assert np.abs(cover.layers.depth - cover.depth).max() < 1e-12
    assert cover.layers.thickness.min() >= 0.0


def test_what_goes_is_taken_from_the_top():
    """2.5 of three layers of 1 leave half of the highest; more lies on the highest."""
    out = restacked(np.ones((2, 3)), np.array([1.5, 4.0]))
    assert np.array_equal(out, [[1.0, 0.5, 0.0], [1.0, 1.0, 2.0]])


def test_a_height_finds_its_layer():
    """Empty layers are passed over; above the snow it is the highest that is not empty."""
    one = Layers.fresh(np.array([[0.1, 0.0, 0.2, 0.0]]), 100.0, -5.0, np.zeros(4))
    found = one.at(np.zeros(4, np.int64), np.array([0.05, 0.15, 0.29, 0.5]))
    assert found.tolist() == [0, 2, 2, 2]


def settled(path):
    """A file of 0.4 m of snow on 2 m by 2 m whose lower half is wet, sintered, and twice as dense."""
    cover = fallen([ground()], depth=0.4, density=100.0, size=(2.0, 2.0))
    state = cover.layers
    low = np.arange(4) < 2
    layers = state.but(
        density=np.where(low, 200.0, 100.0) + 0.0 * state.density,
        temperature=np.where(low, 0.0, -8.0) + 0.0 * state.density,
        liquid=np.where(low, 0.1, 0.0) + 0.0 * state.density,
        growth=np.where(low, 3.0, 1.0) + 0.0 * state.density,
    )
    return stored(type(cover)(**{**vars(cover), "layers": layers}), path)


def holds(file, method="mpm", heat=None):
    """A scene in which that snow lies."""
    return scene_from(
        {
            "numerics": {"dx": 0.1, "method": method},
            "snow": {"law": "cam_clay", "rho0": 100.0, "p0": 100.0},
            "sources": [{"shape": "lying", "file": file}],
            **PLANE,
            **({"heat": heat} if heat else {}),
        }
    )


def test_particles_get_the_state_of_their_layer(tmp_path):
    """Each layer's density, temperature, water and strength; mass and volume are those of the snow.

    A layer that became twice as dense is 2^4.4 times as stiff and 2^2.44 times as strong.
    """
    file = settled(tmp_path / "cover.npz")
    for heat in (None, {"snow_temperature": -1.0}):
        _, found, _ = build(holds(file, heat=heat))
        m, V0 = np.asarray(found.m, float), np.asarray(found.V0, float)
        deep = np.asarray(found.x)[:, 2] < 0.2
        assert m.sum() == pytest.approx(4.0 * 0.2 * 300.0, rel=1e-5)
        assert V0.sum() == pytest.approx(4.0 * 0.4, rel=1e-5)
        assert (m / V0)[deep] == pytest.approx(200.0, rel=0.02)
        assert np.asarray(found.stiffness)[deep] == pytest.approx(2.0**4.4, rel=1e-5)
        grown = 1.0 if heat else 3.0
        assert np.asarray(found.strength)[deep] == pytest.approx(grown * 2.0**2.44, rel=1e-5)
        assert np.asarray(found.strength)[~deep] == pytest.approx(1.0)
        if heat:
            each = found.enthalpy[:, 0] / np.asarray(found.m, float)
            assert each[deep] == pytest.approx(0.1 * LATENT)
            assert each[~deep] == pytest.approx(-8.0 * C_ICE)
            assert found.thermal[deep, 1] == pytest.approx(3.0)


@pytest.mark.parametrize("method", ["sph", "particles"])
def test_methods_without_a_grid_read_the_layers_too(tmp_path, method):
    """Density, stiffness and strength, sintering in it, of each layer; mass and volume of the snow.

    `particles` move apart at birth, so which are of the lower layers their density tells. The jitter of
    places, 0.8 of their distance, keeps each of the four of a half column in its half: half of the volume.
    """
    arrays = neve.Simulation(holds(settled(tmp_path / "cover.npz"), method)).arrays()
    m, V0 = arrays["m"].astype(float), arrays["V0"].astype(float)
    deep = m / V0 > 150.0
    assert m.sum() == pytest.approx(4.0 * 0.2 * 300.0, rel=1e-5)
    assert V0.sum() == pytest.approx(4.0 * 0.4, rel=1e-5)
    assert V0[deep].sum() == pytest.approx(0.5 * V0.sum(), rel=0.02)
    assert arrays["x"][deep, 2].mean() < arrays["x"][~deep, 2].mean() - 0.15
    for rows, density, stiffness, strength in (
        (deep, 200.0, 2.0**4.4, 3.0 * 2.0**2.44),
        (~deep, 100.0, 1.0, 1.0),
    ):
        assert (m / V0)[rows] == pytest.approx(density, rel=0.02)
        assert arrays["stiffness"][rows] == pytest.approx(stiffness, rel=1e-5)
        assert arrays["strength"][rows] == pytest.approx(strength, rel=1e-5)


def test_a_file_gives_the_cover_back(tmp_path):
    """All arrays and books, to the bit."""
    cover = fallen()
    stored(cover, tmp_path / "cover.npz")
    found = cover_of(read_lying(tmp_path / "cover.npz", "f"), "f")
    assert found.books == cover.books
    assert np.array_equal(found.z, cover.z)
    assert np.array_equal(found.x, cover.x)
    for name, values in cover.layers.arrays().items():
        assert np.array_equal(getattr(found.layers, name), values)


def test_damaged_files_are_one_sentence(tmp_path):
    """Neither a file of something else nor one that lacks arrays ends in a traceback."""
    arrays = arrays_of(fallen([ground()]))
    broken = {
        "text": b"no snow",
        "lack": {name: a for name, a in arrays.items() if name != "layers.density"},
        "short": {**arrays, "depth": arrays["depth"][:-1]},
        "other": {"x": np.zeros(3)},
    }
    for name, content in broken.items():
        path = tmp_path / f"{name}.npz"
        if isinstance(content, bytes):
            path.write_bytes(content)
        else:
            np.savez(path, **content)
        scene = scene_from({"sources": [{"shape": "lying", "file": str(path)}], **PLANE})
        with pytest.raises(SceneError, match=r"sources\.0\.file"):
            build(scene)
