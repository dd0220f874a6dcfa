"""The cuts that give parts their ends, the blade always on the waste side.

Whether a saw makes the ends of a part is said of the part alone; the cuts themselves follow when
it lies on a bar, since parts that share an angle share a cut (see `planning.nesting`).

Features that no line makes: bends, planes in space, cambers.

The saw makes the end plane that the angles and the length of the part give: it is one of its cuts.
"""

from collections.abc import Iterator, Sequence
from math import atan, cos, degrees, radians, tan
from typing import Literal

from msgspec.structs import replace

from beamcam.errors import Diagnostic, error, note
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Saw, SawSection
from beamcam.model.part import Bend, Camber, Contour, EndPlane, Face, Part, Profile
from beamcam.model.plan import Bar, Piece, SawOp
from beamcam.model.section import corners
from beamcam.planning import rules
from beamcam.planning.operations.finished_part import Ends, SawnEnd, leaves_stock
from beamcam.planning.operations.part_planner import Numbered, PartPlanner, WorkKind, nothing
from beamcam.planning.operations.tools import Found, Settled
from beamcam.planning.rules import BEVEL, BEVEL_NOISE

SAW_ANGLE = error("plan-saw-angle",
    "found a cut of {found} degrees at the {end}; expected one from {least} to {greatest}, as far "
    "as the saw turns",
    "The mitre is outside the saw's range. Angles are given as in the input.")  # fmt: skip
FLANGE_CUT = error("plan-flange-cut",
    "found a flange cut of {found} degrees at the {end}; expected {expected}",
    "The blade does not tilt, or it tilts one way only; a part that is turned may need that "
    "way.")  # fmt: skip
COMPOUND = error("plan-compound",
    "found a cut of {web} degrees on the web and {flange} on the flange at the {end}; expected one "
    "of them, the saw cannot turn and tilt at once",
    "A compound mitre needs a saw whose blade tilts while the saw is turned.")  # fmt: skip
CUTS_CROSS = error("plan-cuts-cross",
    "found end cuts that cross by {found} mm at y {y}, z {z}; expected the part to be longer than "
    "both mitres there",
    "Nothing is left of the part where its two end cuts meet.")  # fmt: skip
CUTS_TOUCH = note("plan-cuts-touch",
    "the end cuts meet in a point at y {y}, z {z}",
    "The part is as long as its two mitres, and ends there in an edge.")  # fmt: skip
SAW_REACH = error("plan-saw-reach",
    "found a section of {found} mm at a cut of {angle} degrees at the {end}; expected at most "
    "{expected} mm (height x width), as the blade reaches at that angle",
    "A blade that is turned reaches less far across. `saw.max_sections` of the machine file says "
    "how far at which angle.")  # fmt: skip
REASONS = {
    "cut-trim": "the bar's front is sawn square, since no cut comes before it",
    "cut-mitre-start": "the part starts skew",
    "cut-mitre-end": "the part ends skew",
    "cut-common": "two parts share the angle, so one cut ends the one and starts the other",
    "cut-parting": "parts the piece from the bar, behind its square end",
    "cut-parting-both": "parts the piece from the bar and gives the next one its square start",
    "cut-wedge": "takes the wedge of the mitre off the bar",
}
TOUCH = 0.01  #: mm; ends that are as near meet in a point
NOTHING_LEFT = 1e-6  #: mm


def _needs(end: SawnEnd, planner: PartPlanner) -> Diagnostic | None:
    """Why the saw cannot make one end; None if it can."""
    if end.is_square:
        return None
    return _refuse_cut(end, _turning_saw(planner.line.saw, planner.machine), planner.part)


def _refuse_cut(end: SawnEnd, saw: Saw, part: Part) -> Diagnostic | None:
    """Why the saw cannot make a skew end; None if it can."""
    angle, tilt = saw_angles(end, saw)
    if end.web_deg and not saw.min_angle <= angle <= saw.max_angle:
        least, greatest = sorted(
            (limit - saw.zero_angle) * saw.angle_sign for limit in (saw.min_angle, saw.max_angle)
        )
        return SAW_ANGLE.at(
            part.cut_source("web", end.at), found=f"{end.web_deg:g}", end=end.at,
            least=f"{least:g}", greatest=f"{greatest:g}",
        )  # fmt: skip
    if end.flange_deg and not saw.min_tilt <= tilt <= saw.max_tilt:
        expected = "0, the blade does not tilt"
        if saw.min_tilt != saw.max_tilt:
            least, greatest = sorted(saw.tilt_sign * t for t in (saw.min_tilt, saw.max_tilt))
            expected = f"one from {least + 0.0:g} to {greatest + 0.0:g}"
        source = part.cut_source("flange", end.at)
        return FLANGE_CUT.at(source, found=f"{end.flange_deg:g}", end=end.at, expected=expected)
    if end.web_deg and end.flange_deg and not saw.compound:
        source = part.cut_source("flange", end.at)
        return COMPOUND.at(source, web=f"{end.web_deg:g}", flange=f"{end.flange_deg:g}", end=end.at)
    return None


