"""The plan of a sheet on a cutting table.

part -> what each curve is for -> what lies twice taken away -> joined, nested -> half a kerf off
     -> in order -> begun, led into, bridged -> a ledger of every feature
"""

from collections.abc import Collection, Iterator, Sequence
from fnmatch import fnmatchcase
from typing import Literal

from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Source, errors_in
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Matrix, Point
from beamcam.machine.machine import Machine, Torch, TorchProcess, TorchRow
from beamcam.model.drawing import extent
from beamcam.model.part import Part
from beamcam.model.plan import ContourOp, Outcome, Pass, Piece, SheetPlan
from beamcam.planning import rules as bar_rules
from beamcam.planning.contours import rules
from beamcam.planning.contours.gather import OUTLINE, Gathered, Wanted, gather
from beamcam.planning.contours.join import Shape, join, nest
from beamcam.planning.contours.kerf import closes, fitted, offset_shape
from beamcam.planning.contours.leads import Leads
from beamcam.planning.contours.order import order
from beamcam.planning.contours.repeats import without_repeats
from beamcam.planning.contours.way import (
    begun,
    bridged,
    is_turned,
    reversed_chain,
    waste_side,
)

SHEET_CODES = ("B",)
SHOWN_OPEN = 10  #: open contours are named one by one up to so many


def plan_sheet(parts: Sequence[Part], machine: Machine, skips: Collection[str] = ()) -> SheetPlan:
    """The work that makes one part, or a drawing of many, from a sheet.

    `skips` names what may be left out (`planning.SKIP_NAMES`). Raises PlanError with everything
    that the machine cannot make; nothing is left out that is not in the plan's outcomes.
    """
    torch = machine.torch
    if torch is None:
        raise TypeError(f"{machine.name} has no torch")
    if len(parts) != 1:
        source = parts[0].source if parts else Source(machine.name)
        raise PlanError(rules.SHEETS.at(source, found=len(parts)))
    (part,) = parts
    if part.profile.code not in SHEET_CODES:
        raise PlanError(
            bar_rules.STOCK.at(
                part.source,
                found=part.profile.code,
                machine=machine.name,
                expected=", ".join(SHEET_CODES),
            )
        )
    gathered = gather(part, torch, machine.name, skips)
    material = _Material(part, torch)
    refusals = [*gathered.refusals, *material.refusals({w.process for w in gathered.wanted})]
    if refusals:
        raise PlanError(refusals)
    if not gathered.wanted:
        raise PlanError(_nothing(part, gathered))
    remarks = [*material.remarks, *gathered.remarks]
    shift = _shift(gathered, torch)
    wanted, stands, said = without_repeats(gathered.wanted)
    remarks += said
    shapes, said = join(_moved(wanted, shift), torch)
    remarks += said
    shapes, crossing = nest(shapes, torch.tolerance / 4)
    if crossing and torch.kerf_by != "none":
        raise PlanError(crossing)
    operations, said = _operations(shapes, material, torch)
    remarks += said
    if errors_in(remarks):
        raise PlanError(errors_in(remarks))
    _refuse_size(operations, part, torch)
    piece = Piece(part, 0.0)
    outcomes = tuple(_outcomes(part, gathered, stands, operations))
    if part.quantity > 1:
        remarks.append(bar_rules.QUANTITY.at(part.source, found=part.quantity, made=1))
    plan = SheetPlan(
        part.profile, (piece,), shift, material.thickness, operations, outcomes, tuple(remarks)
    )
    _balance(plan, gathered)
    return plan


class _Material:
    """The sheet's material and thickness, and the machine's row for each process on it."""

    def __init__(self, part: Part, torch: Torch) -> None:
        self.thickness = part.profile.web_thickness or torch.thickness
        self.material = part.grade or torch.material
        self._torch = torch
        self._source = part.source
        self.remarks: tuple[Diagnostic, ...] = ()
        if part.profile.web_thickness is None and torch.thickness:
            self.remarks = (
                rules.ASSUMED.at(part.source, found=f"{self.thickness:g}", material=self.material),
            )

    def row(self, process: TorchProcess) -> TorchRow | None:
        """The first row of the machine that fits the sheet; None if there is none."""
        for row in self._torch.rows:
            fits = fnmatchcase(self.material.upper(), row.material.upper())
            if row.process == process and fits and self.thickness <= row.up_to:
                return row
        return None

    def refusals(self, processes: set[TorchProcess]) -> list[Diagnostic]:
        """Why the sheet cannot be worked; nothing if it can."""
        if self.thickness <= 0.0:
            return [rules.NO_THICKNESS.at(self._source)]
        known = {row.process for row in self._torch.rows}
        return [
            rules.THICKNESS.at(
                self._source,
                found=f"{self.thickness:g}",
                material=self.material or "of no known material",
                process=process,
                expected=_limits(self._torch, process),
            )
            for process in sorted(processes & known)
            if self.row(process) is None
        ]


