"""`neve drive`: it serves the files of the built page and nothing else."""

import contextlib
import http.client
import json
import re
import socket
import threading

import pytest
from patience import PATIENCE

from neve.cli import main
from neve.drive import DriveError, serve
from neve.serving import TRIES


@pytest.fixture
def page(tmp_path):
    """A page of two files, beside one that is nobody's business."""
    folder = tmp_path / "page"
    (folder / "assets").mkdir(parents=True)
    (folder / "index.html").write_text("<title>snow</title>", encoding="utf-8")
    (folder / "assets/main.js").write_bytes(b"export {};\n")
    (tmp_path / "secret.txt").write_text("secret", encoding="utf-8")
    return folder


@contextlib.contextmanager
def asking(page, recordings=()):
    """Send requests to a server of the page; each returns status, headers and body."""
    with serve.listening("127.0.0.1", 0, page, recordings) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()

        def request(method, target):
            line = http.client.HTTPConnection(*server.server_address[:2], timeout=PATIENCE)
            line.putrequest(method, target, skip_accept_encoding=True)
            line.endheaders()
            answer = line.getresponse()
            found = answer.status, dict(answer.getheaders()), answer.read()
            line.close()
            return found

        yield request
        server.shutdown()
        thread.join(PATIENCE)


@pytest.fixture
def ask(page):
    """Send one request to a server of the page."""
    with asking(page) as request:
        yield request


@pytest.mark.parametrize(
    ("target", "kind", "body"),
    [
        ("/", "text/html; charset=utf-8", b"<title>snow</title>"),
        ("/index.html?depth=0.5#x", "text/html; charset=utf-8", b"<title>snow</title>"),
        ("/assets/main.js", "text/javascript; charset=utf-8", b"export {};\n"),
    ],
)
def test_files_of_the_page_are_served(ask, target, kind, body):
    """Each has its content type; a query or an anchor changes nothing."""
    status, headers, got = ask("GET", target)
    assert (status, headers["Content-Type"], got) == (200, kind, body)
    status, headers, got = ask("HEAD", target)
    assert (status, headers["Content-Length"], got) == (200, str(len(body)), b"")


@pytest.mark.parametrize(
    "target", ["/secret.txt", "/../secret.txt", "/%2e%2e/secret.txt", "//secret.txt", "/assets", "/assets/"]
)
def test_nothing_else_is_served(ask, target):
    """No path leads out of the list of files."""
    status, _, body = ask("GET", target)
    assert status == 404
    assert b"secret" not in body


def test_other_methods_are_refused(ask):
    """The server only reads."""
    assert ask("DELETE", "/index.html")[0] == 501


def test_missing_page_is_told(tmp_path):
    """A copy of Neve without the page says how to build it."""
    with (
        pytest.raises(DriveError, match=r"does not carry the page .*(npm ci|pip install)"),
        serve.listening("127.0.0.1", 0, tmp_path),
    ):
        pass


@pytest.mark.parametrize(
    ("built", "installed", "told"),
    [
        (False, "site", r"run npm ci && npm run build in \S*web/drive \(.*\), then pip install \S+\.$"),
        (False, "source", r"run npm ci && npm run build in \S*web/drive \([^)]*\)\.$"),
        (True, "site", r"installed before \S*page was built, so run pip install \S+ again\.$"),
        (None, "site", r"npm run build in web/drive of the source .* pip install \. there"),
    ],
)
def test_missing_page_is_told_as_it_is(tmp_path, monkeypatch, built, installed, told):
    """The message knows whether the page was built after Neve was installed, and where from that was."""
    source, site = tmp_path / "a source", tmp_path / "site"
    own = source / serve.PAGE_IN_SOURCE
    for folder in (own, source / "web/drive", site):
        folder.mkdir(parents=True)
    if built is not None:
        (source / "web/drive/package.json").write_text("{}", encoding="utf-8")
    if built:
        (own / "index.html").write_text("", encoding="utf-8")

    class Installed:
        def read_text(self, name):
            return json.dumps({"url": source.as_uri(), "dir_info": {}}) if name == "direct_url.json" else None

    monkeypatch.setattr(serve.metadata, "distribution", lambda name: Installed())
    told = told.replace(r"\S+", r"\S+ source").replace(r"\S*", r"\S+ source/\S*")
    page = {"site": site, "source": own}[installed]
    with pytest.raises(DriveError, match=told), serve.listening("127.0.0.1", 0, page):
        pass


def test_taken_port_is_told(page):
    """A port that was asked for and is taken is one sentence."""
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with (
            pytest.raises(DriveError, match=f"port {port} of 127.0.0.1 cannot be used"),
            serve.listening("127.0.0.1", port, page),
        ):
            pass


def test_next_free_port_is_taken(page):
    """Without a port asked for, the first free one from the usual one on is used."""
    with serve.listening("127.0.0.1", None, page) as one, serve.listening("127.0.0.1", None, page) as two:
        assert serve.PORT <= one.server_address[1] < two.server_address[1] < serve.PORT + TRIES


def test_command_without_page_fails_with_one_sentence(monkeypatch, tmp_path, capsys):
    """Exit code 2, one line."""
    monkeypatch.setattr(serve, "PAGE", tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["drive"])
    assert stop.value.code == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1


def test_ctrl_c_ends_it(monkeypatch, page, capsys):
    """The address is told; Ctrl-C is how it ends, with code 0."""

    def stop(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(serve, "PAGE", page)
    monkeypatch.setattr(serve._Server, "serve_forever", stop)
    with pytest.raises(SystemExit) as end:
        main(["drive", "--host", "127.0.0.1"])
    assert end.value.code == 0
    assert capsys.readouterr().out.startswith("http://127.0.0.1:84")


def test_recordings_are_served_beside_the_page(page, tmp_path):
    """Each under the name of its run's folder, whatever that is, and nothing else of that folder."""
    files = [tmp_path / name / "drive.json" for name in ("wheel", "snow & ice #1")]
    for number, file in enumerate(files):
        file.parent.mkdir()
        file.write_text(f"[{number}]", encoding="utf-8")
    with asking(page, files) as request:
        status, headers, body = request("GET", "/recordings/wheel.json")
        assert (status, headers["Content-Type"], body) == (200, "application/json", b"[0]")
        assert request("GET", "/recordings/snow%20%26%20ice%20%231.json")[::2] == (200, b"[1]")
        assert request("GET", "/recordings/drive.json")[0] == 404


def test_built_page_is_carried_whole():
    """If web/drive was built before Neve was installed, the page and all that it names are served."""
    if not (serve.PAGE / "index.html").exists():
        pytest.skip("web/drive was not built before Neve was installed: npm ci && npm run build there")
    with asking(serve.PAGE) as request:
        status, _, body = request("GET", "/")
        assert status == 200
        named = re.findall(r'(?:src|href)="\./([^"]+)"', body.decode())
        assert any(name.endswith(".js") for name in named)
        assert {name: request("GET", f"/{name}")[0] for name in named} == dict.fromkeys(named, 200)
