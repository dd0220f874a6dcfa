"""How many faulty programs the read-back catches.

Every emitted program of the samples is broken in one place, many times over: blocks dropped,
doubled and swapped, signs flipped, digits changed, words exchanged, spindles, tools, diameters
and angles replaced. `outcome` tells, in a way that shares nothing with the read-back, whether what
the machine makes is another thing now. All such mutants have to be caught, and programs that only
look different (renumbered, respaced, commented, leading zeros) have to raise nothing. Programs that
make the part but break a tool (`faults`), that a smaller machine could not run, or that are wrong
in order, state, limits, leads, direction, heights or outputs on a table (`sheet_faults`), in the
feed of holes and corners or in cuts that parts share (`feed_faults`), plans
that lie (`liars`, `sheet_liars`), jobs that are not what was asked for (`asked_liars`), and texts
that are not the part's (`letterings`) have to be refused too.

    python benchmarks/mutation.py [--mutants 2500] [--seed 1]
"""

import random
import re
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import groupby
from math import radians, tan
from pathlib import Path

from msgspec import Struct
from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parents[1]))

from beamcam.checks.bars import verify
from beamcam.checks.rules import LEFT_OUT, MANUAL_WORK
from beamcam.errors import Diagnostic, Severity, Source
from beamcam.machine import Machine, load
from beamcam.model.part import Hole, Part, Profile
from beamcam.model.plan import SKIP_NAMES
from beamcam.pipeline import parts_of, post, read_file
from benchmarks.asked_liars import told as told_of_jobs
from benchmarks.faults import FAULTS
from benchmarks.feed_faults import told as told_of_feeds
from benchmarks.heads import counted
from benchmarks.letterings import lettered_otherwise
from benchmarks.liars import PROFILES, told
from benchmarks.liars import parts as parts_of_lies
from benchmarks.mutants import FACES, MUTATIONS, REWRITES
from benchmarks.script import arguments, at_least, start
from benchmarks.sheet_faults import told as told_of_tables
from benchmarks.sheet_liars import told as told_of_sheets

ROOT = Path(__file__).resolve().parent.parent
FAULTS_EACH = 4  #: of each kind in every program
MACHINES = ("beamline", "beamline-annex", "beamline-pusher")
BARS = (
    ("beam",), ("channel",), ("strut",), ("tie",), ("beam", "beam"), ("strut", "strut"),
    ("tie", "tie", "tie"), ("channel", "channel"),
)  # fmt: skip


_SOURCE = Source("many.nc1", 1)
#: Seven drills for five stations.
MANY_TOOLS = Part(
    "MANY", Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0), 2500.0, _SOURCE,
    features=tuple(
        Hole("v", 300.0 + 150.0 * i, 150.0, 10.0 + 2 * i, _SOURCE) for i in range(7)
    ),
)  # fmt: skip


class Case(Struct, frozen=True):
    """A program as it was emitted, and what it was made from."""

    name: str
    text: str
    parts: tuple[Part, ...]
    machine: Machine
    bar: float  #: its length

    def said(self, text: str) -> tuple[Diagnostic, ...]:
        found = verify(text, self.parts, self.machine, SKIP_NAMES, bar=self.bar)
        return tuple(d for d in found if d.code not in (LEFT_OUT.code, MANUAL_WORK.code))

    def caught(self, text: str) -> bool:
        return any(d.severity is not Severity.NOTE for d in self.said(text))


def cases(machines: Sequence[str] = MACHINES) -> Iterator[Case]:
    """The programs of all samples, and one that stops for a tool by hand."""
    for name in machines:
        machine = load(name)
        if machine.words.change:
            posted = post([MANY_TOOLS], machine, bar=6000.0)
            yield Case(f"{name} many tools", posted.text, (MANY_TOOLS,), machine, 6000.0)
        for bar in BARS:
            parts, _ = parts_of(read_file(str(ROOT / f"samples/dstv/{s}.nc1")) for s in bar)
            length = max(6000.0, 500 + sum(p.length + 20 for p in parts))
            posted = post(parts, machine, bar=length, skips=SKIP_NAMES)
            yield Case(f"{name} {'+'.join(bar)}", posted.text, parts, machine, length)


def all_kinds() -> Case:
    """A program with every kind of work, which `outcome` does not tell apart but `faults` break."""
    machine = load(MACHINES[-1])
    parts = parts_of_lies(machine.name, PROFILES[0])
    posted = post(parts, machine, bar=6000.0)
    return Case(f"{machine.name} all kinds", posted.text, parts, machine, 6000.0)


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


class FaultScore(Struct):
    """What became of programs with a fault of the process; `alone` without parts at hand."""

    made: Counter[str]
    caught: Counter[str]
    alone: Counter[str]
    missed: list[tuple[str, str]]  #: case and fault


