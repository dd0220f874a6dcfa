"""Ways to make a bar's program dangerous that leave the part as it is, all to be refused.

Each gives None where the program has nothing of the kind. What needs the part to be seen stands in
`NEED_PARTS`: how hard the steel is, and how far the web lies below its flanges.
"""

import random
import re
from collections.abc import Callable, Sequence

from benchmarks.order_faults import ORDER_FAULTS, SEEN_BY_PARTS

Fault = Callable[[list[str], random.Random], list[str] | None]

_FEED = re.compile(r" F([\d.]+)")
_SPEED = re.compile(r"( M0[34] K)([\d.]+)")


def _picked(lines: Sequence[str], rng: random.Random, pattern: str) -> int | None:
    fitting = [i for i, line in enumerate(lines) if re.search(pattern, line)]
    return rng.choice(fitting) if fitting else None


def _stroke(lines: Sequence[str], rng: random.Random) -> int | None:
    """The feed into the steel of some drilled hole: what follows the coolant."""
    found = [i for i, line in enumerate(lines[:-2]) if re.search(r" M0[78]\b", lines[i - 1])]
    return rng.choice(found) if found else None


def _feed_times(factor: float) -> Fault:
    def fault(lines: list[str], rng: random.Random) -> list[str] | None:
        at = _picked(lines, rng, _FEED.pattern)
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
    at = _picked(first, rng, _FEED.pattern)
    return None if at is None else [*lines[:at], _FEED.sub("", lines[at]), *lines[at + 1 :]]


def speed_too_high(lines: list[str], rng: random.Random) -> list[str] | None:
    at = _picked(lines, rng, _SPEED.pattern)
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
    at = _picked(lines, rng, r"G00 X\S+ Y-?[\d.]+ Z")
    if at is None or "M03" not in lines[at + 1]:
        return None
    flange = "Y-" in lines[at] and re.search(r" Y-5(\.0*)?\b", lines[at])
    axis = "Y" if flange else "Z"
    changed = re.sub(rf" {axis}(-?[\d.]+)", lambda m: f" {axis}{float(m[1]) + 5:.3f}", lines[at])
    return [*lines[:at], changed, *lines[at + 1 :]]


def _word_removed(pattern: str, name: str) -> Fault:
    def fault(lines: list[str], rng: random.Random) -> list[str] | None:
        at = _picked(lines, rng, pattern)
        return None if at is None else lines[:at] + lines[at + 1 :]

    fault.__name__ = name
    return fault


FAULTS: tuple[Fault, ...] = (
    _feed_times(2), _feed_times(10), _feed_times(60), feed_removed, speed_too_high,
    stopped_at_the_bottom, retract_removed, rapid_into_steel, rapid_onto_steel,
    _word_removed(r" M0[34]\b", "start_removed"), _word_removed(r" M0[78]\b", "coolant_removed"),
    _word_removed(r" M09\b", "coolant_stays_on"), _word_removed(r" M05\b", "stop_removed"),
    _word_removed(r" M30\b", "end_removed"), _word_removed(r" M06\b", "tool_change_removed"),
    *ORDER_FAULTS,
)  # fmt: skip
NEED_PARTS = frozenset({"feed_x2", "rapid_onto_steel", *SEEN_BY_PARTS})
