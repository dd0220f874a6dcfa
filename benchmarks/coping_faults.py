"""Ways to make a coper's program wrong, all to be refused by the read-back.

By classes: what the planner could get wrong (the side of the kerf, a mirrored or moved contour,
sharp corners, leads in the part, a cut that is missing, made twice or ends too early, the order,
the row of the cut chart), and what of a program's text (A, F, inverse time, heights, waits,
switches, blending). So many random profiles are tried, as many pieces that come cut, which may
also be taken for a bar or for a longer piece, and as many tubes, round and rectangular:

    python benchmarks/coping_faults.py 20
"""

import random
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parents[1]))

from beamcam.emitters.head import head_lines
from beamcam.errors import PlanError, errors_in
from beamcam.machine import Machine, load
from beamcam.model.part import Contour, Part
from beamcam.model.plan import CopeCut, CopePlan
from beamcam.model.request import Job, Request
from beamcam.model.surface import around
from beamcam.planning.coping import plan as planner
from beamcam.planning.left_out import by_hand_sources, left_out_kinds
from beamcam.posts import post_of
from benchmarks.script import arguments, at_least, start
from tests.random_boxes import random_box
from tests.random_copes import random_cope, random_tee
from tests.random_tubes import random_tube

Lines = list[str]
OfPlan = Callable[[CopePlan, random.Random], CopePlan | None]
OfText = Callable[[Lines, random.Random], Lines | None]


def program_of(plan: CopePlan, job: Job) -> str:
    """The text of a plan's program."""
    post = post_of(job.machine)
    head = head_lines(job, plan, left_out_kinds(plan), sum(1 for _ in by_hand_sources(plan)))
    program = post.with_head(post.motion(plan, job.machine, "JOB"), tuple(head))
    text = post.emit(program, job)
    assert isinstance(text, str)
    return text


# --- plans ----------------------------------------------------------------------------------------


def _changed(plan: CopePlan, chance: random.Random, change: Callable[[CopeCut], CopeCut | None],
             fits: Callable[[CopeCut], bool] = lambda cut: True) -> CopePlan | None:  # fmt: skip
    """The plan with one of its cuts changed."""
    which = [k for k, cut in enumerate(plan.operations) if fits(cut)]
    if not which:
        return None
    k = chance.choice(which)
    other = change(plan.operations[k])
    if other is None:
        return None
    return replace(plan, operations=(*plan.operations[:k], other, *plan.operations[k + 1 :]))


def _placed(change: Callable[[float, float], tuple[float, float]]) -> OfPlan:
    def of_plan(plan: CopePlan, chance: random.Random) -> CopePlan | None:
        return _changed(
            plan, chance, lambda cut: replace(cut, path=tuple(change(*p) for p in cut.path))
        )

    return of_plan