def faults(each: int, seed: int, programs: Sequence[Case] | None = None) -> FaultScore:
    """Every fault of the process, `each` times in every program that it is possible in."""
    rng = random.Random(seed)
    result = FaultScore(Counter(), Counter(), Counter(), [])
    for case in programs if programs is not None else [*cases(), all_kinds()]:
        lines = case.text.split("\n")
        for fault in FAULTS:
            for _ in range(each):
                found = fault(list(lines), rng)
                if found is None:
                    continue
                text = "\n".join(found)
                name = fault.__name__
                caught = any(d.severity is Severity.ERROR for d in case.said(text))
                result.made[name] += 1
                result.caught[name] += caught
                alone = verify(text, (), case.machine)
                result.alone[name] += any(d.severity is Severity.ERROR for d in alone)
                if not caught:
                    result.missed.append((case.name, name))
    return result


def beyond_limits(programs: Sequence[Case] | None = None) -> FaultScore:
    """Every program on a machine that is too small for it, by one limit after the other."""
    result = FaultScore(Counter(), Counter(), Counter(), [])
    for case in programs if programs is not None else [*cases(), all_kinds()]:
        machine, profile = case.machine, case.parts[0].profile
        saw, drill = machine.needed(machine.saw, "saw"), machine.needed(machine.drill, "drill")
        smaller = {
            "height at the saw": replace(machine, saw=replace(saw, max_height=profile.height - 1)),
            "width at the saw": replace(machine, saw=replace(saw, max_width=profile.width - 1)),
            "height at the drill": replace(
                machine, drill=replace(drill, max_height=profile.height - 1)
            ),
            "width at the drill": replace(
                machine, drill=replace(drill, max_width=profile.width - 1)
            ),
            "section": replace(
                machine,
                sections={k: v for k, v in machine.sections.items() if k != profile.code},
            ),
        }
        if re.search(r" M0[34] K", case.text):  # the annex leaves speeds and feeds to the machine
            smaller["spindle"] = replace(
                machine, drill=replace(drill, max_speed_rpm=drill.min_speed_rpm)
            )
            smaller["feed"] = replace(machine, drill=replace(drill, max_feed_mm_min=1.0))
        for limit, small in smaller.items():
            said = verify(case.text, case.parts, small, SKIP_NAMES, bar=case.bar)
            caught = any(d.severity is Severity.ERROR for d in said)
            result.made[limit] += 1
            result.caught[limit] += caught
            if not caught:
                result.missed.append((case.name, limit))
    return result


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
    parser = arguments(__doc__)
    parser.add_argument("--mutants", type=at_least(1), default=2500, help="default 2500")
    parser.add_argument("--seed", type=int, default=1, help="default 1")
    asked = parser.parse_args()
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
    broken = faults(FAULTS_EACH, asked.seed)
    for name in sorted(broken.made):
        of = f"{broken.caught[name]:5} of {broken.made[name]:5} caught"
        print(f"{name:22} {of}, {broken.alone[name]:5} without the parts")
    small, tables = beyond_limits(), told_of_tables(FAULTS_EACH, asked.seed)
    feeds = told_of_feeds(FAULTS_EACH, asked.seed)
    for title, one in (("limits: ", small), ("", tables), ("", feeds)):
        for name in sorted(one.made):
            print(f"{title + name:34} {one.caught[name]:5} of {one.made[name]:5} caught")
    alarms = sum(why == "alarm" for _, why in feeds.missed)
    print(f"{alarms} alarms of sound feeds and common cuts")
    scores = (small, tables, feeds)
    of = sum(one.made.total() for one in scores)
    print(f"{sum(one.caught.total() for one in scores)} of {of} beyond limits and of tables caught")
    lied = told(MACHINES)
    print(f"{sum(lied.caught.values())} of {sum(lied.made.values())} lies of the planner caught")
    changed_heads, refused_heads = counted()
    of = sum(changed_heads.values())
    print(f"{sum(refused_heads.values())} of {of} heads that say otherwise refused")
    letterings, caught_letterings = lettered_otherwise()
    for name, count in letterings.items():
        print(f"{name:22} {caught_letterings[name]:5} of {count:5} letterings refused")
    print(f"{caught_letterings.total()} of {letterings.total()} wrong letterings refused")
    sheets = told_of_sheets()
    print(f"{sum(sheets.caught.values())} of {sum(sheets.made.values())} lies about sheets caught")
    jobs = told_of_jobs()
    print(f"{sum(jobs.caught.values())} of {sum(jobs.made.values())} lies about the job caught")
    for some in (small, tables, feeds, jobs, broken, lied, sheets):
        for missed in some.missed[:5]:
            print("missed:", *missed)
    for name, mutation, text in result.missed[:5]:
        print(f"\nmissed: {name}, {mutation}")
        original = next(c.text for c in cases() if c.name == name).split("\n")
        pairs = enumerate(zip(original, text.split("\n"), strict=False), 1)
        print(next((f"line {i}: {a!r} -> {b!r}" for i, (a, b) in pairs if a != b), "cut short"))
    for alarm in result.false_alarms[:5]:
        print("alarm:", *alarm)


if __name__ == "__main__":
    start(main)
