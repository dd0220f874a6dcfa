"""Trigger programs of SIMOTION read back: checked, run with simulated axes, compared.

Written from the controller's documentation and the machine file; nothing is shared with planning,
motion or the emitters.

    text -> units (parser) -> names, types, parameters, bounds (checker) -> latches (chains)
         -> run cycle by cycle (interpreter, cell, axes) -> strokes -> compared with the contours
"""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.machine import Machine, TorchRow
from beamcam.model.part import Part
from beamcam.verify.st import rules
from beamcam.verify.st.chains import check_chains
from beamcam.verify.st.checker import check
from beamcam.verify.st.parser import parse
from beamcam.verify.st.syntax import Unit

if TYPE_CHECKING:
    from beamcam.verify.st.cell import Cell, Stroke

__all__ = ["check_text", "run", "verify_triggers"]

FeatureRef = tuple[int, int]
SPEED_SLACK = 1e-6
LATE_S = 0.5  #: a stop takes at most this


def check_text(
    text: str, machine: Machine, name: str = "program"
) -> tuple[list[Unit], list[Diagnostic]]:
    """The units of a text, and what is wrong with them without running them."""
    triggers = machine.triggers
    if triggers is None:
        raise TypeError(f"{machine.name} has no trigger program")
    units, said = parse(text, name, triggers.names)
    if said:
        return [], said
    paths = (triggers.path_object,) if triggers.path_objects else ()
    said = check(units, triggers.axes, paths, name)
    for unit in units:
        if unit.blocks and triggers.package not in unit.packages:
            found = f"no USEPACKAGE {triggers.package}"
            said.append(rules.NAME.at(Source(name, 1), found=found, expected=triggers.package))
    return units, said + check_chains(units, name)


def run(
    units: Sequence[Unit], machine: Machine, name: str = "program"
) -> "tuple[list[Stroke], list[Diagnostic]]":
    """The strokes of a program, run to its end with simulated axes, and what went wrong."""
    from beamcam.verify.st.cell import Cell
    from beamcam.verify.st.interpreter import Fault

    cell = Cell(units, machine, name)
    values = cell.interpreter.globals
    if "WORKDONE" not in values or "WORKFAULT" not in values:
        found = "no workDone and workFault"
        cell.say(rules.RUN, None, found=found, expected="both as global variables")
    if errors_in(cell.said):
        return [], cell.said
    try:
        while not values["WORKDONE"]:
            cell.cycle()
            if values["WORKFAULT"]:
                cell.say(rules.RUN, None, found="a fault", expected="work to its end")
                break
            if cell.stalled:
                found = f"the program waiting for ever at {_place(cell)}"
                cell.say(rules.RUN, None, found=found, expected="its end")
                break
    except Fault as fault:
        return cell.strokes, [*cell.said, fault.diagnostic]
    if not errors_in(cell.said):
        _at_end(cell)
    said = list(cell.said)
    if not errors_in(said):
        said += _limit_stops(units, machine, name)
    return cell.strokes, said


def _place(cell: "Cell") -> str:
    return " ".join(f"{a.name} {a.position:.3f}" for a in cell.axes)


def _at_end(cell: "Cell") -> None:
    """Where and how a program ends."""
    near = cell.triggers.in_position + 1e-9
    if any(abs(a.position) > near for a in cell.axes):
        cell.say(rules.RUN, None, found=f"the end at {_place(cell)}", expected="both axes at 0")
    cell.cycle()
    if cell.tool_on:
        cell.say(rules.TOOL, None, found="a tool on at the end", expected="off")
    if cell.off_line > cell.torch.tolerance:
        found, expected = f"{cell.off_line:.4f}", f"{cell.torch.tolerance:g}"
        cell.say(rules.STRAIGHT, None, found=found, expected=expected)
    rows: dict[str, list[TorchRow]] = {}
    for row in cell.torch.rows:
        rows.setdefault(row.process, []).append(row)
    for stroke in cell.strokes:
        fastest = max(row.feed_mm_min for row in rows[stroke.process]) / 60.0
        if stroke.greatest_mm_s > fastest + SPEED_SLACK:
            found = f"{stroke.greatest_mm_s:.3f}"
            cell.say(rules.SPEED, None, found=found, expected=f"{fastest:g}")


def _limit_stops(units: Sequence[Unit], machine: Machine, name: str) -> list[Diagnostic]:
    """Close each limit switch while the tool works, and look whether everything stops."""
    from beamcam.verify.st.cell import Cell

    assert machine.triggers is not None
    for k, address in enumerate(machine.triggers.limits):
        cell = Cell(units, machine, name)
        while not (cell.tool_on and any(not a.still for a in cell.axes)) and not cell.stalled:
            if cell.interpreter.globals["WORKDONE"]:
                return []  # no tool is used at all
            if cell.path is not None and cell.tool_on and not cell.path.still:
                break
            cell.cycle()
        cell.closed.add(k)
        since = cell.clock_s
        while cell.clock_s < since + LATE_S:
            cell.cycle()
        moving = any(not a.still for a in cell.axes)
        if moving or cell.tool_on or not cell.interpreter.globals["WORKFAULT"]:
            found = f"work going on with the limit switch {address} closed"
            cell.say(rules.HOME, None, found=found, expected="a stop with the tool off")
            return cell.said
    return []


def verify_triggers(
    text: str,
    parts: Sequence[Part],
    machine: Machine,
    skipped: Collection[FeatureRef] = (),
    name: str = "program",
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with a trigger program, by itself and against its part.

    Nothing comes back for a program that makes exactly the part.
    """
    torch = machine.torch
    if torch is None:
        raise TypeError(f"{machine.name} has no torch")
    units, said = check_text(text, machine, name)
    if errors_in(said):
        return tuple(said)
    strokes, more = run(units, machine, name)
    said += more
    if errors_in(said) or not parts:
        return tuple(said)
    from beamcam.verify.polylines import compare_polylines

    (part,) = parts
    for stroke in strokes:
        said += _pierced(stroke, part, machine, name)
    ways = [(stroke.process, stroke.points) for stroke in strokes]
    slack = machine.triggers.in_position if machine.triggers else 0.0
    said += compare_polylines(ways, part, machine, skipped, slack, name)
    return tuple(said)


def _pierced(stroke: "Stroke", part: Part, machine: Machine, name: str) -> list[Diagnostic]:
    """Whether the head has waited where the tool was started."""
    from beamcam.verify.sheets.need import rows_of

    assert machine.torch is not None
    row = next((r for r in rows_of(part, machine.torch) if r.process == stroke.process), None)
    if row is None:
        found = f"the tool to {stroke.process}"
        return [rules.TOOL.at(Source(name), found=found, expected="a tool that the sheet needs")]
    waited = (stroke.first_move_s or stroke.begin_s) - stroke.begin_s
    if waited < row.pierce_s - 1e-6:
        found = f"a wait of {waited:.3f} s behind the start of the tool"
        return [rules.TOOL.at(Source(name), found=found, expected=f"{row.pierce_s:g} s")]
    return []
