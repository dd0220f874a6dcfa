"""Parts laid on a bar, and the cuts between them.

    bar x 0                                                               bar's length
    | front trim |# part 1 ######/|kerf|# part 2 ####|kerf|      rest           |
                 start           end  start

A part's square start is made by the cut that parts it from what lies before it; a skew start or
end gets a mitre of its own, and the square parting cut at the part's greatest x removes the wedge.
"""

from collections.abc import Iterator, Sequence
from math import cos, radians

from beamcam.errors import Diagnostic, PlanError, Source
from beamcam.machine.machine import Layout, Saw
from beamcam.model.part import Part
from beamcam.model.plan import Bar, Piece, SawOp
from beamcam.planning import rules
from beamcam.planning.ends import End


def lay_on_bar(
    parts: Sequence[Part],
    ends: Sequence[tuple[End, End]],
    layout: Layout,
    saw: Saw,
    length: float | None,
) -> tuple[tuple[Piece, ...], Bar]:
    """The parts in the order given, one kerf apart, and the bar's account.

    `length` is the stock bar's; None takes as much as the parts need. Raises PlanError if the
    parts do not fit, or if the bar is shorter or longer than the machine can hold.
    """
    pieces = []
    x = layout.front_trim
    kerfs = 0.0
    for index, part in enumerate(parts):
        pieces.append(Piece(part, x))
        angles = [ends[index][1].web_deg]
        if index + 1 < len(parts):
            angles.append(ends[index + 1][0].web_deg)
        gap = max(kerf_along_bar(saw, angle) for angle in (*angles, 0.0))
        kerfs += gap
        x += part.length + gap
    source = parts[0].source
    used = layout.front_trim + sum(p.length for p in parts) + kerfs
    if length is not None and used > length + 1e-6:
        raise PlanError(rules.BAR_FULL.at(source, found=f"{used:.3f}", expected=f"{length:.3f}"))
    whole = used if length is None else length
    if whole < layout.least_bar:
        raise PlanError(
            rules.BAR_SHORT.at(source, found=f"{whole:.3f}", expected=f"{layout.least_bar:g}")
        )
    if layout.greatest_bar is not None and whole > layout.greatest_bar:
        raise PlanError(
            rules.BAR_LONG.at(source, found=f"{whole:.3f}", expected=f"{layout.greatest_bar:g}")
        )
    parts_length = sum(p.length for p in parts)
    bar = Bar(whole, layout.front_trim, parts_length, kerfs, max(0.0, whole - used))
    return tuple(pieces), bar


def kerf_along_bar(saw: Saw, web_deg: float) -> float:
    """Length of bar that a cut takes, as the machine counts its kerf."""
    return saw.kerf / cos(radians(web_deg)) if saw.kerf_along == "normal" else saw.kerf


def cuts_of(pieces: Sequence[Piece], ends: Sequence[tuple[End, End]], saw: Saw) -> Iterator[SawOp]:
    """The cuts that give every piece its ends, the blade always on the waste side."""
    for index, (piece, (start, end)) in enumerate(zip(pieces, ends, strict=True)):
        source = piece.part.source
        if start.web_deg:
            yield _mitre(piece, index, start, -0.5, saw)
        elif index == 0:
            x = saw.x + piece.start - saw.kerf / 2
            yield SawOp(x, saw.square, "trim", (index,), source)
        if end.web_deg:
            yield _mitre(piece, index, end, 0.5, saw)
        if index + 1 < len(pieces) and not ends[index + 1][0].web_deg:
            # It makes the next part's square start too, which lies further on behind a mitre.
            x = saw.x + pieces[index + 1].start - saw.kerf / 2
            yield SawOp(x, saw.square, "parting", (index, index + 1), source)
        else:
            x = saw.x + piece.end + saw.kerf / 2
            yield SawOp(x, saw.square, "parting", (index,), source)


def _mitre(piece: Piece, index: int, end: End, side: float, saw: Saw) -> SawOp:
    pivot_y = piece.part.profile.height if saw.pivot == "o" else 0.0
    x = saw.x + piece.start + end.x(pivot_y) + side * kerf_along_bar(saw, end.web_deg)
    angle = saw.square + saw.angle_sign * end.web_deg
    return SawOp(x, angle, "mitre", (index,), piece.part.source)


def refuse_cut(end: End, saw: Saw, source: Source) -> Diagnostic | None:
    """Why the saw cannot make an end; None if it can."""
    angle = saw.square + saw.angle_sign * end.web_deg
    if end.web_deg and not saw.least_angle <= angle <= saw.greatest_angle:
        return rules.SAW_ANGLE.at(
            source, found=f"{angle:g}", end=end.at, least=f"{saw.least_angle:g}",
            greatest=f"{saw.greatest_angle:g}",
        )  # fmt: skip
    return None
