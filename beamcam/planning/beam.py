"""The plan of a bar on a saw and drilling line."""

from collections.abc import Collection, Iterator, Sequence

from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.machine.machine import Drill, Layout, Machine, Saw
from beamcam.model.part import Bend, Camber, Contour, EndPlane, Feature, Hole, Part, Slot, TextMark
from beamcam.model.plan import DrillOp, FeatureRef, Operation, Outcome, Piece, Plan
from beamcam.planning import rules
from beamcam.planning.bar import cuts_of, lay_on_bar, refuse_cut
from beamcam.planning.drilling import drillings, refuse_hole
from beamcam.planning.ends import End, ends_of, leaves_stock
from beamcam.planning.order import sort_along_x


def plan_bar(
    parts: Sequence[Part],
    machine: Machine,
    bar: float | None = None,
    skips: Collection[str] = (),
) -> Plan:
    """The work that makes `parts`, in the order given, from one bar of length `bar`.

    `skips` names what may be left out (`rules.SKIP_NAMES`). Raises PlanError with everything that
    the machine cannot make; nothing is left out that is not in the plan's outcomes.
    """
    saw, drill, layout = machine.saw, machine.drill, machine.layout
    if saw is None or drill is None or layout is None:
        raise TypeError(f"{machine.name} has no saw, drill and layout")
    refusals = [*_refuse_stock(parts, machine, saw, drill, layout)]
    if refusals:
        raise PlanError(refusals)
    remarks: list[Diagnostic] = []
    ends: list[tuple[End, End]] = []
    for part in parts:
        planes, said = ends_of(part, saw.least_mitre)
        ends.append(planes)
        remarks += said
        refusals += [d for end in planes if (d := refuse_cut(end, saw, part.source))]
        if part.quantity > parts.count(part):
            remarks.append(
                rules.QUANTITY.at(part.source, found=part.quantity, made=parts.count(part))
            )
    reasons = {
        (p, f): _refuse_feature(feature, part, ends[p], machine)
        for p, part in enumerate(parts)
        for f, feature in enumerate(part.features)
    }
    skipped = {ref: said for ref, said in reasons.items() if said and _skip_name(said) in skips}
    refusals += [said for ref, said in reasons.items() if said and ref not in skipped]
    if errors_in(refusals):
        raise PlanError(refusals)
    pieces, account = lay_on_bar(parts, ends, layout, saw, bar)
    holes = [
        ((p, f), feature)
        for p, part in enumerate(parts)
        for f, feature in enumerate(part.features)
        if isinstance(feature, Hole) and (p, f) not in skipped
    ]
    drilled = list(_drill_ops(holes, pieces, machine, drill))
    operations: list[Operation] = [*cuts_of(pieces, ends, saw), *drilled]
    plan = Plan(
        parts[0].profile,
        pieces,
        account,
        sort_along_x(operations, machine.format.resolution),
        tuple(_outcomes(parts, drilled, skipped)),
        tuple(remarks),
    )
    _balance(plan)
    return plan


def _refuse_stock(
    parts: Sequence[Part], machine: Machine, saw: Saw, drill: Drill, layout: Layout
) -> Iterator[Diagnostic]:
    """What is wrong with the section of the bar."""
    profile = parts[0].profile
    for part in parts:
        if part.profile.code not in layout.profiles or part.profile.code not in machine.sections:
            yield rules.STOCK.at(
                part.source,
                found=part.profile.code,
                machine=machine.name,
                expected=", ".join(layout.profiles),
            )
        elif part.profile != profile:
            yield rules.MIXED_PROFILES.at(
                part.source, found=part.profile.name, expected=profile.name
            )
        for station, size in (("saw", saw), ("drill", drill)):
            if (
                part.profile.height > size.greatest_height
                or part.profile.width > size.greatest_width
            ):
                yield rules.SECTION_SIZE.at(
                    part.source,
                    found=f"{part.profile.height:g} x {part.profile.width:g}",
                    station=station,
                    expected=f"{size.greatest_height:g} x {size.greatest_width:g}",
                )


