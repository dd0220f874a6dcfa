"""Parts laid on a bar, and the cuts between them.

    bar x 0                                                                        bar's length
    | front trim |# part 1 ######/|kerf|# part 2 ####|kerf|   rest, dead zone   | end trim |
                 start           end  start

A part's square start is made by the cut that parts it from what lies before it; a skew start or
end gets a mitre of its own, and the square parting cut at the part's greatest x removes the wedge.
Two parts that share an angle need neither wedge nor parting cut: one common cut makes both ends,
and the parts overlap along the bar.

    # part 1 ######/|kerf|    # part 2          # part 1 ######/ /# part 2
    # part 1 #####/ |kerf|  /## part 2          # part 1 #####/ /## part 2
    # part 1 ####/  |kerf| /### part 2          # part 1 ####/ /### part 2
         mitre, parting, mitre                       one common cut

Cuts that stand close are in an order that a machine can follow along X: the mitre that ends a
part, the parting cut behind it, the mitre that starts the next. So a parting cut never stands
before the middle of the mitre that it follows.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import atan, cos, degrees, radians, tan

from beamcam.errors import Diagnostic, PlanError, Source
from beamcam.machine.machine import Layout, Saw
from beamcam.model.part import Part, Profile
from beamcam.model.plan import Bar, Piece, SawOp
from beamcam.planning import rules
from beamcam.planning.ends import End
from beamcam.planning.operations.rules import BAR_LEFT

Ends = tuple[End, End]
NOTHING_LEFT = 1e-6  #: mm
SAME_ANGLE_DEG = 0.01  #: ends that differ by no more share a cut


def lay_on_bar(
    parts: Sequence[Part], ends: Sequence[Ends], layout: Layout, saw: Saw, length: float | None
) -> tuple[tuple[tuple[float, ...], Bar], tuple[Diagnostic, ...]]:
    """Starts of the parts in the order given and the bar's account; and remarks about the rest.

    `length` is the stock bar's; None takes as much as the parts need. Raises PlanError if the
    parts do not fit, or if the bar or a part is shorter or longer than the machine can hold.
    """
    refusals = [
        rules.PART_SHORT.at(p.source, found=f"{p.length:.3f}", expected=f"{layout.min_part:g}")
        for p in parts
        if p.length < layout.min_part
    ]
    if refusals:
        raise PlanError(refusals)
    starts, parts_length, kerfs, nested = [layout.front_trim], parts[0].length, 0.0, 0.0
    for index, (part, after) in enumerate(pairwise(parts)):
        here, there = ends[index][1], ends[index + 1][0]
        kerf = max(kerf_along_bar(saw, here), kerf_along_bar(saw, there))
        start = starts[-1] + part.length + kerf
        if share_cut(here, there, saw):
            nested_start = starts[-1] + here.x0 + kerf - there.x0
            nested += start - nested_start
            start = nested_start
        kerfs += kerf
        starts.append(start)
        parts_length += after.length
    kerfs += kerf_along_bar(saw, ends[-1][1])
    used = layout.front_trim + parts_length + kerfs - nested + layout.end_trim
    source = parts[0].source
    needed = used + layout.dead_zone
    if length is not None and needed > length + 1e-6:
        raise PlanError(rules.BAR_FULL.at(source, found=f"{needed:.3f}", expected=f"{length:.3f}"))
    whole = needed if length is None else length
    if whole < layout.min_bar:
        raise PlanError(
            rules.BAR_SHORT.at(source, found=f"{whole:.3f}", expected=f"{layout.min_bar:g}")
        )
    held = starts[-1] + layout.min_bar_left
    if length is None:
        whole = max(whole, held)
    elif held > length + 1e-6:
        expected = f"{layout.min_bar_left:g}"
        raise PlanError(BAR_LEFT.at(source, found=f"{length - starts[-1]:.3f}", expected=expected))
    if layout.max_bar is not None and whole > layout.max_bar:
        raise PlanError(
            rules.BAR_LONG.at(source, found=f"{whole:.3f}", expected=f"{layout.max_bar:g}")
        )
    rest = max(0.0, whole - used)
    bar = Bar(whole, layout.front_trim, parts_length, kerfs, rest, nested, layout.end_trim)
    remarks: tuple[Diagnostic, ...] = ()
    if length is not None and rest >= layout.min_remnant:
        remarks = (rules.REMNANT.at(source, found=f"{rest:.3f}"),)
    return (tuple(starts), bar), remarks


def kerf_along_bar(saw: Saw, end: End) -> float:
    """Length of bar that a cut takes, as the machine counts its kerf."""
    return saw.kerf * end.slant if saw.kerf_along == "normal" else saw.kerf


def share_cut(end: End, start: End, saw: Saw) -> bool:
    """Whether one skew cut can end a part and start the next."""
    return (
        saw.common_cuts
        and not end.is_square
        and abs(end.web_deg - start.web_deg) <= SAME_ANGLE_DEG
        and abs(end.flange_deg - start.flange_deg) <= SAME_ANGLE_DEG
    )


def cuts_of(
    pieces: Sequence[Piece], ends: Sequence[Ends], saw: Saw, bar: Bar | None = None
) -> Iterator[SawOp]:
    """The cuts that give every piece its ends, the blade always on the waste side.

    Behind a skew end at the end of `bar` nothing is left to be squared.
    """
    for index, (piece, (start, end)) in enumerate(zip(pieces, ends, strict=True)):
        source = piece.part.source
        shares_start = index > 0 and share_cut(ends[index - 1][1], start, saw)
        if index == 0 and start.is_square:
            x = saw.x + piece.start - saw.kerf / 2
            yield SawOp(x, saw.square, "trim", (0,), source, 0.0, "start", ("cut-trim",))
        elif not start.is_square and not shares_start:
            yield _skew(piece, (index,), start, saw, "mitre")
        following = ends[index + 1][0] if index + 1 < len(pieces) else None
        if following is not None and share_cut(end, following, saw):
            yield _skew(piece, (index, index + 1), end, saw, "common")
            continue
        if not end.is_square:
            yield _skew(piece, (index,), end, saw, "mitre")
        if following is not None and following.is_square:
            # It makes the next part's square start too, which lies further on behind a mitre.
            x = saw.x + pieces[index + 1].start - saw.kerf / 2
            both = (index, index + 1)
            yield SawOp(x, saw.square, "parting", both, source, 0.0, "end", ("cut-parting-both",))
        elif end.is_square or following is not None or bar is None or bar.left > NOTHING_LEFT:
            x = saw.x + piece.end + kerf_along_bar(saw, end) / 2
            reason = "cut-parting" if end.is_square else "cut-wedge"
            yield SawOp(x, saw.square, "parting", (index,), source, 0.0, "end", (reason,))


def _skew(piece: Piece, pieces: tuple[int, ...], end: End, saw: Saw, purpose: str) -> SawOp:
    """The cut of a skew end, half a kerf on the waste side of it."""
    profile = piece.part.profile
    edge = end.x(*pivot_edge(saw, profile))
    side = -0.5 if end.at == "start" else 0.5
    x = saw.x + piece.start + edge + side * kerf_along_bar(saw, end)
    angle, tilt = saw_angles(end, saw)
    if purpose == "common":
        reasons = ("cut-common",)
        return SawOp(x, angle, "common", pieces, piece.part.source, tilt, end.at, reasons)
    reasons = ("cut-mitre-start" if end.at == "start" else "cut-mitre-end",)
    return SawOp(x, angle, "mitre", pieces, piece.part.source, tilt, end.at, reasons)


def pivot_edge(saw: Saw, profile: Profile) -> tuple[float, float]:
    """y and z of the line on which the machine counts a cut's X: on the side the bar lies on."""
    return (profile.height if saw.pivot == "o" else 0.0), 0.0


