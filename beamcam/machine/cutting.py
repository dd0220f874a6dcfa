"""Speed and feed of a tool, from the machine's table."""

from fnmatch import fnmatchcase
from math import pi

from beamcam.machine.machine import Cutting, Drill, Tool


def speed_and_feed(tool: Tool, drill: Drill, grade: str) -> tuple[float, float]:
    """Spindle speed in rpm and feed in mm/min of a tool, within the machine's limits.

    n = 1000 v / (pi d), v the cutting speed in m/min; feed = n * feed per turn, of a tap
    n * pitch. The table's first row of the tool's kind that fits the grade and the diameter
    counts, the kind's last one for anything beyond. A punch or scribe does not turn: its row's
    speed is its feed in m/min.
    """
    rows = [row for row in drill.cutting if row.kind == tool.kind]
    row = next((r for r in rows if _fits(r, tool, grade)), rows[-1])
    if tool.kind in ("punch", "scribe"):
        return 0.0, min(1000 * row.speed_m_min, drill.greatest_feed_mm_min)
    speed = 1000 * row.speed_m_min / (pi * tool.diameter)
    speed = min(max(speed, drill.least_speed_rpm), drill.greatest_speed_rpm)
    if tool.kind == "tap":
        # A tap has to follow its pitch, so a limit of the feed lowers the speed.
        speed = min(speed, drill.greatest_feed_mm_min / tool.pitch)
        return speed, speed * tool.pitch
    return speed, min(speed * row.feed_per_turn, drill.greatest_feed_mm_min)


def _fits(row: Cutting, tool: Tool, grade: str) -> bool:
    return tool.diameter <= row.up_to and fnmatchcase(grade.upper(), row.grade.upper())