def _turning_saw(saw: Saw, machine: Machine) -> Saw:
    """The saw with those of its angles that its axis turns to."""
    for axis in machine.axes:
        if axis.moves == "angle" and axis.spindle is None:
            least, greatest = axis.limits
            if least > saw.min_angle or greatest < saw.max_angle:
                least, greatest = max(least, saw.min_angle), min(greatest, saw.max_angle)
                return replace(saw, min_angle=least, max_angle=greatest)
    return saw


def _refusals(ends: Ends, planner: PartPlanner) -> Iterator[Diagnostic]:
    """Errors and remarks on the two ends of a part, together and one by one."""
    part, saw = planner.part, planner.line.saw
    start, end = ends
    at_end = part.cut_source("web" if end.web_deg else "flange", "end")
    if not (start.is_square and end.is_square):
        left, y, z = min(
            (end.x(y, z) - start.x(y, z), y, z) for y, z in corners(part.profile, part.section)
        )
        if left < -TOUCH:
            yield CUTS_CROSS.at(at_end, found=f"{-left:.3f}", y=f"{y:g}", z=f"{z:g}")
        elif left <= TOUCH:
            yield CUTS_TOUCH.at(at_end, y=f"{y:g}", z=f"{z:g}")
    if not saw.max_sections:
        return
    height, width = part.profile.height, part.profile.width
    for each in ends:
        angle = saw_angles(each, saw)[0]
        reach = _reach_at(abs(angle - saw.zero_angle), saw)
        if reach is None or (height <= reach.max_height and width <= reach.max_width):
            continue
        yield SAW_REACH.at(
            part.cut_source("web", each.at), found=f"{height:g} x {width:g}",
            angle=f"{each.web_deg:g}", end=each.at,
            expected=f"{reach.max_height:g} x {reach.max_width:g}",
        )  # fmt: skip


def _reach_at(off_square_deg: float, saw: Saw) -> SawSection | None:
    """The row of the machine for an angle; the last one beyond all of them."""
    rows = sorted(saw.max_sections, key=lambda row: row.max_angle)
    fitting = (row for row in rows if off_square_deg <= row.max_angle + 1e-9)
    return next(fitting, rows[-1] if rows else None)


def cuts_of(
    pieces: Sequence[Piece], ends: Sequence[Ends], shared: Sequence[bool], saw: Saw, bar: Bar
) -> Iterator[SawOp]:
    """The cuts that give every piece its ends, the blade always on the waste side.

    `shared` says of each piece but the last whether one cut ends it and starts the next. Behind a
    skew end at the end of the bar nothing is left to be squared.
    """
    common = (False, *shared, False)
    for index, (piece, (start, end)) in enumerate(zip(pieces, ends, strict=True)):
        source, shares_start, shares_end = piece.part.source, common[index], common[index + 1]
        if index == 0 and start.is_square:
            x = saw.x + piece.start - saw.kerf / 2
            yield SawOp(x, saw.zero_angle, "trim", (0,), source, 0.0, "start", ("cut-trim",))
        elif not start.is_square and not shares_start:
            yield _skew(piece, (index,), start, saw, "mitre")
        following = ends[index + 1][0] if index + 1 < len(pieces) else None
        if shares_end:
            yield _skew(piece, (index, index + 1), end, saw, "common")
            continue
        if not end.is_square:
            yield _skew(piece, (index,), end, saw, "mitre")
        if following is not None and following.is_square:
            # It makes the next part's square start too, which lies further on behind a mitre.
            x = saw.x + pieces[index + 1].start - saw.kerf / 2
            both = (index, index + 1)
            yield SawOp(
                x, saw.zero_angle, "parting", both, source, 0.0, "end", ("cut-parting-both",)
            )
        elif end.is_square or following is not None or bar.left > NOTHING_LEFT:
            x = saw.x + piece.end + end.kerf / 2
            reason = "cut-parting" if end.is_square else "cut-wedge"
            yield SawOp(x, saw.zero_angle, "parting", (index,), source, 0.0, "end", (reason,))


def _skew(
    piece: Piece,
    pieces: tuple[int, ...],
    end: SawnEnd,
    saw: Saw,
    purpose: Literal["mitre", "common"],
) -> SawOp:
    """The cut of a skew end, half a kerf on the waste side of it."""
    profile = piece.part.profile
    edge = end.x(*pivot_edge(saw, profile))
    side = -0.5 if end.at == "start" else 0.5
    x = saw.x + piece.start + edge + side * end.kerf
    angle, tilt = saw_angles(end, saw)
    reason = "cut-common" if purpose == "common" else f"cut-mitre-{end.at}"
    return SawOp(x, angle, purpose, pieces, piece.part.source, tilt, end.at, (reason,))