def _skip_name(said: Diagnostic) -> str:
    return said.code.removeprefix("plan-")


def _refuse_feature(
    feature: Feature, part: Part, ends: tuple[End, End], machine: Machine
) -> Diagnostic | None:
    """Why the line cannot make a feature; None if it can."""
    match feature:
        case Hole():
            return refuse_hole(feature, part, machine)
        case Slot():
            size = f"{feature.length + feature.diameter:g} x {feature.height + feature.diameter:g}"
            return rules.SLOT.at(feature.source, found=size, face=feature.face)
        case TextMark():
            return rules.MARK.at(
                feature.source, found=f"the text {feature.text!r}", face=feature.face
            )
        case Contour():
            return _refuse_contour(feature, part, ends)
        case Bend() | EndPlane() | Camber():
            names = {Bend: "a bend", EndPlane: "an end plane", Camber: "a camber"}
            return rules.OTHER.at(feature.source, found=names[type(feature)])


def _refuse_contour(contour: Contour, part: Part, ends: tuple[End, End]) -> Diagnostic | None:
    if contour.process != "cut":
        length = sum(curve.length for curve in contour.curves)
        return rules.MARK.at(contour.source, found=f"{length:g} mm of line", face=contour.face)
    if contour.kind != "outer":
        boxes = [curve.bbox for curve in contour.curves]
        size = (
            f"{max(b[2] for b in boxes) - min(b[0] for b in boxes):g} x "
            f"{max(b[3] for b in boxes) - min(b[1] for b in boxes):g}"
        )
        return rules.CUTOUT.at(contour.source, found=size, face=contour.face)
    corner = leaves_stock(contour, part, ends)
    if corner is not None:
        return rules.COPE.at(
            contour.source, face=contour.face, x=f"{corner[0]:g}", y=f"{corner[1]:g}"
        )
    for bevel in contour.bevels:
        if contour.face in ("v", "h") or not _is_sawn(bevel.angle, ends):
            return rules.BEVEL.at(contour.source, found=f"{bevel.angle:g}", face=contour.face)
    return None


def _is_sawn(bevel_deg: float, ends: tuple[End, End]) -> bool:
    """Whether a mitre of the web leaves this bevel on a flange's end."""
    return any(abs(abs(bevel_deg) - abs(end.web_deg)) <= 0.2 for end in ends)


def _drill_ops(
    holes: Sequence[tuple[FeatureRef, Hole]],
    pieces: Sequence[Piece],
    machine: Machine,
    drill: Drill,
) -> Iterator[DrillOp]:
    for stroke in drillings(holes, machine, drill):
        ref, hole = stroke.holes[0]
        yield DrillOp(
            drill.x + pieces[ref[0]].start + stroke.x,
            stroke.spindle,
            stroke.tool,
            tuple(h.face for _, h in stroke.holes),
            stroke.y,
            hole.depth,
            tuple(r for r, _ in stroke.holes),
            stroke.reason,
            hole.source,
        )


def _outcomes(
    parts: Sequence[Part],
    drilled: Sequence[DrillOp],
    skipped: dict[FeatureRef, Diagnostic],
) -> Iterator[Outcome]:
    """What becomes of each feature, in the order of parts and features."""
    made = {ref: (op, i) for op in drilled for i, ref in enumerate(op.features)}
    for p, part in enumerate(parts):
        for f in range(len(part.features)):
            ref = (p, f)
            if ref in skipped:
                yield Outcome(ref, "skipped", skipped[ref].code)
            elif ref in made:
                yield Outcome(ref, "merged" if made[ref][1] else "made", "drill")
            elif isinstance(part.features[f], Contour):
                yield Outcome(ref, "made", "saw")


def _balance(plan: Plan) -> None:
    """Raise AssertionError unless every feature has exactly one outcome.

    That would be a fault of the planner and not of the part, and no program may come of it.
    """
    read = [(p, f) for p, piece in enumerate(plan.pieces) for f in range(len(piece.part.features))]
    if [o.feature for o in plan.outcomes] != read:
        raise AssertionError("the ledger of the plan does not balance")
