"""Tune the cyclic garbage collector of a process that is beamcam's own.

Only the command line and its worker processes do so: a library leaves the collector to its host.
"""

import atexit
import gc

#: Thresholds of the cyclic garbage collector in a lasting process: cycles are rare, and a
#: drawing of 20,000 curves has fewer objects than the first.
SELDOM = (500_000, 20, 100)


def collector_seldom() -> None:
    """Run the cyclic garbage collector seldom in this process, and not at its end.

    Python's own measure would have it search ten times while a command is loaded, and over all that
    was ever loaded when it is done: a fifth of the time of one post.
    """
    gc.set_threshold(*SELDOM)
    atexit.unregister(gc.freeze)  # a command may be called twice in one process
    atexit.register(gc.freeze)
