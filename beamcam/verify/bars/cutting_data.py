"""Between which feeds and speeds a tool runs, by the machine's cutting data.

A row gives turns n = 1000 v / (pi d), v the speed at the edge, and a feed of n times the feed per
turn, of a tap n times its pitch, all within the limits of the station. The first row that fits
tool, diameter and grade counts, the last of the kind for anything beyond. Where the grade is not
known, every row that fits the tool may be meant.
"""

from fnmatch import fnmatchcase
from math import inf, pi

from msgspec import Struct

from beamcam.caches import cached
from beamcam.machine.drill import Cutting, Drill
from beamcam.machine.machine import Machine

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
        found = [self._of(row, kind, diameter, pitch) for row in self._rows(kind, diameter)]
        if not found:
            return None
        drill = self._drill
        feeds = [feed for _, feed, _ in found]
        speed = max(speed for speed, _, _ in found)
        return CuttingRange(
            LEAST * min(feeds),
            max(feeds),
            min(MOST * max(feeds), drill.max_feed_mm_min) + 0.1,
            speed,
            min(MOST * speed, drill.max_speed_rpm) + 0.6,
            MOST * max(per_turn for _, _, per_turn in found),
        )

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
