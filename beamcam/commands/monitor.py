"""`beamcam monitor`: the axes of a controller in a page, while they move."""

import ipaddress
import socket
import threading
from collections.abc import Callable, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from time import monotonic
from typing import Any

import click
from msgspec.structs import replace

from beamcam.commands import options
from beamcam.commands.common import Console
from beamcam.commands.jobs import read_program
from beamcam.commands.parts import input_bytes
from beamcam.commands.settings import machines_of_stock, settled
from beamcam.commands.value_types import MODBUS_PORT, Number, address
from beamcam.errors import Source, VerifyError
from beamcam.machine.machine import Machine
from beamcam.model.request import stock_of
from beamcam.pipeline import parts_of, read_file
from beamcam.system import INTERRUPTED, LOOK_S, asked_to_end

# --- page server for this computer: who may ask, how many at once, and for how long ---------------

MOST_CALLERS = 16  #: at once, a thread each; a page has one or two
ANSWERED_S = 5.0  #: that a caller may take for question and answer
LOOPBACK_NAMES = ("localhost", "127.0.0.1", "[::1]")
REFUSED_HOST = 421  #: HTTP: Misdirected Request

#: What stands at a path: its kind, and what gives its content now.
Pages = Mapping[str, tuple[str, Callable[[], bytes]]]


class Handler(BaseHTTPRequestHandler):
    """Answers a caller of a `PageServer`."""

    timeout = ANSWERED_S  #: of each wait for the caller
    server: "PageServer"

    def do_GET(self) -> None:
        if not is_own_host(self.headers["Host"], self.server.bound, self.server.server_port):
            self.send_error(REFUSED_HOST, "Another host is named")
            return
        if self.path not in self.server.pages:
            self.send_error(404)
            return
        kind, content = self.server.pages[self.path]
        body = content()
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        pass  # a reading each tenth of a second would hide what is said


class PageServer(ThreadingHTTPServer):
    """Answers GET for some paths; others, and hosts that are not its own, get an error.

    A page of the internet that has its name resolve to this computer would have its own name for a
    host, which is refused. Raises OSError where the address cannot be had.
    """

    daemon_threads = True

    def __init__(self, address: tuple[str, int], pages: Pages) -> None:
        self.callers: dict[Any, float] = {}  #: connection -> when it came
        self._lock = threading.Lock()
        self.pages, self.bound = pages, address[0]
        super().__init__(address, Handler)

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
        """End callers who take too long; a letter a second would keep a thread for good."""
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


@click.command("monitor")
@click.argument("host", metavar="HOST[:PORT]", callback=address(MODBUS_PORT))
@options.machine
@options.config
@click.option(
    "--part", "parts", type=options.FILE, multiple=True,
    help="A part that is worked, for its section; may be repeated, as the parts lie on the bar.",
)  # fmt: skip
@click.option(
    "--program", type=options.FILE,
    help="Program that the controller runs: its parts or its path, and the block are shown.",
)  # fmt: skip
@click.option(
    "--page", callback=address(), metavar="HOST:PORT", default="127.0.0.1:8020", show_default=True,
    help="Address of the page; by default only for this computer.",
)  # fmt: skip
@click.option(
    "--every", type=Number(least=0.02, most=60), default=0.1, show_default=True,
    help="Polling interval in seconds.",
)  # fmt: skip
@options.json_messages
@options.verbosity
def command(
    host: tuple[str, int], parts: tuple[str, ...], program: str | None,
    page: tuple[str, int], every: float, as_json: bool, console: Console, **values: Any,
) -> None:  # fmt: skip
    """Read a controller's axes over Modbus TCP and draw them in a page, until Ctrl-C.

    The table `[modbus]` of the machine file says which register holds which axis. Nothing is
    written to the controller. The section of the bar is that of --part or of --program.
    Exit status: 130 after Ctrl-C, 1 if there is no controller.

    \b
    beamcam monitor 192.168.0.10 --machine beamline
    beamcam monitor 192.168.0.10 --program job.gcode
    beamcam monitor 127.0.0.1:5020 --page 127.0.0.1:8021 --every 0.05
    """
    from beamcam.setup_sheet.study_page import KnownWork, axes_of, monitor_page
    from beamcam.simulation import PORT

    config = settled(values, ())
    laid, _ = parts_of(map(read_file, parts))
    if program is not None:
        read = read_program(input_bytes(program), program, config)
        machine, work = read.machine, KnownWork(program=replace(read, parts=laid))
    else:
        machine = machines_of_stock(config, "beam", "")[0]
        work = KnownWork(laid[0].profile if laid else None)
    if laid and stock_of(laid) != machine.stock:
        raise click.UsageError(f"Found {parts[0]!r}; expected a part for {machine.name}.")
    reader = Reader(host, machine, len(axes_of(machine)), every)
    reader.read_first()
    html = monitor_page(machine, every, f"{host[0]}:{host[1]}", work).encode("utf-8")
    try:
        server = PageServer(page, {
            "/": ("text/html; charset=utf-8", lambda: html),
            "/axes": ("application/json", reader.as_json),
        })  # fmt: skip
    except OSError as error:
        place = Source(f"{page[0]}:{page[1]}")
        raise VerifyError(PORT.at(place, found=error.strerror or error)) from error
    at = f"http://{page[0]}:{server.server_port}/"
    console.tell(f"{machine.name} at {host[0]}:{host[1]} is drawn in {at}; Ctrl-C ends it")
    threading.Thread(target=reader.run, daemon=True).start()
    server.timeout = LOOK_S
    with server, asked_to_end() as interrupted:
        while not interrupted:
            server.handle_request()
            server.end_slow()
    raise SystemExit(INTERRUPTED)


class Reader:
    """Polls the positions of a controller; a lost connection is retried."""

    def __init__(self, host: tuple[str, int], machine: Machine, axes: int, every_s: float) -> None:
        self._host, self._machine, self._axes, self._every_s = host, machine, axes, every_s
        self._said: dict[str, Any] = {"reads": 0, "fault": ""}

    def _client(self) -> Any:
        from beamcam.simulation import CONTROLLER
        from beamcam.simulation.modbus import Client

        return Client(*self._host, CONTROLLER)

    def read_first(self) -> None:
        """Raises VerifyError where there is no controller, or not such registers."""
        with self._client() as client:
            self._read(client)

    def run(self) -> None:
        """Read until the process ends."""
        pause = threading.Event()
        while True:
            try:
                with self._client() as client:
                    while not pause.wait(self._every_s):
                        self._read(client)
            except VerifyError as error:
                self._said = self._said | {"fault": error.diagnostics[0].message}
                pause.wait(max(self._every_s, 0.5))

    def _read(self, client: Any) -> None:
        from msgspec.structs import asdict

        from beamcam.simulation.modbus import axes_shown

        now = axes_shown(client, self._machine.modbus, self._axes)
        reads = self._said["reads"] + 1
        self._said = {
            "positions": now.positions, "state": asdict(now.state), "line": now.line,
            "reads": reads, "fault": "",
        }  # fmt: skip

    def as_json(self) -> bytes:
        """The last reading."""
        import msgspec

        return msgspec.json.encode(self._said)
