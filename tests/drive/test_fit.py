"""`neve drive --fit`: snow that follows the game's law is fitted back to its numbers; a page can play it."""

import base64
import json
import zlib
from pathlib import Path

import numpy as np
import pytest

from neve.cli import main
from neve.drive import fit_runs, serve
from neve.drive.columns import columns_of, floor_of, patch_about
from neve.drive.fit import fitted
from neve.drive.law import GameSnow, bearing_depth, contact_area, wheel_sinkage
from neve.drive.recording import STEP
from neve.drive.track import Rut, Track
from neve.drive.wheel import Wheel
from neve.geometry.pose import quaternion_of
from neve.io.errors import RunError
from neve.io.frames import make_frame, write_frame
from neve.io.table import table_text
from neve.run.outputs.solids import COLUMNS
from neve.scene.reading.load import scene_from, to_toml

RADIUS, WIDTH, DX = 0.2, 0.16, 0.04
SPACING = DX / 2
LAYERS = 15
DEPTH = LAYERS * SPACING
LEFT, PRESSED = 0.8, 0.6
"""Of the mass and the depth of the snow on the floor of the rut."""
SNOW = GameSnow(strain=0.65, pressure=2.4e4, compaction=1.0 - np.log(LEFT) / np.log(PRESSED))
FRAMES = 13
TABLE = Path(__file__).parents[2] / "web/drive/tests/unit/sinkage.json"


def load_for(snow, radius, width, depth, sinkage):
    """Return the load that presses the snow by `sinkage`: the law solved for p, times the contact area."""
    ratio = (1.0 - sinkage / depth) ** -snow.compaction
    pressure = -snow.pressure * np.log1p((1.0 / ratio - 1.0) / snow.strain)
    return pressure * contact_area(radius, width, sinkage)


def test_a_wheel_sinks_until_the_snow_bears_it():
    """At that sinkage the depth after the pressure load / area is what is left below the wheel."""
    sinkage = np.linspace(0.01, 0.25, 9)
    load = load_for(SNOW, 0.3, 0.2, 0.5, sinkage)
    np.testing.assert_allclose(wheel_sinkage(0.3, 0.2, load, 0.5, SNOW), sinkage, atol=1e-9)
    left = bearing_depth(SNOW, 0.5, load / contact_area(0.3, 0.2, sinkage))
    np.testing.assert_allclose(0.5 - left, sinkage, atol=1e-9)
    assert wheel_sinkage(0.3, 0.2, 0.0, 0.5, SNOW) == 0.0


def test_the_page_has_the_same_law():
    """Numbers that web/drive tests as well, to the rounding with which they are written."""
    for row in json.loads(TABLE.read_text(encoding="utf-8")):
        snow = GameSnow(row["strain"], row["pressure"], row["compaction"])
        got = wheel_sinkage(row["radius"], row["width"], row["load"], row["depth"], snow)
        assert got == pytest.approx(row["sinkage"], abs=1e-9)


def track(snow, sinkage, depth=0.4, radius=0.35, width=0.25):
    """Return the track of a wheel in snow that follows the law."""
    wheel = Wheel("bodies.0", 0, radius, width, np.array([0.0, 1.0, 0.0]), np.zeros(3))
    ratio = 0.5
    rut = Rut(np.zeros(1), np.zeros(1), ratio, ratio ** (1.0 - snow.compaction))
    load = load_for(snow, radius, width, depth, sinkage)
    return Track(wheel, 250.0, load, sinkage, np.full(len(sinkage), depth), rut)


@pytest.mark.parametrize(
    "snow", [GameSnow(0.72, 26e3, 0.7), GameSnow(0.3, 5e3, 0.9), GameSnow(0.95, 2e5, 0.5)]
)
def test_the_law_is_fitted_back(snow):
    """Without noise the minimum is 0, and where it is, the search finds to its own tolerance."""
    fit = fitted(
        [track(snow, np.linspace(0.02, 0.12, 6)), track(snow, np.linspace(0.05, 0.15, 4), depth=0.5)]
    )
    np.testing.assert_allclose(fit.snow, snow, rtol=1e-4)
    assert fit.residual < 1e-6
    assert fit.untold == []
    assert [len(one) for one in fit.predicted] == [6, 4]


def test_loads_that_are_alike_tell_no_two_numbers():
    """One load, with the noise of a millimetre: whatever comes out, the doubt about it is told."""
    noise = 1e-3 * np.array([1.0, -1.0, 0.5, -0.5, 0.2])
    known = track(SNOW, np.full(5, 0.1))
    fit = fitted([Track(known.wheel, 250.0, known.load, known.sinkage + noise, known.depth, known.rut)])
    assert fit.untold != []
    assert fit.residual == pytest.approx(float(np.sqrt(np.mean((noise - noise.mean()) ** 2))), rel=1e-3)