def _limits(torch: Torch, process: TorchProcess) -> str:
    """ "above 0 and at most 8 mm of acrylic, 8 mm of wood"."""
    greatest: dict[str, float] = {}
    for row in torch.rows:
        if row.process == process:
            greatest[row.material] = max(row.up_to, greatest.get(row.material, 0.0))
    limits = (f"{up_to:g} mm of {'any' if m == '*' else m}" for m, up_to in greatest.items())
    return "above 0 and at most " + ", ".join(limits)


def _nothing(part: Part, gathered: Gathered) -> Diagnostic:
    """Why there is no work, as far as the drawing says."""
    found = [f"{len(gathered.skipped)} features left out"] if gathered.skipped else []
    if part.measures is not None and part.measures.filled:
        found.append(f"{part.measures.filled_length:.1f} mm round filled shapes without a stroke")
    if part.measures is not None and part.measures.hidden:
        found.append(f"{part.measures.hidden_length:.1f} mm on hidden layers")
    return rules.NOTHING.at(part.source, found=", ".join(found) or "the sheet is empty")


def _shift(gathered: Gathered, torch: Torch) -> Point:
    """Machine coordinates of the part's x 0, y 0."""
    if torch.place == "drawn":
        return 0.0, 0.0
    box = extent(w.curve for w in gathered.wanted)
    if box is None:
        raise AssertionError("nothing to cut was let through")
    return torch.margin - box[0], torch.margin - box[1]


def _moved(wanted: Sequence[Wanted], shift: Point) -> list[Wanted]:
    matrix: Matrix = ((1.0, 0.0, shift[0]), (0.0, 1.0, shift[1]))
    return [replace(w, curve=_shifted(w.curve, shift, matrix)) for w in wanted]


def _shifted(curve: Curve, shift: Point, matrix: Matrix) -> Curve:
    """As `transformed`, quicker and without rounding of angles for what drawings have most."""
    dx, dy = shift
    if isinstance(curve, Line):
        (x0, y0), (x1, y1) = curve.start, curve.end
        return Line((x0 + dx, y0 + dy), (x1 + dx, y1 + dy))
    if isinstance(curve, Arc):
        return replace(curve, centre=(curve.centre[0] + dx, curve.centre[1] + dy))
    return curve.transformed(matrix)


def _operations(
    shapes: Sequence[Shape], material: _Material, torch: Torch
) -> tuple[tuple[ContourOp, ...], list[Diagnostic]]:
    """The contours in order of work, each with its ways in and out, and what is to be said."""
    said: list[Diagnostic] = []
    compensated: list[Shape] = []
    moved_by: list[float] = []
    for shape in shapes:
        row = material.row(shape.process)
        kerf = row.kerf if row is not None and shape.process == "cut" else 0.0
        if torch.kerf_by == "none":
            kerf = 0.0
        if kerf and closes(shape) and torch.kerf_by == "offset":
            rings, refused = offset_shape(shape, kerf, torch.tolerance)
            if refused is not None:
                said.append(refused)
            compensated += rings
            moved_by += [kerf] * len(rings)
        else:
            compensated.append(shape)
            moved_by.append(kerf if closes(shape) else 0.0)
    if errors_in(said):
        return (), said
    said += _open_cuts(shapes)
    if len(compensated) != len(shapes):
        raise AssertionError("every contour has one way")
    ready = [_simple(shape, torch) for shape in compensated]
    tour = order(ready)
    ways: list[tuple[Shape, float]] = []
    here: Point = (0.0, 0.0)
    for index, turned in tour:
        shape = ready[index]
        if shape.closed:
            if shape.process == "cut" and is_turned(shape.area, shape.depth % 2 == 1, torch):
                shape = replace(shape, curves=reversed_chain(shape.curves), area=-shape.area)
            shape = replace(shape, curves=begun(shape.curves, torch, here))
        elif turned:
            shape = replace(shape, curves=reversed_chain(shape.curves))
        ways.append((shape, moved_by[index]))
        here = shape.curves[-1].end
    if not ways:
        raise AssertionError("a tour without contours")
    beside = max(moved_by, default=0.0) / 2 if torch.kerf_by == "offset" else 0.0
    leads = Leads([shape for shape, _ in ways], torch, beside, shapes)
    said += leads.remarks
    found = []
    short = 0
    for k, (shape, kerf) in enumerate(ways):
        operation, is_short = _operation(shape, kerf, material, torch, leads.of(k))
        short += is_short
        found.append(operation)
    if torch.kerf_by == "machine":
        said += (
            rules.NEEDS_LEAD.at(op.source, found=f"{op.kerf:g}")
            for op in found
            if op.side != "on" and sum(c.length for c in op.passes[0].lead_in) <= op.kerf / 2
        )
    if short:
        said.append(rules.NO_TABS.at(ways[0][0].source, count=short, found=torch.tabs))
    return tuple(found), said


