"""Ways to make a table's program wrong that leave its contours where they are, all to be refused.

By classes: the order of cuts, the state of tool and controller, the limits of the machine, leads,
the direction of cuts, the height of the torch and what holds it there, and what is switched
besides. Each changes one place of a program at random, or gives None where the program has nothing
of the kind.
"""

import random
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import Severity, errors_in
from beamcam.geometry.curves import Arc
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Measures, Part
from beamcam.model.plan import SKIP_NAMES
from beamcam.pipeline import post
from benchmarks.liars import Lies
from benchmarks.sheet_liars import COLOURS, contour, lines, part_of

Lines = list[str]
Fault = Callable[[Lines, random.Random], Lines | None]

#: Tables that run G-code, with what their programs may have; leads are arcs, unless it says other.
TABLES: tuple[tuple[str, dict[str, object]], ...] = (
    ("plate-linuxcnc", {}), ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}),
    ("plate-linuxcnc", {"tabs": 2}), ("plate-codesys", {}), ("plate-oxyfuel", {"thickness": 10.0}),
    ("laser-grbl", {"material": "wood", "kerf_by": "offset"}), ("plate-mach3", {}),
    ("plate-qtplasmac", {}),
)  # fmt: skip
TOOL_ON = re.compile(r"^(?:N\d+ )?(?:M0?3(?: \$0)?(?: S1)?|M4 S\S+(?: F\S+)?)$")
TOOL_OFF = re.compile(r"^(?:N\d+ )?M0?5(?: \$0)?$")
MOVE = re.compile(r"^(?:N\d+ )?G0?([123]) X\S+ Y\S+")


def cuts(program: Sequence[str]) -> list[tuple[int, int, int]]:
    """Lines of each stroke: the rapid that goes there, its first move, and where the tool stops."""
    found = []
    rapid = 0
    on = -1
    for k, line in enumerate(program):
        if re.match(r"^(?:N\d+ )?G0?0 X", line):
            rapid = k
        elif TOOL_ON.match(line):
            on = k
        elif TOOL_OFF.match(line) and on >= 0:
            first = next(i for i in range(on, k + 1) if i == k or MOVE.match(program[i]))
            if first < k:
                found.append((rapid, first, k))
            on = -1
    return found


def _stroke(program: Lines, chance: random.Random, moves: int = 2) -> tuple[int, int, int] | None:
    fitting = [cut for cut in cuts(program) if cut[2] - cut[1] >= moves]
    return chance.choice(fitting) if fitting else None


def _put(program: Lines, at: int, *blocks: str) -> Lines:
    return [*program[:at], *blocks, *program[at:]]


def outline_before_its_openings(program: Lines, chance: random.Random) -> Lines | None:
    """The last stroke, which frees the part, comes first."""
    each = cuts(program)
    (first, *_), (last, _, end) = each[0], each[-1]
    own = program[last : end + 1]
    return [*program[:first], *own, *program[first:last], *program[end + 1 :]]


def dwell_in_mid_cut(program: Lines, chance: random.Random) -> Lines | None:
    cut = _stroke(program, chance)
    if cut is None:
        return None
    seconds = "G04 T1" if any("G04 T" in line for line in program) else "G4 P1"
    return _put(program, chance.randint(cut[1] + 1, cut[2] - 1), seconds)


def off_and_on_in_mid_cut(program: Lines, chance: random.Random) -> Lines | None:
    cut = _stroke(program, chance)
    if cut is None:
        return None
    start = next(k for k in reversed(range(cut[1])) if TOOL_ON.match(program[k]))
    again = [program[cut[2]], *program[start : cut[1]]]
    return _put(program, chance.randint(cut[1] + 1, cut[2] - 1), *again)


def tool_left_on(program: Lines, chance: random.Random) -> Lines | None:
    cut = _stroke(program, chance)
    return None if cut is None else [*program[: cut[2]], *program[cut[2] + 1 :]]


def compensation_not_asked(program: Lines, chance: random.Random) -> Lines | None:
    """Another word for it than the program has, or one where it has none."""
    if any(re.search(r"G4[12]\b", line) for line in program):
        return None
    cut = _stroke(program, chance)
    if cut is None or any(line.startswith("M4 S") for line in program):
        return None
    word = "G41 D3" if any("G04 T" in line for line in program) else "G42.1 D2"
    return _put(program, cut[1], word)


