"""Workers that are processes of this machine.

    this process                          worker 1, worker 2, ...
      submit(chunk) ----- pipe ----> queue -> make_all -> results
      wait() <----------- pipe ---------------------------'

Each worker has up to two chunks, so that it finds the next one when it is done with the first. A
worker that dies loses its chunks: the first of them is suspected, since workers keep the order,
and the second is innocent.
"""

import contextlib
import gc
import signal
import threading
from collections import deque
from collections.abc import Iterator, Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

from msgspec import Struct, field

from beamcam.batch.pool import Chunk, Result
from beamcam.batch.work import Made, Shop, make_all, thaw
from beamcam.collector import collector_seldom
from beamcam.system import max_workers, start_method

if TYPE_CHECKING:  # Windows has no such name
    from multiprocessing.context import ForkContext, SpawnContext


class _Worker(Struct):
    process: BaseProcess
    tasks: "Connection[Chunk, None]"
    results: "Connection[None, list[Made]]"
    chunks: deque[Chunk] = field(default_factory=deque)


class Processes:
    """Work in processes of this machine, started as they are needed."""

    PER_WORKER = 2  #: chunks that each worker has at most

    def __init__(self, shop: Shop, jobs: int) -> None:
        self.at_once = max_workers(jobs)
        self._frozen = shop.freeze
        self._workers: list[_Worker] = []
        self._context: ForkContext | SpawnContext = (
            get_context("fork") if start_method() == "fork" else get_context("spawn")
        )

    def has_room(self) -> bool:
        return sum(len(w.chunks) for w in self._workers) < self.at_once * self.PER_WORKER

    def submit(self, chunk: Chunk) -> None:
        worker = min(self._workers, key=lambda w: len(w.chunks), default=None)
        if worker is None or (worker.chunks and len(self._workers) < self.at_once):
            worker = self._start()
            self._workers.append(worker)
        worker.chunks.append(chunk)
        # A worker that is dead already is seen by `wait`, which knows its chunks.
        with contextlib.suppress(OSError):
            worker.tasks.send(chunk)

    def wait(self) -> Iterator[Result]:
        ready = wait([w.results for w in self._workers if w.chunks])
        for worker in [w for w in self._workers if w.results in ready]:
            try:
                made = worker.results.recv()
            except (EOFError, OSError):
                self._workers.remove(worker)
                self._bury(worker)
                for number, chunk in enumerate(worker.chunks):
                    yield Result(chunk, "lost" if number else "suspected")
            else:
                yield Result(worker.chunks.popleft(), "made", made)

    def close(self) -> None:
        for worker in self._workers:
            worker.process.kill()  # it holds nothing that could be left half done
        for worker in self._workers:
            self._bury(worker)
        self._workers.clear()

    def _start(self) -> _Worker:
        their_tasks, tasks = self._context.Pipe(duplex=False)
        results, their_results = self._context.Pipe(duplex=False)
        # A forked worker has a copy of every end that is open here. It has to close them, or it
        # would keep the others, and itself, from seeing that this process is gone.
        ours: tuple[Connection[Any, Any], ...] = ()
        if self._context.get_start_method() == "fork":
            ours = (tasks, results, *(end for w in self._workers for end in (w.tasks, w.results)))
        process = self._context.Process(
            target=serve, args=(their_tasks, their_results, self._frozen, ours), daemon=True
        )
        process.start()
        # With this end closed here the worker's death is the end of the pipe.
        their_tasks.close()
        their_results.close()
        return _Worker(process, tasks, results)

    @staticmethod
    def _bury(worker: _Worker) -> None:
        worker.tasks.close()
        worker.results.close()
        worker.process.join()
        worker.process.close()


def serve(
    tasks: "Connection[None, Chunk]",
    results: "Connection[list[Made], None]",
    frozen: bytes,
    others: "Sequence[Connection[Any, Any]]" = (),
) -> None:
    """What a worker does until the other end of its pipe is closed, or its process gone.

    `others` are ends of pipes that it has by no will of its own.
    """
    for end in others:
        end.close()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that started it
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    shop = thaw(frozen)
    gc.freeze()  # what is there now stays, and need not be looked through again and again
    collector_seldom()
    queue: SimpleQueue[Chunk | None] = SimpleQueue()
    threading.Thread(target=_receive, args=(tasks, queue), daemon=True).start()
    with contextlib.suppress(BrokenPipeError, ConnectionResetError):
        while (chunk := queue.get()) is not None:
            results.send(make_all(chunk, shop))


def _receive(tasks: "Connection[None, Chunk]", queue: "SimpleQueue[Chunk | None]") -> None:
    """Take chunks as they come, so that the other side never waits for this one to read."""
    with contextlib.suppress(EOFError, OSError):
        while True:
            queue.put(tasks.recv())
    queue.put(None)
