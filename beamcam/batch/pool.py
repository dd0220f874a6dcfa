"""Workers: chunks of files in, results out, in any order.

`Here` is this process; others are in `processes` and `cluster`, which are loaded if they are asked
for.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Literal, Protocol

from msgspec import Struct

from beamcam.batch.work import FileResult, Shop, Task, died, make_all
from beamcam.interrupts import Asked

Chunk = tuple[Task, ...]
CHUNK_BYTES = 256 * 1024  #: a chunk of more is closed
CHUNK_FILES = 16  #: most files that a process of this machine gets at once


class Result(Struct, frozen=True):
    """The outcome of a chunk: made, lost with a worker through no fault of its own, or suspected
    of having killed it."""

    chunk: Chunk
    how: Literal["made", "lost", "suspected"]
    made: Sequence[FileResult] = ()


class Workers(Protocol):
    """Whoever does the work."""

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

    def wait(self) -> Iterator[Result]:
        """What is done, or nothing after a moment; there has to be something under way."""

    def close(self) -> None:
        """End the work, whatever is under way."""


class Here:
    """Work in this process, at once."""

    at_once = 1
    most_files = CHUNK_FILES

    def __init__(self, shop: Shop) -> None:
        self._shop = shop
        self._done: Result | None = None

    def has_room(self) -> bool:
        return self._done is None

    def submit(self, chunk: Chunk) -> None:
        self._done = Result(chunk, "made", make_all(chunk, self._shop))

    def wait(self) -> Iterator[Result]:
        if self._done is not None:
            done, self._done = self._done, None
            yield done

    def close(self) -> None:
        self._done = None


def driven(workers: Workers, tasks: Iterator[Task], asked: Asked) -> Iterator[FileResult]:
    """The result of each task, in any order; nothing more once it is `asked` to end."""
    again: deque[Chunk] = deque()
    away, is_left = 0, True
    while not asked:
        while workers.has_room() and (again or is_left):
            chunk = again.popleft() if again else _chunk(tasks, workers.most_files)
            if not chunk:
                is_left = False
                break
            workers.submit(chunk)
            away += 1
        if not away:
            return
        for result in workers.wait():
            away -= 1
            if result.how == "made":
                yield from result.made
            elif result.how == "lost":
                again.append(result.chunk)
            elif len(result.chunk) > 1:
                again.extend((task,) for task in result.chunk)
            else:
                (task,) = result.chunk
                yield FileResult(task.index, died(task.name), ())


def _chunk(tasks: Iterator[Task], most: int) -> Chunk:
    chunk: list[Task] = []
    size = 0
    for task in islice(tasks, most):
        chunk.append(task)
        size += len(task.data)
        if size >= CHUNK_BYTES:
            break
    return tuple(chunk)
