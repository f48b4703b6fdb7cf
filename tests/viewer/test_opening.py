"""Open another scene or run, and drop files: names of a list alone, nothing from outside, clear sentences."""

import base64
import io
import shutil

import numpy as np
import pytest
from viewer.conftest import SMALL, converse

from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from, to_toml
from neve.viewer.show import ViewError, prepare
from neve.viewer.tools.placing import keys_of

TETRAHEDRON = b"v 0 0 0\nv 0.2 0 0\nv 0 0.4 0\nv 0 0 0.6\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
PIECE = 11_250


@pytest.fixture
def served(tmp_path, finished):
    """A folder with a scene, two runs, one of them further down, and what must not be seen from it."""
    root, outside = tmp_path / "served", tmp_path / "outside"
    root.mkdir()
    outside.mkdir()
    text = to_toml(scene_from(SMALL))
    (root / "small.toml").write_text(text)
    (outside / "secret.toml").write_text(text)
    shutil.copytree(finished, root / "first")
    shutil.copytree(finished, root / "session" / "second")
    shutil.copytree(finished, outside / "secret_run")
    (root / "link_run").symlink_to(outside / "secret_run")
    (root / "link.toml").symlink_to(outside / "secret.toml")
    (root / "notes.txt").write_text("no scene")
    return root


async def refused(page):
    """The next refusal's sentence; messages before it are forgotten."""
    sentence = (await page.until(lambda p: p.message("refused")))["sentence"]
    page.messages = [message for message in page.messages if message["kind"] != "refused"]
    return sentence


async def drop(page, name, content):
    """Send a file as the page does."""
    for at in range(0, len(content), PIECE):
        data = base64.b64encode(content[at : at + PIECE]).decode()
        await page.send(do="piece", name=name, at=at, of=len(content), data=data)


def scene_named(name):
    return lambda p: p.message("scene")["name"] == name


def test_runs_and_scenes_of_the_folder_are_opened_and_no_others(served):
    """From a run to another, to a scene and back; paths and links that lead out are refused."""

    async def talk(page, port):
        await page.send(do="library")
        entries = (await page.until(lambda p: p.message("library")))["entries"]
        assert {(entry["name"], entry["kind"]) for entry in entries} == {
            ("first", "run"), ("session/second", "run"), ("small.toml", "scene"),
        }  # fmt: skip
        for name in (
            "../outside/secret_run",
            "link_run",
            "link.toml",
            "/etc",
            "",
            "notes.txt",
            str(served / "first"),
        ):
            await page.send(do="open", scene=name or ".")
            assert "is no scene that comes with Neve, nor in the served folder" in await refused(page), name
        assert page.message("scene")["name"] == "first"
        await page.send(do="open", scene="session/second")
        await page.until(scene_named("session/second"))
        assert not page.message("scene")["live"]
        seen = len(page.states)
        await page.send(do="seek", frame=3)
        await page.until(lambda p: len(p.states) > seen and p.head["frame"] == 3)
        await page.send(do="open", scene="small.toml")
        await page.until(scene_named("small.toml"))
        assert page.message("scene")["live"]
        await page.send(do="frame")
        await page.until(lambda p: p.head["facts"].get("steps", 0) > 0)
        await page.send(do="open", scene="first")
        await page.until(scene_named("first"))
        await page.until(lambda p: "steps" not in p.head["facts"])

    converse(prepare(str(served / "first")), talk)


def test_what_cannot_be_opened_changes_nothing(served):
    """A damaged run, a wrong scene and one that cannot begin are refused; what is shown goes on."""
    for frame in (served / "session" / "second" / "frames").iterdir():
        if frame.is_file():
            frame.write_bytes(b"damaged")
    (served / "wrong.toml").write_text("[snow]\nnu = 0.9\n")
    (served / "huge.toml").write_text(to_toml(scene_from(SMALL)).replace("dx = 0.1", "dx = 0.0001"))

    async def talk(page, port):
        for name, word in (
            ("session/second", "damaged"),
            ("wrong.toml", "snow.nu"),
            ("huge.toml", "particles"),
        ):
            await page.send(do="open", scene=name)
            sentence = await refused(page)
            assert word in sentence or "frames" in sentence, (name, sentence)
        assert page.message("scene")["name"] == "small"
        await page.send(do="frame")
        await page.until(lambda p: p.head["frame"] == 1)

    converse(prepare(str(served / "small.toml"), out=str(served / "out"), threads=1), talk)