def corners_rounded(program: Lines, chance: random.Random) -> Lines | None:
    """A path that the controller may leave by 5 mm."""
    at = next((k for k, line in enumerate(program) if "G64 P" in line), None)
    if at is None:
        return None
    return [*program[:at], re.sub(r"G64 P\S+", "G64 P5", program[at]), *program[at + 1 :]]


def inches(program: Lines, chance: random.Random) -> Lines | None:
    at = next((k for k, line in enumerate(program) if re.search(r"\bG21\b", line)), None)
    if at is None:
        return None
    return [*program[:at], program[at].replace("G21", "G20"), *program[at + 1 :]]


def off_the_table(program: Lines, chance: random.Random) -> Lines | None:
    """A rapid by way of a place that lies 10 m beyond the table."""
    cut = _stroke(program, chance, 1)
    if cut is None:
        return None
    return _put(program, cut[0], re.sub(r"X\S+", "X19999.000", program[cut[0]]))


def faster_than_the_axes(program: Lines, chance: random.Random) -> Lines | None:
    fed = [k for k, line in enumerate(program) if re.search(r" F\d", line)]
    if not fed:
        return None
    at = chance.choice(fed)
    changed = re.sub(r" F[\d.]+", " F999999", program[at])
    return [*program[:at], changed, *program[at + 1 :]]


def _led(program: Lines, chance: random.Random) -> tuple[int, int, int] | None:
    """A stroke that begins with an arc or a line into the contour, which is longer than a lead."""
    return _stroke(program, chance, 4)


def pierced_in_the_contour(program: Lines, chance: random.Random) -> Lines | None:
    """The lead is left out: the rapid goes to where it would end."""
    cut = _led(program, chance)
    if cut is None:
        return None
    there = re.search(r"X\S+ Y\S+", program[cut[1]])
    assert there is not None
    rapid = re.sub(r"X\S+ Y\S+", there[0], program[cut[0]])
    return [*program[: cut[0]], rapid, *program[cut[0] + 1 : cut[1]], *program[cut[1] + 1 :]]


def pierced_in_the_part(program: Lines, chance: random.Random) -> Lines | None:
    """The pierce is mirrored at the point where the lead meets the contour."""
    cut = _led(program, chance)
    if cut is None:
        return None
    (px, py), (x, y) = _place(program[cut[0]]), _place(program[cut[1]])
    there = f"X{2 * x - px:.3f} Y{2 * y - py:.3f}"
    rapid = re.sub(r"X\S+ Y\S+", there, program[cut[0]])
    lead = f"G1 X{x:.3f} Y{y:.3f}"
    feed = re.search(r" F\S+", program[cut[1]])
    lead = re.match(r"^(N\d+ )?", program[cut[1]])[0] + lead + (feed[0] if feed else "")  # type: ignore[index]
    return [*program[: cut[0]], rapid, *program[cut[0] + 1 : cut[1]], lead, *program[cut[1] + 1 :]]


def _place(line: str) -> tuple[float, float]:
    found = re.search(r"X(\S+) Y(\S+)", line)
    assert found is not None
    return float(found[1]), float(found[2])


def _one(program: Lines, chance: random.Random, pattern: str) -> int | None:
    """The number of a line of the pattern; None if there is none."""
    found = [k for k, line in enumerate(program) if re.fullmatch(pattern, line)]
    return chance.choice(found) if found else None


def _changed(
    program: Lines, chance: random.Random, pattern: str, *blocks: str, more: int = 1
) -> Lines | None:
    """Other blocks in the place of one of a pattern, and of those behind it up to `more`."""
    at = _one(program, chance, pattern)
    return None if at is None else [*program[:at], *blocks, *program[at + more :]]


def _instead(pattern: str, *others: Sequence[str], more: int = 1) -> Fault:
    """The fault of some other blocks in the place of one of a pattern, as of `_changed`."""
    return lambda program, chance: _changed(
        program, chance, pattern, *chance.choice(others), more=more
    )


def _turned_round(program: Lines, chance: random.Random, first: str, last: str) -> Lines | None:
    """Two blocks, one right behind the other, in the other order."""
    pairs = [
        k for k, (a, b) in enumerate(pairwise(program))
        if re.fullmatch(first, a) and re.fullmatch(last, b)
    ]  # fmt: skip
    if not pairs:
        return None
    at = chance.choice(pairs)
    return [*program[:at], program[at + 1], program[at], *program[at + 2 :]]


