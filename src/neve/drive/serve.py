"""`neve drive`: serve the built page of `web/drive`, read only.

The page computes everything in the browser; a server is needed only because browsers load modules over HTTP
alone. Any server of files, without Neve, does as well.
"""

from __future__ import annotations

import contextlib
import functools
import http.server
import json
import socket
import webbrowser
from collections.abc import Callable, Iterator, Sequence
from http import HTTPStatus
from importlib import metadata
from pathlib import Path
from urllib.parse import quote, unquote, urlsplit
from urllib.request import url2pathname

from neve.serving import address, content_type, is_local, port_error, ports
from neve.system import stopping

PAGE = Path(__file__).parent / "page"
PORT = 8440

PAGE_IN_SOURCE = Path("src/neve/drive/page")


class DriveError(RuntimeError):
    """One sentence for the user: why the page cannot be served."""


def drive(
    host: str = "127.0.0.1",
    port: int | None = None,
    browse: bool = False,
    tell: Callable[[str], None] = print,
    recordings: Sequence[Path] = (),
    ground: Path | None = None,
) -> None:
    """Serve the page until Ctrl-C.

    browse: open it here. recordings: files in folders of runs, the first of which is played beside the car.
    ground: file in a folder of `neve snow`, on which the car begins. Errors: DriveError, one sentence.
    """
    grounds = [ground] if ground is not None else []
    with listening(host, port, recordings=recordings, grounds=grounds) as server:
        url = address(host, server.server_address[1])
        named = [*(("recording", path) for path in recordings[:1]), *(("ground", path) for path in grounds)]
        if named:
            url += "/#" + "&".join(f"{key}={quote(_name(path), safe='')}" for key, path in named)
        tell(f"{url} is the car on snow; Ctrl-C ends.")
        if not is_local(host):
            tell(f"warning: {host} can be reached from other machines; they can read the page, nothing else.")
        if browse:
            webbrowser.open(url)
        with contextlib.suppress(KeyboardInterrupt):  # the way to end it
            server.serve_forever()
    stopping.check()


@contextlib.contextmanager
def listening(
    host: str,
    port: int | None,
    page: Path | None = None,
    recordings: Sequence[Path] = (),
    grounds: Sequence[Path] = (),
) -> Iterator[http.server.ThreadingHTTPServer]:
    """Open the server of a built page, the PAGE of this copy without one, not yet answering.

    recordings, grounds: files that are served as `recordings/NAME.json` and `grounds/NAME.json`, NAME that of
    their folder. Errors: DriveError.
    """
    page = page or PAGE
    files = {f"/{path.relative_to(page).as_posix()}": path for path in page.rglob("*") if path.is_file()}
    if "/index.html" not in files:
        raise DriveError(f"this copy of Neve does not carry the page of neve drive: {_how_to_build(page)}.")
    files["/"] = files["/index.html"]
    files |= {f"/recordings/{_name(path)}.json": path for path in recordings}
    files |= {f"/grounds/{_name(path)}.json": path for path in grounds}
    handler = functools.partial(_Handler, files)
    for number in (tries := list(ports(port, PORT))):
        try:
            server = _Server6((host, number), handler) if ":" in host else _Server((host, number), handler)
        except OSError as error:
            if number == tries[-1]:
                raise DriveError(port_error(host, number, error)) from error
            continue
        with server:
            yield server
        return


def _name(file: Path) -> str:
    """Return the name of a recording or a ground: that of its folder."""
    return file.resolve().parent.name


def _how_to_build(page: Path) -> str:
    """Say what brings the page into this copy of Neve: a build of it, or of Neve alone if it is built."""
    source = _source()
    if source is None:
        return (
            "npm ci && npm run build in web/drive of the source builds it (Node 20.19 or newer), and pip "
            "install . there then takes it along"
        )
    built = source / PAGE_IN_SOURCE
    if (built / "index.html").is_file() and built.resolve() != page.resolve():
        return f"it was installed before {built} was built, so run pip install {source} again"
    again = "" if built.resolve() == page.resolve() else f", then pip install {source}"
    return f"run npm ci && npm run build in {source / 'web/drive'} (Node 20.19 or newer){again}"


def _source() -> Path | None:
    """Return the folder that this Neve was installed from, if pip knows it and it is still there."""
    try:
        told = json.loads(metadata.distribution("neve").read_text("direct_url.json") or "{}")
    except (metadata.PackageNotFoundError, ValueError, OSError):
        return None
    url = urlsplit(told.get("url", "") if isinstance(told, dict) else "")
    folder = Path(url2pathname(url.path))
    return folder if url.scheme == "file" and (folder / "web/drive/package.json").is_file() else None


class _Server(http.server.ThreadingHTTPServer):
    daemon_threads = True
    allow_reuse_address = True


class _Server6(_Server):
    address_family = socket.AF_INET6


class _Handler(http.server.BaseHTTPRequestHandler):
    """Answers GET and HEAD for the files of a list, nothing else."""

    protocol_version = "HTTP/1.1"
    timeout = 60  # [s] that a silent connection is kept

    def __init__(self, files: dict[str, Path], *args: object) -> None:
        self.files = files
        super().__init__(*args)  # type: ignore[arg-type]

    def do_GET(self) -> None:
        """Send a file with its content."""
        self._answer(with_body=True)

    def do_HEAD(self) -> None:
        """Send what would come before the content."""
        self._answer(with_body=False)

    def _answer(self, with_body: bool) -> None:
        path = self.files.get(unquote(urlsplit(self.path).path))
        if path is None:
            body, kind, status = (
                b"There is no such file.\n",
                "text/plain; charset=utf-8",
                HTTPStatus.NOT_FOUND,
            )
        else:
            body, status = path.read_bytes(), HTTPStatus.OK
            kind = content_type(path)
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-cache")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.end_headers()
        if with_body:
            with contextlib.suppress(ConnectionError):
                self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Log nothing: a line for each file is noise."""