def test_columns_count_what_lies_and_what_flies():
    """A column of ten with two particles above a gap: depth and mass of ten, two loose."""
    z = np.concatenate([SPACING * (np.arange(10) + 0.5), [0.5, 0.7]])
    x = np.column_stack([np.full(12, 0.01), np.full(12, 0.01), z])
    patch = patch_about(np.array([[0.0, 0.0, 0.0], [2 * SPACING, SPACING, 0.0]]), SPACING)
    floor = floor_of(x[:10], patch, SPACING)
    snow = columns_of(x, patch, floor, SPACING)
    assert snow.top[0, 0] == pytest.approx(10 * SPACING)
    assert snow.mass[0, 0] == pytest.approx(10 * SPACING)
    assert snow.loose.tolist() == [False] * 10 + [True] * 2
    assert np.isnan(snow.top[1, 0])
    assert snow.mass[1, 0] == 0.0
    # Over a cell without ground all is loose.
    assert columns_of(x + np.array([SPACING, 0.0, 0.0]), patch, floor, SPACING).loose.all()


def scene(**more):
    """Return a wheel on a slide, above a layer."""
    wheel = {
        "shape": "cylinder", "center": [0.0, 0.0, DEPTH + RADIUS], "rotation": [90.0, 0.0, 0.0],
        "radius": RADIUS, "height": WIDTH, "mass": 20.0, "joint": "hinge", "axis": [0.0, 1.0, 0.0],
    }  # fmt: skip
    return {
        "numerics": {"dx": DX}, "snow": {"rho0": 200.0}, "run": {"film": False},
        "sources": [{"shape": "layer", "size": [2.4, 0.4], "depth": DEPTH}],
        "colliders": [{"shape": "plane"}], "bodies": [wheel], **more,
    }  # fmt: skip


def write_run(folder, document=None, way=1.6, frames=FRAMES, sunk=0.1):
    """Write the run of a wheel that sinks ever deeper, as the law has it, and leaves a rut that is known.

    The sinkage of two frames is the mean of theirs, so each force is the one that belongs to that mean.
    """
    given = scene_from(document or scene())
    (folder / "frames").mkdir(parents=True)
    (folder / "scene.toml").write_text(to_toml(given), encoding="utf-8")
    (folder / "run.json").write_text("{}", encoding="utf-8")
    x, y, z = (
        SPACING * (np.arange(n) + 0.5) + first for n, first in ((120, -0.4), (20, -0.2), (LAYERS, 0.0))
    )
    fresh = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    places, depths = np.linspace(0.0, way, frames), np.linspace(0.0, sunk, frames)
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # 90 degrees about x
    rows = []
    for frame, (place, depth) in enumerate(zip(places, depths, strict=True)):
        rolled = place / RADIUS
        about = np.array(
            [[np.cos(rolled), 0, np.sin(rolled)], [0, 1, 0], [-np.sin(rolled), 0, np.cos(rolled)]]
        )
        axle = np.array([place, 0.0, DEPTH + RADIUS - depth])
        solids = [(np.zeros(3), np.eye(3)), (axle, about @ turn)]
        snow = pressed(fresh, place) if frame == frames - 1 else fresh
        content = make_frame(
            snow, np.zeros_like(snow), np.ones(len(snow)), np.arange(len(snow)),
            np.zeros(len(snow), np.int32), solids, frame / 60,
        )  # fmt: skip
        write_frame(folder / "frames", frame, content)
        force = np.nan
        if frame:
            force = load_for(SNOW, RADIUS, WIDTH, DEPTH, 0.5 * (depth + depths[frame - 1]))
        for name, (position, rotation) in zip(("colliders.0", "bodies.0"), solids, strict=True):
            numbers = [*position, *quaternion_of(rotation), *np.zeros(6), 0.0, 0.0, force, 0.0, 0.0, 0.0]
            values = ["" if np.isnan(value) else float(value) for value in numbers]
            rows.append(dict(zip(COLUMNS, [frame, frame / 60, name, *values], strict=True)))
    (folder / "solids.csv").write_text(table_text(COLUMNS, rows), encoding="utf-8")
    return folder


def pressed(fresh, place):
    """Return the snow with a rut as wide as the wheel behind it; what leaves it lies outside the patch."""
    snow = fresh.copy()
    rut = (np.abs(snow[:, 1]) < 0.5 * WIDTH) & (snow[:, 0] < place) & (snow[:, 0] > -0.2)
    gone = rut & (snow[:, 2] > LEFT * DEPTH)
    # What stays is spread over the depth of the rut, its top included.
    snow[rut, 2] = (snow[rut, 2] - 0.5 * SPACING) / (LEFT * DEPTH - SPACING) * (PRESSED * DEPTH - SPACING)
    snow[rut, 2] += 0.5 * SPACING
    snow[gone] = [0.0, 0.5, 0.01]
    return snow


