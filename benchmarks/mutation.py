"""How many faulty programs the read-back catches.

Every emitted program of the samples is broken in one place, many times over: blocks dropped,
doubled and swapped, signs flipped, digits changed, words exchanged, spindles, tools, diameters
and angles replaced. `outcome` tells, in a way that shares nothing with the read-back, whether what
the machine makes is another thing now. All such mutants have to be caught, and programs that only
look different (renumbered, respaced, commented, leading zeros) have to raise nothing.

    python benchmarks/mutation.py [--mutants 2000] [--seed 1]
"""

import argparse
import random
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from math import radians, tan
from pathlib import Path

from msgspec import Struct

from beamcam.errors import Diagnostic, Severity
from beamcam.machine import Machine, load
from beamcam.model.part import Part
from beamcam.pipeline import parts_of, post, read_file
from beamcam.planning import SKIP_NAMES
from beamcam.verify import FeatureRef, verify

ROOT = Path(__file__).resolve().parent.parent
MACHINES = ("beamline", "beamline-annex", "beamline-pusher")
BARS = (
    ("beam",), ("channel",), ("strut",), ("tie",), ("beam", "beam"), ("strut", "strut"),
    ("tie", "tie", "tie"), ("channel", "channel"),
)  # fmt: skip
FACES = {1: "o", 2: "v", 3: "u"}  #: of the cell's spindles
PAIR = 13


class Case(Struct, frozen=True):
    """A program as it was emitted, and what it was made from."""

    name: str
    text: str
    parts: tuple[Part, ...]
    machine: Machine
    skipped: frozenset[FeatureRef]

    def said(self, text: str) -> tuple[Diagnostic, ...]:
        return verify(text, self.parts, self.machine, self.skipped)

    def caught(self, text: str) -> bool:
        return any(d.severity is not Severity.NOTE for d in self.said(text))


def cases(machines: Sequence[str] = MACHINES) -> Iterator[Case]:
    """The programs of all samples."""
    for name in machines:
        machine = load(name)
        for bar in BARS:
            parts, _ = parts_of(read_file(str(ROOT / f"samples/dstv/{s}.nc1")) for s in bar)
            length = max(6000.0, 500 + sum(p.length + 20 for p in parts))
            posted = post(parts, machine, bar=length, skips=SKIP_NAMES)
            skipped = frozenset(o.feature for o in posted.plan.outcomes if o.how == "skipped")
            yield Case(f"{name} {'+'.join(bar)}", posted.text, parts, machine, skipped)


# What a program makes, told in the simplest way


Outcome = list[tuple[object, ...]]


def outcome(text: str) -> Outcome:
    """Cuts, feeds and their circumstances in order, and the header; numbers as they stand."""
    x = y = z = 0.0
    spindle: tuple[float, float] | None = None
    turning = 0
    cooling = False
    header: dict[str, object] = {}
    done: Outcome = []
    for line in text.splitlines():
        words = line.split()
        if words and words[0].startswith("N"):
            words = words[1:]
        if not words or words[0][0] not in "GM":
            continue
        command, number = words[0][0], int(words[0][1:])
        values = {w[0]: float(w[1:]) for w in words[1:]}
        if command == "G" and number in (0, 1):
            before = (x, y, z)
            x, y, z = values.get("X", x), values.get("Y", y), values.get("Z", z)
            if number == 1 and "Y" in values and (x, y, z) != before:
                web = spindle is not None and FACES.get(int(spindle[0])) == "v"
                if spindle is None or (z if web else y) > 0:  # the bar begins at 0
                    slanted = (x, y) != before[:2] if web else (x, z) != before[::2]
                    done.append(("feed", spindle, turning, cooling, slanted, x, y, z))
        elif command == "M" and number == 40:
            spindle = values.get("K", 0.0), values.get("L", 0.0)
        elif command == "M" and number in (41, 42):
            done.append(("cut", number, x, values.get("K"), values.get("L")))
        elif command == "M" and number in (43, 44):
            header[f"M{number}"] = tuple(values.items())
        elif command == "M" and number in (3, 4, 5):
            turning = number if number < 5 else 0
        elif command == "M" and number in (8, 9):
            cooling = number == 8
        elif command == "M" or number != 90:
            done.append((command, number))
    # Of cuts at one place any may come first.
    ordered: Outcome = []
    for cut, run in groupby(done, lambda d: d[2] if d[0] == "cut" else None):
        group = list(run)
        ordered += group if cut is None else sorted(group, key=str)
    return [*ordered, ("header", *sorted(header.items()))]


