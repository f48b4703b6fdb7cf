"""What a page has changed is taken back and done again; the end of the scene is told."""

import pytest
from viewer.conftest import converse

from neve.viewer.show import prepare


@pytest.fixture
def server(small, tmp_path):
    return prepare(str(small), out=str(tmp_path / "out"), threads=1)


def told(page, path):
    """The value at `path` in the panel that the page was told last."""
    fields = {f["path"]: f for s in page.message("scene")["panel"] for f in s["fields"]}
    return fields[path]["value"]


def undo_of(page):
    """What the page was told last that it can take back; None before it was told anything."""
    return (page.message("player") or {}).get("undo")


def test_changes_are_taken_back_and_done_again(server):
    """Undo brings back value, place and snow; changes of one value that follow each other are one step."""

    async def talk(page, port):
        began = server.player.scene
        for E0 in (2e5, 3e5):
            await page.send(do="set", path="snow.E0", value=E0)
        await page.until(lambda p: told(p, "snow.E0") == 3e5)
        await page.send(do="add", kind="sources", shape="box", at=[3, 0, 0])
        await page.until(lambda p: len(server.player.scene.sources) == 2)
        await page.until(lambda p: p.message("player")["undo"] == "new box in sources")
        await page.send(do="undo")
        await page.until(lambda p: p.message("player")["undo"] == "change of snow.E0")
        assert len(server.player.running().sources) == 1  # its snow is gone as well
        await page.send(do="undo")
        await page.until(lambda p: p.message("player")["undo"] == "")
        assert server.player.scene == began
        assert server.player._sim.solver.model.snows[0].E0 == began.snow.E0
        await page.send(do="redo")
        await page.until(lambda p: told(p, "snow.E0") == 3e5)
        await page.send(do="redo")
        await page.until(lambda p: p.message("player")["redo"] == "")
        assert len(server.player.running().sources) == 2
        await page.send(do="redo")
        await page.until(lambda p: p.message("refused"))

    converse(server, talk)


def test_the_end_of_the_scene_is_told_and_passed(server):
    """At run.duration, 0.2 s and so the sixth frame, the page hears of it once; time goes on."""

    async def talk(page, port):
        await page.send(do="speed", factor=100.0)
        await page.send(do="play")
        await page.until(lambda p: p.head["frame"] >= 8)
        await page.send(do="pause")
        notes = [m["sentence"] for m in page.messages if m["kind"] == "note"]
        assert len(notes) == 1
        assert "run.duration = 0.2 s is over" in notes[0]

    converse(server, talk)


def test_a_scene_that_cannot_begin_leaves_all_as_it_was(server):
    """Deleting a source begins the scene: refused while a dx that is far too small waits, done without it."""

    async def talk(page, port):
        await page.send(do="add", kind="sources", shape="box", at=[3, 0, 0])
        await page.until(lambda p: len(server.player.scene.sources) == 2)
        await page.send(do="set", path="numerics.dx", value=1e-4)
        await page.until(lambda p: undo_of(p) == "change of numerics.dx")
        await page.send(do="delete", name="sources.0")
        await page.until(lambda p: p.message("refused"))
        assert len(server.player.scene.sources) == len(server.player.running().sources) == 2
        assert server.player.state()["undo"] == "change of numerics.dx"
        await page.send(do="undo")
        await page.until(lambda p: undo_of(p) == "new box in sources")
        await page.send(do="delete", name="sources.0")
        await page.until(lambda p: undo_of(p) == "deletion of sources.0")
        assert len(server.player.scene.sources) == len(server.player.running().sources) == 1

    converse(server, talk)
