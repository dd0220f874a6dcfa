"""When Python may look for rings of objects that nothing points to any more."""

import atexit
import gc
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

#: When rings are looked for in a process that stays: next to none are made.
SELDOM = (20_000, 20, 100)


@contextmanager
def collector_resting() -> Iterator[None]:
    """No search for rings of objects meanwhile, and as before at the end, whatever happens.

    Each search walks over all objects that were made, hundreds of thousands for a drawing or a
    model, and finds nothing: records point one way. What nothing points to is freed at once all
    the same, so memory does not grow by it. For a stage that ends, not for a process that stays.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@cache
def collector_seldom() -> None:
    """Let rings be looked for seldom in this process, and not at its end, when all goes at once.

    Python's own measure would have it search ten times while a command is loaded, and over all that
    was ever loaded when it is done: a fifth of the time of one post.
    """
    gc.set_threshold(*SELDOM)
    atexit.register(gc.freeze)
