"""Texts of programs for copers and tubes with one thing wrong, by class."""

import random
import re
from collections.abc import Callable
from itertools import pairwise

Lines = list[str]
OfText = Callable[[Lines, random.Random], Lines | None]


def _line(pattern: str, change: Callable[[re.Match[str], random.Random], str]) -> OfText:
    """One of the lines that a pattern matches, changed."""

    def of_text(lines: Lines, chance: random.Random) -> Lines | None:
        which = [k for k, line in enumerate(lines) if re.fullmatch(pattern, line)]
        if not which:
            return None
        k = chance.choice(which)
        match = re.fullmatch(pattern, lines[k])
        assert match is not None
        return [*lines[:k], *change(match, chance).split("\n"), *lines[k + 1 :]]

    return of_text


def _higher(lines: Lines, chance: random.Random, by: float) -> Lines | None:
    """A stroke with its tip higher or lower over the steel."""
    ons = [k for k, line in enumerate(lines) if line == "M3 S1"]
    k = chance.choice(ons)
    end = next(i for i in range(k, len(lines)) if lines[i] == "M5")
    turned = next(line for line in reversed(lines[:k]) if line.startswith("G0 A"))
    axis, sign = {"G0 A0": ("Z", 1), "G0 A-90": ("Y", 1), "G0 A90": ("Y", -1)}[turned]
    found = [
        re.sub(rf"{axis}(-?[\d.]+)", lambda m: f"{axis}{float(m[1]) + sign * by:g}", line)
        if line.startswith("G1") else line
        for line in lines[k:end]
    ]  # fmt: skip
    return [*lines[:k], *found, *lines[end:]]


def _elsewhere(lines: Lines, chance: random.Random) -> Lines | None:
    """A place of a path, behind its lead, 9 mm along the bar."""

    def is_along(k: int) -> bool:
        """Whether a path goes on along the bar there, so that it hardly matters."""
        across = [line.split()[2:4] for line in lines[k - 1 : k + 2]]
        ys = [[float(word[1:]) for word in words] for words in across]
        return all(abs(max(of) - min(of)) < 1.0 for of in zip(*ys, strict=True))

    which = [k for k, line in enumerate(lines)
             if k > 3 and all(one.startswith("G1") for one in lines[k - 3 : k + 2])
             and not is_along(k)]  # fmt: skip
    if not which:
        return None
    k = chance.choice(which)
    x = float(lines[k].split()[1][1:]) + chance.choice((-9.0, 9.0))
    return [*lines[:k], " ".join(["G1", f"X{x:g}", *lines[k].split()[2:]]), *lines[k + 1 :]]


def _a_off(lines: Lines, chance: random.Random) -> Lines | None:
    """A turn before a cut, a few degrees off."""
    turns = [k for k, line in enumerate(lines) if line.startswith("G0 A")]
    ends = [*turns[1:], len(lines)]
    k = chance.choice([a for a, b in zip(turns, ends, strict=True) if "M5" in lines[a:b]])
    wrong = float(lines[k].removeprefix("G0 A")) + chance.choice((-3, 2))
    return [*lines[:k], f"G0 A{wrong:g}", *lines[k + 1 :]]


def _dropped(pattern: str) -> OfText:
    def of_text(lines: Lines, chance: random.Random) -> Lines | None:
        which = [k for k, line in enumerate(lines) if re.fullmatch(pattern, line)]
        k = chance.choice(which) if which else None
        return None if k is None else [*lines[:k], *lines[k + 1 :]]

    return of_text


