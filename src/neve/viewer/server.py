"""Server: the page and its files over HTTP, snapshots and commands over a WebSocket.

A snapshot is encoded once for each colour mode in use. Each page has at most WINDOW states on their way that
it has not drawn yet; while it has, newer ones replace each other, so that a slow page sees fewer of them and
nobody waits for it.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
from collections.abc import AsyncIterator, Coroutine
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Any

from neve.io.errors import RunError
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene
from neve.serving import content_type
from neve.viewer import safety
from neve.viewer.describe import describe
from neve.viewer.encode import encode
from neve.viewer.modes import MODES, WETNESS, Colors, Scale
from neve.viewer.opening import Opener, Show
from neve.viewer.players.player import Begin
from neve.viewer.protocol import commands
from neve.viewer.protocol.messages import Message
from neve.viewer.protocol.state import finite
from neve.viewer.tools import dropping
from neve.viewer.tools.dropping import Upload

if TYPE_CHECKING:
    from websockets.asyncio.server import Server as Socket
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

PAGE = Path(__file__).parent / "page"
PLAIN = "text/plain; charset=utf-8"
WINDOW = 3
"""States that may be on their way to a page: enough for 30 a second over 100 ms."""


MOST_TASKS = 4096
"""Pieces of files and openings that may wait; more than the pieces of the largest file."""


class Client:
    """Hold one page that watches."""

    def __init__(self, connection: ServerConnection) -> None:
        self.connection = connection
        self.colors = Colors()
        self.sent = self.drawn = 0
        self.room = asyncio.Event()
        self.messages: asyncio.Queue[str] = asyncio.Queue(maxsize=256)

    def tell(self, text: str) -> None:
        """Put a message in the queue of this page; one that has stopped reading misses it."""
        with contextlib.suppress(asyncio.QueueFull):
            self.messages.put_nowait(text)


class Server:
    """Show one player to any number of pages."""

    def __init__(self, show: Show, host: str, opener: Opener) -> None:
        self.player, self.exports, self.host = show.player, show.exports, host
        self._opener = opener
        self._upload = Upload()
        self._tasks: set[asyncio.Task[None]] = set()
        self._turn = asyncio.Lock()
        self.eager = False
        """Whether to play as soon as the first page has connected."""
        self._clients: set[Client] = set()
        self._version = 0
        self._begun = False
        self._encoded: dict[Colors, tuple[int, asyncio.Future[bytes]]] = {}
        self._scale = Scale()
        self._files = {p.relative_to(PAGE).as_posix(): p for p in PAGE.rglob("*") if p.is_file()}

    @contextlib.asynccontextmanager
    async def serve(self, port: int) -> AsyncIterator[Socket]:
        """Open the socket and start the player; at the end close both. `failed` ends if the player does."""
        from websockets.asyncio.server import serve

        loop = asyncio.get_running_loop()
        self._listen(loop)
        self.failed: asyncio.Future[None] = loop.create_future()
        silent = logging.getLogger("neve.viewer.socket")
        silent.addHandler(logging.NullHandler())
        silent.propagate = False
        async with serve(
            self._meet,
            self.host,
            port,
            process_request=self._request,
            compression=None,
            max_size=commands.MOST_BYTES,
            max_queue=16,
            logger=silent,
            ping_interval=20,
            close_timeout=1,  # a page that is gone says no goodbye, and Ctrl-C does not wait for it
        ) as socket:
            self.player.start()
            try:
                yield socket
            finally:
                await asyncio.to_thread(self.player.stop)
                self.exports.close()

    def _listen(self, loop: asyncio.AbstractEventLoop) -> None:
        """Hear what the player and the exports say, until there are others."""
        player = self.player

        def hear(call: Any, *arguments: Any) -> None:
            if player is self.player:
                call(*arguments)

        player.on_snapshot = lambda: self._from_thread(loop, hear, self._wake)
        player.on_scene = lambda: self._from_thread(loop, hear, self._tell_scene)
        player.on_message = lambda message: self._from_thread(loop, hear, self._broadcast, message)
        player.on_failure = lambda error: self._from_thread(loop, hear, self._fail, error)
        self.exports.on_message = player.on_message

    @staticmethod
    def _from_thread(loop: asyncio.AbstractEventLoop, call: Any, *arguments: Any) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended while the player was still at work
            loop.call_soon_threadsafe(call, *arguments)

    def _fail(self, error: BaseException) -> None:
        if not self.failed.done():
            self.failed.set_exception(error)

    def _wake(self) -> None:
        """Wake the senders of all pages that have room for the new snapshot."""
        self._version += 1
        for client in self._clients:
            client.room.set()

    def _tell_scene(self) -> None:
        self._begun = True
        self._broadcast(describe(self.player))

    def _broadcast(self, message: Message) -> None:
        text = json.dumps(finite(message))
        for client in self._clients:
            client.tell(text)

    def _request(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answer a request for a file; let that for the socket pass if it comes from the page."""
        from websockets.datastructures import Headers
        from websockets.http11 import Response

        def answer(status: HTTPStatus, body: bytes, kind: str = PLAIN, **more: str) -> Response:
            length = str(len(body))
            headers = Headers({**safety.HEADERS, "Content-Type": kind, "Content-Length": length, **more})
            return Response(status.value, status.phrase, headers, b"" if request.method == "HEAD" else body)

        hosts = request.headers.get_all("Host")
        if len(hosts) != 1 or not safety.host_allowed(hosts[0], self.host):
            return answer(HTTPStatus.FORBIDDEN, b"This host name is not the viewer's.\n")
        if request.method not in ("GET", "HEAD"):
            return answer(
                HTTPStatus.METHOD_NOT_ALLOWED, b"Only GET and HEAD are answered.\n", Allow="GET, HEAD"
            )
        path = request.path.partition("?")[0]
        if path == "/socket":
            if safety.same_origin(request.headers.get_all("Origin"), hosts[0]):
                return None
            return answer(HTTPStatus.FORBIDDEN, b"Only the viewer's own page may connect.\n")
        name = "index.html" if path == "/" else path.removeprefix("/page/")
        file = self._files.get(name) if path == "/" or path.startswith("/page/") else self.exports.file(path)
        if file is None:
            return answer(HTTPStatus.NOT_FOUND, b"There is no such page.\n")
        try:
            body = file.read_bytes()
        except OSError:
            return answer(HTTPStatus.NOT_FOUND, b"This file is gone.\n")
        return answer(HTTPStatus.OK, body, content_type(file))

    async def _meet(self, connection: ServerConnection) -> None:
        """Serve one page until it goes, however it goes."""
        from websockets.exceptions import ConnectionClosed

        client = Client(connection)
        if self._begun:  # else the first message of the scene is still to come, and reaches this page too
            client.tell(json.dumps(finite(describe(self.player))))
        self._clients.add(client)
        if self.eager:
            self.eager = False
            self.player.submit(commands.Play(do="play"))
        client.room.set()
        tasks = [asyncio.create_task(part(client)) for part in (self._send_states, self._send_messages)]
        try:
            async for message in connection:
                command = commands.read(message)
                if command is not None:
                    self._take(client, command)
        except ConnectionClosed:
            pass
        finally:
            self._clients.discard(client)
            self._update_modes()
            for task in tasks:
                task.cancel()
            for ended in await asyncio.gather(*tasks, return_exceptions=True):
                if isinstance(ended, Exception) and not isinstance(ended, ConnectionClosed):
                    logging.getLogger("neve").error("serving a page failed", exc_info=ended)

    def _take(self, client: Client, command: commands.Command) -> None:
        match command:
            case commands.Acknowledge():
                client.drawn = max(client.drawn, min(command.version, client.sent))
                client.room.set()
            case commands.ColorMode():
                if command.mode in MODES:
                    client.colors = Colors(command.mode, command.limits, command.log)
                    self._update_modes()
                    self.player.submit(command)
            case commands.Library():
                self._work(client, self._list(client))
            case commands.Open():
                self._work(client, self._open(command.scene))
            case commands.Piece():
                self._work(client, self._take_piece(client, command))
            case commands.Picture() | commands.Film() | commands.Replay() | commands.Save():
                self.exports.start(command)
            case _:
                self.player.submit(command)

    def _tell(self, client: Client, message: Message) -> None:
        client.tell(json.dumps(finite(message)))

    def _work(self, client: Client, work: Coroutine[Any, Any, None]) -> None:
        """Do what takes longer than a command, one after the other; a refusal is told to who has asked."""
        if len(self._tasks) >= MOST_TASKS:
            work.close()
            return

        async def one() -> None:
            async with self._turn:
                try:
                    await work
                except (SceneError, RunError) as error:
                    self._tell(client, {"kind": "refused", "sentence": str(error), "path": ""})

        task = asyncio.create_task(one())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _list(self, client: Client) -> None:
        """Tell what can be opened."""
        self._tell(client, {"kind": "library", "entries": await asyncio.to_thread(self._opener.entries)})

    async def _open(self, name: str) -> None:
        """Show another scene or run. Errors: SceneError, RunError; then all is as it was."""
        if self.player.live and not await asyncio.to_thread(self._opener.is_run, name):
            scene = await asyncio.to_thread(self._opener.scene_of, name)
            self.player.submit(Begin(name=name, scene=scene))
            return
        await self._swap(await asyncio.to_thread(self._opener.show_of, name))

    async def _swap(self, show: Show) -> None:
        """End the player and start another for the same pages."""
        old, files = self.player, self.exports
        show.player.meshes = old.meshes
        show.player.plots = old.plots
        self.player, self.exports, self._begun = show.player, show.exports, False
        self._encoded, self._scale = {}, Scale()
        self._listen(asyncio.get_running_loop())
        self._update_modes()
        show.player.start()
        await asyncio.to_thread(old.stop)
        await asyncio.to_thread(files.close)

    async def _take_piece(self, client: Client, piece: commands.Piece) -> None:
        """Take a piece of a dropped file; after the last one, play the scene or offer what it is."""
        content = self._upload.take(client, piece)
        if content is None:
            return
        meshes = self.player.meshes
        path = await asyncio.to_thread(dropping.kept, self._opener.folder, piece.name, content)
        with dropping.refused_by_name(path, piece.name):
            if path.suffix == ".toml":
                scene = await asyncio.to_thread(dropping.scene_of, path, meshes)
                await self._play(path.stem, scene)
            elif not self.player.live:
                raise SceneError(f"{piece.name}: nothing can be added to a finished run; open a scene first")
            else:
                what = await asyncio.to_thread(dropping.offered, path, self.player.scene.numerics.dx)
                meshes[path.name] = path
                self._tell(client, {"kind": "dropped", "what": what})

    async def _play(self, name: str, scene: Scene) -> None:
        """Play a scene that is no entry of the library. Errors: SceneError; then all is as it was."""
        if self.player.live:
            self.player.submit(Begin(name=name, scene=scene))
            return
        show = self._opener.live(name, scene)
        await asyncio.to_thread(show.player.make_ready)
        await self._swap(show)

    def _update_modes(self) -> None:
        colors = {client.colors for client in self._clients}
        for unseen in set(self._encoded) - colors:
            del self._encoded[unseen]
        seen = {each.mode for each in colors}
        self.player.modes = seen - {"snow"} | ({WETNESS} if "snow" in seen else set())

    async def _send_messages(self, client: Client) -> None:
        while True:
            await client.connection.send(await client.messages.get())

    async def _send_states(self, client: Client) -> None:
        """Send the latest snapshot whenever there is a newer one and the page has drawn what it got."""
        shown = 0
        while True:
            await client.room.wait()
            client.room.clear()
            while self.player.latest and self._version > shown and client.sent - client.drawn < WINDOW:
                shown = self._version
                message = await self._message(client.colors)
                client.sent += 1
                await client.connection.send(message)

    async def _message(self, colors: Colors) -> bytes:
        """Return the latest snapshot in some colours, encoded once for all pages that ask."""
        version = self._version
        found = self._encoded.get(colors)
        if found is None or found[0] != version:
            snapshot = self.player.latest
            assert snapshot is not None  # who sends has looked
            work = asyncio.to_thread(encode, snapshot, colors, self._scale, version)
            found = (version, asyncio.ensure_future(work))
            self._encoded[colors] = found
        return await asyncio.shield(found[1])
