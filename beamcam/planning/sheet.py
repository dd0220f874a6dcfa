"""The plan of a sheet on a cutting table.

part -> what each curve is for -> joined, what lies twice taken away -> nothing crosses -> nested
     -> half a kerf off -> in order -> begun, with lead-ins and bridges -> a ledger of every feature

Until the work is put in order all coordinates are those of the drawing, so that messages are too.
"""

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from math import prod
from typing import cast

from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Source, errors_in
from beamcam.geometry.arrays import table_of
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import join_boxes
from beamcam.geometry.polylines import refit_runs
from beamcam.machine.machine import Machine
from beamcam.machine.tables import TABLE_CONTROLLERS
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.model.part import Hole, Measures, Part, Slot
from beamcam.model.plan import ContourOp, Outcome, Piece, SheetPlan
from beamcam.model.rounds import is_unrolled
from beamcam.planning import rules as bar_rules
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import (
    OUTLINE,
    Assigned,
    assign_processes,
    min_hole,
    spot,
)
from beamcam.planning.contours.join import Joined, join, nest
from beamcam.planning.contours.operations import operations_of
from beamcam.planning.contours.order import PLAIN, refuse_order
from beamcam.planning.contours.outline import (
    Shape,
    cross_at,
    off_plate,
    points_of,
    round_ended,
)
from beamcam.planning.contours.plate import (
    SheetMaterial,
    refuse_large,
    refuse_size,
    shift_of,
    skew_ends,
)
from beamcam.planning.contours.running_back import refuse_copies, refuse_many_passes
from beamcam.planning.left_out import BEVEL, DRILL

#: What arcs for short chords may take of the machine's tolerance; rounding has the rest.
CHORDS_SHARE = 0.5
#: mm that the torch moves while it makes a spot, as no controller stops a tool that never moved.
SPOT = 0.01
SHEET_CODES = ("B",)


def plan_sheet(parts: Sequence[Part], machine: Machine, skips: Collection[str] = ()) -> SheetPlan:
    """The work that makes one part, or a drawing of many, from a sheet.

    `skips` names what may be left out (`SKIP_NAMES`). Raises PlanError with everything
    that the machine cannot make; nothing is left out that is not in the plan's outcomes.
    """
    torch = machine.needed(machine.torch, "torch")
    _refuse_stock(parts, machine, torch)
    own = {id(part): part for part in parts}
    if off := [one for part in own.values() for one in off_plate(part, torch.tolerance)]:
        raise PlanError(off)
    if len(parts) > 1:
        return _plan_of_several(parts, machine, torch, skips)
    (part,) = parts
    torch = torch.by(SheetMaterial(part, torch).row("cut"))
    machine = machine if torch is machine.torch else replace(machine, torch=torch)
    assigned = assign_processes(part, torch, machine, skips)
    material = SheetMaterial(part, torch)
    _refuse_work(part, assigned, {w.process for w in assigned.curves}, material, machine, torch)
    remarks = [*material.remarks, *assigned.remarks]
    curves = table_of(tuple([w.curve for w in assigned.curves]))
    refuse_copies(assigned.curves, curves)
    box = curves.box
    assert box is not None
    refuse_large(box, part, torch, torch.gap + torch.tolerance)
    kerf = material.kerf("cut")
    joined = join(assigned.curves, curves, torch, kerf, assigned.rings)
    if machine.words.arc_cw:
        joined.shapes = _with_arcs(joined.shapes, torch)
    shapes, diagnostics = _nested(joined, assigned, torch, kerf)
    shapes, crosses = drill_small_openings(shapes, part, torch, skips, assigned)
    box = join_boxes([box, *(curve.bbox for s in crosses for curve in s.curves)]) or box
    shift = shift_of(box, torch)
    processes = {s.process for s in (*shapes, *crosses)}
    _refuse_work(part, assigned, processes, material, machine, torch)
    shapes += [*crosses, *_spots(part, assigned)]
    remarks += [*joined.remarks, *diagnostics]
    if not shapes:
        raise PlanError(_nothing(part, assigned, len(joined.small), torch.gap))
    operations, diagnostics = operations_of(shapes, material, torch, shift, joined.repeats.share)
    remarks += diagnostics
    if errors_in(remarks):
        raise PlanError(errors_in(remarks))
    refuse_size(operations, part, torch)
    piece = Piece(part, 0.0, place=shift)
    outcomes = tuple(_outcomes(part, assigned, joined, operations))
    if part.quantity > (made := prod(torch.copies)):
        remarks.append(rules.QUANTITY.at(part.source, found=part.quantity, made=made))
    plan = SheetPlan(
        part.profile, (piece,), shift, material.thickness, operations, outcomes, tuple(remarks),
        min_bevel=torch.min_bevel,
    )  # fmt: skip
    if [outcome.feature for outcome in outcomes] != [(0, f) for f in range(len(part.features))]:
        raise AssertionError("the ledger of the plan does not balance")
    return plan


