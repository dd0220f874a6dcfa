"""The work of one part, independent of its place on a bar, and the tools chosen for it.

ends -> each feature by itself: what it needs, and its place on the finished part
     -> the steps of each kind of work
     -> steps that no axis comes to
     -> refused, or left out where that is allowed
"""

from collections.abc import Collection, Iterator, Mapping, Sequence

from msgspec import Struct

from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.machine.absent import text_x
from beamcam.machine.tools import Tool
from beamcam.model.marks import policy_on
from beamcam.model.part import Feature, Part
from beamcam.model.plan import Bar, DrillOp, FeatureRef, PathOp, Piece, SawOp, TextOp, WorkOp
from beamcam.planning.axis_limits import refuse_steps
from beamcam.planning.by_hand import listed_by, refuse_mark
from beamcam.planning.operations.bench import Bench
from beamcam.planning.operations.ends import SQUARE, Ends, ends_of
from beamcam.planning.operations.kinds import KINDS, kind_of
from beamcam.planning.operations.line import BarLine
from beamcam.planning.operations.saw_cut import SAW_CUT, cuts_of
from beamcam.planning.operations.tools import Tools, settle
from beamcam.planning.operations.working_step import Settled, Tooling, WorkingStep


class PartWork(Struct, frozen=True):
    """The work of one part, and the part of it that is refused."""

    part: Part
    ends: Ends
    refusals: tuple[Diagnostic, ...]
    remarks: tuple[Diagnostic, ...] = ()
    steps: tuple[WorkingStep, ...] = ()
    settled: tuple[Settled, ...] = ()  #: features that need no step
    skipped: Mapping[int, Diagnostic] = {}  #: features left out by permission, and why


def work_on(part: Part, line: BarLine, skips: Collection[str]) -> PartWork:
    """The work of `part` in its orientation; refusals are in the result, and not raised."""
    try:
        ends, remarks = ends_of(part, line.saw.min_mitre)
    except PlanError as error:
        return PartWork(part, SQUARE, error.diagnostics)
    bench = Bench(part, ends, line)
    of_ends = [said for end in ends if (said := SAW_CUT.needs(end, bench))]
    of_ends += SAW_CUT.refusals(ends, bench)
    _put_features(bench)
    for kind in KINDS:
        bench.take(kind.steps(bench.accepted[kind.name], bench))
    bench.refuse(refuse_steps(bench.part.features, bench.steps, bench.travel))
    bench.refuse_repeats()
    refused = bench.refused
    skipped = {f: said for f, said in refused.items() if said.code.removeprefix("plan-") in skips}
    refusals = [*errors_in(of_ends), *(refused[f] for f in sorted(refused) if f not in skipped)]
    told = [*remarks, *(said for said in of_ends if said not in refusals), *bench.remarks]
    return PartWork(
        part,
        ends,
        tuple(refusals),
        tuple(told),
        tuple(bench.steps),
        tuple(bench.settled.values()),
        skipped,
    )


def _put_features(bench: Bench) -> None:
    """Put each feature that can be made to those of its kind, and refuse the others."""
    marks = bench.line.machine.marks
    for f, given in enumerate(bench.part.features):
        if policy_on(given, marks) is not None and not _is_made(f, given, bench):
            continue
        kind, feature = kind_of(given), bench.on_reached_face(f, given)
        lacking = kind.needs(feature, bench)
        if lacking is not None:
            bench.refused[f] = lacking
            continue
        bench.take([(f, said) for said in kind.refusals(feature, bench)])
        if f not in bench.refused:
            bench.accepted[kind.name].append((f, feature))


def _is_made(f: int, mark: Feature, bench: Bench) -> bool:
    """Whether a mark is work of the machine; one that is not is listed, or refused."""
    marks = bench.line.machine.marks
    why, said = listed_by(mark, marks), refuse_mark(mark, marks)
    if why is not None:
        bench.settled[f] = Settled(f, "listed", why)
    elif said is not None:
        bench.refused[f] = said
    return why is None and said is None


def operations_on(
    pieces: Sequence[Piece], works: Sequence[PartWork], line: BarLine, bar: Bar | None = None
) -> tuple[list[SawOp], list[WorkOp]]:
    """The cuts of a line with a saw, and the operations on features, piece by piece.

    Behind a skew end at the end of `bar` nothing is left to be squared.
    """
    cuts: list[SawOp] = []
    if line.machine.saw is not None:
        cuts += cuts_of(pieces, [work.ends for work in works], line.saw, bar)
    return cuts, [*_spindle_operations(pieces, works, line)]


def _spindle_operations(
    pieces: Sequence[Piece], works: Sequence[PartWork], line: BarLine
) -> Iterator[WorkOp]:
    """One operation on features for each step at machine X, piece by piece."""
    chosen = _choose_tools({id(s.tooling): s.tooling for work in works for s in work.steps})
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


def _choose_tools(
    toolings: Mapping[int, Tooling],
) -> dict[int, tuple[Tool, tuple[str, ...]]]:
    """The tool of each tooling and the reasons for it."""
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
    if abs(tool.diameter - how.diameter) <= 1e-9:
        return "drill-exact"
    return "drill-nearest" if tool == how.tools[0] else "drill-twin"
