"""Steels, tools and diameters that the machine's data meet only approximately."""

from collections.abc import Collection, Iterator, Sequence

from msgspec.structs import replace

from beamcam.caches import BoundedCache, PerObject
from beamcam.errors import Diagnostic, Source
from beamcam.machine.cutting import cutting_row, is_unnamed, turns_of
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Drill
from beamcam.machine.tools import Tool
from beamcam.model.part import Hole
from beamcam.model.plan import Piece, WorkOp
from beamcam.planning import rules

TURNING = ("drill", "countersink", "mill")  #: tools whose edge wears by its speed
TOO_FAST = 1.2  #: times the speed of the data at which a tool is warned of

Remarks = tuple[Diagnostic, ...]


_known_of: PerObject[Machine, BoundedCache[object, Remarks]] = PerObject(
    "planning.machines", lambda _: BoundedCache("planning.remarks")
)


def cutting_remarks(
    pieces: Sequence[Piece], operations: Sequence[WorkOp], machine: Machine
) -> Iterator[Diagnostic]:
    """A note for a steel that no row names, a warning for each tool that turns too fast in it, a
    note for each diameter that no drill has."""
    if machine.drill is None:
        return
    used: dict[str, dict[int, Tool]] = {}
    sources: dict[str, Source] = {}
    for op in operations:
        part = pieces[op.features[0][0]].part
        sources.setdefault(part.grade, part.source)
        used.setdefault(part.grade, {})[id(op.tool)] = op.tool
    known = _known_of(machine)
    for grade, tools in used.items():
        key = grade, *tools.values()
        found = known.get(key)
        if found is None:
            found = known.keep(key, tuple(_remarks(grade, tools.values(), machine, machine.drill)))
        for said in found:
            yield replace(said, source=sources[grade])
    yield from _size_remarks(pieces, operations, machine.drill)


def _size_remarks(
    pieces: Sequence[Piece], operations: Sequence[WorkOp], drill: Drill
) -> Iterator[Diagnostic]:
    """A note for each diameter that is drilled over or under, at the first such hole."""
    seen: set[tuple[float, int]] = set()
    for op in operations:
        if op.tool.kind != "drill":
            continue
        for p, f in op.features:
            hole = pieces[p].part.features[f]
            if not isinstance(hole, Hole) or hole.kind not in ("through", "blind"):
                continue
            key, off = (hole.diameter, id(op.tool)), op.tool.diameter - hole.diameter
            if key in seen or abs(off) <= drill.twin + 1e-9:
                continue
            seen.add(key)
            yield rules.DRILL_SIZE.at(
                hole.source, found=f"{hole.diameter:g}", size=f"{op.tool.diameter:g}",
                off=f"{abs(off):.3g}", way="over" if off > 0 else "under",
            )  # fmt: skip


def _says_speeds(machine: Machine) -> bool:
    """Whether the machine's programs contain the cutting data."""
    words = (getattr(machine.words, kind) for kind in TURNING)
    return any("{feed}" in line or "{speed}" in line for lines in words for line in lines)


def _remarks(
    grade: str, tools: Collection[Tool], machine: Machine, drill: Drill
) -> Iterator[Diagnostic]:
    if not _says_speeds(machine):
        return
    source = Source(machine.name)
    shown = grade or "unknown"
    if grade and is_unnamed(drill, grade):
        yield rules.UNNAMED_GRADE.at(source, found=shown, machine=machine.name)
    for tool in tools:
        if tool.kind not in TURNING:
            continue
        turns = turns_of(cutting_row(tool, drill, grade), tool)
        if turns * TOO_FAST < drill.min_speed_rpm:
            yield rules.CUTTING_SPEED.at(
                source, tool=tool.name, grade=shown, found=f"{drill.min_speed_rpm:g}",
                expected=f"{turns:.0f}",
            )  # fmt: skip
