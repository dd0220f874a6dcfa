"""Assignment of tools to stations, and the tool changes during the work.

A spindle changes by itself among the tools of its stations. If the work needs more tools than
there are stations, tools are changed manually. Loading the stations before the work is
free; after that each load of a tool that is not there throws one out. The fewest loads come from
throwing out the tool that is needed again last, or never:

    L. A. Belady, A study of replacement algorithms for a virtual-storage computer,
    IBM Systems Journal 5 (1966): no other choice loads less often for a given order of work.
"""

from collections.abc import Collection, Iterator, Sequence

from msgspec.structs import replace

from beamcam.caches import BoundedCache, PerObject
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Drill, Spindle, Tool, cutting_row, is_unnamed, turns_of
from beamcam.model.part import Hole
from beamcam.model.plan import DrillOp, Operation, PathOp, Piece, ToolLoad, WorkOp
from beamcam.planning import rules


def tool_loads(operations: Sequence[Operation], machine: Machine) -> tuple[ToolLoad, ...]:
    """Every load, those before the work first and the others in the order of work."""
    loads = [load for s in machine.spindles for load in _loads_of(operations, s)]
    return tuple(sorted(loads, key=lambda load: (load.out is not None, load.before)))


def _loads_of(operations: Sequence[Operation], spindle: Spindle) -> Iterator[ToolLoad]:
    needs = [
        (index, op.tool)
        for index, op in enumerate(operations)
        if isinstance(op, (DrillOp, PathOp)) and spindle.face in op.faces
    ]
    stations: list[Tool] = []
    for at, (index, tool) in enumerate(needs):
        if tool in stations:
            continue
        if len(stations) < spindle.stations:
            stations.append(tool)
            yield ToolLoad(0, spindle.name, len(stations), tool, None, spindle.number)
            continue
        later = [t for _, t in needs[at:]]
        again = [later.index(t) if t in later else len(later) for t in stations]
        station = again.index(max(again))
        yield ToolLoad(index, spindle.name, station + 1, tool, stations[station], spindle.number)
        stations[station] = tool


def reloads(
    operations: Sequence[Operation], machine: Machine, source: Source
) -> tuple[tuple[ToolLoad, ...], tuple[Diagnostic, ...]]:
    """The manual tool changes in order of work; and a warning for each spindle of theirs.

    An error instead where the machine has no word that stops the program for them.
    """
    # Tools come from one library, so there are no more tools than there are objects.
    objects = {id(op.tool) for op in operations if isinstance(op, (DrillOp, PathOp))}
    if len(objects) <= min((s.stations for s in machine.spindles), default=0):
        return (), ()
    found = tuple(load for load in tool_loads(operations, machine) if load.out is not None)
    remarks = []
    for spindle in machine.spindles:
        changed = sum(load.spindle == spindle.name for load in found)
        if changed:
            worked = [op for op in operations if isinstance(op, (DrillOp, PathOp))]
            count = len({op.tool for op in worked if spindle.face in op.faces})
            rule = rules.RELOAD if machine.words.change else rules.NO_CHANGE_WORD
            remarks.append(
                rule.at(
                    source, found=count, stations=spindle.stations, spindle=spindle.name,
                    changes=changed, machine=machine.name,
                )
            )  # fmt: skip
    return found, tuple(remarks)


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
