"""A small scene, a server that shows it, and a page's end of the line."""

import asyncio
import json
import shutil
from concurrent.futures import ThreadPoolExecutor

import pytest
from patience import PATIENCE

from neve.scene.reading.load import scene_from, to_toml
from neve.viewer.protocol.state import unframed

SMALL = {
    "numerics": {"dx": 0.1},
    "sources": [{"shape": "sphere", "center": [0.0, 0.0, 0.5], "radius": 0.3}],
    "colliders": [
        {"shape": "plane"},
        {"shape": "box", "center": [0.9, 0.0, 0.3], "size": [0.3, 0.6, 0.6], "color": [0.7, 0.2, 0.1]},
    ],
    "camera": {"position": [1.5, -2.5, 1.0], "target": [0.2, 0.0, 0.35]},
    "run": {"duration": 0.2, "film": False},
}


@pytest.fixture
def small(tmp_path):
    """The file of a small scene: some two thousand particles above a floor, and a box."""
    path = tmp_path / "small.toml"
    path.write_text(to_toml(scene_from(SMALL)), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """The folder of a finished run of the small scene, six frames."""
    from neve.run import run_scene

    folder = tmp_path_factory.mktemp("finished") / "recorded"
    run_scene(scene_from(SMALL), folder, threads=1, frames=5, quiet=True)
    return folder


@pytest.fixture
def recorded(tmp_path, finished):
    """A copy of it that a test may spoil."""
    return shutil.copytree(finished, tmp_path / "recorded")


class Page:
    """A page without a browser: sends commands, collects what comes."""

    def __init__(self, socket, draws=True):
        self.socket, self.draws = socket, draws
        self.states, self.messages = [], []

    async def send(self, **command):
        await self.socket.send(json.dumps(command))

    async def until(self, found, seconds=PATIENCE):
        """Read until `found(self)` is true, and return what it returns."""

        async def read():
            while not (answer := found(self)):
                message = await self.socket.recv()
                if isinstance(message, str):
                    self.messages.append(json.loads(message))
                else:
                    self.states.append(unframed(message))
                    if self.draws:
                        await self.send(do="acknowledge", version=len(self.states))
            return answer

        return await asyncio.wait_for(read(), seconds)

    def message(self, kind):
        """The last message of a kind, or None."""
        return next((message for message in reversed(self.messages) if message["kind"] == kind), None)

    @property
    def head(self):
        return self.states[-1][0]


def converse(server, talk):
    """Serve, connect one page and run the coroutine function `talk(page, port)`; return what it returns."""
    from websockets.asyncio.client import connect

    async def main():
        async with server.serve(0) as socket:
            port = socket.sockets[0].getsockname()[1]
            url = f"ws://127.0.0.1:{port}/socket"
            async with connect(url, max_size=None, origin=f"http://127.0.0.1:{port}") as line:
                page = Page(line)
                await page.until(lambda p: p.states and p.message("scene"))
                return await talk(page, port)

    return apart(lambda: asyncio.run(main()))


def apart(call):
    """Return what `call()` returns in another thread: here a browser of other tests may have a loop."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(call).result()
