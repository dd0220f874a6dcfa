"""Ways to make a bar's program dangerous that leave the part as it is, all to be refused.

Each gives None where the program has nothing of the kind. What needs the part to be seen stands in
`NEED_PARTS`: how hard the steel is, and how far the web lies below its flanges.
"""

import random
import re
from collections.abc import Callable, Sequence
from itertools import pairwise

from benchmarks.mutants import picked

Fault = Callable[[list[str], random.Random], list[str] | None]

_FEED = re.compile(r" F([\d.]+)")
_SPEED = re.compile(r"( M0[34] K)([\d.]+)")


def _stroke(lines: Sequence[str], rng: random.Random) -> int | None:
    """The feed into the steel of some drilled hole: what follows the coolant."""
    found = [i for i, line in enumerate(lines[:-2]) if re.search(r" M0[78]\b", lines[i - 1])]
    return rng.choice(found) if found else None


def _feed_times(factor: float) -> Fault:
    def fault(lines: list[str], rng: random.Random) -> list[str] | None:
        at = picked(lines, rng, _FEED.pattern)
        if at is None:
            return None
        changed = _FEED.sub(lambda m: f" F{factor * float(m[1]):.3f}", lines[at])
        return [*lines[:at], changed, *lines[at + 1 :]]

    fault.__name__ = f"feed_x{factor:g}"
    return fault


def feed_removed(lines: list[str], rng: random.Random) -> list[str] | None:
    """That behind a rapid: along a path, and back out of a thread, the feed goes on."""
    first = list(lines)
    feeds = False
    for i, line in enumerate(lines):
        if feeds and " G01 " in line:
            first[i] = ""
        feeds = " G00 " not in line and (feeds or " G01 " in line)
    at = picked(first, rng, _FEED.pattern)
    return None if at is None else [*lines[:at], _FEED.sub("", lines[at]), *lines[at + 1 :]]


def speed_too_high(lines: list[str], rng: random.Random) -> list[str] | None:
    at = picked(lines, rng, _SPEED.pattern)
    if at is None:
        return None
    changed = _SPEED.sub(lambda m: f"{m[1]}{10 * float(m[2]):.0f}", lines[at])
    return [*lines[:at], changed, *lines[at + 1 :]]


def stopped_at_the_bottom(lines: list[str], rng: random.Random) -> list[str] | None:
    at = _stroke(lines, rng)
    if at is None:
        return None
    stop = next((i for i in range(at, len(lines)) if re.search(r" M05\b", lines[i])), None)
    if stop is None:
        return None
    return [*lines[: at + 1], lines[stop], *lines[at + 1 : stop], *lines[stop + 1 :]]


def retract_removed(lines: list[str], rng: random.Random) -> list[str] | None:
    at = _stroke(lines, rng)
    if at is None or " G00 " not in lines[at + 1]:  # a mill goes on along its path
        return None
    return [*lines[: at + 1], *lines[at + 2 :]]


def rapid_into_steel(lines: list[str], rng: random.Random) -> list[str] | None:
    at = _stroke(lines, rng)
    if at is None:
        return None
    return [*lines[:at], lines[at].replace("G01", "G00"), *lines[at + 1 :]]


def rapid_onto_steel(lines: list[str], rng: random.Random) -> list[str] | None:
    """The rapid approach goes 5 mm further than it should."""
    at = picked(lines, rng, r"G00 X\S+ Y-?[\d.]+ Z")
    if at is None or "M03" not in lines[at + 1]:
        return None
    flange = "Y-" in lines[at] and re.search(r" Y-5(\.0*)?\b", lines[at])
    axis = "Y" if flange else "Z"
    changed = re.sub(rf" {axis}(-?[\d.]+)", lambda m: f" {axis}{float(m[1]) + 5:.3f}", lines[at])
    return [*lines[:at], changed, *lines[at + 1 :]]


def _word_removed(pattern: str, name: str) -> Fault:
    def fault(lines: list[str], rng: random.Random) -> list[str] | None:
        at = picked(lines, rng, pattern)
        return None if at is None else lines[:at] + lines[at + 1 :]

    fault.__name__ = name
    return fault


# --- order and state ------------------------------------------------------------------------------

# Work too early or too late, states left as they should not be, and what the operator is told.