TEXTS: dict[str, OfText] = {
    "A off its face": lambda lines, c: _a_off(lines, c),
    "A to the other side": _line(r"G0 A(-?)90", lambda m, c: f"G0 A{'' if m[1] else '-'}90"),
    "A on the way": _line(r"(G1 .*)", lambda m, c: f"{m[1]} A45"),
    "A missing": _dropped(r"G0 A-?90"),
    "F of a block": _line(r"(G1 .*)", lambda m, c: f"{m[1]} F{c.choice((501, 2201))}"),
    "F of a stroke": _line(r"F(\d+)", lambda m, c: f"F{float(m[1]) * c.choice((0.5, 1.1)):g}"),
    "tip too high": lambda lines, c: _higher(lines, c, 1.0),
    "tip too low": lambda lines, c: _higher(lines, c, -1.0),
    "pierce too short": _line(r"G4 P([\d.]+)", lambda m, c: f"G4 P{float(m[1]) / 2:g}"),
    "torch not started": _dropped("M3 S1"),
    "torch not stopped": _dropped("M5"),
    "rapid with the torch on": _line(r"G1 (.*)", lambda m, c: f"G0 {m[1]}"),
    "corners cut short": _line(r"G64 P0.02", lambda m, c: c.choice(("G64 P2", "G64"))),
    "inches": _line(r"G21(.*)", lambda m, c: f"G20{m[1]}"),
    "relative": _line(r"(.*)G90 (.*)", lambda m, c: f"{m[1]}G91 {m[2]}"),
    "x of a place": lambda lines, c: _elsewhere(lines, c),
    "through the bar": _line(r"G0 X(\S+) Y(\S+) Z(\S+)", lambda m, c: f"G0 X{m[1]} Y50 Z5"),
    "beyond an axis": _line(r"G0 X(\S+) (.*)", lambda m, c: f"G0 X99999 {m[2]}"),
    "cut off in the middle": lambda lines, c: lines[: len(lines) // 2],
    "an arc": _line(r"G1 (X\S+ Y\S+) (.*)", lambda m, c: f"G2 {m[1]} I3 J4"),
}  # fmt: skip


def _tilts(lines: Lines) -> list[int]:
    """Turns of B away from 0, each before a cut."""
    return [k for k, line in enumerate(lines)
            if re.fullmatch(r"G0 A\S+ B-?[\d.]+", line) and not line.endswith(" B0")]  # fmt: skip


def _tilted(change: Callable[[float, random.Random], float]) -> OfText:
    """B of one cut, changed."""

    def of_text(lines: Lines, chance: random.Random) -> Lines | None:
        which = _tilts(lines)
        if not which:
            return None
        k = chance.choice(which)
        before, b_deg = lines[k].rsplit(" B", 1)
        other = f"{before} B{change(float(b_deg), chance):g}"
        return [*lines[:k], other, *lines[k + 1 :]]

    return of_text


def _without_tilt(lines: Lines, chance: random.Random) -> Lines | None:
    """The turn to B of one cut, missing."""
    which = _tilts(lines)
    k = chance.choice(which) if which else None
    return None if k is None else [*lines[:k], *lines[k + 1 :]]


#: Of a program whose torch tilts.
TILT_TEXTS: dict[str, OfText] = {
    **{name: TEXTS[name] for name in (
        "A on the way", "F of a block", "F of a stroke", "pierce too short", "torch not started",
        "torch not stopped", "rapid with the torch on", "inches", "relative", "beyond an axis",
        "cut off in the middle",
    )},
    "B of a line the other way": _tilted(lambda b, c: -b),
    "B of a line 0": _tilted(lambda b, c: 0.0),
    "B of a line off": _tilted(lambda b, c: b + c.choice((-3, 3))),
    "B beyond its reach": _tilted(lambda b, c: 58.0 if b > 0 else -58.0),
    "B missing": lambda lines, c: _without_tilt(lines, c),
    "B on the way": _line(r"(G1 .*)", lambda m, c: f"{m[1]} B{c.choice((-40, 40))}"),
    "B not turned back": lambda lines, c: _not_back(lines, c),
}  # fmt: skip


def _not_back(lines: Lines, chance: random.Random) -> Lines | None:
    """A torch that keeps its tilt for the next cut, which is not along the same end."""
    tilts = _tilts(lines)
    ends = [next((i for i in range(k + 1, len(lines)) if lines[i].startswith("G0 A")), 0)
            for k in tilts]  # fmt: skip
    ends = [i for i in ends if i and _square_cut_follows(lines, i)]
    if not ends:
        return None
    k = chance.choice(ends)
    return [*lines[:k], *lines[k + 1 :]]


def _square_cut_follows(lines: Lines, k: int) -> bool:
    """Whether the next cut behind a turn is made without another one."""
    behind = next((line for line in lines[k + 1 :] if line.startswith(("G0 A", "M3 "))), "")
    return behind.startswith("M3 ")


def _other_way(lines: Lines) -> Lines | None:
    """Every turn the other way round, of a tube with cut-outs."""
    if "(cut-out)" not in lines:
        return None

    def other(word: re.Match[str]) -> str:
        if float(word[2]) % 180.0 == 0.0:  # where a tube is alike
            return word[0]
        return f" A{'' if word[1] else '-'}{word[2]}"

    return [re.sub(r" A(-?)([\d.]+)", other, line) for line in lines]


def _corner_blocks(lines: Lines) -> list[int]:
    """Blocks in which a rectangular tube turns and Y and Z follow, as those before and behind."""
    ends = [re.fullmatch(r"G1 X\S+ Y(\S+) Z(\S+) A(\S+) F\S+", line) for line in lines]

    def turns(k: int) -> bool:
        a, b = ends[k - 1], ends[k]
        return a is not None and b is not None and all(a[n] != b[n] for n in (1, 2, 3))

    return [k for k in range(8, len(lines) - 8) if all(turns(k + n) for n in range(-6, 7))]


def _chord(lines: Lines, chance: random.Random) -> Lines | None:
    """A stretch of a corner in one block instead of thirteen."""
    which = _corner_blocks(lines)
    if not which:
        return None
    k = chance.choice(which)
    minutes = sum(1.0 / float(line.rsplit("F", 1)[1]) for line in lines[k - 6 : k + 7])
    last = f"{lines[k + 6].rsplit('F', 1)[0]}F{1.0 / minutes:.4f}"
    return [*lines[: k - 6], last, *lines[k + 7 :]]


def _straight_speed(lines: Lines, chance: random.Random) -> Lines | None:
    """A block in a corner whose time is that of X, Y and Z, as G94 would have it."""
    which = _corner_blocks(lines)
    if not which:
        return None
    k = chance.choice(which)
    here, there = ([float(word[1:]) for word in lines[n].split()[1:]] for n in (k - 1, k))
    turned = abs(there[3] - here[3]) * 3.141592653589793 / 180.0
    way = sum((b - a) ** 2 for a, b in zip(here[:3], there[:3], strict=True)) ** 0.5
    share = way / max(turned, 1e-9)
    return [*lines[:k], f"{lines[k].rsplit('F', 1)[0]}F{there[4] / max(share, 1.5):.4f}",
            *lines[k + 1 :]]  # fmt: skip


def _turned_low(lines: Lines, chance: random.Random) -> Lines | None:
    """A turn by a right angle at least, of a rectangular tube just over its surface."""
    height = re.search(r"HEIGHT (\S+) WIDTH (\S+):", "\n".join(lines))
    turns = [k for k, line in enumerate(lines) if line.startswith("G0 A")]
    pairs = [b for a, b in pairwise(turns)
             if abs(float(lines[a][4:]) - float(lines[b][4:])) >= 90.0]  # fmt: skip
    if height is None or not pairs or not _corner_blocks(lines):
        return None
    low = min(float(height[1]), float(height[2])) / 2 + 2.0
    k = chance.choice(pairs)
    return [*lines[: k - 1], re.sub(r"Z\S+", f"Z{low:g}", lines[k - 1]), *lines[k:]]


#: Of a program for a tube, which turns below the torch and whose F are inverse times.
TUBE_TEXTS: dict[str, OfText] = {
    **{name: TEXTS[name] for name in (
        "pierce too short", "torch not started", "torch not stopped", "rapid with the torch on",
        "corners cut short", "inches", "relative", "cut off in the middle", "beyond an axis",
    )},
    "A of a place": _line(
        r"(G1 .* A)(-?[\d.]+)( .*)", lambda m, c: f"{m[1]}{float(m[2]) + c.choice((-9, 9)):g}{m[3]}"
    ),
    "A missing": _dropped(r"G0 A-?[\d.]+"),
    "A the other way round": lambda lines, c: _other_way(lines),
    "F of a block": _line(
        r"(G1 .* F)([\d.]+)", lambda m, c: f"{m[1]}{float(m[2]) * c.choice((0.7, 1.2)):g}"
    ),
    "F missing": _line(r"(G1 .*) F[\d.]+", lambda m, c: m[1]),
    "no inverse time": _dropped("G93"),
    "beside the normal": _line(
        r"(G1 .* Y)(-?[\d.]+)( .*)",
        # Over a face of a rectangular tube Y is a place on it, which may be off by the tolerance.
        lambda m, c: f"{m[1]}{float(m[2]) + c.choice((-3, 0.5)):g}{m[3]}",
    ),
    "tip too high": _line(
        r"(G1 .* Z)([\d.]+)( .*)", lambda m, c: f"{m[1]}{float(m[2]) + 1:g}{m[3]}"
    ),
    "tip too low": _line(
        r"(G1 .* Z)([\d.]+)( .*)", lambda m, c: f"{m[1]}{float(m[2]) - 1:g}{m[3]}"
    ),
    "through the tube": _line(
        r"G0 X(\S+) Y(\S+) Z(\S+)", lambda m, c: f"G0 X{m[1]} Y{m[2]} Z10"
    ),
    "turned too low": lambda lines, c: _turned_low(lines, c),
    "corner by a chord": lambda lines, c: _chord(lines, c),
    "corner at the speed of X, Y and Z": lambda lines, c: _straight_speed(lines, c),
}  # fmt: skip


def _turned_back(lines: Lines) -> Lines | None:
    """Every turn of a profile the other way round, where its flanges are not cut alike."""

    def on(a: str) -> set[tuple[str, float]]:
        moves = [re.fullmatch(rf"G1 X(\S+) Y(\S+) Z\S+ A{a} F\S+", line) for line in lines]
        return {(m[1], round(float(m[2]) * (1 if a == "90" else -1), 2)) for m in moves if m}

    if on("90") == on("-90"):
        return None
    return [re.sub(r" A(-?)90\b", lambda m: f" A{'' if m[1] else '-'}90", line) for line in lines]


def _stroke(name: str, letter: str, by: float) -> OfText:
    """A cut of some names, its way down included, with all its words of a letter changed."""

    def of_text(lines: Lines, chance: random.Random) -> Lines | None:
        which = [k for k, line in enumerate(lines) if re.match(rf"\((?:{name})", line)]
        if not which:
            return None
        k = chance.choice(which)
        first, end = k + 1 if letter == "A" else k + 2, lines.index("M5", k)
        moved = [
            re.sub(rf" {letter}(\S+)", lambda m: f" {letter}{float(m[1]) + by:.8g}", line)
            for line in lines[first:end]
        ]
        return [*lines[:first], *moved, *lines[end:]]

    return of_text


def _into_the_wall(lines: Lines, chance: random.Random) -> Lines | None:
    """A travel into the wall that is farthest below the torch."""
    wide = re.search(r"WIDTH (\S+):", "\n".join(lines))
    which = [k for k, line in enumerate(lines) if line.startswith("G0 X")]
    if wide is None:
        return None
    k = chance.choice(which[1:])
    low = f"{lines[k].split()[0]} {lines[k].split()[1]} Y0 Z{-float(wide[1]) / 2:g}"
    return [*lines[:k], low, *lines[k + 1 :]]


def _lower(
    lines: Lines, chance: random.Random, which: Callable[[Lines], list[int]]
) -> Lines | None:
    """A travel before a turn just over the wall that lies flat."""
    height = re.search(r"HEIGHT (\S+) WIDTH (\S+):", "\n".join(lines))
    turns = which(lines)
    if height is None or not turns:
        return None
    low = min(float(height[1]), float(height[2])) / 2 + 2.0
    k = chance.choice(turns)
    return [*lines[: k - 1], re.sub(r"Z\S+", f"Z{low:g}", lines[k - 1]), *lines[k:]]


def _turns(lines: Lines) -> list[int]:
    return [k for k, line in enumerate(lines) if line.startswith("G0 A")]


def _later_turns(lines: Lines) -> list[int]:
    """Turns but the first one; none of an L or a T, one corner of whose box is missing."""
    is_open = any(re.match(r"\((SECTION L|THE T LIES)", line) for line in lines)
    return [] if is_open else _turns(lines)[1:]


_CUTS = "cut-out|notch|near end|far end"  #: as programs call them
#: Of a program for a profile, which turns between cuts.
TURNED_TEXTS: dict[str, OfText] = {
    **{name: TEXTS[name] for name in ("A to the other side", "x of a place", "an arc")},
    **{name: TUBE_TEXTS[name] for name in (
        "pierce too short", "torch not started", "torch not stopped", "rapid with the torch on",
        "corners cut short", "inches", "relative", "cut off in the middle", "beyond an axis",
        "A of a place", "A missing", "F of a block", "F missing", "no inverse time",
    )},
    "A the other way round": lambda lines, c: _turned_back(lines),
    "A off its face": _stroke(_CUTS, "A", 2.0), "cut-out across": _stroke("cut-out", "Y", 1.0),
    "tip too high": _stroke(_CUTS, "Z", 1.0), "tip too low": _stroke(_CUTS, "Z", -1.0),
    "into a wall": lambda lines, c: _into_the_wall(lines, c),
    "turned too low": lambda lines, c: _lower(lines, c, _later_turns),
    "first turn too low": lambda lines, c: _lower(lines, c, lambda those: _turns(those)[:1]),
}  # fmt: skip
