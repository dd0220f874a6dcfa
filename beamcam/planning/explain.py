"""A plan in words: what each operation is, why it is so and why it stands where it does."""

from collections.abc import Iterator

from msgspec import Struct

from beamcam.machine.machine import Machine
from beamcam.model.part import Hole
from beamcam.model.plan import (
    DrillOp,
    FeatureRef,
    Operation,
    PathOp,
    Plan,
    SawOp,
    SpindleOp,
    ToolLoad,
)
from beamcam.planning.magazine import tool_loads
from beamcam.planning.merging import unmerged_because
from beamcam.planning.order import changes, setup_of, travel, waits_for
from beamcam.planning.reasons import REASONS
from beamcam.planning.times import work_time
from beamcam.planning.tools import Rack, rack_of


class Step(Struct, frozen=True):
    """One operation explained."""

    x: float  #: machine X
    what: str  #: cut, or kind of tool with its size
    where: str  #: face and y, or end of which part
    seconds: float
    reasons: tuple[tuple[str, str], ...]  #: code and what it says
    rejected: tuple[str, ...]  #: what might have been done instead, and why it was not
    sources: tuple[str, ...]  #: where its features stand in their files


class Explanation(Struct, frozen=True):
    """A plan explained."""

    steps: tuple[Step, ...]
    loads: tuple[ToolLoad, ...]  #: tools put into stations, before the work and during it
    changes: int  #: of spindle and tool
    forward: float  #: travel of the bar, mm
    back: float
    reloads_s: float
    total_s: float


def explain(plan: Plan, machine: Machine) -> Explanation:
    """Every operation of a plan with its reasons and its time, and what the whole costs."""
    time = work_time(plan, machine)
    rack = rack_of(machine)
    before = (None, *plan.operations)
    steps = tuple(
        Step(
            op.x,
            _what(op),
            _where(op, plan),
            seconds,
            tuple((code, REASONS[code]) for code in (*op.reasons, _place_code(op, previous))),
            tuple(_rejected(op, plan, machine, rack)),
            tuple(_sources(op, plan)),
        )
        for op, previous, seconds in zip(plan.operations, before, time.operations, strict=False)
    )
    forward, back = travel(plan.operations)
    return Explanation(
        steps,
        tool_loads(plan.operations, machine),
        changes(plan.operations),
        forward,
        back,
        time.reloads_s,
        time.total_s,
    )


def _what(op: Operation) -> str:
    if isinstance(op, SawOp):
        tilt = f", tilt {op.tilt:g}" if op.tilt else ""
        return f"{op.purpose} cut at {op.angle:g} deg{tilt}"
    return op.tool.name


def _where(op: Operation, plan: Plan) -> str:
    if isinstance(op, SawOp):
        first = f"{op.at} of part {op.pieces[0] + 1}"
        return first + (f", start of part {op.pieces[1] + 1}" if len(op.pieces) > 1 else "")
    depth = "" if op.depth is None else f", {op.depth:g} deep"
    points = f", {len(op.path)} points" if isinstance(op, PathOp) else ""
    part = f"part {op.features[0][0] + 1}"
    return f"{'+'.join(op.faces)} y {op.y:g}{depth}{points}, {part}"


def _place_code(op: Operation, previous: Operation | None) -> str:
    """Why an operation stands behind the one before it."""
    if previous is None or isinstance(op, SawOp) or isinstance(previous, SawOp):
        return "place-x"
    if abs(op.x - previous.x) > 1e-9:
        return "place-x"
    if waits_for(op, previous):
        return "place-after"
    return "place-tool" if setup_of(op) == setup_of(previous) else "place-changes"


def _sources(op: Operation, plan: Plan) -> Iterator[str]:
    if isinstance(op, SawOp):
        yield str(op.source)
    else:
        for p, f in op.features:
            yield str(plan.pieces[p].part.features[f].source)


def _rejected(op: Operation, plan: Plan, machine: Machine, rack: Rack) -> Iterator[str]:
    if not isinstance(op, DrillOp):
        return
    yield from _other_drills(op, plan, rack)
    yield from _missed_merges(op, plan, machine, rack)


def _holes(op: SpindleOp, plan: Plan) -> Iterator[tuple[FeatureRef, Hole]]:
    for p, f in op.features:
        feature = plan.pieces[p].part.features[f]
        if isinstance(feature, Hole):
            yield (p, f), feature


def _other_drills(op: DrillOp, plan: Plan, rack: Rack) -> Iterator[str]:
    """The drills that are within the tolerance too."""
    diameters = tuple(hole.diameter for _, hole in _holes(op, plan))
    if op.tool.kind != "drill" or not diameters or op.reasons[0] not in DRILL_CODES:
        return
    for tool in rack.fitting(diameters, op.faces):
        if tool != op.tool:
            off = max(abs(tool.diameter - d) for d in diameters)
            used = max(abs(op.tool.diameter - d) for d in diameters)
            because = "no nearer" if off - used <= rack.drill.twin + 1e-9 else "further off"
            yield f"{tool.name}: {off:g} mm off, {because}"


DRILL_CODES = ("drill-exact", "drill-nearest", "drill-twin")


def _missed_merges(op: DrillOp, plan: Plan, machine: Machine, rack: Rack) -> Iterator[str]:
    """Holes on the opposite flange that are nearly the same."""
    for ref, hole in _holes(op, plan) if len(op.faces) == 1 else ():
        partners = {a: b for pair in machine.pairs for a, b in (pair.faces, pair.faces[::-1])}
        wanted = partners.get(hole.face)
        for f, other in enumerate(plan.pieces[ref[0]].part.features):
            if isinstance(other, Hole) and other.face == wanted:
                because = unmerged_because(hole, other, rack.drill)
                if because is not None:
                    yield f"both flanges at once ({other.source}, feature {f + 1}): {because}"
