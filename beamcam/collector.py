"""Tune the cyclic garbage collector of a process that is beamcam's own.

Only the command line and its worker processes do so: a library leaves the collector to its host.
"""

import atexit
import gc

#: When rings are looked for in a process that stays: next to none are made.
SELDOM = (20_000, 20, 100)


def collector_seldom() -> None:
    """Let rings be looked for seldom in this process, and not at its end, when all goes at once.

    Python's own measure would have it search ten times while a command is loaded, and over all that
    was ever loaded when it is done: a fifth of the time of one post.
    """
    gc.set_threshold(*SELDOM)
    atexit.unregister(gc.freeze)  # a command may be called twice in one process
    atexit.register(gc.freeze)
