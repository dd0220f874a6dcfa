"""The operations that make the parts of a bar: cuts and work by spindles, with their tools."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

from beamcam.machine.machine import text_x
from beamcam.machine.stations import Tool
from beamcam.model.plan import DrillOp, FeatureRef, PathOp, Piece, SawOp, TextOp, WorkOp
from beamcam.planning.nesting import LaidParts
from beamcam.planning.operations.part_planner import BarLine
from beamcam.planning.operations.saw_cut import cuts_of
from beamcam.planning.operations.tools import ROUNDING, Tooling, Tools
from beamcam.planning.operations.work import PartWork


def bar_operations(laid: LaidParts, line: BarLine) -> tuple[list[SawOp], list[WorkOp]]:
    """The cuts of a line with a saw, and the operations on features, piece by piece."""
    strokes = [*_spindle_operations(laid.pieces, laid.works, line)]
    if line.machine.saw is None:
        return [], strokes
    ends = [work.ends for work in laid.works]
    return [*cuts_of(laid.pieces, ends, laid.shared, line.saw, laid.bar)], strokes


def _spindle_operations(
    pieces: Sequence[Piece], works: Sequence[PartWork], line: BarLine
) -> Iterator[WorkOp]:
    """One operation on features for each step at machine X, piece by piece."""
    chosen = _chosen_tools({id(s.tooling): s.tooling for work in works for s in work.steps})
    for index, (piece, work) in enumerate(zip(pieces, works, strict=True)):
        offset = line.drill.x + piece.start
        for step in work.steps:
            how = step.tooling
            tool, reasons = chosen[id(how)]
            features: tuple[FeatureRef, ...] = ((index, step.features[0]),)
            if len(step.features) > 1:
                features = tuple([(index, f) for f in step.features])
            if step.text is not None:
                yield TextOp(
                    piece.start + step.x + text_x(line.machine), how.spindle, tool, how.faces,
                    step.y, step.text, features, reasons, step.source,
                )  # fmt: skip
            elif step.path:
                path = tuple((offset + x, y) for x, y in step.path)
                yield PathOp(
                    path[0][0], how.spindle, tool, how.faces, path, how.depth, features, reasons,
                    step.source,
                )  # fmt: skip
            else:
                yield DrillOp(
                    offset + step.x, how.spindle, tool, how.faces, step.y, how.depth, features,
                    reasons, step.source,
                )  # fmt: skip


def settle(choices: Iterable[Tools]) -> dict[Tools, Tool]:
    """For each choice of equally good tools the one to take, so that few tools are needed.

    A tool that another choice leaves no way around is taken where it is as good; what is left is
    shared out, the tool that serves most choices first. Of equally useful ones the nearest.
    """
    open_choices = dict.fromkeys(choices)
    taken = {choice[0] for choice in open_choices if len(choice) == 1}
    settled: dict[Tools, Tool] = {}
    for choice in list(open_choices):
        known = next((tool for tool in choice if tool in taken), None)
        if known is not None:
            settled[choice] = known
            del open_choices[choice]
    while open_choices:
        counts: dict[Tool, tuple[int, int, float]] = {}
        for choice in open_choices:
            for rank, tool in enumerate(choice):
                serves, distance, _ = counts.get(tool, (0, 0, 0.0))
                counts[tool] = (serves - 1, distance + rank, tool.diameter)
        best = min(counts, key=lambda tool: counts[tool])
        for choice in [c for c in open_choices if best in c]:
            settled[choice] = best
            del open_choices[choice]
    return settled


def _chosen_tools(toolings: Mapping[int, Tooling]) -> dict[int, tuple[Tool, tuple[str, ...]]]:
    """The tool of each tooling of a bar, by the same keys, and the reasons for it."""
    settled: dict[Tools, Tool] = {}
    if any(len(how.tools) > 1 for how in toolings.values()):
        settled = settle(how.tools for how in toolings.values())
    chosen = {}
    for key, how in toolings.items():
        tool = how.tools[0] if len(how.tools) == 1 else settled[how.tools]
        reasons = (_drill_reason(tool, how), *how.reasons) if how.diameter else how.reasons
        chosen[key] = tool, reasons
    return chosen


def _drill_reason(tool: Tool, how: Tooling) -> str:
    """Why a plain hole gets this drill."""
    if abs(tool.diameter - how.diameter) <= ROUNDING:
        return "drill-exact"
    return "drill-nearest" if tool == how.tools[0] else "drill-twin"
