"""Output of `beamcam plan` for sheets and coped parts: each cut with its time, as text or data."""

from collections.abc import Iterator
from itertools import pairwise
from math import dist

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.model.lengths import total_length
from beamcam.model.plan import NOT_MADE, AnyPlan, ContourOp, CopeCut, CopePlan, SheetPlan, WorkTime
from beamcam.motion.coping import NAMES
from beamcam.reports.run import as_message


def length_of(op: ContourOp) -> float:
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
            f"{number:4} X {x:10.3f} Y {y:10.3f}  {op.row.process:7}{length_of(op):10.1f} mm at "
            f"{op.row.feed_mm_min * op.feed_share:g} mm/min{bridges} {seconds:7.1f} s  {op.source}"
        )
    yield from not_made_lines(plan)
    yield (
        f"{len(plan.operations)} contours, {sum(map(length_of, plan.operations)):.1f} mm, home "
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
                "process": op.row.process, "start": list(op.start),
                "path": round(length_of(op), 6), "feed_mm_min": op.row.feed_mm_min,
                "passes": len(op.passes), "seconds": round(seconds, 3), "source": str(op.source),
            }
            for op, seconds in zip(plan.operations, time.operations, strict=True)
        ],
        **_whole(plan, time, said),
    }  # fmt: skip


def cut_length(cut: CopeCut) -> float:
    """Length that the torch follows, its lead included, in mm."""
    return sum(dist(a, b) for a, b in pairwise(cut.path))


def coping_lines(plan: CopePlan, time: WorkTime, machine: Machine) -> Iterator[str]:
    """The plan of a coped part as text."""
    (piece,) = plan.pieces
    yield f"machine {machine.name}: {machine.title}"
    comes = f"from a bar of {plan.bar:.3f} mm at least"
    if piece.part.made is not None:
        comes = "cut to length by another machine"
    yield (
        f"part {piece.part.mark} of {plan.profile.name}, {piece.part.length:.3f} mm, {comes}, "
        f"its x 0 at X {piece.start:.3f}"
    )
    for number, (cut, seconds) in enumerate(zip(plan.operations, time.operations, strict=True), 1):
        x, y = cut.path[0]
        root = (", root" if cut.root else "") + (f", B {cut.b_deg:.3f}" if cut.b_deg else "")
        yield (
            f"{number:4} face {cut.face}  {NAMES[cut.kind]:8} x {x:10.3f} y {y:8.3f} "
            f"{cut_length(cut):9.1f} mm through {cut.thickness:.1f} mm{root} at "
            f"{cut.row.feed_mm_min:g} mm/min {seconds:7.1f} s  {cut.source}"
        )
    yield from not_made_lines(plan)
    yield (
        f"{len(plan.operations)} cuts, {sum(map(cut_length, plan.operations)):.1f} mm, "
        f"{time.total_s:.0f} s"
    )


def coping_record(
    plan: CopePlan, time: WorkTime, machine: Machine, said: tuple[Diagnostic, ...]
) -> dict[str, object]:
    """The plan of a coped part as data."""
    (piece,) = plan.pieces
    return {
        "machine": machine.name,
        "bar": {"length": plan.bar, "start": piece.start},
        "part": piece.part.mark,
        "operations": [
            {
                "face": cut.face, "kind": cut.kind, "start": list(cut.path[0]),
                "path": round(cut_length(cut), 6), "thickness": round(cut.thickness, 6),
                "root": cut.root, "tilt_deg": round(cut.b_deg, 6),
                "feed_mm_min": cut.row.feed_mm_min, "seconds": round(seconds, 3),
                "source": str(cut.source),
            }
            for cut, seconds in zip(plan.operations, time.operations, strict=True)
        ],
        **_whole(plan, time, said),
    }  # fmt: skip


def _whole(plan: AnyPlan, time: WorkTime, said: tuple[Diagnostic, ...]) -> dict[str, object]:
    """What the data of both kinds of plan end with."""
    return {
        "features": [
            {"part": o.feature[0], "feature": o.feature[1], "how": o.how, "by": o.by}
            for o in plan.outcomes
        ],
        "time": {"home_s": round(time.home_s, 3), "total_s": round(time.total_s, 3)},
        "messages": [as_message(d) for d in said],
    }
