"""`neve view`: open a scene or a run in the browser."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import parse_qs, urlsplit

from neve.serving import address, is_local, port_error, ports
from neve.system import stopping
from neve.system.processors import free_threads

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
    runs/NAME-live. threads: of the simulation; by default those that are free. browse: open
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
    """Make the server of a scene or a run, not yet started.

    what: a scene, a run folder, or the link of a page, which names one of them after `#scene=`.
    Errors: ViewError, SceneError, RunError.
    """
    from neve.io.run_folder import RunFolder
    from neve.scene.reading.load import load
    from neve.scene.reading.presets import presets
    from neve.viewer.exports.exports import Exports
    from neve.viewer.opening import Opener, Show
    from neve.viewer.players.recorded import Recorded
    from neve.viewer.server import Server

    count = threads or free_threads()
    if is_link(what):
        what = Opener([Path(), Path("runs")], Path(), count).place_of(scene_of_link(what))
    run = RunFolder(what)
    if what not in presets() and _is_run(run):
        if changes:
            raise ViewError(
                f"{what} is a finished run, which --set cannot change: name its scene.toml to run it anew."
            )
        player = Recorded(run)
        own = Path(out) if out else run.path
        beside = run.path.resolve().parent
        return Server(Show(player, Exports(own, player, None)), host, Opener([beside], own, count))
    scene = load(what, changes)
    name = what if what in presets() else Path(what).resolve().stem
    folder = Path(out) if out else Path("runs") / f"{name}-live"
    roots = [folder.parent] if what in presets() else [Path(what).resolve().parent, folder.parent]
    opener = Opener(roots, folder, count)
    return Server(opener.live(name, scene), host, opener)


def is_link(what: str) -> bool:
    """Return whether WHAT is a link, not the name of a file."""
    return what.startswith(("http://", "https://", "#"))


def scene_of_link(link: str) -> str:
    """Return the name after `#scene=` of a link. Errors: ViewError: there is none."""
    names = parse_qs(urlsplit(link).fragment).get("scene", [])
    if len(names) != 1:
        raise ViewError(f"{link[:200]} names no scene: copy the link of a page whose address has #scene=NAME")
    return names[0]


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