def _refuse_work(
    part: Part, assigned: Assigned, processes: set[TorchProcess], material: SheetMaterial,
    machine: Machine, torch: Torch,
) -> None:  # fmt: skip
    """Raises PlanError for what the machine cannot make of the curves, and where there are none."""
    refusals = [*assigned.refusals]
    if torch.settings:
        # A power that the machine cannot follow, and an overcut of what is not cut, of each colour
        # or layer in use.
        curves = assigned.curves
        first = {(w.look, w.process): w for w in reversed(curves) if w.look}
        for look, process in sorted(first):
            source, power = first[look, process].source, torch.settings[look].power
            why = None
            if machine.controller in TABLE_CONTROLLERS:
                why = f"the tool of {machine.name} is on or off"
            elif not any("{power}" in line for line in getattr(machine.words, f"{process}_on")):
                why = f"words.{process}_on of {machine.name} has no {{power}}"
            if power is not None and why is not None:
                key, found = f"map.{look}.power", f"{power:g}"
                refusals.append(rules.LOOK_SETTING.at(source, key=key, found=found, why=why))
        for (look, process), w in {(w.look, w.process): w for w in curves}.items():
            if process != "cut" and torch.settings.get(look, PLAIN).overcut is not None:
                refusals.append(rules.LOOK_OVERCUT.at(w.source, key=look, found=process))
    spots: set[TorchProcess] = {"spot"} if assigned.spots else set()
    refusals += material.refusals(processes | spots)
    if machine.triggers is not None and machine.triggers.z is not None:
        refusals += material.unlifted(processes, machine.triggers.z)
    if refusals:
        raise PlanError(refusals)
    if not assigned.curves:
        raise PlanError(_nothing(part, assigned, 0, torch.gap))


def _spots(part: Part, assigned: Assigned) -> list[Shape]:
    """The spots as lines so short that they are none but for the controller."""
    return [
        Shape(
            "spot", (Line((x, y), (x + SPOT, y)),), False, tuple(sorted(set(features))),
            cast("Hole | Slot", part.features[features[0]]).source,
        )
        for (x, y), features in assigned.spots.items()
    ]  # fmt: skip


def _with_arcs(shapes: Sequence[Shape], torch: Torch) -> list[Shape]:
    fits = refit_runs([shape.curves for shape in shapes], torch.tolerance * CHORDS_SHARE)
    return [
        shape if len(curves) == len(shape.curves) else replace(shape, curves=curves)
        for shape, curves in zip(shapes, fits, strict=True)
    ]


def _nested(
    joined: Joined, assigned: Assigned, torch: Torch, kerf: float
) -> tuple[list[Shape], list[Diagnostic]]:
    """The contours with their places in one another, and remarks on them.

    Raises PlanError for those that cannot be worked, or not in the order that is asked for.
    """
    drawn = points_of([shape.curves for shape in joined.shapes], torch.tolerance / 4)
    refuse_many_passes(joined.shapes, drawn, torch.tolerance)
    shapes, diagnostics = nest(
        joined.shapes, drawn, assigned.curves, torch.tolerance, torch.gap, kerf
    )
    diagnostics = [*diagnostics, *refuse_order(shapes, torch)]
    if errors := errors_in([*joined.refusals, *diagnostics]):
        raise PlanError(errors)
    return shapes, diagnostics


def _refuse_stock(parts: Sequence[Part], machine: Machine, torch: Torch) -> None:
    """Raises PlanError unless there is a part, and all are plates."""
    if not parts:
        raise PlanError(rules.SHEETS.at(Source(machine.name), found=0))
    for part in parts:
        if part.profile.code not in SHEET_CODES:
            raise PlanError(bar_rules.STOCK.at(
                part.source, found=part.profile.code, machine=machine.name,
                expected=", ".join(SHEET_CODES),
            ))  # fmt: skip
        if is_unrolled(part.profile) and not torch.unrolled:
            raise PlanError(bar_rules.UNROLLED.at(
                part.source, found=part.profile.name,
                expected="a plate, or --unrolled, which cuts the development flat",
            ))  # fmt: skip
    if skew := [diagnostic for part in parts for diagnostic in skew_ends(part, torch)]:
        raise PlanError(skew)


def _plan_of_several(
    parts: Sequence[Part], machine: Machine, torch: Torch, skips: Collection[str]
) -> SheetPlan:
    """The work that makes several parts from one sheet, planned as one drawing of all of them."""
    from beamcam.planning.sheet_rows import laid_out

    laid = laid_out(parts, machine, skips)
    plan = plan_sheet((laid.whole,), replace(machine, torch=replace(torch, place="drawn")), skips)
    operations = tuple(
        replace(
            op,
            features=tuple(f for f in (laid.origins[i] for _, i in op.features) if f[1] != OUTLINE),
        )
        for op in plan.operations
    )
    outcomes = tuple(
        replace(outcome, feature=origin)
        for outcome, origin in zip(plan.outcomes, laid.origins, strict=True)
        if origin[1] != OUTLINE
    )
    pieces = tuple(
        Piece(part, 0.0, k, place=place)
        for k, (part, place) in enumerate(zip(parts, laid.places, strict=True))
    )
    made = Counter(part for part in parts if part.quantity > 1)
    more = tuple(
        rules.QUANTITY.at(part.source, found=part.quantity, made=count)
        for part, count in made.items()
        if part.quantity > count
    )
    return replace(
        plan, pieces=pieces, operations=operations, outcomes=outcomes,
        remarks=(*plan.remarks, *more),
    )  # fmt: skip


