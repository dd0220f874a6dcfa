"""Several parts on one sheet, in the order given: in rows by their boxes.

margin | part | spacing | part | spacing | part | margin      the first row at the bottom
"""

from collections.abc import Collection, Sequence
from typing import NamedTuple

from msgspec.structs import replace

from beamcam.errors import PlanError, Source
from beamcam.geometry.arrays import CurveTable
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Box, Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch
from beamcam.model.part import Contour, Feature, Measures, Part, moved_feature
from beamcam.model.plan import SKELETON
from beamcam.model.request import Request
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import OUTLINE, assign_processes
from beamcam.planning.contours.outline import outline_of
from beamcam.planning.contours.plate import SheetMaterial, spaced

THICKNESS_SLACK = 0.01  #: mm that parts of one sheet may differ by

FeatureOf = tuple[int, int]  #: which part, and which of its features


class LaidSheet(NamedTuple):
    """The parts of a sheet as one part."""

    whole: Part
    places: tuple[Point, ...]  #: position of each part's x 0, y 0 on the table
    origins: tuple[FeatureOf, ...]  #: of each feature of the whole


def places_of(parts: Sequence[Part], machine: Machine, skips: Collection[str]) -> tuple[Point, ...]:
    """Position of x 0, y 0 of each part, for as many parts as the sheet holds."""
    torch = spaced(parts[0], _torch(machine)) if parts else _torch(machine)
    points: list[Point] = []
    at_x = at_y = torch.margin
    row = 0.0  #: height of the row that is filled
    boxes: dict[int, Box] = {}  #: by the identity of the part, of which there may be many copies
    for part in parts:
        if id(part) not in boxes:
            boxes[id(part)] = _box(part, machine, skips)
        x0, y0, x1, y1 = boxes[id(part)]
        if at_x + x1 - x0 > torch.length - torch.margin and row:
            at_x, at_y, row = torch.margin, at_y + row + torch.spacing, 0.0
        if at_x + x1 - x0 > torch.length - torch.margin:
            break
        if at_y + y1 - y0 > torch.width - torch.margin:
            break
        points.append((at_x - x0, at_y - y0))
        at_x, row = at_x + x1 - x0 + torch.spacing, max(row, y1 - y0)
    return tuple(points)


def _box(part: Part, machine: Machine, skips: Collection[str]) -> Box:
    """The box around what is cut and marked of a part."""
    curves = [one.curve for one in assign_processes(part, _torch(machine), machine, skips).curves]
    return CurveTable(curves).box or (0.0, 0.0, 0.0, 0.0)


def laid_out(parts: Sequence[Part], machine: Machine, skips: Collection[str]) -> LaidSheet:
    """The parts of one sheet. Raises PlanError if it is not one for all, or too small for them."""
    first, torch = parts[0], _torch(machine)
    for part in parts[1:]:
        if _sheet_of(part, torch) != _sheet_of(first, torch):
            found, expected = (
                f"{t:g} mm {g}".rstrip() for t, g in (_sheet_of(p, torch) for p in (part, first))
            )
            raise PlanError(rules.MIXED.at(part.source, found=found, expected=expected))
    places = places_of(parts, machine, skips)
    if len(places) < len(parts):
        size = f"{torch.length:g} x {torch.width:g}"
        first_out = parts[len(places)].source
        raise PlanError(
            rules.SHEET_FULL.at(first_out, found=len(parts), fits=len(places), size=size)
        )
    features: list[Feature] = []
    origins: list[FeatureOf] = []
    for k, (part, place) in enumerate(zip(parts, places, strict=True)):
        own: list[tuple[int, Feature]] = [*enumerate(part.features)]
        if curves := outline_of(part):  # of a plate that has no contour of its own
            own.append((OUTLINE, Contour("v", "outer", curves, part.source)))
        origins += [(k, index) for index, _ in own]
        features += [moved_feature(feature, place) for _, feature in own]
    if torch.skeleton_cuts:
        # From edge to edge of the sheet, in the middle between two rows and behind the last; none
        # where there is no room for one between the kerfs of both rows.
        torch = spaced(first, torch)
        kerf = 0.0 if torch.kerf_by == "none" else SheetMaterial(first, torch).kerf("cut")
        rows: dict[float, float] = {}  #: the top of each row, by its bottom
        for part, (_, y) in zip(parts, places, strict=True):
            _, y0, _, y1 = _box(part, machine, skips)
            bottom = round(y + y0, 6)
            rows[bottom] = max(rows.get(bottom, 0.0), y + y1)
        source = Source(first.source.file, where=SKELETON)
        for top in rows.values() if torch.spacing > 2 * kerf else ():
            y = top + torch.spacing / 2
            if y < torch.width - torch.margin / 2:
                line = Line((0.0, y), (torch.length, y))
                features.append(Contour("v", "open", (line,), source, closed=False))
                origins.append((0, OUTLINE))
    whole = replace(
        first, features=tuple(features), measures=Measures(), quantity=1, length=torch.length
    )
    return LaidSheet(whole, places, tuple(origins))


def sheet_shares(request: Request, pieces: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """The pieces that lie on each sheet, in the order given; each by the place of its part."""
    machine, parts = request.machine, request.parts
    torch = _torch(machine)
    shares: list[tuple[int, ...]] = []
    sheets = [_sheet_of(parts[place], torch) for place in pieces]
    at = 0
    while at < len(pieces):
        same = next((k for k in range(at, len(pieces)) if sheets[k] != sheets[at]), len(pieces))
        alike = [parts[place] for place in pieces[at:same]]
        count = 1
        if len(alike) > 1 and all(part.profile.code == "B" for part in alike):
            # A part that fits beside no other is planned by itself, and refused as it is.
            count = max(len(places_of(alike, machine, request.skips)), 1)
        shares.append(tuple(pieces[at : at + count]))
        at += count
    return tuple(shares)


def _sheet_of(part: Part, torch: Torch) -> tuple[float, str]:
    own = part.profile.web_thickness
    thickness = own if own is not None else torch.thickness or 0.0
    return round(thickness / THICKNESS_SLACK) * THICKNESS_SLACK, part.grade or torch.material


def _torch(machine: Machine) -> Torch:
    return machine.needed(machine.torch, "torch")
