"""Every format writes a frame without particles, and one with a particle far away."""

import numpy as np
import pytest

from neve.export.axes import Axes
from neve.export.camera import FilmCamera
from neve.export.format import Job
from neve.export.formats.vtk_grid import MOST_CELLS, fitting
from neve.export.grid import snow_grid
from neve.export.moment import Moment
from neve.export.registry import FORMATS
from neve.scene.schema.camera import Camera

FAR = np.array([[-9e5, 0.0, 5e5], [0.0, 0.1, 0.2], [9e5, 1.0, 0.0]])
FEW = {"none": np.zeros((0, 3)), "one": np.array([[0.1, 0.2, 0.3]]), "far": FAR}


def moment_of(x, v=None):
    """A moment of particles of 2 kg at x."""
    x = x.astype(np.float32)
    v = np.ones_like(x) if v is None else v
    fields = {"v": v, "J_P": np.ones(len(x), np.float32), "material": np.zeros(len(x), np.uint16)}
    return Moment(3, 0.25, x, v, np.arange(len(x)), fields, np.full(len(x), 2.0, np.float32), [])


@pytest.mark.parametrize("few", FEW)
@pytest.mark.parametrize("word", FORMATS.names())
def test_every_format_takes_what_is_few_or_far(word, few, tmp_path):
    """Its files are there, and none is left unfinished."""
    made = FORMATS.get(word)
    if made.package is not None:
        pytest.importorskip(made.package[0])
    camera = FilmCamera(Camera(), (), 0.1, Axes())
    writer = made(Job(tmp_path, (), Axes(), 25, 0.05, 0.1, "", camera))
    with writer:
        writer.begin([3])
        writer.write(moment_of(FEW[few]))
        writer.close({3: 0.25})
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {*writer.names(3), *writer.shared_names()}
    assert all((tmp_path / name).stat().st_size for name in names)


def test_far_blocks_keep_their_own_velocity():
    """Two particles 1.8e6 m apart, of which one rests: mass and momentum of each are around it."""
    x = np.array([[-9e5, 0.0, 0.0], [9e5, 0.0, 0.0], [9e5, 0.0, 700.0]])
    v = np.array([[0.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, -1.0]], np.float32)
    grid = snow_grid(moment_of(x, v), 0.05, 1.0)
    weight = grid.density[..., None] * 0.05**3
    assert grid.density.sum() * 0.05**3 == pytest.approx(6.0, rel=1e-5)
    near = grid.first + 4 * 0.05 * grid.blocks
    for place, want in zip(x, v, strict=True):
        mine = np.abs(near - place).max(axis=1) < 2.0
        momentum = (weight * grid.velocity)[mine].sum(axis=(0, 1, 2, 3))
        np.testing.assert_allclose(momentum, 2.0 * want, atol=1e-5)


def test_a_box_of_cells_is_bounded():
    """However far a particle flies."""
    moment = moment_of(FAR)
    assert snow_grid(moment, fitting(moment, 0.05), 1.0).dense()[0].size <= MOST_CELLS
