"""The tools that a shop has: what fits a hole, how fast each runs, in which order they work."""

import re
from collections.abc import Iterable, Iterator, Sequence
from fnmatch import fnmatchcase
from math import inf, pi, radians, tan

from msgspec import Struct

from beamcam.caches import PerObject, cached
from beamcam.checks import rules
from beamcam.checks.bars.pieces import CutPlane, LaidPart
from beamcam.checks.bars.stations import (
    Bore,
    Cut,
    MachinedFeatures,
    MachinedPath,
    StampedText,
    Thing,
    limits_of,
)
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.machine.stations import FLAT_DEG, Cutting, Drill, ToolSet
from beamcam.model.part import Face, Feature, Hole, Part, Profile, Slot
from beamcam.model.section import NO_PLATE

# --- shop -----------------------------------------------------------------------------------------

# The tools that a shop has, and between which sizes a tool fits a hole.


USUAL_POINT_DEG = 118.0


class ToolCatalogue:
    """The tools of a machine, by kind, and the faces that its spindles reach."""

    def __init__(self, machine: Machine, drill: Drill) -> None:
        self.machine, self.drill = machine, drill
        self.kinds: dict[str, tuple[ToolSet, ...]] = {}
        for tools in machine.tools:
            self.kinds[tools.kind] = (*self.kinds.get(tools.kind, ()), tools)
        self.faces: tuple[Face, ...] = tuple(s.face for s in machine.spindles)
        self.sizes = cached("verify.sizes")(self._sizes)
        self.fits = cached("verify.fits")(self._fits)
        self.tip = cached("verify.tips")(self._tip)
        under = drill.same_tool_tolerance if drill.never_under else inf
        self.allowances = [
            (row.up_to, min(row.minus, under) + 1e-6, row.plus + 1e-6) for row in drill.fits
        ]
        self.twice = drill.duplicate_tolerance + 1e-9  #: holes nearer than this are one

    def of(self, kind: str, face: Face) -> Iterator[ToolSet]:
        """The tools of a kind that the spindle of a face takes."""
        return (t for t in self.kinds.get(kind, ()) if face in t.faces)

    def _sizes(self, kind: str, face: Face) -> tuple[float, ...]:
        """Diameters of the tools of a kind that the spindle of a face takes, in order."""
        return tuple(sorted({d for tools in self.of(kind, face) for d in tools.sizes}))

    def fit(self, diameter: float) -> tuple[float, float] | None:
        """Minimum and maximum drill for a hole; None if the machine has no row for that size."""
        for up_to, under, over in self.allowances:
            if diameter <= up_to:
                return diameter - under, diameter + over
        return None

    def _fits(self, kind: str, diameter: float, face: Face) -> tuple[float, ...]:
        """The tools of a kind that fit a hole, the nearest first, of two the smaller."""
        limits = self.fit(diameter)
        if limits is None:
            return ()
        fitting = [d for d in self.sizes(kind, face) if limits[0] <= d <= limits[1]]
        return tuple(sorted(fitting, key=lambda d: (abs(d - diameter), d)))

    def tap(self, hole: Hole) -> tuple[float, float, float] | None:
        """Diameter and pitch of the tap of a thread, and the drill before it."""
        hand = "left" if hole.kind == "left-thread" else "right"
        for tools in self.of("tap", hole.face):
            if tools.hand == hand:
                for size, pitch, before in zip(
                    tools.sizes, tools.pitches, tools.pre_drills, strict=True
                ):
                    if abs(size - hole.diameter) <= self.drill.same_tool_tolerance:
                        return size, pitch, before
        return None

    def _tip(self, kind: str, diameter: float, face: Face) -> float:
        """Length of a tool's point: radius / tan(half the angle); 0 of a flat one."""
        angle = self.point_deg(kind, diameter, face)
        return 0.0 if angle >= FLAT_DEG else diameter / 2 / tan(radians(angle) / 2)

    def point_deg(self, kind: str, diameter: float, face: Face) -> float:
        """Angle of the point of the shop's tool of a diameter; a usual drill's if it has none."""
        angles = (t.point_deg for t in self.of(kind, face) if diameter in t.sizes)
        return next(angles, USUAL_POINT_DEG)

    def mills_round(self, diameter: float, face: Face) -> bool:
        """Whether a hole may be milled as a circle: no drill is as large, and a mill may."""
        largest = max((t.largest_hole for t in self.of("mill", face)), default=0.0)
        return max(self.sizes("drill", face), default=0.0) < diameter <= largest

    def drills_ends(self, slot: Feature, face: Face) -> bool:
        """Whether the ends of a slot are drilled before it is milled; a rectangle's are not."""
        if not isinstance(slot, Slot) or slot.height or self.drill.slots != "drill-mill":
            return False
        return bool(self.fits("drill", slot.diameter, face))

    def works_on(self, face: Face, part: Part) -> bool:
        """Whether a spindle works on a face of a part."""
        return face in self.faces and face not in NO_PLATE.get(part.profile.code, ())


# --- cutting data ---------------------------------------------------------------------------------

