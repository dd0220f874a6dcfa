"""Workers: chunks of files in, results out, in any order.

`Here` is this process, `Processes` are others of this machine; those of other machines are in
`cluster`, which is loaded where they are named.
"""

import gc
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import islice
from typing import Protocol

from beamcam.batch import DIED
from beamcam.batch.work import BatchSettings, FileResult, Task, make_all, row_of, thaw
from beamcam.errors import Source
from beamcam.processes import Died, Pool
from beamcam.system import EndRequest, collector_seldom

Chunk = tuple[Task, ...]
CHUNK_BYTES = 256 * 1024  #: a chunk of more is closed
CHUNK_FILES = 16  #: most files that a process of this machine gets at once

#: What became of a chunk: results, that a worker died at it, or None where it was lost with a
#: worker through no fault of its own.
Outcome = tuple[Chunk, Sequence[FileResult] | Died | None]


class Workers(Protocol):
    """What does the work: this process, others, or a cluster."""

    @property
    def at_once(self) -> int:
        """Number of files in work at one time, so that chunks are not too large."""

    @property
    def most_files(self) -> int:
        """Number of files that a chunk has at most."""

    def has_room(self) -> bool:
        """Whether another chunk may be submitted now."""

    def submit(self, chunk: Chunk) -> None:
        """Hand over a chunk; there has to be room."""

    def wait(self) -> Iterator[Outcome]:
        """What is done, or nothing after a moment; there has to be something under way."""

    def close(self) -> None:
        """End the work, whatever is under way."""


class Here:
    """Work in this process, at once."""

    at_once = 1
    most_files = CHUNK_FILES

    def __init__(self, settings: BatchSettings) -> None:
        self._settings = settings
        self._done: Outcome | None = None

    def has_room(self) -> bool:
        return self._done is None

    def submit(self, chunk: Chunk) -> None:
        self._done = chunk, make_all(chunk, self._settings)

    def wait(self) -> Iterator[Outcome]:
        if self._done is not None:
            done, self._done = self._done, None
            yield done

    def close(self) -> None:
        self._done = None


def driven(workers: Workers, tasks: Iterator[Task], interrupt: EndRequest) -> Iterator[FileResult]:
    """The result of each task, in any order; nothing more once `interrupt` asks for the end."""
    again: deque[Chunk] = deque()
    away, is_left = 0, True
    while not interrupt:
        while workers.has_room() and (again or is_left):
            chunk = again.popleft() if again else ()
            if not chunk:
                size = 0
                for task in islice(tasks, workers.most_files):
                    chunk, size = (*chunk, task), size + len(task.data)
                    if size >= CHUNK_BYTES:
                        break
            if not chunk:
                is_left = False
                break
            workers.submit(chunk)
            away += 1
        if not away:
            return
        for outcome in workers.wait():
            away -= 1
            yield from results_of(outcome, again)


def results_of(outcome: Outcome, again: deque[Chunk]) -> Iterator[FileResult]:
    """The results of a chunk; what has to be submitted again is added to `again`.

    Of a chunk at which a worker died each file is tried alone.
    """
    chunk, made = outcome
    if made is None:
        again.append(chunk)
    elif not isinstance(made, Died):
        yield from made
    elif len(chunk) > 1:
        again.extend((task,) for task in chunk)
    else:
        (task,) = chunk
        yield FileResult(task.index, row_of(task.name, "failed", DIED.at(Source(task.name))))


def begin_there(frozen: bytes) -> None:
    """Thaw the shop in a worker, which then makes chunks of files."""
    thaw(frozen)
    gc.freeze()  # what is there now stays, and need not be looked through again and again
    collector_seldom()


def make_there(frozen: bytes, chunk: Chunk) -> list[FileResult]:
    """`make_all` in a worker, by the shop that was frozen on its way there."""
    return make_all(chunk, thaw(frozen))


class Processes(Pool[Chunk, list[FileResult]]):
    """Work in processes of this machine, started as they are needed."""

    most_files = CHUNK_FILES

    def __init__(self, settings: BatchSettings, jobs: int) -> None:
        frozen = settings.freeze
        super().__init__(partial(make_there, frozen), jobs, partial(begin_there, frozen))


# --- head start -----------------------------------------------------------------------------------

# The first files of a batch, made here until a cluster has answered.
#
#     submit -> a process here -> wait
#                  | connected: what it has not begun goes back to be submitted again
#     submit -> the cluster ----> wait
#
# Importing Dask and asking its workers takes as long as making a hundred files. No result is given
# before the cluster has answered: one that cannot be worked with refuses the batch before a file is
# written.


MOST_FILES = 256  #: that are handed to the process here
MOST_BYTES = 256 * 1024  #: of a chunk for it; larger inputs wait for the cluster


class HeadStart:
    """A process here until `connect` has given the workers of the rest."""

    def __init__(self, settings: BatchSettings, files: int, connect: Callable[[], Workers]) -> None:
        """At most half of the `files` are made here."""
        self._here = Processes(settings, 1)
        self._left = min(MOST_FILES, files // 2)  #: files that may still be handed to it
        self._connect = connect
        self._there: Workers | None = None
        self._chunks_here = self._chunks_there = 0  #: under way

    @property
    def at_once(self) -> int:
        return 1 if self._there is None else self._there.at_once

    @property
    def most_files(self) -> int:
        return (self._here if self._there is None else self._there).most_files

    def has_room(self) -> bool:
        return self._left > 0 if self._there is None else self._there.has_room()

    def submit(self, chunk: Chunk) -> None:
        if self._there is None and sum(len(task.data) for task in chunk) <= MOST_BYTES:
            self._here.submit(chunk)
            self._chunks_here += 1
            self._left -= len(chunk)
            return
        self._reached().submit(chunk)
        self._chunks_there += 1

    def wait(self) -> Iterator[Outcome]:
        if self._there is None:
            self._reached()
            yield from self._given_up()
        elif self._chunks_here and (self._here.done() or not self._chunks_there):
            for chunk, made in self._here.wait():
                self._chunks_here -= 1
                yield chunk, made
            yield from self._given_up()  # what was lost with the process here
        else:
            for result in self._there.wait():
                self._chunks_there -= 1
                yield result

    def _given_up(self) -> Iterator[Outcome]:
        """The chunks that are not made here any more, for the cluster."""
        for chunk in self._here.withdraw():
            self._chunks_here -= 1
            yield chunk, None

    def close(self) -> None:
        self._here.close()
        if self._there is not None:
            self._there.close()

    def _reached(self) -> Workers:
        if self._there is None:
            self._there = self._connect()
        return self._there
