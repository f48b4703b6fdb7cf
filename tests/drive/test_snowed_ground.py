"""`neve drive --snow`: ground and snow of a fall as the page reads them."""

import base64
import json
import zlib

import numpy as np
import pytest
from verification.snowfall.surfaces import box, ground

from neve.cli import main
from neve.drive import serve, write_ground
from neve.drive.ground import ground_of
from neve.run.snowfall import write_cover
from neve.scene.errors import SceneError
from neve.scene.schema.snowfall import Snowfall
from neve.snowfall.cover import Raster, let_fall
from neve.snowfall.surroundings import joined

SLOPE = (0.1, -0.05)
ROOF = box((0.0, -2.0, 3.0), (2.0, 2.0, 3.1), "roof")


def fallen(pieces, cell=0.25, **keys):
    """Snow on 8 m x 4 m; flakes fall straight."""
    fall = Snowfall(**{"depth": 0.3, "flutter": 0.0, "steps": 1, "stability": "none", **keys})
    return let_fall(fall, joined(pieces), Raster.over((0.0, 0.0), (8.0, 4.0), cell))


def unpacked(content, name, step):
    """Lengths of the cells [m], as the page unpacks them."""
    numbers = np.frombuffer(zlib.decompress(base64.b64decode(content[name])), "<u2")
    return numbers.reshape(content["nx"], content["ny"]) * content[step]


@pytest.mark.parametrize(("cell", "many"), [(0.25, 2), (0.5, 1), (1.0, 1)])
def test_ground_and_depth_are_those_of_the_fall(cell, many):
    """A slope is a plane to half a step, from its least cell; 30 cm lie on it but below the roof, x > 0."""
    content = ground_of(fallen([ground(0.0, SLOPE), ROOF], cell), "slope")
    assert content["cell"] == many * cell
    assert (content["nx"], content["ny"]) == (round(8.0 / content["cell"]), round(4.0 / content["cell"]))
    x = (np.arange(content["nx"]) + 0.5) * content["cell"] - 4.0
    y = (np.arange(content["ny"]) + 0.5) * content["cell"] - 2.0
    plane = SLOPE[0] * x[:, None] + SLOPE[1] * y
    found = unpacked(content, "ground", "step")
    assert np.abs(found - (plane - plane.min())).max() < 0.5 * content["step"] + 1e-9
    depth = unpacked(content, "depth", "depth_step")
    under = (x > 0.0) & (x < 2.0)
    assert not depth[under].any()
    assert np.abs(depth[~under] - 0.3).max() < 0.5 * content["depth_step"] + 1e-9


def test_high_ground_keeps_its_height():
    """200 m of relief fit into 16 bits: steps of 3 mm."""
    content = ground_of(fallen([ground(0.0, (26.0, 0.0))], stability="none"), "cliff")
    found = unpacked(content, "ground", "step")
    assert found.max() == pytest.approx(26.0 * 7.5)
    assert content["step"] == pytest.approx(26.0 * 7.5 / 65535)


def test_a_hole_is_refused(tmp_path):
    """A car needs ground everywhere; nothing is written."""
    write_cover(fallen([box((-2.0, -2.0, 0.0), (2.0, 2.0, 1.0))]), tmp_path)
    with pytest.raises(SceneError, match=r"nothing lies below 50 % of its rectangle"):
        write_ground(str(tmp_path))
    assert not (tmp_path / "ground.json").exists()


def test_a_folder_without_a_cover_is_refused(tmp_path):
    """One sentence, and exit code 2."""
    with pytest.raises(SceneError, match=r"--snow = .* cannot be read"):
        write_ground(str(tmp_path))


def test_the_command_writes_and_the_server_has_it(tmp_path, capsys, monkeypatch):
    """With --no-page nothing is served; without, the address names the ground, and the server sends it."""
    folder = tmp_path / "a slope"
    write_cover(fallen([ground()]), folder)
    with pytest.raises(SystemExit) as end:
        main(["drive", "--snow", str(folder), "--no-page"])
    assert end.value.code == 0
    content = json.loads((folder / "ground.json").read_text(encoding="utf-8"))
    assert content["name"] == "a slope"
    page = tmp_path / "page"
    page.mkdir()
    (page / "index.html").write_text("", encoding="utf-8")
    with serve.listening("127.0.0.1", 0, page, grounds=[folder / "ground.json"]) as server:
        assert server.RequestHandlerClass.args[0]["/grounds/a slope.json"] == folder / "ground.json"
    with pytest.raises(SystemExit) as end:
        main(["drive", "--no-page"])
    assert end.value.code == 2
    assert "--no-page needs --fit RUN or --snow FOLDER" in capsys.readouterr().err
    monkeypatch.setattr(serve, "PAGE", page)
    monkeypatch.setattr(serve._Server, "serve_forever", lambda server: None)
    told = []
    serve.drive(tell=told.append, ground=folder / "ground.json")
    assert "/#ground=a%20slope is" in told[0]
