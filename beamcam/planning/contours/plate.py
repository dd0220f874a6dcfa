"""The plate: its material and thickness, the machine's rows for it, where it lies on the table."""

from collections.abc import Iterator, Sequence
from itertools import product
from math import dist
from typing import Literal

from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError
from beamcam.geometry.plane import Box, Point
from beamcam.machine.coper import Coper
from beamcam.machine.load import load, shipped
from beamcam.machine.tables import HeightAxis
from beamcam.machine.torch import (
    ORIGINS,
    Torch,
    TorchProcess,
    TorchRow,
    is_row_for,
    material_said,
)
from beamcam.model.colour import key_of
from beamcam.model.hatch import hatched, not_filled
from beamcam.model.part import Contour, Part, extent, moved_curve
from beamcam.model.plan import ContourOp
from beamcam.planning.contours import rules
from beamcam.planning.contours.layout import cannot_lie, laid_out, size_of, spread
from beamcam.planning.contours.outline import Shape, reach_of, reached_curves, with_outline


def shift_of(box: Box, torch: Torch) -> Point:
    """Machine coordinates of the part's x 0, y 0, by the box of its work."""
    if torch.place == "drawn" and torch.origin == "table":
        return 0.0, 0.0
    if torch.origin in ORIGINS:
        (u, v), (x0, y0, x1, y1) = ORIGINS[torch.origin], box
        return -x0 - u * (x1 - x0), -y0 - v * (y1 - y0)
    return torch.margin - box[0], torch.margin - box[1]


def moved(shapes: Sequence[Shape], shift: Point) -> list[Shape]:
    """The shapes in machine coordinates."""
    if shift == (0.0, 0.0):
        return list(shapes)
    return [
        replace(shape, curves=tuple([moved_curve(c, shift) for c in shape.curves]))
        for shape in shapes
    ]


def refuse_large(box: Box, part: Part, torch: Torch, slack: float) -> None:
    """Raises PlanError if the box of the work is larger than the area; kerf and leads add to it.

    Asked first, because what a damaged file holds may be as large as a planet and take hours.
    """
    length, width = box[2] - box[0], box[3] - box[1]
    if length > torch.length + slack or width > torch.width + slack:
        raise PlanError(_too_large(length, width, part, torch))


def _too_large(length: float, width: float, part: Part, torch: Torch) -> Diagnostic:
    found, expected = f"{length:.1f} x {width:.1f}", f"{torch.length:g} x {torch.width:g}"
    return rules.SHEET_SIZE.at(part.source, found=found, expected=expected)


def worked_box(operations: Sequence[ContourOp], overscan: float = 0.0) -> Box:
    """The box around all that the tool does, leads included, and round hatches their overscan."""
    passes = [one for op in operations for one in op.passes]
    ways = [way for p in passes for way in (p.lead_in, p.curves, p.lead_out)]
    box = extent(curve for way in ways for curve in way)
    assert box is not None
    beyond = [
        point
        for op in operations
        if overscan and op.is_hatch
        for (x0, y0), (x1, y1) in ((op.start, op.end),)
        for k in (overscan / (dist(op.start, op.end) or 1.0),)
        for point in ((x0 - k * (x1 - x0), y0 - k * (y1 - y0)),
                      (x1 + k * (x1 - x0), y1 + k * (y1 - y0)))
    ]  # fmt: skip
    xs, ys = [x for x, _ in beyond], [y for _, y in beyond]
    return (min([box[0], *xs]), min([box[1], *ys]), max([box[2], *xs]), max([box[3], *ys]))


def refuse_size(operations: Sequence[ContourOp], part: Part, torch: Torch) -> None:
    """Raises PlanError if the head would have to leave the work area."""
    low_x, low_y, high_x, high_y = torch.area
    box = worked_box(operations, torch.overscan)
    slack = torch.tolerance
    refuse_large(box, part, torch, slack)
    if (
        box[0] < low_x - slack or box[1] < low_y - slack
        or box[2] > high_x + slack or box[3] > high_y + slack
    ):  # fmt: skip
        places = {name: f"{v:.1f}" for name, v in zip(("x0", "y0", "x1", "y1"), box, strict=True)}
        area = {"length": f"{torch.length:g}", "width": f"{torch.width:g}"}
        raise PlanError(rules.SHEET_PLACE.at(part.source, **places, **area))


NOISE_DEG = 1.0  #: of an angle in a header; less is noise of its writer
QUARTER = 90.0  #: degrees by which a part is turned that fits so only


def is_laid_otherwise(torch: Torch) -> bool:
    """Whether a part is moved from its drawn position, or repeated."""
    return bool(torch.mirror != "none" or torch.rotate or torch.copies != (1, 1))


