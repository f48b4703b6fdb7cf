"""Live: a page plays, changes the snow, throws, moves solids, records; over the real socket, no browser."""

import tomllib
from time import monotonic

import numpy as np
import pytest
from viewer.conftest import SMALL, apart, converse

from neve.io.frames import frame_numbers, read_frame
from neve.io.run_folder import RunFolder
from neve.scene.reading.load import load, scene_from, to_toml
from neve.simulation import Simulation
from neve.viewer.protocol import commands
from neve.viewer.show import prepare

EYE = {"position": [1.5, -2.5, 1.0], "target": [0.2, 0.0, 0.35], "width": 160, "height": 90}


@pytest.fixture
def server(small, tmp_path):
    return prepare(str(small), out=str(tmp_path / "out"), threads=1)


def places(page):
    """Positions [m] in the last state, (n, 3)."""
    head, body = page.states[-1]
    q = np.frombuffer(body, "<u2").reshape(-1, 4)
    return np.array(head["low"]) + np.array(head["step"]) * q[:, :3]


def told(page, path):
    """The value at `path` in the panel that the page was told last."""
    fields = {f["path"]: f for s in page.message("scene")["panel"] for f in s["fields"]}
    return fields[path]["value"]


def test_play_moves_the_snow_and_pause_stops_it(server):
    """Before `play` nothing moves; then time runs and the ball falls as g t^2 / 2; `pause` holds.

    The ball falls freely for its first 0.2 s, so its mean height is 0.5 - g t^2 / 2; positions are off by at
    most half a step of 16 bit, and the symplectic step by g t dt / 2 < 1 cm.
    """

    async def talk(page, port):
        assert page.head["time"] == 0.0
        await page.send(do="speed", factor=100.0)
        await page.send(do="play")
        await page.until(lambda p: p.head["time"] > 0.05)
        await page.send(do="pause")
        await page.until(lambda p: p.message("player") and not p.message("player")["playing"])
        await page.send(do="color_mode", mode="speed")
        await page.send(do="frame")
        await page.until(lambda p: p.head["mode"] == "speed")
        t = page.head["time"]
        assert places(page)[:, 2].mean() == pytest.approx(0.5 - 0.5 * 9.81 * t * t, abs=0.01)
        assert page.head["limits"][1] >= 9.81 * t * 0.9
        assert page.head["facts"]["steps"] > 0
        assert sum(page.head["facts"]["stages"].values()) <= 1.0

    converse(server, talk)


def test_one_frame_ends_at_the_frame(server):
    """`frame` simulates to the next multiple of 1 / fps exactly, and pauses."""

    async def talk(page, port):
        await page.send(do="frame")
        await page.until(lambda p: p.head["frame"] == 1)
        assert page.head["time"] == pytest.approx(1 / 30, rel=1e-9)
        await page.until(lambda p: p.message("player") and not p.message("player")["playing"])

    converse(server, talk)


def test_a_value_changes_the_simulation_and_a_wrong_one_does_not(server):
    """Gravity upward makes the ball rise; a wrong value comes back as a sentence with its key."""

    async def talk(page, port):
        await page.send(do="set", path="world.gravity", value=[0, 0, 20.0])
        await page.until(lambda p: told(p, "world.gravity") == [0.0, 0.0, 20.0])
        await page.send(do="set", path="snow.nu", value=0.7)
        await page.until(lambda p: p.message("refused"))
        assert page.message("refused")["path"] == "snow.nu"
        assert "less than 0.5" in page.message("refused")["sentence"]
        await page.send(do="frame")
        await page.until(lambda p: p.head["frame"] == 1)
        assert places(page)[:, 2].mean() > 0.505

    converse(server, talk)
    assert server.player.scene.snow.nu == 0.2


