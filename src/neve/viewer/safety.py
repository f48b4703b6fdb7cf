"""Who may connect: the viewer's own page, under an address of this machine."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Sequence

from neve.serving import is_local

HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'self'; connect-src 'self'; img-src 'self' data: blob:; "
    "style-src 'self'; script-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
"""Sent with every answer: the page loads nothing from elsewhere, and no other page may show or read it."""


def host_allowed(header: str, host: str) -> bool:
    """Whether a request's Host names this server.

    A foreign page can make a name of its own point here (DNS rebinding), but no number: a number is always
    right, a name only if it is this machine's or the one that the server listens on.
    """
    name = _name(header)
    if name is None:
        return False
    try:
        ipaddress.ip_address(name)
        return True
    except ValueError:
        pass
    if is_local(host):
        return name in ("localhost", host.lower())
    return name in ("localhost", host.lower(), socket.gethostname().lower(), socket.getfqdn().lower())


def same_origin(origins: Sequence[str], host: str) -> bool:
    """Whether a request comes from this server's own page: a browser always says from where.

    A program that is no browser sends no Origin and may connect: it could send any.
    """
    if not origins:
        return True
    scheme, _, place = origins[0].partition("://")
    return len(origins) == 1 and scheme in ("http", "https") and place.lower() == host.lower()


def _name(header: str) -> str | None:
    """Return the name in `name:port` or `[address]:port`, in small letters."""
    text = header.strip().lower()
    if text.startswith("["):
        inside, closed, rest = text[1:].partition("]")
        return inside if closed and (not rest or rest.startswith(":")) else None
    name, _, port = text.partition(":")
    return name if name and (not port or port.isdigit()) else None
