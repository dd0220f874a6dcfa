"""Assignment of tools to stations, and the tool changes during the work.

A spindle changes by itself among the tools of its stations. If the work needs more tools than
there are stations, tools are changed manually. Loading the stations before the work is
free; after that each load of a tool that is not there throws one out. The fewest loads come from
throwing out the tool that is needed again last, or never:

    L. A. Belady, A study of replacement algorithms for a virtual-storage computer,
    IBM Systems Journal 5 (1966): no other choice loads less often for a given order of work.
"""

from collections.abc import Iterator, Sequence

from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Spindle
from beamcam.machine.tools import Tool
from beamcam.model.plan import DrillOp, Operation, PathOp, ToolLoad
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