def laid(parts: tuple[Part, ...], torch: Torch | None) -> tuple[tuple[Part, ...], list[Diagnostic]]:
    """Parts of a sheet as the job wants them: mirrored, turned, copied, and hatched; and notes.

    One that fits turned only is turned, those of a drawing may be moved apart. Raises PlanError
    for a feature that cannot be laid so, a sheet that is too small, or a hatch that fills nothing.
    """
    if torch is None:
        return parts, []
    notes: list[Diagnostic] = []
    if len(parts) == 1:
        part, notes = apart(parts[0], torch)
        parts = (part,)
    torch = spaced(parts[0], torch) if parts else torch
    if fits_turned(parts, torch):
        torch = replace(torch, rotate=QUARTER)
        x0, y0, x1, y1 = reach_of(with_outline(parts[0]))
        found, expected = f"{x1 - x0:.1f} x {y1 - y0:.1f}", f"{torch.length:g} x {torch.width:g}"
        notes = [*notes, rules.TURNED.at(parts[0].source, found=found, expected=expected)]
    if not (torch.settings or is_laid_otherwise(torch)):
        return parts, notes
    diagnostics: list[Diagnostic] = []
    if is_laid_otherwise(torch):
        diagnostics += [
            rules.LAYOUT.at(source, found=what)
            for part in parts
            for source, what in cannot_lie(part, torch)
        ]
        for part in () if diagnostics else parts:
            length, width = size_of(part, torch)
            if length > torch.length + torch.gap or width > torch.width + torch.gap:
                diagnostics.append(_too_large(length, width, part, torch))
        if diagnostics:
            raise PlanError(diagnostics)
        parts = tuple([laid_out(part, torch) for part in parts])
    diagnostics += [
        rules.HATCH.at(part.source, key=key, found=what)
        for part in parts
        for key, what in not_filled(part, torch)
    ]
    if diagnostics:
        raise PlanError(diagnostics)
    return tuple([hatched(part, torch) for part in parts]), notes


def apart(part: Part, torch: Torch) -> tuple[Part, list[Diagnostic]]:
    """A drawing for common cuts with its parts a kerf apart where they touch, and a note."""
    if not torch.common_cuts or torch.kerf_by == "none":
        return part, []
    return spread(part, torch, SheetMaterial(part, torch).kerf("cut"))


def spaced(part: Part, torch: Torch) -> Torch:
    """The torch with the spacing of its parts: for common cuts that is the kerf of the sheet."""
    if not torch.common_cuts:
        return torch
    kerf = 0.0 if torch.kerf_by == "none" else SheetMaterial(part, torch).kerf("cut")
    return replace(torch, spacing=kerf)


def fits_turned(parts: Sequence[Part], torch: Torch) -> bool:
    """Whether one part is too large for the sheet as it is drawn, and not if it is turned by 90
    degrees. What is asked for as it is drawn, or laid by an option, stays as it is."""
    if len(parts) != 1 or is_laid_otherwise(torch):
        return False
    if torch.place == "drawn" and torch.origin == "table":
        return False
    (part,) = parts
    ignored = {key for key, meaning in torch.colours.items() if meaning == "ignore"}
    box = extent(
        curve
        for feature in with_outline(part).features
        if not (ignored and isinstance(feature, Contour)
                and key_of(feature, torch.colours) in ignored)
        for curve in reached_curves(feature)
    )  # fmt: skip
    if box is None:
        return False
    length, width = box[2] - box[0], box[3] - box[1]
    long, wide = torch.length + torch.gap, torch.width + torch.gap
    if (length <= long and width <= wide) or width > long or length > wide:
        return False
    return next(cannot_lie(part, torch), None) is None


def outermost(part: Part, thickness: float) -> Iterator[tuple[float, float, float]]:
    """The corners of the box of a plate, by its outline or its header."""
    outer = [curve for one in part.contours if one.kind == "outer" for curve in one.curves]
    x0, y0, x1, y1 = extent(outer) or (0.0, 0.0, part.length, part.profile.height)
    return product((x0, x1), (y0, y1), (0.0, thickness))


def skew_ends(part: Part, torch: Torch) -> Iterator[Diagnostic]:
    """An error for each end of a plate that the header has skew through the thickness, unless
    bevels of an outline say edge by edge what is: see `plate_edges.with_bevels`."""
    if any(contour.bevels for contour in part.contours):
        return
    cuts, least = part.cuts, max(torch.min_bevel, NOISE_DEG)
    ends: tuple[tuple[Literal["start", "end"], float], ...] = (
        ("start", cuts.flange_start), ("end", cuts.flange_end),
    )  # fmt: skip
    for end, angle in ends:
        if abs(angle) >= least:
            yield rules.SKEW_END.at(part.cut_source("flange", end), end=end, found=f"{angle:g}")


