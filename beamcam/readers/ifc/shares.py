"""Members of a model, read by several processes side by side.

A forked process has the whole model at hand without a copy of it; one that is started afresh opens
the model again. Both send back only the parts that they made. This is for callers who say that they
may: one with threads of its own may not fork.
"""

from collections import deque
from collections.abc import Callable, Iterator
from typing import TypeVar

from beamcam.processes import Died, Pool
from beamcam.readers.ifc.options import Options
from beamcam.system import start_method

T = TypeVar("T")

SHARE = 16  #: members that are taken at a time, as reading one takes less than a millisecond
#: Members from which on processes pay, by how they are started and whether the kernel builds each
#: one. It is not to be interrupted, so that where processes cost little it is never called here.
WORTH = {
    ("fork", False): 192, ("fork", True): 1, ("spawn", False): 10_000, ("spawn", True): 50,
}  # fmt: skip


def workers_for(options: Options, count: int) -> int:
    """Number of processes for so many members; 0 to read them in this process."""
    worth = options.workers > 1 and count >= WORTH[start_method(), options.kernel]
    return options.workers if worth else 0


def shares(
    share: Callable[[range], T],
    died: Callable[[int], T],
    count: int,
    workers: int,
    each_by_itself: bool,
) -> Iterator[T]:
    """What `share` gives for all of range(count), a stretch at a time and in order.

    With `workers` above 0 so many processes do it, and `share` has to give what can be pickled.
    `died` gives what stands for a member at which processes die.
    """
    size = 1 if each_by_itself else SHARE
    todo = deque(range(i, min(i + size, count)) for i in range(0, count, size))
    if not workers:
        yield from map(share, todo)
        return
    pool = Pool[range, T](share, min(workers, len(todo)))
    made: dict[int, tuple[int, T]] = {}
    place = 0
    try:
        while place < count:
            while todo and pool.has_room():
                pool.submit(todo.popleft())
            for stretch, found in pool.wait():
                if not isinstance(found, Died):
                    made[stretch.start] = stretch.stop, found
                elif len(stretch) == 1:
                    made[stretch.start] = stretch.stop, died(stretch.start)
                else:
                    todo.extendleft(range(i, i + 1) for i in stretch)
            while place in made:
                place, found = made.pop(place)
                yield found
    finally:
        pool.close()
