"""Ctrl-C, and requests of the system to end.

    until a command begins       the process ends at once: nothing is open yet (`__main__`)
    in a command                 it ends at once, and what is half made is taken back (`end_here`)
    in the loop of a command     a flag is set, which the loop reads (`asked_to_end`)
    in `interrupts_waiting`      nothing; at the end of it what would have happened before

No handler throws. Whatever an exception would meet could lose it or take it for a fault of its own:
an import, a fork, an object that goes, a library that catches everything.
"""

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any

from beamcam.system import stop_signals

INTERRUPTED = 130  #: exit status after Ctrl-C, as shells have it
LOOK_S = 0.1  #: between two looks at the flag

_half_made: list[Callable[[], object]] = []


class Asked:
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


NEVER = Asked()  #: for work that is not interrupted


@contextmanager
def asked_to_end() -> Iterator[Asked]:
    """The flag that Ctrl-C and the system set meanwhile, where they are not ignored."""
    asked = Asked()
    with _handled({n: asked.hear for n in _numbers() if signal.getsignal(n) != signal.SIG_IGN}):
        yield asked


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
    return (signal.SIGINT, *stop_signals())


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