# Between which feeds and speeds a tool runs, by the machine's cutting data.
#
# A row gives turns n = 1000 v / (pi d), v the speed at the edge, and a feed of n times the feed per
# turn, of a tap n times its pitch, all within the limits of the station. The first row that fits
# tool, diameter and grade counts, the last of the kind for anything beyond. Where the grade is not
# known, every row that fits the tool may be meant.


MOST = 1.2  #: times what the data give, beyond which a feed or a speed is refused
LEAST = 0.5  #: times, below which a feed is warned of
STANDING_TOOLS = ("punch", "scribe")  #: they do not turn; their row's speed is their feed in m/min


class CuttingRange(Struct, frozen=True, gc=False):
    """Permitted speed and feed of a tool."""

    min_feed: float  #: mm/min; below it a warning
    own_feed: float  #: of the data, the fastest
    most_feed: float
    most_speed: float  #: rpm
    most_per_turn: float  #: mm


class CuttingData:
    """The machine's cutting data for steel of some grades; None where they are not known."""

    def __init__(self, machine: Machine, drill: Drill, grades: tuple[str, ...] | None) -> None:
        self._machine, self._drill, self._grades = machine, drill, grades
        self.run = cached("verify.runs")(self._run)

    def _run(self, kind: str, diameter: float, pitch: float) -> CuttingRange | None:
        """Permitted speed and feed of a tool; None without cutting data for its kind."""
        drill, turns, feeds, per_turns = self._drill, [], [], []
        for row in self._rows(kind, diameter):
            if kind in STANDING_TOOLS:
                turns.append(0.0)
                feeds.append(min(1000 * row.speed_m_min, drill.max_feed_mm_min))
                per_turns.append(inf)
                continue
            rpm = 1000 * row.speed_m_min / (pi * diameter)
            turns.append(max(drill.min_speed_rpm, min(drill.max_speed_rpm, rpm)))
            per_turns.append(pitch if kind == "tap" else row.feed_per_turn)
            feeds.append(min(turns[-1] * per_turns[-1], drill.max_feed_mm_min))
        if not feeds:
            return None
        return CuttingRange(
            LEAST * min(feeds), max(feeds), min(MOST * max(feeds), drill.max_feed_mm_min) + 0.1,
            min(MOST * max(turns), drill.max_speed_rpm) + 0.6, MOST * max(per_turns),
        )  # fmt: skip

    def _rows(self, kind: str, diameter: float) -> list[Cutting]:
        """The rows that may be meant for a tool."""
        rows = [row for row in self._drill.cutting if row.kind == kind]
        if not rows or (diameter <= 0 and kind not in STANDING_TOOLS):
            return []
        materials = {
            t.tool_material for t in self._machine.tools if t.kind == kind and diameter in t.sizes
        } or {"hss"}
        meant = []
        for material in sorted(materials):
            fitting = [
                row
                for row in rows
                if diameter <= row.up_to and row.tool_material in ("*", material)
            ]
            if self._grades is None:
                meant += fitting or rows[-1:]
                continue
            for grade in self._grades:
                # One of a row's patterns, set off by |, has to be that of the grade, in any case.
                patterns = [(row, row.grade.upper().split("|")) for row in fitting]
                meant += [
                    row for row, own in patterns
                    if any(fnmatchcase(grade.upper(), pattern.strip()) for pattern in own)
                ][:1] or rows[-1:]  # fmt: skip
        return meant


# --- cell limits ----------------------------------------------------------------------------------

# What a machine's file says about its cell, whatever program runs there.


EPSILON = 1e-6
_DWELL = re.compile(r"(?<![A-Z])G(?:0*4|82)(?![0-9.])")


class CellLimits(Struct, frozen=True):
    """What the machine's file says about its cell whatever the program is."""

    max_pecks: dict[float, float]  #: how deep a drill of each size may be fed at once
    stop: tuple[str, float, float]  #: name, minimum and maximum of the axis along the bar
    angle: tuple[str, float, float]  #: and of what turns the saw
    never_back: bool  #: whether the bar only goes on
    step: float  #: of written lengths, with some rounding
    per_minute: float  #: makes mm/min of a feed in a template's unit
    tools: dict[str, tuple[float, ...]]  #: the sizes of each kind that the shop has
    dwells: bool  #: whether a word of its own dwells


def _limits(machine: Machine) -> CellLimits:
    form, layout, words = machine.format, machine.layout, machine.words
    templates = (getattr(words, name) for name in words.__struct_fields__)
    sizes: dict[str, set[float]] = {}
    pecks: dict[float, float] = {}  #: where a size has a limit
    for tools in machine.tools:
        sizes.setdefault(tools.kind, set()).update(tools.sizes)
        for size in tools.sizes if tools.kind == "drill" else ():
            pecks[size] = max(pecks.get(size, 0.0), tools.max_peck or inf)
    return CellLimits(
        {size: peck for size, peck in pecks.items() if peck < inf},
        limits_of(machine, "X"),
        limits_of(machine, "angle"),
        layout is not None and layout.order == "saw-drill",
        form.resolution + EPSILON,
        60.0 if form.feed_unit == "mm/s" else 1.0,
        {kind: tuple(sorted(own)) for kind, own in sizes.items()},
        "drill-cycle-dwell" in machine.codes.values()
        or any(_DWELL.search("\n".join(t)) for t in templates if isinstance(t, tuple)),
    )