def test_a_thrown_ball_arrives(server):
    """More particles, with the thrower's speed; the saved scene does not know of it; restart forgets it."""

    async def talk(page, port):
        before = page.head["n"]
        await page.send(do="throw", origin=[0, 0, 2], direction=[0, 0, -2], speed=10.0, radius=0.2)
        await page.until(lambda p: p.head["n"] > before)
        ball = places(page)[before:]
        np.testing.assert_allclose(ball.mean(axis=0), [0, 0, 1.6], atol=0.03)
        await page.send(do="frame")
        await page.until(lambda p: p.head["frame"] == 1)
        assert places(page)[before:, 2].mean() == pytest.approx(1.6 - 10 / 30, abs=0.03)
        await page.send(do="restart")
        await page.until(lambda p: p.head["n"] == before and p.head["time"] == 0.0)

    converse(server, talk)
    assert len(server.player.scene.sources) == 1


def test_grabbed_snow_follows(server):
    """Snow that is grabbed goes with the pointer."""

    async def talk(page, port):
        await page.send(do="set", path="world.gravity", value=[0, 0, 0])
        await page.send(do="play")
        for _ in range(400):
            await page.send(do="touch", tool="grab", point=[0, 0, 0.5], velocity=[2.0, 0, 0], radius=0.5)
            count = len(page.states)
            await page.until(lambda p, count=count: len(p.states) > count)
            if places(page)[:, 0].mean() > 0.02:
                return
        raise AssertionError("the snow did not follow the pointer")

    converse(server, talk)


def test_solids_move_and_come_and_go(server):
    """A dragged box goes to its place, at rest or while the snow moves; a sphere is added and deleted."""

    async def talk(page, port):
        await page.send(
            do="move", name="colliders.1", position=[1.0, 0.2, 0.4], rotation=[0, 0, 90], done=True
        )
        await page.until(lambda p: p.head["poses"][1][:3] == [1.0, 0.2, 0.4])
        np.testing.assert_allclose(
            np.array(page.head["poses"][1][3:]).reshape(3, 3)[0], [0, -1, 0], atol=1e-12
        )
        await page.send(do="play")
        await page.send(do="speed", factor=100.0)
        await page.send(do="move", name="colliders.1", position=[1.1, 0.2, 0.4], done=True)
        await page.until(lambda p: abs(p.head["poses"][1][0] - 1.1) < 1e-3)
        await page.send(do="pause")
        await page.send(do="add", kind="colliders", shape="sphere", at=[2, 0, 0])
        await page.until(lambda p: len(p.head["poses"]) == 3)
        await page.send(do="delete", name="colliders.2")
        await page.until(lambda p: len(p.head["poses"]) == 2)
        await page.send(do="delete", name="sources.0")
        await page.until(lambda p: p.message("refused"))
        assert "sources" in page.message("refused")["sentence"]

    converse(server, talk)
    assert server.player.scene.colliders[1].center == (1.1, 0.2, 0.4)
    assert server.player.scene.colliders[1].velocity == (0.0, 0.0, 0.0)


def test_record_film_picture_scene(server, tmp_path):
    """A recording is a run that can be read; film, picture and scene lie in the session's folder only."""

    async def talk(page, port):
        await page.send(do="film", camera=EYE)
        await page.until(lambda p: p.message("refused"))
        assert "record" in page.message("refused")["sentence"]
        await page.send(do="record", on=True)
        for frame in (1, 2):
            await page.send(do="frame")
            await page.until(lambda p, frame=frame: p.head["frame"] == frame)
        await page.send(do="record", on=False)
        for kind in ("picture", "film", "save"):
            await page.send(do=kind, camera=EYE)
        await page.until(lambda p: sum(m["kind"] == "file" for m in p.messages) == 3)
        return [m["name"] for m in page.messages if m["kind"] == "file"]

    assert converse(server, talk) == ["picture-1.png", "film-1.mp4", "scene-1.toml"]
    out = tmp_path / "out"
    assert {p.name for p in out.iterdir()} == {"recording-1", "picture-1.png", "film-1.mp4", "scene-1.toml"}
    run = RunFolder(out / "recording-1")
    assert frame_numbers(run.frames) == [0, 1, 2]
    assert read_frame(run.frames, 2).time == pytest.approx(2 / 30)
    assert load(run.path) == server.player.scene
    saved = load(out / "scene-1.toml")
    assert saved.camera.position == (1.5, -2.5, 1.0)
    text = (out / "scene-1.toml").read_text()
    assert tomllib.loads(text)["sources"][0]["radius"] == 0.3
    assert len(text.splitlines()) < 40  # what differs from the defaults
    assert (out / "picture-1.png").read_bytes()[:4] == b"\x89PNG"


