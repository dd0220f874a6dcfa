"""The server of a page: hosts of its own only, a bound on callers, and none that stays."""

import http.client
import socket
import threading
from collections.abc import Iterator

import pytest

from beamcam.commands import monitor
from beamcam.commands.monitor import MOST_CALLERS, PageServer, is_own_host
from tests.runs import wait_until

LOOPBACK = "127.0.0.1"


@pytest.fixture
def server() -> Iterator[PageServer]:
    with PageServer((LOOPBACK, 0), {"/": ("text/plain", lambda: b"here")}) as made:
        thread = threading.Thread(target=made.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        yield made
        made.shutdown()
    thread.join(5)


def asked(server: PageServer, path: str = "/", host: str | None = None) -> tuple[int, bytes]:
    caller = http.client.HTTPConnection(LOOPBACK, server.server_port, timeout=5)
    caller.putrequest("GET", path, skip_host=host is not None)
    if host:
        caller.putheader("Host", host)
    caller.endheaders()
    answer = caller.getresponse()
    found = answer.status, answer.read()
    caller.close()
    return found


def test_only_its_own_hosts_are_answered(server: PageServer) -> None:
    assert asked(server) == (200, b"here")
    assert asked(server, host=f"localhost:{server.server_port}") == (200, b"here")
    assert asked(server, "/etc/passwd")[0] == 404
    for host in ("", "evil.example", f"evil.example:{server.server_port}", f"{LOOPBACK}:1",
                 f"localhost.evil.example:{server.server_port}"):  # fmt: skip
        status, body = asked(server, host=host)
        assert (status, b"here" in body) == (421, False), host


@pytest.mark.parametrize(
    ("named", "bound", "own"),
    [
        ("127.0.0.1:80", "127.0.0.1", True), ("127.0.0.1", "127.0.0.1", True),
        ("[::1]", "127.0.0.1", True), ("LOCALHOST.", "localhost", True),
        ("hall-1", "hall-1", True), ("hall-2", "hall-1", False), ("hall-1:81", "hall-1", False),
        ("192.168.0.5", "0.0.0.0", True), ("[fe80::1]", "0.0.0.0", True),
        (socket.gethostname(), "0.0.0.0", True), ("evil.example", "0.0.0.0", False),
        ("192.168.0.5", "192.168.0.5", True), ("localhost", "192.168.0.5", False),
        (None, "127.0.0.1", False), ("", "0.0.0.0", False), ("a:b:c", "0.0.0.0", False),
    ],
)  # fmt: skip
def test_hosts(named: str | None, bound: str, own: bool) -> None:
    assert is_own_host(named, bound, 80) is own


def test_callers_who_say_nothing_are_few_and_soon_ended(
    server: PageServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(monitor, "ANSWERED_S", 1000.0)
    silent = []
    for wanted in range(1, MOST_CALLERS + 1):
        silent.append(socket.create_connection((LOOPBACK, server.server_port), 5))
        silent[-1].sendall(b"GET / HTTP/1.1\r\n")
        wait_until(lambda wanted=wanted: len(server.callers) == wanted)  # type: ignore[misc]
    assert not is_answered(server)  # one too many
    assert len(server.callers) == MOST_CALLERS
    monkeypatch.setattr(monitor, "ANSWERED_S", 0.0)
    wait_until(lambda: not server.callers)
    monkeypatch.setattr(monitor, "ANSWERED_S", 1000.0)
    assert is_answered(server)
    for caller in silent:
        caller.close()


def is_answered(server: PageServer) -> bool:
    try:
        return asked(server) == (200, b"here")
    except (OSError, http.client.HTTPException):
        return False


def test_a_caller_who_drips_is_ended(server: PageServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(monitor, "ANSWERED_S", 0.3)
    with socket.create_connection((LOOPBACK, server.server_port), 5) as caller:
        wait_until(lambda: is_ended(caller))


def is_ended(caller: socket.socket) -> bool:
    """Whether a letter more cannot be sent."""
    try:
        caller.sendall(b"G")
    except OSError:
        return True
    return False
