"""Ways to make a table's program wrong in the feed of small holes and corners, or in common cuts.

Feeds are dropped, changed, and written a block too early or too late; cuts that two parts share are
left out, made twice, moved, cut short, and made before the ring that they begin on. A change that
leaves the feed of every move as it was is none. `sound` gives programs that only look different,
which must raise nothing.
"""

import random
import re
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import Severity
from beamcam.geometry.curves import Arc
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Measures, Part
from beamcam.pipeline import post
from benchmarks.liars import Lies
from benchmarks.sheet_faults import sheet
from benchmarks.sheet_liars import COLOURS, contour, lines, part_of

Lines = list[str]
Fault = Callable[[Lines, random.Random], Lines | None]

HOLES = Path(__file__).parents[1] / "samples/machines/plate-holes.toml"
KERF = 1.2  #: of the row of `plate-linuxcnc` for 3 mm
FEED = re.compile(r"F([\d.]+)")
FED = re.compile(r"G[123] X")


def common_sheet() -> Part:
    """Boxes a kerf apart, in two rows, and one of them with a hole."""
    rings = [
        lines((x, y), (x + 60.0, y), (x + 60.0, y + 40.0), (x, y + 40.0))
        for y in (0.0, 40.0 + KERF) for x in (0.0, 60.0 + KERF, 120.0 + 2 * KERF)
    ]  # fmt: skip
    hole = contour((Arc((30.0, 20.0), 8.0, 0.0, 360.0),), "#ff0000")
    return part_of((*(contour(ring, "#ff0000") for ring in rings), hole), Measures())


def feeds_of(program: Lines) -> list[str]:
    """The feed of each move with the tool on, as it stands in the program."""
    feed, found = "", list[str]()
    for line in program:
        word = FEED.fullmatch(line)
        feed = word[1] if word else feed
        if FED.match(line):
            found.append(feed)
    return found


def _a_feed(program: Lines, chance: random.Random) -> int:
    return chance.choice([k for k, line in enumerate(program) if FEED.fullmatch(line)])


def feed_dropped(program: Lines, chance: random.Random) -> Lines | None:
    at = _a_feed(program, chance)
    return [*program[:at], *program[at + 1 :]]


def another_feed(program: Lines, chance: random.Random) -> Lines | None:
    at = _a_feed(program, chance)
    factor = chance.choice((0.5, 0.8, 0.95, 1.05, 1.2, 2.0))
    return [*program[:at], f"F{float(program[at][1:]) * factor:g}", *program[at + 1 :]]


def feed_too_early(program: Lines, chance: random.Random) -> Lines | None:
    at = _a_feed(program, chance)
    rest = [*program[:at], *program[at + 1 :]]
    return [*rest[: at - 1], program[at], *rest[at - 1 :]]


def feed_too_late(program: Lines, chance: random.Random) -> Lines | None:
    at = _a_feed(program, chance)
    rest = [*program[:at], *program[at + 1 :]]
    return [*rest[: at + 1], program[at], *rest[at + 1 :]]


def feeds_exchanged(program: Lines, chance: random.Random) -> Lines | None:
    """Fast where it has to be slow, and slow where it has to be fast."""
    values = sorted({line for line in program if FEED.fullmatch(line)})
    one, other = chance.sample(values, 2)
    turned = {one: other, other: one}
    return [turned.get(line, line) for line in program]


Stroke = tuple[int, int]  #: from its rapid to behind the word that stops the tool


def strokes(program: Lines) -> list[Stroke]:
    """The strokes of a program for LinuxCNC."""
    ends = [k for k, line in enumerate(program) if line == "M5"]
    begins = [
        max(k for k in range(end) if program[k].startswith("G0 X")) for end in ends
    ]  # fmt: skip
    return [(a, b + 1) for a, b in zip(begins, ends, strict=True)]


def _run(program: Lines, chance: random.Random) -> Stroke:
    """A stroke of lines alone: what is left of a contour that shares an edge."""
    runs = [(a, b) for a, b in strokes(program) if not any("G3" in line for line in program[a:b])]
    return chance.choice(runs)


def shared_cut_left_out(program: Lines, chance: random.Random) -> Lines | None:
    a, b = _run(program, chance)
    return [*program[:a], *program[b:]]


def shared_cut_made_twice(program: Lines, chance: random.Random) -> Lines | None:
    a, b = _run(program, chance)
    return [*program[:b], *program[a:b], *program[b:]]


def shared_cut_moved(program: Lines, chance: random.Random) -> Lines | None:
    a, b = _run(program, chance)
    axis, by = chance.choice("XY"), chance.choice((-1.2, -0.3, -0.1, 0.1, 0.3, 1.2))
    moved = [
        re.sub(rf"{axis}([\d.]+)", lambda m: f"{axis}{float(m[1]) + by:.4f}", line)
        for line in program[a:b]
    ]
    return [*program[:a], *moved, *program[b:]]


