"""A plan in words: each operation, the reason for it and the reason for its place in the order."""

from collections.abc import Iterator

from msgspec import Struct

from beamcam.machine.machine import Machine
from beamcam.machine.stations import Drill
from beamcam.model.part import Hole
from beamcam.model.plan import (
    DrillOp,
    Operation,
    PathOp,
    Plan,
    SawOp,
    TextOp,
    ToolLoad,
)
from beamcam.planning.nesting import CUT_REASONS
from beamcam.planning.operations.hole import alike, partner_faces
from beamcam.planning.operations.part_planner import ROUNDING
from beamcam.planning.operations.tools import library_of
from beamcam.planning.operations.work import REASONS as WORK_REASONS
from beamcam.planning.order import changes, setup_of, tool_loads, travel, waits_for
from beamcam.planning.times import work_time

#: Why an operation follows the one before it.
PLACES = {
    "place-x": "its place along the bar",
    "place-tool": "at the same X, the tool is in the spindle already",
    "place-after": "at the same X, and made in the hole that comes before",
    "place-changes": "at the same X, in the order of fewest changes of spindle and tool",
}
REASONS = WORK_REASONS | CUT_REASONS | PLACES


class ExplainedOperation(Struct, frozen=True):
    """One operation explained."""

    x: float  #: machine X
    what: str  #: cut, or kind of tool with its size
    where: str  #: face and y, or end of which part
    seconds: float
    reasons: tuple[tuple[str, str], ...]  #: code and its text
    rejected: tuple[str, ...]  #: what might have been done instead, and why it was not
    sources: tuple[str, ...]  #: sources of its features


class Explanation(Struct, frozen=True):
    """A plan explained."""

    steps: tuple[ExplainedOperation, ...]
    loads: tuple[ToolLoad, ...]  #: tools put into stations, before the work and during it
    changes: int  #: of spindle and tool
    forward: float  #: travel of the bar, mm
    back: float
    manual_changes_s: float
    total_s: float


def explain(plan: Plan, machine: Machine) -> Explanation:
    """Every operation of a plan with its reasons and its time, and what the whole costs."""
    time = work_time(plan, machine)
    before = (None, *plan.operations)
    steps = tuple(
        ExplainedOperation(
            op.x, *_what_and_where(op), seconds,
            tuple((code, REASONS[code]) for code in (*op.reasons, _place_code(op, previous))),
            tuple(_rejected(op, plan, machine)),
            (str(op.source),) if isinstance(op, SawOp)
            else tuple(str(plan.feature(ref).source) for ref in op.features),
        )
        for op, previous, seconds in zip(plan.operations, before, time.operations, strict=False)
    )  # fmt: skip
    forward, back = travel(plan.operations)
    return Explanation(
        steps, tool_loads(plan.operations, machine), changes(plan.operations), forward, back,
        time.manual_changes_s, time.total_s,
    )  # fmt: skip


def _what_and_where(op: Operation) -> tuple[str, str]:
    if isinstance(op, SawOp):
        tilt = f", tilt {op.tilt:g}" if op.tilt else ""
        after = f", start of part {op.pieces[1] + 1}" if len(op.pieces) > 1 else ""
        what = f"{op.purpose} cut at {op.angle:g} deg{tilt}"
        return what, f"{op.at} of part {op.pieces[0] + 1}{after}"
    depth = "" if op.depth is None else f", {op.depth:g} deep"
    points = f", {len(op.path)} points" if isinstance(op, PathOp) else ""
    if isinstance(op, TextOp):
        points = f", {op.text.text!r} at {op.text.angle:g} deg"
    part = f"part {op.features[0][0] + 1}"
    return op.tool.name, f"{'+'.join(op.faces)} y {op.y:g}{depth}{points}, {part}"


def _place_code(op: Operation, previous: Operation | None) -> str:
    if previous is None or isinstance(op, SawOp) or isinstance(previous, SawOp):
        return "place-x"
    if abs(op.x - previous.x) > 1e-9:
        return "place-x"
    if waits_for(op, previous):
        return "place-after"
    return "place-tool" if setup_of(op) == setup_of(previous) else "place-changes"


def unmerged_because(hole: Hole, other: Hole, drill: Drill) -> str | None:
    """Why two nearby holes on the faces of a pair are not one stroke.

    None if nothing does, or if they are too far apart for the question.
    """
    if abs(hole.x - other.x) > NEAR_MISS or abs(hole.y - other.y) > NEAR_MISS:
        return None
    for name in ("x", "y"):
        mine, theirs = getattr(hole, name), getattr(other, name)
        if abs(mine - theirs) > drill.merge_tolerance + ROUNDING:
            return f"{name} {mine:g} and {theirs:g}"
    if hole.kind != other.kind:
        return f"kind {hole.kind} and {other.kind}"
    if abs(hole.diameter - other.diameter) > drill.same_tool_tolerance + ROUNDING:
        return f"diameter {hole.diameter:g} and {other.diameter:g}"
    if not alike(hole, other, drill.same_tool_tolerance + ROUNDING):
        return f"depth {_shown(hole.depth)} and {_shown(other.depth)}"
    return None


NEAR_MISS = 10.0  #: mm; holes further apart than this are not expected to merge


def _shown(depth: float | None) -> str:
    return "through" if depth is None else f"{depth:g}"


DRILL_REASONS = ("drill-exact", "drill-nearest", "drill-twin")


def _rejected(op: Operation, plan: Plan, machine: Machine) -> Iterator[str]:
    """The drills that would do too, and why a hole is not made together with one beside it.

    That is one on the opposite flange that is nearly the same.
    """
    if not isinstance(op, DrillOp) or not isinstance(plan.feature(op.features[0]), Hole):
        return
    library = library_of(machine)
    holes = [hole for ref in op.features if isinstance(hole := plan.feature(ref), Hole)]
    diameters = tuple(hole.diameter for hole in holes)
    if op.tool.kind == "drill" and op.reasons[0] in DRILL_REASONS:
        used = max(abs(op.tool.diameter - d) for d in diameters)
        for tool in library.fitting(diameters, op.faces):
            if tool != op.tool:
                off = max(abs(tool.diameter - d) for d in diameters)
                is_near = off - used <= library.drill.same_tool_tolerance + 1e-9
                because = "no nearer" if is_near else "further off"
                yield f"{tool.name}: {off:g} mm off, {because}"
    for hole in holes if len(op.faces) == 1 else ():
        partner = partner_faces(machine).get(hole.face)
        for f, other in enumerate(plan.pieces[op.features[0][0]].part.features):
            if isinstance(other, Hole) and other.face == partner:
                why = unmerged_because(hole, other, library.drill)
                if why is not None:
                    yield f"both flanges at once ({other.source}, feature {f + 1}): {why}"
