"""The station of a spindle that holds a tool, operation by operation."""

from collections.abc import Iterator

from beamcam.machine.machine import Machine
from beamcam.machine.tools import Tool
from beamcam.model.plan import Plan, SawOp, TextOp


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
