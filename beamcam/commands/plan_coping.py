"""Output of `beamcam plan` for a part that is coped: each cut with its time, as text or as data."""

from collections.abc import Iterator
from itertools import pairwise
from math import dist

from beamcam.commands.plan_sheet import not_made_lines
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.model.plan import CopeCut, CopePlan, WorkTime
from beamcam.motion.coping import NAMES
from beamcam.report.run import as_message


def path_of(cut: CopeCut) -> float:
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
            f"{path_of(cut):9.1f} mm through {cut.thickness:.1f} mm{root} at "
            f"{cut.row.feed_mm_min:g} mm/min {seconds:7.1f} s  {cut.source}"
        )
    yield from not_made_lines(plan)
    yield (
        f"{len(plan.operations)} cuts, {sum(map(path_of, plan.operations)):.1f} mm, "
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
                "face": cut.face,
                "kind": cut.kind,
                "start": list(cut.path[0]),
                "path": round(path_of(cut), 6),
                "thickness": round(cut.thickness, 6),
                "root": cut.root,
                "tilt_deg": round(cut.b_deg, 6),
                "feed_mm_min": cut.row.feed_mm_min,
                "seconds": round(seconds, 3),
                "source": str(cut.source),
            }
            for cut, seconds in zip(plan.operations, time.operations, strict=True)
        ],
        "features": [
            {"part": o.feature[0], "feature": o.feature[1], "how": o.how, "by": o.by}
            for o in plan.outcomes
        ],
        "time": {"home_s": round(time.home_s, 3), "total_s": round(time.total_s, 3)},
        "messages": [as_message(d) for d in said],
    }