def shared_cut_before_its_ring(program: Lines, chance: random.Random) -> Lines | None:
    a, b = _run(program, chance)
    first = strokes(program)[0][0]
    return [*program[:first], *program[a:b], *program[first:a], *program[b:]]


def shared_cut_short(program: Lines, chance: random.Random) -> Lines | None:
    """The part hangs in the sheet by the last 2 mm."""
    a, b = _run(program, chance)
    at = max(k for k in range(a, b) if program[k].startswith("G1 X"))
    (x0, y0), (x1, y1) = _place(program[at - 1]), _place(program[at])
    if (x0, y0) == (x1, y1) or abs(x1 - x0) + abs(y1 - y0) < 4.0:
        return None
    size = abs(x1 - x0) + abs(y1 - y0)
    x, y = x1 - 2.0 * (x1 - x0) / size, y1 - 2.0 * (y1 - y0) / size
    return [*program[:at], f"G1 X{x:.4f} Y{y:.4f}", *program[at + 1 :]]


def pierced_in_a_part(program: Lines, chance: random.Random) -> Lines | None:
    """What begins in an open kerf begins 5 mm beside it."""
    a, b = _run(program, chance)
    at = min(k for k in range(a, b) if program[k].startswith("G1 X"))
    (x0, y0), (x1, y1) = _place(program[a]), _place(program[at])
    size = abs(x1 - x0) + abs(y1 - y0)
    side = chance.choice((-5.0, 5.0))
    x, y = x0 + side * (y1 - y0) / size, y0 + side * (x1 - x0) / size
    return [*program[:a], f"G0 X{x:.4f} Y{y:.4f}", *program[a + 1 :]]


def ring_that_shares_left_out(program: Lines, chance: random.Random) -> Lines | None:
    rings = [s for s in strokes(program) if any("G3" in line for line in program[s[0] : s[1]])]
    a, b = chance.choice(rings)
    return [*program[:a], *program[b:]]


def _place(line: str) -> tuple[float, float]:
    found = re.search(r"X(\S+) Y(\S+)", line)
    return (float(found[1]), float(found[2])) if found else (0.0, 0.0)


BY_CLASS: dict[str, tuple[Fault, ...]] = {
    "feeds": (feed_dropped, another_feed, feed_too_early, feed_too_late, feeds_exchanged),
    "common": (shared_cut_left_out, shared_cut_made_twice, shared_cut_moved,
               shared_cut_before_its_ring, shared_cut_short, pierced_in_a_part,
               ring_that_shares_left_out),
}  # fmt: skip


def programs() -> Iterator[tuple[str, Part, Machine, str]]:
    """The class of faults, the part, the machine and its sound program."""
    slow = with_torch(load(str(HOLES)), colours=COLOURS, allow_open=True)
    shared = with_torch(load("plate-linuxcnc"), colours=COLOURS, thickness=3.0, common_cuts=True)
    for kind, part, machine in (
        ("feeds", sheet(), slow), ("feeds", sheet(), with_torch(slow, overcut=3.0)),
        ("feeds", sheet(), with_torch(slow, tabs=2)),
        ("common", common_sheet(), shared),
    ):  # fmt: skip
        text = post([part], machine).text
        assert isinstance(text, str)
        yield kind, part, machine, text


def sound(text: str, chance: random.Random) -> Iterator[str]:
    """Programs that mean the same: feeds said again, comments, and blocks with more blanks."""
    program = text.split("\n")
    feeds = [k for k, line in enumerate(program) if FEED.fullmatch(line)]
    at = chance.choice(feeds)
    yield "\n".join([*program[:at], program[at], *program[at:]])
    yield "\n".join(re.sub(r" Y", "  Y", line) for line in program)
    begins = [k for k, line in enumerate(program) if line.startswith("G0 X")]
    at = chance.choice(begins)
    yield "\n".join([*program[:at], "(here)", *program[at:]])
    yield "\n".join(f"{line}.0" if FEED.fullmatch(line) else line for line in program)


def told(each: int, seed: int) -> Lies:
    """Every fault, `each` times in every program that can have it; `sound` ones are alarms."""
    chance = random.Random(seed)
    result = Lies(Counter(), Counter(), [])
    for kind, part, machine, text in programs():
        for other in (text, *sound(text, chance)):
            if any(d.severity is not Severity.NOTE for d in verify_sheet(other, (part,), machine)):
                result.missed.append((kind, "alarm"))
        right = feeds_of(text.split("\n"))
        for fault in BY_CLASS[kind]:
            for _ in range(each):
                found = fault(text.split("\n"), chance)
                if found is None or (kind == "feeds" and feeds_of(found) == right):
                    continue
                said = verify_sheet("\n".join(found), (part,), machine)
                name = f"{kind} {fault.__name__}"
                refused = any(one.severity is Severity.ERROR for one in said)
                result.made[name] += 1
                result.caught[name] += refused
                if not refused:
                    result.missed.append((machine.name, name))
    return result