def test_another_scene_is_opened_by_name_only(server):
    """A scene that comes with Neve begins; a path is refused."""

    async def talk(page, port):
        await page.send(do="open", scene="../../etc/passwd")
        await page.until(lambda p: p.message("refused"))
        assert (
            "no scene that comes with Neve, nor in the served folder" in page.message("refused")["sentence"]
        )
        await page.send(do="open", scene="throw_ball")
        await page.until(lambda p: p.message("scene")["name"] == "throw_ball", 120)
        assert page.message("scene")["camera"]["fov"] == 36.0

    converse(server, talk)


async def drained(line):
    """Read until the line is closed."""
    while True:
        await line.recv()


def test_rubbish_and_silence_change_nothing(server):
    """A page that sends rubbish or vanishes, and one that never reads, disturb nobody."""

    async def talk(page, port):
        from websockets.asyncio.client import connect
        from websockets.exceptions import ConnectionClosed

        url = f"ws://127.0.0.1:{port}/socket"
        async with connect(url, max_size=None) as other:
            await other.send("{'do': ")
            await other.send(b"\x00\xff" * 100)
            await other.send('{"do": "set", "path": "snow.E0", "value": null, "why": 1}')
        async with connect(url, max_size=None) as other:
            await other.send("x" * 100_000)
            with pytest.raises(ConnectionClosed):
                await drained(other)
        lazy = await connect(url, max_size=None)
        lost = await connect(url, max_size=None)
        lost.transport.abort()
        await page.send(do="play")
        await page.until(lambda p: p.head["frame"] >= 2)
        await page.send(do="pause")
        sent = next(g for g in server._clients if g.drawn == 0 and g.sent)
        assert sent.sent <= 3  # the window: no more is sent to a page that does not draw
        await lazy.close()

    converse(server, talk)


def test_what_fails_is_told_and_changes_nothing(server):
    """A ball of millions of particles, a file, a name without sense: the player goes on."""

    async def talk(page, port):
        for command, told in [
            ({"do": "throw", "origin": [0, 0, 1], "direction": [0, 0, 1], "radius": 9.0}, "smaller"),
            ({"do": "throw", "origin": [0, 0, -3], "direction": [0, 0, -1]}, "wholly inside"),
            ({"do": "add", "kind": "colliders", "shape": "mesh:../rock", "at": [0, 0, 0]}, "no mesh"),
            ({"do": "add", "kind": "camera", "shape": "box", "at": [0, 0, 0]}, "no list"),
            ({"do": "set", "path": "colliders.0.file", "value": "/etc/passwd"}, "come with Neve"),
            ({"do": "set", "path": "sources.0.font", "value": "font.ttf"}, "come with Neve"),
            ({"do": "move", "name": "sources.0", "position": [0, 0, 0]}, "grab"),
            ({"do": "seek", "frame": 1}, ""),
        ]:
            page.messages.clear()
            await page.send(**command)
            if told:
                await page.until(lambda p: p.message("refused"))
                assert told in page.message("refused")["sentence"]
        await page.send(do="frame")
        await page.until(lambda p: p.head["frame"] == 1)

    converse(server, talk)


def test_fragments_are_not_looked_for_all_the_time(server):
    """The first moment finds the fragments; those that follow within a second show the same ones."""

    async def talk(page, port):
        await page.send(do="color_mode", mode="fragment")
        await page.until(lambda p: p.head["mode"] == "fragment")
        fragments = server.player._slow["fragment"].values
        assert len(set(fragments)) == 1
        await page.send(do="frame")
        await page.until(lambda p: p.head["frame"] == 1)
        assert page.head["mode"] == "fragment"

    converse(server, talk)


def test_a_scene_that_cannot_begin_ends_the_server(small):
    """What the scene lacks is told by `neve view`, in one sentence."""
    from neve.cli import main

    with pytest.raises(SystemExit) as stop:
        apart(lambda: main(["view", str(small), "--set", "sources.0.center=[0, 0, -5]", "--port", "0"]))
    assert stop.value.code == 2


