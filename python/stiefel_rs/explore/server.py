"""A server of this machine alone: the page, and curves for it.

It listens on 127.0.0.1. A request needs the random token that is in the page's address, and a Host and an Origin that
are its own, so that other pages of the browser, and other users of the machine, get nothing.
"""

from __future__ import annotations

import json
import secrets
import sys
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from socketserver import TCPServer
from typing import Any, Final
from urllib.parse import parse_qs, urlsplit

from ..errors import StiefelError
from . import page
from .answers import answer, message, parse

ADDRESS: Final = "127.0.0.1"
# Of HTTP.
DEFAULT_PORT: Final = 80
MAX_BODY: Final = 4096
# Seconds that a client may be silent.
TIMEOUT: Final = 20
HEADERS: Final = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class _Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"
    server_version = "stiefel-rs"
    sys_version = ""
    timeout = TIMEOUT
    # Head and body of an answer leave together and at once: apart, the body may wait 40 ms for the head's receipt.
    wbufsize = -1
    disable_nagle_algorithm = True

    def log_message(self, format: str, *args: Any) -> None:
        """Keep quiet: addresses have the token in them."""

    def _send(self, status: HTTPStatus, body: bytes, kind: str) -> None:
        if status >= HTTPStatus.BAD_REQUEST:
            # What was not read of the request would be taken for the next one.
            self.close_connection = True
        self.send_response(status)
        for name, value in HEADERS.items():
            self.send_header(name, value)
        if self.close_connection:
            self.send_header("Connection", "close")
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def _fail(self, status: HTTPStatus, text: str) -> None:
        self._send(status, json.dumps({"error": text}).encode(), "application/json")

    def _admitted(self, token: str) -> bool:
        """Whether host, origin and token are right; if not, that was said."""
        names, port = (ADDRESS, "localhost"), self.server.server_port
        own = {f"{name}:{port}" for name in names}
        # Browsers leave out the default port.
        if port == DEFAULT_PORT:
            own.update(names)
        origin = self.headers.get("Origin")
        if self.headers.get("Host") not in own:
            self._fail(HTTPStatus.FORBIDDEN, "wrong host")
        elif origin is not None and origin not in {f"http://{name}" for name in own}:
            self._fail(HTTPStatus.FORBIDDEN, "wrong origin")
        elif not secrets.compare_digest(token.encode("utf-8", "replace"), self.server.token.encode()):
            self._fail(HTTPStatus.FORBIDDEN, "wrong token: use the address that stiefel-rs explore printed")
        else:
            return True
        return False

    def do_GET(self) -> None:
        """Send the page."""
        try:
            parts = urlsplit(self.path)
        except ValueError:
            self._fail(HTTPStatus.BAD_REQUEST, "no address")
            return
        if not self._admitted(parse_qs(parts.query).get("token", [""])[0]):
            return
        if parts.path != "/":
            self._fail(HTTPStatus.NOT_FOUND, "no such page")
            return
        self._send(HTTPStatus.OK, self.server.page, "text/html")

    do_HEAD = do_GET  # noqa: N815

    def do_POST(self) -> None:
        """Send the curves for what was dragged."""
        if not self._admitted(self.headers.get("X-Token", "")):
            return
        if self.path != "/curves":
            self._fail(HTTPStatus.NOT_FOUND, "no such address")
            return
        if self.headers.get("Content-Type", "").partition(";")[0].strip().lower() != "application/json":
            self._fail(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "application/json expected")
            return
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit()) or "Transfer-Encoding" in self.headers:
            self._fail(HTTPStatus.LENGTH_REQUIRED, "Content-Length expected")
            return
        if len(length) > len(str(MAX_BODY)) or int(length) > MAX_BODY:
            self._fail(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"at most {MAX_BODY} bytes expected")
            return
        try:
            found = answer(parse(self.rfile.read(int(length))))
        except StiefelError as error:
            self._fail(HTTPStatus.BAD_REQUEST, message(error))
            return
        self._send(HTTPStatus.OK, json.dumps(found, allow_nan=False).encode(), "application/json")


class Server(ThreadingHTTPServer):
    """The server; `url` is the address of its page, token included.

    Raises
    ------
    OSError
        The port cannot be used.
    """

    daemon_threads = True
    # Connections that may wait to be accepted. With `socketserver`'s 5, 2 of 16 were reset on a busy machine.
    request_queue_size = 128

    def __init__(self, kind: str, port: int = 0) -> None:
        self.token = secrets.token_urlsafe(24)
        self.page = page.served(kind).encode()
        try:
            super().__init__((ADDRESS, port), _Handler)
        except OSError as error:
            raise OSError(error.errno, error.strerror, f"port {port}") from error

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://{ADDRESS}:{self.server_port}/?token={self.token}"

    def server_bind(self) -> None:
        """Bind without asking for the machine's name, which may wait for a name server."""
        TCPServer.server_bind(self)
        self.server_name, self.server_port = ADDRESS, int(self.server_address[1])

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Keep quiet about browsers that close their connections, and about nothing else."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)
