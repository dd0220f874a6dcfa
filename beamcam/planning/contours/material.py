"""The sheet's material and thickness, and how the machine works it."""

from collections.abc import Iterator

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.machine.coper import Coper
from beamcam.machine.load import load, shipped
from beamcam.machine.tables import HeightAxis
from beamcam.machine.torch import (
    Torch,
    TorchProcess,
    TorchRow,
    is_row_for,
    material_of,
    material_said,
)
from beamcam.model.part import Part
from beamcam.planning.contours import rules


def is_same(material: str, grade: str) -> bool:
    """Whether a requested material may be the one that a part's grade names."""
    return material_of(material) == material_of(grade)


def between_rows(torch: Torch | Coper, row: TorchRow, thickness: float) -> TorchRow:
    """A row as steel is worked with it: at its own feed, or at one between two rows.

    Where the machine's file interpolates, the feed lies on a straight line between the rows of the
    chart that differ in nothing but their thickness; below the thinnest it is that row's.
    """
    if torch.between_rows == "row above":
        return row
    import numpy as np

    chart = sorted(
        (other.up_to, other.feed_mm_min)
        for other in torch.rows
        if _chart_of(other) == _chart_of(row)
    )
    limits, feeds = zip(*chart, strict=True)
    return replace(row, feed_mm_min=float(np.interp(thickness, limits, feeds)))


def _chart_of(row: TorchRow) -> tuple[object, ...]:
    return row.process, row.material, row.amps, row.nozzle


def _shipped_torches() -> Iterator[tuple[str, Torch]]:
    for machine in map(load, shipped()):
        if machine.torch is not None:
            yield machine.name, machine.torch


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
            row = next(filter(self._fits, self._rows_of(process)), None)
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

    def _rows_of(self, process: TorchProcess) -> list[TorchRow]:
        return [row for row in self._torch.rows if row.process == process]

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
        return [
            rules.THICKNESS.at(
                self._source,
                found=f"{self.thickness:g}",
                material=self.material or "of no known material",
                process=process,
                expected=self._limits(process),
                others=self._others(process),
            )
            for process in sorted(processes & known)
            if self.row(process) is None
        ]

    def unlifted(self, processes: set[TorchProcess], z: HeightAxis) -> list[Diagnostic]:
        """Why the torch cannot be lifted over the sheet; nothing if it can."""
        diagnostics = [
            rules.TORCH_HEIGHT.at(
                self._source, key=key, process=process, up_to=f"{row.up_to:g}", axis=z.axis
            )
            for process in sorted(processes)
            if (row := self.row(process)) is not None
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
            name for name, torch in _shipped_torches()
            if any(row.process == process and self._fits(row) for row in torch.rows)
        ]  # fmt: skip
        if not able or self.thickness <= 0.0:
            return "no shipped machine does; [[torch.more_rows]] in a file of your own adds a row"
        return f"--machine {' or '.join(able)} can"

    def _limits(self, process: TorchProcess) -> str:
        """ "above 0 and at most 8 mm of acrylic, 8 mm of wood"."""
        greatest: dict[str, float] = {}
        for row in self._rows_of(process):
            greatest[row.material] = max(row.up_to, greatest.get(row.material, 0.0))
        limits = (f"{up_to:g} mm of {'any' if m == '*' else m}" for m, up_to in greatest.items())
        return "above 0 and at most " + ", ".join(limits)
