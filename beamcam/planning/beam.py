"""The plan of a bar on a saw and drilling line.

parts, as they lie -> what each needs (work) -> in order, laid on the bar
      -> operations at machine X, with their tools -> in order of work -> a ledger of every feature
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import chain, repeat
from operator import attrgetter
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from beamcam.budget import FEATURES, InForce, LimitError
from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.machine.machine import Machine, drill_of, text_x
from beamcam.machine.stations import Tool
from beamcam.model.part import Part
from beamcam.model.plan import (
    AS_GIVEN,
    DrillOp,
    FeatureRef,
    Order,
    Outcome,
    PathOp,
    Piece,
    Plan,
    SawOp,
    TextOp,
    WorkOp,
)
from beamcam.planning import rules
from beamcam.planning.axis_limits import refuse_bar
from beamcam.planning.nesting import LaidParts, cuts_of, lay
from beamcam.planning.operations.tools import ROUNDING, Tooling, Tools
from beamcam.planning.operations.work import PartWork, refuse_stock, works_on
from beamcam.planning.order import cutting_remarks, reloads, sort_along_x
from beamcam.planning.rules import is_too_short
from beamcam.planning.times import work_time
from beamcam.planning.turning import TURNS, Turn, alike, lies, turned


def bar_operations(laid: LaidParts, machine: Machine) -> tuple[list[SawOp], list[WorkOp]]:
    """The cuts of a line with a saw, and the operations on features, piece by piece."""
    strokes = [*_spindle_operations(laid.pieces, laid.works, machine)]
    if machine.saw is None:
        return [], strokes
    ends = [work.ends for work in laid.works]
    return [*cuts_of(laid.pieces, ends, laid.shared, machine.saw, laid.bar)], strokes


def _spindle_operations(
    pieces: Sequence[Piece], works: Sequence[PartWork], machine: Machine
) -> Iterator[WorkOp]:
    """One operation on features for each step at machine X, piece by piece."""
    chosen = _chosen_tools({id(s.tooling): s.tooling for work in works for s in work.steps})
    for index, (piece, work) in enumerate(zip(pieces, works, strict=True)):
        offset = drill_of(machine).x + piece.start
        for step in work.steps:
            how = step.tooling
            tool, reasons = chosen[id(how)]
            features: tuple[FeatureRef, ...] = ((index, step.features[0]),)
            if len(step.features) > 1:
                features = tuple([(index, f) for f in step.features])
            if step.text is not None:
                yield TextOp(
                    piece.start + step.x + text_x(machine), how.spindle, tool, how.faces,
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
        tool, reasons = how.tools[0], how.reasons
        if len(how.tools) > 1:
            tool = settled[how.tools]
        if how.diameter:
            why = "drill-nearest" if tool == how.tools[0] else "drill-twin"
            if abs(tool.diameter - how.diameter) <= ROUNDING:
                why = "drill-exact"
            reasons = (why, *reasons)
        chosen[key] = tool, reasons
    return chosen


LEDGER_TOLERANCE = 0.001  #: mm


def plan_bar(
    parts: Sequence[Part], machine: Machine, bar: float | None = None, skips: Collection[str] = (),
    order: Order = "given",
) -> Plan:  # fmt: skip
    """The work that makes `parts`, as they lie, from one bar of length `bar`, or as they need.

    `skips` names what may be left out (`SKIP_NAMES`), `order` whether the parts lie as they
    are given or as they nest best. Raises PlanError with everything that the machine cannot make,
    and LimitError; nothing is left out that is not in the plan's outcomes.
    """
    refuse_stock(parts, machine)
    most, total = InForce.limits.features, 0
    for part in parts:
        total += len(part.features)
        if total > most:
            raise LimitError(FEATURES.at(part.source, found=total, expected=most))
    works, remarks = works_on(parts, machine, skips)
    laid = lay(works, machine, order, bar)
    remarks += laid.remarks
    pieces, source = laid.pieces, laid.pieces[0].part.source
    cuts, strokes = bar_operations(laid, machine)
    if not (cuts or strokes):
        raise PlanError(rules.NO_WORK.at(source, machine=machine.name))
    refusals = [*refuse_bar([*cuts, *strokes], pieces, machine)]
    if refusals:
        raise PlanError(refusals)
    ordered = sort_along_x(cuts, strokes, machine)
    manual_work, diagnostics = reloads(ordered, machine, source)
    if errors_in(diagnostics):
        raise PlanError(diagnostics)
    remarks += diagnostics
    remarks += cutting_remarks(pieces, strokes, machine)
    outcomes = tuple(_outcomes(laid.works, strokes))
    plan = Plan(
        pieces[0].part.profile, pieces, laid.bar, ordered, outcomes, tuple(remarks), manual_work
    )
    _balance(plan, machine)
    return plan


_feature = attrgetter("feature")


def _outcomes(works: Sequence[PartWork], operations: Sequence[WorkOp]) -> list[Outcome]:
    """The outcome of each feature, in the order of pieces and features."""
    made: dict[FeatureRef, Outcome] = {}
    for op in operations:
        how: Literal["made", "merged"] = "made"
        for ref in op.features:
            made[ref] = Outcome(ref, how, op.tool.kind)
            how = "merged"
    outcomes = list(made.values())
    for p, work in enumerate(works):
        outcomes += (Outcome((p, f), "skipped", d.code) for f, d in work.skipped.items())
        outcomes += (Outcome((p, each.feature), each.how, each.by) for each in work.settled)
    return sorted(outcomes, key=_feature)


def _balance(plan: Plan, machine: Machine) -> None:
    """Raise AssertionError unless every feature has exactly one outcome and the bar adds up.

    That would be a fault of the planner and not of the part, and no program may come of it.
    """
    counts = enumerate(len(piece.part.features) for piece in plan.pieces)
    read = chain.from_iterable(zip(repeat(p), range(count)) for p, count in counts)
    if [*map(_feature, plan.outcomes)] != [*read]:
        raise AssertionError("the ledger of the plan does not balance")
    if abs(plan.bar.total - plan.bar.length) > LEDGER_TOLERANCE:
        raise AssertionError("the account of the bar does not balance")
    if machine.saw is None:
        return
    sawn = {p for op in plan.operations if type(op) is SawOp for p in op.pieces}
    if sawn != set(range(len(plan.pieces))):
        raise AssertionError("a piece has no cut")


def plan_oriented(
    parts: Sequence[Part], machine: Machine, bar: float | None = None, skips: Collection[str] = (),
    order: Order = "given", turn: bool = False,
) -> Plan:  # fmt: skip
    """The plan of `plan_bar`; with `turn`, of the parts in the orientations that are best.

    Raises PlanError as `plan_bar` does; without `turn`, with the turn that would help.
    """
    if not turn:
        try:
            return plan_bar(parts, machine, bar, skips, order)
        except PlanError as error:
            if is_too_short(error.diagnostics):
                raise
            helping = turns_that_help(parts, machine, skips)
            raise PlanError([*error.diagnostics, *helping]) from error
    trials = {id(part): tuple(try_turns(part, machine, skips)) for part in parts}
    # A bar lies one way for all of them: if the best turns would set it on its web for one part and
    # on its flange for another, all lie as given or all are set on the other side.
    for allowed in ((False, True), (False,), (True,)):
        best = {id(p): _choose(p, [t for t in trials[id(p)] if t.turn.swap in allowed])
                for p in parts}  # fmt: skip
        choices = [c for p in parts if (c := best[id(p)]) is not None]
        if len(choices) == len(parts) and len({c.part.profile for c in choices}) == 1:
            break
    else:
        choices = [Orientation(part, AS_GIVEN, ()) for part in parts]
    plan = plan_bar([c.part for c in choices], machine, bar, skips, order)
    pieces = tuple(replace(piece, turn=choices[piece.given].turn) for piece in plan.pieces)
    remarks = dict.fromkeys(diagnostic for c in choices for diagnostic in c.remarks)
    return replace(plan, pieces=pieces, remarks=(*remarks, *plan.remarks))


# --- turn choice ----------------------------------------------------------------------------------

# The turn of a part on the rollers, where the planner may choose.
#
# Each of the eight turns of a part is tried by planning it alone. One is out if the section does
# not lie so on the rollers or if the machine cannot make something of the part that way; of the
# others the one is taken that needs the least time, and as given if that is as good.


BAR_BEHIND = 10_000.0  #: mm of bar behind a part that is tried
MOST_TRIED = 500  #: features of a part of which other ways are looked for unasked
MIN_GAIN_S = 1.0  #: a turn that gains less is not worth the lifting
SKIP_WEIGHT_S = 1e6  #: for each feature left out: it is better made in another orientation


class Trial(Struct, frozen=True):
    """One of a part's eight orientations, and its result."""

    turn: Turn
    part: Part
    seconds: float | None  #: of its work alone; None if it is out
    because: str  #: why it is out, or ""
    code: str = ""  #: of the message that refuses it


