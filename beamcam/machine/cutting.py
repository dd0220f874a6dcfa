"""Speed and feed of a tool, from the machine's table of cutting data."""

from fnmatch import fnmatchcase
from math import inf, pi

from beamcam.machine.stations import Cutting, Drill
from beamcam.machine.tools import Tool

ANY_GRADE = "*"  #: of the rows for what no other row names


def speed_and_feed(tool: Tool, drill: Drill, grade: str) -> tuple[float, float]:
    """Spindle speed in rpm and feed in mm/min of a tool, within the machine's limits.

    n = 1000 v / (pi d), v the cutting speed in m/min; feed = n * feed per turn, of a tap
    n * pitch. A punch or scribe does not turn: its row's speed is its feed in m/min.
    """
    row = cutting_row(tool, drill, grade)
    if tool.kind in ("punch", "scribe"):
        return 0.0, min(1000 * row.speed_m_min, drill.max_feed_mm_min)
    speed = turns_of(row, tool)
    speed = min(max(speed, drill.min_speed_rpm), drill.max_speed_rpm)
    if tool.kind == "tap":
        # A tap has to follow its pitch, so a limit of the feed lowers the speed.
        speed = min(speed, drill.max_feed_mm_min / tool.pitch)
        return speed, speed * tool.pitch
    return speed, min(speed * row.feed_per_turn, drill.max_feed_mm_min)


def turns_of(row: Cutting, tool: Tool) -> float:
    """The speed in rpm that a row asks for, whatever the spindle's limits; of a point infinite."""
    return 1000 * row.speed_m_min / (pi * tool.diameter) if tool.diameter else inf


def cutting_row(tool: Tool, drill: Drill, grade: str) -> Cutting:
    """The first row that fits kind, material and diameter of a tool and the steel's grade.

    The last row of the kind counts for anything beyond.
    """
    rows = [row for row in drill.cutting if row.kind == tool.kind]
    return next((r for r in rows if _fits(r, tool, grade)), rows[-1])


def _fits(row: Cutting, tool: Tool, grade: str) -> bool:
    return (
        tool.diameter <= row.up_to
        and row.tool_material in ("*", tool.tool_material)
        and names_grade(row, grade)
    )


def names_grade(row: Cutting, grade: str) -> bool:
    """Whether one of a row's patterns is that of a steel's grade; case counts for nothing."""
    patterns = row.grade.upper().split("|")
    return any(fnmatchcase(grade.upper(), pattern.strip()) for pattern in patterns)


def is_unnamed(drill: Drill, grade: str) -> bool:
    """Whether drills have rows by grade, and none of them names this one."""
    rows = [row for row in drill.cutting if row.kind == "drill" and row.grade != ANY_GRADE]
    return bool(rows) and not any(names_grade(row, grade) for row in rows)
