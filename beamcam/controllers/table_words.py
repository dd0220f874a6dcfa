"""What the words of a table's own do, as `[codes]` of its file says: events of them.

M64 P2     codes.M64P2 = "thc off"         an Output
M67 E3 Q60 codes.M67E3 = "feed share"      a FeedShare
M7         codes.M7 = "torch on"           a Switch, which starts the tool
"""

from collections.abc import Iterable, Mapping

from beamcam.controllers.events import FeedShare, Material, Other, Output, Switch
from beamcam.machine.codes import CARRYING
from beamcam.machine.machine import CodeMeaning

#: What moves the torch or calls its place, for which its height has to be known.
HEAD_ACTIONS = frozenset({"height", "touch off"})
#: What starts and stops a tool.
TOOL_ON = frozenset({"torch on", "cutting oxygen on"})
TOOL_OFF = frozenset({"torch off", "cutting oxygen off"})
#: M words that neither move a table's head nor switch its tool: coolant and air, overrides.
IDLE_SWITCHES = frozenset({7, 8, 9, 48, 49, 50, 51, 52, 53})
#: M words that stop the program until the operator goes on.
STOPS = frozenset({0, 1, 6, 60})
_WITH_MOVE = frozenset({62, 63, 67})  #: M words that act as the next move begins
_LETTERS = frozenset("PQEKLHD$")


def carried(values: dict[str, float], more: Iterable[str] = ()) -> dict[str, float]:
    """What an M word carries, taken out of the values of its block."""
    own = sorted(values.keys() & (_LETTERS | frozenset(more)))
    return {letter: values.pop(letter) for letter in own}


def with_number(meaning: CodeMeaning, said: Mapping[str, float]) -> float | None:
    """The number that a meaning needs, 0 of one that needs none; None where it is missing."""
    if meaning not in CARRYING:
        return 0.0
    return said.get("Q", said.get("P"))


def event_of(number: int, meaning: CodeMeaning, said: dict[str, float], value: float) -> Other:
    """The event of an M word, its line 0."""
    if meaning in TOOL_ON or meaning in TOOL_OFF:
        return Switch(0, number, said, meaning)
    if meaning == "feed share":
        return FeedShare(0, value / 100.0 if 0.0 < value < 100.0 else 1.0)
    if meaning == "material":
        return Material(0, {"number": value})
    name, _, state = meaning.rpartition(" ")
    if name == "output" and "P" in said:
        name = f"output {said['P']:g}"
    return Output(0, name, state == "on", number in _WITH_MOVE)


def tool_words(switches: Iterable[Switch], on: bool) -> list[Switch]:
    """Those of the M words of a template that start or stop the tool.

    What `[codes]` says comes first, then M3, M4 and M5, then what is no coolant and no override.
    """
    each = list(switches)
    says = [e for e in each if e.does in (TOOL_ON if on else TOOL_OFF)]
    turns = [e for e in each if not e.does and e.number in ((3, 4) if on else (5,))]
    others = [e for e in each if not e.does and e.number not in IDLE_SWITCHES | STOPS]
    return says or turns or others or [e for e in each if not e.does and e.number not in STOPS]
