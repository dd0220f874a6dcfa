"""The motion of a saw and drilling line: strokes and feeds in machine coordinates."""

from collections.abc import Collection, Iterator
from typing import Literal, cast

from msgspec import Struct

from beamcam.caches import BoundedCache, PerObject, PerObjectAndKey
from beamcam.machine.machine import Machine, drill_of, names_in, saw_of
from beamcam.machine.stations import Drill, Tool, speed_and_feed
from beamcam.machine.words import PART_NAMES, WORK_WORDS
from beamcam.model.cell_motion import StrokeGeometry
from beamcam.model.part import Profile, part_data
from beamcam.model.plan import AS_GIVEN, DrillOp, PathOp, Plan, SawOp, TextOp
from beamcam.model.program import (
    BeginPart,
    ChangeTool,
    Command,
    Comment,
    DrillCycle,
    OfPart,
    PathCycle,
    PathPoint,
    PrintText,
    Program,
    SawStroke,
    SpindleStroke,
    StartBar,
)
from beamcam.plain_text import outside_text


def stations_of(plan: Plan, machine: Machine) -> Iterator[int]:
    """For each operation the station of its first spindle, from 1; 0 for one without a tool.

    The stations are loaded before the work in the order in which their tools are needed; a tool
    that finds all of them taken comes where the plan has it changed by hand.
    """
    names = {spindle.face: spindle.name for spindle in machine.spindles}
    held: dict[str, list[Tool]] = {name: [] for name in names.values()}
    changed = {(load.before, load.spindle): load for load in plan.reloads}
    for index, op in enumerate(plan.operations):
        if isinstance(op, SawOp | TextOp):
            yield 0
            continue
        for name in (name for face, name in names.items() if face in op.faces):
            load = changed.get((index, name))
            if load is not None:
                held[name][load.station - 1] = load.tool
            elif op.tool not in held[name]:
                held[name].append(op.tool)
        first = next(name for face, name in names.items() if face == op.faces[0])
        yield held[first].index(op.tool) + 1


class SpindleSection(Struct, frozen=True):
    """Section data as needed on one machine."""

    strokes: StrokeGeometry
    made: BoundedCache[tuple[object, ...], SpindleStroke]  #: by the steel's grade and the operation


_section_of: PerObjectAndKey[Machine, Profile, SpindleSection] = PerObjectAndKey(
    "motion.machines", "motion.sections",
    lambda machine, profile: SpindleSection(
        StrokeGeometry(profile, machine), BoundedCache("motion.strokes")
    ),
)  # fmt: skip


class _Names(Struct, frozen=True):
    """The names in braces that the words of a machine carry."""

    all: frozenset[str]
    of_work: frozenset[str]  #: of those for work on a part


_names_of: PerObject[Machine, _Names] = PerObject(
    "motion.names",
    lambda machine: _Names(
        names_in(machine.words, (*WORK_WORDS, "header")), names_in(machine.words, WORK_WORDS)
    ),
)


def beam_program(plan: Plan, machine: Machine, job: str) -> Program:
    """The commands that carry out a plan, in its order."""
    names = _names_of(machine)
    names_parts = not PART_NAMES.isdisjoint(names.all)
    about = part_data([piece.part for piece in plan.pieces]) if names_parts else {}
    return Program(job, tuple(_commands(plan, machine, names.of_work)), about)


def _commands(plan: Plan, machine: Machine, names: Collection[str]) -> Iterator[Command]:
    """The commands; `names` are those in the words of work on a part."""
    saw, drill = saw_of(machine), drill_of(machine)
    profile = plan.profile
    yield StartBar(machine.sections[profile.code], profile.width, profile.height)
    for index, piece in enumerate(plan.pieces):
        if piece.turn != AS_GIVEN:
            # Whoever loads the bar cannot see it in the figures, since the part is not marked yet.
            mark = outside_text(piece.part.mark)
            yield Comment(f"part {index + 1}, {mark}: {piece.turn}")
    section = _section_of(machine, profile)
    waiting = list(plan.reloads)
    of_part = not PART_NAMES.isdisjoint(names)
    stations = [*stations_of(plan, machine)] if "station" in names else None
    worked: int | None = None  #: piece of the last operation
    begins = _begins(plan)
    for index, op in enumerate(plan.operations):
        for begun in begins.get(index, ()):
            yield BeginPart(
                f"PART {begun + 1} BEGINS: {outside_text(plan.pieces[begun].part.mark)}"
            )
        if of_part:
            on = op.pieces[0] if isinstance(op, SawOp) else op.features[0][0]
            if on != worked:
                yield OfPart(part_data([plan.pieces[on].part]))
                worked = on
        station = 0 if stations is None else stations[index]
        while waiting and waiting[0].before == index:
            load = waiting.pop(0)  # a manual change, with its program stop
            out = f" for {load.out.name}" if load.out else ""
            text = f"{load.spindle} station {load.station}: {load.tool.name}{out}"
            yield Comment(text)
            yield ChangeTool(load.number, load.station, load.tool.diameter, text)
        match op:
            case DrillOp():
                grade = plan.pieces[op.features[0][0]].part.grade
                yield DrillCycle(op.x, _stroke(op, section, drill, grade, station), op.source)
            case PathOp():
                grade = plan.pieces[op.features[0][0]].part.grade
                speed_rpm, feed_mm_min = speed_and_feed(op.tool, drill, grade)
                points = tuple(PathPoint(x, *section.strokes.places(op, y)) for x, y in op.path)
                yield PathCycle(
                    "mill" if op.tool.kind == "mill" else "scribe", op.spindle, op.tool.diameter,
                    points, feed_mm_min, speed_rpm, op.source, op.tool.name, station,
                )  # fmt: skip
            case SawOp():
                yield SawStroke(op.x, op.angle, saw.feed_mm_min, op.source, op.tilt)
            case TextOp():
                yield PrintText(
                    op.tool.kind, op.x, op.y, op.text.text, op.text.height, op.text.angle,
                    op.spindle, op.source,
                )  # fmt: skip


def _begins(plan: Plan) -> dict[int, list[int]]:
    """The pieces that each operation is the first for, by its index.

    The cut that ends a piece begins the next one only if that one has no work of its own.
    """
    own: dict[int, int] = {}
    shared: dict[int, int] = {}
    for index, op in enumerate(plan.operations):
        first, *others = op.pieces if isinstance(op, SawOp) else [f[0] for f in op.features]
        own.setdefault(first, index)
        for piece in others:
            shared.setdefault(piece, index)
    begins: dict[int, list[int]] = {}
    for piece in range(len(plan.pieces)):
        at = own.get(piece, shared.get(piece))
        if at is not None:
            begins.setdefault(at, []).append(piece)
    return begins


def _stroke(
    op: DrillOp, section: SpindleSection, drill: Drill, grade: str, station: int
) -> SpindleStroke:
    """The stroke of an operation; most are like one before, at another X."""
    key = grade, op.spindle, op.tool, op.faces, op.y, op.depth, station
    known = section.made.get(key)
    if known is not None:
        return known
    speed_rpm, feed_mm_min = speed_and_feed(op.tool, drill, grade)
    kind = cast("Literal['drill', 'tap', 'countersink', 'punch']", op.tool.kind)
    stroke = SpindleStroke(
        op.spindle, op.tool.diameter, *section.strokes.places(op, op.y), feed_mm_min, speed_rpm,
        kind, op.tool.pitch, op.tool.max_peck, op.tool.name, station,
    )  # fmt: skip
    return section.made.keep(key, stroke)
