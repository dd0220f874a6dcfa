"""Workers on a Dask cluster, for shops with more than one machine.

The bytes of the files go to the workers and the programs come back, so that they need no common
disk; they need the same beamcam.
"""

import sys
from collections.abc import Iterator
from concurrent.futures import CancelledError
from typing import Any

from beamcam.batch import SCHEDULER
from beamcam.batch.pool import Chunk, Outcome
from beamcam.batch.work import BatchSettings, FileResult, Task, make_all, thaw
from beamcam.errors import BeamcamError, Source
from beamcam.processes import Died
from beamcam.system import LOOK_S
from beamcam.version import __version__

ANSWER_S = 6.0  #: for the scheduler to answer, and for its workers to say which beamcam they have
CHUNKS = 2  #: that each thread of the cluster has at most, one of them in work
CHUNK_FILES = 128  #: in a chunk: what Dask does for a task takes as long as four files
FETCH_S = 60  #: for what is done to arrive
GONE = "the scheduler went away"


class SchedulerError(BeamcamError):
    """A cluster that cannot be worked with."""


class Cluster:
    """Work on the cluster of a running Dask scheduler."""

    most_files = CHUNK_FILES

    def __init__(
        self, settings: BatchSettings, address: str, answer_s: float | None = None,
        chunks: int | None = None,
    ) -> None:  # fmt: skip
        """Raises SchedulerError if there is none at `address`, or it has no worker."""
        self._address = address
        self._answer_s, self._per_thread = answer_s or ANSWER_S, chunks or CHUNKS
        self._frozen = settings.freeze
        self._chunks: dict[Any, Chunk] = {}
        try:
            library = distributed_alone()
        except ImportError as error:
            raise self._error("the package distributed is not installed") from error
        self._wait, self._killed = library.wait, library.KilledWorker
        self._closed: type[Exception] = library.client.ClosedClientError
        try:
            self._client = library.Client(address, timeout=self._answer_s, set_as_default=False)
        except Exception as error:  # another service than a scheduler may answer anything
            raise self._error(str(error) or type(error).__name__) from error
        self.at_once: int = sum(self._client.nthreads().values())
        if not self.at_once:
            self._client.close()
            raise self._error("it has no worker")
        try:
            self._check_workers(settings.version)
        except BaseException:
            self._client.close()
            raise

    def _check_workers(self, version: str) -> None:
        """Raises SchedulerError unless every worker has beamcam in that version.

        They are asked by a function that needs no beamcam and is run beside their work, so that
        one which is busy answers too.
        """

        def version_there() -> str:
            try:
                from beamcam.version import __version__
            except ImportError:
                return ""
            return __version__

        try:
            versions = self._client.sync(
                self._client._run, version_there, on_error="return", callback_timeout=self._answer_s
            )
        except (OSError, TimeoutError) as error:
            raise self._error(f"its workers give no answer within {self._answer_s:g} s") from error
        for worker, has in sorted(versions.items()):
            if not isinstance(has, str):
                raise self._error(f"the worker {worker} gives no answer: {has!r}")
            if has != version:
                has = f"beamcam {has}, not {version}" if has else "no beamcam"
                raise self._error(f"the worker {worker} has {has}")

    def _error(self, found: str) -> SchedulerError:
        return SchedulerError(
            SCHEDULER.at(
                Source("--scheduler"), address=self._address, found=found, version=__version__
            )
        )

    def has_room(self) -> bool:
        return len(self._chunks) < self._per_thread * self.at_once

    def submit(self, chunk: Chunk) -> None:
        # Each call is a task of its own: `pure` would let equal chunks share a result.
        try:
            future = self._client.submit(make_there, self._frozen, chunk, pure=False)
        except self._closed as error:
            raise self._error(GONE) from error
        self._chunks[future] = chunk

    def wait(self) -> Iterator[Outcome]:
        try:
            with self._client.as_current():
                done = self._wait(
                    list(self._chunks), timeout=LOOK_S, return_when="FIRST_COMPLETED"
                ).done
        except TimeoutError:
            if self._client.status == "running":
                return
            raise self._error(GONE) from None
        except CancelledError as error:
            raise self._error(GONE) from error
        for future in [f for f in self._chunks if f in done]:
            chunk = self._chunks.pop(future)
            try:
                yield chunk, future.result(timeout=FETCH_S)
            except self._killed:
                yield chunk, Died()
            except TimeoutError:  # the worker that had the result is gone, with no fault of it
                future.cancel()
                yield chunk, None
            except CancelledError as error:
                raise self._error(GONE) from error
            except Exception as error:
                raise self._error(f"{type(error).__name__}: {error}") from error

    def close(self) -> None:
        self._client.cancel(list(self._chunks))
        self._client.close()
        self._chunks.clear()


def distributed_alone() -> Any:
    """The package distributed, which has no types. Raises ImportError.

    Without numpy and jinja2 its import takes three quarters of the time. It uses the one, where
    it is there, for the memory of messages and the other for pages in HTML.
    """
    modules: dict[str, Any] = sys.modules
    hidden = [name for name in ("numpy", "jinja2") if name not in modules]
    modules.update(dict.fromkeys(hidden))
    try:
        import distributed
    finally:
        for name in hidden:
            del modules[name]
    return distributed


def make_there(frozen: bytes, chunk: tuple[Task, ...]) -> list[FileResult]:
    """`make_all` on a worker. Raises RuntimeError if its beamcam is another than the shop's."""
    settings = thaw(frozen)
    if settings.version != __version__:
        raise RuntimeError(f"a worker has beamcam {__version__}, not {settings.version}")
    return make_all(chunk, settings)
