"""Workers that are processes of this machine."""

import gc
from collections.abc import Callable, Iterator

from msgspec import Struct

from beamcam.batch.pool import CHUNK_FILES, Chunk, Result, Workers
from beamcam.batch.work import FileResult, Shop, make_all, thaw
from beamcam.collector import collector_seldom
from beamcam.processes import Died, Pool


class Making(Struct, frozen=True):
    """The work of a worker, for a shop that is frozen on its way there."""

    frozen: bytes

    def begin(self) -> None:
        thaw(self.frozen)
        gc.freeze()  # what is there now stays, and need not be looked through again and again
        collector_seldom()

    def __call__(self, chunk: Chunk) -> list[FileResult]:
        return make_all(chunk, thaw(self.frozen))


class Processes:
    """Work in processes of this machine, started as they are needed."""

    most_files = CHUNK_FILES

    def __init__(self, shop: Shop, jobs: int) -> None:
        making = Making(shop.freeze)
        self._pool = Pool[Chunk, list[FileResult]](making, jobs, making.begin)
        self.at_once = self._pool.at_once

    def has_room(self) -> bool:
        return self._pool.has_room()

    def submit(self, chunk: Chunk) -> None:
        self._pool.submit(chunk)

    def wait(self) -> Iterator[Result]:
        for chunk, made in self._pool.wait():
            if isinstance(made, Died):
                yield Result(chunk, "suspected")
            else:
                yield Result(chunk, "made", made)

    def done(self) -> bool:
        """Whether `wait` would give something at once."""
        return self._pool.done()

    def withdraw(self) -> list[Chunk]:
        """The chunks that no worker has begun, or that were lost with one."""
        return self._pool.withdraw()

    def close(self) -> None:
        self._pool.close()


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

    def __init__(self, shop: Shop, files: int, connect: Callable[[], Workers]) -> None:
        """At most half of the `files` are made here."""
        self._here = Processes(shop, 1)
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

    def wait(self) -> Iterator[Result]:
        if self._there is None:
            self._reached()
            yield from self._given_up()
        elif self._chunks_here and (self._here.done() or not self._chunks_there):
            for result in self._here.wait():
                self._chunks_here -= 1
                yield result
            yield from self._given_up()  # what was lost with the process here
        else:
            for result in self._there.wait():
                self._chunks_there -= 1
                yield result

    def _given_up(self) -> Iterator[Result]:
        """The chunks that are not made here any more, for the cluster."""
        for chunk in self._here.withdraw():
            self._chunks_here -= 1
            yield Result(chunk, "lost")

    def close(self) -> None:
        self._here.close()
        if self._there is not None:
            self._there.close()

    def _reached(self) -> Workers:
        if self._there is None:
            self._there = self._connect()
        return self._there
