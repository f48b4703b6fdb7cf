"""`neve view`: open a scene or a run in the browser."""

from __future__ import annotations

import asyncio
import contextlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from neve.serving import address, is_local, port_error, ports
from neve.system import stopping

if TYPE_CHECKING:
    from neve.viewer.server import Server

PORT = 8420


class ViewError(RuntimeError):
    """One sentence for the user: why nothing can be shown."""


def view(
    what: str,
    changes: Sequence[str] = (),
    out: str | None = None,
    host: str = "127.0.0.1",
    port: int | None = None,
    threads: int | None = None,
    browse: bool = False,
    tell: Callable[[str], None] = print,
) -> None:
    """Show a scene live, or play a run folder that has frames, until Ctrl-C.

    It plays as soon as the first page is there. out: folder for what the pages save; the run itself, or
    runs/NAME-live. threads: of the simulation; all but one by default, which is for the pages. browse: open
    the page in this machine's browser.
    Errors: ViewError, SceneError, RunError, one sentence each.
    """
    server = prepare(what, changes, out, host, threads)
    if not is_local(host):
        tell(
            f"warning: {host} can be reached from other machines: whoever connects can steer this run and "
            "write into its folder; without --host only this machine can."
        )
    server.eager = True
    with stopping.Held() as held, contextlib.suppress(asyncio.CancelledError):
        asyncio.run(_serve(server, held, host, port, browse, tell))
    stopping.check()


def write_replay(run: str, path: str) -> None:
    """Write the page that plays the run folder `run` by itself. Errors: RunError, SceneError."""
    from neve.io.atomic import write_bytes
    from neve.viewer.exports.replay import replay_of

    if not Path(path).name:
        raise ViewError(f'--replay "{path}" names no file')
    write_bytes(Path(path), replay_of(run))


def prepare(
    what: str,
    changes: Sequence[str] = (),
    out: str | None = None,
    host: str = "127.0.0.1",
    threads: int | None = None,
) -> Server:
    """Make the server of a scene or a run, not yet started. Errors: ViewError, SceneError, RunError."""
    from neve.io.run_folder import RunFolder
    from neve.scene.reading.load import load
    from neve.scene.reading.presets import presets
    from neve.viewer.exports.exports import Exports
    from neve.viewer.players.live import Live
    from neve.viewer.players.player import Player
    from neve.viewer.players.recorded import Recorded
    from neve.viewer.players.recorder import Recorder
    from neve.viewer.server import Server

    run = RunFolder(what)
    player: Player
    if what not in presets() and _is_run(run):
        if changes:
            raise ViewError(
                f"{what} is a finished run, which --set cannot change: name its scene.toml to run it anew."
            )
        player = Recorded(run)
        return Server(player, Exports(Path(out) if out else run.path, player, None), host)
    scene = load(what, changes)
    name = what if what in presets() else Path(what).resolve().stem
    folder = Path(out) if out else Path("runs") / f"{name}-live"
    recorder = Recorder(folder)
    player = Live(name, scene, threads or max(1, (os.cpu_count() or 1) - 1), recorder)
    return Server(player, Exports(folder, player, recorder), host)


def _is_run(run: object) -> bool:
    from neve.io.frames import frame_numbers
    from neve.io.run_folder import RunFolder

    assert isinstance(run, RunFolder)
    with contextlib.suppress(OSError):
        return bool(frame_numbers(run.frames))
    return False


async def _serve(
    server: Server,
    held: stopping.Held,
    host: str,
    port: int | None,
    browse: bool,
    tell: Callable[[str], None],
) -> None:
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    assert task is not None
    held.then(lambda: loop.call_soon_threadsafe(task.cancel))
    for number in (tries := list(ports(port, PORT))):
        try:
            async with server.serve(number) as socket:
                url = address(host, socket.sockets[0].getsockname()[1])
                tell(f"{url} shows it; Ctrl-C ends.")
                if browse:
                    import webbrowser

                    webbrowser.open(url)
                with contextlib.suppress(asyncio.CancelledError):  # Ctrl-C
                    await server.failed
                return
        except OSError as error:
            if number == tries[-1]:
                raise ViewError(port_error(host, number, error)) from error
