"""Programs read back, and compared with the parts that they should make.

It shares no code and no decision with planning, motion or the emitters, so that a fault of theirs
cannot hide in it. The meaning of a text comes from `controllers`; what the machine makes of it, and
whether that is the part, here: `bars` of saw and drill, `sheets`, `st` and `steps` of what follows
contours.

What answers for each word of a program, the codes that refuse it or why it does no harm, stands in
the `OWNERS` of each room, by stock and controller; so do the events that controllers make of a
program. `tests/test_owners.py` takes the words that an interpreter knows from the interpreter
itself: one without a row fails, and so does a row without its word. `beamcam codes --words` prints
them all.
"""

from collections.abc import Mapping
from typing import Literal

from msgspec import Struct

#: What a program is written for, or the events that are made of it.
Language = Literal[
    "codesys", "linuxcnc", "grbl", "mach3", "simotion", "plcopen", "stepper", "events"
]
Stock = Literal["beam", "sheet", "profile"]


class Owner(Struct, frozen=True):
    """Who answers for words, or for what they carry."""

    words: tuple[str, ...]  #: `G41`, the role of an M word of the machine file, or an event
    carries: tuple[str, ...] = ()  #: letters, placeholders or fields; none: the words themselves
    #: codes of messages, those that begin alike as `verify-hole-*`
    refused_by: tuple[str, ...] = ()
    harmless: str = ""  #: why, wherever none of them refuses it


Rows = Mapping[tuple[Stock, Language], tuple[Owner, ...]]
