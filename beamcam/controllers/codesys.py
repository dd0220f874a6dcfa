"""The interpreter of CODESYS SoftMotion CNC: blocks in, events out.

Source: CODESYS online help, "CNC: DIN 66025". G90/G91 say how X, Y and Z count, G98/G99 how I and
J do (from the start of the arc unless told otherwise). A block without a command repeats the last
travel command. F counts per second or per minute as the machine file says.
"""

from math import isnan, nan

from beamcam.controllers import rules
from beamcam.controllers.arcs import arc_fault, radius_centre, radius_fault, sweep_of
from beamcam.controllers.blocks import BRAKING, Block
from beamcam.controllers.events import BarEvent, Move, Pause, Place, Switch, Turn
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import NumberFormat

M_WORDS_IN_A_ROW = 64  #: CODESYS, SMC_DEC_OUTQUEUE_RAN_EMPTY
_WITHOUT_EFFECT = frozenset({40, 50, 53})  # compensation, smoothing, offsets: off, as at the start
_TRAVEL = frozenset({0, 1, 2, 3})
_KNOWN = "G00 to G04, G40, G50, G53, G75, G90, G91, G98 or G99"


def run(
    blocks: list[Block], name: str, form: NumberFormat, feed: float = 0.0
) -> tuple[list[BarEvent], list[Diagnostic]]:
    """The events of a program, and what its controller would not do as it says.

    `feed` in mm/min is what holds before the first F.
    """
    events: list[BarEvent] = []
    said: list[Diagnostic] = []
    x = y = z = nan
    per_minute = 60.0 if form.feed_unit == "mm/s" else 1.0
    absolute, absolute_centre = True, False
    travel = -1
    in_a_row = 0
    too_many = False
    for line, command, number, words in blocks:
        if command == "M":
            in_a_row += 1
            events.append(Switch(line, number, words))
        elif command == "G" and number not in _TRAVEL:
            if number == 4:
                in_a_row += 1
                if "T" in words:
                    events.append(Pause(line, words["T"]))
                else:
                    said.append(
                        rules.WORD.at(Source(name, line), found="G04", expected="T with seconds")
                    )
            elif number == 75:
                in_a_row = 0
            elif number in (90, 91):
                absolute = number == 90
            elif number in (98, 99):
                absolute_centre = number == 98
            elif number not in _WITHOUT_EFFECT:
                said.append(
                    rules.WORD.at(Source(name, line), found=f"G{number:02}", expected=_KNOWN)
                )
            if words and number != 4:
                said.append(
                    rules.WORD.at(
                        Source(name, line),
                        found=f"{next(iter(words))} behind G{number:02}",
                        expected="no word there",
                    )
                )
            if number != 4:
                continue
        else:
            if command == "G":
                travel = number
            elif travel < 0:
                said.append(
                    rules.WORD.at(
                        Source(name, line), found="words without a command", expected="G or M"
                    )
                )
                continue
            if "F" in words:
                feed = words["F"] * per_minute
            start = (x, y, z)
            if absolute:
                get = words.get
                x, y, z = get("X", x), get("Y", y), get("Z", z)
            else:
                x, y, z = x + words.get("X", 0), y + words.get("Y", 0), z + words.get("Z", 0)
                if any(w in words and isnan(v) for w, v in zip("XYZ", (x, y, z), strict=True)):
                    said.append(
                        rules.WORD.at(
                            Source(name, line),
                            found="a relative move from nowhere",
                            expected="an absolute place (G90) before",
                        )
                    )
            end = (x, y, z)
            if start != end:
                in_a_row, too_many = 0, False
            if travel < 2:
                events.append(Move(line, travel == 0, start, end, feed, "F" in words))
                allowed = _STRAIGHT_WORDS
            else:
                turn = _turn((line, "G", travel, words), start, end, absolute_centre, form)
                if isinstance(turn, Turn):
                    events.append(turn._replace(feed_mm_min=feed))
                    in_a_row, too_many = 0, False
                else:
                    said.append(
                        rules.ARC.at(
                            Source(name, line),
                            found=turn,
                            expected="one that start, end and centre agree on",
                        )
                    )
                allowed = _ARC_WORDS
            if not words.keys() <= allowed:
                said.append(
                    rules.WORD.at(
                        Source(name, line),
                        found=f"{min(words.keys() - allowed)} behind G{travel:02}",
                        expected="no such word there",
                    )
                )
            continue
        if in_a_row > M_WORDS_IN_A_ROW and not too_many:
            too_many = True
            said.append(
                rules.M_QUEUE.at(Source(name, line), found=in_a_row, expected=M_WORDS_IN_A_ROW)
            )
    return events, said


_STRAIGHT_WORDS = frozenset("XYZFE") | {BRAKING}
_ARC_WORDS = _STRAIGHT_WORDS | frozenset("IJR")


def _turn(
    block: Block, start: Place, end: Place, absolute_centre: bool, form: NumberFormat
) -> Turn | str:
    """The arc of a block, without its feed; what is wrong with it if there is none."""
    line, _, number, words = block
    first, last = start[:2], end[:2]
    if any(isnan(v) for v in (*first, *last)):
        return "that starts nowhere"
    clockwise = number == 2
    if "R" in words:
        if "I" in words or "J" in words:
            return "with R as well as I and J"
        fault = radius_fault(first, last, words["R"])
        if fault:
            return fault
        centre = radius_centre(first, last, words["R"], clockwise)
    elif "I" in words or "J" in words:
        origin = (0.0, 0.0) if absolute_centre else first
        centre = (origin[0] + words.get("I", 0.0), origin[1] + words.get("J", 0.0))
        fault = arc_fault(first, last, centre, form.resolution)
        if fault:
            return fault
    else:
        return "without I, J or R"
    return Turn(line, start, end, centre, sweep_of(first, last, centre, clockwise), 0.0)