def traverse_between_the_heights(program: Lines, chance: random.Random) -> Lines | None:
    found = [
        k for k, (a, b) in enumerate(pairwise(program)) if a == "G0 Z20" and b.startswith("G0 X")
    ]  # fmt: skip
    if not found:
        return None
    at = chance.choice(found)
    low = chance.choice(([], ["G0 Z5"], ["G0 Z19"]))
    return [*program[:at], *low, *program[at + 1 :]]


def up_before_the_tool_is_off(program: Lines, chance: random.Random) -> Lines | None:
    at = _one(program, chance, r"M121")
    return None if at is None else [*program[:at], "M121", "G0 Z20", "M5", *program[at + 4 :]]


def never_up_at_first(program: Lines, chance: random.Random) -> Lines | None:
    at = next((k for k, line in enumerate(program) if line == "G53 G0 Z0"), None)
    return None if at is None else [*program[:at], *program[at + 1 :]]


def held_as_it_pierces(program: Lines, chance: random.Random) -> Lines | None:
    return _changed(program, chance, r"M3", "M120", "M3") if "M120" in program else None


def held_as_it_stops(program: Lines, chance: random.Random) -> Lines | None:
    found = _turned_round(program, chance, r"M121", r"M5")
    return _changed(program, chance, r"M121") if chance.random() < 0.5 else found


def share_left_for_the_next_program(program: Lines, chance: random.Random) -> Lines | None:
    at = next((k for k in reversed(range(len(program))) if program[k] == "M68 E3 Q0"), None)
    return None if at is None else [*program[:at], "M68 E3 Q50", *program[at + 1 :]]


def another_material(program: Lines, chance: random.Random) -> Lines | None:
    at = next((k for k, line in enumerate(program) if line.startswith("(o=0")), None)
    if at is None:
        return None
    name = chance.choice(("ph", "pd", "ch", "fr", "kw", "ca", "cv"))
    other = re.sub(rf"\b{name}=[\d.]+", f"{name}=7.7", program[at])
    return [*program[:at], other, *program[at + 1 :]]


def flame_too_short(program: Lines, chance: random.Random) -> Lines | None:
    at = _one(program, chance, r"M64 P0")
    seconds = ([], ["G4 P1"])
    return None if at is None else [*program[: at + 1], *chance.choice(seconds), *program[at + 2 :]]


def oxygen_before_the_flame(program: Lines, chance: random.Random) -> Lines | None:
    at = _one(program, chance, r"M64 P0")
    if at is None:
        return None
    flame, wait, oxygen = program[at : at + 3]
    return [*program[:at], oxygen, flame, wait, *program[at + 3 :]]


def flame_off_before_the_oxygen(program: Lines, chance: random.Random) -> Lines | None:
    return _turned_round(program, chance, r"M5", r"M65 P0")


def flame_left_on(program: Lines, chance: random.Random) -> Lines | None:
    at = next((k for k in reversed(range(len(program))) if program[k] == "M65 P0"), None)
    return None if at is None else [*program[:at], *program[at + 1 :]]


def output_left_on(program: Lines, chance: random.Random) -> Lines | None:
    """An output of which nothing is known is switched."""
    if not any("M64" in line or "M62" in line for line in program):
        return None
    at = next(k for k, line in enumerate(program) if line.startswith("G0 X"))
    return _put(program, at, "M64 P9")


def _named(*faults: Any) -> dict[str, Fault]:
    return {fault.__name__: fault for fault in faults}