class Orientation(Struct, frozen=True):
    """The chosen orientation of a part."""

    part: Part
    turn: str
    remarks: tuple[Diagnostic, ...]


def turns_that_help(
    parts: Sequence[Part], machine: Machine, skips: Collection[str]
) -> Iterator[Diagnostic]:
    """For each part that cannot be made as given, the turn that would help, if one does.

    Parts of more than `MOST_TRIED` features are not tried, as no turn was asked for.
    """
    for part in {id(p): p for p in parts}.values():
        if len(part.features) > MOST_TRIED:
            continue
        trials = try_turns(part, machine, skips)
        if next(trials).seconds is None:
            helping = next((t for t in trials if t.seconds is not None), None)
            if helping is not None:
                yield rules.TURN_HELPS.at(part.source, found=helping.turn.name)


def try_turns(part: Part, machine: Machine, skips: Collection[str]) -> Iterator[Trial]:
    """All eight orientations of a part, in the order of `TURNS`: as it is given first."""
    made: list[Trial] = []
    for turn in TURNS:
        trial = _tried(part, turn, made, machine, skips)
        if trial.seconds is not None:
            made.append(trial)
        yield trial


def _tried(
    part: Part, turn: Turn, made: Sequence[Trial], machine: Machine, skips: Collection[str]
) -> Trial:
    """A part in one orientation; of those that were `made` before it one may be no different."""
    if not lies(part.profile, turn):
        return Trial(turn, part, None, f"a {part.profile.code} does not lie so on the rollers")
    lying = turned(part, turn)
    same = next((t for t in made if alike(t.part, lying)), None)
    if same is not None:
        return Trial(turn, lying, None, f"no different from {same.turn.name!r}")
    bar = part.length + BAR_BEHIND  # more behind the part, as behind all but the last of a bar
    if machine.layout is not None and machine.layout.max_bar is not None:
        bar = min(bar, machine.layout.max_bar)
    try:
        plan = plan_bar([lying], machine, bar, skips)
    except PlanError as error:
        first = errors_in(error.diagnostics)[0]
        return Trial(turn, lying, None, f"{first.code}: {first.message}", first.code)
    skipped = sum(outcome.how == "skipped" for outcome in plan.outcomes)
    return Trial(turn, lying, work_time(plan, machine).total_s + SKIP_WEIGHT_S * skipped, "")


def _choose(part: Part, trials: Sequence[Trial]) -> Orientation | None:
    """The best of some orientations; None if the part can be made in none of them."""
    made = [t for t in trials if t.seconds is not None]
    if not made:
        return None
    best = min(made, key=lambda t: (round((t.seconds or 0.0) / MIN_GAIN_S), TURNS.index(t.turn)))
    given = trials[0]
    if given.turn is not TURNS[0]:
        reason = "as the other parts on the bar have to lie"
    elif given.seconds is None:
        reason = f"as given it cannot be made ({given.code or given.because})"
    else:
        gain = given.seconds - (best.seconds or 0.0)
        if best is given or gain < MIN_GAIN_S:
            return Orientation(part, AS_GIVEN, ())
        reason = f"{gain:.1f} s less than as given"
        if gain >= SKIP_WEIGHT_S / 2:
            reason = "so nothing has to be left out"
    diagnostic = rules.TURNED.at(part.source, found=best.turn.name, reason=reason)
    return Orientation(best.part, best.turn.name, (diagnostic,))