def mirrored_along(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut at the other end of the part."""
    length = plan.pieces[0].part.length
    return _placed(lambda x, y: (length - x, y))(plan, chance)


def mirrored_across(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A hole whose y counts from the other edge."""

    def off_middle(cut: CopeCut) -> bool:
        ys = [y for _, y in cut.path[cut.lead :]]
        wide = plan.profile.face_width(cut.face)
        return cut.kind == "inner" and abs(min(ys) + max(ys) - wide) > 1.0

    def change(cut: CopeCut) -> CopeCut:
        wide = plan.profile.face_width(cut.face)
        return replace(cut, path=tuple((x, wide - y) for x, y in cut.path))

    return _changed(plan, chance, change, off_middle)


def on_the_part(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut whose kerf lies on the side of the part."""
    from shapely import LineString, Polygon

    def change(cut: CopeCut) -> CopeCut | None:
        way, kerf = cut.path[cut.lead :], cut.row.kerf
        if cut.kind == "inner":
            ring = Polygon(way).buffer(kerf).exterior.coords
            return replace(cut, path=tuple(ring), lead=0)
        pierce, start = cut.path[0], cut.path[1]
        side = 1.0 if LineString(way).parallel_offset(1.0, "left").distance(
            LineString([pierce, start]).interpolate(0.0)
        ) > LineString(way).parallel_offset(1.0, "right").distance(
            LineString([pierce, start]).interpolate(0.0)
        ) else -1.0  # fmt: skip
        moved = LineString(way).offset_curve(side * kerf).coords
        return replace(cut, path=(pierce, *moved))

    return _changed(plan, chance, change)


def left_out(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut that is missing."""
    k = chance.randrange(len(plan.operations))
    return replace(plan, operations=(*plan.operations[:k], *plan.operations[k + 1 :]))


def face_left_out(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A wall without its cuts."""
    face = chance.choice(sorted({cut.face for cut in plan.operations}))
    return replace(plan, operations=tuple(c for c in plan.operations if c.face != face))


def on_other_face(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut of one flange on the other one, where that differs from its own cuts."""

    def change(cut: CopeCut) -> CopeCut | None:
        other = "u" if cut.face == "o" else "o"
        same = [c for c in plan.operations if c.face == other and c.path == cut.path]
        return None if same else replace(cut, face=other)

    return _changed(plan, chance, change, lambda c: c.face != "v" and plan.profile.code not in "LT")


def too_short(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut that ends too early."""
    return _changed(
        plan, chance, lambda cut: replace(cut, path=_shortened(cut.path, 6.0)),
        lambda cut: len(cut.path) > 2,
    )  # fmt: skip


def _shortened(path: tuple[tuple[float, float], ...], by: float) -> tuple[tuple[float, float], ...]:
    points = list(path)
    while len(points) > 1:
        (xa, ya), (xb, yb) = points[-2:]
        long = ((xb - xa) ** 2 + (yb - ya) ** 2) ** 0.5
        if long > by:
            share = (long - by) / long
            points[-1] = xa + share * (xb - xa), ya + share * (yb - ya)
            return tuple(points)
        by -= long
        points.pop()
    return tuple(points)


def twice(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut-out that is cut twice."""
    k = chance.randrange(len(plan.operations))
    cut = plan.operations[k]
    return replace(plan, operations=(*plan.operations[:k], cut, *plan.operations[k:]))


def reordered(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut of the far end before all others."""
    far = [cut for cut in plan.operations if cut.kind == "far"]
    rest = [cut for cut in plan.operations if cut is not far[0]]
    return replace(plan, operations=(far[0], *rest)) if rest[0].kind != "far" else None


def pierced_in_part(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A lead on the other side of its contour."""

    def change(cut: CopeCut) -> CopeCut:
        (xa, ya), (xb, yb) = cut.path[:2]
        return replace(cut, path=((2 * xb - xa, 2 * yb - ya), *cut.path[1:]))

    return _changed(plan, chance, change, lambda cut: cut.kind == "inner" or cut.face == "v")


def other_row(machine: Machine) -> OfPlan:
    """A cut with the row of another thickness."""

    def of_plan(plan: CopePlan, chance: random.Random) -> CopePlan | None:
        rows = machine.coper.rows if machine.coper else ()
        return _changed(
            plan, chance,
            lambda cut: replace(cut, row=chance.choice([r for r in rows if r != cut.row])),
        )  # fmt: skip

    return of_plan


def bulge(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A place of a path 1 mm into the part."""

    def change(cut: CopeCut) -> CopeCut:
        k = chance.randrange(cut.lead + 1, len(cut.path) - 1)
        (xa, ya), (xb, yb) = cut.path[k - 1], cut.path[k + 1]
        long = ((xb - xa) ** 2 + (yb - ya) ** 2) ** 0.5 or 1.0
        x, y = cut.path[k]
        moved = x - (yb - ya) / long, y + (xb - xa) / long  # the part lies on the left
        return replace(cut, path=(*cut.path[:k], moved, *cut.path[k + 1 :]))

    return _changed(
        plan, chance, change,
        lambda cut: cut.kind == "inner" and len(cut.path) > cut.lead + 4,
    )  # fmt: skip


def extra(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut somewhere in the scrap before the part."""
    cut = plan.operations[0]
    return replace(plan, operations=(
        replace(cut, path=((-20.0, 60.0), (-20.0, 40.0), (-20.0, 61.0))), *plan.operations
    ))  # fmt: skip


# --- texts ----------------------------------------------------------------------------------------


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


def _askew(lines: Lines, chance: random.Random) -> Lines | None:
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
    "A askew": lambda lines, c: _askew(lines, c),
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


def _other_way(lines: Lines) -> Lines | None:
    """Every turn the other way round, of a tube with cut-outs."""
    if "(cut-out)" not in lines:
        return None
    return [re.sub(r" A(-?)([\d.]+)", lambda m: f" A{'' if m[1] else '-'}{m[2]}", line)
            for line in lines]  # fmt: skip


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


def mirrored_round(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut-out of a tube whose arc counts the other way round."""
    turn = around(plan.profile).turn

    def is_same(cut: CopeCut) -> bool:
        us = [u for _, u in cut.path[cut.lead :]]
        return abs((min(us) + max(us) + turn / 2) % turn - turn / 2) < 1.0

    return _changed(
        plan, chance,
        lambda cut: replace(cut, path=tuple((x, -u) for x, u in cut.path)),
        lambda cut: cut.kind == "inner" and not is_same(cut),
    )  # fmt: skip


def elsewhere_round(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut-out of a tube a quarter of a turn on."""
    turn = around(plan.profile).turn
    return _changed(
        plan, chance,
        lambda cut: replace(cut, path=tuple((x, u + turn / 4) for x, u in cut.path)),
        lambda cut: cut.kind == "inner",
    )  # fmt: skip


def other_corners(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A rectangular tube with corners of another radius."""
    profile = plan.profile
    if profile.code != "M":
        return None
    return replace(
        plan, profile=replace(profile, radius=profile.radius * chance.choice((0.8, 1.2)))
    )


def ends_before_the_seam(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """An end of a tube that is not cut all round."""
    return _changed(
        plan, chance, lambda cut: replace(cut, path=_shortened(cut.path, 6.0)),
        lambda cut: cut.kind != "inner",
    )  # fmt: skip


def plan_faults(machine: Machine) -> dict[str, OfPlan]:
    """Ways to make a plan wrong."""
    of_all: dict[str, OfPlan] = {
        "moved along": _placed(lambda x, y: (x + 0.6, y)),
        "moved across": lambda p, c: _changed(
            p, c, lambda cut: replace(cut, path=tuple((x, y + 0.6) for x, y in cut.path)),
            lambda cut: cut.kind == "inner",
        ),
        "mirrored along": mirrored_along, "cut left out": left_out, "too short": too_short,
        "order": reordered, "twice": twice, "kerf on the part": on_the_part,
        "other row": other_row(machine), "bulge": bulge, "extra": extra,
    }  # fmt: skip
    if machine.coper is not None and machine.coper.turns == "bar":
        return of_all | {
            "mirrored round": mirrored_round, "elsewhere round": elsewhere_round,
            "ends before the seam": ends_before_the_seam, "other corners": other_corners,
        }  # fmt: skip
    return of_all | {
        "mirrored across": mirrored_across, "face left out": face_left_out,
        "other face": on_other_face, "pierced in the part": pierced_in_part,
    }  # fmt: skip


def faults(part: Part, machine: Machine, chance: random.Random) -> Iterator[tuple[str, str]]:
    """A wrong program of each class that the part has something for. Raises PlanError."""
    job = Job(Request((part,), machine, name="JOB"), (0,))
    plan = planner.plan_coping((part,), machine)
    right = program_of(plan, job)
    for name, of_plan in plan_faults(machine).items():
        if part.made is not None and of_plan is reordered:
            continue  # nothing is parted from a bar
        wrong = of_plan(plan, chance)
        if wrong is not None:
            yield name, program_of(wrong, job)
    coper = machine.coper
    assert coper is not None
    for name, of_text in (TEXTS if coper.turns == "torch" else TUBE_TEXTS).items():
        lines = of_text(right.split("\n"), chance)
        if lines is not None and "\n".join(lines) != right:
            yield name, "\n".join(lines)
    if part.made is not None:
        yield from piece_faults(part, machine)
    if any(said.code == "plan-coping-rounded" for said in plan.remarks):
        sharp = replace(machine, coper=replace(coper, corner_radius=2.5))
        yield "sharp corners", program_of(planner.plan_coping((part,), sharp), job)


def random_piece(seed: int) -> Part:
    """A random profile whose ends are there: what a saw leaves of it."""
    part = (random_tee if seed % 4 == 3 else random_cope)(seed)
    holes = tuple(f for f in part.features if not isinstance(f, Contour))
    rest = tuple(f for f in part.features if isinstance(f, Contour))
    return replace(part, features=rest, made=holes)


def piece_faults(part: Part, machine: Machine) -> Iterator[tuple[str, str]]:
    """Programs for other steel than the piece that comes."""
    job = Job(Request((part,), machine, name="JOB"), (0,))
    bar = replace(part, made=None)
    yield "taken for a bar", program_of(planner.plan_coping((bar,), machine), job)
    if any(c.kind == "far" for c in planner.plan_coping((part,), machine).operations):
        longer = replace(part, length=part.length + 3.0)
        try:
            plan = planner.plan_coping((longer,), machine)
        except PlanError:
            return
        yield "taken for a longer piece", program_of(plan, job)


def survivors(count: int, seed: int = 0) -> tuple[Counter[str], list[tuple[int, str, str]], int]:
    """Wrong programs by class, those that the read-back took, and sound ones that it refused.

    They are those of so many profiles, T sections and pieces that come cut, round and rectangular
    tubes.
    """
    chance = random.Random(seed)
    tried: Counter[str] = Counter()
    taken: list[tuple[int, str, str]] = []
    refused = 0
    kinds = (random_cope, random_tube, random_piece, random_box, random_tee)
    for number in range(len(kinds) * count):
        make = kinds[number % len(kinds)]
        is_tube = make in (random_tube, random_box)
        machine, part = (
            load(f"{'tube' if is_tube else 'coper'}-linuxcnc"),
            make(number // len(kinds)),
        )
        job = Job(Request((part,), machine, name="JOB"), (0,))
        verify = post_of(machine).verify
        try:
            right = program_of(planner.plan_coping((part,), machine), job)
        except PlanError:
            continue
        refused += bool(errors_in(verify(right, job)))
        for name, text in faults(part, machine, chance):
            tried[name] += 1
            if not errors_in(verify(text, job)):
                taken.append((number, name, text))
    return tried, taken, refused


def main() -> None:
    """Prints how many wrong programs of each class there were, and which were taken."""
    parser = arguments(__doc__)
    parser.add_argument("parts", type=at_least(1), nargs="?", default=20)
    tried, taken, refused = survivors(parser.parse_args().parts)
    for name, count in sorted(tried.items()):
        print(f"{count:5}  {name}")
    for number, name, _ in taken:
        print(f"taken: {name}, part {number}")
    print(f"{tried.total()} wrong programs, {len(taken)} taken; {refused} sound ones refused")
    sys.exit(bool(taken or refused))


if __name__ == "__main__":
    start(main)
