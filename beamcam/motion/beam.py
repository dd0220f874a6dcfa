"""The motion of a saw and drilling line: strokes and feeds in machine coordinates."""

from collections.abc import Iterator
from fnmatch import fnmatchcase
from math import pi

from beamcam.machine.machine import Cutting, Drill, Formula, Machine, Spindle, Tool
from beamcam.model.part import Face, Profile
from beamcam.model.plan import DrillOp, Plan, SawOp
from beamcam.model.program import Command, DrillCycle, Program, SawStroke, StartBar


def beam_program(plan: Plan, machine: Machine, job: str) -> Program:
    """The commands that carry out a plan, in its order."""
    return Program(job, tuple(_commands(plan, machine)))


def _commands(plan: Plan, machine: Machine) -> Iterator[Command]:
    saw, drill = machine.saw, machine.drill
    if saw is None or drill is None:
        raise TypeError(f"{machine.name} has no saw and drill")
    profile = plan.profile
    yield StartBar(machine.sections[profile.code], profile.width, profile.height)
    spindles: dict[Face, Spindle] = {s.face: s for s in machine.spindles}
    sections = {face: _section_values(profile, face, drill) for face in spindles}
    for op in plan.operations:
        if isinstance(op, SawOp):
            yield SawStroke(op.x, op.angle, saw.feed_mm_min, op.source)
        else:
            spindle = spindles[op.faces[0]]
            grade = plan.pieces[op.features[0][0]].part.grade
            yield _drill_cycle(op, spindle, sections[op.faces[0]], drill, grade)


def _section_values(profile: Profile, face: Face, drill: Drill) -> dict[str, float]:
    """The names that a machine's formulas may use, as far as the section gives them."""
    return {
        "height": profile.height,
        "width": profile.width,
        "flange_thickness": profile.flange_thickness,
        "web_thickness": profile.web_thickness or 0.0,
        "thickness": profile.thickness(face),
        "face_depth": profile.face_depth(face),
        "clearance": drill.clearance,
    }


def _drill_cycle(
    op: DrillOp, spindle: Spindle, section: dict[str, float], drill: Drill, grade: str
) -> DrillCycle:
    through = section["thickness"] + drill.breakthrough
    values = {
        **section,
        "y": op.y,
        "depth": through if op.depth is None else op.depth,
        "tip": op.tool.tip,
    }
    across, stroke = spindle.across, spindle.stroke
    position = across.position(values)

    def place(formula: Formula) -> tuple[float, float]:
        at = {across.axis: position, stroke.axis: formula(values)}
        return at["Y"], at["Z"]

    speed_rpm, feed_mm_min = speed_and_feed(op.tool, drill, grade)
    return DrillCycle(
        op.spindle,
        op.tool.diameter,
        op.x,
        place(stroke.start),
        place(stroke.near or stroke.start),
        place(stroke.bottom),
        feed_mm_min,
        speed_rpm,
        op.source,
    )


def speed_and_feed(tool: Tool, drill: Drill, grade: str) -> tuple[float, float]:
    """Spindle speed in rpm and feed in mm/min for a drill, within the machine's limits.

    n = 1000 v / (pi d), v the cutting speed in m/min; feed = n * feed per turn. The table's first
    row that fits the grade and the diameter counts, its last one for anything beyond.
    """
    row = next((r for r in drill.cutting if _fits(r, tool, grade)), drill.cutting[-1])
    speed = 1000 * row.speed_m_min / (pi * tool.diameter)
    speed = min(max(speed, drill.least_speed_rpm), drill.greatest_speed_rpm)
    return speed, min(speed * row.feed_per_turn, drill.greatest_feed_mm_min)


def _fits(row: Cutting, tool: Tool, grade: str) -> bool:
    return tool.diameter <= row.up_to and fnmatchcase(grade.upper(), row.grade.upper())