Lines = list[str]
_BEGINS = re.compile(r"N\d+ (?:M4[05789]|M50) K")
_ENDS = re.compile(r"N\d+ (?:M4[05789]|M50|M06|M30|G0[01] X[\d.]+$)|\(")
_X = re.compile(r" X(-?[\d.]+)")
_STOP = re.compile(r"^\((.* station \d+: \w+) ([\d.]+)( for .*)\)$")
TAPPED = re.compile(r" M45 ")
SAW_X = 1250.0  #: of the line with a gripper, whose drills come first

Operation = tuple[int, int]  #: its lines


def _operations(lines: Sequence[str]) -> list[Operation]:
    """The strokes and paths of a program, without the stops before them."""
    found = []
    for at, line in enumerate(lines):
        if _BEGINS.match(line):
            ends = (i for i in range(at + 1, len(lines)) if _ENDS.match(lines[i]))
            found.append((at, next(ends, len(lines))))
    return found


def _x_of(lines: Sequence[str], operation: Operation) -> str:
    return next((m[1] for line in lines[slice(*operation)] if (m := _X.search(line))), "")


def _behind(word: str, lines: Lines, rng: random.Random) -> tuple[Operation, Operation] | None:
    """An operation with a word, and the one just before it at the same place."""
    done = _operations(lines)
    pairs = [
        (one, other)
        for one, other in pairwise(done)
        if word in lines[other[0]]
        and one[1] == other[0]
        and _x_of(lines, one) == _x_of(lines, other)
    ]
    return rng.choice(pairs) if pairs else None


def _swapped(lines: Lines, first: Operation, second: Operation) -> Lines:
    before, behind = lines[: first[0]], lines[second[1] :]
    return [*before, *lines[slice(*second)], *lines[slice(*first)], *behind]


def tap_before_its_drill(lines: Lines, rng: random.Random) -> Lines | None:
    pair = _behind(" M45 ", lines, rng)
    return None if pair is None else _swapped(lines, *pair)


def sink_before_its_hole(lines: Lines, rng: random.Random) -> Lines | None:
    pair = _behind(" M47 ", lines, rng)
    return None if pair is None else _swapped(lines, *pair)


def entry_of_a_mill_removed(lines: Lines, rng: random.Random) -> Lines | None:
    mill = next((one for one in _operations(lines) if " M49 " in lines[one[0]]), None)
    if mill is None:
        return None
    x = _x_of(lines, mill)
    drilled = [one for one in _operations(lines) if " M40 " in lines[one[0]] and one[0] < mill[0]]
    entry = next((one for one in reversed(drilled) if _x_of(lines, one) == x), None)
    return None if entry is None else [*lines[: entry[0]], *lines[entry[1] :]]


def work_behind_the_cut(lines: Lines, rng: random.Random) -> Lines | None:
    """Some work of a part moved behind the cut that frees it, where the drills come first."""
    if not any("MACHINE beamline-pusher" in line for line in lines):
        return None
    cuts = [i for i, line in enumerate(lines) if re.search(r" M42 K", line)]
    done = [one for one in _operations(lines) if cuts and one[0] < cuts[-1]]
    done = [
        one
        for one in done
        if not lines[one[0] - 1].startswith("(") and " M06 " not in lines[one[0] - 1]
    ]
    rng.shuffle(done)
    for one in done:
        x = float(_x_of(lines, one) or 0.0)
        for cut in cuts:
            at = float(_X.search(lines[cut - 1])[1]) if _X.search(lines[cut - 1]) else 0.0  # type: ignore[index]
            if cut > one[1] and at - SAW_X > x + 300.0:
                work = lines[slice(*one)]
                return [*lines[: one[0]], *lines[one[1] : cut + 1], *work, *lines[cut + 1 :]]
    return None


def dwell_in_the_steel(lines: Lines, rng: random.Random) -> Lines | None:
    at = picked(lines, rng, r" G01 X\S+ Y\S+ Z\S+ F")
    return None if at is None else [*lines[: at + 1], "G04 T2", *lines[at + 1 :]]


def dwell_of_an_hour(lines: Lines, rng: random.Random) -> Lines | None:
    at = picked(lines[:-3], rng, r"^N")
    return None if at is None else [*lines[: at + 1], "G04 T3600", *lines[at + 1 :]]


