"""The work of each part, independent of its place on a bar.

ends -> each feature by itself: what it needs, and its place on the finished part
     -> the steps of each kind of work
     -> steps that no axis comes to
     -> refused, or left out where that is allowed
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from math import pi, sqrt

from msgspec import Struct

from beamcam.errors import Diagnostic, PlanError, Source, error, errors_in, note
from beamcam.machine.machine import Machine
from beamcam.model.description import description
from beamcam.model.part import Bend, Camber, Contour, EndPlane, Feature, Hole, Part, Slot, TextMark
from beamcam.model.request import policy_on, rolled_on
from beamcam.model.rounds import SLACK, is_unrolled, named_diameters, unseen
from beamcam.model.section import section_fault
from beamcam.planning import rules
from beamcam.planning.axis_limits import refuse_steps
from beamcam.planning.left_out import listed_by, refuse_mark
from beamcam.planning.operations.finished_part import SQUARE, Ends, ends_of
from beamcam.planning.operations.hole import HOLE
from beamcam.planning.operations.marks import LINE, TEXT
from beamcam.planning.operations.part_planner import BarLine, PartPlanner, WorkKind
from beamcam.planning.operations.saw_cut import CONTOUR, OTHER, SAW_CUT
from beamcam.planning.operations.slot import SLOT
from beamcam.planning.operations.tools import Settled, WorkingStep

# --- kinds ----------------------------------------------------------------------------------------

# The kinds of work on a bar, in the order in which a part gets their steps.


KINDS = (HOLE, SLOT, LINE, CONTOUR, TEXT, OTHER, SAW_CUT)
REASONS = {code: said for kind in KINDS for code, said in kind.reasons.items()}
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


def refuse_stock(parts: Sequence[Part], line: BarLine) -> None:
    """Raises PlanError for sections that the machine does not take, or that differ on one bar."""
    machine, layout = line.machine, line.layout
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
    stations = (("saw", line.saw), ("drill", line.drill))
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
    parts: Sequence[Part], line: BarLine, skips: Collection[str]
) -> tuple[list[PartWork], list[Diagnostic]]:
    """The work of each part, and remarks. Raises PlanError with all that cannot be made."""
    works: dict[int, PartWork] = {}
    for part in parts:
        if id(part) not in works:
            works[id(part)] = _work_on(part, line, skips)
    refusals = [diagnostic for work in works.values() for diagnostic in work.refusals]
    if refusals:
        raise PlanError(refusals)
    return [works[id(part)] for part in parts], [*_remarks(works.values(), parts)]


def _remarks(works: Iterable[PartWork], parts: Sequence[Part]) -> Iterator[Diagnostic]:
    """Remarks on each part, once."""
    for work in works:
        part = work.part
        yield from work.remarks
        if part.quantity > 1:
            count = sum(one is part or one == part for one in parts)
            if part.quantity > count:
                yield rules.QUANTITY.at(part.source, found=part.quantity, made=count)


def _work_on(part: Part, line: BarLine, skips: Collection[str]) -> PartWork:
    """The work of `part` in its orientation; refusals are in the result, and not raised."""
    try:
        ends, remarks = ends_of(part, line.saw)
    except PlanError as error:
        return PartWork(part, SQUARE, error.diagnostics)
    planner = PartPlanner(part, ends, line)
    of_ends = [diagnostic for end in ends if (diagnostic := SAW_CUT.needs(end, planner))]
    of_ends += SAW_CUT.refusals(ends, planner)
    _put_features(planner)
    for kind in KINDS:
        if accepted := planner.accepted[kind.name]:
            planner.take(kind.steps(accepted, planner))
    planner.refuse(refuse_steps(planner.part.features, planner.steps, planner.travel))
    planner.refuse_repeats()
    refused = planner.refused
    skipped = {
        f: diagnostic
        for f, diagnostic in refused.items()
        if diagnostic.code.removeprefix("plan-") in skips
    }
    refusals = [*errors_in(of_ends), *(refused[f] for f in sorted(refused) if f not in skipped)]
    diagnostics = [
        *remarks,
        *(diagnostic for diagnostic in of_ends if diagnostic not in refusals),
        *planner.remarks,
    ]
    return PartWork(
        part, ends, tuple(refusals), tuple(diagnostics), tuple(planner.steps),
        tuple(planner.settled.values()), skipped,
    )  # fmt: skip


def _put_features(planner: PartPlanner) -> None:
    """Put each feature that can be made to those of its kind, and refuse the others."""
    marks = planner.line.machine.marks
    for f, given in enumerate(planner.part.features):
        if policy_on(given, marks) is not None and not _is_made(f, given, planner):
            continue
        kind, feature = kind_of(given), planner.on_reached_face(f, given)
        lacking = kind.needs(feature, planner)
        if lacking is not None:
            planner.refused[f] = lacking
            continue
        planner.take([(f, diagnostic) for diagnostic in kind.refusals(feature, planner)])
        if f not in planner.refused:
            planner.accepted[kind.name].append((f, feature))


def _is_made(f: int, mark: Feature, planner: PartPlanner) -> bool:
    """Whether a mark is work of the machine; one that is not is listed, or refused."""
    marks = planner.line.machine.marks
    why, diagnostic = listed_by(mark, marks), refuse_mark(mark, marks)
    if why is not None:
        planner.settled[f] = Settled(f, "listed", why)
    elif diagnostic is not None:
        planner.refused[f] = diagnostic
    return why is None and diagnostic is None


# --- rounds ---------------------------------------------------------------------------------------

# Plates that are sawn as pipes, and what no side of a round shows.


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


def told_of_round(
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