def saw_angles(end: End, saw: Saw) -> tuple[float, float]:
    """Angle and tilt of the blade for an end, in the machine's counting.

    The blade turned by w and tilted by t has the normal (cos t cos w, cos t sin w, sin t), which
    is along (1, tan w, tan f) of the end if tan t = tan f cos w.
    """
    angle = saw.square + saw.angle_sign * end.web_deg
    if not end.flange_deg:
        return angle, 0.0
    tilt = degrees(atan(tan(radians(end.flange_deg)) * cos(radians(end.web_deg))))
    return angle, saw.tilt_sign * tilt


def refuse_cut(end: End, saw: Saw, source: Source) -> Diagnostic | None:
    """Why the saw cannot make an end; None if it can."""
    if end.is_square:
        return None
    angle, tilt = saw_angles(end, saw)
    if end.web_deg and not saw.min_angle <= angle <= saw.max_angle:
        return rules.SAW_ANGLE.at(
            source, found=f"{angle:g}", end=end.at, least=f"{saw.min_angle:g}",
            greatest=f"{saw.max_angle:g}",
        )  # fmt: skip
    if end.flange_deg and not saw.min_tilt <= tilt <= saw.max_tilt:
        expected = "0, the blade does not tilt"
        if saw.min_tilt != saw.max_tilt:
            expected = f"a tilt from {saw.min_tilt:g} to {saw.max_tilt:g}"
        return rules.FLANGE_CUT.at(
            source, found=f"{end.flange_deg:g}", end=end.at, expected=expected
        )
    if end.web_deg and end.flange_deg and not saw.compound:
        return rules.COMPOUND.at(
            source, web=f"{end.web_deg:g}", flange=f"{end.flange_deg:g}", end=end.at
        )
    return None
