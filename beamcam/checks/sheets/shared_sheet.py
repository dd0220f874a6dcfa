"""Parts that share a sheet, each at the place where the machine lays it, as one part to compare.

Where each lies follows from the parts in the order given and the machine's table alone: in rows
from the lower left corner, `margin` to the edges and `spacing` from box to box.
"""

from collections.abc import Collection, Iterator, Sequence

from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.asked_sheet import between, kerf_on, thickness_of
from beamcam.checks.sheets.need import OUTLINE, Need, need_of
from beamcam.checks.sheets.plates import beside_faults, header_outline, skew_ends
from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Box, Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, material_said
from beamcam.model.part import Contour, Feature, Measures, Part, extent, moved_feature

SKELETON = "skeleton"  #: where the cuts through what is left of a sheet are said to be


class SharedSheet(Struct, frozen=True):
    """One part with all that has to be on a sheet, and the machine that leaves it there."""

    part: Part
    machine: Machine
    places: list[Point]  #: of the x 0, y 0 of each of several parts
    diagnostics: list[Diagnostic]


def as_one(parts: Sequence[Part], machine: Machine, skips: Collection[str]) -> SharedSheet:
    """The parts of a sheet as one, and what is wrong with their sharing it.

    A part that is alone stays as it is.
    """
    torch = machine.torch
    off = [*skew_ends(parts, machine), *beside_faults(parts)]
    if torch is None or len(parts) == 1:
        return SharedSheet(parts[0], machine, [], off)
    features: list[Feature] = []
    sheet = _sheet_shown(parts[0], torch)
    diagnostics = off + [
        rules.OTHER_SHEET.at(part.source, found=own, expected=sheet)
        for part in parts[1:]
        if (own := _sheet_shown(part, torch)) != sheet
    ]
    tops: dict[float, float] = {}  #: upper edge of each row of parts, by its lower one
    lie = list(_places(parts, machine, torch, skips))
    for part, (here, need) in zip(parts, lie, strict=True):
        _, low, _, high = _box(need)
        row = round(here[1] + low, 6)
        tops[row] = max(tops.get(row, row), here[1] + high)
        features += [moved_feature(feature, here) for feature in part.features]
        if any(OUTLINE in some for some in need.features.values()):
            outline = Contour("v", "outer", tuple(header_outline(part)), part.source)
            features.append(moved_feature(outline, here))
    half = between(parts[0], torch) / 2
    if torch.skeleton_cuts and half > kerf_on(parts[0], torch):
        for y in (t + half for t in tops.values() if t + half < torch.width - torch.margin / 2):
            line = Line((torch.length, y), (0.0, y))
            source = replace(parts[0].source, where=SKELETON, line=None)
            features.append(Contour("v", "open", (line,), source, closed=False))
    whole = replace(parts[0], features=tuple(features), measures=Measures(), length=torch.length)
    machine = replace(machine, torch=replace(torch, place="drawn"))
    return SharedSheet(whole, machine, [place for place, _ in lie], diagnostics)


def _places(
    parts: Sequence[Part], machine: Machine, torch: Torch, skips: Collection[str]
) -> Iterator[tuple[Point, Need]]:
    """Where each of several parts lies on the table, its x 0, y 0; and what of it has to be cut."""
    left = bottom = torch.margin
    spacing = between(parts[0], torch)
    top = bottom
    needs: dict[int, Need] = {}  #: many are the same part
    for part in parts:
        if id(part) not in needs:
            needs[id(part)] = need_of(part, machine, torch, skips)
        need = needs[id(part)]
        x0, y0, x1, y1 = _box(need)
        if left + (x1 - x0) > torch.length - torch.margin and top > bottom:
            left, bottom = torch.margin, top + spacing
            top = bottom
        yield (left - x0, bottom - y0), need
        left, top = left + (x1 - x0) + spacing, max(top, bottom + (y1 - y0))


def _box(need: Need) -> Box:
    return extent(c for some in need.curves.values() for c in some) or (0.0, 0.0, 0.0, 0.0)


def _sheet_shown(part: Part, torch: Torch) -> str:
    material = material_said(part.grade, torch.material)
    return f"{thickness_of(part, torch):.2f} mm {material}".rstrip()
