"""Files and doors of the server: what is handed out, to whom, and from where."""

import asyncio
import io
import posixpath
import re
import socket
import warnings

import pytest
from viewer.conftest import apart, converse

from neve.viewer.server import PAGE
from neve.viewer.show import ViewError, prepare, view


async def get(port, path, method="GET", **headers):
    """Send a bare request and return status, headers and body."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    lines = [
        f"{method} {path} HTTP/1.1",
        *(f"{k}: {v}" for k, v in ({"Host": f"127.0.0.1:{port}"} | headers).items()),
    ]
    writer.write("\r\n".join([*lines, "", ""]).encode())
    answer = await asyncio.wait_for(reader.read(), 20)
    writer.close()
    head, _, body = answer.partition(b"\r\n\r\n")
    return int(head.split()[1]), head.decode(), body


@pytest.fixture
def server(recorded):
    return prepare(str(recorded))


def test_page_and_its_files_are_served(server):
    """The page and its modules name only files that are served, with a strict policy, none from elsewhere."""

    async def talk(page, port):
        status, head, body = await get(port, "/")
        assert status == 200
        assert "default-src 'self'" in head
        text = body.decode()
        named = set(re.findall(r'(?:src|href)="([^"]+)"', text)) - {"data:,"}
        assert all(name.startswith("/page/") for name in named)
        seen = set()
        while waiting := named - seen:
            name = waiting.pop()
            seen.add(name)
            status, head, body = await get(port, name)
            assert status == 200, name
            if name.endswith(".js"):  # a browser runs a module only under this type
                assert "Content-Type: text/javascript" in head
                imported = re.findall(r'^import\b[^;]*?"(\.[^"]+)";', body.decode(), re.MULTILINE)
                named |= {
                    posixpath.normpath(posixpath.join(posixpath.dirname(name), path)) for path in imported
                }
        assert len(seen) > 10
        assert not re.search(
            r"https?://",
            "".join(p.read_text() for p in PAGE.rglob("*.*")).replace("http://www.w3.org/2000/svg", ""),
        )

    converse(server, talk)


OUTSIDE = [
    "/page/../server.py", "/page/..%2fserver.py", "/../view.py", "/files/scene.toml", "/files/../scene.toml",
    "/page/", "/page//etc/passwd", "/files/", "//etc/passwd", "/scene.toml", "/page/%00",
]  # fmt: skip


def test_nothing_else_is_served(server):
    """No path leads out: names are looked up in a list."""

    async def talk(page, port):
        for path in OUTSIDE:
            status, _, body = await get(port, path)
            assert status == 404, path
            assert b"import" not in body

    converse(server, talk)


def test_foreign_pages_are_turned_away(server):
    """A foreign Host or Origin, or two Hosts, get 403."""

    async def talk(page, port):
        socket_ = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
                   "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}  # fmt: skip
        assert (await get(port, "/", Host="snow.example"))[0] == 403
        assert (await get(port, "/socket", Origin="http://evil.example", **socket_))[0] == 403
        assert (await get(port, "/socket", Origin="null", **socket_))[0] == 403

    converse(server, talk)


def test_only_reading_is_answered(server):
    """POST, PUT, DELETE, TRACE and OPTIONS get 405 and what is allowed; HEAD is GET without its body."""

    async def talk(page, port):
        for method in ("POST", "PUT", "DELETE", "TRACE", "OPTIONS", "PATCH"):
            status, head, _ = await get(port, "/", method)
            assert status == 405, method
            assert "Allow: GET, HEAD" in head
        status, head, body = await get(port, "/", "HEAD")
        assert (status, body) == (200, b"")
        assert "Content-Type: text/html" in head

    converse(server, talk)


def test_a_run_plays_with_its_timeline(server, recorded):
    """Seek shows the frame asked for; colours that a frame has are shown, others are not offered."""

    async def talk(page, port):
        scene = page.message("scene")
        assert scene["live"] is False
        assert scene["player"]["frames"] == 6
        assert "stress" not in {m["name"] for m in scene["modes"]}
        assert [s["path"] for s in scene["panel"]] == ["light"]
        await page.send(do="seek", frame=3)
        await page.until(lambda p: p.head["frame"] == 3)
        assert page.head["time"] == pytest.approx(0.1)
        await page.send(do="color_mode", mode="speed")
        await page.until(lambda p: p.head["mode"] == "speed")
        await page.send(do="seek", frame=10**6)
        await page.until(lambda p: p.head["frame"] == 5)
        await page.send(do="play")
        await page.until(lambda p: p.head["frame"] < 5)  # in a circle
        await page.send(do="throw", origin=[0, 0, 2], direction=[0, 0, -1])
        await page.until(lambda p: p.message("refused"))
        assert "recorded" in page.message("refused")["sentence"]
        await page.send(do="set", path="light.sun_elevation", value=60.0)
        await page.until(lambda p: p.message("scene")["light"]["sun"][2] > 0.8)

    before = sorted((p.name, p.stat().st_mtime_ns) for p in recorded.rglob("*"))
    converse(server, talk)
    assert sorted((p.name, p.stat().st_mtime_ns) for p in recorded.rglob("*")) == before


def test_many_pages_watch_one_run(server):
    """Each page sees the run, in its own colours; the moment is encoded once for each colour mode."""

    async def talk(page, port):
        from viewer.conftest import Page
        from websockets.asyncio.client import connect

        async with connect(f"ws://127.0.0.1:{port}/socket", max_size=None) as line:
            other = Page(line)
            await other.until(lambda p: p.states and p.message("scene"))
            await other.send(do="color_mode", mode="J_P")
            await other.until(lambda p: p.head["mode"] == "J_P")
            await page.send(do="seek", frame=2)
            for each in (page, other):
                await each.until(lambda p: p.head["frame"] == 2)
            assert page.head["mode"] == "snow"
            assert other.head["mode"] == "J_P"

    converse(server, talk)


def test_what_cannot_be_shown_is_told_in_one_sentence(tmp_path, recorded):
    """A taken port, a change to a finished run, a damaged frame."""
    from neve.io.errors import RunError

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(ViewError, match="cannot be used"):
            apart(lambda: view(str(recorded), port=taken.getsockname()[1]))
    with pytest.raises(ViewError, match="--set cannot change"):
        prepare(str(recorded), ["snow.xi=3"])
    (recorded / "frames/000000.npz").write_bytes(b"snow")
    with pytest.raises(RunError, match="damaged"):
        prepare(str(recorded))


def test_an_open_address_is_warned_of(recorded, monkeypatch):
    """Any address but this machine's own comes with a warning; the own one does not."""
    for host, warned in [("127.0.0.1", False), ("0.0.0.0", True), ("::", True), ("localhost", False)]:
        said = io.StringIO()
        monkeypatch.setattr("neve.viewer.show.asyncio.run", lambda work: work.close())
        with warnings.catch_warnings():
            view(str(recorded), host=host, tell=lambda text, said=said: print(text, file=said))
        assert ("warning" in said.getvalue()) == warned


def test_the_first_page_finds_the_run_playing(server):
    """`neve view` plays when the first page has come; what `prepare` makes waits for `play`."""
    server.eager = True

    async def talk(page, port):
        await page.until(lambda p: p.head["frame"] > 0)

    converse(server, talk)
    assert not server.eager