def between_rows(torch: Torch | Coper, row: TorchRow, thickness: float) -> TorchRow:
    """A row as steel is worked with it: at its own feed, or at one between two rows.

    Where the machine's file interpolates, the feed lies on a straight line between the rows of the
    chart that differ in nothing but their thickness; below the thinnest it is that row's.
    """
    if torch.between_rows == "row above":
        return row
    import numpy as np

    own = (row.process, row.material, row.amps, row.nozzle)
    chart = sorted(
        (other.up_to, other.feed_mm_min)
        for other in torch.rows
        if (other.process, other.material, other.amps, other.nozzle) == own
    )
    limits, feeds = zip(*chart, strict=True)
    return replace(row, feed_mm_min=float(np.interp(thickness, limits, feeds)))


class SheetMaterial:
    """Material and thickness of a sheet, and the machine's row for each process on it."""

    def __init__(self, part: Part, torch: Torch) -> None:
        own = part.profile.web_thickness
        thickness = torch.thickness if own is None else own
        self.is_known = thickness is not None
        self.thickness = thickness or 0.0
        self.material = material_said(part.grade, torch.material)
        self._torch = torch
        self._source = part.source
        self._rows: dict[TorchProcess, TorchRow | None] = {}
        self.remarks: tuple[Diagnostic, ...] = ()
        if own is None and self.is_known:
            self.remarks = (
                rules.ASSUMED.at(part.source, found=f"{self.thickness:g}", material=self.material),
            )

    def row(self, process: TorchProcess) -> TorchRow | None:
        """The first row of the machine that fits the sheet; None if there is none."""
        if process not in self._rows:
            rows = (row for row in self._torch.rows if row.process == process)
            row = next(filter(self._fits, rows), None)
            if row is None and process == "spot" and (cut := self.row("cut")) is not None:
                row = cut.spotting()
            self._rows[process] = row and between_rows(self._torch, row, self.thickness)
        return self._rows[process]

    def row_for(self, process: TorchProcess, look: str) -> TorchRow | None:
        """`row` with the settings of a key of the table of colours."""
        row, own = self.row(process), self._torch.settings.get(look)
        if row is None or own is None:
            return row
        return replace(
            row,
            feed_mm_min=row.feed_mm_min if own.speed is None else own.speed,
            power=row.power if own.power is None else own.power,
            passes=row.passes if own.passes is None else own.passes,
        )

    def _fits(self, row: TorchRow) -> bool:
        is_material = is_row_for(row.material, self.material)
        return is_material and 0.0 < self.thickness <= row.up_to

    def kerf(self, process: TorchProcess) -> float:
        """Kerf width to compensate, by offset or machine; 0 without compensation."""
        row = self.row(process)
        if row is None or process != "cut" or self._torch.kerf_by == "none":
            return 0.0
        return row.kerf

    def refusals(self, processes: set[TorchProcess]) -> list[Diagnostic]:
        """Why the sheet cannot be worked; nothing if it can."""
        if not self.is_known:
            return [rules.NO_THICKNESS.at(self._source)]
        known = {row.process for row in self._torch.rows}
        material = self.material or "of no known material"
        return [
            rules.THICKNESS.at(
                self._source, found=f"{self.thickness:g}", material=material, process=process,
                expected=self._limits(process), others=self._others(process),
            )
            for process in sorted(processes & known) if self.row(process) is None
        ]  # fmt: skip

    def unlifted(self, processes: set[TorchProcess], z: HeightAxis) -> list[Diagnostic]:
        """Why the torch cannot be lifted over the sheet; nothing if it can."""
        rows = [(process, row) for process in sorted(processes) if (row := self.row(process))]
        diagnostics = [
            rules.TORCH_HEIGHT.at(
                self._source, key=key, process=process, up_to=f"{row.up_to:g}", axis=z.axis
            )
            for process, row in rows
            for key in ("pierce_height", "cut_height")
            if not getattr(row, key)
        ]
        most = z.home_height - z.clearance
        if self.thickness > most:
            found, expected = f"{self.thickness:g}", f"{most:g}"
            diagnostics.append(rules.HEADROOM.at(self._source, found=found, expected=expected))
        return diagnostics

    def _others(self, process: TorchProcess) -> str:
        """Which of the shipped machines work such a sheet: "plate-oxyfuel cuts it (--machine)"."""
        able = [
            machine.name for machine in map(load, shipped())
            if machine.torch is not None
            and any(row.process == process and self._fits(row) for row in machine.torch.rows)
        ]  # fmt: skip
        if not able or self.thickness <= 0.0:
            return "no shipped machine does; [[torch.more_rows]] in a file of your own adds a row"
        return f"--machine {' or '.join(able)} can"

    def _limits(self, process: TorchProcess) -> str:
        """ "above 0 and at most 8 mm of acrylic, 8 mm of wood"."""
        greatest: dict[str, float] = {}
        for row in (row for row in self._torch.rows if row.process == process):
            greatest[row.material] = max(row.up_to, greatest.get(row.material, 0.0))
        limits = (f"{up_to:g} mm of {'any' if m == '*' else m}" for m, up_to in greatest.items())
        return "above 0 and at most " + ", ".join(limits)
