"""When Python may look for rings of objects that nothing points to any more."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


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