def test_a_scene_and_a_mesh_are_dropped(served, tmp_path):
    """A mesh arrives in pieces, is offered and set down; a scene may name it, and no other file."""
    table = (
        '[[colliders]]\nshape = "mesh"\nfile = "FILE"\n[[sources]]\nshape = "box"\ncenter = [0.0, 0.0, 2.0]\n'
    )
    mesh = TETRAHEDRON + b"# " + b"x" * PIECE  # two pieces

    async def talk(page, port):
        server = talk.server
        await drop(page, "../../a tetra.obj", mesh)
        what = (await page.until(lambda p: p.message("dropped")))["what"]
        assert what["shape"] == "mesh:a_tetra.obj"
        assert what["half"] == pytest.approx([0.1, 0.2, 0.3])
        await page.send(do="add", kind="colliders", shape=what["shape"], at=[0, 2, 0])
        await page.until(lambda p: len(p.message("scene")["solids"]) == 3)
        assert server.player.scene.colliders[2].file == str(served / "out" / "dropped" / "a_tetra.obj")
        await drop(page, "mine.toml", table.replace("FILE", str(served / "first" / "run.json")).encode())
        assert "does not have" in await refused(page)
        await drop(page, "mine.toml", table.replace("FILE", "a_tetra.obj").encode())
        await page.until(lambda p: p.message("scene")["name"].startswith("mine"))
        assert len(page.message("scene")["solids"]) == 1
        for name, content, word in (
            ("a.exe", b"MZ", "drop a scene"),
            ("b.toml", b"snow = [", "not valid TOML"),
            ("c.obj", b"nothing", "c.obj"),
        ):
            await drop(page, name, content)
            assert word in await refused(page), name
        await page.send(do="piece", name="d.obj", at=8, of=16, data="AAAAAAAA")
        assert "did not arrive whole" in await refused(page)
        assert sorted(path.name for path in (tmp_path / "served" / "out").iterdir()) == ["dropped"]

    talk.server = prepare(str(served / "small.toml"), out=str(served / "out"), threads=1)
    converse(talk.server, talk)


def height_map(heights):
    """The file of an array of heights."""
    out = io.BytesIO()
    np.save(out, heights)
    return out.getvalue()


def test_a_damaged_file_is_refused_by_its_name_and_not_kept(served):
    """The sentence has the name that was dropped and no folder, and nothing is left in that folder."""

    async def talk(page, port):
        for name, content, told in (
            ("m.obj", b"rubbish", "holds no triangles"),
            ("m.glb", b"glTF", "cannot be read"),
            ("h.png", b"rubbish", "cannot be read"),
            ("h.asc", b"ncols x", "no Esri ASCII grid"),
            ("s.toml", b"[[[", "not valid TOML"),
            ("t.toml", b"\xff", "not UTF-8"),
            ("t.toml", b"x = 1", "x is not a known key"),
            ("picture.gif", b"GIF89a", "drop a scene"),
        ):
            await drop(page, name, content)
            sentence = await refused(page)
            assert sentence.startswith(name), sentence
            assert told in sentence
            assert str(served) not in sentence
        assert list((served / "out" / "dropped").iterdir()) == []

    converse(prepare(str(served / "small.toml"), out=str(served / "out"), threads=1), talk)


def test_a_height_map_is_dropped(served):
    """It is offered with a size that fits the scene, stands as ground, and is refused where it has gaps."""
    hill = np.add.outer(np.linspace(0.0, 0.5, 9), np.zeros(5)).astype(np.float32)
    gaps = hill.copy()
    gaps[3, 2] = np.nan

    async def talk(page, port):
        server = talk.server
        await drop(page, "gaps.npy", height_map(gaps))
        assert "has gaps" in await refused(page)
        await drop(page, "my hill.npy", height_map(hill))
        what = (await page.until(lambda p: p.message("dropped")))["what"]
        assert what["shape"] == "terrain:my_hill.npy"
        # 160 cells along the longer side, the other by the shape; real numbers are metres.
        longer = 160 * server.player.scene.numerics.dx
        assert what["half"] == pytest.approx([0.5 * longer, 0.5 * longer * 5 / 9, 0.25])
        await page.send(do="add", kind="colliders", shape=what["shape"], at=[1, 2, -4])
        await page.until(lambda p: len(p.message("scene")["solids"]) == 3)
        ground = server.player.scene.colliders[-1]
        assert (ground.shape, ground.center, ground.height) == ("terrain", (1.0, 2.0, -4.0), 1.0)
        assert ground.file == str(served / "out" / "dropped" / "my_hill.npy")
        await page.send(do="add", kind="sources", shape=what["shape"], at=[0, 0, 0])
        assert "terrain" in await refused(page)

    talk.server = prepare(str(served / "small.toml"), out=str(served / "out"), threads=1)
    converse(talk.server, talk)


def test_a_map_of_whole_numbers_gets_a_height(tmp_path):
    """A picture's grey has no unit: its full range becomes 0.15 of the longer side."""
    file = tmp_path / "grey.npy"
    file.write_bytes(height_map(np.arange(12, dtype=np.uint8).reshape(4, 3)))
    keys = keys_of("terrain:grey.npy", (0.0, 0.0, 0.0), 0.1, {"grey.npy": file})
    assert keys["size"] == pytest.approx([16.0, 12.0])
    assert keys["height"] == pytest.approx(0.15 * 16.0)


def test_a_link_opens_what_it_names(served, monkeypatch):
    """A preset, or a scene or run of the folder by its name; no path, and no link without a name."""
    monkeypatch.chdir(served)
    for link, name in (
        ("http://127.0.0.1:8420/#scene=throw_ball", "throw_ball"),
        ("http://127.0.0.1:8420/#resolution=0.5&scene=small.toml", "small"),
        ("#scene=session/second", "second"),
    ):
        server = prepare(link, out=str(served / "out"), threads=1)
        assert server.player.name == name
    for link, told in (
        ("http://127.0.0.1:8420/", "names no scene"),
        ("http://127.0.0.1:8420/#scene=a&scene=b", "names no scene"),
    ):
        with pytest.raises(ViewError, match=told):
            prepare(link)
    for name in ("../outside/secret.toml", "link.toml", "/etc/passwd", "notes.txt"):
        with pytest.raises(SceneError, match="nor in the served folder"):
            prepare(f"https://example.org/#scene={name}")
