"""Members of a large model, read by several processes side by side.

A forked process has the whole model at hand without a copy of it, and sends back only the parts
that it made. So this is for systems that fork, and for callers who say that they may: one with
threads of its own may not.
"""

import signal
from collections.abc import Callable, Generator
from typing import Any, TypeVar

from beamcam.system import start_method

T = TypeVar("T")

SHARE = 16  #: members that a process takes at a time
HEAVY = 1  #: of members that the geometry kernel builds, which takes a hundred times as long
WORTH = 12  #: shares below which processes cost more than they save

_share_of: list[Callable[[range], Any]] = []  #: the one that a forked process calls


def shares(
    share: Callable[[range], T], count: int, workers: int, size: int = SHARE
) -> Generator[T, None, None]:
    """What `share` gives for all of range(count), a stretch at a time and in order.

    With `workers` above 1 and enough to do, so many processes do it, `size` members at a time, and
    `share` has to give what can be pickled. Where one of them dies, as a geometry kernel can, the
    rest is done here.
    """
    done = 0
    if workers > 1 and count >= WORTH * size and start_method() == "fork":
        for given in _by_processes(share, count, workers, size):
            yield given
            done = min(done + size, count)
    for place in range(done, count):
        yield share(range(place, place + 1))


def _by_processes(
    share: Callable[[range], T], count: int, workers: int, size: int
) -> Generator[T, None, None]:
    """As `shares`, as far as the processes live."""
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    stretches = [range(i, min(i + size, count)) for i in range(0, count, size)]
    # What the model's members have in common is read with the first of them: here, for all.
    yield share(stretches.pop(0))
    # `share` reaches a forked process as it is; what initargs hold is not pickled then.
    pool = ProcessPoolExecutor(workers, get_context("fork"), _begin, (share,))
    try:
        yield from pool.map(_one_share, stretches)
    except BrokenProcessPool:
        return
    finally:
        pool.shutdown(cancel_futures=True)


def _begin(share: Callable[[range], object]) -> None:
    _share_of[:] = [share]
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the caller hears it and ends the others


def _one_share(stretch: range) -> Any:
    return _share_of[0](stretch)
