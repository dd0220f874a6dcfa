"""The tools that a shop has: what fits a hole, what a spindle can hold, how fast each runs."""

import re
from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from math import inf, pi, radians, tan

from msgspec import Struct

from beamcam.caches import PerObject, cached
from beamcam.checks.bars.stations import limits_of
from beamcam.machine.machine import Machine
from beamcam.machine.stations import FLAT_DEG, Cutting, Drill, ToolSet
from beamcam.model.part import Face, Hole, Part
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
        self.twice = drill.duplicate_tolerance + 1e-9  #: holes nearer than this are one

    def of(self, kind: str, face: Face) -> Iterator[ToolSet]:
        """The tools of a kind that the spindle of a face takes."""
        return (t for t in self.kinds.get(kind, ()) if face in t.faces)

    def _sizes(self, kind: str, face: Face) -> tuple[float, ...]:
        """Diameters of the tools of a kind that the spindle of a face takes, in order."""
        return tuple(sorted({d for tools in self.of(kind, face) for d in tools.sizes}))

    def fit(self, diameter: float) -> tuple[float, float] | None:
        """Minimum and maximum drill for a hole; None if the machine has no row for that size."""
        for row in self.drill.fits:
            if diameter <= row.up_to:
                under = (
                    min(row.minus, self.drill.same_tool_tolerance)
                    if self.drill.never_under
                    else row.minus
                )
                return diameter - under - 1e-6, diameter + row.plus + 1e-6
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

    def works_on(self, face: Face, part: Part) -> bool:
        """Whether a spindle works on a face of a part."""
        return face in self.faces and face not in NO_PLATE.get(part.profile.code, ())


# --- magazine -------------------------------------------------------------------------------------

# Tools available to a spindle: limited by its stations, and changed at stops.
#
# What is put in before the program starts is not written down; it is taken to be the tools that the
# program needs first. At each stop a tool comes in, for one that is needed last of all: if even so
# a tool is chosen that cannot be there, the program has forgotten to stop for it.


Tool = tuple[str, float]  #: kind and diameter


class Chosen(Struct, frozen=True, gc=False):
    """A tool selected for a spindle."""

    line: int
    spindle: int  #: or the number of a pair of them
    tool: Tool


class Changed(Struct, frozen=True, gc=False):
    """A stop for a manual tool change; None where the word does not name the tool."""

    line: int
    spindle: int | None
    diameter: float | None


def wrong_changes(own: Sequence[Chosen | Changed], stations: int) -> Iterator[Chosen | Changed]:
    """Selections of tools that cannot be in a spindle's stations yet, and stops without need.

    `own` are the tools that the spindle is commanded to take and the stops for them,
    in their order.
    """
    loaded: set[Tool] = set()
    started = False  #: whether all stations have had their first tool
    for at, one in enumerate(own):
        if isinstance(one, Chosen):
            if one.tool in loaded:
                continue
            if started or len(loaded) >= stations:
                yield one
                started = True
                _make_room(loaded, own[at:], stations)
            loaded.add(one.tool)
            continue
        new = _meant(one, own[at:], loaded)
        if new is None:
            if one.spindle is not None:
                yield one
            continue
        started = started or len(loaded) >= stations
        _make_room(loaded, own[at:], stations)
        loaded.add(new)


def _meant(change: Changed, rest: Sequence[Chosen | Changed], loaded: set[Tool]) -> Tool | None:
    """The tool that a stop brings: the next one that is needed and not there."""
    for one in rest:
        if isinstance(one, Changed) or one.tool in loaded:
            continue
        if change.diameter is None or abs(one.tool[1] - change.diameter) < 0.001:
            return one.tool
    return None


def _make_room(loaded: set[Tool], rest: Sequence[Chosen | Changed], stations: int) -> None:
    """Take out what is needed last of all, if every station is taken."""
    if len(loaded) < stations:
        return
    next_use: dict[Tool, int] = {}
    for at, one in enumerate(rest):
        if isinstance(one, Chosen):
            next_use.setdefault(one.tool, at)
    loaded.discard(max(sorted(loaded), key=lambda tool: next_use.get(tool, len(rest))))


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
    own_speed: float  #: rpm
    most_speed: float
    most_per_turn: float  #: mm