def test_a_body_follows_the_pointer_and_the_other_falls_on(tmp_path):
    """A dragged rigid body comes to where the page drags it; another flies on at its 1 m/s."""
    box = {"shape": "box", "center": [-1, 0, 0.3], "size": [0.3, 0.3, 0.3]}
    flying = {"shape": "sphere", "center": [-2, 0, 2.0], "radius": 0.2, "velocity": [0, 1, 0]}
    path = tmp_path / "bodies.toml"
    path.write_text(to_toml(scene_from(SMALL | {"bodies": [box, flying]})), encoding="utf-8")

    async def talk(page, port):
        await page.send(do="speed", factor=100.0)
        await page.send(do="play")
        for _ in range(200):
            await page.send(do="move", name="bodies.0", position=[-1.0, 0.5, 0.8])
            count = len(page.states)
            await page.until(lambda p, count=count: len(p.states) > count)
            here, other = page.head["poses"][2][:3], page.head["poses"][3][:3]
            if abs(here[1] - 0.5) < 0.03 and abs(here[2] - 0.8) < 0.05:
                break
        else:
            raise AssertionError("the body did not come")
        assert other[1] == pytest.approx(page.head["time"], abs=1e-6)
        for _ in range(200):  # a collider of the scene too, which the engine must then move
            await page.send(do="move", name="colliders.1", position=[0.9, 0.4, 0.3])
            count = len(page.states)
            await page.until(lambda p, count=count: len(p.states) > count)
            if abs(page.head["poses"][1][1] - 0.4) < 0.03:
                break
        else:
            raise AssertionError("the collider did not come")
        assert page.head["poses"][3][1] == pytest.approx(page.head["time"], abs=1e-6)
        assert page.message("refused") is None

    converse(prepare(str(path), out=str(tmp_path / "out"), threads=1), talk)


def test_snapshots_are_shown_and_commands_heard_between_two_steps(small):
    """A piece of many steps is shown while it is computed, and ends early if a page wants something.

    Asking after each step changes no bit; to say "enough" ends the work after that step.
    """
    scene = load(str(small))
    plain, asked, ended = (Simulation(scene, threads=1) for _ in range(3))
    plain.advance(0.01)
    asked.advance(0.01, lambda: False)
    np.testing.assert_array_equal(plain.state.x, asked.state.x)
    ended.advance(0.01, lambda: True)
    assert ended.steps == 1
    assert 0.0 < ended.time < 0.01

    live = prepare(str(small), threads=1).player
    live._begin()
    first, began = live.latest, monotonic() - 1.0  # a second ago
    live._due = 0.0
    assert not live._look_up(began)
    assert live.latest is not first
    live.submit(commands.Pause(do="pause"))
    assert live._look_up(began)
    assert not live._look_up(monotonic() + 60.0)  # a piece that has hardly begun goes on


def test_a_mode_that_the_solver_has_no_columns_for_is_not_measured(small, monkeypatch):
    """A page may ask for any mode of the list; what the solver cannot show is left out of the snapshot."""
    live = prepare(str(small), threads=1).player
    live._begin()
    live.modes = {"speed", "stress"}
    monkeypatch.setattr(live, "color_modes", lambda: ["snow", "speed"])
    live._copy()
    assert set(live.latest.values) == {"speed"}


def test_a_source_is_found_behind_a_thrown_ball(small):
    """Snow that was added after a throw is the scene's second source and the running scene's third."""
    live = prepare(str(small), threads=1).player
    live._begin()
    live._do(commands.Throw(do="throw", origin=(0, 0, 2), direction=(0, 0, -1), radius=0.2))
    live._do(commands.Add(do="add", kind="sources", shape="box", at=(3, 0, 0)))
    assert [s.shape for s in live.scene.sources] == ["sphere", "box"]
    assert [s.shape for s in live.running().sources] == ["sphere", "sphere", "box"]
    assert live._running("sources.1.snow.E0") == "sources.2.snow.E0"
    assert live._running("sources.0.snow.E0") == "sources.0.snow.E0"
    assert live._running("colliders.1.mu_c") == "colliders.1.mu_c"