#: The faults of each class by their names.
BY_CLASS: dict[str, dict[str, Fault]] = {
    "order": _named(outline_before_its_openings),
    "state": _named(dwell_in_mid_cut, off_and_on_in_mid_cut, tool_left_on, compensation_not_asked,
                    corners_rounded, inches),
    "limits": _named(off_the_table, faster_than_the_axes),
    "leads": _named(pierced_in_the_contour, pierced_in_the_part),
    "heights": {
        "pierced_at_another_height": _instead(
            r"G0 Z3\.8", ["G0 Z0.5"], ["G0 Z2.8"], ["G0 Z5"], ["G0 Z12"]
        ),
        "cut_at_another_height": _instead(
            r"G1 Z1\.5 F1500", *([f"G1 Z{height} F1500"] for height in (0.4, 1.2, 2, 3.8, 6))
        ),
        "down_as_a_traverse": _instead(r"G1 Z1\.5 F1500", ["G0 Z1.5"]),
        "never_down_to_the_cut": _instead(r"G1 Z1\.5 F1500", []),
        "no_touch": _instead(r"G31 Z-150 F600", []),
        "no_zero_behind_the_touch": _instead(r"G92 Z-3", []),
        "another_zero": _instead(
            r"G92 Z-3", ["G92 Z-2.5"], ["G92 Z0"], ["G92 Z3"], ["G92 Z-30"]
        ),
        "zero_left_for_the_next_program": _instead(r"G92\.1", []),
        **_named(traverse_between_the_heights, up_before_the_tool_is_off, never_up_at_first),
    },
    "held": {
        "not_held": _instead(r"M120", []),
        "held_in_a_small_hole": _instead(r"M62 P2", []),
        "not_held_behind_a_small_hole": _instead(r"M63 P2", []),
        **_named(held_as_it_pierces, held_as_it_stops),
    },
    "switched": {
        "share_left_behind_a_small_hole": _instead(r"M67 E3 Q0", []),
        "another_share": _instead(
            r"M67 E3 Q60", *([f"M67 E3 Q{share}"] for share in (30, 61, 90, 100))
        ),
        "no_material": _instead(r"\(o=0.*", []),
        "places_of_the_scribe": _instead(r"T0 M6", [], more=2),
        "oxygen_without_the_flame": _instead(r"M64 P0", []),
        **_named(share_left_for_the_next_program, another_material, flame_too_short,
                 oxygen_before_the_flame, flame_off_before_the_oxygen, flame_left_on,
                 output_left_on),
    },
}  # fmt: skip


def sheet() -> Part:
    """A plate with openings of every kind of corner and a line that is marked."""
    outline = lines((0.0, 0.0), (160.0, 0.0), (160.0, 100.0), (60.0, 100.0), (0.0, 60.0))
    window = lines((95.0, 20.0), (145.0, 20.0), (145.0, 70.0), (95.0, 70.0))
    return part_of(
        (
            contour(outline, "#ff0000"),
            contour((Arc((45.0, 40.0), 22.0, 0.0, 360.0),), "#ff0000"),
            contour((Arc((80.0, 84.0), 8.0, 0.0, 360.0),), "#ff0000"),
            contour(window, "#ff0000"),
            contour(lines((105.0, 85.0), (135.0, 85.0), closed=False), "#0000ff"),
        ),
        Measures(),
    )


def told(each: int, seed: int) -> Lies:
    """Every fault, `each` times in the program of every table, and every table's cuts turned."""
    chance = random.Random(seed)
    result = Lies(Counter(), Counter(), [])
    part = sheet()

    def tell(kind: str, where: str, text: str, machine: Machine) -> None:
        said = verify_sheet(text, (part,), machine, SKIP_NAMES)
        refused = any(one.severity is Severity.ERROR for one in said)
        result.made[kind] += 1
        result.caught[kind] += refused
        if not refused:
            result.missed.append((where, kind))

    for name, values in TABLES:
        where = " ".join([name, *(f"{key}={value}" for key, value in values.items())])
        ways = {
            way: with_torch(load(name), colours=COLOURS, allow_open=True, direction=way, **values)  # type: ignore[arg-type]
            for way in ("climb", "conventional")
        }
        for asked, other in (("climb", "conventional"), ("conventional", "climb")):
            text = _text_of(part, ways[asked])
            assert not errors_in(verify_sheet(text, (part,), ways[asked], SKIP_NAMES)), where
            tell("direction turned", where, _text_of(part, ways[other]), ways[asked])
        for kind, fault, text in _broken(_text_of(part, ways["climb"]), each, chance):
            tell(f"{kind} {fault}", where, text, ways["climb"])
    return result


def _text_of(part: Part, machine: Machine) -> str:
    text = post([part], machine, skips=SKIP_NAMES).text
    assert isinstance(text, str)
    return text


def _broken(text: str, each: int, chance: random.Random) -> Iterator[tuple[str, str, str]]:
    """Class, name and program of each fault that a program can have."""
    for kind, faults in BY_CLASS.items():
        for name, fault in faults.items():
            for _ in range(each):
                program = fault(text.split("\n"), chance)
                if program is not None:
                    yield kind, name, "\n".join(program)