class CuttingData:
    """The machine's cutting data for steel of some grades; None where they are not known."""

    def __init__(self, machine: Machine, drill: Drill, grades: tuple[str, ...] | None) -> None:
        self._machine, self._drill, self._grades = machine, drill, grades
        self.run = cached("verify.runs")(self._run)

    def _run(self, kind: str, diameter: float, pitch: float) -> CuttingRange | None:
        """Permitted speed and feed of a tool; None without cutting data for its kind."""
        figures = [self._of(row, kind, diameter, pitch) for row in self._rows(kind, diameter)]
        if not figures:
            return None
        drill = self._drill
        feeds = [feed for _, feed, _ in figures]
        speed = max(speed for speed, _, _ in figures)
        return CuttingRange(
            LEAST * min(feeds), max(feeds), min(MOST * max(feeds), drill.max_feed_mm_min) + 0.1,
            speed, min(MOST * speed, drill.max_speed_rpm) + 0.6,
            MOST * max(per_turn for _, _, per_turn in figures),
        )  # fmt: skip

    def _of(
        self, row: Cutting, kind: str, diameter: float, pitch: float
    ) -> tuple[float, float, float]:
        """Speed in rpm, feed in mm/min and feed per turn of a row."""
        drill = self._drill
        if kind in STANDING_TOOLS:
            return 0.0, min(1000 * row.speed_m_min, drill.max_feed_mm_min), inf
        turns = 1000 * row.speed_m_min / (pi * diameter)
        turns = max(drill.min_speed_rpm, min(drill.max_speed_rpm, turns))
        per_turn = pitch if kind == "tap" else row.feed_per_turn
        return turns, min(turns * per_turn, drill.max_feed_mm_min), per_turn

    def _rows(self, kind: str, diameter: float) -> list[Cutting]:
        """The rows that may be meant for a tool."""
        rows = [row for row in self._drill.cutting if row.kind == kind]
        if not rows or (diameter <= 0 and kind not in STANDING_TOOLS):
            return []
        materials = {
            t.tool_material for t in self._machine.tools if t.kind == kind and diameter in t.sizes
        } or {"hss"}
        found = []
        for material in sorted(materials):
            fitting = [
                row
                for row in rows
                if diameter <= row.up_to and row.tool_material in ("*", material)
            ]
            if self._grades is None:
                found += fitting or rows[-1:]
                continue
            for grade in self._grades:
                found += [row for row in fitting if _names(row, grade)][:1] or rows[-1:]
        return found


def _names(row: Cutting, grade: str) -> bool:
    """Whether one of a row's patterns, set off by |, is that of a grade, in any case."""
    return any(fnmatchcase(grade.upper(), p.strip()) for p in row.grade.upper().split("|"))


# --- cell limits ----------------------------------------------------------------------------------

# What a machine's file says about its cell, whatever program runs there.


EPSILON = 1e-6
_DWELL = re.compile(r"(?<![A-Z])G(?:0*4|82)(?![0-9.])")


class CellLimits(Struct, frozen=True):
    """What the machine's file says about its cell whatever the program is."""

    max_pecks: dict[float, float]  #: how deep a drill of each size may be fed at once
    stop: tuple[str, float, float]  #: name, minimum and maximum of the axis along the bar
    never_back: bool  #: whether the bar only goes on
    step: float  #: of written lengths, with some rounding
    per_minute: float  #: makes mm/min of a feed in a template's unit
    tools: dict[str, tuple[float, ...]]  #: the sizes of each kind that the shop has
    dwells: bool  #: whether a word of its own dwells


def _limits(machine: Machine) -> CellLimits:
    form, layout = machine.format, machine.layout
    return CellLimits(
        _max_pecks(machine),
        limits_of(machine, "X"),
        layout is not None and layout.order == "saw-drill",
        form.resolution + EPSILON,
        60.0 if form.feed_unit == "mm/s" else 1.0,
        {
            kind: tuple(sorted({d for t in machine.tools if t.kind == kind for d in t.sizes}))
            for kind in {tools.kind for tools in machine.tools}
        },
        "drill-cycle-dwell" in machine.codes.values()
        or any(_DWELL.search(t) for t in _lines(machine)),
    )


def _lines(machine: Machine) -> Iterator[str]:
    """The lines of all templates of work."""
    for name in machine.words.__struct_fields__:
        template = getattr(machine.words, name)
        yield from template if isinstance(template, tuple) else ()


limits_of_cell = PerObject("verify.cells", _limits)


def _max_pecks(machine: Machine) -> dict[float, float]:
    """How deep a drill of each size may be fed at once, where its size has a limit."""
    pecks: dict[float, float] = {}
    for tools in machine.tools:
        if tools.kind == "drill":
            for size in tools.sizes:
                pecks[size] = max(pecks.get(size, 0.0), tools.max_peck or inf)
    return {size: peck for size, peck in pecks.items() if peck < inf}