def changed(old: Outcome, new: Outcome, part: Part, resolution: float) -> bool:
    """Whether something else is made; a stroke that still goes through makes the same hole."""
    return len(old) != len(new) or any(
        not _same(a, b, part, resolution) for a, b in zip(old, new, strict=True)
    )


def _same(old: tuple[object, ...], new: tuple[object, ...], part: Part, step: float) -> bool:
    if old == new:
        return True
    if old[0] != "feed" or new[0] != "feed" or old[:6] != new[:6]:
        return False
    spindle, diameter = old[1]  # type: ignore[misc]
    face = FACES.get(int(spindle), "o")
    across, stroke = (6, 7) if face == "v" else (7, 6)
    was, now = float(str(old[stroke])), float(str(new[stroke]))
    profile = part.profile
    tip = diameter / 2 / tan(radians(118) / 2)
    through = profile.face_depth(face) + profile.thickness(face) + tip
    return old[across] == new[across] and through - step <= now <= was


# Mutants


Mutate = Callable[[list[str], random.Random, float], list[str] | None]
_WORD = re.compile(r"([XYZKL])(-?\d+(?:\.\d+)?)")


def _blocks(lines: Sequence[str]) -> list[int]:
    return [i for i, line in enumerate(lines) if line.startswith("N")]


def _pick(lines: Sequence[str], rng: random.Random, pattern: str) -> int | None:
    fitting = [i for i, line in enumerate(lines) if re.search(pattern, line)]
    return rng.choice(fitting) if fitting else None


