"""The first files of a batch, made here until a cluster has answered.

    submit -> a process here -> wait
                 | connected: what it has not begun goes back to be submitted again
    submit -> the cluster ----> wait

Importing Dask and asking its workers takes as long as making a hundred files. No result is given
before the cluster has answered: one that cannot be worked with refuses the batch before a file is
written.
"""

from collections.abc import Callable, Iterator

from beamcam.batch.pool import Chunk, Result, Workers
from beamcam.batch.processes import Processes
from beamcam.batch.work import Shop

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
