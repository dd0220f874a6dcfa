"""Calls of one function in worker processes of this machine; one that dies is replaced.

    pool.submit(task) -> ProcessPoolExecutor -> work(task) in a worker -> pool.wait()

A worker that dies, as a geometry kernel can, takes the whole executor with it, and none can tell at
which task. So each task that was lost beside others is tried again, one by one; who then kills a
worker by itself has `Died`.
"""

import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait as wait_for
from os import _exit as end_at_once
from typing import Any, Generic, TypeVar

from msgspec import Struct

from beamcam.system import LOOK_S, interrupts_waiting, max_workers, start_method

Given = TypeVar("Given")
Made = TypeVar("Made")

_work: list[Callable[[Any], Any]] = []  #: what this process does, if it is a worker


class Died(Struct, frozen=True):
    """In place of what would have been made: a worker died at it that had nothing else to do."""


class Pool(Generic[Given, Made]):
    """Workers that are started when there is something to do."""

    PER_WORKER = 2  #: tasks that each worker has at most, so that it finds the next one at once

    def __init__(
        self, work: Callable[[Given], Made], workers: int,
        begin: Callable[[], object] | None = None, most_s: float = 0.0,
    ) -> None:  # fmt: skip
        """Each worker calls `begin` once, and `work` for each task.

        One that takes more than `most_s` of the processor for a task, where that is above 0, dies:
        a library that never comes back hears of nothing else.
        A forked worker has both as they are here. One that is started afresh gets them pickled.
        """
        self.at_once = max_workers(workers)
        self._begun_with = (work, begin, most_s)
        self._executor: ProcessPoolExecutor | None = None
        self._given: dict[Future[Made], Given] = {}
        self._again: deque[Given] = deque()  #: lost with a worker
        self._is_alone = False  #: a task that was lost is under way, and no other

    def has_room(self) -> bool:
        """Whether another task may be submitted now."""
        return (
            not (self._is_alone or self._again)
            and len(self._given) < self.at_once * self.PER_WORKER
        )

    def submit(self, given: Given) -> None:
        """Hand over a task; there has to be room."""
        try:
            self._hand_over(given, self.at_once)
        except BrokenProcessPool:
            self._again.append(given)  # what it was lost with is seen by `wait`

    def wait(self) -> Iterator[tuple[Given, Made | Died]]:
        """What is done, or nothing after a moment; there has to be something under way.

        Nothing comes either where a worker died. Raises what `work` raised.
        """
        if not self._given:
            self.close()
            self._hand_over(self._again.popleft(), 1)
            self._is_alone = True
        certain = self._is_alone or (self.at_once == 1 and len(self._given) == 1)
        done = wait(self._given, LOOK_S, FIRST_COMPLETED).done
        if any(isinstance(future.exception(), BrokenProcessPool) for future in done):
            done = wait(self._given).done
            self.close()
        for future in [f for f in self._given if f in done]:
            given = self._given.pop(future)
            if not isinstance(future.exception(), BrokenProcessPool):
                yield given, future.result()
            elif certain:
                yield given, Died()
            else:
                self._again.append(given)
        if self._is_alone and not self._given:
            self._is_alone = False
            self.close()

    def done(self) -> bool:
        """Whether `wait` would give something at once."""
        return bool(self._again) or any(future.done() for future in self._given)

    def withdraw(self) -> list[Given]:
        """The tasks that no worker has begun, or that were lost with one; none does them now."""
        cancelled = [future for future in self._given if future.cancel()]
        withdrawn = [*self._again, *map(self._given.pop, cancelled)]
        self._again.clear()
        return withdrawn

    def close(self) -> None:
        """End the workers, whatever is under way: they leave nothing half done."""
        executor, self._executor = self._executor, None
        if executor is None:
            return
        for process in tuple((executor._processes or {}).values()):  # kill_workers of Python 3.14
            process.kill()
        executor.shutdown(cancel_futures=True)

    def _hand_over(self, given: Given, workers: int) -> None:
        """Submit a task, to so many workers if none is there. Raises BrokenProcessPool."""
        # It starts processes: what hears of a fork swallows exceptions, and an executor that is
        # half started cannot be ended. Who calls this from Python has a handler that throws.
        with interrupts_waiting():
            if self._executor is None:
                method = get_context(start_method())
                self._executor = ProcessPoolExecutor(workers, method, _begin, self._begun_with)
            self._given[self._executor.submit(_call, given)] = given


def _begin(work: Callable[[Any], Any], begin: Callable[[], object] | None, most_s: float) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that started it
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _work[:] = [_timed(work, most_s) if most_s and hasattr(signal, "setitimer") else work]
    if begin is not None:
        begin()


def _timed(work: Callable[[Any], Any], most_s: float) -> Callable[[Any], Any]:
    def timed(given: Any) -> Any:
        signal.setitimer(signal.ITIMER_PROF, most_s)
        try:
            return work(given)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)

    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    return timed


def _end_with_parent() -> None:
    """A killed process closes nothing, and its workers would wait for good."""
    parent = parent_process()
    if parent is not None:
        wait_for([parent.sentinel])
        end_at_once(1)


def _call(given: Any) -> Any:
    return _work[0](given)