limits_of_cell = PerObject("verify.cells", _limits)


# --- order of work --------------------------------------------------------------------------------

# Place by place and part by part:
#
#     drill -> tap         a tap cuts its thread into a hole
#     drill -> countersink a countersink widens a hole, be it drilled or milled
#     entry -> mill        where slots are drilled first the mill goes down into a hole (`paths`)
#     work  -> cut         where the drills come first a part is lost to them once it is cut off
#
# An arrow is checked wherever its right side stands in the program. That what stands on its left is
# there at all, in its size and place, is checked elsewhere.


NOUNS = {"drill": "hole", "tap": "thread", "punch": "punch mark", "mill": "slot", "scribe": "line"}
Work = Bore | MachinedPath | StampedText


def place_faults(made: MachinedFeatures, machine: Machine, name: str) -> Iterator[Diagnostic]:
    """Threads and sinks of a program that come before the hole that they need."""
    if all(bore.kind not in ("tap", "countersink") for bore in made.bores):
        return
    near = machine.format.resolution + (machine.drill.merge_tolerance if machine.drill else 0.0)
    for index, work in enumerate(made.order):
        if not isinstance(work, Bore) or work.kind not in ("tap", "countersink"):
            continue
        if not any(_is_hole_of(work, other, near) for other in made.order[:index]):
            hole = "the drill" if work.kind == "tap" else "its hole"
            yield too_early(work, f"before {hole}", f"{hole} first", name)


def parting_faults(
    made: MachinedFeatures, laid: Sequence[LaidPart], done: Iterable[tuple[int, Work]],
    cuts: Sequence[CutPlane], machine: Machine, profile: Profile, name: str,
) -> Iterator[Diagnostic]:  # fmt: skip
    """Work on a part that is cut off already, where the bar comes to the drills before the saw.

    `done` is what was found to be of a part on the bar, by the part's number.
    """
    if machine.layout is None or machine.layout.order != "drill-saw":
        return
    place: dict[int, int] = {}  #: line of some work -> its place in the order of work
    for index, work in enumerate(made.order):
        place.setdefault(work.line, index)
    freed = [None if one.piece is None else one.piece.end.cut.line for one in laid]
    for part, work in sorted(done, key=lambda one: one[1].line):
        cut = freed[part]
        if cut and place[work.line] > place[cut]:
            yield _cut_off(work, cut, name)
    rise = (-1.0 if machine.saw is not None and machine.saw.pivot == "o" else 1.0) * profile.height
    reached: tuple[float, int] | None = None  #: how far the bar is cut off, and by which line
    by_line = {plane.cut.line: plane for plane in cuts}
    for plane in sorted(by_line.values(), key=lambda plane: place[plane.cut.line]):
        xs = [plane.along(y, z) for y in (0.0, rise) for z in (0.0, profile.width)]
        if reached is not None and max(xs) < reached[0]:
            yield _cut_off(plane.cut, reached[1], name)
        elif reached is None or min(xs) > reached[0]:
            reached = min(xs), plane.cut.line


def _is_hole_of(work: Bore, other: Thing, near: float) -> bool:
    """Whether a tap or countersink goes into what was made before."""
    if isinstance(other, Bore):
        is_other_tool = other.kind in ("drill", "tap") and other.kind != work.kind
        apart = max(abs(other.x - work.x), abs(other.y - work.y))
        return is_other_tool and other.face == work.face and apart <= near
    if work.kind == "tap" or not isinstance(other, MachinedPath) or other.face != work.face:
        return False
    xs, ys = [x for x, _ in other.points], [y for _, y in other.points]
    return other.kind == "mill" and (
        min(xs) - near <= work.x <= max(xs) + near and min(ys) - near <= work.y <= max(ys) + near
    )


def too_early(work: Bore | MachinedPath, found: str, expected: str, name: str) -> Diagnostic:
    x, y = work.points[0] if isinstance(work, MachinedPath) else (work.x, work.y)
    return rules.WORK_ORDER.at(
        Source(name, work.line), what=f"a {work.kind} {work.diameter:g}", face=work.face,
        x=f"{x:g}", y=f"{y:g}", found=found, expected=expected,
    )  # fmt: skip


def _cut_off(work: Thing, cut: int, name: str) -> Diagnostic:
    what = "a cut" if isinstance(work, Cut) else "a text"
    if isinstance(work, Bore | MachinedPath):
        what = f"a {NOUNS.get(work.kind, work.kind)}"
    x = work.points[0][0] if isinstance(work, MachinedPath) else work.x
    return rules.CUT_OFF.at(Source(name, work.line), what=what, found=f"{x:g}", cut=cut)
