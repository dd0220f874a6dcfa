"""The server of a page for this computer: who may ask, how many at once, and for how long."""

import ipaddress
import socket
import threading
from collections.abc import Callable, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from time import monotonic
from typing import Any

MOST_CALLERS = 16  #: at once, a thread each; a page has one or two
ANSWERED_S = 5.0  #: that a caller may take for question and answer
LOOPBACK_NAMES = ("localhost", "127.0.0.1", "[::1]")
REFUSED_HOST = 421  #: HTTP: Misdirected Request

#: What stands at a path: its kind, and what gives its content now.
Pages = Mapping[str, tuple[str, Callable[[], bytes]]]


class PageServer(ThreadingHTTPServer):
    """Answers GET for some paths; others, and hosts that are not its own, get an error.

    A page of the internet that has its name resolve to this computer would have its own name for a
    host, which is refused. Raises OSError where the address cannot be had.
    """

    daemon_threads = True

    def __init__(self, address: tuple[str, int], pages: Pages) -> None:
        self.callers: dict[Any, float] = {}  #: connection -> when it came
        self._lock = threading.Lock()
        super().__init__(address, _handler(pages, address[0]))

    def process_request(self, request: Any, client_address: Any) -> None:
        """A thread for the caller; one too many is turned away, one that is slow ended."""
        self.end_slow()
        with self._lock:
            is_welcome = len(self.callers) < MOST_CALLERS
            if is_welcome:
                self.callers[request] = monotonic()
        if is_welcome:
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def shutdown_request(self, request: Any) -> None:
        """The end of a caller's connection."""
        with self._lock:
            self.callers.pop(request, None)
        super().shutdown_request(request)

    def service_actions(self) -> None:
        """What is to be done now and then."""
        self.end_slow()

    def end_slow(self) -> None:
        """End callers who take too long; a letter a second would keep a thread for ever."""
        with self._lock:
            slow = [r for r, since in self.callers.items() if monotonic() - since > ANSWERED_S]
        for request in slow:
            try:
                request.shutdown(socket.SHUT_RDWR)
            except OSError:
                continue  # it has ended meanwhile

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A caller who is gone is nothing to tell."""


def is_own_host(named: str | None, bound: str, port: int) -> bool:
    """Whether the host that a caller names is this server.

    One that is bound to loopback has the names of loopback; one that is bound to all interfaces has
    their addresses and the computer's name.
    """
    host, colon, at = (named or "").rpartition(":")
    if not colon or at.endswith("]"):
        host, at = named or "", "80"  # the port that a browser leaves out
    host = host.lower().rstrip(".")
    if at != str(port):
        return False
    if host == bound.lower():
        return True
    try:
        address = ipaddress.ip_address(bound or "0.0.0.0")
    except ValueError:
        return False
    if address.is_loopback:
        return host in LOOPBACK_NAMES
    if not address.is_unspecified:
        return False
    try:
        ipaddress.ip_address(host.strip("[]"))
    except ValueError:
        return host in ("localhost", socket.gethostname().lower(), socket.getfqdn().lower())
    return True


def _handler(pages: Pages, bound: str) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        timeout = ANSWERED_S  #: of each wait for the caller
        server: PageServer

        def do_GET(self) -> None:
            if not is_own_host(self.headers["Host"], bound, self.server.server_port):
                self.send_error(REFUSED_HOST, "Another host is named")
                return
            if self.path not in pages:
                self.send_error(404)
                return
            kind, content = pages[self.path]
            body = content()
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None:
            pass  # a reading each tenth of a second would hide what is said

    return Handler
