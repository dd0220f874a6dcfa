"""Output of `beamcam plan` for a sheet: each contour with its time, as text or as data."""

from collections.abc import Iterator

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.model.lengths import total_length
from beamcam.model.plan import NOT_MADE, AnyPlan, ContourOp, SheetPlan, WorkTime
from beamcam.report.run import as_message


def path_of(op: ContourOp) -> float:
    """Length that the tool follows, leads included, in mm."""
    passes = ((*one.lead_in, *one.curves, *one.lead_out) for one in op.passes)
    return sum(total_length(curves) for curves in passes)


def not_made_lines(plan: AnyPlan) -> Iterator[str]:
    """The features that no operation makes, each with the reason."""
    for outcome in plan.outcomes:
        if outcome.how in NOT_MADE:
            piece, feature = outcome.feature
            source = plan.pieces[piece].part.features[feature].source
            yield f"{NOT_MADE[outcome.how]}: {source} ({outcome.by})"


def sheet_lines(plan: SheetPlan, time: WorkTime, machine: Machine) -> Iterator[str]:
    """The plan of a sheet as text."""
    yield f"machine {machine.name}: {machine.title}"
    for piece in plan.pieces:
        part, (x, y) = piece.part, piece.place
        yield (
            f"sheet {part.mark} {part.length:.3f} x {part.profile.height:.3f} x "
            f"{plan.thickness:g}, its x 0, y 0 at X {x:.3f} Y {y:.3f}"
        )
    for number, (op, seconds) in enumerate(zip(plan.operations, time.operations, strict=True), 1):
        x, y = op.start
        bridges = f", {len(op.passes)} passes" if len(op.passes) > 1 else ""
        yield (
            f"{number:4} X {x:10.3f} Y {y:10.3f}  {op.row.process:7}{path_of(op):10.1f} mm at "
            f"{op.row.feed_mm_min * op.feed_share:g} mm/min{bridges} {seconds:7.1f} s  {op.source}"
        )
    yield from not_made_lines(plan)
    yield (
        f"{len(plan.operations)} contours, {sum(map(path_of, plan.operations)):.1f} mm, home "
        f"{time.home_s:.1f} s, {time.total_s:.0f} s"
    )


def sheet_record(
    plan: SheetPlan, time: WorkTime, machine: Machine, said: tuple[Diagnostic, ...]
) -> dict[str, object]:
    """The plan of a sheet as data."""
    sheets = [
        {
            "mark": piece.part.mark,
            "length": piece.part.length,
            "width": piece.part.profile.height,
            "thickness": plan.thickness,
            "shift": list(piece.place),
        }
        for piece in plan.pieces
    ]
    return {
        "machine": machine.name,
        "sheet": sheets[0],
        "others": sheets[1:],  # that share the sheet
        "operations": [
            {
                "process": op.row.process,
                "start": list(op.start),
                "path": round(path_of(op), 6),
                "feed_mm_min": op.row.feed_mm_min,
                "passes": len(op.passes),
                "seconds": round(seconds, 3),
                "source": str(op.source),
            }
            for op, seconds in zip(plan.operations, time.operations, strict=True)
        ],
        "features": [
            {"part": o.feature[0], "feature": o.feature[1], "how": o.how, "by": o.by}
            for o in plan.outcomes
        ],
        "time": {"home_s": round(time.home_s, 3), "total_s": round(time.total_s, 3)},
        "messages": [as_message(d) for d in said],
    }
