"""What a command says of a program that it wrote: one line, as a colleague would."""

from collections import Counter
from collections.abc import Iterator
from pathlib import PurePath

from beamcam.commands.common import STANDARD
from beamcam.model.part import Contour, Feature, Hole, Slot, TextMark
from beamcam.model.plan import Plan, SawOp, SheetPlan, clock
from beamcam.pipeline import Posted
from beamcam.planning.left_out import by_hand_sources, left_out_sources

#: What a pass of a torch or laser makes, by its process.
_OF_PROCESS = {"cut": "contour", "mark": "marked line", "engrave": "engraved line"}


def success(name: str, posted: Posted, first: int | None = None) -> str:
    """`channel.gcode: 14 holes, 2 cuts, 1 bar of 12000, 33:56 min; read back: the part, exactly`.

    `name` is the program's file. `first` is the operation that a remainder begins with.
    """
    plan, job = posted.plan, posted.job
    count = len(plan.operations)
    made = [*_bar(plan, job.machine.saw is None)] if isinstance(plan, Plan) else [*_sheet(plan)]
    made.append(clock(posted.time(job.machine).total_s))
    if first is not None:
        made = [f"operations {first} to {count} of {count}"]
    shown = "the program" if name == STANDARD else PurePath(name).name
    return f"{shown}: {', '.join(made)}; {_read_back(posted)}"


def _bar(plan: Plan, comes_cut: bool) -> Iterator[str]:
    """What is made of a bar, and the bar; a part that `comes_cut` is one by itself."""
    kinds = Counter[str]()
    for outcome in plan.outcomes:
        if outcome.how in ("made", "merged"):
            piece, index = outcome.feature
            kinds[_kind(plan.pieces[piece].part.features[index])] += 1
    kinds["cut"] = sum(isinstance(op, SawOp) for op in plan.operations)
    for kind in ("hole", "slot", "line", "text", "cut"):
        if kinds[kind]:
            yield _counted(kinds[kind], kind)
    yield f"1 {'part' if comes_cut else 'bar'} of {round(plan.bar.length, 3):g}"


def _kind(feature: Feature) -> str:
    match feature:
        case Hole():
            return "hole"
        case Slot():
            return "slot"
        case TextMark():
            return "text"
        case Contour(process="mark" | "engrave"):
            return "line"
    return "end"  # a contour or plane that the cuts make


def _sheet(plan: SheetPlan) -> Iterator[str]:
    kinds = Counter(_OF_PROCESS[op.row.process] for op in plan.operations)
    for kind in _OF_PROCESS.values():
        if kinds[kind]:
            yield _counted(kinds[kind], kind)
    yield f"1 sheet of {plan.thickness:g} mm"


def _read_back(posted: Posted) -> str:
    """What the read-back found of a program that is not refused."""
    plan = posted.plan
    if not posted.job.request.verified:
        return "NOT read back"
    pieces = len(plan.pieces)
    parts = "the part" if pieces == 1 else f"the {pieces} parts"
    left_out = sum(1 for _ in left_out_sources(plan))
    by_hand = sum(1 for _ in by_hand_sources(plan))
    exactly = f"read back: {parts}, exactly"
    lacking = [f"{_counted(left_out, 'feature')} left out"] if left_out else []
    if by_hand:
        lacking.append(f"{_counted(by_hand, 'mark')} left to the hand")
    return f"read back: {parts} but for {' and '.join(lacking)}" if lacking else exactly


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"
