"""The rows of the cut chart that may run on a part's sheet."""

from msgspec.structs import replace

from beamcam.machine.torch import Torch, TorchProcess, TorchRow, is_row_for, material_said
from beamcam.model.part import Part


def thickness_of(part: Part, torch: Torch) -> float:
    """Of the part's sheet in mm, what the machine's file takes where it does not say; 0 unknown."""
    own = part.profile.web_thickness
    return own if own is not None else torch.thickness or 0.0


def rows_of(part: Part, torch: Torch) -> list[TorchRow]:
    """The rows that may run on the part's sheet: of each process, then of colours and layers."""
    rows = rows_on(part, torch)
    looked = [
        replace(
            row,
            feed_mm_min=row.feed_mm_min if own.speed is None else own.speed,
            power=row.power if own.power is None else own.power,
            passes=row.passes if own.passes is None else own.passes,
        )
        for key, own in torch.settings.items()
        for row in rows
        if torch.colours.get(key) == row.process
    ]
    return [*rows, *looked]


def _at_feed(row: TorchRow, torch: Torch, thickness: float) -> TorchRow:
    """A row at the feed that the chart has for a thickness, where the file says it lies between."""
    if torch.between_rows != "interpolate":
        return row
    alike = [
        r for r in torch.rows
        if (r.process, r.material, r.amps, r.nozzle)
        == (row.process, row.material, row.amps, row.nozzle)
    ]  # fmt: skip
    thinner = [r for r in alike if r.up_to <= thickness]
    if not thinner or row.up_to == thickness:
        return row
    below = max(thinner, key=lambda r: r.up_to)
    share = (thickness - below.up_to) / (row.up_to - below.up_to)
    feed = below.feed_mm_min + share * (row.feed_mm_min - below.feed_mm_min)
    return replace(row, feed_mm_min=feed)


def rows_on(part: Part, torch: Torch) -> list[TorchRow]:
    """The row of each process on the part's sheet, as the machine's file has it."""
    thickness = thickness_of(part, torch)
    material = material_said(part.grade, torch.material)
    rows: dict[TorchProcess, TorchRow] = {}
    for row in torch.rows:
        if 0.0 < thickness <= row.up_to and is_row_for(row.material, material):
            rows.setdefault(row.process, _at_feed(row, torch, thickness))
    if torch.drilled == "spot" and "cut" in rows:
        rows.setdefault("spot", rows["cut"].spotting())
    return list(rows.values())
