"""Differences between Windows, macOS and Linux, and what a process of beamcam itself sets."""

import atexit
import errno
import gc
import os
import signal
import stat
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any, Literal

BINARY = getattr(os, "O_BINARY", 0)  #: without it Windows writes "\r\n" for "\n"

#: How a file is opened to be read: a pipe without a writer is not waited for.
_TO_READ = os.O_RDONLY | BINARY | getattr(os, "O_NONBLOCK", 0)

#: Waiting for more than 63 things at once is an error of Windows; the pipe of a worker is one.
MAX_WORKERS_WINDOWS = 60

#: A scanner for viruses holds a new file for some hundred milliseconds.
REPLACE_TRIES = 20
REPLACE_WAIT_S = 0.05

_RESERVED = frozenset(
    {"CON", "PRN", "AUX", "NUL", *(f"{port}{n}" for port in ("COM", "LPT") for n in range(1, 10))}
)


def is_windows() -> bool:
    return os.name == "nt"


def is_unicode(encoding: str | None) -> bool:
    """Whether a stream takes every character; pipes of Windows have the alphabet of a region."""
    return (encoding or "").lower().replace("-", "").startswith("utf")


def user_folder() -> str:
    """Folder of a user's own configuration and machines."""
    if is_windows():
        return os.path.join(os.environ.get("APPDATA") or os.path.expanduser("~"), "beamcam")
    # XDG Base Directory Specification: a relative path counts as none.
    folder = os.environ.get("XDG_CONFIG_HOME", "")
    if not os.path.isabs(folder):
        folder = os.path.join(os.path.expanduser("~"), ".config")
    return os.path.join(folder, "beamcam")


def is_open_to_all(folder: str) -> bool:
    """Whether any user may put files into a folder, as into /tmp; Windows says that otherwise."""
    return not is_windows() and bool(os.stat(folder).st_mode & stat.S_IWOTH)


def is_ones_own(file: str) -> bool:
    """Whether a file belongs to the user, or to the owner of the system."""
    return is_windows() or os.stat(file).st_uid in (os.getuid(), 0)


class NotAFile(OSError):
    """A pipe or a device: it may have no end, or none that comes."""


def open_file(path: str | os.PathLike[str]) -> int:
    """A plain file, open to be read. Raises OSError, NotAFile for a pipe or a device."""
    try:
        file = os.open(path, _TO_READ)
    except BlockingIOError:  # a file server has a lease on it, as is only had on plain files
        file = os.open(path, os.O_RDONLY | BINARY)
    mode = os.fstat(file).st_mode
    if stat.S_ISREG(mode):
        return file
    os.close(file)
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
    raise NotAFile(errno.EINVAL, "a pipe or a device", os.fspath(path))


def beginning_of(path: str | os.PathLike[str], most: int) -> bytes:
    """The first `most` bytes of a plain file. Raises OSError as `open_file` does."""
    with os.fdopen(open_file(path), "rb") as file:
        return file.read(most)


def start_method() -> Literal["fork", "spawn"]:
    """Start method of worker processes: fork where that is safe, else spawn."""
    return "fork" if sys.platform == "linux" else "spawn"


def cores() -> int:
    """Number of cores that this process may use."""
    allowed: Callable[[int], set[int]] | None = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed is not None else os.cpu_count() or 1


def max_workers(count: int) -> int:
    """As many of the workers as one process can wait for."""
    return min(count, MAX_WORKERS_WINDOWS) if is_windows() else count


def replace_file(part: str, target: str) -> None:
    """`os.replace`; Windows refuses while anybody reads the target, which is tried again then."""
    for left in range(REPLACE_TRIES if is_windows() else 1, 0, -1):
        try:
            os.replace(part, target)
        except PermissionError:
            if left == 1:
                raise
            time.sleep(REPLACE_WAIT_S)
        else:
            return


def is_reader_gone(error: OSError) -> bool:
    """Whether the reader of a pipe is gone, which Windows reports as an invalid argument."""
    return is_windows() and error.errno == errno.EINVAL


def can_sync_all() -> bool:
    """Whether all that was written can be brought to the disk at once; else file by file."""
    return hasattr(os, "sync")


def free_of_devices(name: str) -> str:
    """A file's name, with `_` behind one that is a device of Windows in every folder."""
    stem, dot, rest = name.partition(".")
    return f"{stem}_{dot}{rest}" if stem.strip().upper() in _RESERVED else name


