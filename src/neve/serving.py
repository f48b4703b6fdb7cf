"""What the servers of `neve view` and `neve drive` share: addresses, ports and types of files."""

from __future__ import annotations

import ipaddress
from collections.abc import Iterator
from pathlib import PurePath

TRIES = 20
"""Ports from the usual one on that are tried, unless one was asked for."""

TYPES = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".jpg": "image/jpeg",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".mp4": "video/mp4",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".toml": "text/plain; charset=utf-8",
    ".wasm": "application/wasm",
}
"""Content types by suffix. Browsers run a module only under the right one, so none is asked of the system."""


def content_type(file: PurePath) -> str:
    """Return the content type of a file that is served."""
    return TYPES.get(file.suffix, "application/octet-stream")


def ports(asked: int | None, usual: int) -> Iterator[int]:
    """Yield the ports to try: the one that was asked for, or the usual one and those after it."""
    yield from (asked,) if asked is not None else range(usual, usual + TRIES)


def port_error(host: str, port: int, error: OSError) -> str:
    """Return the sentence for a port that cannot be opened."""
    return f"port {port} of {host} cannot be used: {error.strerror or error}; choose another."


def address(host: str, port: int) -> str:
    """Return the URL of a server."""
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


def is_local(host: str) -> bool:
    """Return whether `host` is reached from this machine alone."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
