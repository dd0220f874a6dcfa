"""Features of a plate that a torch can make, and those left for drill and grinder."""

from itertools import product
from math import hypot

from beamcam.errors import Diagnostic
from beamcam.machine.torch import Torch
from beamcam.model.part import (
    PLATE_FACES,
    Bend,
    Bevel,
    Camber,
    Contour,
    EndPlane,
    Feature,
    Hole,
    Part,
    Slot,
    TextMark,
    extent,
)
from beamcam.planning import rules as bar_rules

BESIDE = 0.1  #: mm that a plane may lie inside of the edge that it states once more


def min_hole(torch: Torch, thickness: float) -> float:
    """The smallest hole that can be cut into a sheet, and the narrowest slot."""
    return max(torch.min_hole, torch.min_hole_share * thickness)


def bevels_of(contour: Contour, torch: Torch) -> list[Bevel]:
    """The bevels that are meant; smaller ones are noise of whoever wrote the file."""
    return [bevel for bevel in contour.bevels if abs(bevel.angle) >= torch.min_bevel]


def is_drilled(feature: Feature, torch: Torch, thickness: float) -> bool:
    """Whether a hole or slot is left to the drill, its centre marked."""
    if torch.drilled == "refuse" or isinstance(feature, Contour):
        return False
    if not isinstance(feature, Hole | Slot):
        return False
    if feature.kind == "mark" or feature.face not in PLATE_FACES:
        return False
    return refusal(feature, torch, thickness) is not None


def takes_nothing(plane: EndPlane, part: Part, thickness: float) -> bool:
    """Whether all of a plate lies behind a plane, as where that states a square end once more."""
    outer = [curve for one in part.contours if one.kind == "outer" for curve in one.curves]
    x0, y0, x1, y1 = extent(outer) or (0.0, 0.0, part.length, part.profile.height)
    (px, py, pz), (a, b, c) = plane.point, plane.normal
    return all(
        a * (x - px) + b * (y - py) + c * (z - pz) <= BESIDE * hypot(a, b, c)
        for x, y, z in product((x0, x1), (y0, y1), (0.0, thickness))
    )


def refusal(feature: Feature, torch: Torch, thickness: float) -> Diagnostic | None:
    """Why a table cannot make a feature; None if it can."""
    match feature:
        case Contour():
            if feature.face not in PLATE_FACES:
                return bar_rules.NO_SPINDLE.at(
                    feature.source, kind="contour", found=feature.face,
                    expected=f"one of {', '.join(PLATE_FACES)}",
                )  # fmt: skip
            if bevels := bevels_of(feature, torch):
                return bar_rules.BEVEL.at(
                    feature.source, found=f"{bevels[0].angle:g}", face=feature.face
                )
            return None
        case Hole() | Slot() if feature.face not in PLATE_FACES:
            return bar_rules.NO_SPINDLE.at(
                feature.source,
                kind="slot" if isinstance(feature, Slot) else f"{feature.kind} hole",
                found=feature.face,
                expected=f"one of {', '.join(PLATE_FACES)}",
            )
        case Hole() if feature.kind == "mark":
            return _refuse_centre(feature, torch)
        case Hole():
            return _refuse_hole(feature, torch, thickness)
        case Slot():
            return _refuse_slot(feature, torch, thickness)
        case TextMark():
            return None
        case Bend() | EndPlane() | Camber():
            names = {Bend: "a bend", EndPlane: "an end plane", Camber: "a camber"}
            return bar_rules.OTHER.at(feature.source, found=names[type(feature)])


def _refuse_centre(hole: Hole, torch: Torch) -> Diagnostic | None:
    """Why a table cannot mark a centre: it has no cross for it, or it should be of some depth."""
    if not torch.cross and torch.drilled != "spot":
        expected = "none, or the size of a cross in the machine file (torch.cross)"
    elif hole.depth is not None:
        expected = f"one without a depth, it is marked by a cross of {torch.cross:g}"
    else:
        return None
    return bar_rules.NO_TOOL.at(
        hole.source, kind="mark", found=f"{hole.diameter:g}", face=hole.face, expected=expected
    )


def _refuse_hole(hole: Hole, torch: Torch, thickness: float) -> Diagnostic | None:
    if hole.kind != "through" or hole.depth is not None:
        expected = "one through the sheet, a torch makes nothing else"
    elif hole.diameter < (least := min_hole(torch, thickness)):
        expected = f"at least {least:g} in a sheet of {thickness:g} mm"
    else:
        return None
    kind = "blind" if hole.kind == "through" and hole.depth is not None else hole.kind
    return bar_rules.NO_TOOL.at(
        hole.source, kind=kind, found=f"{hole.diameter:g}", face=hole.face, expected=expected
    )


def _refuse_slot(slot: Slot, torch: Torch, thickness: float) -> Diagnostic | None:
    if slot.kind != "through" or slot.depth is not None:
        expected = "one through the sheet, a torch makes nothing else"
    elif min(slot.length, slot.height) + slot.diameter < (least := min_hole(torch, thickness)):
        expected = f"one at least {least:g} wide in a sheet of {thickness:g} mm"
    else:
        return None
    size = f"{slot.length + slot.diameter:g} x {slot.height + slot.diameter:g}"
    return bar_rules.SLOT.at(slot.source, found=size, face=slot.face, expected=expected)
