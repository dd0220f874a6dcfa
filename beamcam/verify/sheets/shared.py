"""Parts that share a sheet, each at the place where the machine lays it, as one part to compare.

Where each lies follows from the parts in the order given and the machine's table alone: in rows
from the lower left corner, `margin` to the edges and `spacing` from box to box.
"""

from collections.abc import Collection, Iterator, Sequence

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.materials import material_said
from beamcam.machine.torch import Torch
from beamcam.model.drawing import Measures, extent
from beamcam.model.moved import moved_feature
from beamcam.model.part import Contour, Feature, Part
from beamcam.verify.head import head_of, part_faults, stock_faults
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.asked_layout import between
from beamcam.verify.sheets.need import (
    OUTLINE,
    Need,
    need_of,
    rows_on,
    shift_of,
    thickness_of,
)

SKELETON = "skeleton"  #: where the cuts through what is left of a sheet are said to be


def as_one(
    parts: Sequence[Part], machine: Machine, skips: Collection[str]
) -> tuple[Part, Machine, list[Diagnostic]]:
    """One part with all that has to be on the sheet, the machine that leaves it there, and faults.

    A part that is alone stays as it is.
    """
    torch = machine.torch
    if torch is None or len(parts) == 1:
        return parts[0], machine, []
    features: list[Feature] = []
    said = [
        rules.OTHER_SHEET.at(
            part.source, found=_shown(part, torch), expected=_shown(parts[0], torch)
        )
        for part in parts[1:] if _shown(part, torch) != _shown(parts[0], torch)
    ]  # fmt: skip
    tops: dict[float, float] = {}  #: upper edge of each row of parts, by its lower one
    for part, (here, need) in zip(parts, places_of(parts, machine, torch, skips), strict=True):
        _, low, _, high = _box(need)
        row = round(here[1] + low, 6)
        tops[row] = max(tops.get(row, row), here[1] + high)
        features += [moved_feature(feature, here) for feature in part.features]
        features += [
            moved_feature(Contour("v", "outer", tuple(curves), part.source), here)
            for process, some in need.curves.items()
            if (curves := [c for c, f in zip(some, need.features[process], strict=True)
                           if f == OUTLINE])
        ]  # fmt: skip
    half = between(parts[0], torch) / 2
    if torch.skeleton_cuts and half > _kerf(parts[0], torch):
        for y in (t + half for t in tops.values() if t + half < torch.width - torch.margin / 2):
            line = Line((torch.length, y), (0.0, y))
            source = replace(parts[0].source, where=SKELETON, line=None)
            features.append(Contour("v", "open", (line,), source, closed=False))
    whole = replace(parts[0], features=tuple(features), measures=Measures(), length=torch.length)
    return whole, replace(machine, torch=replace(torch, place="drawn")), said


def places_of(
    parts: Sequence[Part], machine: Machine, torch: Torch, skips: Collection[str]
) -> Iterator[tuple[Point, Need]]:
    """Where each of several parts lies on the table, its x 0, y 0; and what of it has to be cut."""
    left = bottom = torch.margin
    spacing = between(parts[0], torch)
    top = bottom
    for part in parts:
        need = need_of(part, machine, torch, skips)
        x0, y0, x1, y1 = _box(need)
        if left + (x1 - x0) > torch.length - torch.margin and top > bottom:
            left, bottom = torch.margin, top + spacing
            top = bottom
        yield (left - x0, bottom - y0), need
        left, top = left + (x1 - x0) + spacing, max(top, bottom + (y1 - y0))


def _box(need: Need) -> tuple[float, float, float, float]:
    return extent(c for some in need.curves.values() for c in some) or (0.0, 0.0, 0.0, 0.0)


def told_faults(
    text: str, parts: Sequence[Part], machine: Machine, skips: Collection[str], name: str
) -> Iterator[Diagnostic]:
    """All differences of the head that `text` begins with from the parts as they have to lie."""
    head = head_of(text)
    if head is None or machine.torch is None:
        return
    yield from stock_faults(
        head, parts, float(thickness_of(parts[0], machine.torch)), machine, name
    )
    if len(parts) == 1:
        need = need_of(parts[0], machine, machine.torch, skips)
        places: list[tuple[float, ...]] = [shift_of(need, machine.torch)]
        if not need.curves and head.parts:  # texts alone are found wherever the program has them
            places = [head.parts[0].at]
    else:
        places = [place for place, _ in places_of(parts, machine, machine.torch, skips)]
    lie = [*zip(parts, places, strict=True)]
    yield from part_faults(head, lie, machine.torch.tolerance, False, name)


def _kerf(part: Part, torch: Torch) -> float:
    taken = [row.kerf for row in rows_on(part, torch) if row.process == "cut"]
    return taken[0] if taken and torch.kerf_by != "none" else 0.0


def _shown(part: Part, torch: Torch) -> str:
    return (
        f"{thickness_of(part, torch):.2f} mm {material_said(part.grade, torch.material)}".rstrip()
    )