def _nothing(part: Part, assigned: Assigned, small: int, gap: float) -> Diagnostic:
    """Why a drawing gives no work; `small` features are too small."""
    from beamcam.model.lengths import total_length

    out = len(assigned.skipped) + len(assigned.listed)
    texts = [f"{out} features left out"] if out else []
    if small:
        texts.append(f"{small} curves no larger than {gap:g} mm")
    measures = part.measures or Measures()
    if measures.filled:
        length = total_length(measures.filled)
        texts.append(f"{length:.1f} mm round filled shapes without a stroke")
    if measures.hidden:
        texts.append(f"{total_length(measures.hidden):.1f} mm on hidden layers")
    return rules.NOTHING.at(part.source, found=", ".join(texts) or "the sheet is empty")


def _outcomes(
    part: Part, assigned: Assigned, joined: Joined, operations: Sequence[ContourOp]
) -> Iterator[Outcome]:
    made = {feature: op.row.process for op in operations for _, feature in op.features}
    stands = joined.repeats.resolved(made) if joined.repeats.stands else {}
    for index in range(len(part.features)):
        ref, why = (0, index), assigned.listed.get(index)
        if why == BEVEL and index in made:  # cut as it stands, its edges square
            yield Outcome(ref, "made", made[index], why)
        elif why is not None:
            yield Outcome(ref, "listed", why)
        elif index in made:
            yield Outcome(ref, "made", made[index])
        elif index in assigned.within:
            yield Outcome(ref, "duplicate", assigned.within[index].code)
        elif index in assigned.filled:
            yield Outcome(ref, "made", assigned.filled[index])
        elif index in assigned.stated:
            yield Outcome(ref, "made", "cut")
        elif index in assigned.skipped:
            yield Outcome(ref, "skipped", assigned.skipped[index])
        elif index in stands:
            yield Outcome(ref, "duplicate", rules.OVERLAP.code)
        elif index in joined.small:
            yield Outcome(ref, "skipped", rules.TINY.code)


def drill_small_openings(
    shapes: Sequence[Shape], part: Part, torch: Torch, skips: Collection[str], assigned: Assigned
) -> tuple[list[Shape], list[Shape]]:
    """The shapes but for round openings and slots of a drawing that are too small for the torch,
    and the crosses that mark them.

    They are what such a hole or slot of a part is: their drill start points are marked and they are
    listed, or they are refused, or left out; `assigned` records it. What lies within one as round,
    as a countersink or a thread, goes with it.
    """
    thickness = part.profile.web_thickness or torch.thickness or 0.0
    least = min_hole(torch, thickness)
    crosses, small = list[Shape](), set[int]()
    for k in sorted(range(len(shapes)), key=lambda k: shapes[k].depth):
        shape = shapes[k]
        if shape.process != "cut" or not (shape.is_hole or shape.parent in small):
            continue
        opening = round_ended(shape, least, torch.tolerance) if shape.closed else None
        if opening is None:
            continue
        small.add(k)
        if torch.drilled != "refuse":
            assigned.listed.update(dict.fromkeys(shape.features, DRILL))
            if torch.drilled == "spot":
                spot(opening.centres, shape.features, assigned)
            else:
                crosses += (
                    Shape("mark", (line,), False, shape.features, shape.source)
                    for centre in opening.centres for line in cross_at(centre, torch.cross)
                )  # fmt: skip
            continue
        if len(opening.centres) > 1:
            diagnostic = bar_rules.SLOT.at(
                shape.source, found=f"{opening.length:.4g} x {opening.width:.4g}", face="v",
                expected=f"one at least {least:g} wide in a sheet of {thickness:g} mm",
            )  # fmt: skip
        else:
            diagnostic = bar_rules.NO_TOOL.at(
                shape.source, kind="through", found=f"{opening.width:.4g}", face="v",
                expected=f"at least {least:g} in a sheet of {thickness:g} mm",
            )  # fmt: skip
        if diagnostic.code.removeprefix("plan-") in skips:
            assigned.skipped.update(dict.fromkeys(shape.features, diagnostic.code))
        else:
            assigned.refusals.append(diagnostic)
    left = [k for k in range(len(shapes)) if k not in small]
    place = {k: number for number, k in enumerate(left)}
    return [replace(shapes[k], parent=place.get(shapes[k].parent, -1)) for k in left], crosses