def counted_from_there(lines: Lines, rng: random.Random) -> Lines | None:
    at = picked(lines[:-8], rng, r" G00 X\S+ Y")
    return None if at is None else [*lines[:at], "G91", *lines[at:]]


def beside_the_contour(lines: Lines, rng: random.Random) -> Lines | None:
    at = picked(lines[:-3], rng, r"^N")
    side = rng.choice(("G41 D2", "G42 D0.5"))
    return None if at is None else [*lines[: at + 1], side, *lines[at + 1 :]]


def turned_the_other_way(lines: Lines, rng: random.Random) -> Lines | None:
    at = picked(lines, rng, r" M0[34]\b")
    if at is None:
        return None
    other = re.sub(r" M0([34])", lambda m: f" M0{7 - int(m[1])}", lines[at])
    return [*lines[:at], other, *lines[at + 1 :]]


def run_up_too_fast(lines: Lines, rng: random.Random) -> Lines | None:
    at = picked(lines, rng, r" G01 X\S+ Y\S+ Z\S+ F")
    return None if at is None else [*lines[:at], lines[at] + " E90000", *lines[at + 1 :]]


def _of_tap(lines: Lines, rng: random.Random, pattern: str, change: str) -> Lines | None:
    """A figure of a tap's operation times something, by the groups of a pattern."""
    taps = [one for one in _operations(lines) if TAPPED.search(lines[one[0]])]
    if not taps:
        return None
    first, last = rng.choice(taps)
    fitting = [i for i in range(first, last) if re.search(pattern, lines[i])]
    if not fitting:
        return None
    at, factor = rng.choice(fitting), rng.choice((0.5, 0.6, 0.9, 1.1, 2.0))
    new = re.sub(pattern, lambda m: f"{change}{float(m[1]) * factor:.3f}", lines[at])
    return [*lines[:at], new, *lines[at + 1 :]]


def tap_off_its_pitch(lines: Lines, rng: random.Random) -> Lines | None:
    return _of_tap(lines, rng, r" F([\d.]+)", " F")


def tap_back_at_other_turns(lines: Lines, rng: random.Random) -> Lines | None:
    return _of_tap(lines, rng, r" M04 K([\d.]+)", " M04 K")


def told_another_tool(lines: Lines, rng: random.Random) -> Lines | None:
    at = picked(lines, rng, _STOP.pattern)
    if at is None:
        return None
    other = _STOP.sub(lambda m: f"({m[1]} {float(m[2]) + 1:g}{m[3]})", lines[at])
    return [*lines[:at], other, *lines[at + 1 :]]


def told_another_station(lines: Lines, rng: random.Random) -> Lines | None:
    at = picked(lines, rng, _STOP.pattern)
    if at is None:
        return None
    other = re.sub(r"station \d+", "station 9", lines[at])
    return [*lines[:at], other, *lines[at + 1 :]]


FAULTS: tuple[Fault, ...] = (
    _feed_times(2), _feed_times(10), _feed_times(60), feed_removed, speed_too_high,
    stopped_at_the_bottom, retract_removed, rapid_into_steel, rapid_onto_steel,
    _word_removed(r" M0[34]\b", "start_removed"), _word_removed(r" M0[78]\b", "coolant_removed"),
    _word_removed(r" M09\b", "coolant_stays_on"), _word_removed(r" M05\b", "stop_removed"),
    _word_removed(r" M30\b", "end_removed"), _word_removed(r" M06\b", "tool_change_removed"),
    tap_before_its_drill, sink_before_its_hole, entry_of_a_mill_removed, work_behind_the_cut,
    dwell_in_the_steel, dwell_of_an_hour, counted_from_there, beside_the_contour,
    turned_the_other_way, run_up_too_fast, tap_off_its_pitch, tap_back_at_other_turns,
    told_another_tool, told_another_station,
)  # fmt: skip
#: Which slot is meant, and which part is cut off, only the parts say.
SEEN_BY_PARTS = frozenset({"entry_of_a_mill_removed", "work_behind_the_cut"})
NEED_PARTS = frozenset({"feed_x2", "rapid_onto_steel", *SEEN_BY_PARTS})