def _simple(shape: Shape, torch: Torch) -> Shape:
    """The shape as lines and arcs if the controller is to keep off it, else as it is."""
    if torch.kerf_by == "machine" and shape.process == "cut" and shape.closed:
        return replace(shape, curves=fitted(shape.curves, torch.tolerance))
    return shape


def _operation(
    shape: Shape,
    kerf: float,
    material: _Material,
    torch: Torch,
    lead: tuple[tuple[Curve, ...], tuple[Curve, ...]],
) -> tuple[ContourOp, bool]:
    """The operation of one contour, and whether it got fewer bridges than the machine wants."""
    row = material.row(shape.process)
    if row is None:
        raise AssertionError("a process without a row was let through")
    side: Literal["on", "left", "right"] = "on"
    wants_tabs = shape.process == "cut" and closes(shape) and shape.depth % 2 == 0
    stretches = [shape.curves]
    if torch.tabs and wants_tabs:
        stretches = list(bridged(shape.curves, torch.tabs, torch.tab_width + kerf))
    if torch.kerf_by == "machine" and kerf:
        side = "left" if waste_side(shape.area, shape.depth % 2 == 1) > 0 else "right"
    passes = tuple(
        Pass(
            lead[0] if k == 0 else (),
            tuple(curves),
            lead[1] if k == len(stretches) - 1 else (),
        )
        for k, curves in enumerate(stretches)
    )
    features = tuple([(0, f) for f in shape.features if f != OUTLINE])
    operation = ContourOp(
        row,
        passes,
        shape.closed,
        shape.depth,
        side,
        kerf,
        features,
        shape.source,
    )
    short = bool(torch.tabs and wants_tabs and len(stretches) != torch.tabs + 1)
    return operation, short


def _open_cuts(shapes: Sequence[Shape]) -> Iterator[Diagnostic]:
    opened = [s for s in shapes if s.process == "cut" and not s.closed]
    for shape in opened[:SHOWN_OPEN]:
        (x0, y0), (x1, y1) = shape.curves[0].start, shape.curves[-1].end
        yield rules.OPEN_CUT.at(
            shape.source, x0=f"{x0:.3f}", y0=f"{y0:.3f}", x1=f"{x1:.3f}", y1=f"{y1:.3f}"
        )
    if len(opened) > SHOWN_OPEN:
        more = opened[SHOWN_OPEN]
        yield rules.MORE_OPEN.at(more.source, found=len(opened) - SHOWN_OPEN)


def _refuse_size(operations: Sequence[ContourOp], part: Part, torch: Torch) -> None:
    """Raise PlanError if the head would have to leave the work area."""
    curves = [
        c for op in operations for p in op.passes for c in (*p.lead_in, *p.curves, *p.lead_out)
    ]
    box = _hull(curves)
    slack = torch.tolerance
    if box[2] - box[0] > torch.length + slack or box[3] - box[1] > torch.width + slack:
        raise PlanError(
            rules.SHEET_SIZE.at(
                part.source,
                found=f"{box[2] - box[0]:.1f} x {box[3] - box[1]:.1f}",
                expected=f"{torch.length:g} x {torch.width:g}",
            )
        )
    if min(box[:2]) < -slack or box[2] > torch.length + slack or box[3] > torch.width + slack:
        x0, y0, x1, y1 = (f"{v:.1f}" for v in box)
        raise PlanError(
            rules.SHEET_PLACE.at(
                part.source, x0=x0, y0=y0, x1=x1, y1=y1,
                length=f"{torch.length:g}", width=f"{torch.width:g}",
            )
        )  # fmt: skip


def _hull(curves: Sequence[Curve]) -> tuple[float, float, float, float]:
    box = extent(curves)
    if box is None:
        raise AssertionError("a plan without curves")
    return box


def _outcomes(
    part: Part, gathered: Gathered, stands: dict[int, int], operations: Sequence[ContourOp]
) -> Iterator[Outcome]:
    """What becomes of each feature, in their order."""
    made = {feature: op.row.process for op in operations for _, feature in op.features}
    for index in range(len(part.features)):
        if index in made:
            yield Outcome((0, index), "made", made[index])
        elif index in gathered.skipped:
            yield Outcome((0, index), "skipped", gathered.skipped[index])
        elif index in stands:
            yield Outcome((0, index), "duplicate", rules.OVERLAP.code)


def _balance(plan: SheetPlan, gathered: Gathered) -> None:
    """Raise AssertionError unless every feature has exactly one outcome."""
    features = plan.pieces[0].part.features
    if [o.feature for o in plan.outcomes] != [(0, f) for f in range(len(features))]:
        raise AssertionError("the ledger of the plan does not balance")
