"""Runs with heat, by each method that knows it: log, frames, film, resume and export."""

import subprocess

import imageio_ffmpeg
import numpy as np
import pytest

from neve.build import solids
from neve.export.run import Choices, export_run
from neve.io.frames import frame_numbers, read_frame
from neve.io.log import HEAT, read_log
from neve.registry import METHODS
from neve.run import painter, run_scene
from neve.run.painter import Painter
from neve.scene.reading.load import scene_from

SIZE = (320, 180)
LAST = 4
METHODS_WITH_HEAT = [name for name in METHODS.names() if METHODS.get(name).has_heat]


def scene(method):
    """A block of snow in the sun, of which more than half melts in a third of a second of motion."""
    return scene_from(
        {
            "numerics": {"method": method, "dx": 0.1},
            "heat": {"air_temperature": 30.0, "sun": 800.0, "heat_speed": 40000.0, "snow_temperature": -1.0},
            "sources": [{"shape": "box", "size": [0.3, 0.3, 0.3], "center": [0, 0, 0.15]}],
            "colliders": [{"shape": "plane"}],
            "camera": {"position": [1.0, -1.6, 0.8], "target": [0.0, 0.0, 0.1]},
            "run": {"duration": LAST / 12, "fps": 12},
            "outputs": [{"kind": "checkpoint", "every_frames": 1}, {"kind": "film"}],
        }
    )


@pytest.fixture(scope="module", params=METHODS_WITH_HEAT)
def method(request):
    return request.param


@pytest.fixture(scope="module")
def whole(method, tmp_path_factory):
    """A run in one go, with small pictures."""
    before, painter.SIZE = painter.SIZE, SIZE
    out = tmp_path_factory.mktemp("heated") / "run"
    run_scene(scene(method), out, quiet=True, threads=1)
    yield out
    painter.SIZE = before


def rows(out, method):
    """The rows of the log as numbers, without those of the clock on the wall."""
    return [
        {
            name: float(value)
            for name, value in row.items()
            if value and name != "bound" and not name.startswith("seconds")
        }
        for row in read_log(out / "log.csv", method, has_heat=True)
    ]


def test_log_tells_of_heat(whole, method):
    """What the snow has gained is what air and sun gave; its water grows; the speed of heat is said."""
    table = rows(whole, method)
    assert len(table) == LAST + 1
    assert all(set(HEAT) <= row.keys() for row in table)
    assert {row["heat_speed"] for row in table} == {40000.0}
    for name in ("heat_taken", "water"):
        assert np.all(np.diff([row[name] for row in table]) > 0)
    first, last = table[0], table[-1]
    assert last["heat"] - first["heat"] == pytest.approx(last["heat_taken"], rel=1e-9)
    assert last["water"] > 0.5 * last["mass"]


def test_frames_hold_temperature_and_phase(whole, method):
    """At first all is solid at -1 deg C; at the end the liquid share of the mass is what the log says."""
    first, last = (read_frame(whole / "frames", number) for number in (0, LAST))
    np.testing.assert_allclose(first.more["temperature"], -1.0, rtol=1e-5)
    assert not first.more["phase"].any()
    share = rows(whole, method)[-1]
    assert last.more["phase"].mean() == pytest.approx(share["water"] / share["mass"], rel=1e-3)
    assert last.more["temperature"][last.more["phase"] > 0].min() >= 0.0


def test_film_says_how_fast_heat_is(whole, method):
    """In the film's last picture, letters stand in the lower left corner, and nothing else is different."""
    told = scene(method)
    plain = Painter(told.model_copy(update={"heat": None}), solids(told), 1, SIZE)
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-i", str(whole / "preview.mp4")]
    command += ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(command, capture_output=True, check=True).stdout
    shown = np.frombuffer(raw, np.uint8).reshape(-1, *SIZE[::-1], 3)[-1].astype(int)
    away = np.abs(shown - plain.draw(read_frame(whole / "frames", LAST))).mean(axis=2)
    corner = np.zeros(away.shape, bool)
    corner[int(0.9 * SIZE[1]) :, : int(0.6 * SIZE[0])] = True
    assert np.count_nonzero(away[corner] > 60) > 100
    assert away[~corner].mean() < 8


def test_resume_has_the_same_bits(whole, method, tmp_path):
    """A run that stopped after two frames goes on with the same frames, checkpoint and log."""
    run_scene(scene(method), tmp_path, frames=2, quiet=True, threads=1)
    run_scene(scene(method), tmp_path, resume=True, quiet=True, threads=2)
    assert frame_numbers(tmp_path / "frames") == [*range(LAST + 1)]
    for number in range(LAST + 1):
        one, other = (read_frame(folder / "frames", number) for folder in (whole, tmp_path))
        for name in ("x", "v", "id"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        for name in ("temperature", "phase"):
            np.testing.assert_array_equal(one.more[name], other.more[name])
    assert rows(whole, method) == rows(tmp_path, method)


def test_export_has_temperature_and_phase(whole):
    """A PLY of the last frame has both as properties of its points."""
    meshio = pytest.importorskip("meshio")
    folder, _ = export_run(whole, Choices("ply"), frames=slice(LAST, LAST + 1))
    content = read_frame(whole / "frames", LAST)
    [path] = folder.glob("*.ply")
    data = meshio.read(path).point_data
    for name in ("temperature", "phase"):
        np.testing.assert_allclose(data[name], content.more[name], rtol=1e-6)