def drop(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = rng.choice(_blocks(lines))
    return lines[:at] + lines[at + 1 :]


def double(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = rng.choice(_blocks(lines))
    return lines[: at + 1] + lines[at:]


def swap(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = rng.choice(_blocks(lines)[:-1])
    return [*lines[:at], lines[at + 1], lines[at], *lines[at + 2 :]]


def swap_far(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    blocks = _blocks(lines)
    a, b = rng.choice(blocks), rng.choice(blocks)
    result = list(lines)
    result[a], result[b] = result[b], result[a]
    return result


def _replace(lines: list[str], at: int, word: re.Match[str], new: str) -> list[str]:
    line = lines[at]
    return [*lines[:at], line[: word.start()] + new + line[word.end() :], *lines[at + 1 :]]


def _some_word(lines: list[str], rng: random.Random) -> tuple[int, re.Match[str]]:
    at = rng.choice([i for i in _blocks(lines) if _WORD.search(lines[i])])
    return at, rng.choice(list(_WORD.finditer(lines[at])))


def flip_sign(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at, word = _some_word(lines, rng)
    if float(word[2]) == 0:
        return None
    digits = word[2][1:] if word[2].startswith("-") else f"-{word[2]}"
    return _replace(lines, at, word, word[1] + digits)


def change_digit(lines: list[str], rng: random.Random, step: float) -> list[str] | None:
    at, word = _some_word(lines, rng)
    places = [i for i, c in enumerate(word[2]) if c.isdigit()]
    place = rng.choice(places)
    digit = rng.choice([d for d in "0123456789" if d != word[2][place]])
    digits = word[2][:place] + digit + word[2][place + 1 :]
    if abs(float(digits) - float(word[2])) < 2 * step:
        return None  # within what the output can tell apart
    return _replace(lines, at, word, word[1] + digits)


def exchange_axes(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = _pick(lines, rng, r"X\S+ Y\S+ Z")
    if at is None:
        return None
    a, b = rng.sample("XYZ", 2)
    table = str.maketrans({a: b, b: a})
    return [*lines[:at], lines[at].translate(table), *lines[at + 1 :]]


def wrong_spindle(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = _pick(lines, rng, r"M40 K")
    if at is None:
        return None
    number = re.search(r"M40 K(\d+)", lines[at])
    other = rng.choice([str(n) for n in (*FACES, PAIR) if str(n) != number[1]])  # type: ignore[index]
    return [*lines[:at], re.sub(r"M40 K\d+", f"M40 K{other}", lines[at]), *lines[at + 1 :]]


def wrong_diameter(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = _pick(lines, rng, r"M40 K\d+ L")
    if at is None:
        return None
    old = float(re.search(r"L(\S+)", lines[at])[1])  # type: ignore[index]
    new = old + rng.choice((-4, -2, -1, 1, 2, 4, 0.75))
    return [*lines[:at], re.sub(r"L\S+", f"L{new:g}", lines[at]), *lines[at + 1 :]]


def negate_angle(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = _pick(lines, rng, r"M4[12] K-?[1-9]")
    if at is None:
        return None
    line = lines[at].replace("K-", "K", 1) if "K-" in lines[at] else lines[at].replace("K", "K-", 1)
    return [*lines[:at], line, *lines[at + 1 :]]


def drop_m_word(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = _pick(lines, rng, r" M\d+")
    return None if at is None else lines[:at] + lines[at + 1 :]


def other_m_word(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = _pick(lines, rng, r" M\d+")
    if at is None:
        return None
    number = re.search(r" M(\d)(\d)", lines[at])
    digit = rng.choice([d for d in "0123456789" if d != number[2]])  # type: ignore[index]
    new = f" M{number[1]}{digit}"  # type: ignore[index]
    return [*lines[:at], re.sub(r" M\d\d", new, lines[at]), *lines[at + 1 :]]


def truncate(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    return lines[: rng.choice(_blocks(lines))]


MUTATIONS: tuple[Mutate, ...] = (
    drop, double, swap, swap_far, flip_sign, change_digit, change_digit, change_digit,
    exchange_axes, wrong_spindle, wrong_diameter, negate_angle, drop_m_word, other_m_word, truncate,
)  # fmt: skip


# Programs that only look different


def renumbered(text: str, rng: random.Random) -> str:
    step = rng.choice((1, 5, 10))
    counter = iter(range(step, 10**9, step))
    return re.sub(r"(?m)^N\d+", lambda _: f"N{next(counter)}", text)


def unnumbered(text: str, rng: random.Random) -> str:
    return re.sub(r"(?m)^N\d+ ", "", text)


def respaced(text: str, rng: random.Random) -> str:
    blank = rng.choice(("  ", "\t", " \t "))
    return "\n".join(f" {line.replace(' ', blank)} " for line in text.split("\n"))


def commented(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    for _ in range(5):
        lines.insert(rng.randrange(1, len(lines) - 2), "(checked by hand, X1 and M30)")
    at = rng.randrange(1, len(lines) - 3)
    lines[at] += " (M05)"
    return "\n".join(lines)


def leading_zeros(text: str, rng: random.Random) -> str:
    text = re.sub(r"([XYZ])(-?)(\d)", r"\1\g<2>00\3", text)
    return re.sub(r"\b([GM])(\d)", r"\g<1>0\2", text)


def trailing_zeros(text: str, rng: random.Random) -> str:
    return re.sub(r"(?<=[ ])([XYZ]-?\d+)(?=\s)", r"\1.000", text)


def short_commands(text: str, rng: random.Random) -> str:
    return re.sub(r"\b([GM])0(\d)", r"\1\2", text)


def lower_case(text: str, rng: random.Random) -> str:
    first, _, rest = text.partition("\n")
    return first + "\n" + rest.lower()


def other_line_ends(text: str, rng: random.Random) -> str:
    return text.replace("\n", "\r\n")


def blank_lines(text: str, rng: random.Random) -> str:
    return text.replace("\nN", "\n\nN")


def other_name(text: str, rng: random.Random) -> str:
    return re.sub(r"% \w+", "% ANOTHER", text)


REWRITES: tuple[Callable[[str, random.Random], str], ...] = (
    renumbered, unnumbered, respaced, commented, leading_zeros, trailing_zeros, short_commands,
    lower_case, other_line_ends, blank_lines, other_name,
)  # fmt: skip


class Score(Struct):
    """What became of the mutants."""

    made: Counter[str]
    caught: Counter[str]
    harmless: int  #: mutants that make the same thing
    said_of_harmless: int  #: those of them that break a rule all the same
    missed: list[tuple[str, str, str]]  #: case, mutation, text
    rewrites: int
    false_alarms: list[tuple[str, str, str]]  #: case, rewrite, first message


def score(mutants: int, seed: int, programs: Sequence[Case] | None = None) -> Score:
    """At least `mutants` programs that make something else, and every rewrite of every program."""
    rng = random.Random(seed)
    programs = programs if programs is not None else list(cases())
    result = Score(Counter(), Counter(), 0, 0, [], 0, [])
    originals = [(c, c.text.split("\n"), outcome(c.text)) for c in programs]
    seen: set[tuple[str, str]] = set()
    turns = 0
    while sum(result.made.values()) < mutants and turns < 20 * mutants:
        case, lines, before = originals[turns % len(originals)]
        mutate = MUTATIONS[turns // len(originals) % len(MUTATIONS)]
        turns += 1
        found = mutate(list(lines), rng, case.machine.format.resolution)
        text = "\n".join(found) if found is not None else case.text
        if text == case.text or (case.name, text) in seen:
            continue
        seen.add((case.name, text))
        caught = case.caught(text)
        if not changed(before, outcome(text), case.parts[0], case.machine.format.resolution):
            result.harmless += 1
            result.said_of_harmless += caught
            continue
        result.made[mutate.__name__] += 1
        result.caught[mutate.__name__] += caught
        if not caught:
            result.missed.append((case.name, mutate.__name__, text))
    for case, _, _ in originals:
        for rewrite in REWRITES:
            result.rewrites += 1
            said = case.said(rewrite(case.text, rng))
            if said:
                result.false_alarms.append((case.name, rewrite.__name__, str(said[0])))
    return result


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--mutants", type=int, default=2000)
    arguments.add_argument("--seed", type=int, default=1)
    asked = arguments.parse_args()
    result = score(asked.mutants, asked.seed)
    for name in result.made:
        print(f"{name:15} {result.caught[name]:5} of {result.made[name]:5} caught")
    made, caught = sum(result.made.values()), sum(result.caught.values())
    print(f"{'all':15} {caught:5} of {made:5} mutants caught ({100 * caught / made:.2f} %)")
    print(
        f"{result.harmless} more make the same thing; "
        f"{result.said_of_harmless} of them break a rule and are refused for that"
    )
    print(f"{result.rewrites} rewrites of unchanged meaning, {len(result.false_alarms)} alarms")
    for name, mutation, text in result.missed[:5]:
        print(f"\nmissed: {name}, {mutation}")
        original = next(c.text for c in cases() if c.name == name).split("\n")
        pairs = enumerate(zip(original, text.split("\n"), strict=False), 1)
        print(next((f"line {i}: {a!r} -> {b!r}" for i, (a, b) in pairs if a != b), "cut short"))
    for alarm in result.false_alarms[:5]:
        print("alarm:", *alarm)


if __name__ == "__main__":
    main()
