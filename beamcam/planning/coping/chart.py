"""The rows of a coper's cut chart for the steel of a part."""

from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.machine.coper import Coper
from beamcam.machine.torch import TorchRow, is_row_for, material_said
from beamcam.model.part import Face, Part
from beamcam.planning.contours.plate import between_rows
from beamcam.planning.coping import rules


class Chart:
    """The rows of a cut chart for the steel of a part."""

    def __init__(self, part: Part, coper: Coper) -> None:
        self.material = material_said(part.grade, coper.material)
        self._rows = sorted(
            (row for row in coper.rows if is_row_for(row.material, self.material)),
            key=lambda row: row.up_to,
        )
        self.coper = coper

    @property
    def deepest(self) -> float:
        """The greatest thickness that is cut; 0 if the steel has no rows."""
        return self._rows[-1].up_to if self._rows else 0.0

    @property
    def cut_height(self) -> float:
        """The least height of the torch over the steel."""
        return min((row.cut_height for row in self._rows), default=self.coper.rows[0].cut_height)

    def row(self, thickness: float) -> TorchRow | None:
        """The first row that is deep enough; where the file interpolates, just as deep."""
        row = next((row for row in self._rows if thickness <= row.up_to + 1e-9), None)
        if row is None:
            return None
        at = between_rows(self.coper, row, thickness)
        return row if at.feed_mm_min == row.feed_mm_min else replace(at, up_to=thickness)

    def depth(self, thickness: float) -> float:
        """How deep the row for a thickness cuts; the thickness itself where there is none."""
        row = self.row(thickness)
        return row.up_to if row else thickness

    def too_thick(self, thickness: float, face: Face, source: Source) -> Diagnostic:
        """The refusal of a wall that no row cuts through."""
        known = ", ".join(sorted({row.material for row in self.coper.rows}))
        return rules.THICK.at(
            source, found=f"{thickness:.4g}", material=self.material or "steel", face=face,
            expected=f"at most {self.deepest:g} mm" if self._rows else f"what has rows: {known}",
        )  # fmt: skip