def pivot_edge(saw: Saw, profile: Profile) -> tuple[float, float]:
    """y and z of the line on which the machine counts a cut's X: on the side the bar lies on."""
    return (profile.height if saw.pivot == "o" else 0.0), 0.0


def saw_angles(end: SawnEnd, saw: Saw) -> tuple[float, float]:
    """Angle and tilt of the blade for an end, in the machine's counting.

    The blade turned by w and tilted by t has the normal (cos t cos w, cos t sin w, sin t), which
    is along (1, tan w, tan f) of the end if tan t = tan f cos w.
    """
    angle = saw.zero_angle + saw.angle_sign * end.web_deg
    if not end.flange_deg:
        return angle, 0.0
    tilt = degrees(atan(tan(radians(end.flange_deg)) * cos(radians(end.web_deg))))
    return angle, saw.tilt_sign * tilt


#: No feature of a part is a cut: its ends are, which `work` asks about.
SAW_CUT = WorkKind("saw cut", _needs, _refusals, nothing, REASONS)


COPE = error("plan-cope",
    "found a contour on face {face} that leaves the straight stock at x {x}, y {y}; expected "
    "straight edges and saw cuts",
    "A saw cannot make a cope or a notch. `--allow-skips cope` leaves it to another "
    "machine.")  # fmt: skip
CUTOUT = error("plan-cutout",
    "found a cut-out of {found} mm on face {face}; expected none, the machine has no torch",
    "A drill cannot make a cut-out. `--allow-skips cutout` leaves it to another "
    "machine.")  # fmt: skip
BEVEL_TOLERANCE_DEG = 0.2  #: between a bevel and the end cut that leaves it


def _cut_out(contour: Contour, _: PartPlanner) -> Diagnostic | None:
    """A torch, unless the contour is the outer one."""
    if contour.kind == "outer":
        return None
    boxes = [curve.bbox for curve in contour.curves]
    size = (
        f"{max(b[2] for b in boxes) - min(b[0] for b in boxes):g} x "
        f"{max(b[3] for b in boxes) - min(b[1] for b in boxes):g}"
    )
    return CUTOUT.at(contour.source, found=size, face=contour.face)


def _unsawn(contour: Contour, planner: PartPlanner) -> Iterator[Diagnostic]:
    """Parts of the contour that the saw cuts do not produce."""
    corner = leaves_stock(contour, planner.part, planner.ends)
    if corner is not None:
        x, y = corner
        yield COPE.at(contour.source, face=contour.face, x=f"{x:g}", y=f"{y:g}")
    least = planner.line.saw.min_mitre
    noise = [abs(bevel.angle) for bevel in contour.bevels if abs(bevel.angle) < least]
    if noise:
        yield BEVEL_NOISE.at(
            contour.source, count=len(noise), found=f"{max(noise):g}", expected=f"{least:g}"
        )
    for bevel in contour.bevels:
        if abs(bevel.angle) >= least and not _leaves_bevel(bevel.angle, contour.face, planner.ends):
            yield BEVEL.at(contour.source, found=f"{bevel.angle:g}", face=contour.face)


def _leaves_bevel(bevel_deg: float, face: Face, ends: Ends) -> bool:
    """Whether an end cut leaves this bevel: a web's mitre on the flanges, a flange's on the web."""
    on_web = face in ("v", "h")
    leaves = (end.flange_deg if on_web else end.web_deg for end in ends)
    return any(
        angle and abs(abs(bevel_deg) - abs(angle)) <= BEVEL_TOLERANCE_DEG for angle in leaves
    )


def _sawn(features: Sequence[Numbered], _: PartPlanner) -> Iterator[Found]:
    """None: the cuts at the ends make them all."""
    return (Settled(f, "made", "saw") for f, _ in features)


CONTOUR = WorkKind("contour", _cut_out, _unsawn, _sawn)


NAMES = {Bend: "a bend", EndPlane: "an end plane", Camber: "a camber"}
SAME_PLANE = 0.1  #: mm between a plane and the end that it states once more, at any corner


def _beyond_saw(feature: Bend | EndPlane | Camber, planner: PartPlanner) -> Diagnostic | None:
    """What no saw makes; a plane that is that of the part's start or end is made."""
    if isinstance(feature, EndPlane):
        end = planner.ends[feature.normal[0] > 0]
        places = corners(planner.part.profile, planner.part.section)
        if all(abs(feature.x(y, z) - end.x(y, z)) <= SAME_PLANE for y, z in places):
            return None
    return rules.OTHER.at(feature.source, found=NAMES[type(feature)])


OTHER = WorkKind("other", _beyond_saw, steps=_sawn)
