"""The work of each part, independent of its place on a bar.

ends, as far as a saw makes them
     -> each feature by itself: what it needs, and its place on the finished part
     -> the steps of each kind of work
     -> steps that no axis comes to
     -> refused, or left out where that is allowed
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import atan, cos, degrees, pi, radians, sqrt, tan

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Source, error, errors_in, note
from beamcam.machine.machine import Machine, drill_of, saw_of
from beamcam.machine.stations import Saw, SawSection
from beamcam.model.description import description
from beamcam.model.part import Bend, Camber, Contour, EndPlane, Feature, Hole, Part, Slot, TextMark
from beamcam.model.request import policy_on, rolled_on
from beamcam.model.rounds import SLACK, is_unrolled, named_diameters, unseen
from beamcam.model.section import corners, section_fault
from beamcam.planning import rules
from beamcam.planning.axis_limits import refuse_steps
from beamcam.planning.left_out import listed_by, refuse_mark
from beamcam.planning.operations.finished_part import SQUARE, Ends, SawnEnd, ends_of
from beamcam.planning.operations.hole import HOLE
from beamcam.planning.operations.marks import LINE, TEXT
from beamcam.planning.operations.outlines import CONTOUR, OTHER
from beamcam.planning.operations.part_planner import PartPlanner, WorkKind
from beamcam.planning.operations.slot import SLOT
from beamcam.planning.operations.tools import Settled, WorkingStep
from beamcam.planning.within import within_larger

KINDS = (HOLE, SLOT, LINE, CONTOUR, TEXT, OTHER)  #: a part gets their steps in this order
REASONS = {code: text for kind in KINDS for code, text in kind.reasons.items()}
KIND_OF = {
    Hole: HOLE, Slot: SLOT, Contour: CONTOUR, TextMark: TEXT,
    Bend: OTHER, EndPlane: OTHER, Camber: OTHER,
}  # fmt: skip


def kind_of(feature: Feature) -> WorkKind:
    """The kind of work that makes a feature; a contour that is not cut is a line to mark."""
    is_line = isinstance(feature, Contour) and feature.process != "cut"
    return LINE if is_line else KIND_OF[type(feature)]


class PartWork(Struct, frozen=True):
    """The work of one part, and the part of it that is refused."""

    part: Part
    ends: Ends
    refusals: tuple[Diagnostic, ...]
    remarks: tuple[Diagnostic, ...] = ()
    steps: tuple[WorkingStep, ...] = ()
    settled: tuple[Settled, ...] = ()  #: features that need no step
    skipped: Mapping[int, Diagnostic] = {}  #: features left out by permission, and why


def refuse_stock(parts: Sequence[Part], machine: Machine) -> None:
    """Raises PlanError for sections that the machine does not take, or that differ on one bar."""
    layout = machine.needed(machine.layout, "layout")
    if not parts:
        raise PlanError(rules.NO_PARTS.at(Source(machine.name)))
    refusals: list[Diagnostic] = []
    profile = parts[0].profile
    for part in parts:
        mine = part.profile
        if mine.code not in layout.profiles or mine.code not in machine.sections:
            refusals.append(rules.STOCK.at(
                part.source, found=mine.code, machine=machine.name,
                expected=", ".join(layout.profiles),
            ))  # fmt: skip
        elif mine is not profile and mine != profile:
            refusals.append(
                rules.MIXED_PROFILES.at(part.source, found=mine.name, expected=profile.name)
            )
        if mine.code == "B" and is_unrolled(mine):
            refusals.append(rules.UNROLLED.at(
                part.source, found=mine.name, expected="a flat bar, or a pipe of profile code RO",
            ))  # fmt: skip
        fault = section_fault(mine)
        if fault is not None:
            refusals.append(rules.SECTION_SHAPE.at(part.source, found=fault, code=mine.code))
    stations = (("saw", saw_of(machine)), ("drill", drill_of(machine)))
    for part in parts:
        height, width = part.profile.height, part.profile.width
        for station, size in stations:
            if height > size.max_height or width > size.max_width:
                refusals.append(rules.SECTION_SIZE.at(
                    part.source, found=f"{height:g} x {width:g}", station=station,
                    expected=f"{size.max_height:g} x {size.max_width:g}",
                ))  # fmt: skip
    if refusals:
        raise PlanError(refusals)


def works_on(
    parts: Sequence[Part], machine: Machine, skips: Collection[str]
) -> tuple[list[PartWork], list[Diagnostic]]:
    """The work of each part, and remarks. Raises PlanError with all that cannot be made."""
    works: dict[int, PartWork] = {}
    for part in parts:
        if id(part) not in works:
            works[id(part)] = _work_on(part, machine, skips)
    refusals = [diagnostic for work in works.values() for diagnostic in work.refusals]
    if refusals:
        raise PlanError(refusals)
    remarks: list[Diagnostic] = []
    for work in works.values():
        part = work.part
        remarks += work.remarks
        if part.quantity > 1:
            count = sum(one is part or one == part for one in parts)
            if part.quantity > count:
                remarks.append(rules.QUANTITY.at(part.source, found=part.quantity, made=count))
    return [works[id(part)] for part in parts], remarks


def _work_on(part: Part, machine: Machine, skips: Collection[str]) -> PartWork:
    """The work of `part` in its orientation; refusals are in the result, and not raised."""
    try:
        ends, remarks = ends_of(part, saw_of(machine))
    except PlanError as error:
        return PartWork(part, SQUARE, error.diagnostics)
    planner = PartPlanner(part, ends, machine)
    of_ends: list[Diagnostic] = []
    for end in ends:
        if not end.is_square and (refusal := _refuse_cut(end, _turning_saw(machine), part)):
            of_ends.append(refusal)
    of_ends += _judge_ends(ends, part, saw_of(machine))
    _put_features(planner)
    for kind in KINDS:
        if accepted := planner.accepted[kind.name]:
            planner.take(kind.steps(accepted, planner))
    # What no axis comes to outweighs all that was refused before, and drops the steps.
    refused, steps = planner.refused, planner.steps
    beyond = dict(refuse_steps(part.features, steps, planner.travel))
    if beyond:
        refused |= beyond
        steps = [step for step in steps if beyond.keys().isdisjoint(step.features)]
    for f, each in [*planner.settled.items()]:  # the repeats of refused features are refused too
        if each.like in refused:
            refused[f] = refused[each.like]
        if f in refused:
            del planner.settled[f]
    skipped = {
        f: diagnostic
        for f, diagnostic in refused.items()
        if diagnostic.code.removeprefix("plan-") in skips
    }
    refusals = [*errors_in(of_ends), *(refused[f] for f in sorted(refused) if f not in skipped)]
    diagnostics = [
        *remarks,
        *(diagnostic for diagnostic in of_ends if diagnostic not in refusals),
        *(diagnostic for f, diagnostic in planner.remarks if f not in refused),
    ]
    return PartWork(
        part, ends, tuple(refusals), tuple(diagnostics), tuple(steps),
        tuple(planner.settled.values()), skipped,
    )  # fmt: skip


def _put_features(planner: PartPlanner) -> None:
    """Put each feature that can be made to those of its kind, and refuse the others."""
    marks, within = planner.machine.marks, within_larger(planner.part)
    for f, own in enumerate(planner.part.features):
        if f in within:
            planner.settled[f] = Settled(f, "duplicate", within[f].code)
            planner.remarks.append((f, within[f]))
            continue
        refusal = None
        if policy_on(own, marks) is not None:
            why, refusal = listed_by(own, marks), refuse_mark(own, marks)
            if why is not None:
                planner.settled[f] = Settled(f, "listed", why)
                continue
        kind, feature = kind_of(own), planner.on_reached_face(f, own)
        refusal = refusal or kind.needs(feature, planner)
        if refusal is not None:
            planner.refused[f] = refusal
            continue
        for diagnostic in kind.refusals(feature, planner):
            planner.take([(f, diagnostic)])
        if f not in planner.refused:
            planner.accepted[kind.name].append((f, feature))


# --- ends -----------------------------------------------------------------------------------------


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
TOUCH = 0.01  #: mm; ends that are as near meet in a point


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


def _turning_saw(machine: Machine) -> Saw:
    """The saw with those of its angles that its axis turns to."""
    saw = saw_of(machine)
    for axis in machine.axes:
        if axis.moves == "angle" and axis.spindle is None:
            least, greatest = axis.limits
            if least > saw.min_angle or greatest < saw.max_angle:
                least, greatest = max(least, saw.min_angle), min(greatest, saw.max_angle)
                return replace(saw, min_angle=least, max_angle=greatest)
    return saw


def _judge_ends(ends: Ends, part: Part, saw: Saw) -> Iterator[Diagnostic]:
    """Errors and remarks on the two ends of a part, together and one by one."""
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


# --- rounds ---------------------------------------------------------------------------------------


PIPE = note("plan-pipe",
    "found a plate {found} {height} mm wide; it is the unrolled surface of a pipe {diameter} mm in "
    "diameter, and is sawn as that pipe",
    "Some exporters write a pipe as a plate as wide as its circumference.")  # fmt: skip
ROUND = error("plan-round",
    "found {what}, which is the unrolled surface of a round bar; expected {expected}",
    "Face v of a round is its surface, unrolled: y counts the arc from its lowest line, and v is a "
    "quarter of the way round. A spindle drills square to the surface only in the middle of v, o, "
    "h or u, and the saw cuts planes. A machine for tubes makes the others; --allow-skips "
    "cutout leaves them out.")  # fmt: skip
LEFT_OUT_AS = "cutout"  #: name of what is not seen square for --allow-skips
PLANE_ENDS = "one as wide as the round, of two plane ends that lean in the view of v alone"


def round_remarks(
    given: Part, machine: Machine, skips: Collection[str] = ()
) -> Iterator[Diagnostic]:
    """That a plate is sawn as a pipe, and errors for what spindles and saw cannot make of it.

    Where `skips` has cut-outs, what is not seen square is left out as one.
    """
    part = rolled_on(machine, given)
    plate, diameter = given.profile, part.profile.height
    if part is not given:
        named_mm = named_diameters(plate.name)
        if named_mm and min(abs(one - diameter) for one in named_mm) > SLACK:
            nearest = min(named_mm, key=lambda one: abs(one - diameter))
            expected = f"{pi * nearest:.2f} mm of width, the circumference that its name has"
            yield rules.UNROLLED.at(given.source, found=plate.name, expected=expected)
            return
        yield PIPE.at(
            given.source, found=plate.name, height=f"{plate.height:g}", diameter=f"{diameter:.2f}"
        )
    if not part.profile.is_round:
        return
    quarters = ", ".join(f"{k * pi / 4 * diameter:.2f}" for k in range(4))
    wall = max(part.profile.flange_thickness, part.profile.web_thickness or 0.0)
    deeper = machine.drill.breakthrough if machine.drill else 0.0
    for hole in part.features if part.profile.code == "RO" and wall else ():
        if isinstance(hole, Hole | Slot) and hole.depth is None and hole.kind != "mark":
            # Beside its middle the wall curves away from the drill.
            inner = diameter / 2 - wall
            sag = inner - sqrt(max(0.0, inner**2 - (hole.diameter / 2) ** 2))
            if sag > deeper:
                expected = f"one through a wall that curves by {deeper:g} mm, not {sag:.2f}"
                yield ROUND.at(hole.source, what=description(hole), expected=expected)
    for feature in unseen(part) if LEFT_OUT_AS not in skips else ():
        is_end = isinstance(feature, Contour) and feature.kind == "outer"
        expected = PLANE_ENDS if is_end else f"it in the middle of a face, at y {quarters}"
        yield ROUND.at(feature.source, what=description(feature), expected=expected)