def test_a_run_is_fitted_back(tmp_path):
    """Places are float32 in frames, heights are tops of whole particles: all is exact but for that."""
    told = []
    fit, file = fit_runs([str(write_run(tmp_path / "wheel"))], tell=told.append)
    np.testing.assert_allclose(fit.snow, SNOW, rtol=2e-3)
    assert fit.residual < 1e-5
    assert fit.density_ratio[0] == pytest.approx(LEFT / PRESSED, rel=1e-3)
    assert file == tmp_path / "wheel/drive.json"
    assert "12 moments" in told[2]
    assert not any("warning" in line for line in told)


def test_what_is_recorded_is_what_a_page_reads(tmp_path):
    """Depths, masses and the way of the wheel come back out of the file, to its step."""
    fit, file = fit_runs([str(write_run(tmp_path / "wheel"))], tell=lambda _: None)
    content = json.loads(file.read_text(encoding="utf-8"))

    def numbers(name):
        return np.frombuffer(zlib.decompress(base64.b64decode(content[name])), "<u2")

    patch = content["patch"]
    shape = (FRAMES, patch["nx"], patch["ny"])
    depth, mass = (
        np.cumsum(numbers(name).reshape(shape).astype(np.uint16), axis=0, dtype=np.uint16) * STEP
        for name in ("depth", "mass")
    )
    assert (content["format"], content["name"], len(content["times"])) == (1, "wheel", FRAMES)
    np.testing.assert_allclose(depth[0], DEPTH, atol=STEP)
    middle, behind = patch["ny"] // 2, int((0.5 - patch["along"]) / patch["cell"])
    np.testing.assert_allclose(depth[-1, behind, middle], PRESSED * DEPTH, atol=2 * STEP)
    np.testing.assert_allclose(mass[-1, behind, middle], LEFT * DEPTH, atol=2 * STEP)
    np.testing.assert_allclose(content["path"][-1], [1.6, 0.0, DEPTH + RADIUS - 0.1], atol=1e-5)
    np.testing.assert_allclose(content["spin"][-1] - content["spin"][0], 1.6 / RADIUS, atol=1e-4)
    assert content["snow"]["strain"] == fit.snow.strain
    assert sum(content["counts"]) == len(numbers("loose")) // 3


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda folder: folder, "holds no Neve run"),
        (lambda folder: write_run(folder, frames=4), "holds 4 frames, and a fit needs at least 5"),
        (lambda folder: write_run(folder, way=0.3), r"rolls 0.30 m, and a rut .* 0.60 m"),
        (lambda folder: write_run(folder, sunk=-0.1), "presses fresh snow in 0 frames"),
        (lambda folder: write_run(folder, scene(bodies=[])), "has none"),
        (lambda folder: write_run(folder, scene(bodies=2 * scene()["bodies"])), r"several \(bodies.0, bod"),
    ],
    ids=["no run", "few frames", "not rolled", "not sunk", "no wheel", "two wheels"],
)  # fmt: skip
def test_what_cannot_be_fitted_is_one_sentence(tmp_path, make, told):
    """Nothing is written."""
    folder = make(tmp_path / "wheel")
    with pytest.raises(RunError, match=told):
        fit_runs([str(folder)])
    assert not (folder / "drive.json").exists()


def test_another_body_is_no_wheel(tmp_path):
    """The bodies that are wheels are named."""
    folder = str(write_run(tmp_path / "wheel"))
    with pytest.raises(RunError, match=r"--wheel bodies.3 is no wheel .* it has bodies.0"):
        fit_runs([folder], "bodies.3")


def test_the_command_fits_and_ends(tmp_path, capsys):
    """With --no-page nothing is served; --wheel without a run is refused with exit code 2."""
    folder = write_run(tmp_path / "wheel")
    with pytest.raises(SystemExit) as end:
        main(["drive", "--fit", str(folder), "--wheel", "bodies.0", "--no-page"])
    assert end.value.code == 0
    assert capsys.readouterr().out.startswith("strain 0.6")
    with pytest.raises(SystemExit) as end:
        main(["drive", "--wheel", "bodies.0"])
    assert end.value.code == 2
    assert "--wheel needs --fit RUN" in capsys.readouterr().err


def test_the_address_names_the_recording(tmp_path, monkeypatch):
    """The page is told which recording to play."""
    page = tmp_path / "page"
    page.mkdir()
    (page / "index.html").write_text("", encoding="utf-8")
    monkeypatch.setattr(serve, "PAGE", page)
    monkeypatch.setattr(serve._Server, "serve_forever", lambda server: None)
    told = []
    serve.drive(tell=told.append, recordings=[tmp_path / "a wheel/drive.json"])
    assert "/#recording=a%20wheel is the car" in told[0]
