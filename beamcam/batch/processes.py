"""Workers that are processes of this machine."""

import gc
from collections.abc import Iterator

from msgspec import Struct

from beamcam.batch.pool import CHUNK_FILES, Chunk, Result
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