def portable_path(name: str) -> str:
    """A path as this system writes it: one that only Windows knows has / in place of the other."""
    if is_windows() or "\\" not in name or os.path.exists(name):
        return name
    return name.replace("\\", "/")


#: Thresholds of the cyclic garbage collector in a lasting process: cycles are rare, and a
#: drawing of 20,000 curves has fewer objects than the first.
SELDOM = (500_000, 20, 100)


def collector_seldom() -> None:
    """Run the cyclic garbage collector seldom in this process, and not at its end.

    Python's own measure would have it search ten times while a command is loaded, and over all that
    was ever loaded when it is done: a fifth of the time of one post.
    """
    gc.set_threshold(*SELDOM)
    atexit.unregister(gc.freeze)  # a command may be called twice in one process
    atexit.register(gc.freeze)


def one_thread() -> None:
    """Have numpy's library of matrices, where it is not loaded yet, start no threads of its own.

    It starts one a core as it is imported, a fifth of the time of that import, and no matrix here
    is large enough for two.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


# --- interrupts -----------------------------------------------------------------------------------

# Ctrl-C, and requests of the system to end.
#
#     until a command begins       the process ends at once: nothing is open yet (`__main__`)
#     in a command                 it ends at once, and what is half made is taken back (`end_here`)
#     in the loop of a command     a flag is set, which the loop reads (`asked_to_end`)
#     in `interrupts_waiting`      nothing; at the end of it what would have happened before
#
# No handler throws. Whatever an exception would meet could lose it or take it for a fault of its
# own: an import, a fork, an object that goes, a library that catches everything.

INTERRUPTED = 130  #: exit status after Ctrl-C, as shells have it
LOOK_S = 0.1  #: between two looks at the flag

_half_made: list[Callable[[], object]] = []


class EndRequest:
    """Whether a run is asked to end."""

    def __init__(self) -> None:
        self._is_asked = False

    def __bool__(self) -> bool:
        return self._is_asked

    def hear(self, *_: object) -> None:
        """Set the flag, as a handler of signals; who asks again does not wait for the loop."""
        if self._is_asked:
            end_here()
        self._is_asked = True

    def wait(self, seconds: float) -> None:
        """Wait so long, or until the run is asked to end."""
        while seconds > 0 and not self:
            time.sleep(min(seconds, LOOK_S))
            seconds -= LOOK_S


NEVER = EndRequest()  #: for work that is not interrupted


@contextmanager
def asked_to_end() -> Iterator[EndRequest]:
    """The flag that Ctrl-C and the system set meanwhile, where they are not ignored."""
    interrupt = EndRequest()
    with _handled({n: interrupt.hear for n in _numbers() if signal.getsignal(n) != signal.SIG_IGN}):
        yield interrupt


@contextmanager
def interrupts_waiting() -> Iterator[None]:
    """An interrupt meanwhile does what it does at the end."""
    heard: list[int] = []
    own = (number for number in _numbers() if callable(signal.getsignal(number)))
    try:
        with _handled({number: lambda number, _: heard.append(number) for number in own}):
            yield
    finally:
        for number in heard:
            signal.raise_signal(number)


@contextmanager
def taken_back(undo: Callable[[], object]) -> Iterator[None]:
    """Have `undo` called if an interrupt ends the process meanwhile; it may raise OSError."""
    _half_made.append(undo)
    try:
        yield
    finally:
        _half_made.remove(undo)


def end_here(*_: object) -> None:
    """End the process and its workers, as a handler of signals."""
    workers: Any = sys.modules.get("multiprocessing")
    with suppress(Exception):  # one that ends by itself meanwhile is none to be ended
        for worker in workers.active_children() if workers is not None else ():
            worker.kill()
    for undo in reversed(_half_made):
        with suppress(OSError):
            undo()
    os._exit(INTERRUPTED)


def _numbers() -> tuple[int, ...]:
    """The signals that are heard here; only the main thread hears of any."""
    if threading.current_thread() is not threading.main_thread():
        return ()
    names = ("SIGINT", "SIGTERM", "SIGBREAK")  # Ctrl-Break and the end of a session, of Windows
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


@contextmanager
def _handled(handlers: Mapping[int, Callable[..., object]]) -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in handlers}
    try:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)
